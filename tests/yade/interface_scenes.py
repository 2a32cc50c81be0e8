"""Blocks with interface laws between them."""

from scenes import RADIUS, add, soft_material
from yade import O

import softgrain as sg

SIDE = 2 * RADIUS
COHESION = dict(cohesion=2e3, cohesionRange=1e-4)
BOND = dict(bondStrength=2e3, bondEnergy=0.1)


def add_block(height, material=None, length=SIDE):
    """A soft block, its underside at this height; returns its body."""
    size = (length, SIDE)
    return add(sg.soft_block((0, height + RADIUS, 0), size, material or damped(), zeta=0.25))


def damped(**attributes):
    return soft_material(poisson=0.3, massDamping=200, **attributes)


def interaction():
    (found,) = [i for i in O.interactions if i.isReal]
    return found
