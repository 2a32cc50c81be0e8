"""O.dt: set by the package, kept by the integrator, or the user's."""

import math
import re

import numpy as np
import pytest
from partner_scenes import add_rigid_disk
from scenes import (
    RADIUS,
    YOUNG,
    ZETA,
    add_disk,
    add_wall,
    ready,
    run,
    soft_material,
)
from yade import FrictMat, O, utils

import softgrain as sg


def test_set_time_step():
    add_disk()
    O.engines = sg.engines()
    critical = sg.critical_time_step()
    assert sg.set_time_step(0.3) == O.dt == pytest.approx(0.3 * critical, rel=1e-14)
    assert sg.integrator().timeStepFraction == 0.3
    assert sg.set_time_step() == pytest.approx(0.3 * critical, rel=1e-14)


def test_fraction_stays_where_none_is_given():
    """The engines', what was last set without them, or 0.85."""
    for k in range(4):
        O.bodies.append(utils.sphere((3 * RADIUS * k, 0, 0), RADIUS, fixed=False))
        O.bodies[k].state.blockedDOFs = "zXY"
    sg.soften([0])
    assert pytest.approx(0.85 * sg.critical_time_step(), rel=1e-14) == O.dt
    sg.set_time_step(0.4)
    sg.soften([1])
    assert pytest.approx(0.4 * sg.critical_time_step(), rel=1e-14) == O.dt
    O.engines = sg.engines(timeStepFraction=0.5)
    sg.soften([2])
    sg.soften([3], when="loaded")
    assert sg.integrator().timeStepFraction == 0.5
    assert pytest.approx(0.5 * sg.critical_time_step(), rel=1e-14) == O.dt


def test_scaling_of_the_critical_step():
    """With size, wave speed and resolution; the smallest of all grains counts."""
    add_disk()
    one = sg.critical_time_step()
    add_disk((5 * RADIUS, 0, 0), 0.5 * RADIUS)
    assert sg.critical_time_step() == pytest.approx(0.5 * one, rel=1e-12)
    add_disk((10 * RADIUS, 0, 0), material=soft_material(young=16e6))
    assert sg.critical_time_step() == pytest.approx(0.25 * one, rel=1e-12)
    O.reset()
    add_disk(zeta=0.125)
    assert sg.critical_time_step() == pytest.approx(0.5 * one, rel=0.15)


def test_undeformed_grain_keeps_the_step():
    """Rounding is no deformation."""
    disk = add_disk()
    disk.state.vel = (1, 0, 0)
    dt = ready()
    run(100)
    assert O.dt == dt


def test_first_step_takes_the_step_of_the_grains():
    """YADE's initial O.dt is nobody's choice."""
    add_disk()
    O.engines = sg.engines()
    run(1)
    assert O.dt == pytest.approx(0.85 * sg.critical_time_step(), rel=0.11)


def squeeze(steps=60):
    add_disk()
    add_wall(-RADIUS, 1)
    add_wall(RADIUS, 1, velocity=(0, -2, 0))
    dt = ready()
    run(steps)
    return dt


def test_follows_the_deformation():
    """At or up to 30 % below the fraction of the critical step, which falls; changed seldom."""
    dt = squeeze(0)
    seen = [O.dt]
    for _ in range(120):
        run(1)
        engine = sg.integrator()
        assert (
            0.7 * 0.5 * engine.criticalDt * (1 - 1e-9)
            <= O.dt
            <= 0.5 * engine.criticalDt * (1 + 1e-8)
        )
        if O.dt != seen[-1]:
            seen.append(O.dt)
    assert seen[-1] < 0.8 * dt
    assert len(seen) < 25


