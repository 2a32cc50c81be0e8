"""Impacts and walls: impulses are what State and O.forces say."""

import math

import numpy as np
import pytest
from motion import momentum
from periodic_scenes import set_cell
from scenes import RADIUS, add_disk, add_wall, ready, run, soft_material
from yade import FrictMat, O, utils

import softgrain as sg


def test_head_on_impact():
    """Both rebound; the momentum is kept to rounding, all through the contact."""
    grains = [add_disk((-1.02 * RADIUS, 0, 0)), add_disk((1.02 * RADIUS, 0, 0), 0.8 * RADIUS)]
    grains[0].state.vel, grains[1].state.vel = (1, 0, 0), (-1.5, 0, 0)
    before = grains[0].shape.volume() * 1000 - 1.5 * grains[1].shape.volume() * 1000
    scale = grains[0].shape.volume() * 1000
    ready()
    touched = 0
    for _ in range(300):
        run(1)
        touched += sg.integrator().activeContacts > 0
        np.testing.assert_allclose(momentum(grains), (before, 0, 0), rtol=0, atol=1e-12 * scale)
    assert touched > 20
    assert sg.integrator().activeContacts == 0
    assert grains[0].state.vel[0] < 0 < grains[1].state.vel[0]


def oblique_pair(speed):
    """Two disks with friction, the first of which goes for the second one off its centre."""
    material = sg.SoftMat(frictionAngle=0.5)
    grains = [
        add_disk((-RADIUS, 0, 0), material=material),
        add_disk((1.01 * RADIUS, 0.01, 0), material=material),
    ]
    grains[0].state.vel = (speed, 0, 0)
    return grains


def test_oblique_impact_with_friction():
    """Friction sets both spinning; the momentum stays."""
    grains = oblique_pair(3)
    ready()
    run(1)
    before = momentum(grains)
    run(300)
    np.testing.assert_allclose(
        momentum(grains), before, rtol=0, atol=1e-12 * np.linalg.norm(before)
    )
    assert grains[0].state.angVel[2] * grains[1].state.angVel[2] > 0
    assert abs(grains[0].state.angVel[2]) > 1


def test_impact_energy_balance():
    oblique_pair(1)
    O.trackEnergy = True
    ready()
    run(1)
    balance = sg.Balance()
    run(200)
    assert balance.error() < 0.01
    energy = sg.integrator().energy()
    assert energy["friction"] > 0
    assert dict(O.energy.items())["softKinetic"] == energy["kinetic"]


@pytest.mark.parametrize("axis", (0, 1))
@pytest.mark.parametrize("side", (-1, 1))
def test_reaction_on_a_wall(axis, side):
    """Force on the grain = its change of momentum = - force on the wall = the contacts' sum."""
    normal = np.zeros(3)
    normal[axis] = -side
    disk = add_disk()
    wall = add_wall(side * 1.01 * RADIUS, axis, friction=0.3)
    disk.state.vel = -2 * normal + np.array((0.2, 0.2, 0)) * (1 - np.abs(normal))
    ready()
    O.dt = 0.4 * sg.critical_time_step()  # the user's, so that it does not change
    largest = 0
    for _ in range(100):
        before = momentum([disk])
        run(1)
        force = np.array(O.forces.f(disk.id))
        np.testing.assert_allclose(O.forces.f(wall.id), -force, rtol=1e-13)
        np.testing.assert_allclose(
            momentum([disk]) - before, force * O.dt, atol=1e-11 * disk.state.mass
        )
        largest = max(largest, force @ normal)
        assert force @ normal >= 0
        for i in O.interactions:
            contacts = i.geom.contacts()
            np.testing.assert_allclose(
                contacts["impulse"].sum(axis=0) / O.dt, force, atol=1e-9 * max(largest, 1)
            )
            second = np.array(i.phys.normalForce + i.phys.shearForce)
            np.testing.assert_allclose(second, force if i.id2 == disk.id else -force, atol=1e-9)
    assert largest > 1
    np.testing.assert_allclose(wall.state.pos[axis], side * 1.01 * RADIUS)


def test_friction_law():
    """No contact force leaves Coulomb's cone, and a sliding one lies on it."""
    mu = 0.3
    disk = add_disk(material=sg.SoftMat(frictionAngle=1.0))
    add_wall(-RADIUS, 1, friction=mu)
    disk.state.vel = (3, -1, 0)
    ready()
    sliding = 0
    for _ in range(60):
        run(1)
        for i in O.interactions:
            contacts = i.geom.contacts()
            normal = np.sum(contacts["impulse"] * contacts["normal"], axis=1)
            tangential = np.linalg.norm(
                contacts["impulse"] - normal[:, None] * contacts["normal"], axis=1
            )
            assert (normal >= 0).all()
            assert (tangential <= mu * normal * (1 + 1e-12)).all()
            sliding += np.sum((normal > 0) & (tangential > 0.999 * mu * normal))
    assert sliding > 10


def test_moving_wall_pushes():
    """A wall hits a grain at rest: it rebounds from the wall with about twice its speed."""
    disk = add_disk()
    wall = add_wall(-1.01 * RADIUS, 0, velocity=(1, 0, 0), sense=1)
    ready()
    run(250)
    assert wall.state.pos[0] == pytest.approx(-1.01 * RADIUS + O.time, rel=1e-10)
    assert 1.5 < disk.state.vel[0] <= 2.0
    assert sg.integrator().activeContacts == 0


def test_wall_changes_speed_in_the_run():
    disk = add_disk()
    wall = add_wall(1.001 * RADIUS, 1, velocity=(0, -1, 0))
    add_wall(-RADIUS, 1)
    ready()
    run(30)
    squeezed = -O.forces.f(wall.id)[1]
    assert squeezed < 0
    wall.state.vel = (0, 1, 0)
    run(200)
    assert O.forces.f(wall.id)[1] == 0
    assert disk.shape.outline()[:, 1].max() < wall.state.pos[1]


