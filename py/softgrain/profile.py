"""The contact of a pair in 2D seen along the contact: tractions and width."""

import numpy as np
from yade import Interaction, O, wrapper

from softgrain.checks import array

#: Of forces, over the largest one: normal parts of tangential impulses.
ROUNDING = 1e-12


def contact_profile(interaction):
    """Contact points of a pair in the last step, ordered along the contact.

    The tractions are those of ``interaction.geom.contacts()``.

    Args:
        interaction (Interaction): of a soft grain (2D) and any other body.

    Returns:
        dict of arrays, by increasing position: side and node of the contact point, as in
        ``contacts()``; position along the tangent, which is the one of the two across
        ``geom.normal`` that points to where x, or y if that is its larger component, grows, from
        the origin of space [m]; force normal to the contact, compression positive [N/m]; length
        that the node stands for [m]; pressure, and shear along the tangent, on the grain that owns
        the node, smoothed over about one spacing of background nodes [Pa]. The last three are 0
        unless the contact geometry is 'surface'. In plane stress forces and tractions are per unit
        of undeformed thickness.

    Raises:
        ValueError: the interaction is not one of a soft grain in 2D, or not real (any more).
    """
    _require_soft(interaction)
    contacts = interaction.geom.contacts()
    tangent = _tangent(np.array(interaction.geom.normal))
    position = contacts["point"] @ tangent
    columns = {
        "side": contacts["side"],
        "node": contacts["node"],
        "position": position,
        "force": np.sum(contacts["force"] * contacts["normal"], axis=1),
        "length": contacts["area"],
        "pressure": contacts["pressure"],
        "shear": contacts["shear"] @ tangent,
    }
    order = np.argsort(position, kind="stable")
    return {name: values[order] for name, values in columns.items()}


def _require_soft(interaction):
    if not isinstance(interaction, Interaction):
        raise ValueError(f"interaction = {interaction!r}: admissible is one of O.interactions")
    ids = (interaction.id1, interaction.id2)
    name = f"interaction = #{ids[0]}, #{ids[1]}"
    present = all(i < len(O.bodies) and O.bodies[i] for i in ids)
    if not (present and O.interactions.has(*ids) and interaction.isReal):
        raise ValueError(f"{name}: not in contact; admissible is a real one of O.interactions")
    shapes = [O.bodies[i].shape for i in ids]
    if not any(isinstance(s, wrapper.SoftGrain) and s.dim == 2 for s in shapes):
        raise ValueError(f"{name}: not one of a soft grain in 2D")


def _tangent(normal):
    across = np.array([normal[1], -normal[0], 0])
    return across if across[np.argmax(np.abs(across))] > 0 else -across


def contact_halfwidth(position, force):
    """Half-width of a contact from the second moment of its forces.

    a = 2 sqrt(sum f (x - c)² / sum f), c the centre of the forces: exact for the elliptical
    pressure p0 sqrt(1 - (x - c)²/a²) of Hertz, to which contacts of disks stay close. Unlike the
    place of the outermost loaded node it does not jump when a node comes into contact.

    Args:
        position (array): of the nodes along the contact [m].
        force (array): on them, >= 0 [N or N/m]; of contacts that also pull ``numpy.maximum(force,
            0)``.

    Returns:
        float: a [m]; 0 without force and of one node. It takes three or more nodes to be near
            that of Hertz.

    Raises:
        ValueError: a force is negative or no number, a position no finite one, or there are not as
            many of these as of those.
    """
    position, force = array("position", position), array("force", force)
    if position.ndim != 1 or position.shape != force.shape:
        raise ValueError(
            f"position, force have shapes {position.shape}, {force.shape}; admissible: (n,) both"
        )
    if not np.isfinite(position).all():
        raise ValueError("position holds a value outside the admissible range (-inf, inf) m")
    if not np.isfinite(force).all() or np.any(force < -ROUNDING * np.abs(force).max(initial=0)):
        raise ValueError("force holds a value outside the admissible range [0, inf)")
    total = np.sum(force)
    if not total > 0:
        return 0.0
    centre = np.dot(force, position) / total
    return 2 * np.sqrt(np.dot(force, (position - centre) ** 2) / total)
