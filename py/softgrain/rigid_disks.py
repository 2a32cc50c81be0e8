"""Rigid spheres of a scene, and clumps of them, as the disks of a 2D one."""

import math

from yade import O, Sphere

from softgrain.bodies import bodies_of
from softgrain.time_loop import refuse_background_run

#: Members of a clump count as touching, not overlapping, at this share of two radii: rounding.
TOUCHING = 0.999


def as_disks(ids=None):
    """Give spheres of a 2D scene, and clumps of them, the mass and inertia of disks per metre of
    thickness, as soft disks have theirs.

    YADE makes a 2D scene of spheres that stay in a plane, with the mass of a ball, 4/3 pi R^3
    density. Beside soft disks, of pi R^2 density kg/m, such a sphere weighs 4 R/3 (in m) of what a
    disk of the same material does. Contact takes the mass and inertia that are in ``State``.

    Args:
        ids (iterable of int | None): spheres and clumps; None: all spheres of the scene that are
            not in clumps, and all clumps of spheres.

    Returns:
        list of int: ids of the changed bodies.

    Raises:
        ValueError: a body is neither, or there is none, its out-of-plane degrees of freedom ``z``,
            ``X`` and ``Y`` are not blocked, or a clump has members that overlap or differ in
            radius. Nothing has been changed then.
        RuntimeError: a run is going on in the background. Nothing has been changed then.
    """
    refuse_background_run("as_disks")
    if ids is None:
        bodies = [b for b in O.bodies if b and (_is_clump_of_spheres(b) or is_single_sphere(b))]
    else:
        bodies = bodies_of(ids)
    if not bodies:
        raise ValueError("ids: there is no sphere and no clump")
    disks = [(b, _disk_mass_and_inertia(b)) for b in bodies]
    for body, (mass, inertia) in disks:
        body.state.mass = mass
        body.state.inertia = (inertia,) * 3
    return [b.id for b in bodies]


def spheres_of(body):
    """The members of a clump, or the sphere itself."""
    return [O.bodies[i] for i in body.shape.members] if body.isClump else [body]


def _is_clump_of_spheres(body):
    return body.isClump and all(isinstance(part.shape, Sphere) for part in spheres_of(body))


def is_single_sphere(body):
    """Whether a body is a sphere outside clumps."""
    return isinstance(body.shape, Sphere) and not body.isClumpMember


def require_plane(body):
    """ValueError unless a body is kept in the plane of a 2D scene."""
    if not set("zXY") <= set(body.state.blockedDOFs):
        raise ValueError(
            f"ids: body #{body.id} has blockedDOFs = {body.state.blockedDOFs!r}; a disk of a 2D "
            "scene has at least 'zXY'"
        )


def _disk_mass_and_inertia(body):
    """Of a sphere or a clump of spheres, as disks per metre of thickness [kg/m, kg m]."""
    if not (body.isClump or is_single_sphere(body)):
        raise ValueError(f"ids: body #{body.id} is no sphere outside clumps and no clump")
    require_plane(body)
    parts = spheres_of(body)
    if not all(isinstance(part.shape, Sphere) for part in parts):
        raise ValueError(f"ids: clump #{body.id} has a member that is no sphere")
    radii = [part.shape.radius for part in parts]
    if max(radii) > (1 + 1e-9) * min(radii) or any(
        (a.state.pos - b.state.pos).norm() < 2 * TOUCHING * radii[0]
        for k, a in enumerate(parts)
        for b in parts[:k]
    ):
        raise ValueError(
            f"ids: members of clump #{body.id} overlap or differ in radius, so that its centre of "
            "mass is not that of the disks; set state.mass and state.inertia by hand"
        )
    masses = [math.pi * part.shape.radius**2 * part.material.density for part in parts]
    inertia = sum(
        mass * (0.5 * part.shape.radius**2 + (part.state.pos - body.state.pos).squaredNorm())
        for mass, part in zip(masses, parts)
    )
    return sum(masses), inertia
