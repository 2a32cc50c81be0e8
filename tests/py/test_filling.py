"""Discs and balls that fill an outline."""

import numpy as np
import pytest

from softgrain.filling import distance, encloses, fill, samples_of


def ring(x):
    """A closed polygon and its facets."""
    k = np.arange(len(x))
    return np.asarray(x, float), np.column_stack([k, np.roll(k, -1)])


def circle(n=80, squeezed=1.0):
    t = np.linspace(0, 2 * np.pi, n, endpoint=False)
    x = np.column_stack([np.cos(t), np.sin(t)])
    return ring(np.clip(x, -squeezed, squeezed))


def bean(n=120):
    """Not convex."""
    t = np.linspace(0, 2 * np.pi, n, endpoint=False)
    r = 1 - 0.6 * np.exp(-((t - np.pi) ** 2) / 0.2)
    return ring(np.column_stack([r * np.cos(t), r * np.sin(t)]))


SQUARE = ring([(-1, -1), (1, -1), (1, 1), (-1, 1)])


def cube():
    x = np.array([(i, j, k) for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)], float)
    faces = []
    for quad in (
        (0, 1, 3, 2),
        (4, 6, 7, 5),
        (0, 4, 5, 1),
        (2, 3, 7, 6),
        (0, 2, 6, 4),
        (1, 5, 7, 3),
    ):
        faces += [(quad[0], quad[1], quad[2]), (quad[0], quad[2], quad[3])]
    return x, np.array(faces)


def folded_circle():
    """Two neighbouring vertices have passed each other: a segment has its outer side inwards."""
    x, facets = circle()
    x[[10, 11]] = x[[11, 10]]
    return x, facets


def folded_cube():
    """A vertex of the upper face hangs over an edge, and a facet lies on the side below."""
    x, facets = cube()
    top = (1, 5, 7, 3)
    others = [f for f in facets if not set(f) <= set(top)]
    around = [(top[k], top[(k + 1) % 4], 8) for k in range(4)]
    return np.vstack([x, [1.1, 0, 0.9]]), np.array(others + around)


def gaps(outline, centres, radii, spacing):
    """Of places on the outline to the union of the balls, < 0 inside."""
    places, _, _ = samples_of(*outline, spacing)
    return (np.linalg.norm(places[:, None] - centres[None], axis=2) - radii).min(axis=1)


@pytest.mark.parametrize("gap", (0.01, 0.05))
@pytest.mark.parametrize(
    "outline",
    (circle(), circle(squeezed=0.9), bean(), SQUARE),
    ids=("disk", "flat", "bean", "square"),
)
def test_outline_is_met(outline, gap):
    """Everywhere within the gap, and the balls stay inside: also between the samples it was
    filled by."""
    centres, radii = fill(*outline, gap, depth=0.1 * gap)
    found = gaps(outline, centres, radii, 0.1 * gap)
    assert found.max() < 1.3 * gap
    assert found.min() > -0.1001 * gap
    assert (radii > gap).all()


def test_number_of_discs():
    """One for a disk, more for a smaller error."""
    assert len(fill(*circle(), 0.03, 0.003)[1]) == 1
    numbers = [len(fill(*SQUARE, gap, 0.1 * gap)[1]) for gap in (0.2, 0.05, 0.02)]
    assert 4 < numbers[0] < numbers[1] < numbers[2] < 40


def test_cube():
    """Corners and edges lie between samples."""
    gap = 0.15
    centres, radii = fill(*cube(), gap, depth=0.1 * gap)
    found = gaps(cube(), centres, radii, 0.3 * gap)
    assert found.max() < 1.6 * gap
    out = (np.abs(centres) + radii[:, None] - 1).max(axis=1)
    assert out.max() < 0.1001 * gap
    assert (out / radii).max() < 0.0501
    assert len(radii) < 200


def test_distance():
    """Of a place above a facet, beyond an edge, beyond a corner."""
    vertices, facets = cube()
    corners = vertices[facets]
    assert distance(np.array([0.2, 0.3, 0.9]), corners) == pytest.approx(0.1)
    assert distance(np.array([4.0, 5.0, 0.5]), corners) == pytest.approx(5)
    assert distance(np.array([3.0, 3.0, 2.0]), corners) == pytest.approx(3)
    vertices, facets = SQUARE
    assert distance(np.array([4.0, 5.0]), vertices[facets]) == pytest.approx(5)


def test_samples():
    """Areas sum up, normals point outwards."""
    for outline, area in ((SQUARE, 8), (cube(), 24)):
        places, normals, areas = samples_of(*outline, 0.3)
        assert areas.sum() == pytest.approx(area)
        assert (np.sum(places * normals, axis=1) > 0.9).all()
        np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1)
        np.testing.assert_allclose(areas @ places, 0, atol=1e-12)


def test_inside_out():
    vertices, facets = SQUARE
    with pytest.raises(ValueError, match="is it closed"):
        fill(vertices, facets[:, ::-1], 0.05, 0.005)


@pytest.mark.parametrize("outline", (folded_circle(), folded_cube()), ids=("circle", "cube"))
def test_facets_that_are_folded_over(outline):
    """Balls that would touch them lie outside, with nothing to bound them."""
    gap, depth = 0.1, 0.01
    centres, radii = fill(*outline, gap, depth)
    assert np.isfinite(radii).all()
    assert (np.abs(centres).max(axis=1) + radii).max() < 1.1 + depth
    places, normals, _ = samples_of(*outline, 0.1)
    upright = np.array([encloses(outline[0][outline[1]], x) for x in places - 1e-3 * normals])
    assert 0 < (~upright).sum() < 0.2 * len(places)
    uncovered = np.linalg.norm(places[:, None] - centres[None], axis=2) - radii
    assert uncovered.min(axis=1)[upright].max() < 1.6 * gap


def test_enclosed_places():
    for outline in (SQUARE, bean(), cube()):
        corners = outline[0][outline[1]]
        dim = corners.shape[2]
        inside, beyond = np.full(dim, 0.3), np.full(dim, 1.01)
        assert encloses(corners, inside)
        assert not encloses(corners, beyond)
        assert not encloses(corners[:, ::-1], inside)
