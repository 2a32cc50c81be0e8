"""Turning soft grains rigid again, in place: into spheres, clumps or fixed facets."""

import math
from dataclasses import dataclass, field

import numpy as np
from yade import FrictMat, Matrix3, O, Sphere, Vector3, utils

from softgrain import _softgrain
from softgrain.bodies import bodies_of, is_soft, material_of, soft_bodies, unscaled_mass
from softgrain.checks import number
from softgrain.filling import fill
from softgrain.materials import found_material
from softgrain.overlaps import Ball, overlap_factor
from softgrain.softening import drop_interactions, look_anew
from softgrain.time_loop import critical_time_step, refuse_background_run

#: Outlines of clumps are off by that much of the size of the grain, if nothing else is said, by
#: dimension: some ten or twenty spheres in either.
DEFAULT_ERROR = {2: 0.01, 3: 0.05}
#: Spheres of a clump may leave the outline by that much of the error. By more of it, and they would
#: press on what the grain touches (``doc/decisions/0025-hardening.md``).
DEPTH_OVER_ERROR = 0.1
#: Below there would be hundreds of spheres, above nothing of the outline is left.
ERROR_RANGE = "[0.002, 0.3]"
#: Of grains whose boundary points are all that is known of a form which is no ball.
_LOST_FORM = "it cannot be turned rigid"


@dataclass
class Hardened:
    """What became of soft grains, and what was lost by it.

    Attributes:
        bodies (dict): by id of the grain the list of ids of the rigid bodies in its place: the
            sphere, which has the id of the grain, the clump, or the facets.
        momentum (ndarray): that the grains had and the rigid bodies do not have; shape (3,)
            [kg m/s, 2D kg/s].
        angular_momentum (ndarray): the same, about the origin; shape (3,) [kg m²/s, 2D kg m/s].
        energy (float): kinetic and elastic energy of the grains less the kinetic energy of the
            rigid bodies; the elastic one at the beginning of the last step [J, 2D J/m].
    """

    bodies: dict = field(default_factory=dict)
    momentum: np.ndarray = field(default_factory=lambda: np.zeros(3))
    angular_momentum: np.ndarray = field(default_factory=lambda: np.zeros(3))
    energy: float = 0.0

    @property
    def ids(self):
        """Of all rigid bodies."""
        return [i for bodies in self.bodies.values() for i in bodies]


def harden(ids=None, material=None, into="spheres", overlap="keep", error=None):
    """Turn soft grains into rigid bodies of YADE in place, between steps or by a PyRunner.

    A PyRunner must not stand between SoftGrainIntegrator and NewtonIntegrator, where outlines are a
    step ahead of ``state.pos``.

    * ``into='spheres'`` (disks and balls only): each becomes a sphere of its present area (volume)
      and keeps its id. The shape becomes round, so that grains that were flattened at their
      contacts overlap; see `overlap`.
    * ``into='clumps'``: each is erased, and a clump of overlapping spheres with its *deformed*
      outline is appended. The spheres are the largest that fit inside, as many as it takes to come
      within `error` of the outline everywhere; none leaves it by more than a tenth of that and
      0.05 of its own radius, whichever is less.
    * ``into='fixed'``: each is erased, and facets along its deformed outline are appended, which
      do not move any more. In 2D they stand upright in the plane of the grains.

    Of spheres and clumps mass, centre of mass, inertia, momentum and angular momentum are those of
    the grain to rounding (inertia of a sphere: that of its radius). In 2D they stay in their plane
    (``blockedDOFs = 'zXY'``). Elastic energy and vibrations are dropped. What is lost, with 'fixed'
    the momenta too, is returned. Contacts of the grains are dropped and found anew in the next
    step; those of what is still soft by contact dynamics, those of rigid pairs by the law that the
    engines have: a stiffness may ask for a smaller ``O.dt``, which is to be assigned then.

    Args:
        ids (iterable of int | None): soft grains; None: all of the scene.
        material (FrictMat | int | str | None): of the rigid bodies, or its index or label in
            ``O.materials``; None: the only FrictMat there. Its density is not used.
        into (str): 'spheres', 'clumps' or 'fixed'.
        overlap (str): of 'spheres'. 'keep': radii of the present areas; YADE's law makes forces of
            the overlaps. 'shrink': all radii are reduced by one common factor so that no two of
            the new spheres, and none of them and another sphere or a wall, overlap; masses and
            inertias stay.
        error (float | None): of 'clumps': largest distance from the grain's outline to that of the
            clump, over the radius of the disk (ball) of the same area (volume), in [0.002, 0.3]
            [-]; None: 0.01, in 3D 0.05. Outlines are polygons (triangles) between contact nodes; at
            sharp corners of cuboids it is half as much more.

    Returns:
        Hardened: ids of the rigid bodies, and what was lost.

    Raises:
        ValueError: a body is no soft grain, of a material with massScaling, or of a form or contact
            geometry that cannot be converted, there is no FrictMat, or none is given and there are
            several, or a value is unknown or out of its range. Nothing has been changed then.
        RuntimeError: a run is going on in the background. Nothing has been changed then.
    """
    refuse_background_run("harden")
    if into not in tuple(_MAKERS):  # what cannot be hashed is unknown, too
        raise ValueError(f"into = {into!r} is unknown; known: {', '.join(map(repr, _MAKERS))}")
    bodies = _grains(ids)
    material = _rigid_material(material)
    made = _MAKERS[into](bodies, material, overlap, error)
    look_anew()
    return made


