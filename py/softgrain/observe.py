"""Reading soft scenes: areas, stresses, forces, coordination, energy balance."""

import itertools
import math

import numpy as np
from yade import O, wrapper

from softgrain import _softgrain
from softgrain.checks import array, index, indices, number
from softgrain.time_loop import integrators


def is_soft(body):
    """Whether a body is a soft grain (None, and what is no body, is not)."""
    return isinstance(getattr(body, "shape", None), wrapper.SoftGrain)


def soft_bodies():
    """All bodies with a soft shape, by id."""
    return [b for b in O.bodies if is_soft(b)]


def has_own_motion(body):
    """Whether forces move a body by itself: a soft grain, or a rigid body that is neither held nor
    a member of a clump. (YADE gives mass to bodies that are held, too.)"""
    return is_soft(body) or (body.dynamic and not body.isClumpMember)


def some_soft_bodies(asker):
    """All bodies with a soft shape, by id.

    Args:
        asker (str): who needs them, for the message.

    Raises:
        ValueError: the scene has no soft grain.
    """
    bodies = soft_bodies()
    if not bodies:
        raise ValueError(f"{asker}: the scene has no soft grain")
    return bodies


def unscaled_mass(body):
    """Of a soft grain without mass scaling, of which State.mass tells from the next step on [kg, 2D
    kg/m]."""
    return body.material.density * body.shape.undeformedVolume()


def bodies_of(ids):
    """The bodies with these ids.

    Args:
        ids (iterable of int): ids, each once.

    Returns:
        list of Body.

    Raises:
        ValueError: something else, an id that no body has, or one that comes twice.
    """
    ids = indices("ids", ids)
    for i in ids:
        if not 0 <= i < len(O.bodies) or O.bodies[i] is None:
            raise ValueError(f"ids: there is no body #{i}")
    if len(set(ids)) < len(ids):
        raise ValueError(f"ids: #{next(i for i in ids if ids.count(i) > 1)} is given twice")
    return [O.bodies[i] for i in ids]


def integrator():
    """The ``SoftGrainIntegrator`` of ``O.engines``.

    Raises:
        ValueError: there is none.
    """
    for engine in integrators():
        return engine
    raise ValueError("O.engines holds no SoftGrainIntegrator; see sg.engines()")


def grain_area(body):
    """Present area of a soft disk [m²] (volume of a soft ball [m³]), sum_p Vp0 J_p.

    Raises:
        ValueError: the body is no soft grain.
    """
    if not is_soft(body):
        raise ValueError(f"body = {body!r} is no soft grain")
    return body.shape.volume()


def packing_fraction(box_area=None, nominal=False):
    """Packing fraction of all soft grains in a box or a periodic cell; rigid bodies do not count.

    Args:
        box_area (float | None): present area (volume) of the box [m² or m³]; None: of the periodic
            cell.
        nominal (bool): with the undeformed areas (phi0) instead of the present ones (phi).

    Returns:
        float: phi or phi0 [-].

    Raises:
        ValueError: the area is not positive, or none is given and the scene is not periodic, or
            there is no soft grain.
    """
    if box_area is None:
        box_area = cell_volume()
    box_area = number("box_area", box_area, "(0, inf)", "m² or m³")
    grains = some_soft_bodies("packing_fraction")
    if nominal:
        areas = [b.shape.undeformedVolume() for b in grains]
    else:
        areas = [grain_area(b) for b in grains]
    return sum(areas) / box_area


def von_mises(cauchy):
    """Equivalent stress sqrt(3/2 s:s) of Cauchy stresses.

    Args:
        cauchy (array (..., 3, 3)): as in ``SoftGrain.points()['cauchy']`` [Pa].

    Returns:
        array (...): [Pa].

    Raises:
        ValueError: another shape.
    """
    cauchy = array("cauchy", cauchy)
    if cauchy.shape[-2:] != (3, 3):
        raise ValueError(f"cauchy has shape {cauchy.shape}; admissible: (..., 3, 3)")
    mean = np.trace(cauchy, axis1=-2, axis2=-1) / 3
    deviator = cauchy - mean[..., None, None] * np.eye(3)
    return np.sqrt(1.5 * np.sum(deviator**2, axis=(-2, -1)))


def cell_volume():
    """Volume of the periodic cell [m³]; beside 2D grains the area of its face in their plane [m²].

    Raises:
        ValueError: the scene is not periodic, or has no soft grain.
    """
    grains = soft_bodies()
    if not O.periodic or not grains:
        raise ValueError(
            "a periodic cell with soft grains is needed where no area (volume) of a box is given, "
            "but " + ("the scene has none" if O.periodic else "O.periodic is False")
        )
    size = np.array(O.cell.hSize)
    return abs(np.linalg.det(size[:2, :2] if grains[0].shape.dim == 2 else size))


def cell_stress(source="contacts"):
    """Mean stress of a periodic cell, tension positive.

    Args:
        source (str): 'contacts': sum of contact forces times branch vectors between centres of
            mass, over the volume of the cell, as ``utils.getStress`` has it, but for branches to
            bodies that are held, which end where these are touched; 'grains': integral of the
            Cauchy stress over the grains, over the same volume, in plane stress per unit of
            undeformed thickness, as forces are. Less, in both, the momentum
            that grains carry relative to the mean flow, m c c with c = v - velGrad x less the mean
            of that by mass. They agree on the mean over a time that is long beside the vibrations
            of the grains; in space within 1e-3 (doc/decisions/0030-hourglass.md). With contact
            'points' or 'nodes' forces act across a distance that is in no grain, and 'grains' is
            the lower: 14 and 8 % at zeta = 0.25 and 0.15 ('points', 3 x 3 disks).

    Returns:
        array (3, 3): [Pa]. In 2D the out-of-plane stress is that of the grains, 0 with 'contacts'.

    Raises:
        ValueError: an unknown source, or no periodic cell with soft grains. With rigid bodies
            present, 'grains' is refused: their stress is not known.
    """
    if source not in ("contacts", "grains"):
        raise ValueError(f"source = {source!r} is unknown; known: 'contacts', 'grains'")
    volume = cell_volume()
    rigid = [b for b in O.bodies if b and b.shape and not is_soft(b)]
    if source == "grains" and rigid:
        raise ValueError(f"source = 'grains': body #{rigid[0].id} is rigid, its stress unknown")
    total = _contact_moments() if source == "contacts" else _integral_of_stress()
    return (total - _carried_momentum()) / volume


