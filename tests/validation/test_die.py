"""A square pressed along one axis in a rigid die without friction: uniaxial strain, in closed form
the neo-Hookean law of doc/theory.md with F = diag(1, stretch)."""

import math

import numpy as np
import pytest
from patches import POISSON, YOUNG, add, add_wall
from yade import O

import softgrain as sg

HALF = 0.01  # of a side, m
MU = YOUNG / (2 * (1 + POISSON))
LAMBDA = YOUNG * POISSON / ((1 + POISSON) * (1 - 2 * POISSON))


def exact(stretch):
    """Pressure on the moved sides, and the mean pressure [Pa]."""
    across = -LAMBDA * math.log(stretch) / stretch
    along = across - MU * (stretch - 1 / stretch)
    return along, (along + 2 * across) / 3


def press(until, **shape):
    """Until the mean pressure is so much [Pa]; largest error of the force, averaged over 40 steps,
    over the exact one, from a third of that pressure on."""
    material = sg.SoftMat(young=YOUNG, poisson=POISSON, density=1000, massDamping=3000)
    add(sg.soft_block((0, 0, 0), (2 * HALF, 2 * HALF), material, zeta=0.2, **shape))
    walls = [add_wall(side * HALF, axis) for axis in (0, 1) for side in (-1, 1)]
    for wall, side in zip(walls[2:], (-1, 1)):
        wall.state.vel = (0, -0.05 * side, 0)
    O.engines = sg.engines()
    sg.set_time_step()
    reached, errors = 0, []
    while reached < until:
        forces, expected = [], []
        for _ in range(20):
            sg.advance(2)
            along, reached = exact(walls[3].state.pos[1] / HALF)
            forces.append(sg.wall_force(walls[3].id)[1] / (2 * HALF))
            expected.append(along)
        if reached > until / 3:
            errors.append(np.mean(forces) / np.mean(expected) - 1)
    return np.abs(errors).max()


@pytest.mark.parametrize("until, shape", ((1.4, {}), (3, {"nodeSpacing": 2})))
def test_square_in_a_die(until, shape):
    """Up to a pressure beyond which the default folds; wide grids bear more."""
    assert press(until * YOUNG, **shape) < 0.02
