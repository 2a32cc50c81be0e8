"""Reading soft scenes: areas, stresses, forces, coordination."""

import numpy as np
from yade import O, wrapper

from softgrain import _softgrain
from softgrain.bodies import is_soft, some_soft_bodies, whole_of
from softgrain.cell import volume_for
from softgrain.checks import array, index, number
from softgrain.time_loop import integrators


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
        box_area = volume_for("packing_fraction without box_area")
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
            partners |= {(a, whole_of(b)) for a, b in (ends, ends[::-1]) if a in ids}
    return len(partners) / len(bodies)
