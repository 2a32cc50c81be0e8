"""What grains sleep on: floors that go, move, are let go or move along themselves wake them."""

import math

import numpy as np
import pytest
from scenes import RADIUS, add_disk, add_wall, present_state, ready, run, soft_material
from sleep_scenes import (
    GRAVITY,
    asleep,
    box_below,
    facet_below,
    forces,
    heap,
    newton,
    on_all_floors,
    rest,
    rough,
)
from yade import O, Quaternion, Vector3, utils

import softgrain as sg


@on_all_floors
@pytest.mark.parametrize("awake", (False, True), ids=("", "awake"))
@pytest.mark.parametrize("going", ("erased", "moved"))
def test_a_floor_that_goes(floor, awake, going):
    """Grains at rest fall when it goes; those that it kept awake by moving a little, too: in a step
    in which it is looked who may sleep, before anything has moved."""
    disks = heap(floor=floor)
    if awake:
        O.bodies[3].state.vel = (0, 1e-12, 0)
    run(11000)
    assert sg.quasi_static()["kinetic_over_elastic"] < 1e-10
    assert asleep() == [not awake] * 3
    heights = [disk.state.pos[1] for disk in disks]
    if going == "erased":
        O.bodies.erase(3)
    else:
        O.bodies[3].state.vel = (0, 0, 0)
        O.bodies[3].state.pos -= Vector3(0, 5 * RADIUS, 0)
    run(200)
    assert all(disk.state.pos[1] < y - 0.1 * RADIUS for disk, y in zip(disks, heights))


def turn_the_floor():
    O.bodies[3].state.ori = Quaternion((0, 0, 1), 1e-6)


def let_the_floor_go():
    O.bodies[3].state.mass, O.bodies[3].state.inertia = 1, Vector3(1, 1, 1)
    O.bodies[3].state.blockedDOFs = "zXY"


@pytest.mark.parametrize("change", (turn_the_floor, let_the_floor_go))
def test_woken_by_a_floor(change):
    heap(floor=box_below)
    rest()
    change()
    run(1)
    assert asleep() == [False, False, True]  # who lies on it


def test_forces_on_a_floor_while_asleep():
    """The same whatever the step: impulses of old are forces over the kick they had."""
    heap(floor=box_below)
    rest()
    before = forces()
    weight = GRAVITY * sum(b.state.mass for b in sg.soft_bodies())
    assert 0.5 * weight < -before[3, 1] < weight  # walls bear the rest by friction
    assert before[3, 5] != 0
    for step in (0.5, 0.3):
        O.dt *= step
        run(3)
        assert all(asleep())
        np.testing.assert_allclose(forces(), before, rtol=1e-12)


def test_free_rigid_bodies_keep_grains_awake():
    """They are carried by contact dynamics, and their own rest is not watched."""
    O.reset()
    material = soft_material(massDamping=4000.0, frictionAngle=math.atan(0.3))
    add_disk((0, 0, 0), material=material)
    sphere = utils.sphere((0, 1.99 * RADIUS, 0), RADIUS, material=rough())
    O.bodies.append(sphere)
    sphere.state.blockedDOFs = "xzXYZ"
    add_wall(-RADIUS, 1, friction=0.3)
    ready(gravity=(0, -GRAVITY, 0))
    newton().damping = 0
    run(6000)
    assert abs(sphere.state.vel[1]) < 1e-9
    assert asleep() == [False]


def test_walls_that_move_keep_grains_awake():
    heap()
    O.bodies[5].state.vel = (1e-7, 0, 0)
    run(10000)
    assert not any(asleep())
    O.bodies[5].state.vel = (0, 0, 0)
    rest()


def clump_below():
    """Held spheres in a row, as large as the disks; the clump comes after its members."""
    places = ((2 * k - 1) * RADIUS for k in range(3))
    row = [utils.sphere((x, -2 * RADIUS, 0), RADIUS, material=rough()) for x in places]
    O.bodies.appendClumped(row)
    the_clump().state.blockedDOFs = "xyzXYZ"


def the_clump():
    return next(body for body in O.bodies if body.isClump)


def shift_the_clump():
    the_clump().state.pos += Vector3(0, -1e-6 * RADIUS, 0)


def let_the_clump_go():
    the_clump().state.blockedDOFs = "zXY"


def test_same_results_without_on_a_clump():
    """As on other floors, but on spheres disks come to rest more slowly: after 12 000 steps nodes
    differ by less than 1e-4 R."""
    states = []
    for sleep in (False, True):
        heap(sleep=sleep, floor=clump_below)
        run(12000)
        assert all(asleep()) == sleep
        states.append((present_state()["nodes"], forces()))
    (nodes, pushed), (nodes_asleep, pushed_asleep) = states
    np.testing.assert_allclose(nodes_asleep, nodes, atol=1e-4 * RADIUS)
    weight = sum(body.state.mass for body in sg.soft_bodies()) * GRAVITY
    np.testing.assert_allclose(pushed_asleep, pushed, atol=1e-4 * weight)


@pytest.mark.parametrize("change", (shift_the_clump, let_the_clump_go))
def test_woken_by_a_clump(change):
    heap(floor=clump_below)
    rest()
    change()
    run(2)  # YADE moves the members of a clump behind the clump, at the end of a step
    feel_more = change is let_the_clump_go  # than those who lie on it
    assert asleep() == [False, False, not feel_more]


