"""A periodic cell: its volume, its mean stress, images of bodies in it."""

import itertools
import math

import numpy as np
from yade import O

from softgrain.bodies import has_own_motion, is_soft, soft_bodies, whole_of


def cell_volume():
    """Volume of the periodic cell [m³]; beside 2D grains the area of its face in their plane [m²].

    Raises:
        ValueError: the scene is not periodic, or has no soft grain.
    """
    return volume_for("cell_volume")


def volume_for(asker):
    """The same for a function of that name, which the message has."""
    grains = soft_bodies()
    if not O.periodic or not grains:
        missing = "the scene has no soft grain" if O.periodic else "O.periodic is False"
        raise ValueError(f"{asker} needs a periodic cell with soft grains, but {missing}")
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
    volume = volume_for("cell_stress")
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
    whole = O.bodies[whole_of(body_id)]
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
