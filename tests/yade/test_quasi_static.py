"""Damping, mass scaling and the quasi-static indicator."""

import math
import warnings

import __main__
import numpy as np
import pytest
from scenes import (
    DENSITY,
    RADIUS,
    add_disk,
    add_wall,
    assert_goes_on_after_loading,
    ready,
    run,
    soft_material,
)
from yade import FrictMat, O, PyRunner, utils

import softgrain as sg
from softgrain import time_loop


def squeezed_disk(steps=120, speed=2.0, **material):
    """A disk between two walls of which one moves; energies are tracked."""
    disk = add_disk(material=soft_material(**material))
    add_wall(-RADIUS, 1)
    wall = add_wall(RADIUS, 1, velocity=(0, -speed, 0))
    ready()
    O.trackEnergy = True
    run(steps)
    return disk, wall


def weigh(steps=4000, **material):
    """Mean force of a damped disk on the floor under growing gravity, over its weight."""
    add_disk(material=soft_material(massDamping=2000, **material))
    floor = add_wall(-RADIUS, 1)
    ready()
    newton = O.engines[-1]
    force = 0
    for k in range(steps):
        newton.gravity = (0, -200 * min(1, 3 * k / steps), 0)
        O.step()
        if k >= 0.8 * steps:
            force -= sg.wall_force(floor.id)[1] / (0.2 * steps)
    return force / (200 * DENSITY * math.pi * RADIUS**2)


# --- damping ------------------------------------------------------------------------------------


@pytest.mark.parametrize("damping", [{"massDamping": 3000.0}, {"stiffnessDamping": 2e-5}], ids=str)
def test_damping_is_booked(damping):
    """What vibrations lose is in the balance, in `energy` and in O.energy."""
    _, wall = squeezed_disk(steps=60, **damping)
    balance = sg.Balance()
    wall.state.vel = (0, 0, 0)
    start = sg.integrator().energy()
    run(1500)
    energy = sg.integrator().energy()
    lost = energy["damping"] - start["damping"]
    assert lost > 0.05 * start["elastic"]
    assert balance.error() < 2e-3
    assert O.energy["softDamping"] == energy["damping"]
    assert sg.quasi_static()["kinetic_over_elastic"] < 1e-3


def test_balance_of_roundings():
    """Before anything happens energies are some, too."""
    for k in range(4):
        add_disk((2.5 * k * RADIUS, 0, 0), (1 - 0.07 * k) * RADIUS)
    O.trackEnergy = True
    ready()
    run(1)
    balance = sg.Balance()
    for _ in range(5):
        run(20)
        assert balance.error() < 0.02


def test_without_damping_vibrations_stay():
    _, wall = squeezed_disk(steps=60)
    wall.state.vel = (0, 0, 0)
    run(1500)
    assert sg.integrator().energy()["damping"] == 0
    assert sg.quasi_static()["kinetic_over_elastic"] > 1e-2


def test_damping_may_change_while_running():
    """A change of the material is taken over at the next step, sums are kept."""
    disk, _ = squeezed_disk(steps=60)
    disk.material.stiffnessDamping = 2e-5
    run(10)
    lost = sg.integrator().energy()["damping"]
    assert lost > 0
    disk.material.stiffnessDamping = 0
    run(10)
    assert sg.integrator().energy()["damping"] == pytest.approx(lost, rel=0.1)


def test_stiffness_damping_shortens_the_step():
    """dt_c (sqrt(1 + xi^2) - xi), xi = beta/dt_c; the engine refuses what is longer."""
    disk = add_disk()
    plain = sg.critical_time_step()
    beta = 0.5 * plain
    disk.material.stiffnessDamping = beta
    expected = plain * (math.sqrt(1 + 0.25) - 0.5)
    assert sg.critical_time_step() == pytest.approx(expected, rel=1e-12)
    O.engines = sg.engines()
    O.dt = 0.9 * plain
    with pytest.raises(RuntimeError, match="O.dt = .* is outside the admissible range"):
        O.step()


def test_damping_needs_velocities_at_the_nodes():
    add_disk(material=soft_material(massDamping=10), velocityUpdate="flip")
    O.engines = sg.engines(verlet_distance=0.001)
    with pytest.raises(RuntimeError, match="grain #0: massDamping = 10.*velocityUpdate = 'nodal'"):
        O.step()


def test_saved_run_with_damping_and_scaling_goes_on(tmp_path):
    squeezed_disk(massDamping=500, stiffnessDamping=1e-6, massScaling=3)
    assert_goes_on_after_loading(tmp_path / "scene.yade.bz2", 50)
    assert sg.integrator().energy()["damping"] > 0
    assert O.bodies[0].material.massScaling == 3


