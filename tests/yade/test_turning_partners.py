"""What sticks to a rigid body that turns, held or free, goes round with it."""

import math

import numpy as np
import pytest
from partner_scenes import rigid_material
from scenes import RADIUS, ready, run, soft_material
from yade import FrictMat, O, Quaternion, utils

import softgrain as sg


def distance_from_axis(body):
    x, y, _ = body.state.pos
    return math.hypot(x, y)


def test_carried_round_by_a_turntable():
    """What sticks to it stays at its distance from the axis: the surface goes along circles, not
    along their tangents (which would be 1e-3 farther out after the half turn)."""
    side, spin = 2 * RADIUS, 8.0
    material = soft_material(massDamping=2000, frictionAngle=math.atan(0.8))
    block = sg.soft_block((3 * RADIUS, 0, RADIUS), (side, side, side), material, zeta=0.5)
    O.bodies.append(block)
    plate = utils.box((0, 0, -RADIUS), (6 * RADIUS, 6 * RADIUS, RADIUS), fixed=True)
    plate.material = rigid_material(0.8)
    O.bodies.append(plate)
    ready(gravity=(0, 0, -10))
    for turning in np.linspace(0, spin, 1500):
        plate.state.angVel = (0, 0, turning)
        run(1)
    run(1000)
    distance, start = distance_from_axis(block), O.time
    while O.time < start + math.pi / spin:
        run(100)
    assert distance_from_axis(block) == pytest.approx(distance, rel=2e-5)


@pytest.mark.parametrize("dim", (2, 3))
def test_bonds_to_a_free_body_that_turns_with_the_grain(dim):
    """They bear next to nothing, and do no work; the tangents of what turns would have opened them
    by pi omega dt of the radius in each turn. Momenta are kept."""
    O.trackEnergy = True
    spin, side = 30.0, 2 * RADIUS
    size = (side,) * dim
    block = sg.soft_block((0, RADIUS, 0), size, soft_material(poisson=0.3), zeta=0.5)
    plate = utils.box((0, -RADIUS, 0), (2 * RADIUS, RADIUS, 2 * RADIUS), material=rigid_material(0))
    O.bodies.append([block, plate])
    state = plate.state
    state.blockedDOFs = "zXY" if dim == 2 else ""
    state.mass = 2000 * (4 * RADIUS) * side * (1 if dim == 2 else 4 * RADIUS)
    halves = np.array((2 * RADIUS, RADIUS, 2 * RADIUS if dim == 3 else 0))
    state.inertia = state.mass / 3 * ((halves**2).sum() - halves**2)
    ready(interface={"bondStrength": 1e4, "bondEnergy": 1.0}, tolerance=1e-6)
    run(3)
    axis = np.array((0, 0, 1) if dim == 2 else (0, 1, 0))
    bodies = (block, plate)
    masses = np.array([body.state.mass for body in bodies])
    centre = masses @ np.array([body.state.pos for body in bodies]) / masses.sum()
    for body in bodies:
        body.state.vel = np.cross(spin * axis, np.array(body.state.pos) - centre)
        body.state.angVel = spin * axis
        body.state.angMom = spin * axis * body.state.inertia
    run(2)
    momentum = masses @ np.array([body.state.vel for body in bodies])
    before, start = sg.integrator().energy(), O.time
    while O.time < start + 2 * 2 * math.pi / spin:
        run(50)
    (pair,) = [i for i in O.interactions if i.isReal]
    contacts = pair.geom.contacts()
    assert contacts["damage"].max() < 0.01 and (contacts["bond"] == 1).all()
    now = sg.integrator().energy()
    scale = before["kinetic"]
    assert abs(now["cohesion"] - before["cohesion"]) < 1e-3 * scale
    assert now["elastic"] < 0.01 * scale
    assert now["kinetic"] == pytest.approx(scale, rel=0.01)
    after = masses @ np.array([body.state.vel for body in bodies])
    np.testing.assert_allclose(after, momentum, atol=1e-9 * masses.sum() * spin * RADIUS)


def test_no_creep_about_an_axis_across_the_side():
    """A block bonded to a held box that turns about an axis at 45 degrees to the normal stays where
    it is on that, in whose axes it had crept by 0.004 R a turn."""
    spin = 30.0
    block = sg.soft_block((0, RADIUS, 0), (2 * RADIUS,) * 3, soft_material(poisson=0.3), zeta=0.5)
    plate = utils.box((0, -RADIUS, 0), (2 * RADIUS, RADIUS, 2 * RADIUS), fixed=True)
    plate.material = rigid_material(0)
    O.bodies.append([block, plate])
    ready(interface={"bondStrength": 1e4, "bondEnergy": 1.0}, tolerance=1e-6)
    run(3)
    axis = np.array((1, 1, 0)) / math.sqrt(2)
    for body in (block, plate):
        body.state.angVel = spin * axis
        body.state.vel = np.cross(spin * axis, np.array(body.state.pos) - np.array(plate.state.pos))

    def place():
        apart = np.array(block.state.pos) - np.array(plate.state.pos)
        return np.array(plate.state.ori.toRotationMatrix()).T @ apart

    run(200)
    before, start = place(), O.time
    while O.time < start + 4 * 2 * math.pi / spin:
        run(50)
    assert np.linalg.norm((place() - before)[[0, 2]]) < 2e-3 * RADIUS


@pytest.mark.parametrize("side", (0, 1))
def test_impulses_turn_about_normals_with_a_body_that_spins(side):
    """In 3D; at contact points of the grain, on a box, as well as at that of a small ball, whose
    normal points the other way."""
    material = soft_material(massDamping=300, frictionAngle=math.atan(0.8))
    ball = sg.soft_sphere((0, 0, RADIUS), RADIUS, material, zeta=0.3)
    ball.state.ori = Quaternion((0.9, 0.3, 0.3), 0.16)
    O.bodies.append(ball)
    surface = FrictMat(frictionAngle=math.atan(0.8))
    if side == 0:
        size = (9 * RADIUS, 9 * RADIUS, RADIUS)
        rigid = utils.box((0, 0, -RADIUS), size, material=surface)
    else:
        tip = 0.15 * RADIUS
        rigid = utils.sphere((0, 0, -tip), tip, material=surface)
    rigid.state.blockedDOFs = "xyzXYZ"
    O.bodies.append(rigid)
    ready(gravity=(4, 0, -200), tolerance=1e-6)
    run(300)
    spin = 20.0
    rigid.state.angVel = (0, 0, spin)
    run(3)
    (pair,) = [i for i in O.interactions if i.isReal]
    sign = -1 if side else 1
    turned = []
    for _ in range(20):
        before = pair.geom.contacts()
        run(1)
        now, problem = pair.geom.contacts(), sg.integrator().contactProblem()
        for k, n in enumerate(problem["normal"]):
            same = (before["side"] == now["side"][k]) & (before["node"] == now["node"][k])
            if now["side"][k] != side or not same.any() or not before["impulse"][same].any():
                continue
            (last,), (normal,) = before["impulse"][same], before["normal"][same]
            last = sign * (last - last @ normal * normal)
            start = problem["start"][k] - problem["start"][k] @ n * n
            angle = math.atan2(np.cross(last, start) @ n, last @ start)
            turned.append(angle / (spin * n[2] * O.dt))
    assert len(turned) >= 20
    np.testing.assert_allclose(turned, 1, atol=0.02)
