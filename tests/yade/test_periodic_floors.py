"""Rigid floors and obstacles in a periodic cell, which grains cross sideways."""

import math

import numpy as np
import pytest
from bodies import add, facet_strip
from periodic_scenes import set_cell
from scenes import DENSITY, RADIUS, add_disk, complaint, ready, run, soft_material
from yade import FrictMat, Matrix3, O, utils

import softgrain as sg

WIDTH, HEIGHT = 8 * RADIUS, 40 * RADIUS


def set_tall_cell():
    set_cell(WIDTH, HEIGHT)


def rigid(friction=0.3):
    return FrictMat(density=DENSITY, frictionAngle=math.atan(friction))


def box_floor(half_width, middle=0.5 * WIDTH, half_depth=0.5, friction=0.3):
    """A fixed Box, its upper side at y = 0."""
    half = (half_width, RADIUS, half_depth)
    return add(utils.box((middle, -RADIUS, 0), half, fixed=True, material=rigid(friction)))


def facet_floor(pieces, width=WIDTH):
    """Fixed facets one after the other along x, upper side at y = 0; each is two triangles."""
    points = [(k * width / pieces, 0, 0) for k in range(pieces + 1)]
    O.bodies.append(facet_strip(points, (0, 0, 0.1), rigid()))


def damped(**attributes):
    return soft_material(massDamping=200.0, frictionAngle=math.atan(0.3), **attributes)


def sliding_disk(velocity, material=None, height=1.001 * RADIUS):
    disk = add_disk((0.5 * WIDTH, height, 0), material=material)
    disk.state.vel = (velocity, 0, 0)
    return disk


@pytest.mark.parametrize("velocity", (3.0, -3.0))
def test_across_the_border_as_on_a_long_floor(velocity):
    """A disk that slides and rolls through several periods: as on a floor without a cell."""
    places = []
    for periodic in (False, True):
        O.reset()
        if periodic:
            set_tall_cell()
        box_floor(11 * RADIUS if periodic else 100 * RADIUS)
        disk = sliding_disk(velocity, soft_material(frictionAngle=0.3))
        ready(gravity=(0, -100, 0), tolerance=1e-8, maxSweeps=2000)
        run(2500)
        assert abs(disk.state.pos[0] - 0.5 * WIDTH) > 2 * WIDTH
        assert abs(disk.state.angVel[2]) > 1
        places.append(disk.shape.nodes())
    np.testing.assert_allclose(places[1], places[0], rtol=0, atol=1e-8 * RADIUS)


@pytest.mark.parametrize("form", ("round", "block"))
@pytest.mark.parametrize("kind", ("facets", "boxes"))
def test_seams_at_the_border_do_not_brake(kind, form):
    """Without friction, over a floor of eight pieces, two of which meet at the border, there and
    back."""
    set_tall_cell()
    if kind == "facets":
        facet_floor(8)
    else:
        for k in range(8):
            box_floor(0.5 * WIDTH / 8, middle=(k + 0.5) * WIDTH / 8)
    soft = soft_material(massDamping=100)
    middle = (0.5 * WIDTH, 0.999 * RADIUS, 0)
    if form == "block":
        body = sg.soft_block(middle, (2 * RADIUS, 2 * RADIUS), soft, zeta=0.3)
    else:
        body = sg.soft_disk(middle, RADIUS, soft, zeta=0.3)
    O.bodies.append(body)
    ready(gravity=(0, -50, 0))
    for speed in (3.0, -3.0):
        body.state.vel = (speed, body.state.vel[1], 0)
        begin, touched, steps = body.state.pos[0], 0, 0
        while abs(body.state.pos[0] - begin) < 2.2 * WIDTH:
            run(5)
            steps += 1
            touched += sg.integrator().activeContacts > 0
            assert body.state.vel[0] == pytest.approx(speed, rel=0.01), steps
        assert touched > 0.2 * steps


def weight_on(bodies):
    return sum(O.forces.f(b.id)[1] for b in bodies)


@pytest.mark.parametrize("floor", ("box", "facets"))
def test_disks_lie_on_a_floor(floor):
    """Some of them on the border; the floor bears their weight, and no grain is through it."""
    set_tall_cell()
    if floor == "box":
        box_floor(0.5 * WIDTH + 6 * RADIUS)
    else:
        facet_floor(4)
    for k in range(3):
        add_disk((2.6 * k * RADIUS + 0.2 * RADIUS, 1.001 * RADIUS, 0), material=damped())
        add_disk((2.6 * k * RADIUS + 1.5 * RADIUS, 2.9 * RADIUS, 0), material=damped())
    ready(gravity=(0, -50, 0))
    run(3000)
    rigid_bodies = [b for b in O.bodies if b not in sg.soft_bodies()]
    weights = []
    for _ in range(2000):
        O.step()
        weights.append(weight_on(rigid_bodies))
    weight = 50 * sum(b.state.mass for b in sg.soft_bodies())
    assert np.mean(weights) == pytest.approx(-weight, rel=0.01)
    outlines = [b.shape.outline() for b in sg.soft_bodies()]
    assert min(x[:, 1].min() for x in outlines) > -1e-3 * RADIUS
    borders = [
        x
        for x in outlines
        if math.floor(x[:, 0].min() / WIDTH) != math.floor(x[:, 0].max() / WIDTH)
    ]
    assert borders
    assert sg.integrator().largestOverlap < 0.2


