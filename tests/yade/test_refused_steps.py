"""A step that was refused leaves the scene as it was, and a run that goes on loses and doubles
nothing."""

import math

import numpy as np
import pytest
from partner_scenes import add_rigid_disk
from scenes import (
    RADIUS,
    add_disk,
    add_wall,
    assert_same_bits,
    complaint,
    message_of_step,
    present_state,
    ready,
    run,
)
from yade import ForceEngine, Matrix3, O, PyRunner, Quaternion, Vector3

import softgrain as sg


def move(body):
    body.state.pos += Vector3(3 * RADIUS, RADIUS, 0)
    body.state.ori = Quaternion((0, 0, 1), 0.3) * body.state.ori
    body.state.vel += Vector3(1, 0, 0)
    body.state.angVel += Vector3(0, 0, 20)


def assert_same_motion(body, other):
    for name in ("pos", "vel", "angVel"):
        found, expected = getattr(body.state, name), getattr(other.state, name)
        np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-15)
    assert (body.state.ori.conjugate() * other.state.ori).toAngleAxis()[0] < 1e-12
    found, expected = body.shape.nodes(), other.shape.nodes()
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12 * RADIUS)


def flight(refused):
    O.reset()
    body = add_disk()
    ready()
    run(5)
    move(body)
    if refused:
        dt = O.dt
        O.dt = 100 * dt
        for _ in range(2):
            assert "O.dt" in complaint()
        O.dt = dt
    run(20)
    return body


def test_motion_by_hand_counts_once():
    assert_same_motion(flight(refused=True), flight(refused=False))


def test_motions_of_others_count_once():
    """One grain is moved, and the State of the next one is no motion."""
    first, second = add_disk(), add_disk((10 * RADIUS, 0, 0))
    ready()
    run(2)
    first.state.vel = (1, 0, 0)
    second.state.vel = (math.nan, 0, 0)
    for _ in range(3):
        assert "#1" in complaint()
    second.state.vel = (0, 0, 0)
    start = first.state.pos[0]
    run(10)
    assert first.state.vel[0] == pytest.approx(1, rel=1e-12)
    assert first.state.pos[0] == pytest.approx(start + 10 * O.dt, rel=1e-9)


def pressed_sphere():
    """A grain between a wall and a free rigid disk that presses on it."""
    add_disk()
    add_wall(-RADIUS, 0)
    sphere = add_rigid_disk((1.99 * RADIUS, 0, 0), RADIUS, velocity=(-1, 0, 0))
    ready()
    run(20)
    assert sg.integrator().activeContacts > 0
    return sphere


def test_impulse_that_is_no_number():
    """It is not what the next step starts from."""
    sphere = pressed_sphere()
    before = np.array(sphere.state.pos)
    O.forces.setPermF(sphere.id, (-math.inf, 0, 0))
    message = complaint()
    assert "not finite" in message
    np.testing.assert_array_equal(sphere.state.pos, before)
    assert len(sg.integrator().contactProblem()["bias"]) == 0
    O.forces.setPermF(sphere.id, (0, 0, 0))
    run(50)
    assert sg.integrator().residual <= sg.integrator().tolerance
    assert np.isfinite(sphere.state.vel[0]) and sphere.state.vel[0] > -1


def test_no_problem_is_left_of_the_step_before():
    """Nor where a step ends before it is solved."""
    add_disk()
    add_wall(-0.99 * RADIUS, 0)
    ready()
    run(20)
    assert len(sg.integrator().contactProblem()["bias"]) > 0
    sg.integrator().maxOverlap = 1e-12
    assert "maxOverlap" in complaint()
    assert len(sg.integrator().contactProblem()["bias"]) == 0


