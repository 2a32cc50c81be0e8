"""Making soft grains."""

import math

import numpy as np
from yade import Body, Quaternion, Vector3, utils, wrapper

from softgrain.checks import finite_vector, index, lengths, made, number, rgb
from softgrain.materials import keep_material, soft_material
from softgrain.outlines import area_and_inertia, normalized

#: Attributes of ``SoftGrain`` that the functions here set themselves.
_FORM = ("form", "aspect", "exponent", "vertices", "corners", "radius", "dim")


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
    return _kept(_soft_body(center, radius, 2, material, color, mask, shape))


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
    sides = lengths("size", size, (2, 3))
    outline = {"form": "block", "aspect": _aspect("size", sides)}
    return _kept(
        _soft_body(center, min(sides) / 2, len(sides), material, color, mask, shape, outline)
    )


def soft_ellipse(center, half_axes, angle=0.0, material=-1, color=None, mask=1, **shape):
    """A soft ellipse in the xy-plane: a :func:`soft_superdisk` of exponent 2.

    Args:
        center (Vector3): position of the centre [m].
        half_axes (tuple): half axes, each > 0 and at most 100 times the shorter [m].
        angle (float): from the x axis to the first half axis [rad].
        material, color, mask, **shape: as for :func:`soft_disk`; ``zeta`` is over the shorter half
            axis, which is the grain's ``radius``.

    Returns:
        Body: to be added with ``O.bodies.append``.

    Raises:
        ValueError: a value is out of its range, or the material is no ``SoftMat``.
    """
    refuse_form(shape)
    return soft_superdisk(center, half_axes, 2.0, angle, material, color, mask, **shape)


def soft_superdisk(
    center, half_axes, exponent=4.0, angle=0.0, material=-1, color=None, mask=1, **shape
):
    """A soft superdisk (superellipse) in the xy-plane, abs(x/a)^n + abs(y/b)^n = 1.

    Args:
        exponent (float): n, in [1.25, 20] [-]: 2 is an ellipse, 20 nearly a rectangle.
        center, half_axes, angle, material, color, mask, **shape: as for :func:`soft_ellipse`.

    Returns, raises: as :func:`soft_ellipse`.
    """
    axes = lengths("half_axes", half_axes, (2,))
    angle = number("angle", angle, "(-inf, inf)", "rad")
    if axes[1] > axes[0]:  # the longer one along the grain's own x axis: one table for both
        axes.reverse()
        angle += math.pi / 2
    outline = {"form": "superdisk", "aspect": _aspect("half_axes", axes), "exponent": exponent}
    turned = _turned(angle)
    body = _soft_body(center, min(axes), 2, material, color, mask, shape, outline)
    body.state.ori = turned
    return _kept(body)


def soft_polygon(vertices, material=-1, color=None, mask=1, corners=None, z=0.0, **shape):
    """A soft grain in the xy-plane with any simple polygon as its outline, convex or not.

    Through vertices that are no corners the outline runs smoothly, so that a finely sampled curve
    may be given as well. Notches narrower than some four node spacings are stiffer than they should
    be, as both their sides lean on the same background nodes, and the two sides of a notch do not
    feel each other.

    Args:
        vertices (array): in order around it, either way, shape (n, 2) [m].
        corners (iterable of int | None): vertices at which the outline has a kink; None: those at
            which it turns by more than 20 degrees.
        z (float): of the plane [m].
        material, color, mask, **shape: as for :func:`soft_disk`; ``zeta`` is over the radius of the
            largest circle inside, which is the grain's ``radius``.

    Returns:
        Body: to be added with ``O.bodies.append``; its position is the centroid, and its
        orientation that in which congruent polygons have the same axes, in general not the
        identity: turn it by ``state.ori = turn * state.ori``.

    Raises:
        ValueError: the polygon crosses itself or has no area, a value is out of its range, or the
            material is no ``SoftMat``.
    """
    return _kept(polygon_body(vertices, material, color, mask, corners, z, shape))


