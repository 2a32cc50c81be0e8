"""Clumps, facets, boxes and balls in space as rigid partners of soft grains."""

import numpy as np
import pytest
from bodies import add, add_wall, facet_strip
from motion import angular_momentum, momentum
from partner_scenes import (
    add_clump,
    assert_comes_to_rest,
    bed_of_grains,
    box_strip,
    facets_along,
    rest_material,
    rigid_material,
)
from scenes import RADIUS, WIDE, add_disk, ready, run, soft_material
from yade import FrictMat, O, Quaternion, Vector3, utils

import softgrain as sg


def test_clump_keeps_the_momenta():
    disk = add_disk(material=soft_material(frictionAngle=0.5))
    disk.state.vel = (2, 0, 0)
    r = 0.4 * RADIUS
    clump = add_clump([(1.45 * RADIUS, 0, 0), (1.45 * RADIUS, 2 * r, 0)], r)
    ready()
    run(1)
    before = momentum()
    start = angular_momentum()
    run(300)
    np.testing.assert_allclose(momentum(), before, rtol=0, atol=1e-13 * before[0])
    assert abs(clump.state.angVel[2]) > 10
    scale = disk.state.mass * 2 * RADIUS
    assert angular_momentum() == pytest.approx(start, abs=0.02 * scale)


def test_clump_rests_on_soft_grains():
    bed_of_grains()
    r = 0.3 * RADIUS
    clump = add_clump([(x * RADIUS, (1 + 0.3) * RADIUS, 0) for x in (-0.9, -0.3, 0.3, 0.9)], r)
    assert_comes_to_rest(clump, clump.shape.members)


@pytest.mark.parametrize("kind", ("facets", "boxes"))
def test_container(kind):
    """A grain thrown into a container comes to rest on its floor, whose reaction is the weight."""
    disk = add_disk(material=rest_material())
    disk.state.vel, disk.state.angVel = (0.5, 0.2, 0), (0, 0, 20)
    half = 1.05 * RADIUS
    if kind == "facets":
        # the floor of two pieces: the grain lies on their seam
        ends = [(-half, half), (-half, -half), (0, -half), (half, -half), (half, half)]
        bodies = facets_along(ends)
    else:
        bodies = box_strip()
    ids = O.bodies.append(bodies)
    ready(gravity=(0, -10, 0))
    run(8000)
    total, steps = np.zeros(3), 2000
    for _ in range(steps):
        run(1)
        total += sum(np.array(O.forces.f(i)) for i in ids)
        assert np.abs(disk.shape.outline()[:, :2]).max() < half + 0.05 * RADIUS
    weight = 10 * disk.state.mass
    # it still rolls to and fro a little: rolling is not damped
    np.testing.assert_allclose(total / steps, (0, -weight, 0), atol=0.05 * weight)
    assert sg.integrator().largestOverlap < 0.2


def test_turned_box_carries():
    """A free box, turned by 30 degrees, is hit and turns on."""
    disk = add_disk(material=soft_material(frictionAngle=0.5))
    disk.state.vel = (1, 0, 0)
    box = utils.box(
        (1.9 * RADIUS, 0.4 * RADIUS, 0),
        (0.5 * RADIUS, 0.8 * RADIUS, RADIUS),
        orientation=Quaternion((0, 0, 1), 0.5),
        fixed=False,
        material=rigid_material(0.5),
    )
    box.state.blockedDOFs = "zXY"
    box.state.mass, box.state.inertia = 0.3, (1e-5, 1e-5, 1e-5)
    O.bodies.append(box)
    ready()
    run(1)
    before = momentum()
    run(400)
    np.testing.assert_allclose(momentum(), before, rtol=0, atol=1e-13 * before[0])
    assert box.state.vel[0] > 0.2 and abs(box.state.angVel[2]) > 1
    assert sg.integrator().cappedSteps == 0


def squeezed_between_boxes(half, dim):
    """Forces on two boxes of that half thickness that squeeze a grain by a tenth."""
    O.reset()
    material = soft_material(massDamping=3000)
    axis = dim - 1
    if dim == 2:
        add_disk(material=material)
    else:
        O.bodies.append(sg.soft_sphere((0, 0, 0), RADIUS, material, zeta=0.4, nodeSpacing=2))
    extents = [3 * RADIUS] * 3
    extents[axis] = half
    plates = []
    for side in (-1, 1):
        place = [0, 0, 0]
        place[axis] = side * (RADIUS + half)
        plate = utils.box(place, extents, fixed=True, material=rigid_material())
        O.bodies.append(plate)
        plates.append(plate)
    velocity = [0, 0, 0]
    velocity[axis] = -0.5
    plates[1].state.vel = velocity
    ready()
    while plates[1].state.pos[axis] - half > 0.8 * RADIUS:
        run(5)
    return [O.forces.f(plate.id)[axis] for plate in plates]


@pytest.mark.parametrize("dim", (2, 3))
def test_thin_boxes_bear_as_thick_ones(dim):
    """Nodes are behind a box that is thinner than they overlap it."""
    thick = squeezed_between_boxes(0.5 * RADIUS, dim)
    assert -thick[0] > 0 and thick[1] > 0
    for half in (0.01 * RADIUS, 1e-4 * RADIUS, 1e-9 * RADIUS, 0):
        np.testing.assert_allclose(squeezed_between_boxes(half, dim), thick, rtol=1e-3)