@pytest.mark.parametrize(
    "alpha, rebound", ((0, 0.90), (1, 0.80), (2.35, 0.72), (5, 0.62), (20, 0.44))
)
def test_rebound_of_a_damped_disk(alpha, rebound):
    """Speed after over before an impact on a wall, alpha in c_s/R: what the guide says."""
    shear_wave = math.sqrt(1e6 / (2 * 1.3) / DENSITY)
    material = soft_material(young=1e6, poisson=0.3, massDamping=alpha * shear_wave / RADIUS)
    disk = add_disk((0, 1.01 * RADIUS, 0), RADIUS, material, zeta=0.2)
    add_wall(0, axis=1)
    disk.state.vel = (0, -1, 0)
    ready()
    while disk.state.pos[1] < 1.05 * RADIUS:
        run(5)
    assert disk.state.vel[1] == pytest.approx(rebound, abs=0.03)


# --- mass scaling -------------------------------------------------------------------------------


def test_scaled_mass_lengthens_the_step():
    add_disk()
    before, critical = ready(), sg.critical_time_step()
    assert sg.scale_mass(4) == pytest.approx(2 * critical, rel=1e-12)
    assert O.dt == pytest.approx(2 * before, rel=1e-12)
    sg.scale_mass(1)
    assert O.dt == pytest.approx(before, rel=1e-12)


def test_users_step_survives_scaling():
    add_disk()
    ready()
    O.dt = 1e-7
    sg.scale_mass(9)
    assert O.dt == 1e-7


def test_scaling_of_one_material():
    """The small disk dictates the step until only its own mass is scaled."""
    add_disk()
    add_disk((5 * RADIUS, 0, 0), 0.25 * RADIUS)
    small = O.bodies[1].material
    O.engines = sg.engines()
    before = sg.critical_time_step()
    assert sg.scale_mass(16, materials=[small]) == pytest.approx(4 * before, rel=1e-12)
    assert O.bodies[0].material.massScaling == 1


@pytest.mark.parametrize("scaling", [1, 10])
def test_weight_is_not_scaled(scaling):
    assert weigh(massScaling=scaling) == pytest.approx(1, rel=5e-3)


def test_scaling_changes_no_balance():
    """Of what lies at rest, as figures that are asked for before the next step have it, too."""
    weigh(massScaling=1)
    before = sg.quasi_static()
    sg.scale_mass(16)
    after = sg.quasi_static()
    assert after["unbalanced_force"] == pytest.approx(before["unbalanced_force"], abs=1e-9)
    assert after["elastic"] == pytest.approx(before["elastic"], rel=5e-3)
    assert before["elastic"] > 0


def test_scaled_grain_falls_more_slowly():
    disk = add_disk(material=soft_material(massScaling=4))
    ready(gravity=(0, -10, 0))
    O.trackEnergy = True
    run(100)
    assert disk.state.vel[1] == pytest.approx(-10 / 4 * O.time, rel=1e-9)
    assert disk.state.mass == pytest.approx(4 * DENSITY * math.pi * RADIUS**2, rel=1e-9)
    energy = sg.integrator().energy()
    assert energy["kinetic"] == pytest.approx(energy["loads"], rel=1e-9)


def test_scaling_in_motion_is_warned_of():
    disk = add_disk()
    disk.state.vel = (1, 0, 0)
    ready()
    run(1)
    with pytest.warns(UserWarning, match="not at rest"):
        sg.scale_mass(2)


def test_scaling_at_rest_is_silent():
    add_disk()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sg.scale_mass(2)


@pytest.mark.parametrize("factor", [0.5, math.inf, math.nan])
def test_scaling_out_of_range(factor):
    disk = add_disk()
    with pytest.raises(ValueError, match=r"factor = .*\[1, inf\)"):
        sg.scale_mass(factor)
    with pytest.raises(ValueError, match="materials: FrictMat is no SoftMat"):
        sg.scale_mass(2, materials=[disk.material, FrictMat()])
    assert disk.material.massScaling == 1


def test_scaling_that_fails_leaves_all_as_it_was(monkeypatch):
    disks = [
        add_disk((x, 0, 0), material=soft_material(massScaling=k)) for k, x in ((1, 0), (3, 1))
    ]

    def fail():
        raise RuntimeError("no time step")

    monkeypatch.setattr(time_loop, "critical_time_step", fail)
    with pytest.raises(RuntimeError, match="no time step"):
        sg.scale_mass(2)
    assert [disk.material.massScaling for disk in disks] == [1, 3]