def test_raised_once_it_has_been_too_short_for_long():
    """Not with each swing of the vibration that a wall leaves when it is taken away."""
    add_disk(material=soft_material(massDamping=2000))
    add_wall(-RADIUS, 1)
    wall = add_wall(RADIUS, 1, velocity=(0, -2, 0))
    dt = ready()
    run(220)
    O.bodies.erase(wall.id)
    lowest = O.dt
    assert lowest < 0.6 * dt
    run(1000)
    assert O.dt == lowest
    run(600)
    assert O.dt > 0.85 * dt


def test_users_step_is_left_alone():
    squeeze(10)
    O.dt = 0.3 * sg.critical_time_step()
    chosen = O.dt
    run(30)
    assert O.dt == chosen


def test_users_step_before_the_first():
    add_disk()
    O.engines = sg.engines()
    O.dt = chosen = 0.21 * sg.critical_time_step()
    run(30)
    assert O.dt == chosen


@pytest.mark.parametrize("asked", (True, False))
@pytest.mark.parametrize(
    "rigid, young, warnings", [("linear", 1e9, 1), ("linear", 1e5, 0), ("nonsmooth", 1e9, 0)]
)
def test_warning_of_stiff_spheres(rigid, young, warnings, asked, capfd):
    """Logged once, where O.dt is set for the soft grains, by the user's call or not."""
    add_disk()
    for x in (3, 5):
        material = FrictMat(young=young, density=1000)
        O.bodies.append(utils.sphere((x * RADIUS, 0, 0), RADIUS, material=material))
    O.engines = sg.engines(rigid=rigid)
    if asked:
        sg.set_time_step()
    run(3)
    assert capfd.readouterr().err.count("the stiffest rigid sphere asks") == warnings


def test_warning_of_stiff_spheres_once_they_are(capfd):
    """The step becomes too long for them when the first grain turns soft."""
    young, soft = FrictMat(young=1e9, density=1000), soft_material()
    for x in (3, 5, 9):
        sphere = utils.sphere((x * RADIUS, 0, 0), RADIUS, material=young)
        sphere.state.blockedDOFs = "zXY"
        O.bodies.append(sphere)
    stiff = add_disk(material=soft_material(young=1e9))
    O.engines = sg.engines()
    run(3)
    assert "the stiffest rigid sphere asks" not in capfd.readouterr().err
    sg.soften([2], material=soft, zeta=ZETA)
    O.bodies.erase(stiff.id)
    run(1200)
    assert capfd.readouterr().err.count("the stiffest rigid sphere asks") == 1


@pytest.mark.parametrize("come_later", (True, False))
def test_warning_of_spheres_that_are_stiff_later(come_later, capfd):
    """Whether they are added then, or their material is changed."""
    material = FrictMat(young=1e9 if come_later else 1e5, density=1000)

    def add_spheres():
        for x in (3, 5):
            O.bodies.append(utils.sphere((x * RADIUS, 0, 0), RADIUS, material=material))

    add_disk()
    if not come_later:
        add_spheres()
    O.engines = sg.engines()
    run(3)
    assert "the stiffest rigid sphere asks" not in capfd.readouterr().err
    if come_later:
        add_spheres()
    material.young = 1e9
    run(1 if come_later else 100)
    assert capfd.readouterr().err.count("the stiffest rigid sphere asks") == 1


def test_no_warning_of_stiff_spheres_where_the_step_is_chosen_for_them(capfd):
    add_disk()
    for x in (3, 5):
        material = FrictMat(young=1e9, density=1000)
        O.bodies.append(utils.sphere((x * RADIUS, 0, 0), RADIUS, material=material))
    O.engines = sg.engines()
    O.dt = 0.5 * utils.PWaveTimeStep()
    run(3)
    assert "the stiffest rigid sphere asks" not in capfd.readouterr().err


def test_step_is_forgotten_with_its_scene():
    """The same number, assigned by hand in a later scene, is the user's."""
    add_disk()
    dt = sg.set_time_step(0.5)
    O.reset()
    add_disk()
    O.dt = dt
    O.engines = sg.engines()
    run(3)
    assert O.dt == dt
    assert sg.integrator().dtSet != dt


