"""Contacts of two grains, or of a grain and a wall, with a gap smaller than a given reach."""

from dataclasses import dataclass, field

import numpy as np

#: Overlaps of a node with an outline deeper than this (in dr) are no contacts any more.
DEEPEST_CONTACT = 1.5

#: Twice the weights of four nodes on the curve between the middle ones, as polynomials: a row a
#: node, columns 1, t, t^2, t^3.
CATMULL_ROM = np.array([[0, -1, 2, -1], [2, 0, -5, 3], [0, 1, 4, -3], [0, 0, -1, 1]])

#: Steps of Newton's method towards the foot on that curve.
NEWTON_STEPS = 2


@dataclass
class Contact:
    """A contact node of one body against a place on another body."""

    side: int  #: 0: the node belongs to the first body of the pair, 1: to the second
    node: int
    other: int  #: node of the other body for disk against disk, else -1
    partners: dict  #: nodes of the other body it leans on: share; empty for a wall
    normal: np.ndarray  #: unit, from the other body to the node
    gap: float  #: m, negative for an overlap
    impulse: np.ndarray = field(default_factory=lambda: np.zeros(2))  #: reaction on the node, N s
    pull: np.ndarray = field(default_factory=lambda: np.zeros(2))  #: of tractions besides, N s
    drift: np.ndarray = field(default_factory=lambda: np.zeros(2))  #: of the wall or image, m/s
    slid: bool = False  #: in the last step in which it carried a reaction

    @property
    def key(self):
        """Its name within the pair, the same in every step."""
        return self.side, self.node, self.other


def contacts_of_grains(first, second, reach, shift=np.zeros(2), drift=np.zeros(2)):
    """Contacts of two grains, or of the first and an image of the second.

    Args:
        first, second (Grain): both with the same kind of contact nodes.
        reach (float): largest gap [m].
        shift (ndarray): place of the image relative to the second grain [m].
        drift (ndarray): its velocity relative to it [m/s].

    Returns:
        list of Contact: sorted by key.
    """
    if first.has_surface:
        contacts = nodes_on_outline(first, second, 0, reach, shift)
        contacts += nodes_on_outline(second, first, 1, reach, -shift)
    else:
        contacts = disks_on_disks(first, second, reach, shift)
    for contact in contacts:
        contact.drift = drift if contact.side == 0 else -drift
    return contacts


def turned_with(last, present, vector):
    """A vector turned as a unit normal was, from `last` to `present`; as it was if these differ by
    a right angle or more, which are normals of two places."""
    cosine = last @ present
    if cosine <= 0:
        return vector
    sine = last[0] * present[1] - last[1] * present[0]
    return np.array([[cosine, -sine], [sine, cosine]]) @ vector


def contacts_with_plane(grain, point, normal, reach):
    """Contacts of a grain with the plane through `point` on the side of `normal`, sorted by key.

    g = (x_s - point) . normal - node radius.
    """
    gaps = (grain.contact_positions() - point) @ normal - grain.contact_radius
    return [Contact(0, s, -1, {}, normal, gap) for s, gap in enumerate(gaps) if gap < reach]


def disks_on_disks(first, second, reach, shift):
    """Contact nodes as disks: g = |x_s - x_t| - the two radii."""
    touch = first.contact_radius + second.contact_radius
    contacts = []
    for s, x in enumerate(first.contact_positions()):
        for t, y in enumerate(second.contact_positions() + shift):
            distance = np.linalg.norm(x - y)
            if distance - touch < reach:
                normal = (x - y) / distance
                contacts.append(Contact(0, s, t, {t: 1.0}, normal, distance - touch))
    return contacts


def nodes_on_outline(grain, other, side, reach, shift):
    """Surface nodes of `grain` against the outline of `other`, shifted."""
    outline = other.contact_positions() + shift
    deepest = DEEPEST_CONTACT * max(grain.point_spacing, other.point_spacing)
    contacts = []
    for s, x in enumerate(grain.contact_positions()):
        place, normal, gap = measure_gap(x, outline)
        if -deepest <= gap < reach:
            contacts.append(Contact(side, s, -1, place, normal, gap))
    return contacts


def nearest_segment(x, outline):
    """Segment of a closed polygon nearest to x: its first node, and the share t of its second."""
    edge = np.roll(outline, -1, axis=0) - outline
    t = np.einsum("sa,sa->s", x - outline, edge) / np.einsum("sa,sa->s", edge, edge)
    t = np.clip(t, 0, 1)
    distance = np.linalg.norm(x - outline - t[:, None] * edge, axis=1)
    s = int(np.argmin(distance))
    return s, t[s]


def curve_weights(t):
    """Weights of four nodes in a row on the curve between the second and the third, and their
    derivatives by t.

    The cubic with the tangents (x_2 - x_0)/2 and (x_3 - x_1)/2 at its ends (Catmull and Rom).
    """
    powers = np.array([1, t, t**2, t**3])
    slopes = np.array([0, 1, 2 * t, 3 * t**2])
    return 0.5 * CATMULL_ROM @ powers, 0.5 * CATMULL_ROM @ slopes


def measure_gap(x, outline):
    """Gap of a node at x to the smooth curve through the nodes of a counter-clockwise polygon.

    The foot y = sum_k w_k x_k is the place of the curve, over the nearest segment, nearest to x;
    n is normal to the curve there, g = (x - y) . n.

    Returns:
        tuple: the nodes of the curve with their weights w_k (dict), n of shape (2,), and g [m].
    """
    s, t = nearest_segment(x, outline)
    nodes = [(s + k) % len(outline) for k in (-1, 0, 1, 2)]
    weights, slopes = curve_weights(t)
    for _ in range(NEWTON_STEPS):
        tangent = slopes @ outline[nodes]
        t = np.clip(t + (x - weights @ outline[nodes]) @ tangent / (tangent @ tangent), 0, 1)
        weights, slopes = curve_weights(t)
    tangent = slopes @ outline[nodes]
    normal = np.array([tangent[1], -tangent[0]]) / np.linalg.norm(tangent)
    gap = (x - weights @ outline[nodes]) @ normal
    return dict(zip(nodes, weights)), normal, gap
