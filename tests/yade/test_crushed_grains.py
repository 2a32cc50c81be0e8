"""Soft grains crushed fast by stiff ones: corners bend, outlines fold, and a node bears where it
lies against the other outline all the same."""

import math

import numpy as np
import pytest
from scenes import RADIUS, add_wall, soft_material
from yade import O, Quaternion

import softgrain as sg

SPACING = 2.2 * RADIUS
MANY = 4  # grains along each side
FRICTION = 0.3


def make_block(place, radius, random, **look):
    sides = 1.4 * radius, 1.4 * radius * random.uniform(0.3, 1)
    block = sg.soft_block(place, sides, **look)
    block.state.ori = Quaternion((0, 0, 1), random.uniform(0, 2 * math.pi))
    return block


def make_disk(place, radius, random, **look):
    return sg.soft_disk(place, radius, **look)


def make_superdisk(place, radius, random, **look):
    half_axes = radius, radius * random.uniform(0.5, 1)
    exponent, angle = random.choice([1.3, 3, 6]), random.uniform(0, 2 * math.pi)
    return sg.soft_superdisk(place, half_axes, exponent, angle, **look)


def add_grains(make, random):
    material = {"poisson": 0.4, "frictionAngle": math.atan(FRICTION)}
    materials = [soft_material(young=young, **material) for young in (1e5, 1e7)]
    O.materials.append(materials)
    for k in range(MANY**2):
        x, y = (k // MANY + 0.5) * SPACING, (k % MANY + 0.5) * SPACING
        look = dict(material=materials[random.integers(2)], zeta=random.choice([0.2, 0.3]))
        body = make((x, y, 0), RADIUS * random.uniform(0.75, 1), random, **look)
        body.state.vel = (*random.uniform(-1, 1, 2), 0)
        O.bodies.append(body)


def add_closing_walls(speed):
    for axis in (0, 1):
        add_wall(0, axis, FRICTION, sense=1)
        add_wall(MANY * SPACING, axis, FRICTION, velocity=-speed, sense=-1)


def signed_distance(x, polygon):
    """From a polygon, negative inside [m]."""
    start, end = polygon, np.roll(polygon, -1, axis=0)
    way = end - start
    share = np.clip(((x - start) * way).sum(axis=1) / (way**2).sum(axis=1), 0, 1)
    distance = np.linalg.norm(x - start - share[:, None] * way, axis=1).min()
    crossed = (start[:, 1] > x[1]) != (end[:, 1] > x[1])
    to_right = start[crossed, 0] + (x[1] - start[crossed, 1]) * (way[:, 0] / way[:, 1])[crossed]
    return distance if (to_right > x[0]).sum() % 2 == 0 else -distance


def farthest_that_bears(outlines):
    """Distance of a contact node that bore force in this step from the other grain, in dr."""
    farthest = 0
    for i in O.interactions:
        if not i.isReal or not {i.id1, i.id2} <= set(outlines):
            continue
        contacts = i.geom.contacts()
        grains = i.geom.first, i.id1 + i.id2 - i.geom.first
        dr = np.mean([O.bodies[k].shape.zeta * O.bodies[k].shape.radius for k in grains])
        for k in np.flatnonzero(np.linalg.norm(contacts["force"], axis=1)):
            side = contacts["side"][k]
            x = outlines[grains[side]][contacts["node"][k]]
            farthest = max(farthest, signed_distance(x, outlines[grains[1 - side]]) / dr)
    return farthest


def crush(make, seed, steps=1300):
    """The farthest node that bore in one of the sampled steps, in dr. (Without the rules for bends
    and folds three of the runs with blocks stop; nodes bore at 0.4 to 0.9 dr.)"""
    O.reset()
    add_grains(make, np.random.default_rng(seed))
    add_closing_walls(speed=6)
    O.engines = sg.engines()
    farthest = 0
    for step in range(steps):
        before = {b.id: b.shape.outline() for b in sg.soft_bodies()} if step % 10 == 0 else {}
        O.step()
        farthest = max(farthest, farthest_that_bears(before))
    return farthest


@pytest.mark.parametrize(
    "make, seeds",
    ((make_block, (3, 6, 7, 8, 16)), (make_disk, (5,)), (make_superdisk, (13, 16))),
    ids=("blocks", "disks", "superdisks"),
)
def test_nodes_bear_where_they_are(make, seeds):
    for seed in seeds:
        assert crush(make, seed) < 0.25, seed
        assert sg.integrator().largestOverlap < 0.3
