"""Shapes that a script exchanges while the bodies touch, for which YADE has chosen functors."""

import math

import numpy as np
from scenes import RADIUS, ZETA, add_disk, add_wall, ready, run
from yade import O, Box, Sphere, Wall

SINK = 0.01 * RADIUS  # overlap that walls and disks begin with [m]


def pressed_row(small=RADIUS, zeta=ZETA):
    """Two disks side by side on a floor, between walls that press them; returns the bodies of the
    floor and the disks."""
    floor = add_wall(0, axis=1, sense=1)
    first = add_disk((0, RADIUS - SINK, 0))
    gap = math.sqrt((RADIUS + small - SINK) ** 2 - (RADIUS - small) ** 2)
    second = add_disk((gap, small - SINK, 0), small, first.material, zeta=zeta)
    add_wall(-RADIUS + SINK, axis=0, sense=1)
    add_wall(gap + small - SINK, axis=0, sense=-1)
    ready()
    run(20)
    assert len(bearing()) == 5
    return floor, first, second


def bearing():
    """Pairs of bodies between which force acts."""
    return {
        tuple(sorted((i.id1, i.id2)))
        for i in O.interactions
        if i.isReal and i.phys.normalForce.norm() > 0
    }


def test_disks_exchange_shapes():
    """Each goes on with what it was given, and touches what it touched."""
    _, first, second = pressed_row()
    before = bearing()
    first.shape, second.shape = second.shape, first.shape
    run(5)
    assert bearing() == before


def test_disks_of_different_resolution_exchange_shapes():
    """Their order in the assembly with it, and which of them the nodes of contacts belong to."""
    _, first, second = pressed_row(zeta=0.2)
    before = bearing()
    first.shape, second.shape = second.shape, first.shape
    run(1)
    (pair,) = [i for i in O.interactions if {i.id1, i.id2} == {first.id, second.id}]
    places = np.array(pair.geom.contacts()["point"])[:, 0]
    assert abs(places - RADIUS).max() < 0.1 * RADIUS  # between them
    run(5)
    assert bearing() == before


def test_disks_of_different_sizes_exchange_shapes_and_places():
    """Contacts of the larger one know nodes that the smaller one does not have."""
    _, first, second = pressed_row(small=0.6 * RADIUS)
    first.shape, second.shape = second.shape, first.shape
    first.state.pos, second.state.pos = second.state.pos, first.state.pos
    run(5)
    assert (first.shape.radius, second.shape.radius) == (0.6 * RADIUS, RADIUS)
    assert bearing() == {(0, 1), (0, 2), (1, 2), (1, 4), (2, 3)}


def test_shape_of_an_erased_grain():
    _, first, second = pressed_row()
    position, shape = first.state.pos, first.shape
    O.bodies.erase(first.id)
    heir = add_disk(position, material=second.material)
    heir.shape = shape
    run(5)
    assert tuple(sorted((second.id, heir.id))) in bearing()


def test_a_floor_becomes_a_box_and_a_floor_again():
    floor, _, _ = pressed_row()
    before = bearing()
    floor.shape = Box(extents=(10 * RADIUS, RADIUS, 10 * RADIUS))
    floor.state.pos = (0, -RADIUS, 0)
    run(5)
    assert bearing() == before
    floor.shape = Wall(axis=1, sense=1)
    floor.state.pos = (0, 0, 0)
    run(5)
    assert bearing() == before


def test_a_sphere_becomes_a_wall():
    disk, floor = add_disk(), add_wall(0, axis=1)
    floor.shape = Sphere(radius=RADIUS)
    floor.state.pos = (0, -2 * RADIUS + SINK, 0)
    ready()
    run(5)
    assert bearing() == {(disk.id, floor.id)}
    floor.shape = Wall(axis=1)
    floor.state.pos = (0, -RADIUS + SINK, 0)
    run(5)
    assert bearing() == {(disk.id, floor.id)}
