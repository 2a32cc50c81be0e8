"""Scenes in which soft grains turn rigid."""

from scenes import RADIUS, YOUNG, add_wall
from yade import FrictMat

PLACES = [(x * RADIUS, y * RADIUS, 0) for x in (1, 3) for y in (1, 3)]


def rigid_material(young=YOUNG / RADIUS):
    return FrictMat(young=young, poisson=0.3, frictionAngle=0.3, density=1000)


def box():
    return [add_wall(4 * RADIUS * (k % 2), axis=k // 2) for k in range(4)]
