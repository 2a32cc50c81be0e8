"""Grains from a labelled image: one soft grain for each label."""

import math
import os
from dataclasses import dataclass, field

import numpy as np
from PIL import Image

from softgrain.build import soft_polygon
from softgrain.checks import finite_vector, index, number
from softgrain.label_outlines import label_outlines

NAMED_LABELS = 5  #: unusable ones that a message names
MANY_LABELS = 50  #: unusable ones, seldom meant as such


@dataclass
class ImageGrains:
    """What :func:`grains_from_image` found.

    Attributes:
        bodies (list of Body): to be added with ``O.bodies.append``.
        labels (list of int): of the bodies.
        area_errors (ndarray): area of each grain over that of its pixels, minus 1 [-].
        left_out (dict): unusable labels with the reason.
        size (tuple): width and height of the image [m].
    """

    bodies: list
    labels: list
    area_errors: np.ndarray
    size: tuple
    left_out: dict = field(default_factory=dict)


def grains_from_image(
    image,
    pixel,
    material=-1,
    origin=(0.0, 0.0, 0.0),
    background=0,
    smoothing=1.0,
    least_pixels=50,
    unusable="refuse",
    **shape,
):
    """A soft grain for each label of an image, e.g. a segmented section of a real packing.

    The staircase of the pixels is smoothed (``softgrain.label_outlines``); corners are rounded by
    it. Grains that touch in the image touch in the scene, with overlaps far below a pixel, which
    the first steps work off.

    Args:
        image (str | Path | array): a picture file, or integers or bools (label 1) of shape (rows,
            columns), the first row on top. Of grey or palette pictures the value is the label, of
            coloured ones red + 256 green + 65536 blue; transparent pixels are background.
        pixel (float): its side, > 0 [m].
        material (int | str | SoftMat): as for :func:`soft_disk`.
        origin (tuple): of the lower left corner of the image [m].
        background (int): label that is no grain, below 2^31.
        smoothing (float): standard deviation of the Gaussian on the mask of a label, in [0.5, 10]
            [pixels].
        least_pixels (int): labels of fewer pixels are unusable, >= 10.
        unusable (str): what to do with labels that are too small, at the border, in several pieces,
            with a hole or too thin: 'refuse' or 'skip'.
        **shape: attributes of ``SoftGrain``, and mask and color of the bodies.

    Returns:
        ImageGrains: with 'skip' its `left_out` names the labels that are not there.

    Raises:
        ValueError: a value is out of its range, the image has no usable label, or an unusable one
            that is refused.
        OSError: the file is not there, or no picture.
    """
    pixel = number("pixel", pixel, "(0, inf)", "m")
    least_pixels = math.ceil(number("least_pixels", least_pixels, "[10, inf)"))
    if unusable not in ("refuse", "skip"):
        raise ValueError(f"unusable = {unusable!r} is unknown; known: 'refuse', 'skip'")
    origin = finite_vector("origin", origin, 3, "m")
    background = index("background", background)
    for name in ("vertices", "corners", "z"):
        if name in shape:
            raise ValueError(f"{name} = {shape[name]!r}: set by the image and its origin")
    labels = read_labels(image, background)
    outlines, left_out = label_outlines(labels, background, smoothing, least_pixels)
    if left_out and unusable == "refuse":
        raise ValueError(f"image: {_named(left_out)}. Mend the image or say unusable='skip'")
    if not outlines:
        found = _named(left_out) if left_out else "there is no other"
        raise ValueError(f"image: no usable label but background = {background}: {found}")
    bodies = [
        soft_polygon(
            np.array(origin[:2]) + pixel * outline.vertices,
            material,
            corners=(),
            z=origin[2],
            **shape,
        )
        for outline in outlines
    ]
    rows, columns = labels.shape
    return ImageGrains(
        bodies,
        [outline.label for outline in outlines],
        np.array([outline.area_error for outline in outlines]),
        (columns * pixel, rows * pixel),
        left_out,
    )


def _named(left_out):
    """Unusable labels in words; of many the first."""
    names = [f"label {label} {left_out[label]}" for label in list(left_out)[:NAMED_LABELS]]
    more = len(left_out) - len(names)
    if more:
        names.append(f"and {more} more")
    if len(left_out) > MANY_LABELS:
        names.append(
            "so many may come of lossy compression (JPEG), dithering, smoothed edges or shades of "
            "grey: labels are whole numbers, one for each grain (scipy.ndimage.label makes them of "
            "a mask)"
        )
    return "; ".join(names)


def read_labels(image, background=0):
    """Labels of an image as :func:`grains_from_image` takes it: integers (rows, columns).

    Raises:
        ValueError: neither a name nor an array, or one that is empty, not two-dimensional or not of
            integers; a picture of another kind.
    """
    is_name = isinstance(image, os.PathLike) or (isinstance(image, str) and image != "")
    if isinstance(image, (list, tuple)):
        image = np.array(image)
    elif not (is_name or isinstance(image, np.ndarray)):
        raise ValueError(f"image = {image!r}: admissible are the name of a file and an array")
    elif isinstance(image, np.ma.MaskedArray):
        image = _wide(image)
        image = image.filled(background) if _is_integer(image) else image.data
    elif is_name:
        with Image.open(image) as picture:
            image = _labels_of_picture(picture, background)
    if image.ndim != 2 or not _is_integer(image):
        raise ValueError(
            f"image: {image.dtype} of shape {image.shape}; admissible: integers (rows, columns)"
        )
    if image.size == 0:
        raise ValueError(f"image: no pixels, its shape is {image.shape}")
    if int(image.max()) >= 2**63:
        raise ValueError(f"image: label {image.max()}; admissible: below 2^63")
    return image.astype(np.int64)


def _labels_of_picture(picture, background):
    """One label a pixel, by its value or colour; not checked yet."""
    weights = {"RGB": (1, 256, 65536), "RGBA": (1, 256, 65536, 0), "LA": (1, 0)}
    labels = np.array(picture)
    if picture.mode in weights:
        labels = labels.astype(np.int64) @ np.array(weights[picture.mode])
    if labels.ndim != 2:
        raise ValueError(
            f"image: a picture of mode {picture.mode!r}; admissible: grey, palette or RGB, with "
            "or without transparency"
        )
    if picture.mode.endswith("A") or "transparency" in picture.info:
        alpha = np.array(picture.convert("RGBA"))[:, :, 3]
        labels = np.where(alpha == 0, background, _wide(labels))
    return labels


def _is_integer(image):
    return np.issubdtype(image.dtype, np.integer) or image.dtype == bool


def _wide(image):
    """Of integers those of a type that takes any label for the background."""
    small = _is_integer(image) and image.dtype.itemsize < 8
    return image.astype(np.int64) if small else image
