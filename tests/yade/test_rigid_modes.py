"""The grain as a whole: free flight, rotation, loads, and what the user does to its State."""

import math

import numpy as np
import pytest
from scenes import DENSITY, RADIUS, YOUNG, add_disk, add_wall, largest_stress, ready, run
from yade import O, PyRunner, Quaternion, Vector3

import softgrain as sg

MASS = DENSITY * math.pi * RADIUS**2


def turn_about_z(angle):
    return Quaternion(Vector3(0, 0, 1), angle)


def angle_of(state):
    """Angle of a 2D orientation in (-pi, pi]."""
    ori = state.ori
    return 2 * math.atan2(ori[2], ori[3])


def test_free_flight():
    """Straight on, no stress, momentum to rounding."""
    disk = add_disk((0.1, 0.2, 0))
    disk.state.vel = (1, -2, 0)
    ready()
    run(300)
    assert disk.state.mass == pytest.approx(MASS, rel=1e-12)
    np.testing.assert_allclose(disk.state.vel, (1, -2, 0), rtol=0, atol=1e-12 * 2)
    np.testing.assert_allclose(
        disk.state.pos, (0.1 + O.time, 0.2 - 2 * O.time, 0), rtol=0, atol=1e-12
    )
    assert largest_stress(disk) < 1e-9 * YOUNG


def test_rotation():
    """Half a turn, slow enough that the rim does not fly out."""
    disk = add_disk()
    spin = 20.0
    disk.state.angVel = (0, 0, spin)
    dt = ready()
    run(int(math.pi / spin / dt))
    assert disk.state.angVel[2] == pytest.approx(spin, rel=1e-4)
    assert angle_of(disk.state) == pytest.approx(spin * O.time, rel=1e-4)
    assert largest_stress(disk) < 2 * DENSITY * (spin * RADIUS) ** 2
    np.testing.assert_allclose(disk.state.pos, 0, atol=1e-12 * RADIUS)
    shape = disk.shape.points()["F"]
    np.testing.assert_allclose(shape[:, 0, 0], math.cos(angle_of(disk.state)), atol=1e-3)
    np.testing.assert_allclose(shape[:, 1, 0], math.sin(angle_of(disk.state)), atol=1e-3)


def test_rotation_in_3d():
    """About an oblique axis."""
    ball = sg.soft_sphere((0, 0, 0), RADIUS, sg.SoftMat(), zeta=0.4)
    axis = np.array([1.0, 2.0, 2.0]) / 3
    ball.state.angVel = tuple(20 * axis)
    ball.state.vel = (1, 2, 3)
    O.bodies.append(ball)
    ready()
    run(300)
    expected_axis, angle = ball.state.ori.toAxisAngle()
    np.testing.assert_allclose(expected_axis, axis, atol=1e-3)
    assert angle == pytest.approx(20 * O.time, rel=1e-3)
    np.testing.assert_allclose(ball.state.vel, (1, 2, 3), rtol=1e-12)
    np.testing.assert_allclose(ball.state.pos, np.array((1, 2, 3)) * O.time, rtol=1e-10)


def test_gravity():
    """As YADE's integrator moves a rigid body: pos(n) = g dt^2 n (n + 1) / 2."""
    disk = add_disk()
    ready(gravity=(1, -10, 0))
    run(200)
    dt = O.dt
    assert O.time == pytest.approx(200 * dt, rel=1e-12)
    fallen = dt**2 * 200 * 201 / 2
    np.testing.assert_allclose(disk.state.pos, (fallen, -10 * fallen, 0), rtol=1e-9)
    np.testing.assert_allclose(disk.state.vel, (200 * dt, -2000 * dt, 0), rtol=1e-10)
    assert largest_stress(disk) < 1e-9 * YOUNG


def test_permanent_force_and_torque():
    """F = m a, T = I alpha, with the mass and inertia that State shows."""
    disk = add_disk()
    ready()
    O.forces.setPermF(disk.id, (3, -1, 0))
    O.forces.setPermT(disk.id, (0, 0, 1e-4))
    run(100)
    np.testing.assert_allclose(
        np.array(disk.state.vel) * MASS, O.time * np.array((3, -1, 0)), rtol=1e-9, atol=1e-15
    )
    assert disk.state.angVel[2] * disk.state.inertia[2] == pytest.approx(1e-4 * O.time, rel=1e-3)


