"""What patch tests and blocks on inclines are made of."""

from bodies import DENSITY, POISSON, YOUNG
from neo_hookean import wave_speed
from yade import O

import softgrain as sg

GRAVITY = 9.81  # m/s^2
WIDTH, HEIGHT = 0.02, 0.01  # of a block, m
WAVE_SPEED = wave_speed(YOUNG, POISSON, DENSITY)  # m/s


def start(**engines):
    O.engines = sg.engines(**engines)
    return sg.set_time_step(0.5)


def gentle(share):
    """From 0 to 1 with two derivatives that vanish at the ends."""
    s = min(max(share, 0.0), 1.0)
    return s**3 * (10 - 15 * s + 6 * s**2)
