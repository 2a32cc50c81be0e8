"""Rigid bodies beside soft grains."""

import math

import numpy as np
from scenes import RADIUS, add_disk, add_wall, facet_strip, ready, run, soft_material
from yade import FrictMat, O, utils

import softgrain as sg


def rigid_material(friction=0.3, density=2000.0, young=1e5):
    return FrictMat(young=young, poisson=0.3, density=density, frictionAngle=math.atan(friction))


def add_rigid_disk(center, radius, velocity=(0, 0, 0), spin=0, fixed=False, **material):
    """A rigid disk in the plane, of YADE's sphere; returns its body."""
    body = utils.sphere(center, radius, material=rigid_material(**material), fixed=fixed)
    if not fixed:
        body.state.blockedDOFs = "zXY"
    O.bodies.append(body)
    if not fixed:
        sg.as_disks([body.id])
    body.state.vel, body.state.angVel = velocity, (0, 0, spin)
    return body


def rest_material():
    """Damped, so that a scene comes to rest."""
    return soft_material(massDamping=300, frictionAngle=math.atan(0.5))


def add_clump(centers, radius, friction=0.5):
    """A rigid clump of disks; returns its body."""
    spheres = [utils.sphere(c, radius, material=rigid_material(friction=friction)) for c in centers]
    clump, _ = O.bodies.appendClumped(spheres)
    body = O.bodies[clump]
    body.state.blockedDOFs = "zXY"
    sg.as_disks([clump])
    return body


def facets_along(ends):
    """Across the plane, between neighbouring points."""
    points = [(x, y, 0) for x, y in ends]
    return facet_strip(points, (0, 0, 4 * RADIUS), rigid_material(0.5))


def box_strip():
    """Floor and sides of the same container, of boxes."""
    half, thick = 1.05 * RADIUS, 0.3 * RADIUS
    places = ((0, -half - thick, 0), (-half - thick, 0, 0), (half + thick, 0, 0))
    sizes = ((2 * half, thick, RADIUS), (thick, 2 * half, RADIUS), (thick, 2 * half, RADIUS))
    return [
        utils.box(place, size, fixed=True, material=rigid_material(0.5))
        for place, size in zip(places, sizes)
    ]


def bed_of_grains():
    """Two damped grains between walls, for something to lie on."""
    for x in (-1.0, 1.0):
        add_disk((x * RADIUS, 0, 0), material=rest_material())
    add_wall(-RADIUS, 1, friction=0.5)
    add_wall(-2 * RADIUS, 0)
    add_wall(2 * RADIUS, 0)


def assert_comes_to_rest(body, parts):
    """Under gravity: the reaction on its parts (ids) is its weight, and it does not creep."""
    ready(gravity=(0, -10, 0))
    run(6000)
    start = np.array(body.state.pos)
    total, steps = np.zeros(3), 2000
    for _ in range(steps):
        run(1)
        total += sum(np.array(O.forces.f(i)) for i in parts)
    weight = 10 * body.state.mass
    np.testing.assert_allclose(total / steps, (0, weight, 0), atol=0.01 * weight)
    assert np.linalg.norm(np.array(body.state.pos) - start) < 1e-4 * RADIUS
    assert np.linalg.norm(body.state.vel) < 1e-3
