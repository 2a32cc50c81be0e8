"""What patch tests and blocks on inclines are made of."""

import math

from yade import FrictMat, O, utils

import softgrain as sg

YOUNG = 1e6  # Pa
DENSITY = 1000.0  # kg/m^3
POISSON = 0.3
GRAVITY = 9.81  # m/s^2
WIDTH, HEIGHT = 0.02, 0.01  # of a block, m
WAVE_SPEED = math.sqrt(
    YOUNG * (1 - POISSON) / ((1 + POISSON) * (1 - 2 * POISSON)) / DENSITY
)  # of pressure waves, m/s


def soft(friction=0.0):
    return sg.SoftMat(
        young=YOUNG, poisson=POISSON, density=DENSITY, frictionAngle=math.atan(friction)
    )


def add_wall(position, axis, friction=0.0):
    wall = utils.wall(position, axis=axis, material=FrictMat(frictionAngle=math.atan(friction)))
    O.bodies.append(wall)
    return wall


def add(body):
    O.bodies.append(body)
    return body


def start(**engines):
    O.engines = sg.engines(**engines)
    return sg.set_time_step(0.5)


def gentle(share):
    """From 0 to 1 with two derivatives that vanish at the ends."""
    s = min(max(share, 0.0), 1.0)
    return s**3 * (10 - 15 * s + 6 * s**2)
