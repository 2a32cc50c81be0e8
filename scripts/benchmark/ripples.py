"""Waves of the grid inside soft grains: how much stresses alternate from point to point, and in
time."""

import numpy as np
from scipy.spatial import cKDTree

import softgrain as sg

NEIGHBOURS = 8  # of a point in the lattice of points
RIM = 1.5  # in spacings of the points: nearer to the outline they are smaller and closer
#: Steps from sample to sample, in turn: the shortest waves take a little more than three steps a
#: period, and one stride alone would see some of them always at the same phase.
STRIDES, ROUNDS = (3, 4), 20


class _Ripple:
    """Of one grain: what the von Mises stress of a point inside differs from that of the points
    about it, a plane being laid through theirs."""

    def __init__(self, body):
        self.body = body
        points = body.shape.points()
        place, volume = points["position"][:, :2], points["volume"]
        outline = body.shape.outline()[:, :2]
        spacing = np.sqrt(np.median(volume))
        self.inside = np.flatnonzero(cKDTree(outline).query(place)[0] > RIM * spacing)
        self.volume = volume[self.inside]
        about = cKDTree(place).query(place[self.inside], NEIGHBOURS + 1)[1]
        self.about = about[:, 1:]
        away = place[self.about] - place[self.inside, None]
        plane = np.concatenate([np.ones((*away.shape[:2], 1)), away], axis=2)
        self.weights = np.linalg.pinv(plane)[:, 0]
        self.samples = []

    def sample(self):
        stress = sg.von_mises(self.body.shape.points()["cauchy"])
        expected = np.sum(self.weights * stress[self.about], axis=1)
        self.samples.append(stress[self.inside] - expected)

    def strength(self):
        """Root mean square about its mean in time [Pa]: what stands is the field's curvature."""
        moving = np.array(self.samples) - np.mean(self.samples, axis=0)
        return np.sqrt(np.average(np.mean(moving**2, axis=0), weights=self.volume))


def ripples_of_stress():
    """Root mean square in time of the ripples of von Mises stress inside each soft disk over the
    next 140 steps: array (grains,) [Pa]."""
    ripples = [_Ripple(body) for body in sg.soft_bodies()]
    for stride in STRIDES * ROUNDS:
        sg.advance(stride)
        for ripple in ripples:
            ripple.sample()
    return np.array([ripple.strength() for ripple in ripples])
