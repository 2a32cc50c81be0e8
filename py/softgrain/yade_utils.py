"""Functions of ``yade.utils`` that know spheres only, or leave out bodies whose degrees of freedom
are all blocked, as those of soft grains are: they count soft grains once softgrain is imported, by
every name a script has for them. In scenes of rigid bodies alone they are YADE's own."""

import math

import numpy as np
from yade import Matrix3, O, Sphere, Vector3, utils

from softgrain import _host
from softgrain.bodies import bodies_of, has_own_motion, is_soft, soft_bodies
from softgrain.cell import cell_volume
from softgrain.checks import number
from softgrain.quasi_static import unbalanced_force
from softgrain.time_loop import refuse_background_run

_of_yade = {
    name: getattr(utils, name)
    for name in (
        "unbalancedForce",
        "kineticEnergy",
        "aabbExtrema",
        "fabricTensor",
        "porosity",
        "growParticle",
    )
}


def replace():
    """Put the functions of this module in the place of those of ``yade.utils``."""
    for name in _of_yade:
        _host.replace_in_utils(name, globals()[name])


def unbalancedForce(useMaxForce=False):
    """:func:`softgrain.unbalanced_force`.

    Args:
        useMaxForce (bool): the largest sum of forces on a body in place of their mean.

    Returns:
        float: 0 without any force, inf where something is accelerated without any contact, nan
        where the forces of the last step are not there [-].
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
    energies = {b.id: _kinetic_energy(b) for b in O.bodies if b and has_own_motion(b)}
    total = sum(energies.values())
    if not findMaxId:
        return total
    return total, max(energies, key=energies.get) if total > 0 else -1


def aabbExtrema(cutoff=0.0, centers=False):
    """Box about all spheres and soft grains (2D: as thick as these are wide).

    Args:
        cutoff (float): share of it that is cut away, half of it at either side, in [0, 1] [-].
        centers (bool): about the centres alone.

    Returns:
        tuple: lower and upper corner [m].

    Raises:
        ValueError: *cutoff* is not in [0, 1].
    """
    if not soft_bodies():
        return _of_yade["aabbExtrema"](cutoff, centers)
    cutoff = number("cutoff", cutoff, "[0, 1]")
    ends = np.array([_ends(b, centers) for b in O.bodies if b and (is_soft(b) or _is_sphere(b))])
    low, high = ends[:, 0].min(axis=0), ends[:, 1].max(axis=0)
    cut = cutoff / 2 * (high - low)
    return Vector3(low + cut), Vector3(high - cut)


def fabricTensor(cutoff=0.0, splitTensor=False, thresholdForce=math.nan, extrema=()):
    """Fabric 1/n sum n n^T of the n pairs that bear a force and touch in *extrema* or, if there are
    none, in :func:`aabbExtrema`.

    Args:
        cutoff (float): as :func:`aabbExtrema` has it, in [0, 1] [-].
        splitTensor (bool): of strong and of weak contacts apart.
        thresholdForce (float): normal force that parts them, compression negative; nan: the mean
            [N, 2D N/m].
        extrema (list): lower and upper corner of a box [m].

    Returns:
        tuple: the tensor, or the two of them, each a Matrix3 [-]; nan of no contact.

    Raises:
        ValueError: *cutoff* is not in [0, 1].
    """
    if not soft_bodies():
        return _of_yade["fabricTensor"](cutoff, splitTensor, thresholdForce, list(extrema))
    low, high = np.array(extrema if len(extrema) else aabbExtrema(cutoff))
    rounding = 1e-9 * np.linalg.norm(high - low)  # contacts with walls lie on their box
    normals, forces = [], []
    for i in O.interactions:
        if not (i.isReal and i.phys.normalForce.squaredNorm() > 0):
            continue
        place = np.array(i.geom.contactPoint)
        if np.all((low - rounding <= place) & (place <= high + rounding)):
            normals.append(i.geom.normal)
            forces.append(-i.phys.normalForce.dot(i.geom.normal))
    normals, forces = np.reshape(normals, (-1, 3)), np.array(forces)
    if not splitTensor or not len(forces):
        return (_fabric(normals),) * (1 + splitTensor)
    strong = forces <= (forces.mean() if math.isnan(thresholdForce) else thresholdForce)
    return _fabric(normals[strong]), _fabric(normals[~strong])


def _fabric(normals):
    if not len(normals):
        return Matrix3(*[math.nan] * 9)
    return Matrix3(*(normals.T @ normals / len(normals)).ravel())


def porosity(volume=-1):
    """Share of a volume that neither spheres nor soft grains, as they are now, fill.

    Args:
        volume (float): [m³]; 2D: the area, with spheres as disks [m²]. If it is not positive, that
            of :func:`aabbExtrema`. In a periodic cell always that of the cell.

    Returns:
        float: [-], negative if the grains do not fit into the volume.

    Raises:
        ValueError: *volume* is no number.
    """
    grains = soft_bodies()
    if not grains:
        return _of_yade["porosity"](volume)
    volume = number("volume", volume, "(-inf, inf)")
    flat = grains[0].shape.dim == 2
    if O.periodic:
        volume = cell_volume()
    elif not volume > 0:
        low, high = aabbExtrema()
        volume = np.prod(np.array(high - low)[: 2 if flat else 3])
    radii = np.array([b.shape.radius for b in O.bodies if b and _is_sphere(b)])
    rigid = math.pi * (radii**2).sum() if flat else 4 / 3 * math.pi * (radii**3).sum()
    return 1 - (sum(b.shape.volume() for b in grains) + rigid) / volume


def growParticle(bodyID, multiplier, updateMass=True):
    """YADE's, which takes any shape for a sphere and writes where the radius of one would be.

    Args:
        bodyID (int): of a sphere.
        multiplier (float): on its radius [-].
        updateMass (bool): of mass and inertia, too.

    Raises:
        ValueError: the body is no sphere, or there is none.
        RuntimeError: a run is going on in the background.
    """
    refuse_background_run("growParticle")
    (body,) = bodies_of([bodyID], "bodyID")
    if not _is_sphere(body):
        kind = "clump" if body.isClump else type(body.shape).__name__
        raise ValueError(f"bodyID = {bodyID}: a {kind} does not grow; admissible: spheres")
    _of_yade["growParticle"](bodyID, multiplier, updateMass)


def _is_sphere(body):
    return isinstance(body.shape, Sphere)


def _ends(body, centers):
    """Lower and upper corner of the box about a sphere or a soft grain."""
    place, radius = np.array(body.state.pos), body.shape.radius
    if centers:
        return place, place
    if not is_soft(body):
        return place - radius, place + radius
    outline = np.array(body.shape.outline())
    # with 'points' of the middles of disks (balls) of diameter dr = zeta R
    around = body.shape.zeta * radius / 2 if body.shape.contact == "points" else 0
    thick = np.full(3, float(around))
    if body.shape.dim == 2:
        thick[2] = radius
    return outline.min(axis=0) - thick, outline.max(axis=0) + thick


def _kinetic_energy(body):
    velocity, spin = body.state.vel, body.state.angVel
    if O.periodic:
        velocity, spin = O.cell.getFluctuationVelocity(body), spin - O.cell.getSpin()
    whole = _energy_of_whole(body, velocity, spin)
    if not is_soft(body):
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