def _grains(ids):
    bodies = soft_bodies() if ids is None else bodies_of(ids)
    for body in bodies:
        if not is_soft(body):
            raise ValueError(f"ids: body #{body.id} is no soft grain")
        motion = (*body.state.pos, *body.state.vel, *body.state.angVel)
        if not np.isfinite(motion).all():
            raise ValueError(f"ids: pos, vel or angVel of soft grain #{body.id} is not finite")
        scaling = material_of(body).massScaling
        if scaling != 1:
            raise ValueError(
                f"massScaling = {scaling} of soft grain #{body.id}: a rigid body would keep the "
                "scaled mass, and weigh as much; admissible is 1, sg.scale_mass(1)"
            )
    if not bodies:
        raise ValueError("ids: there is no soft grain to harden")
    critical_time_step()  # grains whose material has changed are made anew, as in the next step
    return bodies


def _rigid_material(material):
    if material is None:
        found = [m for m in O.materials if isinstance(m, FrictMat)]
        if len(found) != 1:
            labels = [m.label for m in found] if found else "none"
            raise ValueError(f"material: give a FrictMat; O.materials holds {labels}")
        return found[0]
    material = found_material(material)
    if not isinstance(material, FrictMat):
        raise ValueError(f"material = {type(material).__name__}: rigid bodies need a FrictMat")
    return material


@dataclass
class _Motion:
    """Of a soft grain as its State has it, with what a rigid body in its place takes over; in 2D
    per metre of thickness."""

    mass: float  #: kg
    centre: Vector3  #: of mass, m
    velocity: Vector3  #: of the centre, m/s
    inertia: np.ndarray  #: about the centre, kg m^2, shape (3, 3)
    spin: np.ndarray  #: angular momentum about the centre, kg m^2/s, shape (3,)

    @classmethod
    def of(cls, body):
        state, inertia = body.state, np.array(body.shape.inertia())
        spin = inertia @ np.array(state.angVel)
        return cls(unscaled_mass(body), Vector3(state.pos), Vector3(state.vel), inertia, spin)

    def momenta(self):
        """Momentum [kg m/s] and angular momentum about the origin [kg m^2/s], of shape (3,)."""
        momentum = self.mass * np.array(self.velocity)
        return momentum, np.cross(self.centre, momentum) + self.spin

    def kinetic(self):
        """Energy of a rigid body with this inertia [J]."""
        turning = self.spin @ np.linalg.pinv(self.inertia) @ self.spin
        return 0.5 * (self.mass * self.velocity.squaredNorm() + turning)


def _energy(body):
    energy = body.shape.energy()
    return energy["kinetic"] + energy["elastic"]


def _into_spheres(bodies, material, overlap, error):
    for body in bodies:
        if body.shape.form != "ball":
            has_outline = body.shape.contact != "points"
            instead = "use into='clumps' or 'fixed'" if has_outline else _LOST_FORM
            raise ValueError(f"ids: body #{body.id} is no soft disk or ball; {instead}")
    if overlap not in ("keep", "shrink"):
        raise ValueError(f"overlap = {overlap!r} is unknown; known: 'keep', 'shrink'")
    _refuse(error is not None, "error", error, "spheres")
    radii = [_equivalent_radius(body.shape) for body in bodies]
    factor = 1.0
    if overlap == "shrink":
        balls = [Ball.of(b, r) for b, r in zip(bodies, radii)]
        factor = overlap_factor(balls, "shrink", bodies[0].shape.dim)
    made = Hardened()
    for body, radius in zip(bodies, radii):
        energy = _energy(body)
        _become_sphere(body, material, radius)
        body.shape.radius *= factor
        state = body.state
        turning = sum(state.inertia[a] * state.angVel[a] ** 2 for a in range(3))
        made.energy += energy - 0.5 * (state.mass * state.vel.squaredNorm() + turning)
        made.bodies[body.id] = [body.id]
    drop_interactions(bodies)
    return made


def _refuse(given, name, value, into):
    if given:
        raise ValueError(f"{name} = {value!r}: it has no meaning with into={into!r}")


