"""Sharp corners of soft grains at facets and spheres, and grains at rest on spheres."""

import math

import pytest
from scenes import RADIUS, WIDE, add_disk, add_facets, add_wall, ready, run, soft_material
from yade import FrictMat, O, Quaternion, Vector3, utils

import softgrain as sg


def triangle():
    angles = [2 * math.pi * k / 3 for k in range(3)]
    vertices = [(1.2 * RADIUS * math.cos(a), 1.2 * RADIUS * math.sin(a)) for a in angles]
    return sg.soft_polygon(vertices, rough(), zeta=0.25)


def cube():
    return sg.soft_block((0, 0, 0), (2 * RADIUS,) * 3, rough(), zeta=0.5)


def rough():
    return soft_material(massDamping=1000, frictionAngle=0.3)


def add_floor(kind):
    material = FrictMat(frictionAngle=0.3)
    if kind == "wall":
        add_wall(0, axis=1, sense=1, material=material)
    else:
        add_facets((-20, 0), (20, 0), material)


@pytest.mark.parametrize("make, seconds", [(triangle, 0.2), (cube, 0.12)])
def test_corners_fall_on_facets_as_on_a_wall(make, seconds):
    """The far side of a corner that stands on a facet is not taken for one that has come through
    it from beneath."""
    places = []
    for kind in ("wall", "facets"):
        O.reset()
        grain = make()
        grain.state.pos = (0, 1.8 * RADIUS, 0.1 * RADIUS if grain.shape.dim == 3 else 0)
        grain.state.ori = Quaternion((0, 0, 1), 0.6)
        O.bodies.append(grain)
        add_floor(kind)
        ready(gravity=(0, -9.81, 0))
        while O.time < seconds:
            run(1)
        places.append(list(grain.state.pos))
        assert sg.integrator().largestOverlap < 0.02
    assert places[1] == pytest.approx(places[0], abs=0.05 * RADIUS)


@pytest.mark.parametrize(
    "angle, sideways", [(5.07, (0.52, -0.16)), (4.76, (0.64, -0.03)), (2.71, (0.12, 0.85))]
)
def test_cube_falls_on_a_box_without_thickness(angle, sideways):
    """As those of utils.aabbWalls(thickness=0): a corner on it is not taken for one of what lies
    beneath."""
    material = soft_material(young=1e5, poisson=0.3, massDamping=100, frictionAngle=0.3)
    grain = sg.soft_block((0, 1.5 * RADIUS, 0), (1.6 * RADIUS,) * 3, material, zeta=0.4)
    grain.state.ori = Quaternion(Vector3(0.3, 0.5, 0.8).normalized(), angle)
    grain.state.vel = (sideways[0], -1, sideways[1])
    O.bodies.append(grain)
    sheet = (5 * RADIUS, 0, 5 * RADIUS)
    O.bodies.append(utils.box((0, 0, 0), sheet, material=FrictMat(frictionAngle=0.3), fixed=True))
    ready(gravity=(0, -9.81, 0))
    while O.time < 0.04:
        run(1)
    assert sg.integrator().largestOverlap < 0.03
    assert grain.state.pos[1] > 0.9 * RADIUS


@pytest.mark.parametrize("corner", (30, 60, 90))
@pytest.mark.parametrize("direction", (-70, -45, 0, 45, 70))
def test_ball_beside_a_sharp_corner(corner, direction):
    """It lies behind the line of one side or the other, and touches none."""
    half, toward = math.radians(corner / 2), math.radians(direction)
    if abs(direction) + corner / 2 >= 90:
        toward *= 0.5
    length, radius, gap = 3 * RADIUS, 0.6 * RADIUS, 0.3 * RADIUS
    ends = [(-length * math.cos(half), y * length * math.sin(half)) for y in (1, -1)]
    O.bodies.append(sg.soft_polygon([(0, 0), *ends], soft_material(), zeta=0.3))
    place = [(radius + gap) * f(toward) for f in (math.cos, math.sin)]
    O.bodies.append(utils.sphere((*place, 0), radius, material=FrictMat(), fixed=True))
    ready(verlet_distance=0.4 * RADIUS)
    run(2)
    assert sg.integrator().overlap == 0
    assert sg.integrator().activeContacts == 0


@pytest.mark.parametrize("dim", (2, 3))
def test_rest_on_a_ball(dim):
    """A ball as small as the spacing of points, and the dent that it makes."""
    material = soft_material(massDamping=3000, frictionAngle=0.3)
    zeta, small = {2: (0.2, 0.2), 3: (0.3, 0.4)}[dim]
    make = sg.soft_disk if dim == 2 else sg.soft_sphere
    grain = make((0, 0, 0), RADIUS, material, zeta=zeta)
    O.bodies.append(grain)
    place = (0, -(1 + small) * RADIUS, 0)
    rigid = FrictMat(frictionAngle=0.3)
    O.bodies.append(utils.sphere(place, small * RADIUS, material=rigid, fixed=True))
    lid = add_wall(RADIUS, 1, friction=0.3, velocity=(0, -0.5, 0))
    O.trackEnergy = True
    ready()
    sg.set_time_step()
    while lid.state.pos[1] > 0.7 * RADIUS:
        run(1)
    lid.state.vel = (0, 0, 0)
    for _ in range(80):
        run(200)
        if grain.shape.isAsleep():
            break
    assert grain.shape.isAsleep()
    assert sg.integrator().overlap < 0.25


