"""Contacts of two grains, or of a grain and a wall, with a gap smaller than a given reach."""

from dataclasses import dataclass, field

import numpy as np

#: Overlaps of a node with an outline deeper than this (in dr) are no contacts any more.
DEEPEST_CONTACT = 1.5


@dataclass
class Contact:
    """A contact node of one body against a place on another body."""

    side: int  #: 0: the node belongs to the first body of the pair, 1: to the second
    node: int
    other: int  #: node of the other body for disk against disk, else -1
    partners: dict  #: nodes of the other body it leans on: share; empty for a wall
    normal: np.ndarray  #: unit, from the other body to the node
    gap: float  #: m, negative for an overlap
    impulse: np.ndarray = field(default_factory=lambda: np.zeros(2))  #: on the node, N s

    @property
    def key(self):
        """Its name within the pair, the same in every step."""
        return self.side, self.node, self.other


def contacts_of_grains(first, second, reach):
    """Contacts of two grains.

    Args:
        first, second (Grain): both with the same kind of contact nodes.
        reach (float): largest gap [m].

    Returns:
        list of Contact: sorted by key.
    """
    if first.has_surface:
        return nodes_on_outline(first, second, 0, reach) + nodes_on_outline(second, first, 1, reach)
    return disks_on_disks(first, second, reach)


def contacts_with_plane(grain, point, normal, reach):
    """Contacts of a grain with the plane through `point` on the side of `normal`, sorted by key.

    g = (x_s - point) . normal - node radius.
    """
    gaps = (grain.contact_positions() - point) @ normal - grain.contact_radius
    return [
        Contact(0, s, -1, {}, normal, gap) for s, gap in enumerate(gaps) if gap < reach
    ]


def disks_on_disks(first, second, reach):
    """Contact nodes as disks: g = |x_s - x_t| - the two radii."""
    touch = first.contact_radius + second.contact_radius
    contacts = []
    for s, x in enumerate(first.contact_positions()):
        for t, y in enumerate(second.contact_positions()):
            distance = np.linalg.norm(x - y)
            if distance - touch < reach:
                normal = (x - y) / distance
                contacts.append(Contact(0, s, t, {t: 1.0}, normal, distance - touch))
    return contacts


def nodes_on_outline(grain, other, side, reach):
    """Surface nodes of `grain` against the outline of `other`."""
    outline = other.contact_positions()
    normals = outline_normals(outline)
    deepest = DEEPEST_CONTACT * max(grain.point_spacing, other.point_spacing)
    contacts = []
    for s, x in enumerate(grain.contact_positions()):
        place = nearest_place(x, outline)
        normal, gap = smooth_gap(x, outline, normals, place)
        if -deepest <= gap < reach:
            contacts.append(Contact(side, s, -1, place, normal, gap))
    return contacts


def outline_normals(outline):
    """Outward unit normals at the nodes of a counter-clockwise polygon, shape (nodes, 2).

    Those of the two segments that meet there, weighted with their lengths.
    """
    edge = np.roll(outline, -1, axis=0) - outline
    segment_normal = np.column_stack([edge[:, 1], -edge[:, 0]])
    normal = segment_normal + np.roll(segment_normal, 1, axis=0)
    return normal / np.linalg.norm(normal, axis=1)[:, None]


def nearest_place(x, outline):
    """Point of a closed polygon nearest to x.

    Returns:
        dict: the two nodes of its segment with their shares 1 - t and t.
    """
    edge = np.roll(outline, -1, axis=0) - outline
    t = np.einsum("sa,sa->s", x - outline, edge) / np.einsum("sa,sa->s", edge, edge)
    t = np.clip(t, 0, 1)
    distance = np.linalg.norm(x - outline - t[:, None] * edge, axis=1)
    s = int(np.argmin(distance))
    return {s: 1 - t[s], (s + 1) % len(outline): t[s]}


def smooth_gap(x, outline, normals, place):
    """Normal and gap of a node at x over a place between the outline nodes i and j.

    With shares w_i, w_j, foot y = w_i x_i + w_j x_j, n = (w_i n_i + w_j n_j) made unit:
    g = (x - y) . n - b. The true outline bulges over the segment by
    b = 1/2 w_i w_j (n_j - n_i) . (x_j - x_i), which is the arc through both nodes to second order.

    Returns:
        tuple: n, shape (2,), and g [m].
    """
    (i, w_i), (j, w_j) = place.items()
    foot = w_i * outline[i] + w_j * outline[j]
    normal = w_i * normals[i] + w_j * normals[j]
    normal = normal / np.linalg.norm(normal)
    bulge = 0.5 * w_i * w_j * (normals[j] - normals[i]) @ (outline[j] - outline[i])
    return normal, (x - foot) @ normal - bulge
