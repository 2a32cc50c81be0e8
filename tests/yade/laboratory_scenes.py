"""Grains between walls, and the controller that presses these."""

import numpy as np
from scenes import RADIUS, YOUNG, add_disk, add_wall, damped_material
from yade import FrictMat, O, utils

import softgrain as sg

STRESS = -0.03 * YOUNG  # Pa


def four_disks():
    """Four disks in a box of walls, with some room; returns the ids of the walls."""
    material = damped_material()
    for k, radius in enumerate((1.0, 0.9, 0.95, 0.85)):
        add_disk(
            ((1 + 2 * (k % 2)) * RADIUS, (1 + 2 * (k // 2)) * RADIUS, 0), radius * RADIUS, material
        )
    return [add_wall(4 * RADIUS * (k % 2), axis=k // 2).id for k in range(4)]


def eight_balls(thickness=0.2 * RADIUS):
    """Eight balls in a box of boxes, or of walls if these have no thickness; returns their ids."""
    material = damped_material()
    for place in np.ndindex(2, 2, 2):
        center = [(1.01 + 2.02 * k) * RADIUS for k in place]
        O.bodies.append(sg.soft_sphere(center, RADIUS, material, zeta=0.5))
    width = 4.04 * RADIUS
    if thickness == 0:
        return [add_wall(width * (k % 2), axis=k // 2).id for k in range(6)]
    return O.bodies.append(
        utils.aabbWalls(
            [(0, 0, 0), (width,) * 3],
            thickness=thickness,
            oversizeFactor=1.5,
            material=FrictMat(frictionAngle=0),
        )
    )


def insert_controller(walls, **attributes):
    """A WallStressController in its place in O.engines."""
    controller = sg.WallStressController(walls=walls, **attributes)
    sg.insert_before_solve(controller)
    return controller
