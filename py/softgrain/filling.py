"""Discs (balls) that together fill a closed outline. Plain numpy; nothing of a scene."""

import numpy as np

#: So many balls times samples are tried at a time, for the sake of memory.
BATCH = 2_000_000
#: Distance of samples over the gap, by dimension: in 3D the number of samples is that of a surface.
SPACING = {2: 1, 3: 2}
#: No ball leaves an outline by more than that of its own radius: half of what contact dynamics lets
#: rigid bodies overlap what they rest on (``maxOverlap``).
DEEPEST = 0.05


def samples_of(vertices, facets, spacing):
    """Places on an outline, with their outward normals and the areas they stand for.

    Args:
        vertices (array): shape (n, dim) [m].
        facets (array): indices of the corners of each facet: in 2D segments, counter-clockwise
            around the outline, in 3D triangles with the normal outwards; shape (m, dim).
        spacing (float): facets are divided into parts of about this size, > 0 [m].

    Returns:
        tuple: places (k, dim) [m], normals (k, dim), areas (k,) [m², 2D m].
    """
    corner = np.asarray(vertices, float)[np.asarray(facets)]
    edges = np.roll(corner, -1, axis=1) - corner
    dim = corner.shape[2]
    if dim == 2:
        along = edges[:, 0]
        area = np.column_stack([along[:, 1], -along[:, 0]])
    else:
        area = 0.5 * np.cross(edges[:, 0], edges[:, 1])
    parts = np.ceil(np.linalg.norm(edges, axis=2).max(axis=1) / spacing).astype(int)
    places, normals, areas = [], [], []
    for number in np.unique(parts):
        weight = _centres_of_parts(number, dim)
        chosen = parts == number
        places.append(np.einsum("ka,fad->fkd", weight, corner[chosen]).reshape(-1, dim))
        size = np.linalg.norm(area[chosen], axis=1)
        normals.append(np.repeat(area[chosen] / size[:, None], len(weight), axis=0))
        areas.append(np.repeat(size / len(weight), len(weight)))
    return np.concatenate(places), np.concatenate(normals), np.concatenate(areas)


def _centres_of_parts(number, dim):
    """Weights of the corners of a facet at the centres of its equal parts, whose sides are those of
    the facet over `number`; shape (number^(dim - 1), dim)."""
    if dim == 2:
        share = (np.arange(number) + 0.5) / number
        return np.column_stack([1 - share, share])
    i, j = np.meshgrid(np.arange(number), np.arange(number), indexing="ij")
    upright = np.stack([i, j], axis=-1)[i + j < number] + 1 / 3
    turned = np.stack([i, j], axis=-1)[i + j < number - 1] + 2 / 3
    share = np.concatenate([upright, turned]) / number
    return np.column_stack([1 - share.sum(axis=1), share])


def largest_balls(places, normals, chosen, depth):
    """Radii of the largest balls inside an outline that touch it at some of its samples, no sample
    being deeper than `depth` in them (shrinking balls: they are about the medial axis).

    Args:
        places, normals (array): samples of the outline, as :func:`samples_of` has them.
        chosen (array): indices of the samples at which the balls touch, shape (k,).
        depth (float): >= 0 [m].

    Returns:
        ndarray: radii, shape (k,) [m].
    """
    touched, inward = places[chosen], -normals[chosen]
    below = inward @ places.T - np.sum(inward * touched, axis=1)[:, None]
    limits = below > depth
    return np.divide(
        _squares(touched, places) - depth**2,
        2 * (below - depth),
        out=np.full(below.shape, np.inf),
        where=limits,
    ).min(axis=1)


def _squares(a, b):
    """Of the distances of all of `a` to all of `b`, shape (len(a), len(b))."""
    return np.sum(a**2, axis=1)[:, None] + np.sum(b**2, axis=1) - 2 * (a @ b.T)


