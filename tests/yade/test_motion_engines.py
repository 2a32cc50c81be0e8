"""Engines of YADE that move grains and walls."""

import math

import __main__
import numpy as np
import pytest
from scenes import RADIUS, add, add_disk, add_wall, damped_material, ready, run, soft_material
from yade import (
    ForceEngine,
    FrictMat,
    HarmonicMotionEngine,
    NewtonIntegrator,
    O,
    PyRunner,
    Quaternion,
    RotationEngine,
    TorqueEngine,
    TranslationEngine,
    utils,
)

import softgrain as sg


def free_grain():
    disk = add_disk()
    ready()
    O.dt = 0.4 * sg.critical_time_step()
    return disk


def with_engine(engine):
    """In front of the contacts, where kinematic engines stand."""
    engines = list(O.engines)
    O.engines = engines[:1] + [engine] + engines[1:]


def test_engines_before_the_solve():
    free_grain()
    names = [type(engine).__name__ for engine in O.engines]
    sg.insert_before_solve(ForceEngine(), TorqueEngine())
    place = names.index("SoftGrainIntegrator")
    expected = names[:place] + ["ForceEngine", "TorqueEngine"] + names[place:]
    assert [type(engine).__name__ for engine in O.engines] == expected
    O.engines = []
    with pytest.raises(ValueError, match="sg.engines"):
        sg.insert_before_solve(ForceEngine())


def test_force_and_torque_engine_on_a_grain():
    disk = free_grain()
    with_engine(ForceEngine(ids=[disk.id], force=(0.3, 0.1, 0)))
    with_engine(TorqueEngine(ids=[disk.id], moment=(0, 0, 1e-3)))
    run(200)
    mean = O.time - O.dt / 2  # velocities are half a step behind
    np.testing.assert_allclose(
        disk.state.vel, np.array((0.3, 0.1, 0)) / disk.state.mass * mean, rtol=0.01
    )
    assert disk.state.angVel[2] == pytest.approx(1e-3 / disk.state.inertia[2] * mean, rel=0.01)


def test_translation_engine_on_a_grain():
    """It has its velocity from the engine in every step, and is deformed by what is in its way."""
    disk = free_grain()
    add_wall(1.2 * RADIUS, axis=0)
    with_engine(TranslationEngine(ids=[disk.id], translationAxis=(1, 0, 0), velocity=0.5))
    while O.time < 0.38 * RADIUS:
        run(1)
    assert disk.state.pos[0] == pytest.approx(0.5 * O.time, rel=1e-6)
    while O.time < 0.6 * RADIUS:
        run(1)
    assert 0.26 * RADIUS < disk.state.pos[0] < 0.5 * O.time
    assert disk.shape.outline()[:, 0].max() < 1.205 * RADIUS
    assert disk.shape.energy()["elastic"] > 0


def test_rotation_engine_on_a_grain():
    disk = free_grain()
    with_engine(RotationEngine(ids=[disk.id], rotationAxis=(0, 0, 1), angularVelocity=20))
    run(300)
    angle = 2 * math.atan2(disk.state.ori[2], disk.state.ori[3])
    assert angle == pytest.approx(20 * O.time, rel=0.01)


def test_translation_engine_on_a_wall():
    """The grain between two of them follows."""
    disk = free_grain()
    low, high = add_wall(-RADIUS, axis=0), add_wall(RADIUS, axis=0)
    with_engine(TranslationEngine(ids=[low.id, high.id], translationAxis=(1, 0, 0), velocity=0.2))
    run(500)
    assert high.state.pos[0] == pytest.approx(RADIUS + 0.2 * O.time, rel=1e-9)
    assert disk.state.pos[0] == pytest.approx(0.2 * O.time, abs=0.05 * RADIUS)


