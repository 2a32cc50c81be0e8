"""Outlines of 2D grains as polygons: moments, the form that congruent ones share. Plain numpy;
nothing of a scene."""

from dataclasses import dataclass

import numpy as np
from scipy import optimize, spatial

from softgrain.checks import indices

#: Vertices at which a polygon turns by more than this are corners, if nothing else is said [rad].
CORNER_TURN = np.radians(20)
#: Longest side of the bounding box over half the width of the hull; the kernel bounds the distance
#: from the centroid over the radius of the largest circle inside.
SLENDEREST = 1000


@dataclass
class Outline:
    """A polygon, and where it lies.

    Attributes:
        vertices (ndarray): about the centroid, the first of the longest sides along x,
            counter-clockwise, the largest circle inside of radius 1; shape (n, 2) [-]. The same
            for all congruent polygons.
        corners (list of int): those at which it has a kink.
        radius (float): of the largest circle inside [m].
        centroid (ndarray): shape (2,) [m].
        angle (float): by which `vertices` is turned to lie as given [rad].
    """

    vertices: np.ndarray
    corners: list
    radius: float
    centroid: np.ndarray
    angle: float


def signed_area(vertices):
    """Of a polygon, positive if counter-clockwise [m²]."""
    a = vertices - vertices.mean(axis=0)
    b = np.roll(a, -1, axis=0)
    return np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) / 2


def area_and_inertia(vertices):
    """Of a polygon: area [m²], centroid [m], and moment of inertia about it for unit density [m⁴].

    Args:
        vertices (array): counter-clockwise, shape (n, 2) [m].

    Returns:
        tuple: area (float), centroid (ndarray of shape (2,)), inertia (float).
    """
    start = np.asarray(vertices, float)
    origin = start.mean(axis=0)  # near the polygon: saves digits
    a = start - origin
    b = np.roll(a, -1, axis=0)
    twice = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    area = twice.sum() / 2
    centroid = twice @ (a + b) / (6 * area)
    about_origin = twice @ np.sum(a * a + a * b + b * b, axis=1) / 12
    return area, origin + centroid, about_origin - area * centroid @ centroid


def turns(vertices):
    """Angles by which a closed polygon turns at its vertices, shape (n,), positive to the left."""
    edge = np.roll(vertices, -1, axis=0) - vertices
    before = np.roll(edge, 1, axis=0)
    cross = before[:, 0] * edge[:, 1] - before[:, 1] * edge[:, 0]
    return np.arctan2(cross, np.sum(before * edge, axis=1))


def _ways_from_sides(points, vertices):
    """From the nearest place of each of n sides of a polygon to m points; shape (m, n, 2)."""
    x = points[:, None, :]
    edge = np.roll(vertices, -1, axis=0) - vertices
    along = np.sum((x - vertices) * edge, axis=2) / np.sum(edge**2, axis=1)
    return x - (vertices + np.clip(along, 0, 1)[:, :, None] * edge)


def depth_inside(points, vertices):
    """Distance of points from the sides of a polygon, negative outside; shape (m,)."""
    distance = np.linalg.norm(_ways_from_sides(points, vertices), axis=2).min(axis=1)
    x = points[:, None, :]
    a, b = vertices, np.roll(vertices, -1, axis=0)
    edge = b - a
    level = (a[:, 1] > x[:, :, 1]) != (b[:, 1] > x[:, :, 1])
    rise = np.where(edge[:, 1] == 0, 1, edge[:, 1])
    to_the_right = x[:, :, 0] < a[:, 0] + (x[:, :, 1] - a[:, 1]) / rise * edge[:, 0]
    inside = np.sum(level & to_the_right, axis=1) % 2 == 1
    return np.where(inside, distance, -distance)


def inradius(vertices):
    """Radius of the largest circle inside a polygon: squares that may hold a better centre are
    divided until none may by more than 2 %, then the best centre is improved where it is."""
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    half = (high - low).max() / 16
    line = (np.arange(8) + 0.5) * 2 * half
    centre = low + np.stack(np.meshgrid(line, line), axis=-1).reshape(-1, 2)
    quarters = np.array([(-1, -1), (1, -1), (-1, 1), (1, 1)])
    best, place = 0.0, centre[0]
    while len(centre):
        depth = depth_inside(centre, vertices)
        if depth.max() > best:
            best, place = depth.max(), centre[depth.argmax()]
        centre = centre[depth + np.sqrt(2) * half > 1.02 * best]
        half /= 2
        centre = (centre[:, None, :] + half * quarters).reshape(-1, 2)
    return _largest_depth_about(place, vertices)


