"""Corners in containers of facets and boxes, and what lies on their seams."""

import math
import random

import pytest
from scenes import RADIUS, add, add_wall, facet_strip, ready, run, soft_material
from yade import FrictMat, O, geom, utils

import softgrain as sg


def add_block(dim, clearance, zeta):
    """A block of sides 2 RADIUS, so far from the planes x = 0, y = 0 (z = 0)."""
    place = [RADIUS + clearance] * dim + [0.0] * (3 - dim)
    material = soft_material(massDamping=2000)
    return add(sg.soft_block(place, (2 * RADIUS,) * dim, material, zeta=zeta))


@pytest.mark.parametrize("clearance", (0, 1e-4, 0.02))
@pytest.mark.parametrize("dim, zeta", ((2, 0.25), (3, 0.5)))
def test_block_between_two_boxes_that_abut(dim, zeta, clearance):
    """The floor begins where the side of the other box is. The block is pressed into the corner:
    both bear it, and it keeps within them."""
    grain = add_block(dim, clearance * RADIUS, zeta)
    if dim == 3:
        grain.state.pos[2] = 0
    boxes = (
        ((2 * RADIUS, -RADIUS, 0), (2 * RADIUS, RADIUS, 5 * RADIUS)),
        ((-RADIUS, RADIUS, 0), (RADIUS, 2 * RADIUS, 5 * RADIUS)),
    )
    floor, side = O.bodies.append(
        [utils.box(*box, material=FrictMat(frictionAngle=0), fixed=True) for box in boxes]
    )
    ready(gravity=(-20, -50, 0))
    run(6000)
    weight = 50 * grain.state.mass
    assert O.forces.f(floor)[1] == pytest.approx(-weight, rel=0.01)
    assert O.forces.f(side)[0] == pytest.approx(-0.4 * weight, rel=0.01)
    lowest = grain.shape.outline()[:, :2].min(axis=0)
    assert (lowest > -0.005 * zeta * RADIUS).all()


def squeezed(kind, dim, zeta):
    """Force on a lid that comes down by 3 % onto a block that fills a container."""
    O.reset()
    add_block(dim, 1e-5 * RADIUS, zeta)
    material = FrictMat(frictionAngle=0)
    if kind == "walls":
        for axis in range(dim):
            for place, sense in ((0, 1), (2.00002 * RADIUS, -1)):
                if axis != 1 or place == 0:
                    add_wall(place, axis=axis, sense=sense)
    else:
        extents = [1.00001 * RADIUS, 2 * RADIUS, 1.00001 * RADIUS if dim == 3 else 3 * RADIUS]
        center = [extents[0], extents[1], extents[2] if dim == 3 else 0]
        mask = 1 + 2 + 4 + (16 + 32 if dim == 3 else 0)  # all but the lid
        O.bodies.append(geom.facetBox(center, extents, wallMask=mask, material=material))
    lid = add_wall(2.00002 * RADIUS, axis=1, sense=-1)
    lid.state.vel = (0, -0.05, 0)
    ready()
    while lid.state.pos[1] > 1.94 * RADIUS:
        run(1)
    lid.state.vel = (0, 0, 0)
    run(1500)
    return sg.wall_force(lid.id)[1]


@pytest.mark.parametrize("dim, zeta", ((2, 0.25), (3, 0.5)))
def test_container_of_facets_holds_a_block_as_walls_do(dim, zeta):
    assert squeezed("facets", dim, zeta) == pytest.approx(squeezed("walls", dim, zeta), rel=3e-3)


def box_between(low, high):
    center = [(a + b) / 2 for a, b in zip(low, high)]
    half = [(b - a) / 2 for a, b in zip(low, high)]
    return utils.box((*center, 0), (*half, 1), material=FrictMat(frictionAngle=0.1), fixed=True)


def container(kind, width, height):
    """Floor and sides; boxes meet at their edges alone."""
    if kind == "facets":
        low, high = ((0, 0, 0), (width, 0, 0)), ((0, height, 0), (width, height, 0))
        material = FrictMat(frictionAngle=0.1)
        sides = (*zip(low, high), low)
        return [f for ends in sides for f in facet_strip(ends, (0, 0, 0.1), material)]
    boxes = [((-RADIUS, 0), (0, height)), ((width, 0), (width + RADIUS, height))]
    return [box_between(*ends) for ends in [*boxes, ((0, -RADIUS), (width, 0))]]


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("kind", ("facets", "boxes"))
def test_triangles_poured_into_a_container_stay_in_it(kind, seed):
    """Their sharp corners turn on the walls and come to the inside corners."""
    width, zeta, scatter = 6 * RADIUS, 0.3, random.Random(seed)
    O.bodies.append(container(kind, width, 20 * RADIUS))
    material = soft_material(poisson=0.3, frictionAngle=0.1, massDamping=500)
    for row in range(3):
        for column in range(2):
            x = (1.7 + 2.6 * column + 0.3 * scatter.random()) * RADIUS
            y, turn = (4 + 2.9 * row) * RADIUS, 3 * scatter.random()
            corners = [
                (x + 1.3 * RADIUS * math.cos(a), y + 1.3 * RADIUS * math.sin(a))
                for a in (turn, turn + 2.1, turn + 4.2)
            ]
            O.bodies.append(sg.soft_polygon(corners, material=material, zeta=zeta))
    ready(gravity=(0, -100, 0))
    while O.time < 0.05:
        run(50)
        for body in sg.soft_bodies():
            x, y = body.shape.outline()[:, :2].T / (zeta * RADIUS)
            assert min(x.min(), y.min(), width / (zeta * RADIUS) - x.max()) > -0.01


def area(kind):
    """That of a coarse ball on a floor, right above what the pieces of that share [m2]."""
    O.reset()
    O.bodies.append(sg.soft_sphere((0, 0, RADIUS), RADIUS, soft_material(), zeta=0.5))
    wide, material = 3 * RADIUS, FrictMat(frictionAngle=0)
    if kind == "wall":
        add_wall(0, axis=2, sense=1)
    elif kind == "facets":
        ends = [(wide, 0, 0), (0, wide, 0), (-wide, 0, 0), (0, -wide, 0)]
        for k in range(4):
            corners = [(0, 0, 0), ends[k], ends[(k + 1) % 4]]
            O.bodies.append(utils.facet(corners, material=material))
    else:
        half = wide / 2
        for x in (-half, half):
            for y in (-half, half):
                O.bodies.append(
                    utils.box((x, y, -half), (half,) * 3, material=material, fixed=True)
                )
    ready(gravity=(0, 0, -200))
    run(20)
    contacts = [i.geom.contacts() for i in O.interactions if i.isReal]
    return sum(c["area"].sum() for c in contacts)


@pytest.mark.parametrize("kind", ("facets", "boxes"))
def test_area_above_a_seam_counts_once(kind):
    assert area(kind) == pytest.approx(area("wall"), rel=1e-9)
