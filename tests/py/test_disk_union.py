"""Outlines of overlapping disks, without a scene."""

import numpy as np
import pytest

from softgrain.disk_union import outline_of_disks
from softgrain.outlines import area_and_inertia, turns


def lens(apart, radius):
    """Area common to two disks of the same radius."""
    return 2 * radius**2 * np.arccos(apart / (2 * radius)) - apart / 2 * np.sqrt(
        4 * radius**2 - apart**2
    )


def test_one_disk():
    vertices, corners = outline_of_disks([(3, 4)], [2])
    area, centroid, _ = area_and_inertia(vertices)
    assert area == pytest.approx(4 * np.pi, rel=1e-3)
    np.testing.assert_allclose(centroid, (3, 4), atol=1e-12)
    assert corners == []


def test_two_disks():
    vertices, corners = outline_of_disks([(0, 0), (1.2, 0)], [1, 1])
    area, centroid, _ = area_and_inertia(vertices)
    assert area == pytest.approx(2 * np.pi - lens(1.2, 1), rel=1e-3)
    np.testing.assert_allclose(centroid, (0.6, 0), atol=1e-12)
    np.testing.assert_allclose(np.abs(vertices[corners]), [(0.6, 0.8)] * 2, atol=1e-12)
    np.testing.assert_allclose(turns(vertices)[corners], -2 * np.arcsin(0.6), atol=0.07)


def test_disks_that_are_hidden_or_there_twice():
    """They leave no trace, whatever their place in the list."""
    visible = [((0, 0), 1.0), ((1.2, 0.3), 0.7), ((0.5, 1), 0.8)]
    hidden = [((0.2, 0.1), 0.3), ((0, 0), 1.0), ((0.5, 0.4), 0.2), ((1.2, 0.5), 0.5)]
    expected, corners = outline_of_disks(*zip(*visible))
    found, found_corners = outline_of_disks(*zip(*visible, *hidden))
    np.testing.assert_allclose(found, expected, atol=1e-12)
    assert found_corners == corners and len(corners) == 3


def ring(disks, radius):
    angle = 2 * np.pi * np.arange(disks) / disks
    return np.stack([np.cos(angle), np.sin(angle)], axis=1), np.full(disks, radius)


def test_ring_without_its_hole():
    vertices, corners = outline_of_disks(*ring(6, 1.01))
    assert len(corners) == 6
    assert np.linalg.norm(vertices, axis=1).min() > 1
    assert (turns(vertices)[corners] < 0).all()


@pytest.mark.parametrize(
    "disks",
    [
        ([(0, 0), (3, 0)], [1, 1]),
        ([(0, 0), (2, 0)], [1, 1]),  # they touch
        ([(0, 0), (1, 0), (4, 0)], [1, 1, 1]),
        ring(6, 0.6),
    ],
    ids=("apart", "touching", "two and one", "hole"),
)
def test_no_outline(disks):
    with pytest.raises(ValueError, match="falls into parts, or encloses a hole"):
        outline_of_disks(*disks)
