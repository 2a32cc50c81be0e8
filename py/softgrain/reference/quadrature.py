"""Material points of a unit disk: where they are, and how much each stands for."""

import math
from itertools import product

import numpy as np

from .grid import DIM

AREA = np.pi

#: Corners of a square about the origin, the first coordinate running fastest.
CORNERS = np.array([(-1, -1), (1, -1), (-1, 1), (1, 1)])
#: Cells with a centre less than this inside the outline (in dr) are divided at the rim.
RIM_DEPTH = 1.0
#: Cuts are resolved down to 1/2^6 of a cell; there the outline is taken as straight.
CUT_DEPTH = 6
#: Cells that hold less than this share of their area hold no material point.
NEGLIGIBLE_SHARE = 1e-9


def material_points(rule, spacing):
    """Material points on a square lattice of side dr with a cell corner at the centre.

    Args:
        rule (str): 'cutCell': every cell is cut with the outline, its point lies at the centroid of
            what is inside, with that area as weight; cells at the rim, with a centre less than dr
            inside, are first divided into four parts with a point each; 'lattice': cell centres
            inside, equal weights.
        spacing (float): dr.

    Returns:
        tuple: Xp (points, 2); Vp0 (points,), scaled to the exact area pi.
    """
    held = []  # area inside, first moment of it
    for cell, whole in occupied_cells(rule, spacing).items():
        centre = (np.array(cell) + 0.5) * spacing
        if rule == "cutCell" and np.linalg.norm(centre) - 1 > -RIM_DEPTH * spacing:
            parts = (
                moments_inside(c, 0.5 * spacing, CUT_DEPTH - 1)
                for c in quarter_centres(centre, spacing)
            )
            held += [part for part in parts if part[0] > NEGLIGIBLE_SHARE * spacing**DIM]
        else:
            held.append(whole)
    area = np.array([area for area, _ in held])
    return np.array([moment / area for area, moment in held]), area * AREA / area.sum()


def boundary_points(rule, spacing):
    """Centroids of the cells with an empty neighbour, one a cell, shape (cells, 2)."""
    held = occupied_cells(rule, spacing)
    return np.array(
        [moment / area for cell, (area, moment) in held.items() if _has_empty_neighbour(cell, held)]
    )


def occupied_cells(rule, spacing):
    """Cells that hold something.

    Returns:
        dict: cell, in lexicographic order: area inside, first moment of it.
    """
    reach = int(np.ceil(1 / spacing))
    held = {}
    for cell in product(range(-reach, reach), repeat=DIM):
        centre = (np.array(cell) + 0.5) * spacing
        if rule == "cutCell":
            area, moment = moments_inside(centre, spacing, CUT_DEPTH)
        else:
            area, moment = (1.0, centre) if np.linalg.norm(centre) < 1 else (0.0, 0 * centre)
        if area > NEGLIGIBLE_SHARE * spacing**DIM:
            held[cell] = area, moment
    return held


def moments_inside(centre, side, depth):
    """Area and first moment of the part of a square inside the unit circle.

    A cut square is divided into four; at the last level the outline is a straight line at its
    distance from the centre, parallel to a side.

    Args:
        centre (ndarray): of the square, shape (2,).
        side (float): of the square.
        depth (int): levels of division left.

    Returns:
        tuple: area, and first moment of shape (2,).
    """
    distance = math.hypot(*centre) - 1
    half_diagonal = 0.5 * side * np.sqrt(DIM)
    if distance >= half_diagonal:
        return 0.0, np.zeros(DIM)
    if distance <= -half_diagonal or depth == 0:
        area = side**DIM * min(max(0.5 - distance / side, 0.0), 1.0)
        return area, area * centre
    area, moment = 0.0, np.zeros(DIM)
    for c in quarter_centres(centre, side):
        part = moments_inside(c, 0.5 * side, depth - 1)
        area, moment = area + part[0], moment + part[1]
    return area, moment


def quarter_centres(centre, side):
    """Centres of the four parts of a square, shape (4, 2)."""
    return centre + 0.25 * side * CORNERS


def _has_empty_neighbour(cell, held):
    neighbours = (cell + step * axis for axis in np.eye(DIM, dtype=int) for step in (-1, 1))
    return any(tuple(neighbour.tolist()) not in held for neighbour in neighbours)
