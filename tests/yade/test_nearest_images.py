"""Pairs in a periodic cell meet in the images that are nearest, also where the cell or a body has
been put elsewhere since YADE's collider found them."""

import itertools

import numpy as np
import pytest
from motion import momentum
from partner_scenes import add_rigid_disk
from periodic_scenes import compress, flow, set_cell
from scenes import RADIUS, add_disk, ready, run, soft_material
from yade import Matrix3, O, Vector3, pack

import softgrain as sg

CELL = 5 * RADIUS


def nearest_way(bodies):
    """From the first body to the nearest image of the second."""
    cell = np.array(O.cell.hSize)
    apart = np.subtract(bodies[1].state.pos, bodies[0].state.pos)
    images = [cell @ (i, j, 0) for i, j in itertools.product(range(-3, 4), repeat=2)]
    return min((apart + image for image in images), key=np.linalg.norm)


def let_collide(bodies, steps):
    """The bodies fly at each other; the least distance of their centres over R."""
    way = nearest_way(bodies)
    for body, sign in zip(bodies, (1, -1)):
        body.state.vel = tuple(sign * 0.5 * way / np.linalg.norm(way))
    least = np.inf
    for _ in range(steps):
        run(1)
        least = min(least, np.linalg.norm(nearest_way(bodies)) / RADIUS)
    return least


def add_body(kind, place):
    return add_disk(place) if kind == "soft" else add_rigid_disk(place, RADIUS)


@pytest.mark.parametrize("kinds", ("soft soft", "soft rigid", "rigid rigid"))
@pytest.mark.parametrize("place", ((-0.375, -0.375), (0.375, 0.375)))
def test_bodies_meet_after_the_cell_has_flipped(kinds, place):
    """A sheared cell becomes one that leans the other way; `place`: of the second body, in base
    vectors."""
    O.periodic = True
    O.cell.hSize = Matrix3(CELL, 0.499 * CELL, 0, 0, CELL, 0, 0, 0, 1)
    x, y = place
    second = ((0.2 + x + 0.499 * y) * CELL, (0.2 + y) * CELL, 0)
    places = ((0.2 * CELL, 0.2 * CELL, 0), second)
    bodies = [add_body(kind, at) for kind, at in zip(kinds.split(), places)]
    O.engines = sg.engines(rigid="nonsmooth")
    O.dt = 2e-5
    run(2)
    O.cell.flipFlippable = True
    O.cell.homoDeform = 0
    O.cell.velGrad = Matrix3(0, 50, 0, 0, 0, 0, 0, 0, 0)
    run(60)
    assert O.cell.hSize[0, 1] < 0
    O.cell.velGrad = Matrix3.Zero
    assert let_collide(bodies, 1500) > 1.5


@pytest.mark.parametrize("kinds", ("soft soft", "soft rigid", "rigid rigid"))
@pytest.mark.parametrize("cell, jump", ((5, 0.158), (20, 0.795)))
def test_bodies_meet_after_one_was_put_elsewhere(kinds, cell, jump):
    """By no whole period; the pair that the collider knows is near on another side now."""
    set_cell(cell * RADIUS, cell * RADIUS)
    bodies = [add_body(kind, (x * RADIUS, 0, 0)) for kind, x in zip(kinds.split(), (1, 3.05))]
    O.engines = sg.engines(rigid="nonsmooth")
    O.dt = 2e-5
    run(3)
    bodies[1].state.pos += Vector3(jump * cell * RADIUS, 0, 0)
    assert let_collide(bodies, 2000) > 1.5


@pytest.mark.parametrize("kinds", ("soft soft", "soft rigid", "rigid soft", "rigid rigid"))
def test_bodies_that_are_wrapped_into_the_cell_meet(kinds):
    """By O.cell.wrap, as scripts do for pictures: apart, and again while they touch."""
    set_cell(10 * RADIUS, 10 * RADIUS)
    bodies = [add_body(kind, (x * RADIUS, 0, 0)) for kind, x in zip(kinds.split(), (9, 11.06))]
    O.engines = sg.engines(rigid="nonsmooth")
    O.dt = 2e-5
    bodies[1].state.vel = (-0.5, 0, 0)
    least, wrapped_in_contact = np.inf, False
    for step in range(1500):
        run(1)
        touches = any(i.isReal and np.linalg.norm(i.phys.normalForce) > 0 for i in O.interactions)
        if step == 5 or (touches and not wrapped_in_contact):
            wrapped_in_contact = touches
            for body in bodies:
                body.state.pos = O.cell.wrap(body.state.pos)
        least = min(least, np.linalg.norm(nearest_way(bodies)) / RADIUS)
    assert wrapped_in_contact and least > 1.5
    assert momentum()[0] == pytest.approx(-0.5 * bodies[1].state.mass, rel=1e-9)


def test_packing_that_is_sheared_through_flips_does_not_pass_through_itself():
    """Nine disks, in a cell of some three diameters."""
    side = 7.5 * RADIUS
    O.periodic = True
    O.cell.setBox(side, side, 1)
    cloud = pack.SpherePack()
    corner = (side, side, 0)
    cloud.makeCloud((0, 0, 0), corner, rMean=RADIUS, rRelFuzz=0.2, num=9, periodic=True, seed=1)
    for center, radius in cloud:
        add_disk(center, radius, soft_material(frictionAngle=0.3, massDamping=500))
    ready()
    compress(0.87, 4)
    O.cell.flipFlippable = True
    flow(xy=8)
    flips, least, before = 0, np.inf, 0.0
    while O.cell.trsf[0, 1] < 1.2:
        run(20)
        flips += O.cell.hSize[0, 1] < before - 0.3 * side
        before = O.cell.hSize[0, 1]
        for pair in itertools.combinations(sg.soft_bodies(), 2):
            radii = sum(body.shape.radius for body in pair)
            least = min(least, np.linalg.norm(nearest_way(pair)) / radii)
    assert flips and least > 0.7
