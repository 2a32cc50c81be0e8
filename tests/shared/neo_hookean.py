"""The neo-Hookean law of doc/theory.md in closed form, by stretches along the axes: in plane strain
two of them."""

import math

import numpy as np
from scipy import optimize


def lame(young, poisson):
    """mu and Lambda [Pa]."""
    return young / (2 * (1 + poisson)), young * poisson / ((1 + poisson) * (1 - 2 * poisson))


def wave_speed(young, poisson, density):
    """Of pressure waves at small strain [m/s]."""
    mu, lam = lame(young, poisson)
    return math.sqrt((lam + 2 * mu) / density)


def cauchy(stretches, young, poisson):
    """Stress along each axis [Pa]."""
    mu, lam = lame(young, poisson)
    J = math.prod(stretches)
    return (mu * (np.square(stretches) - 1) + lam * math.log(J)) / J


def with_free_sides(stretch, sides, poisson):
    """All stretches where the sides, all alike, are free of stress."""

    def stretches(widening):
        return (stretch, *[widening] * sides)

    return stretches(
        optimize.brentq(lambda w: cauchy(stretches(w), 1.0, poisson)[-1], 0.5, 2.0)
    )
