"""Grains with a long critical step beside grains with a short one."""

import numpy as np
import pytest
from motion import momentum
from scenes import (
    RADIUS,
    add_disk,
    add_wall,
    assert_goes_on_after_loading,
    assert_same_bits,
    points_of,
    present_state,
    ready,
    run,
    soft_material,
)
from yade import O

import softgrain as sg

RATIO = 10


def pressed(ratio=RATIO, speed=0.5, stiffness=1, **engine):
    """A disk between a wall and two small disks, so many times as stiff, on another wall, pressed;
    returns both walls."""
    O.reset()
    small = RADIUS / ratio
    add_disk((0, RADIUS + 1.9 * small, 0))
    stiff = soft_material(young=1e6 * stiffness)
    for side in (-1, 1):
        add_disk((side * 1.2 * small, small, 0), small, stiff)
    walls = add_wall(0, 1, friction=0.5), add_wall(2 * RADIUS + 1.9 * small, 1, friction=0.5)
    walls[1].state.vel = (0, -speed, 0)
    ready(rigidMotion=False, **{"multirate": True, **engine})
    O.trackEnergy = True
    return walls


def test_rates_follow_size_and_stiffness():
    add_disk()
    add_disk((5 * RADIUS, 0, 0), 0.3 * RADIUS)
    add_disk((10 * RADIUS, 0, 0), material=soft_material(young=1e8))
    ready(multirate=True)
    assert sg.integrator().rates() == {}
    run(1)
    assert sg.integrator().rates() == {1: 1, 3: 1, 9: 1}
    sg.integrator().multirate = False
    run(1)
    assert sg.integrator().rates() == {1: 3}


def test_dt_is_that_of_the_most_demanding_grain():
    pressed()
    big, *small = sg.soft_bodies()
    run(3)
    critical = sg.integrator().criticalDt
    assert critical == pytest.approx(sg.critical_time_step(), rel=0.05)
    assert 0.7 * 0.5 * critical <= O.dt <= 0.5 * critical * (1 + 1e-6)
    for body in small:
        O.bodies.erase(body.id)
    assert sg.critical_time_step() > 0.99 * RATIO * critical
    pressed()
    run(3)
    O.dt = 1.01 * sg.critical_time_step()
    with pytest.raises(RuntimeError, match="O.dt = .* is outside the admissible range"):
        run(1)


def test_points_that_are_updated():
    """A slow grain counts once in as many steps as its rate."""
    pressed()
    big, *small = sg.soft_bodies()
    engine = sg.integrator()
    run(2 * RATIO)
    before = engine.pointsUpdated
    run(6 * RATIO)
    expected = 6 * points_of(big) + 6 * RATIO * sum(points_of(b) for b in small)
    assert engine.pointsUpdated - before == expected


def test_many_big_and_few_small_grains():
    """Size ratio 10: at least five times fewer point updates where one grain in ten is small."""
    for k in range(20):
        add_disk((3 * RADIUS * k, 0, 0))
    for k in range(2):
        add_disk((3 * RADIUS * k, 3 * RADIUS, 0), RADIUS / 10)
    updates = []
    for multirate in (True, False):
        ready(rigidMotion=False, multirate=multirate)
        run(2 * RATIO)
        updates.append(sg.integrator().pointsUpdated)
        run(10 * RATIO)
        updates[-1] = sg.integrator().pointsUpdated - updates[-1]
    assert updates[1] >= 5 * updates[0]


def test_force_and_energy_are_those_of_short_steps():
    forces, tremors = [], []
    for multirate in (True, False):
        bottom, top = pressed(multirate=multirate)
        seen = []
        balance = None
        while O.time < 3e-3:
            run(1)
            balance = balance or sg.Balance()
            if O.time > 1e-3:
                seen.append([abs(sg.wall_force(wall.id)[1]) for wall in (bottom, top)])
        assert abs(balance.error()) < 3e-3
        seen = np.array(seen)
        forces.append(seen.mean(axis=0))
        tremors.append(np.abs(np.diff(seen, axis=0)).mean(axis=0) / seen.mean(axis=0))
    np.testing.assert_allclose(forces[0], forces[1], rtol=0.01)
    assert (tremors[0] < 2 * tremors[1] + 1e-3).all()


def test_equal_grains_are_not_touched():
    """Critical steps that differ by less than a factor of two: the same bits with and without."""
    states = []
    for multirate in (True, False):
        pressed(ratio=1.9, multirate=multirate)
        run(150)
        states.append(present_state())
    assert_same_bits(*states)


@pytest.mark.parametrize(
    "method", [{"velocityUpdate": "flip"}, {"formulation": "updated"}], ids=str
)
def test_velocities_at_points_need_every_step(method):
    add_disk(**method)
    add_disk((5 * RADIUS, 0, 0), RADIUS / RATIO, **method)
    ready(multirate=True)
    run(3)
    assert sg.integrator().rates() == {1: 2}