def _largest_depth_about(place, vertices):
    """Distance of the sides of a polygon from the place where it is largest, uphill from a place
    inside. Distances from sides are convex, so that they are not below their tangents: the place
    where the least of the tangents is largest is never worse, and no side lies between."""
    depth = 0.0
    for _ in range(50):  # two or three do for convex polygons, five for others
        way = _ways_from_sides(place[None], vertices)[0]
        distance = np.linalg.norm(way, axis=1)
        if distance.min() <= depth * (1 + 1e-10):
            break
        depth = distance.min()
        tangents = np.column_stack((-way / distance[:, None], np.ones(len(way))))
        best = optimize.linprog((0, 0, -1), tangents, distance, bounds=(None, None))
        place = place + best.x[:2]
    return depth


def width(vertices):
    """Smallest distance of two parallel lines between which a polygon lies [m]; vertices of shape
    (n, 2) [m]."""
    hull = spatial.ConvexHull(vertices)
    beyond = hull.equations[:, :2] @ vertices.T + hull.equations[:, 2:]
    return -beyond.min(axis=1).max()


def normalized(vertices, corners=None):
    """The form that a polygon shares with those congruent to it (up to translation, rotation and
    size, not reflection).

    Args:
        vertices (array): in order around it, either way, shape (n, 2), n >= 3 [m].
        corners (iterable of int | None): vertices at which the outline has a kink; None: those at
            which it turns by more than 20 degrees.

    Returns:
        Outline.

    Raises:
        ValueError: no polygon, or an index that is out of range.
    """
    x = _checked_vertices(vertices)
    sharp = _sharp_vertices(x, corners)
    area = signed_area(x)
    if area < 0:
        x, sharp, area = x[::-1], sharp[::-1], -area
    _refuse_shape(x, area)
    size, centroid = np.sqrt(area), area_and_inertia(x)[1]
    x = (x - centroid) / size
    first = _first_side(x, sharp)
    x, sharp = np.roll(x, -first, axis=0), np.roll(sharp, -first)
    angle = np.arctan2(*(x[1] - x[0])[::-1])
    c, s = np.cos(angle), np.sin(angle)
    x = np.round(x @ np.array([[c, -s], [s, c]]), 9) + 0.0  # equal digits for congruent ones
    size /= np.sqrt(signed_area(x))
    radius = inradius(x)
    return Outline(
        x / radius, np.flatnonzero(sharp).tolist(), float(radius * size), centroid, float(angle)
    )


def _checked_vertices(vertices):
    """As an array of shape (n, 2)."""
    try:
        x = np.array(vertices, float)
    except (TypeError, ValueError):
        raise ValueError("vertices: admissible are numbers of shape (n, 2)") from None
    if x.ndim != 2 or x.shape[1] != 2 or len(x) < 3 or not np.isfinite(x).all():
        raise ValueError(
            f"vertices has shape {x.shape}; admissible: (n, 2) with n >= 3, finite numbers"
        )
    repeated = np.flatnonzero(~(np.linalg.norm(np.roll(x, -1, axis=0) - x, axis=1) > 0))
    if len(repeated):
        raise ValueError(
            f"vertices: {repeated[0]} and the one after it are the same (the last one joins the "
            "first by itself)"
        )
    return x


def _sharp_vertices(x, corners):
    """Whether the outline has a kink at each of the vertices."""
    if corners is None:
        return np.abs(turns(x)) > CORNER_TURN
    corners = indices("corners", corners)
    if any(not 0 <= c < len(x) for c in corners):
        raise ValueError(f"corners = {corners}: indices are in [0, {len(x) - 1}]")
    return np.isin(np.arange(len(x)), corners)


def _refuse_shape(x, area):
    """ValueError for a polygon that goes round anything else than once, or is too slender."""
    if not area > 1e-9 * np.ptp(x, axis=0).max() ** 2:
        raise ValueError(
            f"vertices: the area of the polygon is {area:g} m^2; admissible: > 0, "
            "without crossings"
        )
    turned = np.degrees(turns(x).sum())
    if abs(turned - 360) > 1:
        raise ValueError(
            f"vertices: the polygon crosses or touches itself, as it turns by {turned:.0f} degrees "
            "in all; admissible: 360, once round"
        )
    slenderness = np.ptp(x, axis=0).max() / (width(x) / 2)
    if slenderness > SLENDEREST:  # the circle inside is smaller still, and takes long to be found
        raise ValueError(
            f"vertices: the polygon is {slenderness / 2:.3g} times as long as wide; admissible: "
            f"at most {SLENDEREST / 2:g}"
        )


def _first_side(x, sharp):
    """Index of the side from which on lengths, turns and corners, read around, come last in the
    order of words: it does not depend on where the list of vertices begins."""
    lengths = np.linalg.norm(np.roll(x, -1, axis=0) - x, axis=1)
    letters = list(zip(np.round(lengths, 6), np.round(turns(x), 6), sharp))
    return max(range(len(x)), key=lambda k: letters[k:] + letters[:k])