def test_one_sided_wall():
    """A wall with sense lets pass what is on its other side."""
    disk = add_disk()
    disk.state.vel = (2, 0, 0)
    add_wall(1.05 * RADIUS, 0, sense=1)
    ready()
    run(50)
    assert disk.state.vel[0] == pytest.approx(2, rel=1e-12)


def test_one_sided_wall_hides_no_corner():
    """What it lets pass falls on the end of a box that lies in it as if it were not there."""
    places = []
    for sense in (1, None):
        O.reset()
        disk = add_disk((-0.02 * RADIUS, RADIUS, 0), material=soft_material(massDamping=500))
        box = (-2 * RADIUS, -RADIUS, 0), (2 * RADIUS, RADIUS, RADIUS)
        O.bodies.append(utils.box(*box, material=FrictMat(frictionAngle=0), fixed=True))
        if sense:
            add_wall(0, 0, sense=sense)
        ready(gravity=(0, -50, 0))
        run(600)
        places.append(tuple(disk.state.pos))
    assert places[0] == places[1]
    assert places[0][0] < -0.021 * RADIUS


def test_two_balls_touch():
    """3D: head-on impact of unequal balls, momentum kept."""
    balls = [
        sg.soft_sphere((-RADIUS, 0, 0), RADIUS, sg.SoftMat(), zeta=0.4),
        sg.soft_sphere((0.81 * RADIUS, 0, 0), 0.8 * RADIUS, sg.SoftMat(), zeta=0.4),
    ]
    balls[0].state.vel = (1, 0, 0)
    O.bodies.append(balls)
    ready()
    run(1)
    before = momentum(balls)
    touched = 0
    for _ in range(200):
        run(1)
        touched += sg.integrator().activeContacts > 0
    np.testing.assert_allclose(momentum(balls), before, rtol=0, atol=1e-12 * before[0])
    assert touched > 10
    assert balls[1].state.vel[0] > balls[0].state.vel[0]


def test_gravity_holds_against_the_floor():
    """A grain rests on the floor: the mean reaction is its weight."""
    disk = add_disk()
    floor = add_wall(-RADIUS, axis=1, material=FrictMat())
    ready(gravity=(0, -10, 0))
    run(200)
    total = steps = 0
    while steps < 2000:
        run(1)
        total -= O.forces.f(floor.id)[1]
        steps += 1
    assert total / steps == pytest.approx(10 * disk.state.mass, rel=0.1)


@pytest.mark.parametrize("steps", (0, 1))
def test_interaction_made_by_hand(steps):
    """Between grains that do not touch, before the first step and after it."""
    add_disk()
    add_disk((2.1 * RADIUS, 0, 0))
    ready()
    run(steps)
    found = utils.createInteraction(0, 1)
    assert isinstance(found.geom, sg.SoftGeom) and isinstance(found.phys, sg.SoftPhys)
    run(2)
    assert sg.integrator().activeContacts == 0


def test_points_of_contacts_on_background_nodes():
    """After a step, in which the nodes that a grain gives to get other numbers: beside the wall."""
    add_disk(contact="nodes")
    sides = [(axis, side) for axis in (0, 1) for side in (-1, 1)]
    for axis, side in sides:
        add_wall(side * RADIUS, axis, velocity=[-side * 0.5 * (a == axis) for a in range(3)])
    ready()
    for _ in range(200):
        run(1)
        for interaction in O.interactions:
            axis, side = sides[max(interaction.id1, interaction.id2) - 1]
            points = interaction.geom.contacts()["point"]
            assert np.linalg.norm(points, axis=1).max() < 1.1 * RADIUS
            assert (side * points[:, axis]).min() > 0.5 * RADIUS
    assert O.interactions.countReal() == len(sides)


def test_contact_point_of_grains_within_each_other():
    """Where no contact points tell it lies between the centres."""
    set_cell(10 * RADIUS, 10 * RADIUS)
    add_disk((0.05 * RADIUS, 5 * RADIUS, 0), 0.4 * RADIUS)
    add_disk((9.95 * RADIUS, 5 * RADIUS, 0), 2 * RADIUS)
    ready(maxOverlap=math.inf, rigidMotion=False)
    for _ in range(3):
        run(1)
        (pair,) = [i for i in O.interactions if i.isReal]
        assert pair.phys.contacts == 0
        x, y, z = pair.geom.contactPoint
        assert (y, z) == pytest.approx((5 * RADIUS, 0))
        assert abs(math.remainder(x, 5 * RADIUS)) < 1e-9


@pytest.mark.parametrize("contact", ("surface", "points"))
def test_pair_is_touched_half_way(contact):
    """Of two equal disks; disks about boundary points count with their radius, also beside a
    wall."""
    material = soft_material(massDamping=2000)
    disks = [
        add_disk((x * RADIUS, 0, 0), material=material, zeta=0.15, contact=contact) for x in (-1, 1)
    ]
    for side in (-1, 1):
        add_wall(side * 2 * RADIUS, axis=0, velocity=(-0.05 * side, 0, 0))
    ready()
    run(400)
    pair = O.interactions[disks[0].id, disks[1].id]
    assert pair.phys.normalForce[0] > 10
    assert abs(pair.geom.contactPoint[0]) < 0.02 * RADIUS
    assert pair.geom.refR1 == pytest.approx(pair.geom.refR2, abs=0.03 * RADIUS)
    wall = O.interactions[disks[0].id, disks[1].id + 1]
    assert wall.geom.contactPoint[0] == pytest.approx(O.bodies[2].state.pos[0], abs=0.02 * RADIUS)
