"""What a wall feels along its contact with a soft disk: pressure and width."""

import numpy as np
from yade import O, wrapper


def contact_profile(interaction):
    """Pressure of a soft disk on a wall in the last step, node by node.

    The force of a contact node is spread over the length that the node stands for: half of the way
    to the neighbours on either side along the wall.

    Args:
        interaction (Interaction): of a soft disk (2D) and a ``Wall``.

    Returns:
        dict of arrays, by increasing position: node (contact node of the disk), position along the
        wall [m], length that the node stands for [m], force along the wall's normal [N/m],
        pressure = force/length [Pa]. Nodes that are near but carry nothing have pressure 0. In
        plane stress forces, and so pressures, are per unit of undeformed thickness.

    Raises:
        ValueError: the interaction is not one of a soft disk and a wall.
    """
    wall, disk = _wall_and_disk(interaction)
    contacts = interaction.geom.contacts()
    position = contacts["point"][:, 1 - wall.shape.axis]
    order = np.argsort(position, kind="stable")
    position = position[order]
    impulse = np.sum(contacts["impulse"] * contacts["normal"], axis=1)[order]
    length = (
        np.gradient(position)
        if len(position) > 1
        else np.full(len(position), disk.shape.zeta * disk.shape.radius)
    )
    total = impulse.sum()
    force = impulse * (interaction.phys.normalForce.norm() / total if total > 0 else 0.0)
    return {
        "node": contacts["node"][order],
        "position": position,
        "length": length,
        "force": force,
        "pressure": force / length,
    }


def _wall_and_disk(interaction):
    bodies = [O.bodies[i] for i in (interaction.id1, interaction.id2)]
    walls = [b for b in bodies if isinstance(b.shape, wrapper.Wall)]
    disks = [b for b in bodies if isinstance(b.shape, wrapper.SoftGrain) and b.shape.dim == 2]
    if not (len(walls) == len(disks) == 1):
        raise ValueError(
            f"interaction = #{interaction.id1}, #{interaction.id2}: not one of a soft disk (2D) "
            "and a Wall"
        )
    return walls[0], disks[0]


def contact_halfwidth(position, force):
    """Half-width of a contact from the second moment of its forces.

    a = 2 sqrt(sum f (x - c)² / sum f), c the centre of the forces: exact for the elliptical
    pressure p0 sqrt(1 - (x - c)²/a²) of Hertz, to which contacts of disks stay close. Unlike the
    place of the outermost loaded node it does not jump when a node comes into contact.

    Args:
        position (array): of the nodes along the contact [m].
        force (array): on them, >= 0 [N or N/m].

    Returns:
        float: a [m]; 0 without force.
    """
    total = np.sum(force)
    if not total > 0:
        return 0.0
    centre = np.dot(force, position) / total
    return 2 * np.sqrt(np.dot(force, (position - centre) ** 2) / total)