def test_place_of_a_pair_is_where_it_is_pressed():
    """The mean of the contact points by their forces: of a disk beside which others are near."""
    disk = add_disk((0, 0, 0), zeta=0.1)
    floor = add_wall(-RADIUS, 1)
    ready()
    disk.state.vel = (0, -0.3, 0)
    while sg.integrator().activeContacts < 3:
        run(1)
    interaction = O.interactions[disk.id, floor.id]
    contacts = interaction.geom.contacts()
    weights = (contacts["force"] * contacts["normal"]).sum(axis=1)
    expected = weights @ contacts["point"] / weights.sum()
    assert list(interaction.geom.contactPoint) == pytest.approx(list(expected), abs=1e-4 * RADIUS)


@pytest.mark.parametrize("zeta", (0.11, 0.25))
def test_disk_rolls_off_a_table(zeta):
    """Top and upright end of it are facets: what is above one is not behind the other."""
    material = FrictMat(frictionAngle=0.4)
    add_facets((-8, 0), (0, 0), material)
    add_facets((0, -2), (0, 0), material)
    soft = soft_material(young=1e5, massDamping=1000, frictionAngle=0.4)
    grain = add_disk((-0.5 * RADIUS, RADIUS, 0), material=soft, zeta=zeta)
    grain.state.vel = (0.1, 0, 0)
    ready(gravity=(0, -9.81, 0))
    while grain.state.pos[1] > -RADIUS:
        run(10)
    assert sg.integrator().largestOverlap < 0.05
    assert grain.state.vel[0] > 0.1


@pytest.mark.parametrize("floor", ("box", "facets"))
@pytest.mark.parametrize("zeta, error", [(0.11, 0.02), (0.25, 0.04)])
def test_disk_slides_off_the_end_of_a_floor(floor, zeta, error):
    """Without friction, as a point on a circle about the edge that starts with v0: it lifts off
    where cos a = 2/3 + v0^2/(3 g R), at v^2 = g R cos a, and the edge does not turn it. (A coarse
    one rocks on its nodes before.)"""
    material, v0, g = FrictMat(frictionAngle=0), 0.08, 9.81
    if floor == "box":
        size = (4 * RADIUS, RADIUS, WIDE)
        O.bodies.append(utils.box((-4 * RADIUS, -RADIUS, 0), size, fixed=True, material=material))
    else:
        add_facets((-8, 0), (0, 0), material)
    soft = soft_material(young=1e5, massDamping=1000, frictionAngle=0)
    grain = add_disk((-0.8 * RADIUS, RADIUS, 0), material=soft, zeta=zeta)
    grain.state.vel = (v0, 0, 0)
    O.trackEnergy = True
    ready(gravity=(0, -g, 0))
    while grain.state.pos[0] < 0:
        run(1)
    spin = grain.state.angVel[2]
    while grain.state.pos[1] > -RADIUS:
        run(1)
    cosine = 2 / 3 + v0**2 / (3 * g * RADIUS)
    assert grain.state.vel[0] == pytest.approx(math.sqrt(g * RADIUS * cosine) * cosine, rel=error)
    assert grain.state.angVel[2] == pytest.approx(spin, abs=1)  # rad/s
    assert sg.integrator().largestOverlap < 0.01
    assert sg.integrator().energy()["impact"] > -1e-4 * grain.state.mass * g * RADIUS


def test_cube_tips_over_the_end_of_a_floor_of_facets():
    """The side of it that turns up above the floor is not behind that."""
    add_facets((-8, 0), (0, 0), FrictMat(frictionAngle=0))
    soft = soft_material(young=1e5, massDamping=1000, frictionAngle=0)
    grain = sg.soft_block((-1.2 * RADIUS, RADIUS, 0), (RADIUS,) * 3, soft, zeta=0.3)
    O.bodies.append(grain)
    grain.state.vel = (0.1, 0, 0)
    ready(gravity=(0, -9.81, 0))
    while grain.state.pos[1] > -0.5 * RADIUS:
        run(1)
    assert sg.integrator().largestOverlap < 0.02


@pytest.mark.parametrize(
    "angle, speed, damping, spin", [(3.722, 0.078, 200, -19.47), (2.975, 0.314, 0, -5.01)]
)
def test_corner_that_is_squeezed_flat(angle, speed, damping, spin):
    """Both sides of it lie along the floor then, which it does not come through."""
    angles = [2 * math.pi * k / 3 + angle for k in range(3)]
    vertices = [
        (1.2 * RADIUS * math.cos(a), RADIUS * (1.5 + 1.2 * math.sin(a))) for a in angles
    ]
    friction = math.atan(0.5)
    soft = soft_material(young=1e5, poisson=0.3, massDamping=damping, frictionAngle=friction)
    grain = sg.soft_polygon(vertices, soft, zeta=0.15)
    O.bodies.append(grain)
    add_facets((-20, 0), (20, 0), FrictMat(frictionAngle=friction))
    grain.state.vel, grain.state.angVel = (speed, -0.3, 0), (0, 0, spin)
    ready(gravity=(0, -9.81, 0))
    sg.set_time_step(0.85)
    while O.time < 0.06:
        run(1)
        assert grain.shape.outline()[:, 1].min() > -0.01 * RADIUS