def test_accelerated_walls():
    """Harmonic motion of a box of two walls, slow against the grain's vibrations."""
    disk = add_disk(material=damped_material())
    walls = [add_wall(side * RADIUS, axis=0) for side in (-1, 1)]
    ready()
    with_engine(
        HarmonicMotionEngine(
            ids=[w.id for w in walls], A=(0.1 * RADIUS, 0, 0), f=(50, 0, 0), fi=(0, 0, 0)
        )
    )
    worst = 0
    while O.time < 0.04:
        run(1)
        worst = max(worst, abs(disk.state.pos[0] - (walls[0].state.pos[0] + RADIUS)))
        if O.time > 0.02:
            moved = 0.1 * RADIUS * (math.cos(2 * math.pi * 50 * O.time) - 1)
            assert walls[0].state.pos[0] == pytest.approx(moved - RADIUS, abs=0.005 * RADIUS)
    assert worst < 0.02 * RADIUS


@pytest.mark.parametrize("kind", ("box", "facet", "by hand"))
def test_paddle_hits_a_grain_at_rest(kind):
    """It turns about its own place, by which YADE's collider tells what moves. (One that is turned
    by hand has no velocity: that it is met is all there is to see.)"""
    disk = add_disk((0, 4 * RADIUS, 0), material=damped_material())
    far = 6 * RADIUS
    if kind == "facet":
        paddle = utils.facet([(-far, 0, -far), (far, 0, -far), (0, 0, 2 * far)], fixed=True)
    else:
        paddle = utils.box((0, 0, 0), (far, 0.2 * RADIUS, RADIUS), fixed=True)
    O.bodies.append(paddle)
    ready()
    rate = 20.0
    if kind != "by hand":
        paddle.state.angVel = (0, 0, rate)
    while O.time < 0.95 * math.pi / 2 / rate:
        if kind == "by hand":
            paddle.state.ori = Quaternion((0, 0, 1), rate * O.time)
        run(1)
        if kind == "by hand" and sg.integrator().activeContacts > 0:
            return
    assert disk.state.pos[0] < -0.2 * RADIUS
    assert sg.integrator().largestOverlap < 0.5


def test_wall_under_another_newton_integrator():
    """YADE's collider keeps the one that it met first, which knows of no motion any more."""
    disk, wall = add_disk(), add_wall(-4 * RADIUS, axis=0, sense=1)
    ready()
    run(5)
    O.engines = [*O.engines[:-1], NewtonIntegrator(damping=0)]
    wall.state.vel = (5, 0, 0)
    while wall.state.pos[0] < -0.9 * RADIUS:
        run(1)
    assert disk.state.vel[0] > 0


def test_functors_of_new_engines_bound_what_is_there():
    disk, sphere = add_disk(), utils.sphere((6 * RADIUS, 0, 0), RADIUS, material=FrictMat())
    sphere.state.blockedDOFs = "zXY"
    O.bodies.append(sphere)
    ready()
    run(2)
    O.engines = sg.engines(rigid="nonsmooth")
    O.engines[1].boundDispatcher.functors[0].margin = 0.5
    run(3)
    assert disk.bound.max[0] > 1.5 * RADIUS
    assert sphere.bound.max[0] > 7.049 * RADIUS


def test_rotating_box_turns_a_grain():
    """RotationEngine on a Box on which a grain lies: friction carries it along."""
    disk = add_disk((0, 1.0001 * RADIUS, 0), material=damped_material())
    paddle = utils.box((0, -RADIUS, 0), (4 * RADIUS, RADIUS, RADIUS), fixed=True)
    O.bodies.append(paddle)
    ready(gravity=(0, -10, 0))
    with_engine(
        RotationEngine(
            ids=[paddle.id],
            rotationAxis=(0, 0, 1),
            angularVelocity=2,
            rotateAroundZero=True,
            zeroPoint=(0, -RADIUS, 0),
        )
    )
    while O.time < 0.05:
        run(1)
    assert 2 * math.atan2(paddle.state.ori[2], paddle.state.ori[3]) == pytest.approx(0.1, rel=0.01)
    normal = np.array((-math.sin(0.1), math.cos(0.1), 0))
    depth = (disk.shape.outline() - np.array(paddle.state.pos)) @ normal - RADIUS
    assert depth.min() > -0.02 * RADIUS and sg.wall_force(paddle.id)[1] < 0


