"""Walls about a box, and the box between walls."""

import numpy as np
from yade import O, utils, wrapper

from softgrain.checks import finite_vector
from softgrain.materials import found_material


def walls_around(low, high, material=-1):
    """Walls along the sides of a box that bear what is inside of it.

    Args:
        low, high (sequence of float): opposite corners, two numbers each, or three for walls across
            z as well; finite, low below high along each axis [m].
        material (FrictMat | int | str): as of ``utils.wall``: itself, or its index or label in
            ``O.materials``; -1: the last one there.

    Returns:
        list of Body: for ``O.bodies.append``, axis by axis the lower and the upper one: left,
        right, bottom, top (, back, front).

    Raises:
        ValueError: corners that are not such, or an unknown material.
    """
    low = finite_vector("low", low, 3 if np.size(low) == 3 else 2, "m")
    high = finite_vector("high", high, len(low), "m")
    for axis, (least, most) in enumerate(zip(low, high)):
        if not least < most:
            raise ValueError(
                f"low = {low}, high = {high}: along {'xyz'[axis]} low is not below high"
            )
    if material != -1:
        material = found_material(material)
    return [
        utils.wall(corner[axis], axis=axis, sense=sense, material=material)
        for axis in range(len(low))
        for corner, sense in ((low, 1), (high, -1))
    ]


def wall_box():
    """(xmin, xmax, ymin, ymax) spanned by the axis-aligned walls of a 2D scene [m].

    Raises:
        ValueError: there are not two walls for each of the axes x and y.
    """
    positions = {0: [], 1: []}
    for b in O.bodies:
        if b and isinstance(b.shape, wrapper.Wall) and b.shape.axis in positions:
            positions[b.shape.axis].append(b.state.pos[b.shape.axis])
    if any(len(p) < 2 for p in positions.values()):
        raise ValueError("wall_box: two walls are needed for each of the axes x and y")
    return (min(positions[0]), max(positions[0]), min(positions[1]), max(positions[1]))
