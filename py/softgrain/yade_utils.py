"""Functions of ``yade.utils`` that leave out bodies whose degrees of freedom are all blocked, as
those of soft grains are: they count them once softgrain is imported, by every name a script has for
them. In scenes of rigid bodies alone they are YADE's own."""

from yade import O, utils, wrapper

from softgrain import _host
from softgrain.observe import soft_bodies
from softgrain.quasi_static import unbalanced_force

_of_yade = {name: getattr(utils, name) for name in ("unbalancedForce", "kineticEnergy")}


def replace():
    """Put the functions of this module in the place of those of ``yade.utils``."""
    _host.replace_in_utils("unbalancedForce", unbalancedForce)
    _host.replace_in_utils("kineticEnergy", kineticEnergy)


def unbalancedForce(useMaxForce=False):
    """:func:`softgrain.unbalanced_force`.

    Args:
        useMaxForce (bool): the largest sum of forces on a body in place of their mean.

    Returns:
        float: 0 without any force, inf where something is accelerated without any contact [-].
    """
    if soft_bodies():
        return unbalanced_force(largest=useMaxForce)
    return _of_yade["unbalancedForce"](useMaxForce)


def kineticEnergy(findMaxId=False):
    """Kinetic energy of all soft grains, vibrations included, and of all free rigid bodies. In a
    periodic cell motion with the cell (``O.cell.velGrad``, at the centre of each body) is left out.

    Args:
        findMaxId (bool): tell the body that has most of it, too.

    Returns:
        float | tuple: [J, 2D J/m]; with *findMaxId* the energy and the id, -1 where nothing moves.
    """
    if not soft_bodies():
        return _of_yade["kineticEnergy"](findMaxId)
    energies = {b.id: _kinetic_energy(b) for b in O.bodies if b and _counts(b)}
    total = sum(energies.values())
    if not findMaxId:
        return total
    return total, max(energies, key=energies.get) if total > 0 else -1


def _is_soft(body):
    return isinstance(body.shape, wrapper.SoftGrain)


def _counts(body):
    return _is_soft(body) or (body.dynamic and not body.isClumpMember)


def _kinetic_energy(body):
    velocity, spin = body.state.vel, body.state.angVel
    if O.periodic:
        velocity, spin = O.cell.getFluctuationVelocity(body), spin - O.cell.getSpin()
    whole = _energy_of_whole(body, velocity, spin)
    if not _is_soft(body):
        return whole
    vibration = body.shape.energy()["kinetic"] - _energy_of_whole(
        body, body.state.vel, body.state.angVel
    )
    return whole + vibration


def _energy_of_whole(body, velocity, spin):
    """Of a body that moves as a whole at these velocities."""
    if body.aspherical:
        spin = body.state.ori.conjugate() * spin
    turning = sum(i * rate**2 for i, rate in zip(body.state.inertia, spin))
    return (body.state.mass * velocity.squaredNorm() + turning) / 2