@pytest.mark.parametrize("low, high", ((-WIDE, WIDE), (-WIDE, 0), (0, WIDE)))
def test_facets_from_the_plane_on_bear(low, high):
    """A floor drawn in the plane of the grains may be extruded to either side."""
    disk = add_disk((0, 0.99 * RADIUS, 0))
    ends = [(x * RADIUS, 0, (low + high) / 2) for x in (-5, 5)]
    across = (0, 0, (high - low) / 2)
    ids = O.bodies.append(facet_strip(ends, across, FrictMat(frictionAngle=0)))
    ready()
    O.step()
    assert sum(O.forces.f(i)[1] for i in ids) < 0
    run(500)
    assert disk.state.pos[1] > 0.995 * RADIUS


def test_box_turned_out_of_the_plane_is_refused():
    add_disk()
    box = utils.box(
        (1.3 * RADIUS, 0, 0), (0.5 * RADIUS,) * 3, orientation=Quaternion((1, 0, 0), 0.5)
    )
    O.bodies.append(box)
    ready()
    with pytest.raises(RuntimeError, match="turn it about z only"):
        run(2)


def test_three_dimensions():
    """A free sphere falls on a soft ball in a box of facets."""
    add(sg.soft_sphere((0, 0, 0), RADIUS, rest_material(), zeta=0.4))
    ends = [(x, 0, -RADIUS) for x in (-1, 1)]
    O.bodies.append(facet_strip(ends, (0, 1, 0), rigid_material()))
    rigid = utils.sphere((0, 0, 1.62 * RADIUS), 0.6 * RADIUS, material=rigid_material())
    rigid.state.vel = (0.02, 0, -0.5)
    O.bodies.append(rigid)
    ready(gravity=(0, 0, -10))
    touched = 0
    for _ in range(200):
        velocity = np.array(rigid.state.vel)
        run(1)
        force = np.array(O.forces.f(rigid.id))
        touched += force[2] > 0
        expected = O.dt * (force / rigid.state.mass + np.array((0, 0, -10)))
        np.testing.assert_allclose(
            np.array(rigid.state.vel) - velocity, expected, rtol=0, atol=1e-13
        )
    assert touched > 10
    assert rigid.state.vel[2] > -0.3


def edge_of_box():
    half = 2 * RADIUS
    box = utils.box((0, 0, -(2**0.5) * half), (half, 5 * RADIUS, half), fixed=True)
    box.state.ori = Quaternion((0, 1, 0), np.pi / 4)
    return [box]


def edge_of_thin_box():
    half = 2 * RADIUS
    return [utils.box((0, 0, -half), (1e-3 * RADIUS, 5 * RADIUS, half), fixed=True)]


def edge_of_box_without_thickness():
    half = 2 * RADIUS
    return [utils.box((0, 0, -half), (0, 5 * RADIUS, half), fixed=True)]


def edge_of_facet():
    return [
        utils.facet([(0, -5 * RADIUS, 0), (0, 5 * RADIUS, 0), (0, 0, -10 * RADIUS)], fixed=True)
    ]


def ridge_of_facets():
    a, b = (0, -5 * RADIUS, 0), (0, 5 * RADIUS, 0)
    return [
        utils.facet([a, b, (side * 9 * RADIUS, 0, -9 * RADIUS)], fixed=True) for side in (-1, 1)
    ]


@pytest.mark.parametrize(
    "edge",
    (
        edge_of_box,
        edge_of_thin_box,
        edge_of_box_without_thickness,
        edge_of_facet,
        ridge_of_facets,
    ),
)
@pytest.mark.parametrize("aside", (0, 0.1))
def test_edge_in_space_carries(edge, aside):
    """A stiff ball laid on an edge, the nodes of its outline as they come, rests there (aside: it
    rolls off, about the edge)."""
    material = soft_material(young=1e7, massDamping=1000, frictionAngle=0.4)
    ball = sg.soft_sphere((aside * RADIUS, 0, 1.01 * RADIUS), RADIUS, material, zeta=0.3)
    ball.state.ori = Quaternion((1, 2, 3), 0.7)
    O.bodies.append([ball, *edge()])
    ready(gravity=(0, 0, -9.81))
    while O.time < 0.03:
        run(20)
        place = ball.state.pos / RADIUS
        assert np.hypot(place[0], place[2]) == pytest.approx(1, abs=0.025)
    assert sg.integrator().largestOverlap < 0.02


def upright_facet():
    return utils.facet([(0, 0, -0.02), (0, 0, 0.02), (0, -0.05, 0)], material=rigid_material(0.4))


def upright_thin_box():
    extents = (1e-3 * RADIUS, 0.02, 0.02)
    return utils.box((0, -0.02, 0), extents, fixed=True, material=rigid_material(0.4))


def upright_box_without_thickness():
    return utils.box((0, -0.02, 0), (0, 0.02, 0.02), fixed=True, material=rigid_material(0.4))