def test_grain_that_touches_stiffer_ones():
    """It is computed as often as these, from its next computation on."""
    pressed(stiffness=4)
    engine = sg.integrator()
    run(2)
    rate = max(engine.rates())
    assert rate == 2 * RATIO
    run(rate)
    before = engine.pointsUpdated
    run(3 * rate)
    assert engine.pointsUpdated - before == 3 * rate * sum(map(points_of, sg.soft_bodies()))


def test_stiff_grains_in_a_packing_of_soft_ones():
    """Forces that are held while a stiff neighbour shakes the nodes would feed it."""
    R = RADIUS
    side = 6.02 * R
    damped = dict(massDamping=100, poisson=0.3, frictionAngle=0.3)
    for i in range(3):
        for j in range(3):
            place = (R * (1 + 2.01 * i), R * (1 + 2.01 * j), 0)
            add_disk(place, material=soft_material(**damped))
    for i in range(2):
        for j in range(2):
            place = (R * (2.005 + 2.01 * i), R * (2.005 + 2.01 * j), 0)
            add_disk(place, 0.35 * R, soft_material(young=1e7, **damped))
    walls = [add_wall(x, axis, friction=0.3) for axis in (0, 1) for x in (0, side)]
    walls[1].state.vel, walls[3].state.vel = (-1, 0, 0), (0, -1, 0)
    ready(multirate=True)
    sg.set_time_step(0.85)
    O.trackEnergy = True
    run(2)
    assert sg.integrator().rates() == {1: 4, 9: 9}
    balance = sg.Balance()
    while walls[3].state.pos[1] > 0.93 * side:
        run(1)
    for wall in walls:
        wall.state.vel = (0, 0, 0)
    run(2500)
    assert abs(balance.error()) < 3e-3


def test_second_shell_about_stiff_grains():
    """Soft grains that touch those which touch stiff ones step as these do, and are let go with
    them."""
    R = RADIUS
    damped = dict(poisson=0.3, massDamping=50)
    soft, stiff = soft_material(**damped), soft_material(young=1e7, **damped)
    for i in range(3):
        for j in range(3):
            add_disk((R * (1 + 2 * i), R * (1 + 2 * j), 0), material=soft if i else stiff)
    walls = [add_wall(x, axis) for axis in (0, 1) for x in (0, 6 * R)]
    walls[1].state.vel, walls[3].state.vel = (-1, 0, 0), (0, -1, 0)
    ready(multirate=True)
    sg.set_time_step(0.85)
    O.trackEnergy = True
    run(2)
    rate = max(sg.integrator().rates())
    assert sg.integrator().rates() == {1: 3, rate: 6}
    while walls[3].state.pos[1] > 6 * R * 0.94:
        run(1)
    balance = sg.Balance()
    for wall in walls:
        wall.state.vel = (0, 0, 0)
    run(3000)
    assert abs(balance.error()) < 1e-3
    bodies = sg.soft_bodies()
    for body in bodies[:3]:
        O.bodies.erase(body.id)
    add_disk((30 * R, 30 * R, 0), material=stiff)  # moves rigidly
    run(1000 * rate + 200)
    before = sg.integrator().pointsUpdated
    run(10 * rate)
    assert sg.integrator().pointsUpdated - before == 10 * 6 * points_of(bodies[5])


@pytest.mark.parametrize("stiffness", (10, 100))
def test_stiff_grain_hits_a_soft_one(stiffness):
    """It moves off as with single steps, though it may come in the midst of a long one."""
    velocities = []
    for multirate in (True, False):
        O.reset()
        big = add_disk()
        stiff = soft_material(young=1e6 * stiffness)
        small = add_disk((1.4 * RADIUS, 0.15 * RADIUS, 0), 0.35 * RADIUS, stiff)
        big.state.angVel = (0, 0, 20)
        small.state.vel = (-1, 0, 0)
        ready(multirate=multirate, rigidMotion=False)
        sg.set_time_step(0.85)
        O.trackEnergy = True
        while O.time < 0.015:
            run(1)
        assert abs(sg.integrator().energy()["impact"]) > 0
        velocities.append(list(small.state.vel))
    assert velocities[0] == pytest.approx(velocities[1], abs=0.01)


@pytest.mark.parametrize("suffix", ("yade.bz2", "xml.gz"))
@pytest.mark.parametrize("stiffness", (1, 4))
@pytest.mark.parametrize("damping", (0.0, 1e-6))
def test_save_and_load_between_two_computations(damping, stiffness, suffix, tmp_path):
    pressed(stiffness=stiffness)
    for body in sg.soft_bodies():
        body.material.stiffnessDamping = damping
    run(3 * RATIO + 4)
    assert_goes_on_after_loading(tmp_path / f"scene.{suffix}", 5 * RATIO)
    assert sg.integrator().rates() == {1: 2, max(sg.integrator().rates()): 1}