def test_back_to_automatic():
    squeeze(10)
    O.dt = 1e-7
    run(2)
    assert O.dt == 1e-7
    sg.set_time_step(0.4)
    run(2)
    assert O.dt == pytest.approx(0.4 * sg.integrator().criticalDt, rel=0.3)
    assert O.dt > 1e-6


def test_the_critical_step_itself_is_admissible():
    """Rounding does not refuse it; a thousandth more is too much, in numbers that differ."""
    add_disk()
    ready()
    O.dt = sg.critical_time_step()
    run(3)
    assert sg.integrator().steps == 3
    O.dt = 1.001 * sg.critical_time_step()
    with pytest.raises(RuntimeError, match=r"O.dt = .* is outside the admissible range") as error:
        run(1)
    given, limit = re.search(r"O\.dt = (\S+) s .* \(0, (\S+)\]", str(error.value)).groups()
    assert float(given) == pytest.approx(1.001 * float(limit), rel=1e-6)


def test_advance():
    """Steps one after the other; what stops one is raised, and none is taken after it."""
    disk = add_disk()
    disk.state.vel = (1, 0, 0)
    ready()
    sg.advance(0)
    assert O.iter == 0
    sg.advance(7)
    assert O.iter == 7
    assert disk.state.pos[0] == pytest.approx(O.time, rel=1e-12)
    with pytest.raises(ValueError, match=r"steps = -1 is outside .*\[0, inf\)"):
        sg.advance(-1)
    O.engines[-1].gravity = (float("nan"), 0, 0)
    with pytest.raises(RuntimeError, match="not finite"):
        sg.advance(5)
    assert O.iter < 9


@pytest.mark.parametrize("changed", [0, 1])
def test_follows_each_of_two_materials_in_turn(changed):
    """Grains of two materials one after the other; the stiffer one limits the step."""
    materials = [soft_material(), soft_material()]
    for k in range(6):
        add_disk((3 * k * RADIUS, 0, 0), RADIUS, materials[k % 2])
    ready()
    O.step()
    before = sg.critical_time_step()
    materials[changed].young *= 4
    assert sg.critical_time_step() == pytest.approx(before / 2, rel=1e-9)
    materials[changed].young /= 4
    assert sg.critical_time_step() == pytest.approx(before, rel=1e-9)


@pytest.mark.parametrize("speed, share", ((0.005, 0.99), (2, 0.9)))
def test_how_near_the_critical_step(speed, share):
    """The slower the critical step falls, the nearer: where grains would be measured all the time,
    there is more room."""
    add_disk()
    add_wall(-RADIUS, 1)
    add_wall(RADIUS, 1, velocity=(0, -speed, 0))
    ready()
    engine = sg.integrator()
    jumps = []
    while O.time < 0.25 * RADIUS / speed:
        dt = O.dt
        run(1)
        if O.dt < dt:
            jumps.append(O.dt / (0.5 * engine.criticalDt))
    assert jumps[-1] == pytest.approx(share, rel=1e-9)
    measured = engine.pointsMeasured / engine.pointsUpdated
    assert (measured <= 0.05) == (share == 0.99)


def total_energy():
    """What stays constant, before the last step [J/m]."""
    energy = sg.integrator().energy()
    lost = energy["friction"] + energy["impact"]
    return energy["kinetic"] + energy["elastic"] + lost - energy["walls"] - energy["loads"]