def test_inertia_at_usual_resolution():
    """The angular acceleration of a disk is that of the continuum, up to the discretisation."""
    disk = add_disk(zeta=0.11)
    ready()
    O.forces.setPermT(disk.id, (0, 0, 1e-4))
    run(100)
    inertia = 0.5 * MASS * RADIUS**2
    assert disk.state.angVel[2] == pytest.approx(1e-4 / inertia * O.time, rel=0.08)


def test_force_of_a_few_steps():
    disk = add_disk()
    ready()
    O.engines = (
        O.engines[:1]
        + [
            PyRunner(
                command=f"O.forces.addF({disk.id}, (2, 0, 0)) if O.iter < 5 else None",
                iterPeriod=1,
                initRun=True,
            )
        ]
        + O.engines[1:]
    )
    run(20)
    assert disk.state.vel[0] == pytest.approx(5 * 2 * O.dt / MASS, rel=1e-9)


def test_user_sets_velocity_and_spin():
    disk = add_disk()
    disk.state.vel = (1, 0, 0)
    ready()
    run(10)
    disk.state.vel = (-2, 3, 0)
    disk.state.angVel = (0, 0, 7)
    run(1)
    velocities, nodes = disk.shape.nodeVelocities(), disk.shape.nodes()
    centre = np.array(disk.state.pos)[:2]
    arm = nodes - O.dt * velocities - (centre - O.dt * np.array((-2, 3)))
    np.testing.assert_allclose(disk.state.vel, (-2, 3, 0), rtol=1e-10)
    assert disk.state.angVel[2] == pytest.approx(7, rel=1e-6)
    turned = 7**2 * O.dt * RADIUS  # velocities may belong to the arms before or after the step
    np.testing.assert_allclose(velocities[:, 0], -2 - 7 * arm[:, 1], atol=2 * turned)
    np.testing.assert_allclose(velocities[:, 1], 3 + 7 * arm[:, 0], atol=2 * turned)


def test_user_stops_the_grain():
    """A velocity of zero is a change, too."""
    disk = add_disk()
    disk.state.vel = (1, 0, 0)
    ready()
    run(10)
    disk.state.vel = (0, 0, 0)
    run(10)
    assert np.abs(disk.shape.nodeVelocities()).max() < 1e-10


def test_user_moves_and_turns():
    """A rigid displacement carries no stress, by any angle."""
    disk = add_disk()
    ready()
    run(5)
    before = disk.shape.nodes()
    disk.state.pos = (0.3, -0.1, 0)
    disk.state.ori = turn_about_z(2.0)
    run(1)
    np.testing.assert_allclose(disk.state.pos, (0.3, -0.1, 0), atol=1e-12)
    assert angle_of(disk.state) == pytest.approx(2.0, rel=1e-9)
    c, s = math.cos(2.0), math.sin(2.0)
    np.testing.assert_allclose(
        disk.shape.nodes(), before @ np.array([[c, s], [-s, c]]) + (0.3, -0.1), atol=1e-10
    )
    assert largest_stress(disk) < 1e-8 * YOUNG


def test_changes_to_a_compressed_grain_keep_its_shape():
    """The user's motion adds to the deformation, it does not replace it."""
    disk = add_disk()
    bottom, top = add_wall(-RADIUS, 1), add_wall(RADIUS, 1, velocity=(0, -1, 0))
    ready()
    run(30)
    O.dt = 1e-9
    run(1)  # energies are those at its beginning
    stress, energy = largest_stress(disk), disk.shape.energy()["elastic"]
    assert stress > 1e-3 * YOUNG
    for wall, y in ((bottom, -1), (top, 1)):  # out of the way
        wall.state.vel, wall.state.pos = (0, 0, 0), (0, y, 0)
    disk.state.ori = turn_about_z(1.0) * disk.state.ori
    disk.state.pos += Vector3(0.05, 0, 0)
    run(1)
    assert largest_stress(disk) == pytest.approx(stress, rel=1e-3)
    assert disk.shape.energy()["elastic"] == pytest.approx(energy, rel=1e-2)


@pytest.mark.parametrize("angle", (0.5, 3.0))
def test_grain_placed_with_an_orientation(angle):
    disk = add_disk()
    disk.state.ori = turn_about_z(angle)
    ready()
    run(20)
    assert angle_of(disk.state) == pytest.approx(angle, rel=1e-9)
    assert largest_stress(disk) < 1e-9 * YOUNG
    F = disk.shape.points()["F"]
    np.testing.assert_allclose(F[:, 0, 0], math.cos(angle), atol=1e-9)