def _become_sphere(body, material, radius):
    state, grain, motion = body.state, body.shape, _Motion.of(body)
    inertia = (0.5 if grain.dim == 2 else 0.4) * motion.mass * radius**2
    body.shape = Sphere(radius=radius, color=grain.color)
    body.material = material
    state.blockedDOFs = _blocked(grain)
    state.mass, state.inertia = motion.mass, (inertia,) * 3
    state.vel, state.angVel = motion.velocity, Vector3(*(motion.spin / inertia))


def _equivalent_radius(grain):
    """Of the disk (ball) of the same present area (volume)."""
    if grain.dim == 2:
        return math.sqrt(grain.volume() / math.pi)
    return (0.75 * grain.volume() / math.pi) ** (1 / 3)


def _blocked(grain):
    return "zXY" if grain.dim == 2 else ""


def _outline(body):
    """Present places of the contact nodes (n, 3), and the facets between them (m, dim)."""
    facets = body.shape.facets()
    if not len(facets):
        instead = "use into='spheres'" if body.shape.form == "ball" else _LOST_FORM
        raise ValueError(
            f"ids: soft grain #{body.id} has contact = {body.shape.contact!r}, and so no outline; "
            f"{instead}"
        )
    return body.shape.outline(), facets


def _into_clumps(bodies, material, overlap, error):
    _refuse(overlap != "keep", "overlap", overlap, "clumps")
    if error is None:
        error = DEFAULT_ERROR[bodies[0].shape.dim]
    error = number("error", error, ERROR_RANGE)
    fillings = [_filling(body, error) for body in bodies]
    made = Hardened()
    for body, (centres, radii) in zip(bodies, fillings):
        motion, energy, grain_id = _Motion.of(body), _energy(body), body.id
        made.bodies[grain_id] = [_become_clump(body, motion, centres, radii, material)]
        made.energy += energy - motion.kinetic()
    return made


def _filling(body, error):
    """Centres (m, 3) and radii (m,) of spheres in a grain."""
    vertices, facets = _outline(body)
    dim = body.shape.dim
    gap = error * _equivalent_radius(body.shape)
    try:
        centres, radii = fill(vertices[:, :dim], facets, gap, depth=DEPTH_OVER_ERROR * gap)
    except ValueError as reason:
        raise ValueError(f"ids: soft grain #{body.id}: {reason}") from reason
    if dim == 2:
        centres = np.column_stack([centres, np.full(len(centres), body.state.pos[2])])
    return centres, radii


def _become_clump(body, motion, centres, radii, material):
    grain = body.shape
    spheres = [
        utils.sphere(Vector3(*c), r, material=material, color=grain.color, mask=body.mask)
        for c, r in zip(centres, radii.tolist())
    ]
    O.bodies.erase(body.id)
    clump, _ = O.bodies.appendClumped(spheres, discretization=0)
    inertia = motion.inertia if grain.dim == 3 else motion.inertia[2, 2] * np.eye(3)
    O.bodies[clump].mask = body.mask
    O.bodies[clump].state.blockedDOFs = _blocked(grain)
    _softgrain.becomeClump(
        clump,
        motion.centre,
        motion.mass,
        Matrix3(*inertia.ravel()),
        motion.velocity,
        Vector3(*motion.spin),
    )
    return clump


def _into_fixed(bodies, material, overlap, error):
    _refuse(overlap != "keep", "overlap", overlap, "fixed")
    _refuse(error is not None, "error", error, "fixed")
    if O.periodic:
        raise ValueError("into = 'fixed': fixed facets do not follow a periodic cell")
    outlines = [_outline(body) for body in bodies]
    made = Hardened()
    for body, (vertices, facets) in zip(bodies, outlines):
        momentum, angular_momentum = _Motion.of(body).momenta()
        made.momentum += momentum
        made.angular_momentum += angular_momentum
        made.energy += _energy(body)
        made.bodies[body.id] = O.bodies.append(_plates(body, vertices[facets], material))
        O.bodies.erase(body.id)
    return made


def _plates(body, facets, material):
    look = {"color": body.shape.color, "mask": body.mask, "material": material}
    return [utils.facet(_corners(ends), fixed=True, **look) for ends in facets]


def _corners(ends):
    """Of a facet: of a triangle those it has. A segment in the plane becomes an upright triangle
    with one side upright at its first end and a corner at the second: like the plane, it is its
    own mirror image, so that what touches it in the plane is not pushed out of it."""
    if len(ends) == 3:
        return [Vector3(*corner) for corner in ends]
    upright = Vector3(0, 0, 0.5 * float(np.linalg.norm(ends[1] - ends[0])))
    first, second = (Vector3(*end) for end in ends)
    return [first - upright, first + upright, second]


_MAKERS = {"spheres": _into_spheres, "clumps": _into_clumps, "fixed": _into_fixed}