def test_a_floor_that_moves_along_itself_keeps_grains_awake():
    """A conveyor, set back in each step, without friction: only its velocity tells that it moves.
    When it stops the disk falls asleep, within fewer steps than it was watched."""
    watched = 300
    add_disk((0, 0, 0), material=soft_material(massDamping=4000.0))
    facet_below()
    belt = O.bodies[1]
    start = belt.state.pos
    ready(gravity=(0, -GRAVITY, 0))
    rest()
    belt.state.vel = (0.05, 0, 0)
    for _ in range(watched):
        run(1)
        belt.state.pos = start
        assert asleep() == [False]
    belt.state.vel = (0, 0, 0)
    began = O.iter
    rest()
    assert O.iter - began < watched


def test_woken_by_a_wall_of_which_another_side_acts():
    disks = heap()
    rest()
    heights = [disk.state.pos[1] for disk in disks]
    O.bodies[3].shape.sense = -1
    run(1)
    assert asleep() == [False, False, True]
    run(60)
    assert all(disk.state.pos[1] < y - 0.02 * RADIUS for disk, y in zip(disks, heights))


def let_go():
    (interaction,) = O.interactions
    interaction.phys.interface.cohesion = 0


def take_the_law_away():
    (interaction,) = O.interactions
    interaction.phys.interface = None


@pytest.mark.parametrize("change", (let_go, take_the_law_away), ids=lambda change: change.__name__)
@pytest.mark.parametrize("meanwhile", ("nothing", "loaded", "appended"))
def test_woken_by_an_interface_that_changes(change, meanwhile, tmp_path):
    """A disk that hangs from a wall by cohesion."""
    O.reset()
    disk = add_disk(material=soft_material(massDamping=4000.0))
    add_wall(RADIUS, 1)
    glue = {"cohesion": 4e5, "cohesionRange": 0.03 * RADIUS}
    ready(gravity=(0, -GRAVITY, 0), interface=glue)
    rest()
    if meanwhile == "loaded":
        O.save(str(tmp_path / "asleep.yade.bz2"))
        O.load(str(tmp_path / "asleep.yade.bz2"))
        disk = O.bodies[0]
        run(1)
        assert asleep() == [True]
        O.load(str(tmp_path / "asleep.yade.bz2"))
        disk = O.bodies[0]
    elif meanwhile == "appended":
        add_disk((30 * RADIUS, 0, 0))
    change()
    start, height = O.time, disk.state.pos[1]
    run(300)
    fall = GRAVITY * (O.time - start) ** 2 / 2
    assert height - disk.state.pos[1] == pytest.approx(fall, rel=0.1)


def disks_squeezed_hard(count, steps, **engines):
    """Over each other, between walls without friction across x, let lie for so many steps."""
    O.reset()
    small = 0.1 * RADIUS
    material = soft_material(young=1e9, massDamping=1e6)
    apart = 2.016 * small  # squeezed they are longer: they push each other until they touch
    disks = [add_disk((0, k * apart, 0), radius=small, material=material) for k in range(count)]
    walls = add_wall(-small, 0), add_wall(small, 0)
    ready(**engines)
    walls[1].state.vel = (-10, 0, 0)
    while walls[1].state.pos[0] > 0.96 * small:
        run(1)
    walls[1].state.vel = (0, 0, 0)
    run(steps)
    return disks


def assert_falls(disk, gravity, steps):
    start, height = O.time, disk.state.pos[1]
    run(steps)
    fall = gravity * (O.time - start) ** 2 / 2
    assert height - disk.state.pos[1] == pytest.approx(fall, rel=0.01)


@pytest.mark.parametrize("sleep", (True, False))
def test_squeezed_grains_that_slide_do_not_sleep(sleep):
    """A weight that is small beside what squeezes them, and that nothing bears."""
    (disk,) = disks_squeezed_hard(1, 10000, gravity=(0, 0, 0), sleep=sleep)
    assert asleep() == [sleep]
    newton().gravity = (0, -9.81, 0)
    assert_falls(disk, 9.81, 2000)


@pytest.mark.parametrize("share", (9e-3, 9e-4))
def test_squeezed_grains_do_not_sleep_under_a_small_share_of_their_weight(share):
    """Walls without friction bear the rest; the forces of grains squeezed so hard tremble by
    more in a step."""
    (disk,) = disks_squeezed_hard(1, 20000, gravity=(-9.81, 0, 0))
    assert asleep() == [True]
    newton().gravity = (-9.81, -9.81 * share, 0)
    assert_falls(disk, 9.81 * share, 20000)


def test_a_sleeper_without_load_does_not_carry_that_of_another():
    """Upon one that nothing but the walls holds lies one that gets a weight: both slide."""
    low, high = disks_squeezed_hard(2, 10000, gravity=(0, 0, 0))
    assert asleep() == [True, True]
    assert O.interactions[low.id, high.id].isReal
    O.forces.setPermF(high.id, (0, -9.81 * high.state.mass, 0))
    run(1)
    assert asleep() == [False, False]
    heights = low.state.pos[1], high.state.pos[1]
    run(20000)
    O.forces.setPermF(high.id, (0, 0, 0))
    for body, height in zip((low, high), heights):
        assert height - body.state.pos[1] > 5e-3 * low.shape.radius
