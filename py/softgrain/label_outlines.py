"""Outlines of the labels of an image. Plain numpy; nothing of a scene."""

from dataclasses import dataclass

import numpy as np
from contourpy import contour_generator
from scipy import ndimage

from softgrain.checks import number
from softgrain.outlines import area_and_inertia, signed_area

#: The Gaussian that smooths masks ends at this many standard deviations.
TRUNCATE = 4
#: Vertices of an outline at least.
LEAST_VERTICES = 8
#: Pieces of a label whose sizes are told.
NAMED_PIECES = 5


@dataclass
class LabelOutline:
    """Outline of one label of an image: vertices (n, 2) in pixels, x to the right, y upwards, from
    the lower left corner of the image, and its area over that of the pixels, minus 1."""

    label: int
    vertices: np.ndarray
    area_error: float


def label_outlines(labels, background=0, smoothing=1.0, least_pixels=50):
    """Outlines of the labels of an image.

    The mask of a label is smoothed by a Gaussian and its contour taken at 1/2, in steps of a pixel:
    two grains that touch in the image have one common line between them. Where the outline bends
    with a radius r (in pixels) it moves inwards by some smoothing^2/(2 r).

    Args:
        labels (ndarray): integers, shape (rows, columns), the first row on top.
        background (int): what is no grain.
        smoothing (float): standard deviation of the Gaussian, in [0.5, 10] [pixels].
        least_pixels (int): labels of fewer pixels are unusable.

    Returns:
        tuple: list of LabelOutline in the order of the labels; and dict of the unusable labels with
        the reason: less than `least_pixels`, at the border of the image, in several pieces, with a
        hole, or too thin to be smoothed.

    Raises:
        ValueError: `smoothing` is out of its range.
    """
    smoothing = number("smoothing", smoothing, "[0.5, 10]", "pixels")
    names, indices = np.unique(labels, return_inverse=True)
    numbers = indices.reshape(labels.shape) + 1  # from 1 on, without gaps
    found, unusable = [], {}
    for name, place, value in zip(names, ndimage.find_objects(numbers), range(1, len(names) + 1)):
        if name == background:
            continue
        mask = numbers[place] == value
        reason = _why_unusable(mask, place, labels.shape, least_pixels)
        lines = [] if reason else _contours(mask, smoothing)
        if reason is None and len(lines) != 1:
            reason = f"is so thin that smoothing = {smoothing} leaves {len(lines)} pieces of it"
        if reason:
            unusable[int(name)] = reason
            continue
        corner = np.array([place[1].start, labels.shape[0] - place[0].stop])
        area = area_and_inertia(lines[0])[0]
        found.append(LabelOutline(int(name), lines[0] + corner, area / mask.sum() - 1))
    return found, unusable


def _why_unusable(mask, place, shape, least_pixels):
    """Reason, or None."""
    pixels = int(mask.sum())
    if pixels < least_pixels:
        return f"has {pixels} pixels, fewer than least_pixels = {least_pixels}"
    if any(p.start == 0 or p.stop == n for p, n in zip(place, shape)):
        border = "touches the border of the image, which may cut it"
        return border + ", or is what lies between the grains: background=..."
    numbers, pieces = ndimage.label(mask)
    if pieces > 1:
        sizes = sorted(np.bincount(numbers.ravel())[1:], reverse=True)
        named = " + ".join(map(str, sizes[:NAMED_PIECES]))
        more = " + ..." if pieces > NAMED_PIECES else ""
        return f"is in {pieces} pieces, of {named}{more} pixels"
    if ndimage.binary_fill_holes(mask).sum() > pixels:
        return "has a hole"
    return None


def _contours(mask, smoothing):
    """Closed contours of the smoothed mask, counter-clockwise about what is inside, in steps of
    about a pixel, in pixels from the lower left corner of the mask, y upwards."""
    margin = int(np.ceil(TRUNCATE * smoothing)) + 1
    padded = np.pad(mask[::-1].astype(float), margin)
    level = ndimage.gaussian_filter(padded, smoothing, truncate=TRUNCATE)
    lines = contour_generator(z=level).lines(0.5)
    return [_in_equal_steps(line[:-1]) - margin + 0.5 for line in lines]


def _in_equal_steps(line):
    """A closed line (n, 2), counter-clockwise, with vertices about a pixel apart."""
    if signed_area(line) < 0:
        line = line[::-1]
    closed = np.vstack([line, line[:1]])
    along = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(closed, axis=0), axis=1))])
    steps = np.linspace(0, along[-1], max(LEAST_VERTICES, round(along[-1])), endpoint=False)
    return np.column_stack([np.interp(steps, along, closed[:, a]) for a in range(2)])