@pytest.mark.parametrize("turns", (3, -3))
@pytest.mark.parametrize("dim, axis", ((2, (0, 0, 1)), (3, (0, 0, 1)), (3, (0, 1, 0))), ids=str)
def test_squeezed_block_turns_with_its_boxes(dim, axis, turns):
    """All of the scene turns as one: what sticks bears what it bore."""
    side, press = 2 * RADIUS, 0.05
    soft = soft_material(poisson=0.3, massDamping=1500, frictionAngle=0.5)
    sides = (side, side, side)[:dim]
    block = sg.soft_block((0, 0, 0), sides, soft, zeta=0.25 if dim == 2 else 0.5)
    O.bodies.append(block)
    half = (5 * RADIUS, RADIUS, 5 * RADIUS)
    rough = FrictMat(frictionAngle=0.5)
    boxes = [
        utils.box((0, y * 2 * RADIUS, 0), half, fixed=True, material=rough) for y in (-1, 1)
    ]
    O.bodies.append(boxes)
    ready()
    sg.set_time_step(0.85)
    for box, speed in zip(boxes, (0.2, -0.2)):
        box.state.vel = (0, speed, 0)
    while boxes[1].state.pos[1] > RADIUS + (1 - press) * side / 2:
        run(1)
    for box in boxes:
        box.state.vel = (0, 0, 0)
    run(4000)

    def present():
        force = np.linalg.norm(sg.wall_force(boxes[1].id))
        return force, block.shape.energy()["elastic"]

    before = present()
    rotation = RotationEngine(
        ids=[box.id for box in boxes],
        rotationAxis=axis,
        angularVelocity=2 * math.pi * turns / 0.5,
        rotateAroundZero=True,
    )
    sg.insert_before_solve(rotation)
    start = O.time
    while O.time - start < 0.5:
        run(1)
    rotation.angularVelocity = 0
    run(2000)
    np.testing.assert_allclose(present(), before, rtol=0.02)


def pressed_cube(lid):
    """A cube on a rough floor, pressed by a lid in its middle; returns lid and floor."""
    O.reset()
    rough, smooth = FrictMat(frictionAngle=1.1), FrictMat(frictionAngle=0.1)
    side = 2 * RADIUS
    soft = soft_material(massDamping=5000, frictionAngle=1.1)
    add(sg.soft_block((0, RADIUS, 0), (side,) * 3, soft, zeta=0.5))
    half = (5 * RADIUS, RADIUS, 5 * RADIUS)
    floor = add(utils.box((0, -RADIUS, 0), half, fixed=True, material=rough))
    if lid == "wall":
        top = add_wall(side, axis=1, sense=-1, material=smooth)
    else:
        top = add(utils.box((0, side + RADIUS, 0), half, fixed=True, material=smooth))
    ready()
    sg.integrator().tolerance, sg.integrator().maxSweeps = 1e-4, 1000  # lids differ by what is left
    top.state.vel = (0, -0.4, 0)
    start = top.state.pos[1]
    while top.state.pos[1] > start - 0.02 * side:
        run(1)
    top.state.vel = (0, 0, 0)
    run(300)
    return top, floor


def test_wall_turns_about_its_normal():
    """It drags as a box does, bears the torque, and wakes what sleeps on it."""
    torques = []
    for lid in ("wall", "box"):
        top, floor = pressed_cube(lid)
        top.state.angVel = (0, 3, 0)
        run(1500)
        on_floor, on_top = (O.forces.t(body.id)[1] for body in (floor, top))
        assert on_top == pytest.approx(-on_floor, rel=0.02)
        torques.append([on_floor, on_top, O.forces.f(top.id)[1]])
    assert torques[0] == pytest.approx(torques[1], rel=1e-3)
    mean_arm = 0.3826 * 2 * RADIUS  # of a uniform pressure on a square
    force = torques[0][2]
    assert torques[0][0] == pytest.approx(math.tan(0.1) * force * mean_arm, rel=0.05)


