"""Weight, stress waves and friction at rest against closed-form solutions."""

import math

import numpy as np
import pytest
from bodies import DENSITY, YOUNG, add, add_wall, soft
from scipy import integrate, optimize
from yade import O

import softgrain as sg


def add_bar(center, size, zeta, **attributes):
    """A block without lateral contraction: a bar in one dimension."""
    return add(sg.soft_block(center, size, soft(poisson=0, **attributes), zeta=zeta))


# --- a block under its own weight ---------------------------------------------------------------

SIDE = 0.02  # m
WEIGHT = 0.1 * YOUNG / (DENSITY * SIDE)  # gravity that shortens it by 5 %, m/s^2
LOADING = 0.02  # s


def stretch_under(pressure):
    """Of a bar of the neo-Hookean law with poisson = 0: the solution of mu (F - 1/F) = -pressure,
    mu = E/2."""
    s = pressure / YOUNG
    return math.sqrt(1 + s * s) - s


def below(place):
    """Height at which a point of the block lies in the end that lay at `place` without weight."""
    height, _ = integrate.quad(lambda y: stretch_under(DENSITY * WEIGHT * (SIDE - y)), 0, place)
    return height


def place_of(height):
    """The inverse of `below`."""
    return optimize.brentq(lambda place: below(place) - height, 0, 1.1 * SIDE)


@pytest.mark.parametrize("zeta, sinking, stress", ((0.25, 0.06, 0.05), (0.125, 0.015, 0.03)))
def test_block_under_its_own_weight(zeta, sinking, stress):
    """Bounds: of the way its top sinks, and of the stress, relative."""
    block = add_bar((0, SIDE / 2, 0), (SIDE, SIDE), zeta, massDamping=2000)
    floor = add_wall(0, axis=1, sense=1)
    O.engines = sg.engines()
    sg.set_time_step()
    while O.time < 10 * LOADING:
        O.engines[-1].gravity = (0, -WEIGHT * min(1, O.time / LOADING), 0)
        O.step()
    pressure = DENSITY * WEIGHT * SIDE  # at the bottom
    assert abs(O.forces.f(floor.id)[1]) == pytest.approx(pressure * SIDE, rel=1e-4)
    height = np.ptp(block.shape.outline()[:, 1])
    assert SIDE - height == pytest.approx(SIDE - below(SIDE), rel=sinking)
    points = block.shape.points()
    x, y = points["position"][:, 0], points["position"][:, 1]
    exact = DENSITY * WEIGHT * np.array([place_of(end) - SIDE for end in y])
    middle = np.abs(x) < 0.3 * SIDE
    squares = (points["cauchy"][:, 1, 1] - exact)[middle] ** 2
    error = math.sqrt(np.average(squares, weights=points["volume"][middle]))
    assert error < stress * pressure


# --- a bar that hits a wall ---------------------------------------------------------------------

LENGTH, WIDTH, SPEED = 0.08, 0.01, 0.05  # m, m, m/s
WAVE_SPEED = math.sqrt(YOUNG / DENSITY)  # m/s


@pytest.mark.parametrize("zeta, loss", ((0.5, 0.06), (0.25, 0.04)))
def test_bar_that_hits_a_wall(zeta, loss):
    """A wave of compression runs up and comes back as one of release: the force is rho c v times
    the width for a time of 2 L/c, and the bar leaves as fast as it came (but for waves shorter than
    the grid can carry, which stay behind as vibration)."""
    bar = add_bar((0.5001 * LENGTH, 0, 0), (LENGTH, WIDTH), zeta)
    wall = add_wall(0, axis=0, sense=1)
    O.engines = sg.engines()
    sg.set_time_step()
    bar.state.vel = (-SPEED, 0, 0)
    times, forces = [], []
    while O.time < 4 * LENGTH / WAVE_SPEED:
        O.step()
        times.append(O.time)
        forces.append(abs(O.forces.f(wall.id)[0]))
    times, forces = np.array(times), np.array(forces)
    plateau = DENSITY * WAVE_SPEED * SPEED * WIDTH
    contact = times[forces > 0.5 * plateau]
    share = (times - contact[0]) / (contact[-1] - contact[0])
    inside = (share > 0.15) & (share < 0.85)
    assert forces[inside].mean() == pytest.approx(plateau, rel=0.01)
    assert np.ptp(contact) == pytest.approx(2 * LENGTH / WAVE_SPEED, rel=loss)
    assert bar.state.vel[0] == pytest.approx(SPEED, rel=loss)


# --- three disks in a pyramid -------------------------------------------------------------------

RADIUS = 0.01  # m
SLIPS = math.tan(math.radians(15))  # least coefficient of friction between the disks
RAMP = 0.03  # while weight comes up, s


@pytest.mark.parametrize("zeta", (0.1, 0.05))
@pytest.mark.parametrize("share, stands", ((0.9, False), (1.1, True)))
def test_pyramid_of_three_disks(share, stands, zeta):
    """Two disks carry a third and do not press on each other. What the upper one does to a lower
    one runs through its point on the floor, if it is to rest: 15 degrees from the normal. On the
    floor a third of that friction is enough."""
    material = soft(share * SLIPS, massDamping=300)
    for x, y in ((-1.0005, 1), (1.0005, 1), (0, 1 + math.sqrt(3))):
        add(sg.soft_disk((x * RADIUS, y * RADIUS, 0), RADIUS, material, zeta=zeta))
    add_wall(0, axis=1, friction=share * SLIPS, sense=1)
    O.engines = sg.engines()
    sg.set_time_step()
    upper = O.bodies[2]
    while O.time < 10 * RAMP:
        O.engines[-1].gravity = (0, -9.81 * min(1, O.time / RAMP), 0)
        O.step()
    sunk = (RADIUS * (1 + math.sqrt(3)) - upper.state.pos[1]) / RADIUS
    assert sunk < 0.03 if stands else sunk > 0.3
