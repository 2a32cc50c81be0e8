"""A square pressed along one axis in a rigid die without friction: uniaxial strain,
F = diag(1, stretch)."""

import numpy as np
import pytest
from bodies import POISSON, YOUNG, add, add_wall, soft
from neo_hookean import cauchy
from yade import O

import softgrain as sg

HALF = 0.01  # of a side, m


def exact(stretch):
    """Pressure on the moved sides, and the mean pressure [Pa]."""
    across, along = -cauchy((1, stretch), YOUNG, POISSON)
    return along, (along + 2 * across) / 3


def press(until, **shape):
    """Until the mean pressure is so much [Pa]; largest error of the force, averaged over 40 steps,
    over the exact one, from a third of that pressure on."""
    material = soft(massDamping=3000)
    add(sg.soft_block((0, 0, 0), (2 * HALF, 2 * HALF), material, zeta=0.2, **shape))
    sides = [(axis, side) for axis in (0, 1) for side in (-1, 1)]
    walls = [add_wall(s * HALF, axis, velocity=-0.05 * s * axis) for axis, s in sides]
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