def test_torque_of_a_turning_wall_is_about_its_place():
    top, _ = pressed_cube("wall")
    top.state.pos = (3 * RADIUS, top.state.pos[1], -RADIUS)
    top.state.angVel = (0, 3, 0)
    run(200)
    (grain,) = sg.soft_bodies()
    contacts = O.interactions[grain.id, top.id].geom.contacts()
    forces = np.array(contacts["force"])
    expected = np.cross(contacts["point"] - np.array(top.state.pos), forces).sum(axis=0)
    sign = np.sign(O.forces.f(top.id)[1] * forces[:, 1].sum())
    assert abs(expected[1]) > 1e-3
    assert list(O.forces.t(top.id)) == pytest.approx(list(sign * expected), rel=0.01, abs=1e-5)


def test_wall_that_turns_wakes_sleepers():
    top, floor = pressed_cube("wall")
    while not sg.integrator().sleepingGrains:
        run(100)
    assert O.forces.t(floor.id)[1] == pytest.approx(0, abs=1e-4)
    top.state.angVel = (0, 3, 0)
    run(1000)
    assert sg.integrator().sleepingGrains == 0
    assert O.forces.t(floor.id)[1] > 1e-3


@pytest.mark.parametrize("dim", (2, 3))
def test_wall_that_would_tilt_is_refused(dim):
    if dim == 2:
        add_disk()
    else:
        O.bodies.append(sg.soft_sphere((0, 0, 0), RADIUS, damped_material(), zeta=0.5))
    wall = add_wall(-RADIUS, 1)
    ready()
    sg.insert_before_solve(RotationEngine(ids=[wall.id], rotationAxis=(0, 0, 1), angularVelocity=2))
    with pytest.raises(RuntimeError, match=r"angVel\[2\] = 2.* of a Wall of axis = 1, .*Use a Box"):
        run(5)


def swing():
    """A wall on a grain, that swings so fast that each step tells."""
    O.bodies[1].state.vel = (0, 0.2 * math.cos(O.iter / 4), 0)


__main__.swing = swing  # where PyRunner looks


@pytest.mark.parametrize("first", (False, True))
def test_solve_sees_the_present_velocity_of_a_wall(first):
    """As it does that of a box, wherever the engine stands that gives it."""
    places = []
    for make in (add_wall, add_plate):
        O.reset()
        disk = add_disk(zeta=0.3)
        make(-RADIUS, 1)
        ready()
        O.trackEnergy = True
        engine = PyRunner(command="swing()", iterPeriod=1)
        O.engines = [engine] + O.engines if first else O.engines
        if not first:
            sg.insert_before_solve(engine)
        run(60)
        places.append((disk.state.pos[1], sg.integrator().energy()["walls"]))
    assert places[0] == pytest.approx(places[1], rel=1e-9)
    assert places[0][1] > 0


def add_plate(position, axis):
    box = utils.box((0, position - RADIUS, 0), (9 * RADIUS, RADIUS, RADIUS), fixed=True)
    box.material = FrictMat(frictionAngle=0)
    O.bodies.append(box)


@pytest.mark.parametrize("make", (add_wall, add_plate))
def test_what_newton_leaves_out_does_no_work(make):
    disk = add_disk()
    make(-0.999 * RADIUS, 1)
    O.bodies[1].state.vel = (0, 1, 0)
    O.bodies[1].mask = 2
    disk.mask = 3
    ready()
    O.engines[-1].mask = 1
    O.trackEnergy = True
    run(20)
    assert O.bodies[1].state.pos == O.bodies[1].state.refPos
    assert sg.integrator().energy()["walls"] == 0