def _carried_momentum():
    """Sum of m c c, c the velocity beyond the flow of the cell and the mean motion."""
    flow = np.array(O.cell.velGrad)
    bodies = [b for b in O.bodies if b and has_own_motion(b)]
    mass = np.array([b.state.mass for b in bodies])
    c = np.array([np.array(b.state.vel) - flow @ np.array(b.state.pos) for b in bodies])
    c -= mass @ c / mass.sum()
    return np.einsum("b,bi,bj->ij", mass, c, c)


def _contact_moments():
    """Summed exactly: the order of ``O.interactions`` is not that of a loaded scene."""
    moments = [np.zeros((3, 3))]
    for i in O.interactions:
        if not i.isReal:
            continue
        force = np.array(i.phys.normalForce + i.phys.shearForce)
        image = np.array(O.cell.hSize) @ np.array(i.cellDist)
        branch = _branch_end(i.id1, np.zeros(3), i) - _branch_end(i.id2, image, i)
        moments.append(np.outer(force, branch))
    return np.apply_along_axis(math.fsum, 0, np.array(moments))


def _branch_end(body_id, image, interaction):
    """The centre of a body, shifted to an image; on one that is held, whose centre may lie anywhere
    (a floor), where it is touched."""
    whole = O.bodies[_whole_of(body_id)]
    if has_own_motion(whole):
        return np.array(whole.state.pos) + image
    return np.array(interaction.geom.contactPoint)


def _integral_of_stress():
    total = np.zeros((3, 3))
    for body in soft_bodies():
        points = body.shape.points()
        thickness = points["F"][:, 2, 2] if body.shape.dim == 2 else np.ones(1)
        total += np.einsum("p,pij->ij", points["volume"] * thickness, points["cauchy"])
    return total


def nearest_images(position, half_size, dim=3):
    """Displacements of a body to those of its images that reach into the periodic cell.

    Args:
        position (array (3,)): of its centre [m].
        half_size (float): radius of a ball about all of it [m].
        dim (int): with 2 displacements in the plane of 2D grains alone.

    Returns:
        list of ndarray: of shape (3,) [m]; the first one puts the centre into the cell. A single
        zero if the scene is not periodic.
    """
    if not O.periodic:
        return [np.zeros(3)]
    cell = np.array(O.cell.hSize)
    inverse = np.linalg.inv(cell)
    share = inverse @ np.asarray(position)
    home = -np.floor(share)
    share += home
    reach = half_size * np.linalg.norm(inverse, axis=1)
    steps = [
        np.array(step)
        for step in itertools.product((0, -1, 1), (0, -1, 1), (0, -1, 1) if dim == 3 else (0,))
        if np.all(share + step + reach >= 0) and np.all(share + step - reach <= 1)
    ]
    return [cell @ (home + step) for step in steps]


def wall_force(body_id):
    """Force of all contacts on a wall, or any other body, in the last step; on a clump that on all
    its members.

    ``O.forces.f(body_id)`` has besides what pushes a body that is free, as a wall under stress is.

    Args:
        body_id (int): of the body.

    Returns:
        array (3,): [N, 2D N/m].

    Raises:
        ValueError: there is no such body.
    """
    body_id = index("body_id", body_id)
    force = np.array(_softgrain.contactForce(body_id))
    if not O.bodies[body_id].isClump:
        return force
    members = O.bodies[body_id].shape.members
    return np.sum([_softgrain.contactForce(member) for member in members], axis=0)


def coordination_number():
    """Mean number of bodies that a soft grain exchanges force with, walls and rigid ones included,
    a clump as one [-].

    Raises:
        ValueError: the scene has no soft grain.
    """
    bodies = some_soft_bodies("coordination_number")
    ids = {b.id for b in bodies}
    partners = set()  # (soft grain, what it touches)
    for i in O.interactions:
        if i.isReal and isinstance(i.phys, wrapper.SoftPhys) and i.phys.activeContacts > 0:
            ends = (i.id1, i.id2)
            partners |= {(a, _whole_of(b)) for a, b in (ends, ends[::-1]) if a in ids}
    return len(partners) / len(bodies)


def _whole_of(body_id):
    """The clump that a body is a member of, or the body itself; by id."""
    body = O.bodies[body_id]
    return body.clumpId if body.isClumpMember else body_id


class Balance:
    """Relative closure of the energy balance since this object was made. What a script changes by
    hand (``vel``, ``young``, bodies erased), and what ``SoftenWhenLoaded`` turns soft, is no work
    that is booked: it counts as error.

    The work of walls, loads and a periodic cell must be found again as kinetic and elastic energy
    and as what friction, impacts and damping dissipated, and grains that fell asleep lost.

    Raises:
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
        self._check()
        self._start = self._stored_and_lost(integrator().energy())
        stiffness = sum(b.material.young * b.shape.undeformedVolume() for b in soft_bodies())
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
