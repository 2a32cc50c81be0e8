"""Normal form of polygons, and outlines of labels, without a scene."""

import re

import numpy as np
import pytest

from softgrain import outlines
from softgrain.label_outlines import label_outlines

IRON = np.array([(0, 0), (6, 0), (6, 2), (2, 2), (2, 6), (0, 6)], float)


def moved(vertices, angle, scale=1.0, shift=(0, 0)):
    c, s = np.cos(angle), np.sin(angle)
    return scale * vertices @ np.array([[c, s], [-s, c]]) + shift


def test_area_centroid_and_inertia_of_an_angle_iron():
    area, centroid, inertia = outlines.area_and_inertia(IRON)
    assert area == pytest.approx(20)
    # a square of side 6 without one of side 4
    np.testing.assert_allclose(centroid, [(36 * 3 - 16 * 4) / 20] * 2)
    about_origin = 36 * 6**2 / 6 - 16 * 4**2 / 6 + 36 * 18 - 16 * 32
    assert inertia == pytest.approx(about_origin - area * centroid @ centroid)


@pytest.mark.parametrize(
    "vertices, expected",
    [
        (IRON, 4 / (2 + np.sqrt(2))),  # in the corner, against the outer sides and the inner corner
        (np.array([(0, 0), (4, 0), (0, 3)]), 1.0),
        (np.array([(0, 0), (50, 0), (50, 1), (0, 1)]), 0.5),
    ],
)
def test_largest_circle_inside(vertices, expected):
    assert outlines.inradius(np.asarray(vertices, float)) == pytest.approx(expected, rel=1e-9)


def test_congruent_polygons_have_the_same_digits():
    form = outlines.normalized(IRON)
    assert form.corners == [0, 1, 2, 3, 4, 5]
    for angle, scale, shift, start in [(0.7, 0.003, (5, -2), 3), (-2.9, 40.0, (0, 0), 1)]:
        other = np.roll(moved(IRON, angle, scale, shift), start, axis=0)
        for vertices in (other, other[::-1]):
            found = outlines.normalized(vertices)
            np.testing.assert_array_equal(found.vertices, form.vertices)
            assert found.corners == form.corners
            assert found.radius == pytest.approx(scale * form.radius)
            back = moved(found.vertices, found.angle, found.radius, found.centroid)
            distance = np.linalg.norm(back[:, None] - vertices[None], axis=2).min(axis=1)
            assert distance.max() < 1e-8 * scale


def test_mirror_images_differ():
    hook = np.array([(0, 0), (5, 0), (5, 1), (1, 1), (1, 3), (0, 3)], float)
    mirrored = hook * (-1, 1)
    a, b = outlines.normalized(hook), outlines.normalized(mirrored)
    assert a.radius == pytest.approx(b.radius)
    assert not np.allclose(a.vertices, b.vertices)


def test_corners_are_where_it_turns():
    t = np.linspace(0, np.pi, 40)
    half = np.column_stack([np.cos(t), np.sin(t)])
    form = outlines.normalized(half)
    assert len(form.corners) == 2
    assert outlines.normalized(half, corners=[3]).corners != form.corners
    assert outlines.normalized(half, corners=()).corners == []


@pytest.mark.parametrize(
    "vertices, corners, message",
    [
        ([(0, 0), (1, 0)], None, "vertices has shape (2, 2)"),
        ([(0, 0), (1, 0), (0, float("nan"))], None, "finite numbers"),
        ([(0, 0), (1, 0), (1, 0), (0, 1)], None, "vertices: 1 and the one after it are the same"),
        ([(0, 0), (1, 0), (2, 0)], None, "the area of the polygon is 0 m^2"),
        ([(0, 0), (1, 0), (0, 1)], [3], "corners = [3]: indices are in [0, 2]"),
    ],
)
def test_what_is_no_polygon(vertices, corners, message):
    with pytest.raises(ValueError, match=re.escape(message)):
        outlines.normalized(vertices, corners)


def disk_image(radius, centre=(60.3, 50.7), shape=(110, 120)):
    rows, columns = np.mgrid[: shape[0], : shape[1]]
    x, y = columns + 0.5, shape[0] - rows - 0.5
    return ((x - centre[0]) ** 2 + (y - centre[1]) ** 2 < radius**2).astype(int)


@pytest.mark.parametrize("radius", (10, 20, 40))
def test_outline_of_a_drawn_disk(radius):
    (found,), unusable = label_outlines(disk_image(radius))
    assert not unusable
    distance = np.linalg.norm(found.vertices - (60.3, 50.7), axis=1)
    assert np.abs(distance - radius).max() < 0.35  # of a pixel; its staircase: 0.7
    assert found.area_error == pytest.approx(-1 / radius**2, abs=0.7 / radius**2)
    area, centroid, _ = outlines.area_and_inertia(found.vertices)
    np.testing.assert_allclose(centroid, (60.3, 50.7), atol=0.1)
    assert area == pytest.approx(np.pi * radius**2, rel=0.02)


def test_touching_labels_share_their_line():
    image = np.zeros((60, 80), int)
    image[10:50, 10:40] = 3
    image[10:50, 40:70] = 7
    (left, right), _ = label_outlines(image)
    assert (left.label, right.label) == (3, 7)
    assert left.vertices[:, 0].max() == pytest.approx(40, abs=1e-6)
    assert right.vertices[:, 0].min() == pytest.approx(40, abs=1e-6)


def test_unusable_labels_are_named():
    image = np.zeros((80, 80), int)
    image[0:20, 30:50] = 1
    image[30:34, 30:34] = 2
    image[40:50, 10:20] = image[60:70, 10:20] = 3
    image[40:70, 40:70] = 4
    image[50:55, 50:55] = 0
    image[36:37, 2:70] = 5
    image[60:75, 22:37] = 6
    found, unusable = label_outlines(image, smoothing=2.0)
    assert [outline.label for outline in found] == [6]
    assert "touches the border" in unusable[1]
    assert unusable[2] == "has 16 pixels, fewer than least_pixels = 50"
    assert unusable[3].startswith("is in 2 pieces, of ")
    assert unusable[4] == "has a hole"
    assert "so thin" in unusable[5]