def polygon_body(vertices, material, color, mask, corners, z, shape):
    """:func:`soft_polygon`, but a material that is made for it is not in ``O.materials``."""
    form = normalized(vertices, corners)
    z = number("z", z, "(-inf, inf)", "m")
    outline = {"form": "polygon", "vertices": form.vertices.tolist(), "corners": form.corners}
    center = (*form.centroid, z)
    body = _soft_body(center, form.radius, 2, material, color, mask, shape, outline)
    body.state.ori = _turned(form.angle)
    return body


def soft_sphere(center, radius, material=-1, color=None, mask=1, **shape):
    """A soft ball; arguments, result and errors as for :func:`soft_disk`."""
    return _kept(_soft_body(center, radius, 3, material, color, mask, shape))


def _kept(body):
    """The same, its material in ``O.materials`` if it was made for it."""
    keep_material(body.material)
    return body


def _aspect(name, sides):
    """Over the shortest one, to 12 digits: equal for congruent grains; `name`: for a message."""
    if max(sides) > 100 * min(sides):
        raise ValueError(f"{name} = {sides}: admissible is up to 100 times the shortest")
    return [round(side / min(sides), 12) for side in sides] + [1.0] * (3 - len(sides))


def _turned(angle):
    return Quaternion((0, 0, 1), angle)


def _soft_body(center, radius, dim, material, color, mask, shape, form=None):
    """`shape`: attributes as the user gave them; `form`: those of the outline."""
    center = finite_vector("center", center, 3, "m")
    radius = number("radius", radius, "(0, inf)", "m")
    mask = index("mask", mask)
    color = utils.randomColor() if color is None else rgb(color)
    refuse_form(shape)
    material = soft_material(material)
    body = Body()
    attributes = {**shape, **(form or {}), "radius": radius, "dim": dim, "color": Vector3(*color)}
    body.shape = made(wrapper.SoftGrain, attributes)
    try:
        volume, inertia = volume_and_inertia(body.shape)
    except OverflowError:
        raise ValueError(f"radius = {radius}: the volume of the grain is no number") from None
    utils._commonBodySetup(
        body,
        volume,
        Vector3(inertia, inertia, inertia),
        material,
        pos=center,
        fixed=True,
    )
    body.mask = mask
    return body


def refuse_form(shape):
    """ValueError for attributes of ``SoftGrain`` that are not the user's to give: they make the
    outline."""
    for name in _FORM:
        if name in shape:
            raise ValueError(
                f"{name} = {shape[name]!r}: the function that makes the grain sets it; call the "
                "one for the outline that is meant (sg.soft_disk, sg.soft_block, ...)"
            )


def volume_and_inertia(grain):
    """Volume [m³, 2D m²], and moment of inertia over density: about z in 2D, the mean principal one
    in 3D."""
    if grain.form == "block":
        sides = [2 * grain.radius * grain.aspect[a] for a in range(grain.dim)]
        volume = math.prod(sides)
        squares = sum(side**2 for side in sides)
        return volume, volume * squares / (12 if grain.dim == 2 else 18)
    if grain.form == "superdisk":
        a, b, n = grain.radius * grain.aspect[0], grain.radius * grain.aspect[1], grain.exponent
        return (
            _moment_of_superdisk(a, b, n, 1, 1),
            _moment_of_superdisk(a, b, n, 3, 1) + _moment_of_superdisk(a, b, n, 1, 3),
        )
    if grain.form == "polygon":
        area, _, inertia = area_and_inertia(grain.radius * np.array(grain.vertices))
        return area, inertia
    if grain.dim == 2:
        volume = math.pi * grain.radius**2
        return volume, 0.5 * volume * grain.radius**2
    volume = 4 / 3 * math.pi * grain.radius**3
    return volume, 0.4 * volume * grain.radius**2


def _moment_of_superdisk(a, b, n, p, q):
    """Integral of abs(x)^(p-1) abs(y)^(q-1), after Dirichlet."""
    gammas = math.gamma(p / n) * math.gamma(q / n) / math.gamma(1 + (p + q) / n)
    return 4 * a**p * b**q / n**2 * gammas
