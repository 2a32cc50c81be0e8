"""Making soft grains."""

import math

from yade import (
    Body,
    O,
    Vector3,
    wrapper,
)
from yade import utils


def soft_disk(center, radius, material=-1, color=None, mask=1, **shape):
    """A soft disk in the xy-plane, as ``utils.sphere`` makes a sphere. All quantities are per metre
    of thickness.

    Args:
        center (Vector3): position of the centre [m].
        radius (float): radius of the undeformed disk, > 0 [m].
        material (int | str | SoftMat): id, label or instance; -1 is the last one, made if there is
            none.
        color (Vector3 | None): colour, random if None.
        mask (int): ``Body.mask``.
        **shape: attributes of ``SoftGrain``: zeta, order, nodeSpacing, surfaceSpacing, quadrature,
            contact, volumetric, formulation, velocityUpdate, picShare, basis.

    Returns:
        Body: to be added with ``O.bodies.append``.

    Raises:
        ValueError: a value is out of its range, or the material is no ``SoftMat``.
    """
    return _soft_body(center, radius, 2, material, color, mask, shape)


def soft_block(center, size, material=-1, color=None, mask=1, **shape):
    """A soft rectangle in the xy-plane, or a soft cuboid, with sides along the axes.

    ``zeta`` is over half the shortest side, which is the block's ``radius``.

    Args:
        center (Vector3): position of the centre [m].
        size (tuple): lengths of the undeformed sides along x and y, for a cuboid x, y and z, each
            > 0 and at most 100 times the shortest [m].
        material, color, mask, **shape: as for :func:`soft_disk`.

    Returns:
        Body: to be added with ``O.bodies.append``; ``body.state.ori`` set before turns it.

    Raises:
        ValueError: a value is out of its range, or the material is no ``SoftMat``.
    """
    sides = [float(side) for side in size]
    if len(sides) not in (2, 3):
        raise ValueError(f"size = {tuple(size)} has {len(sides)} components, admissible: 2, 3")
    if not all(0 < side < math.inf for side in sides):
        raise ValueError(f"size = {tuple(size)} is outside the admissible range (0, inf) m")
    radius = min(sides) / 2
    aspect = [side / min(sides) for side in sides] + [1.0] * (3 - len(sides))
    return _soft_body(
        center,
        radius,
        len(sides),
        material,
        color,
        mask,
        {**shape, "form": "block", "aspect": aspect},
    )


def soft_sphere(center, radius, material=-1, color=None, mask=1, **shape):
    """A soft ball; arguments, result and errors as for :func:`soft_disk`."""
    return _soft_body(center, radius, 3, material, color, mask, shape)


def _soft_body(center, radius, dim, material, color, mask, shape):
    body = Body()
    body.shape = wrapper.SoftGrain(
        radius=radius, dim=dim, color=color if color else utils.randomColor(), **shape
    )
    volume, inertia = volume_and_inertia(body.shape)
    utils._commonBodySetup(
        body,
        volume,
        Vector3(inertia, inertia, inertia),
        soft_material(material),
        pos=center,
        fixed=True,
    )
    body.mask = mask
    return body


def volume_and_inertia(grain):
    """Volume [m³, 2D m²], and moment of inertia over density: about z in 2D, the mean principal one
    in 3D."""
    if grain.form == "block":
        sides = [2 * grain.radius * grain.aspect[a] for a in range(grain.dim)]
        volume = math.prod(sides)
        squares = sum(side**2 for side in sides)
        return volume, volume * squares / (12 if grain.dim == 2 else 18)
    if grain.dim == 2:
        volume = math.pi * grain.radius**2
        return volume, 0.5 * volume * grain.radius**2
    volume = 4 / 3 * math.pi * grain.radius**3
    return volume, 0.4 * volume * grain.radius**2


def soft_material(material):
    """The SoftMat that a SoftMat, an index or a label of ``O.materials`` stands for (-1: the last
    one, added with default values if there is none); ValueError for another material."""
    if isinstance(material, str) or (isinstance(material, int) and material >= 0):
        material = O.materials[material]
    elif isinstance(material, int):
        if not any(isinstance(m, wrapper.SoftMat) for m in O.materials):
            O.materials.append(wrapper.SoftMat(label="softMat"))
        material = [m for m in O.materials if isinstance(m, wrapper.SoftMat)][-1]
    if not isinstance(material, wrapper.SoftMat):
        raise ValueError(f"material = {type(material).__name__}: soft grains need a SoftMat")
    return material
