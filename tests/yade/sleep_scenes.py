"""Grains at rest on floors and between walls: what the tests of sleep share."""

import math

import numpy as np
import pytest
from scenes import RADIUS, add_disk, add_wall, ready, run, soft_material
from yade import FrictMat, NewtonIntegrator, O, utils

import softgrain as sg

GRAVITY = 1000.0  # m/s^2: weight over modulus 0.02, so that grains come to rest soon


def newton():
    return next(engine for engine in O.engines if isinstance(engine, NewtonIntegrator))


def wall_below():
    add_wall(-RADIUS, 1, friction=0.3)


def rough():
    return FrictMat(frictionAngle=math.atan(0.3))


def box_below():
    center, half = (RADIUS, -2 * RADIUS, 0), (5 * RADIUS, RADIUS, RADIUS)
    O.bodies.append(utils.box(center, half, fixed=True, material=rough()))


def facet_below():
    low = (-9 * RADIUS, -RADIUS, -9 * RADIUS)
    corners = (low, (30 * RADIUS, *low[1:]), (*low[:2], 30 * RADIUS))
    O.bodies.append(utils.facet(corners, material=rough()))


FLOORS = (wall_below, box_below, facet_below)
on_all_floors = pytest.mark.parametrize("floor", FLOORS, ids=lambda floor: floor.__name__)


def heap(damping=4000.0, floor=wall_below, **engine):
    """Two disks on a floor (body #3) between walls and a third upon them; returns the disks."""
    O.reset()
    material = soft_material(massDamping=damping, frictionAngle=math.atan(0.3))
    places = ((0, 0, 0), (2.1 * RADIUS, 0, 0), (1.05 * RADIUS, 1.8 * RADIUS, 0))
    disks = [add_disk(place, material=material) for place in places]
    floor()
    add_wall(-1.05 * RADIUS, 0, friction=0.3)
    add_wall(3.15 * RADIUS, 0, friction=0.3)
    ready(gravity=(0, -GRAVITY, 0), **engine)
    O.trackEnergy = True
    return disks


def asleep():
    return [body.shape.isAsleep() for body in sg.soft_bodies()]


def rest():
    """Run until all sleep."""
    while not all(asleep()):
        run(1)
        assert O.iter < 30000


def all_wake(most=500):
    """Who was touched is awake now, and soon are all who feel it."""
    assert not all(asleep())
    began = O.iter
    while any(asleep()):
        run(1)
        assert O.iter - began < most


def forces():
    """And torques over the radius, on all bodies, as YADE shows them after a step."""
    return np.array([[*O.forces.f(b.id), *(O.forces.t(b.id) / RADIUS)] for b in O.bodies])
