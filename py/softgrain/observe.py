"""Reading soft scenes: areas, stresses, forces, coordination, energy balance."""

import numpy as np
from yade import O, wrapper

from softgrain import _softgrain


def soft_bodies():
    """All bodies with a soft shape, by id."""
    return [b for b in O.bodies if b and isinstance(b.shape, wrapper.SoftGrain)]


def integrator():
    """The ``SoftGrainIntegrator`` of ``O.engines``.

    Raises:
        ValueError: there is none.
    """
    for engine in O.engines:
        if isinstance(engine, wrapper.SoftGrainIntegrator):
            return engine
    raise ValueError("O.engines holds no SoftGrainIntegrator; see sg.engines()")


def grain_area(body):
    """Present area of a soft disk [m²] (volume of a soft ball [m³]), sum_p Vp0 J_p."""
    return body.shape.volume()


def packing_fraction(box_area, nominal=False):
    """Packing fraction of all soft grains in a box.

    Args:
        box_area (float): present area (volume) of the box [m² or m³].
        nominal (bool): with the undeformed areas (phi0) instead of the present ones (phi).

    Returns:
        float: phi or phi0 [-].
    """
    if nominal:
        areas = [b.shape.undeformedVolume() for b in soft_bodies()]
    else:
        areas = [grain_area(b) for b in soft_bodies()]
    return sum(areas) / box_area


def von_mises(cauchy):
    """Equivalent stress sqrt(3/2 s:s) of Cauchy stresses.

    Args:
        cauchy (array (..., 3, 3)): as in ``SoftGrain.points()['cauchy']`` [Pa].

    Returns:
        array (...): [Pa].
    """
    mean = np.trace(cauchy, axis1=-2, axis2=-1) / 3
    deviator = cauchy - mean[..., None, None] * np.eye(3)
    return np.sqrt(1.5 * np.sum(deviator**2, axis=(-2, -1)))


def wall_force(body_id):
    """Force of all contacts on a wall, or any other body, in the last step [N, 2D N/m].

    ``O.forces.f(body_id)`` has besides what pushes a body that is free, as a wall under stress is.
    """
    return np.array(_softgrain.contactForce(body_id))


def coordination_number():
    """Mean number of bodies that a soft grain exchanges force with, walls and rigid ones included
    [-]."""
    bodies = soft_bodies()
    ids = {b.id for b in bodies}
    ends = 0
    for i in O.interactions:
        if i.isReal and isinstance(i.phys, wrapper.SoftPhys) and i.phys.activeContacts > 0:
            ends += (i.id1 in ids) + (i.id2 in ids)
    return ends / len(bodies)


class Balance:
    """Relative closure of the energy balance since this object was made; needs ``O.trackEnergy =
    True``.

    The work of walls and loads must be found again as kinetic and elastic energy and as what
    friction, impacts and damping dissipated, and grains that fell asleep lost.
    """

    def __init__(self):
        self._start = self._stored_and_lost(integrator().energy())
        self._scale = 0.0

    @staticmethod
    def _stored_and_lost(energy):
        stored = energy["kinetic"] + energy["elastic"]
        lost = sum(energy[name] for name in ("friction", "impact", "damping", "sleep"))
        return stored + lost - energy["walls"] - energy["loads"]

    def error(self):
        """|work - change of energy - dissipation| over the largest magnitude so far [-]."""
        energy = integrator().energy()
        self._scale = max([self._scale] + [abs(value) for value in energy.values()])
        if self._scale == 0:
            return 0.0
        return abs(self._stored_and_lost(energy) - self._start) / self._scale