def test_vibrations_are_not_fed():
    """Three grains part after a hard impact and swing so wide that the critical step of one changes
    by more than a third in each period: O.dt, raised and lowered with it, would double the energy.
    """
    O.trackEnergy = True
    weak = soft_material(young=0.1 * YOUNG, poisson=0.4, frictionAngle=0.5)
    stiff = soft_material(poisson=0.4, frictionAngle=0.5)
    for place, velocity, material in (
        ((0, 0, 0), (4, 0, 0), stiff),
        ((2.1 * RADIUS, 0.3 * RADIUS, 0), (-3, 1, 0), weak),
        ((RADIUS, 2 * RADIUS, 0), (0, -5, 0), stiff),
    ):
        state = add_disk(place, material=material, zeta=0.2).state
        state.vel, state.angVel = velocity, (0, 0, 60)
    O.engines = sg.engines()
    sg.set_time_step(0.9)
    run(3)
    before, steps = total_energy(), []
    for _ in range(4000):
        run(1)
        steps.append(O.dt)
    assert sg.integrator().activeContacts == 0
    assert min(steps) < 0.6 * max(steps)
    assert np.count_nonzero(np.diff(steps) > 0) <= 4000 / 1000
    assert total_energy() == pytest.approx(before, rel=0.02)


@pytest.mark.parametrize(
    "before, after",
    (
        ({}, {"poisson": 0.499}),
        ({}, {"young": 100 * YOUNG}),
        ({"massScaling": 100}, {"massScaling": 1}),
    ),
    ids=("poisson", "young", "massScaling"),
)
def test_materials_made_stiffer_put_in_no_more_than_their_law(before, after):
    """In the middle of an impact: half of the last step, many times the critical one by now, must
    not count in the kick of the new forces."""
    O.trackEnergy = True
    material = soft_material(poisson=0.3, **before)
    disk = add_disk((0, RADIUS, 0), material=material, zeta=0.2)
    add_wall(0, axis=1, sense=1)
    disk.state.vel = (0, -1, 0)
    O.engines = sg.engines()
    sg.set_time_step()
    while O.time < 6.6e-4 * math.sqrt(before.get("massScaling", 1)):
        run(1)
    for name, value in after.items():
        setattr(material, name, value)
    run(1)  # with the energy of the new law, before its first kick
    start, largest = total_energy(), 0
    for _ in range(60):
        run(1)
        largest = max(largest, total_energy())
    assert start < largest < 1.1 * start


def test_short_waves_do_not_resonate_with_the_step():
    """Two disks that touched once, gently. (At 0.9 of the critical step, beyond 0.866, a wave of
    three steps a period is fed: their energy grows several times over.)"""
    O.trackEnergy = True
    material = soft_material(poisson=0.3)
    for x, y, speed in ((0, 0, 0.1), (2.05 * RADIUS, 0.3 * RADIUS, -0.1)):
        add_disk((x, y, 0), material=material).state.vel = (speed, 0, 0)
    O.engines = sg.engines()
    run(400)
    assert sg.integrator().activeContacts == 0
    before = total_energy()
    run(20000)
    assert total_energy() == pytest.approx(before, rel=1e-3)


@pytest.mark.parametrize("partner", ("grain", "rigid body"))
def test_light_partners_of_bonds_shorten_the_step(partner):
    """As much as light grains do that come first, and as they are light."""
    found = {}
    for radius, place in ((0.2, "second"), (0.2, "first"), (1.0, "second")):
        O.reset()
        kinds = ["big", "other"] if place == "second" else ["other", "big"]
        for kind in kinds:
            if kind == "big":
                add_disk((0, 0, 0), material=soft_material())
            elif partner == "grain":
                at = ((1 + radius) * RADIUS, 0, 0)
                add_disk(at, radius * RADIUS, soft_material(density=10, young=1e4))
            else:
                add_rigid_disk(((1 + radius) * RADIUS, 0, 0), radius * RADIUS, density=10)
        ready(interface=dict(bondStrength=1e6, bondEnergy=1.0, bondStiffness=1e13))
        run(10)
        assert [i for i in O.interactions if i.isReal and i.phys.contacts]
        found[radius, place] = sg.integrator().criticalDt
    assert found[0.2, "second"] == pytest.approx(found[0.2, "first"], rel=1e-6)
    assert found[0.2, "second"] < 0.6 * found[1.0, "second"]
