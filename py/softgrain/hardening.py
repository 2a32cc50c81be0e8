"""Turning soft grains back into rigid spheres, in place."""

import math

from yade import FrictMat, O, Sphere, wrapper

from softgrain.observe import soft_bodies
from softgrain.softening import drop_interactions, overlap_factor


def harden(ids=None, material=None, overlap="keep"):
    """Turn soft disks and balls into YADE's spheres in place, at any time.

    Of each grain mass, present area (volume), centre of mass, momentum and angular momentum are
    kept; the shape becomes round, and elastic energy and vibrations are dropped. In 2D the spheres
    stay in their plane (``blockedDOFs = 'zXY'``) and have mass and inertia of disks. The grains'
    interactions are dropped; rigid pairs go by YADE's law, whose stiffness may ask for a smaller
    ``O.dt``: assign it. Grains that were flattened at their contacts overlap as spheres:

    * ``overlap='keep'`` (default): radii of the present areas; YADE's law makes forces of the
      overlaps.
    * ``overlap='shrink'``: all radii are reduced by one common factor so that no two of the new
      spheres, and no sphere and wall, overlap; masses and inertias stay.

    Args:
        ids (iterable of int | None): soft grains; None: all of the scene.
        material (FrictMat | None): of the spheres; None: the last FrictMat of ``O.materials``. Its
            density is not used.
        overlap (str): 'keep' or 'shrink'.

    Returns:
        list of int: ids of the bodies that were converted.

    Raises:
        ValueError: a body is no soft disk or ball, there is no FrictMat, or a value is unknown.
            Nothing has been changed then.
    """
    bodies = _round_grains(ids)
    material = _rigid_material(material)
    if overlap not in ("keep", "shrink"):
        raise ValueError(f"overlap = {overlap!r} is unknown; known: 'keep', 'shrink'")
    for body in bodies:
        _convert(body, material)
    if overlap == "shrink":
        factor = overlap_factor(bodies, "shrink")
        for body in bodies:
            body.shape.radius *= factor
    drop_interactions(bodies)
    return [b.id for b in bodies]


def _round_grains(ids):
    bodies = soft_bodies() if ids is None else [O.bodies[i] for i in ids]
    for body in bodies:
        if not (body and isinstance(body.shape, wrapper.SoftGrain) and body.shape.form == "ball"):
            raise ValueError(f"ids: body #{body and body.id} is no soft disk or ball")
    if not bodies:
        raise ValueError("ids: there is no soft grain to harden")
    return bodies


def _rigid_material(material):
    if material is None:
        found = [m for m in O.materials if isinstance(m, FrictMat)]
        if not found:
            raise ValueError("material: give a FrictMat, O.materials holds none")
        return found[-1]
    if not isinstance(material, FrictMat):
        raise ValueError(f"material = {type(material).__name__}: rigid spheres need a FrictMat")
    return material


def _convert(body, material):
    state, grain = body.state, body.shape
    spin = [state.inertia[a] * state.angVel[a] for a in range(3)]
    if grain.dim == 2:
        radius = math.sqrt(grain.volume() / math.pi)
        inertia = 0.5 * state.mass * radius**2
    else:
        radius = (0.75 * grain.volume() / math.pi) ** (1 / 3)
        inertia = 0.4 * state.mass * radius**2
    velocity = state.vel
    body.shape = Sphere(radius=radius, color=grain.color)
    body.material = material
    state.blockedDOFs = "zXY" if grain.dim == 2 else ""
    state.inertia = (inertia,) * 3
    state.vel, state.angVel = velocity, [component / inertia for component in spin]