@pytest.mark.parametrize(
    "plate", (upright_facet, upright_thin_box, upright_box_without_thickness)
)
@pytest.mark.parametrize("aside", (0, 0.0625, 0.125, 0.25))
def test_plate_that_pokes_into_a_disk(plate, aside):
    """Upright beneath a soft disk: nodes beside its tip are not taken for overlaps of its side."""
    O.bodies.append(plate())
    soft = soft_material(young=1e5, poisson=0.4, massDamping=50, frictionAngle=0.4)
    disk = add_disk((aside * RADIUS, 1.06 * RADIUS, 0), RADIUS, soft, zeta=0.2)
    ready(gravity=(0, -9.81, 0))
    while O.time < 0.05:
        run(20)
    assert sg.integrator().largestOverlap < 0.01
    assert 0.5 * RADIUS < disk.state.pos[1] < 1.06 * RADIUS


@pytest.mark.parametrize(
    "zeta, angle, slower", ((0.3, 10, 0.22), (0.25, 20, 0.09), (0.2, 20, 0.06))
)
def test_coarse_balls_roll_too_slowly(zeta, angle, slower):
    """By what the guide says, against 5/7 g sin: the wall meets nodes."""
    material = soft_material(young=1e6, poisson=0.3, massDamping=1000, frictionAngle=0.8)
    ball = add(sg.soft_sphere((0, 0, RADIUS), RADIUS, material, zeta=zeta))
    add_wall(0, axis=2, friction=1, sense=1)
    along, down = 9.81 * np.sin(np.radians(angle)), 9.81 * np.cos(np.radians(angle))
    ready(gravity=(along, 0, -down))
    times, speeds = [], []
    while O.time < 0.15:
        run(10)
        times.append(O.time)
        speeds.append(ball.state.vel[0])
    settled = len(times) // 3
    acceleration = np.polyfit(times[settled:], speeds[settled:], 1)[0]
    assert 1 - acceleration / (5 / 7 * along) == pytest.approx(slower, abs=0.03)


def add_floor(kind, dim):
    """Coplanar facets or boxes one radius long, without friction; its upper side is at 0."""
    material, up = rigid_material(0), 1 if dim == 2 else 2
    for begin in np.arange(-2, 9) * RADIUS:
        if kind == "boxes":
            center, half = Vector3(begin + 0.5 * RADIUS, 0, 0), Vector3(1, 1, 1) * 5 * RADIUS
            center[up], half[0] = -half[up], 0.5 * RADIUS
            O.bodies.append(utils.box(center, half, fixed=True, material=material))
            continue
        ends = [(x, 0, 0) for x in (begin, begin + RADIUS)]
        across = np.eye(3)[3 - up] * 5 * RADIUS
        O.bodies.append(facet_strip(ends, across, material))


@pytest.mark.parametrize("form", ("round", "block"))
@pytest.mark.parametrize("dim", (2, 3))
@pytest.mark.parametrize("kind", ("facets", "boxes"))
def test_a_floor_of_pieces_does_not_brake(kind, dim, form):
    """Without friction, over the seams of coplanar facets or boxes, one every radius."""
    add_floor(kind, dim)
    soft = soft_material(young=1e5, poisson=0.3, massDamping=100)
    center = Vector3(0, 0.997 * RADIUS, 0) if dim == 2 else Vector3(0, 3e-4, 0.997 * RADIUS)
    if form == "block":
        make, size = sg.soft_block, (2 * RADIUS,) * dim
    else:
        make, size = (sg.soft_disk if dim == 2 else sg.soft_sphere), RADIUS
    body = make(center, size, soft, zeta=0.3)
    O.bodies.append(body)
    body.state.vel = (0.5, 0, 0)
    ready(gravity=(0, -9.81, 0) if dim == 2 else (0, 0, -9.81))
    touched = 0
    while body.state.pos[0] < 5 * RADIUS:
        run(5)
        touched += sg.integrator().activeContacts > 0
        assert body.state.vel[0] > 0.4
    assert touched > 50
    assert body.state.vel[0] == pytest.approx(0.5, rel=1e-3)


@pytest.mark.parametrize("step, passes", ((0.01, True), (0.5, False)))
def test_a_step_of_the_floor_stops(step, passes):
    """A block comes to the edge of a facet that lies higher, by so many point spacings."""
    soft = soft_material(young=1e5, poisson=0.3, massDamping=100)
    height = step * 0.3 * RADIUS
    for begin, end, level in ((-5, 1.5, 0), (1.5, 5, height)):
        ends = [(x * RADIUS, level, 0) for x in (begin, end)]
        O.bodies.append(facet_strip(ends, (0, 0, RADIUS), rigid_material(0)))
    body = sg.soft_block((0, 0.997 * RADIUS, 0), (2 * RADIUS, 2 * RADIUS), soft, zeta=0.3)
    O.bodies.append(body)
    body.state.vel = (0.2, 0, 0)
    ready(gravity=(0, -9.81, 0))
    while O.time < 0.06:
        run(1)
    assert (body.state.pos[0] > RADIUS) == passes