@pytest.mark.parametrize("change", [{"young": 2e6}, {"massDamping": 50}], ids=str)
@pytest.mark.parametrize("loaded", (False, True))
def test_material_may_change_between_two_computations(loaded, change, tmp_path):
    """Forces of the material before are not used any more, those that were saved neither."""
    pressed()
    run(3 * RATIO + 4)
    if loaded:
        O.save(str(tmp_path / "scene.yade.bz2"))
        O.load(str(tmp_path / "scene.yade.bz2"))
    body = sg.soft_bodies()[0]
    body.material.updateAttrs(change)
    before = sg.integrator().pointsUpdated
    run(1)
    assert sg.integrator().pointsUpdated - before == sum(map(points_of, sg.soft_bodies()))


def test_grains_come_and_go_between_two_computations():
    """Held forces of the others go on."""
    found = []
    for comes in (False, True):
        pressed()
        O.dt *= 0.9  # by hand
        grains, guest = sg.soft_bodies(), None
        for step in range(6 * RATIO):
            if comes and step % 7 == 3:
                if guest is None:
                    guest = add_disk((0, 50 * RADIUS, 0), RADIUS / RATIO).id
                else:
                    O.bodies.erase(guest)
                    guest = None
            run(1)
        found.append([b.shape.nodes() for b in grains])
    for usual, beside_guests in zip(*found):
        np.testing.assert_allclose(beside_guests, usual, rtol=0, atol=1e-12 * RADIUS)


def test_grain_that_waits_rigidly():
    """A slow grain goes over to rigid motion and back."""
    disk = add_disk()
    add_disk((1.2 * RADIUS, 0, 0), RADIUS / RATIO)
    disk.state.vel = (1, 0, 0)
    ready(multirate=True)
    O.trackEnergy = True
    run(50)
    assert sg.integrator().activeGrains == 0
    run(400)
    assert sg.integrator().energy()["impact"] != 0  # they have met
    assert momentum()[0] == pytest.approx(disk.state.mass, rel=1e-12)


def test_bonded_grains_are_computed_in_every_step():
    """Held forces would feed what a bond swings: two disks that hold fast to each other, beside a
    small one."""
    for x, speed in ((0, (0.3, 0, 0)), (2 * RADIUS, (-0.3, 0.2, 0))):
        add_disk((x, 0, 0)).state.vel = speed
    add_disk((0, 8 * RADIUS, 0), RADIUS / 8)
    stiff = {"bondStrength": 1e9, "bondEnergy": 1e9, "bondStiffness": 5e9}
    ready(multirate=True, interface=stiff)
    O.trackEnergy = True
    run(2)
    assert sg.integrator().rates() == {1: 1, 8: 2}
    run(10)  # the first bonds form in the midst of a long step
    balance = sg.Balance()
    run(4000)
    assert abs(balance.error()) < 1e-3


@pytest.mark.parametrize("met", (False, True))
def test_rates_that_change_after_loading(met, tmp_path):
    """Forces held for the step of before, and intervals of before, are forgotten."""
    soft = soft_material()
    disk = add_disk(material=soft)
    stiff = add_disk((1.72 * RADIUS, 0, 0), 0.7 * RADIUS, soft_material(young=4e6))
    tiny = add_disk((0, 5 * RADIUS, 0), RADIUS / 16, soft)
    stiff.state.vel = (-2, 0, 0) if met else (2, 0, 0)
    disk.state.angVel = (0, 0, 100)
    ready(multirate=True, rigidMotion=False)
    if not met:  # swings
        walls = add_wall(RADIUS, 1), add_wall(-RADIUS, 1)
        walls[0].state.vel = (0, -3, 0)
        while walls[0].state.pos[1] > 0.97 * RADIUS:
            run(1)
        for wall in walls:
            O.bodies.erase(wall.id)
    O.trackEnergy = True
    while O.time < 0.01 or O.iter % max(sg.integrator().rates()) != 1:
        run(1)
    before = sum(disk.shape.energy().values())
    path = str(tmp_path / "scene.yade.bz2")
    O.save(path)
    O.load(path)
    O.bodies.erase(tiny.id)
    O.dt = sg.integrator().dtSet
    run(300)
    assert max(sg.integrator().rates()) < 5
    assert sum(O.bodies[disk.id].shape.energy().values()) == pytest.approx(before, rel=0.2)


@pytest.mark.parametrize("damped", (False, True))
def test_damping_of_another_grain_changes_after_loading(damped, tmp_path):
    """What is held of a grain is its own."""
    materials = [soft_material(massDamping=0 if k else 100 * damped) for k in range(2)]
    for x, material in zip((0, 5 * RADIUS), materials):
        add_disk((x, 0, 0), material=material).state.angVel = (0, 0, 100)
    add_disk((0, 5 * RADIUS, 0), RADIUS / RATIO, materials[0])
    ready(multirate=True, rigidMotion=False)
    run(RATIO + 4)
    O.save(str(tmp_path / "scene.yade.bz2"))
    O.load(str(tmp_path / "scene.yade.bz2"))
    O.bodies[0].material.massDamping = 0 if damped else 100
    run(2 * RATIO)
    assert sg.integrator().rates() == {1: 1, RATIO - (not damped): 2}
