"""The outline of disks that overlap, as clumps are made of. Plain numpy; nothing of a scene."""

import numpy as np

#: Vertices on an arc are this far apart at most [rad]: areas are right to a thousandth.
ARC_STEP = 2 * np.pi / 100
#: Places on outlines are the same, and disks touch, within this share of the smallest radius.
SAME_PLACE = 1e-6


def outline_of_disks(centres, radii):
    """The outline of the union of disks, as a polygon.

    Args:
        centres (array): shape (n, 2), n >= 1 [m].
        radii (array): shape (n,), > 0 [m].

    Returns:
        tuple: vertices in counter-clockwise order (ndarray of shape (m, 2)) [m], and the indices of
        those at which two disks meet (list of int), where the outline has a kink.

    Raises:
        ValueError: the union falls into parts, or encloses a hole.
    """
    centres, radii = np.asarray(centres, float), np.asarray(radii, float)
    visible = [k for k in range(len(radii)) if not _is_covered(k, centres, radii)]
    centres, radii = centres[visible], radii[visible]
    arcs = [
        _points(centre, radius, *angles)
        for k, (centre, radius) in enumerate(zip(centres, radii))
        for angles in _free_angles(k, centres, radii)
    ]
    loop = _joined(arcs, SAME_PLACE * radii.min())
    if loop is None:
        raise ValueError("the union of the disks falls into parts, or encloses a hole")
    starts = np.cumsum([0] + [len(arc) - 1 for arc in loop[:-1]])
    corners = starts.tolist() if len(loop) > 1 else []
    return np.concatenate([arc[:-1] for arc in loop]), corners


def _is_covered(k, centres, radii):
    """Whether a disk lies within another one; of two that are the same the first stays."""
    distance = np.linalg.norm(centres - centres[k], axis=1)
    slack = SAME_PLACE * radii.min()
    within = distance + radii[k] <= radii + slack
    same = within & (np.abs(radii - radii[k]) <= slack)
    within[same] = np.flatnonzero(same) < k
    return within.any()


def _free_angles(k, centres, radii):
    """Beginnings and ends of the arcs of a circle that lie in no other disk [rad]."""
    others = np.arange(len(radii)) != k
    meetings = []
    for apart, radius in zip(centres[others] - centres[k], radii[others]):
        distance = np.linalg.norm(apart)
        if distance >= radii[k] + radius:
            continue
        half = np.arccos((radii[k] ** 2 + distance**2 - radius**2) / (2 * radii[k] * distance))
        towards = np.arctan2(apart[1], apart[0])
        meetings += [towards - half, towards + half]
    if not meetings:
        return [(0.0, 2 * np.pi)]
    begins = np.sort(np.mod(meetings, 2 * np.pi))
    ends = np.append(begins[1:], begins[0] + 2 * np.pi)
    middles = (begins + ends) / 2
    places = centres[k] + radii[k] * np.stack([np.cos(middles), np.sin(middles)], axis=1)
    distance = np.linalg.norm(places[:, None] - centres[others], axis=2)
    free = (distance >= radii[others]).all(axis=1) & (ends - begins > SAME_PLACE)
    return list(zip(begins[free], ends[free]))


def _points(centre, radius, begin, end):
    """On an arc, both ends among them."""
    count = max(int(np.ceil((end - begin) / ARC_STEP)), 1)
    angle = np.linspace(begin, end, count + 1)
    return centre + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def _joined(arcs, slack):
    """All arcs in the order in which each begins where the last one ends; None if they do not make
    one loop."""
    loop, left = [arcs[0]], list(arcs[1:])
    while left:
        gaps = [np.linalg.norm(arc[0] - loop[-1][-1]) for arc in left]
        if min(gaps) > slack:
            return None
        loop.append(left.pop(int(np.argmin(gaps))))
    closed = np.linalg.norm(loop[-1][-1] - loop[0][0]) <= slack
    return loop if closed else None
