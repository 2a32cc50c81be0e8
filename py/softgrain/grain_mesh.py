"""A grain as triangles with values of its material points at their corners, to be drawn."""

import numpy as np
from matplotlib.path import Path
from scipy import spatial


def outline_polygon(body):
    """Outline of a 2D grain in order around it, (n, 2) [m]; for 'points' geometry the boundary
    points by their angle about their mean, as far as that goes for outlines with notches."""
    outline = body.shape.outline()[:, :2]
    if body.shape.contact == "points":
        centre = outline.mean(axis=0)
        outline = outline[np.argsort(np.arctan2(*(outline - centre).T[::-1]))]
    return outline


def filled(points, values, outline):
    """A 2D grain: triangles between material points, and up to the outline, which has the values
    of the nearest ones.

    Args:
        points (array (p, 2)): places of the material points [m].
        values (array (p, ...)): at these.
        outline (array (n, 2)): as of :func:`outline_polygon` [m].

    Returns:
        tuple: places (p + n, 2), triangles (t, 3) as indices of places, values at places.
    """
    places = np.vstack([points, outline])
    mesh = spatial.Delaunay(places).simplices
    inside = Path(outline).contains_points(places[mesh].mean(axis=1))
    return places, mesh[inside], np.concatenate([values, _nearest(points, values, outline)])


def shell(body, points, values):
    """The surface of a 3D grain, with the values of the nearest material points; for 'points'
    geometry the convex hull of the boundary points.

    Args:
        body (Body): the grain.
        points (array (p, 3)), values (array (p, ...)): as in :func:`filled`.

    Returns:
        tuple: places (n, 3), triangles (t, 3) with normals outwards, values at places.
    """
    places = body.shape.outline()
    triangles = body.shape.facets() if body.shape.contact != "points" else _hull(places)
    return places, triangles, _nearest(points, values, places)


def _nearest(points, values, places):
    return values[spatial.cKDTree(points).query(places)[1]]


def _hull(places):
    hull = spatial.ConvexHull(places)
    a, b, c = places[hull.simplices].transpose(1, 0, 2)
    inwards = np.einsum("ti,ti->t", np.cross(b - a, c - a), hull.equations[:, :3]) < 0
    return np.where(inwards[:, None], hull.simplices[:, ::-1], hull.simplices)
