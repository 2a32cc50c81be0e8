"""scripts/compare_rigid.py: its models have the constants that all are told."""

import math

import numpy as np
import pytest
from yade import O, Sphere

RADIUS, STRAIN, STEPS = 0.01, 1e-4, 20


def bonded_stress(poisson, gradient):
    """What a small homogeneous displacement gradient (2, 2) does to the stress within a grain of
    bonded particles: bonds of its inside, each standing for a third of a particle's cell."""
    from rigid_and_soft.models import Bonded

    model = Bonded(0.3, poisson)
    model.add([(0, 0)], [RADIUS])
    model.start()
    O.step()  # bonds
    O.engines = O.engines[:-1]  # particles are moved by hand
    places = {b.id: np.array(b.state.pos)[:2] for b in O.bodies if isinstance(b.shape, Sphere)}
    ends = [(i, places[i.id1], places[i.id2]) for i in O.interactions]
    inside = [
        (i, a, b) for i, a, b in ends if max(np.linalg.norm(x) for x in (a, b)) < 0.7 * RADIUS
    ]
    area = len(inside) / 3 * 2 * math.sqrt(3) * O.bodies[0].shape.radius**2

    def stress():
        forces = [np.array(i.phys.normalForce + i.phys.shearForce)[:2] for i, _, _ in inside]
        moments = sum(np.outer(f, b - a) for f, (_, a, b) in zip(forces, inside))
        return moments / (area * model.thickness)

    before = stress()
    for b in O.bodies:
        b.state.vel = (*(gradient @ places[b.id] / (STEPS * O.dt)), 0)
    for _ in range(STEPS):
        for b in O.bodies:
            b.state.pos += O.dt * b.state.vel
        O.step()
    return stress() - before


@pytest.mark.parametrize("name", ("linear", "hertz", "nonsmooth", "bonded", "triangles", "soft"))
def test_grains_weigh_as_disks_of_the_layer(name):
    from rigid_and_soft.models import DENSITY, MODELS

    radii = (0.8 * RADIUS, RADIUS)
    model = MODELS[name](0.3, 0.2)
    model.add([(0, 0), (3 * RADIUS, 0)], radii)
    model.start()
    masses = np.zeros(len(radii))
    for body, grain in model.grain_of.items():
        masses[grain] += O.bodies[body].state.mass
    expected = DENSITY * math.pi * np.square(radii)
    np.testing.assert_allclose(masses / model.thickness, expected, rtol=2e-3)


@pytest.mark.parametrize("poisson, reached", [(0.1, 1 / 9), (0.2, 1 / 4), (0.45, 0.95 / 3.05)])
def test_bonded_particles_are_calibrated(poisson, reached):
    """Young's modulus and Poisson's ratio in the plane, measured; 0.45 is not in reach of
    central bonds."""
    from rigid_and_soft.models import YOUNG

    pulled = np.abs(bonded_stress(poisson, np.diag([STRAIN, 0]))) / STRAIN
    O.reset()
    sheared = np.abs(bonded_stress(poisson, STRAIN * np.array([[0, 1], [1, 0]]))) / STRAIN
    ratio = pulled[1, 1] / pulled[0, 0]
    young = pulled[0, 0] * (1 - ratio**2)
    assert ratio == pytest.approx(reached, rel=1e-3)
    assert young == pytest.approx(YOUNG / (1 - poisson**2), rel=1e-3)
    assert sheared[0, 1] == pytest.approx(young / (1 + ratio), rel=1e-3)
