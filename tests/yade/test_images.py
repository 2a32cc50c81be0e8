"""Grains from labelled images inside YADE."""

import math
import re

import numpy as np
import pytest
from PIL import Image
from scenes import DENSITY, ready, run, soft_material
from yade import O

import softgrain as sg


def drawn_labels():
    """Two disks side by side and a square, labels 5, 9 and 70, in a picture of 90 x 60 pixels."""
    labels = np.zeros((60, 90), np.uint8)
    rows, columns = np.mgrid[:60, :90] + 0.5
    labels[(columns - 25) ** 2 + (rows - 30) ** 2 < 15**2] = 5
    labels[(columns - 55) ** 2 + (rows - 30) ** 2 < 15**2] = 9
    labels[35:55, 70:85] = 70
    return labels


@pytest.mark.parametrize("how", ("array", "grey", "palette", "colour"))
def test_grains_from_an_image(how, tmp_path):
    labels = drawn_labels()
    names = [5, 9, 70]
    if how == "array":
        image = labels
    else:
        image = tmp_path / "labels.png"
        picture = Image.fromarray(labels)
        if how == "palette":
            picture.putpalette([int(v) for v in np.arange(768) % 256])
        if how == "colour":
            colours = np.zeros((*labels.shape, 3), np.uint8)
            colours[:, :, :2] = labels[:, :, None]  # red, green
            picture = Image.fromarray(colours)
            names = [(1 + 256) * name for name in names]
        picture.save(image)
    pixel = 1e-4
    found = sg.grains_from_image(image, pixel, soft_material(), zeta=0.25)
    assert found.labels == names and not found.left_out
    assert found.size == pytest.approx((90 * pixel, 60 * pixel))
    assert np.abs(found.area_errors).max() < 0.02  # corners of the square
    O.bodies.append(found.bodies)
    left, right, square = found.bodies
    np.testing.assert_allclose(left.state.pos, (25 * pixel, 30 * pixel, 0), atol=0.1 * pixel)
    np.testing.assert_allclose(square.state.pos, (77.5 * pixel, 15 * pixel, 0), atol=0.1 * pixel)
    assert left.state.mass == pytest.approx(DENSITY * math.pi * (15 * pixel) ** 2, rel=0.02)
    ready()
    run(20)
    assert sg.integrator().largestOverlap < 0.1


@pytest.mark.parametrize("how", ("array", "file"))
def test_mask_of_one_grain(how, tmp_path):
    """Bools, and a picture of one bit: label 1."""
    mask = drawn_labels() == 70
    image = mask
    if how == "file":
        image = tmp_path / "mask.png"
        Image.fromarray(mask).save(image)
    found = sg.grains_from_image(image, 1e-4, soft_material(), origin=(0.3, -0.2, 0.1), zeta=0.25)
    assert found.labels == [1]
    (square,) = found.bodies
    place = (0.3 + 77.5e-4, -0.2 + 15e-4, 0.1)
    np.testing.assert_allclose(square.state.pos, place, atol=0.1e-4)


@pytest.mark.parametrize("mode", ("RGBA", "LA"))
def test_transparent_pixels_are_background(mode, tmp_path):
    """Whatever colour they have."""
    labels = drawn_labels()
    pixels = np.full((*labels.shape, len(mode)), 255, np.uint8)
    pixels[:, :, -1] = 255 * (labels > 0)
    pixels[labels > 0, :-1] = labels[labels > 0, None]
    path = tmp_path / "labels.png"
    Image.fromarray(pixels, mode).save(path)
    found = sg.grains_from_image(path, 1e-4, soft_material(), zeta=0.25)
    weight = 1 + 256 + 65536 if mode == "RGBA" else 1
    assert found.labels == [weight * name for name in (5, 9, 70)]


@pytest.mark.parametrize("mode, transparent", (("P", 9), ("L", 9), ("RGB", (9, 0, 0)), ("1", 0)))
def test_one_colour_may_be_transparent(mode, transparent, tmp_path):
    """As in pictures without a channel for it."""
    labels = drawn_labels()
    path = tmp_path / "labels.png"
    if mode == "1":
        picture, left = Image.fromarray(labels == 70), [1]
    else:
        picture, left = Image.fromarray(labels), [5, 70]
        if mode == "P":
            picture.putpalette([int(v) for v in np.arange(768) % 256])
        if mode == "RGB":
            picture = Image.fromarray(np.dstack([labels, 0 * labels, 0 * labels]))
    picture.save(path, transparency=transparent)
    found = sg.grains_from_image(path, 1e-4, soft_material(), zeta=0.25)
    assert found.labels == left


@pytest.mark.parametrize("kind, background", ((int, 0), (np.uint8, 0), (np.uint8, 300)))
def test_masked_pixels_are_background(kind, background):
    """Also where its label is beyond the pixels' type."""
    labels = np.ma.masked_equal(drawn_labels().astype(kind), 9)
    if background:
        labels.mask |= drawn_labels() == 0
    found = sg.grains_from_image(labels, 1e-4, soft_material(), background=background, zeta=0.25)
    assert found.labels == [5, 70]


def test_masked_numbers_with_fractions_are_refused():
    with pytest.raises(ValueError, match="image: float64 .*admissible: integers"):
        sg.grains_from_image(np.ma.masked_equal(0.5 * drawn_labels(), 0), 1e-4, soft_material())


def test_picture_of_another_kind_is_refused(tmp_path):
    path = tmp_path / "labels.tif"
    Image.fromarray(drawn_labels()).convert("CMYK").save(path)
    with pytest.raises(ValueError, match="picture of mode 'CMYK'; admissible: grey, palette"):
        sg.grains_from_image(path, 1e-4, soft_material())


@pytest.mark.parametrize("unusable", ("refuse", "skip"))
def test_messages_about_many_labels_are_short(unusable):
    """As of a picture that was compressed with losses; and of one label in many pieces."""
    labels = np.arange(1, 60 * 90 + 1).reshape(60, 90)
    with pytest.raises(ValueError, match="and 5395 more; .*JPEG") as told:
        sg.grains_from_image(labels, 1e-4, soft_material(), unusable=unusable)
    assert len(str(told.value)) < 600
    dots = np.zeros((60, 90), int)
    dots[5:-5:2, 5:-5:2] = 1
    with pytest.raises(ValueError, match="is in 1000 pieces, of 1( \\+ 1){4} \\+ ... pixels"):
        sg.grains_from_image(dots, 1e-4, soft_material())


def test_unusable_labels_are_refused_or_reported():
    labels = drawn_labels()
    labels[0:10, 0:10] = 3
    with pytest.raises(ValueError, match="label 3 touches the border of the image"):
        sg.grains_from_image(labels, 1e-4, soft_material())
    found = sg.grains_from_image(labels, 1e-4, soft_material(), unusable="skip")
    assert found.labels == [5, 9, 70] and list(found.left_out) == [3]


@pytest.mark.parametrize(
    "arguments, message",
    [
        ({"pixel": 0}, "pixel = 0 is outside"),
        ({"unusable": "mend"}, "unusable = 'mend' is unknown"),
        ({"least_pixels": 2}, "least_pixels = 2 is outside"),
        ({"smoothing": 0.1}, "smoothing = 0.1 is outside"),
        ({"image": np.zeros((5, 5))}, "image: float64 of shape (5, 5)"),
        ({"image": np.zeros((5, 5), int)}, "image: no usable label"),
    ],
)
def test_bad_image(arguments, message):
    with pytest.raises(ValueError, match=re.escape(message)):
        sg.grains_from_image(**{"image": drawn_labels(), "pixel": 1e-4, **arguments})
