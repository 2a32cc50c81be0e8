"""The energy balance of a run."""

from yade import O

from softgrain.bodies import material_of, some_soft_bodies
from softgrain.observe import integrator


class Balance:
    """Relative closure of the energy balance of all soft grains since this object was made. What a
    script changes by hand (``vel``, ``young``, bodies erased), and what ``SoftenWhenLoaded`` turns
    soft, is no work that is booked: it counts as error.

    The work of walls, rigid bodies, loads and a periodic cell must be found again as kinetic and
    elastic energy of the grains and as what friction, impacts and damping dissipated, and grains
    that fell asleep lost. What rigid bodies have and lose among themselves is not in it.

    Raises:
        ValueError: the scene has no soft grain.
        RuntimeError: ``O.trackEnergy`` is off, or no step has been taken with it: there are no
            energies to compare.
    """

    _STORED_AND_LOST = (
        "kinetic",
        "elastic",
        "friction",
        "impact",
        "damping",
        "sleep",
        "cohesion",
    )
    _WORKS = ("walls", "cell", "loads")
    #: Of Young's modulus times volume: energies below are rounding, which balances nothing.
    _ROUNDING = 1e-15

    def __init__(self):
        grains = some_soft_bodies("Balance")
        self._check()
        self._start = self._stored_and_lost(integrator().energy())
        stiffness = sum(material_of(b).young * b.shape.undeformedVolume() for b in grains)
        self._scale = self._ROUNDING * stiffness

    @staticmethod
    def _check():
        if O.trackEnergy and "softKinetic" in O.energy.keys() and integrator().steps > 0:
            return
        raise RuntimeError(
            f"Balance: O.trackEnergy = {O.trackEnergy}, and a balance needs the energies of the "
            "last step: set O.trackEnergy = True and take a step first"
        )

    @classmethod
    def _stored_and_lost(cls, energy):
        return sum(energy[name] for name in cls._STORED_AND_LOST) - sum(
            energy[name] for name in cls._WORKS
        )

    def error(self):
        """|work - change of energy - dissipation| over the largest of these so far, as far as it
        was asked: ask at every record where energies come and go. Over 1e-15 of Young's modulus
        times volume at least, so that it tells of no rounding [-]."""
        self._check()
        energy = integrator().energy()
        terms = self._STORED_AND_LOST + self._WORKS  # not what rigid bodies have by themselves
        self._scale = max([self._scale] + [abs(energy[name]) for name in terms])
        if self._scale == 0:
            return 0.0
        return abs(self._stored_and_lost(energy) - self._start) / self._scale
