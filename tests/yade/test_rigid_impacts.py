"""Plastic impacts of rigid bodies in contact dynamics, and heavy ones at rest on light ones."""

import math

import numpy as np
import pytest
from rigid_scenes import GRAVITY, R, add_sphere, material, spheres, start
from scenes import add_wall, run
from yade import O

import softgrain as sg

ALONG_Z = "xyXYZ"


def largest_speed():
    return max(b.state.vel.norm() for b in O.bodies if b.state.mass > 0)


def column(balls):
    """Balls that touch each other fall on a floor; without gravity they stop there."""
    add_wall(0, 2)
    for k in range(balls):
        add_sphere((0, 0, (2 * k + 1 + 0.0099) * R), velocity=(0, 0, -1), blocked=ALONG_Z)
    start(1e-4, (0, 0, 0))


@pytest.mark.parametrize("balls, left", ((3, 1e-3), (10, 1e-3), (20, 1e-3), (40, 0.02)))
def test_column_stops(balls, left):
    column(balls)
    run(30)
    assert largest_speed() < left


def creeping_pair():
    """A held ball that is driven against a free one."""
    add_sphere((1, 0, 5 * R), velocity=(1e-9, 0, 0), blocked="xyzXYZ")
    add_sphere((1 + 2.002 * R, 0, 5 * R))


def grain_on_a_ball():
    """A soft one."""
    soft = sg.SoftMat(young=1e6, poisson=0.3, density=1000)
    O.bodies.append(sg.soft_sphere((1, 0, 5 * R), R, soft, zeta=0.4))
    add_sphere((1, 0, 3 * R), velocity=(0, 0, 1e-3))


@pytest.mark.parametrize("elsewhere", (creeping_pair, grain_on_a_ball))
def test_column_stops_whatever_happens_elsewhere(elsewhere):
    """What it does not touch neither ends its sweeps nor changes them."""
    column(20)
    balls = spheres()
    elsewhere()
    run(30)
    assert max(b.state.vel.norm() for b in balls) < 1e-3


def test_column_stops_on_a_floor_that_moves():
    """As seen by who moves with it: what all have in common drives nothing."""
    column(20)
    for body in O.bodies:
        body.state.vel += (0, 0, 2)
    run(30)
    assert max(abs(b.state.vel[2] - 2) for b in spheres()) < 1e-3


def test_column_of_which_the_top_is_heavy_stops():
    column(3)
    spheres()[-1].state.mass *= 1000
    run(30)
    assert largest_speed() < 5e-3


@pytest.mark.parametrize("ratio", (2, 5, 10))
def test_large_ball_stops_on_a_small_one(ratio):
    add_wall(0, 2)
    add_sphere((0, 0, R), blocked=ALONG_Z)
    place = (0, 0, (2 + ratio + 0.01) * R)
    add_sphere(place, ratio * R, velocity=(0, 0, -1), blocked=ALONG_Z)
    start(1e-4, (0, 0, 0))
    run(100)
    assert largest_speed() < 5e-3


@pytest.mark.parametrize("ratio", (4, 400))
def test_lid_stops_on_a_square_of_disks(ratio):
    side = 8 * R
    for axis, place in ((1, 0), (0, 0), (0, side)):
        add_wall(place, axis)
    for i, j in np.ndindex(4, 4):
        centre = ((2 * i + 1) * R, (2 * j + 1) * R, 0)
        add_sphere(centre, friction=0, blocked="zXY")
    lid = add_wall(side + 0.02 * R, axis=1, velocity=-0.1, material=material())
    lid.state.blockedDOFs = "xzXYZ"
    lid.state.mass = ratio * spheres()[0].state.mass
    start(1e-3, (0, 0, 0))
    run(100)
    assert largest_speed() < 5e-3 * 0.1


@pytest.mark.parametrize("ratio", (10, 1e3, 1e4))
def test_heavy_ball_rests_on_light_ones(ratio):
    add_wall(0, 2)
    for k in range(4):
        add_sphere((0, 0, (2 * k + 1) * R), blocked=ALONG_Z)
    heavy = spheres()[-1].state
    heavy.mass *= ratio
    before = heavy.pos[2]
    start(2e-4)
    run(500)
    assert abs(heavy.pos[2] - before) < 2e-3 * R
    weight = GRAVITY * sum(b.state.mass for b in spheres())
    assert -O.forces.f(0)[2] == pytest.approx(weight, rel=2e-3)


def leaning_clump(angle, friction, small=0.2, apart=1.3):
    """A ball with a small one on it, on which it stands, leaning [deg]; returns its State."""
    way = np.array([math.cos(math.radians(angle)), 0, math.sin(math.radians(angle))])
    foot = np.array([0, 0, small * R * (1 + 1e-6)])
    places = ((foot, small * R), (foot + apart * R * way, R))
    members = [add_sphere(tuple(centre), radius, friction).id for centre, radius in places]
    return O.bodies[O.bodies.clump(members)].state


def sliding_impulse(state, velocity, friction):
    """Of the one contact with the floor, x and z [N s], where it goes on sliding to +x: friction
    is -mu times the normal impulse that ends the approach, -u_z/(W_zz - mu W_zx)."""
    turn = np.array(state.ori.toRotationMatrix())
    inertia = (turn @ np.diag(state.inertia) @ turn.T)[1, 1]
    x, z = -state.pos[0], -state.pos[2]
    W_zz, W_zx = 1 / state.mass + x * x / inertia, -x * z / inertia
    normal = -velocity[2] / (W_zz - friction * W_zx)
    return np.array([-friction * normal, normal]), friction * abs(W_zx) / W_zz


@pytest.mark.parametrize("friction", (0.3, 1.0, 1.2, 2.0))
def test_friction_that_lifts(friction):
    """The larger, the more of the impulse it takes; also where mu |W_nt| > W_nn."""
    add_wall(0, 2, friction=friction)
    clump = leaning_clump(55, friction)
    clump.vel = (1, 0, -0.1)
    start(1e-4, (0, 0, 0))
    wanted, lift = sliding_impulse(clump, (1, 0, -0.1), friction)
    assert (lift > 1) == (friction > 1.1)
    O.step()
    impulse = -O.dt * np.array(O.forces.f(0))[[0, 2]]
    assert impulse == pytest.approx(wanted, rel=2e-3)
    run(50)
    assert sg.integrator().cappedSteps == 0
