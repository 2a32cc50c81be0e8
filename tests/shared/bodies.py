"""Bodies that tests of all kinds put into a scene."""

import math

import numpy as np
from yade import FrictMat, O, utils

import softgrain as sg

YOUNG = 1e6  # Pa
POISSON = 0.3
DENSITY = 1000.0  # kg/m^3


def add(body):
    O.bodies.append(body)
    return body


def add_wall(position, axis, friction=0.0, velocity=0.0, sense=0, material=None):
    """A wall with that coefficient of friction, or of that material; a velocity that is a number is
    along its axis."""
    if material is None:
        material = FrictMat(frictionAngle=math.atan(friction))
    wall = utils.wall(position, axis=axis, sense=sense, material=material)
    wall.state.vel = velocity * np.eye(3)[axis] if np.isscalar(velocity) else velocity
    return add(wall)


def facet_strip(points, across, material):
    """From each point to the next one two facets, as wide as from -across to across; the list of
    them, which is not in the scene yet."""
    points, across, facets = np.array(points, float), np.array(across, float), []
    for a, b in zip(points, points[1:]):
        corners = a - across, b - across, b + across, a + across
        for chosen in ((0, 1, 2), (0, 2, 3)):
            facets.append(utils.facet([corners[k] for k in chosen], material=material))
    return facets


def soft(friction=0.0, **attributes):
    """A material of soft grains, with its coefficient of friction."""
    elasticity = {"young": YOUNG, "poisson": POISSON, "density": DENSITY}
    return sg.SoftMat(**{**elasticity, **attributes}, frictionAngle=math.atan(friction))