@pytest.mark.parametrize("refusals", (1, 3))
def test_forces_of_engines_count_once(refusals):
    """On a grain, a rigid body, a wall: what a refused step had put on them is not there twice."""
    grain, other = add_disk(), add_disk((4 * RADIUS, 0, 0))
    sphere = add_rigid_disk((8 * RADIUS, 0, 0), RADIUS)
    wall = add_wall(-4 * RADIUS, 0)
    wall.state.blockedDOFs, wall.state.mass = "yzXYZ", 0.5
    pushed = (grain, sphere, wall)
    ready()
    sg.insert_before_solve(ForceEngine(ids=[b.id for b in pushed], force=(1, 0, 0)))
    run(2)

    def gained():
        before = [b.state.vel[0] for b in pushed]
        run(1)
        return [b.state.vel[0] - v for b, v in zip(pushed, before)]

    expected = gained()
    for _ in range(refusals):
        other.state.vel = (math.nan, 0, 0)
        assert "not finite" in complaint()
    other.state.vel = (0, 0, 0)
    assert min(expected) > 0
    np.testing.assert_allclose(gained(), expected, rtol=1e-9)


def flowing_cell():
    """Grains that the cell brings nearer to each other and shears."""
    O.reset()
    O.periodic = True
    O.cell.setBox(6 * RADIUS, 6 * RADIUS, 1)
    for place in ((1, 1), (3.2, 1), (1, 3.1), (3.2, 3.3)):
        add_disk((place[0] * RADIUS, place[1] * RADIUS, 0))
    ready()
    O.cell.velGrad = Matrix3(-5, 2, 0, 0, -5, 0, 0, 0, 0)
    run(50)
    return O.dt


@pytest.mark.parametrize("wrong", (0, 1e-3, 0.1, 10, math.nan))
def test_cell_is_as_it_was(wrong):
    """YADE deforms it before any engine can tell that O.dt is wrong."""
    dt = flowing_cell()
    run(50)
    expected = {**present_state(), "cell": np.array(O.cell.hSize)}
    dt = flowing_cell()
    size, gradient = np.array(O.cell.hSize), np.array(O.cell.trsf)
    for _ in range(2):
        O.dt = wrong
        assert "O.dt = " in complaint()
        np.testing.assert_array_equal(O.cell.hSize, size)
        np.testing.assert_allclose(O.cell.trsf, gradient, rtol=0, atol=1e-12)
    O.dt = dt
    run(50)
    assert_same_bits({**present_state(), "cell": np.array(O.cell.hSize)}, expected)


def test_forces_of_a_step_that_was_refused():
    """Are those of the step before, over its time."""
    sphere = pressed_sphere()
    contacts = O.interactions[0, sphere.id].geom.contacts
    before = contacts()
    O.forces.setPermF(sphere.id, (-math.inf, 0, 0))
    O.dt /= 2
    assert "not finite" in complaint()
    for name in ("force", "pressure"):
        largest = np.abs(before[name]).max()
        assert largest > 0
        np.testing.assert_allclose(contacts()[name], before[name], rtol=0, atol=1e-9 * largest)


@pytest.mark.parametrize("put", ("setPermF", "setPermT"))
def test_load_that_is_no_number(put):
    _, second = add_disk(), add_disk((10 * RADIUS, 0, 0))
    ready()
    run(2)
    before = second.shape.nodes()
    getattr(O.forces, put)(second.id, (0, math.inf, math.nan))
    message = message_of_step()
    assert "soft grain #1: its load is not finite" in message
    assert " N/m, torque " in message and " N), Newton" in message  # of a disk
    np.testing.assert_array_equal(second.shape.nodes(), before)
    getattr(O.forces, put)(second.id, (0, 0, 0))
    run(2)
    assert np.isfinite(second.shape.nodes()).all()


def interrupted_flight(interrupted):
    """NewtonIntegrator, the last engine, is left out of one of the steps, if it is to be."""
    O.reset()
    body = add_disk()
    ready()
    body.state.vel, body.state.angVel = (1, 0.5, 0), (0, 0, 30)
    run(5)
    engines = O.engines
    if interrupted:
        O.engines = [*engines[:-1], PyRunner(command="1 / 0", iterPeriod=1), engines[-1]]
        with pytest.raises(RuntimeError):
            O.step()
        O.engines = engines
    else:
        O.step()
    run(5)
    return body


def test_step_stopped_before_newton_integrator():
    """State, which it has not brought up to the grain, is no motion by hand."""
    assert_same_motion(interrupted_flight(True), interrupted_flight(False))