def test_no_soft_grain():
    for ask in (sg.quasi_static, sg.suggest_speed, lambda: sg.scale_mass(2)):
        with pytest.raises(ValueError, match="no soft grain"):
            ask()


# --- indicator ----------------------------------------------------------------------------------


def test_indicator_of_a_free_grain():
    disk = add_disk()
    ready()
    run(1)
    nothing = sg.quasi_static()
    assert nothing["kinetic_over_elastic"] == nothing["unbalanced_force"] == 0
    disk.state.vel = (3, 4, 0)
    O.forces.setPermF(disk.id, (1, 0, 0))
    run(1)
    moving = sg.quasi_static()
    mass = DENSITY * math.pi * RADIUS**2
    assert moving["kinetic"] == pytest.approx(0.5 * mass * 25, rel=1e-3)
    assert moving["kinetic_over_elastic"] > 1e6
    assert moving["unbalanced_force"] == math.inf


def test_indicator_tells_loading_from_rest():
    """It falls by orders where the wall stops and damping works."""
    _, wall = squeezed_disk(steps=100, massDamping=3000)
    loading = sg.quasi_static()
    wall.state.vel = (0, 0, 0)
    run(3000)
    rest = sg.quasi_static()
    assert rest["kinetic_over_elastic"] < 1e-3 * loading["kinetic_over_elastic"]
    assert rest["unbalanced_force"] < 1e-2
    assert loading["unbalanced_force"] > 5 * rest["unbalanced_force"]
    energy = sg.integrator().energy()
    assert rest["elastic"] == pytest.approx(energy["elastic"], rel=1e-12)


def test_indicator_counts_weight():
    """A grain at rest on the floor is in balance; without its weight it would not be."""
    weigh(massScaling=5)
    assert sg.quasi_static()["unbalanced_force"] < 1e-2


def unbalanced():
    return sg.quasi_static()["unbalanced_force"], sg.unbalanced_force(), utils.unbalancedForce()


@pytest.mark.parametrize("steps", (1, 100))
def test_unbalanced_force_is_known_from_the_solve_on(steps):
    """Until the next ForceResetter; nan does not pass for rest."""
    squeezed_disk(steps=steps)
    seen = {}

    def look(place):
        return PyRunner(command=f"look('{place}')", iterPeriod=1)

    __main__.look = lambda place: seen.update({place: unbalanced()})
    resetter, *others = O.engines
    O.engines = [look("first"), resetter, *others, look("last")]
    sg.insert_before_solve(look("solve"))
    between = unbalanced()
    run(1)
    assert np.isnan(seen["solve"]).all()
    assert seen["first"] == between and min(between) > 0
    assert seen["last"] == unbalanced() and (steps == 1 or seen["last"] != between)


def test_unbalanced_force_after_what_forgets_forces(tmp_path):
    """Not before a step has made them anew; engines alone forget nothing."""
    squeezed_disk(steps=100)
    before = unbalanced()
    O.engines = sg.engines()
    assert unbalanced() == before
    O.save(str(tmp_path / "scene.yade.gz"))
    O.load(str(tmp_path / "scene.yade.gz"))
    assert np.isnan(unbalanced()).all()
    run(1)
    assert min(unbalanced()) > 0
    O.forces.reset()
    assert np.isnan(unbalanced()).all()
    O.reset()
    add_disk()
    ready()
    assert np.isnan(unbalanced()).all()


def test_unbalanced_force_of_a_scene_saved_after_its_first_step(tmp_path):
    """Nothing has been reset there, as in a step of number 0."""
    squeezed_disk(steps=1)
    assert not np.isnan(unbalanced()).any()
    O.save(str(tmp_path / "scene.yade.gz"))
    O.load(str(tmp_path / "scene.yade.gz"))
    assert np.isnan(unbalanced()).all()


def test_what_a_wall_is_held_by_is_no_imbalance():
    """A free wall, at rest under its stress, bears friction along itself."""
    disk = add_disk(material=soft_material(massDamping=2000, frictionAngle=0.5))
    walls = [add_wall(at * RADIUS, axis, friction=0.5) for axis in (0, 1) for at in (-1, 1)]
    O.forces.setPermF(disk.id, (0, -100, 0))
    ready(tolerance=1e-4, maxSweeps=1000)
    sg.insert_before_solve(
        sg.WallStressController(walls=[w.id for w in walls], goal=(-2e4, -2e4, 0))
    )
    run(8000)
    along = [abs(sg.wall_force(w.id)[1]) for w in walls[:2]]
    assert min(along) > 10
    assert sg.unbalanced_force(largest=True) < 1e-2