def distance(place, corners):
    """Of a place from the nearest of some facets.

    Args:
        place (array): shape (dim,) [m].
        corners (array): of segments or triangles, shape (m, dim, dim) [m].

    Returns:
        float: >= 0 [m].
    """
    edges, ways = np.roll(corners, -1, axis=1) - corners, place - corners
    shares = np.sum(ways * edges, axis=2) / np.sum(edges**2, axis=2)
    off = ways - np.clip(shares, 0, 1)[:, :, None] * edges
    nearest = np.sqrt(np.sum(off**2, axis=2).min())
    if corners.shape[2] == 2:
        return nearest
    normals = np.cross(edges[:, 0], edges[:, 1])
    sides = np.einsum("mkd,md->mk", np.cross(edges, ways), normals)
    above = (sides >= 0).all(axis=1)
    heights = np.abs(np.sum(ways[:, 0] * normals, axis=1)) / np.linalg.norm(normals, axis=1)
    return min(nearest, heights[above].min(initial=np.inf))


def encloses(corners, place):
    """Whether facets that close around a space enclose a place: all together turn about it once
    (in 3D: are seen at a solid angle of 4 pi). Where a facet lies folded onto its neighbour, with
    its outer side inwards, what it seems to enclose is outside.

    Args:
        corners (array): of segments or triangles, shape (m, dim, dim) [m].
        place (array): shape (dim,) [m].

    Returns:
        bool:
    """
    way = corners - place
    if len(place) == 2:
        a, b = way[:, 0], way[:, 1]
        angles = np.arctan2(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0], np.sum(a * b, axis=1))
        return angles.sum() > np.pi
    a, b, c = way[:, 0], way[:, 1], way[:, 2]
    la, lb, lc = np.linalg.norm(way, axis=2).T
    upper = np.sum(a * np.cross(b, c), axis=1)  # van Oosterom and Strackee 1983
    lower = la * lb * lc + sum(
        np.sum(x * y, axis=1) * z for x, y, z in ((a, b, lc), (b, c, la), (c, a, lb))
    )
    return 2 * np.arctan2(upper, lower).sum() > 2 * np.pi


def fill(vertices, facets, gap, depth):
    """Few discs (balls) whose union has nearly a given outline.

    Greedy: of the largest balls inside that touch the outline at its samples, the one that
    covers most of what is not covered yet, until all is. A sample is covered by a ball if it is
    not further than `gap` from it. No ball leaves the outline, between samples either, by more than
    `depth` and a twentieth of its radius, whichever is less. Samples at which only balls outside
    touch, on facets that are folded over, are left out.

    Args:
        vertices, facets: the outline, as for :func:`samples_of`.
        gap (float): > 0 [m].
        depth (float): in [0, gap] [m].

    Returns:
        tuple: centres (m, dim) and radii (m,) [m], in the order in which they were chosen.

    Raises:
        ValueError: the outline is no closed one with its normals outwards: somewhere no ball fits.
    """
    vertices = np.asarray(vertices, float)
    origin = vertices.mean(axis=0)  # near the outline: saves digits
    corners = (vertices - origin)[np.asarray(facets)]
    places, normals, areas = samples_of(vertices - origin, facets, SPACING[len(origin)] * gap)
    bare = areas.copy()  # 0 where a ball covers the sample
    centres, radii = [], []
    while bare.any():
        candidates = np.flatnonzero(bare)
        candidates = candidates[:: -(-len(candidates) * len(places) // BATCH)]
        radius = largest_balls(places, normals, candidates, depth)
        fits = np.isfinite(radius) & (radius > 0)
        bare[candidates[~fits]] = 0
        candidates, radius = candidates[fits], radius[fits]
        largest_first = np.argsort(-radius, kind="stable")  # of those that cover as much
        candidates, radius = candidates[largest_first], radius[largest_first]
        centre = places[candidates] - radius[:, None] * normals[candidates]
        squares = _squares(centre, places)
        covered = (squares <= (radius + gap)[:, None] ** 2).astype(float)
        while (gains := covered @ bare).any():
            best = int(np.argmax(gains))
            if not encloses(corners, centre[best]):
                covered[best] = bare[candidates[best]] = 0
                continue
            room = distance(centre[best], corners)
            fitting = min(room + depth, room / (1 - DEEPEST))
            if radius[best] > fitting:  # smaller, it may not be the best one
                radius[best] = fitting
                covered[best] = squares[best] <= (fitting + gap) ** 2
                covered[best, candidates[best]] = 1  # so that all are covered some time
                continue
            centres.append(origin + centre[best])
            radii.append(radius[best])
            bare[covered[best] > 0] = 0
    if not centres:
        raise ValueError("vertices: no ball fits inside the outline; is it closed?")
    return np.array(centres), np.array(radii)