def test_stress_above_a_floor():
    """Where the centre of the floor lies does not matter: the integral over the grains."""
    set_tall_cell()
    box_floor(half_width=7 * RADIUS, middle=0.7 * WIDTH)
    for row in range(3):
        for k in range(4):
            x = (2 * k + 1 + row % 2) * RADIUS
            disk = add_disk((x, (1 + 1.74 * row) * RADIUS, 0), material=damped())
            if row == 2:
                O.forces.setPermF(disk.id, (20, -200, 0))
    ready()
    run(6000)
    points = [b.shape.points() for b in sg.soft_bodies()]
    grains = sum(np.einsum("p,pij->ij", p["volume"], p["cauchy"]) for p in points)
    expected = grains / sg.cell_volume()
    plane = np.ix_([0, 1], [0, 1])
    found, scale = sg.cell_stress()[plane], 800 / WIDTH
    np.testing.assert_allclose(found, expected[plane], rtol=0, atol=2e-3 * scale)


def test_a_ball_crosses_the_border_on_a_floor():
    """3D, a floor along two borders: after several periods the ball still slides on it."""
    set_cell(WIDTH, HEIGHT, WIDTH)
    floor = box_floor(12 * RADIUS, half_depth=12 * RADIUS, friction=0)
    ball = sg.soft_sphere((0.5 * WIDTH, 1.001 * RADIUS, 0), RADIUS, soft_material(), zeta=0.5)
    O.bodies.append(ball)
    ball.state.vel = (5.0, 0, 7.0)
    ready(gravity=(0, -100, 0))
    run(1200)
    assert ball.state.pos[0] > 1.5 * WIDTH and ball.state.pos[2] > 1.5 * WIDTH
    assert 0.9 * RADIUS < ball.state.pos[1] < 1.1 * RADIUS
    np.testing.assert_allclose(ball.state.vel[0], 5.0, rtol=1e-9)
    assert floor.state.pos[0] == 0.5 * WIDTH


def test_an_obstacle_of_half_the_cell():
    """A rigid disk of 0.6 of the cell is met on both sides, whichever of the two was first."""
    for soft_first in (True, False):
        O.reset()
        set_cell(WIDTH, WIDTH)
        sphere = utils.sphere((0.5 * WIDTH, 0, 0), 0.3 * WIDTH, fixed=True, material=rigid(0))

        def add_soft():
            return add_disk((0.5 * WIDTH + 3.6 * RADIUS, 0, 0), material=soft_material())

        if soft_first:
            disk = add_soft()
        O.bodies.append(sphere)
        if not soft_first:
            disk = add_soft()
        sg.as_disks()
        disk.state.vel = (1.0, 0, 0)
        ready()
        turns, last = 0, 1.0
        for _ in range(2000):
            O.step()
            turns += last * disk.state.vel[0] < 0
            last = disk.state.vel[0]
            offset = (disk.state.pos[0] - 0.5 * WIDTH) % WIDTH
            assert 3.2 * RADIUS < offset < 4.8 * RADIUS
        assert turns >= 3


def with_a_disk_on(add_floor, *arguments):
    """A soft disk on a floor in a periodic cell; returns what ``add_floor`` does."""
    set_tall_cell()
    floor = add_floor(*arguments)
    sliding_disk(0)
    ready()
    return floor


@pytest.mark.parametrize("half", (0.4 * WIDTH, 0.5 * WIDTH, 0.6 * WIDTH))
def test_a_floor_with_ends_is_refused(half):
    floor = with_a_disk_on(box_floor, half)
    message = complaint()
    assert f"rigid body #{floor.id} (Box) spans" in message
    assert "it might touch a soft grain on two sides" in message


def test_a_tilted_floor_is_refused():
    floor = with_a_disk_on(box_floor, 2 * WIDTH)
    floor.state.ori = utils.Quaternion((0, 0, 1), 0.01)
    assert "for a Box with a side along that base vector" in complaint()


def test_a_long_facet_is_refused():
    with_a_disk_on(facet_floor, 1, 3 * WIDTH)
    assert "(Facet) spans" in complaint()


def test_a_sort_along_the_floor_is_refused():
    floor = with_a_disk_on(box_floor, 2 * WIDTH)
    assert O.engines[1].sortAxis == 1
    O.engines[1].sortAxis = 0
    message = complaint()
    assert "sortAxis = 0" in message and f"#{floor.id} is longer than the periodic cell" in message


def test_a_floor_in_a_cell_that_shrinks_along_it_is_refused():
    with_a_disk_on(box_floor, 2 * WIDTH)
    O.cell.velGrad = Matrix3(0, 0, 0, 0, -1, 0, 0, 0, 0)
    O.step()
    O.cell.velGrad = Matrix3(-1, 0, 0, 0, 0, 0, 0, 0, 0)
    assert "does not move nor change" in complaint()


def test_a_box_in_a_sheared_cell_is_refused():
    """YADE would end the process."""
    box = with_a_disk_on(box_floor, 2 * WIDTH)
    O.step()
    O.cell.velGrad = Matrix3(0, 1, 0, 0, 0, 0, 0, 0, 0)
    assert f"body #{box.id} is a Box in a sheared periodic cell" in complaint()
    O.cell.velGrad = Matrix3.Zero
    O.cell.hSize = Matrix3(WIDTH, RADIUS, 0, 0, HEIGHT, 0, 0, 0, 1)
    with pytest.raises(ValueError, match=f"#{box.id} is a Box in a sheared periodic cell"):
        sg.set_time_step()
