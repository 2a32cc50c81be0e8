"""A periodic cell that flows homogeneously."""

from dataclasses import dataclass, field

import numpy as np


@dataclass
class Cell:
    """Base vectors H and velocity gradient L: x -> x + H n are images of each other.

    L of the step before is kept since a change of it takes the bodies along.
    """

    base: np.ndarray  #: H at t_n, base vectors as columns [m], shape (2, 2)
    gradient: np.ndarray  #: L of the step from t_n on [1/s], shape (2, 2)
    last_gradient: np.ndarray = field(default_factory=lambda: np.zeros((2, 2)))  #: 1/s

    def image(self, first, second):
        """Shift H n [m] and velocity L H n [m/s] of the image of `second` [m] next to `first`."""
        n = -np.round(np.linalg.solve(self.base, second - first))
        return self.base @ n, self.gradient @ self.base @ n

    def take_along(self, position, velocity, dt):
        """What a body gets for the flow: velocity dL x + dt L v of its centre [m/s], and spin
        [1/s]."""
        change = self.gradient - self.last_gradient
        spin = 0.5 * (change[1, 0] - change[0, 1])
        return change @ position + dt * self.last_gradient @ velocity, spin

    def move(self, dt):
        """H += dt L H."""
        self.base = self.base + dt * self.gradient @ self.base
        self.last_gradient = self.gradient
