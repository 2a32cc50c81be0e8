"""Turning spheres and clumps of a scene into soft grains, in place."""

from dataclasses import dataclass

from yade import Body, InsertionSortCollider, Material, O, Sphere, Vector3, wrapper

from softgrain.bodies import bodies_of, soft_bodies
from softgrain.build import polygon_body, refuse_form, volume_and_inertia
from softgrain.checks import made, number
from softgrain.disk_union import outline_of_disks
from softgrain.materials import keep_material, soft_material
from softgrain.overlaps import Ball, overlap_factor
from softgrain.rigid_disks import is_single_sphere, require_plane, spheres_of
from softgrain.time_loop import (
    chosen_fraction,
    insert_before_solve,
    integrators,
    refuse_background_run,
    set_time_step,
)

#: Spheres lie in one plane where their centres differ by less than this share of a radius.
ONE_PLANE = 1e-6
#: Force over E D (3D: E D^2) that turns a sphere with ``when='loaded'``, if nothing else is said.
USUAL_LOAD = 1e-3


def soften(
    ids=None,
    material=-1,
    zeta=0.11,
    dim=None,
    overlap="relax",
    time_step_fraction=None,
    when="now",
    load=None,
    **shape,
):
    """Turn spheres of the scene, and in 2D clumps of them, into soft grains in place, keeping
    position, velocity, spin and radius.

    Spheres become disks (dim = 2) where the scene is two-dimensional: all of them in one plane
    z = const, with the out-of-plane degrees of freedom ``z``, ``X`` and ``Y`` blocked. Interactions
    of the converted spheres are dropped; the contacts of the soft grains are found in the next
    step. ``O.dt`` is set for the scene (see :func:`set_time_step`).

    A clump whose members overlap becomes one grain with the outline of all of them: it is erased
    with its members, and the grain appended under an id of its own. It is homogeneous, of the
    density of `material`, and ``zeta`` is over the radius of the largest circle inside.

    Rigid packings carry their load by overlaps. They are treated by choice:

    * ``overlap='relax'`` (default): radii are kept; the overlaps are worked off over several steps
      with a capped speed (``SoftGrainIntegrator.overlapRelaxation``, ``overlapSpeed``), which turns
      them into deformation. Refused if an overlap is larger than 5 % of the smaller radius.
    * ``overlap='shrink'``: all radii are reduced by one common factor so that no two of these
      grains, and no grain and rigid sphere or wall, overlap.
    * ``overlap='refuse'``: any such overlap is an error. (Boxes, facets and soft grains that are
      there already do not count.)

    With ``when='loaded'`` spheres stay rigid until they first bear load, each for itself: a
    ``SoftenWhenLoaded`` before the ``SoftGrainIntegrator`` of ``O.engines`` turns them. Until then
    they touch each other by YADE's law, soft grains by contact dynamics; ``O.dt`` is the script's
    before the first one is turned, the integrator's from then on, which goes beyond the script's
    only up to 0.3 of what the stiffest sphere left asks for (``utils.PWaveTimeStep``). They get the
    mass of soft grains, of the density of `material` and in 2D of disks, at once. Overlaps are
    those of the rigid law at the load: they are relaxed.

    Args:
        ids (iterable of int | None): spheres and clumps to convert; None: all spheres that are
            neither in clumps nor held.
        material (SoftMat | int | str): material of the soft grains, as in :func:`soft_disk`.
        zeta (float): relative resolution 2 dr/D, in [0.001, 0.5] [-].
        dim (int | None): 2 or 3; None: by the scene.
        overlap (str): 'relax', 'shrink' or 'refuse'.
        time_step_fraction (float | None): O.dt over the critical step, in (0, 1] [-]; None: as for
            :func:`set_time_step`.
        when (str): 'now' or, spheres only, 'loaded'.
        load (float | None): with 'loaded', force of a contact over E D (3D: E D^2) above which a
            sphere is turned, E of the material, D its diameter, >= 0 [-]; None: 1e-3.
        **shape: further attributes of ``SoftGrain``.

    Returns:
        list of int: ids of the soft grains, or of the bodies that are to become such.

    Raises:
        ValueError: a body is neither sphere nor clump, is held (``x``, ``y`` or ``Z`` among its
            ``blockedDOFs``, as by ``fixed=True``, in 3D any: a soft grain cannot be), a clump is in
            3D, falls into parts or encloses a hole, the
            scene's dimension is not clear, an overlap is refused, grains would differ from others
            in ``dim``, ``contact`` or plane, or a parameter is out of its range. Nothing has been
            changed then.
        RuntimeError: a run is going on in the background. Nothing has been changed then.
    """
    refuse_background_run("soften")
    time_step_fraction = chosen_fraction("time_step_fraction", time_step_fraction)
    load_given = load is not None
    load = number("load", load if load_given else USUAL_LOAD, "[0, inf)")
    _refuse_kept(shape)
    bodies = _rigid_grains(ids)
    dim = _dimension(bodies) if dim is None else dim
    if dim == 3:
        _refuse_blocked(bodies)
    material = soft_material(material)
    if when == "loaded":
        if overlap != "relax":
            raise ValueError(f"overlap = {overlap!r} with when='loaded'; admissible: 'relax'")
        grain = made(wrapper.SoftGrain, {**shape, "radius": 1, "dim": dim, "zeta": zeta})
        _soften_when_loaded(bodies, grain, material, load, time_step_fraction)
        return [b.id for b in bodies]
    if when != "now":
        raise ValueError(f"when = {when!r} is unknown; known: 'now', 'loaded'")
    if load_given:
        raise ValueError(f"load = {load}: it has no meaning with when='now'")
    spheres = [part for body in bodies for part in spheres_of(body)]
    factor = overlap_factor([Ball.of(sphere) for sphere in spheres], overlap, dim)
    shape.update(dim=dim, zeta=zeta)
    grains = [_soft_counterpart(body, factor, material, shape) for body in bodies]
    _require_alike(bodies, made(wrapper.SoftGrain, {**shape, "radius": 1}))
    return _replace(bodies, grains, material, time_step_fraction)


def _refuse_kept(shape):
    """ValueError for attributes of ``SoftGrain`` that the spheres decide on."""
    refuse_form(shape)
    if "color" in shape:
        raise ValueError(f"color = {shape['color']}: soft grains keep that of their spheres")


def _replace(bodies, grains, material, fraction):
    """Put soft counterparts in the place of spheres and clumps, or leave all as it is where they do
    not fit with the soft grains that there are (ValueError); returns their ids."""
    before = [_Sphere.of(body) for body in bodies if not body.isClump]
    converted = []
    try:
        for body, grain in zip(bodies, grains):
            converted.append(
                O.bodies.append(grain) if body.isClump else _convert(body, grain, material)
            )
        set_time_step(fraction)
    except Exception:
        for sphere in before:
            sphere.restore()
        for body, grain_id in zip(bodies, converted):
            if body.isClump:
                O.bodies.erase(grain_id)
        raise
    keep_material(material)
    drop_interactions([part for body in bodies for part in spheres_of(body)])
    for body in bodies:
        if body.isClump:
            O.bodies.erase(body.id, True)
    return converted


@dataclass
class _Sphere:
    """What of a sphere is changed when it turns soft."""

    body: Body
    shape: Sphere
    material: Material
    state: dict

    @classmethod
    def of(cls, body):
        state = {name: getattr(body.state, name) for name in ("mass", "blockedDOFs")}
        for name in ("inertia", "vel", "angVel"):
            state[name] = Vector3(getattr(body.state, name))  # not a reference to it
        return cls(body, body.shape, body.material, state)

    def restore(self):
        self.body.shape, self.body.material = self.shape, self.material
        for name, value in self.state.items():
            setattr(self.body.state, name, value)


def _soft_counterpart(body, factor, material, shape):
    """The shape for a sphere, the body for a clump, all radii changed by a factor."""
    if body.isClump:
        return _soft_clump(body, factor, material, shape)
    look = {"radius": factor * body.shape.radius, "color": body.shape.color}
    return made(wrapper.SoftGrain, {**look, **shape})


def _soft_clump(clump, factor, material, shape):
    if shape["dim"] != 2:
        raise ValueError(f"ids: body #{clump.id} is a clump; in 3D only spheres can be softened")
    parts = spheres_of(clump)
    aside = max(parts, key=lambda part: abs(part.state.pos[2] - clump.state.pos[2]))
    if abs(aside.state.pos[2] - clump.state.pos[2]) > ONE_PLANE * aside.shape.radius:
        raise ValueError(
            f"ids: member #{aside.id} of clump #{clump.id} is centred at z = "
            f"{aside.state.pos[2]:g} m; admissible in 2D: the plane of all, z = "
            f"{clump.state.pos[2]:g} m"
        )
    try:
        vertices, corners = outline_of_disks(
            [tuple(part.state.pos)[:2] for part in parts],
            [factor * part.shape.radius for part in parts],
        )
    except ValueError as error:
        raise ValueError(f"ids: clump #{clump.id}: {error}; its members must overlap") from None
    attributes = {name: value for name, value in shape.items() if name != "dim"}
    color, mask, z = parts[0].shape.color, parts[0].mask, clump.state.pos[2]
    body = polygon_body(vertices, material, color, mask, corners, z, attributes)
    spin = Vector3(0, 0, clump.state.angVel[2])
    velocity = clump.state.vel + spin.cross(body.state.pos - clump.state.pos)
    body.state.vel, body.state.angVel = (velocity[0], velocity[1], 0), spin
    return body


def _soften_when_loaded(bodies, grain, material, load, fraction):
    ids = [b.id for b in bodies]
    clumps = [b.id for b in bodies if b.isClump]
    if clumps:
        raise ValueError(f"ids: clump #{clumps[0]} with when='loaded'; admissible: spheres")
    softener = wrapper.SoftenWhenLoaded(ids=ids, shape=grain, material=material, load=load)
    engine = next(iter(integrators()), None)
    if engine is None:
        raise ValueError(
            "when = 'loaded' needs a SoftGrainIntegrator in O.engines; assign O.engines = "
            "sg.engines(verlet_distance=...) first"
        )
    if grain.dim == 2:
        for body in bodies:
            require_plane(body)
    _require_alike(bodies, grain)
    _refuse_waiting(ids)
    for body in bodies:
        _give_mass(body, grain, material.density)
    keep_material(material)
    engine.timeStepFraction = fraction
    insert_before_solve(softener)


def _softeners():
    return [e for e in O.engines if isinstance(e, wrapper.SoftenWhenLoaded)]


def _refuse_waiting(ids):
    """ValueError for bodies that would be turned by two engines."""
    waiting = {i for softener in _softeners() for i in softener.ids}
    twice = [i for i in ids if i in waiting]
    if twice:
        raise ValueError(
            f"ids: body #{twice[0]} waits already to turn soft, for a SoftenWhenLoaded of "
            "O.engines; soften it now, or take that out"
        )


def _require_alike(bodies, grain):
    """ValueError where spheres and clumps, once soft, would not fit with each other or with the
    soft grains that there are or will be: a step would see it too late."""
    others = [(b, b.shape) for b in soft_bodies()[:1]]
    kept = range(len(O.bodies))  # the engine passes over ids of none
    others += [
        (O.bodies[i], e.shape)
        for e in _softeners()
        if e.shape
        for i in e.ids
        if i in kept and O.bodies[i]
    ]
    for _, shape in others:
        for name in ("dim", "contact"):
            own, there = getattr(grain, name), getattr(shape, name)
            if own != there:
                raise ValueError(
                    f"{name} = {own!r}: other grains of the scene are soft, or will be, with "
                    f"{there!r}; admissible: one for all"
                )
    if grain.dim == 3:
        return
    plane = [*(b for b, _ in others), *bodies][0].state.pos[2]
    for body in bodies:
        radius = spheres_of(body)[0].shape.radius
        if abs(body.state.pos[2] - plane) > ONE_PLANE * radius:
            raise ValueError(
                f"ids: body #{body.id} is centred at z = {body.state.pos[2]:g} m; admissible in "
                f"2D: the plane of all soft grains, z = {plane:g} m"
            )


def _give_mass(sphere, grain, density):
    """Mass and inertia of a soft grain like `grain`, of radius 1, so that they stay when it turns
    soft."""
    radius = sphere.shape.radius
    volume, inertia = volume_and_inertia(grain)
    sphere.state.mass = density * volume * radius**grain.dim
    sphere.state.inertia = (density * inertia * radius ** (grain.dim + 2),) * 3


def _rigid_grains(ids):
    if ids is None:
        spheres = [b for b in O.bodies if b and is_single_sphere(b)]
        bodies = [b for b in spheres if not _is_held(b)]
        if spheres and not bodies:
            _refuse_held(spheres[0])
    else:
        bodies = bodies_of(ids)
        for body in bodies:
            if not (body.isClump or is_single_sphere(body)):
                part = f"; it is a member of clump #{body.clumpId}" if body.isClumpMember else ""
                raise ValueError(
                    f"ids: body #{body.id} is neither a sphere outside clumps nor a clump; only "
                    f"these can be softened{part}"
                )
            if _is_held(body):
                _refuse_held(body)
            if not all(isinstance(part.shape, Sphere) for part in spheres_of(body)):
                raise ValueError(f"ids: clump #{body.id} has a member that is no sphere")
    if not bodies:
        raise ValueError("ids: there is no sphere to soften")
    return bodies


def _is_held(body):
    """In a motion within the plane of 2D, in which ``z``, ``X`` and ``Y`` keep spheres."""
    return bool(set("xyZ") & set(body.state.blockedDOFs))


def _refuse_held(body):
    raise ValueError(
        f"ids: body #{body.id} is held, blockedDOFs = {body.state.blockedDOFs!r}, and would be "
        "free as a soft grain; admissible: neither 'x', 'y' nor 'Z' among them (a layer lies in a "
        "plane z = const), nothing at all with dim = 3"
    )


def _refuse_blocked(bodies):
    """ValueError in 3D, where no motion of a sphere is one that a soft grain could not have."""
    for body in bodies:
        if body.state.blockedDOFs:
            _refuse_held(body)


def _dimension(bodies):
    flat = all(set("zXY") <= set(b.state.blockedDOFs) for b in bodies)
    solid = not any(set("zXY") & set(b.state.blockedDOFs) for b in bodies)
    heights = [b.state.pos[2] for b in bodies]
    smallest = min(part.shape.radius for b in bodies for part in spheres_of(b))
    one_layer = max(heights) - min(heights) < ONE_PLANE * smallest
    if flat and one_layer:
        return 2
    if solid and (not one_layer or len(bodies) == 1):
        return 3
    raise ValueError(
        "dim: the scene is neither clearly 2D (one layer z = const, blockedDOFs including 'zXY') "
        "nor clearly 3D; give dim=2 or dim=3"
    )


def drop_interactions(bodies):
    """Erase all interactions of the bodies; those that are still near are found anew."""
    ids = {b.id for b in bodies}
    for i in list(O.interactions.all()):
        if i.id1 in ids or i.id2 in ids:
            O.interactions.erase(i.id1, i.id2)
    look_anew()


def look_anew():
    """Have the collider look at all pairs again: those dropped are known to it as seen."""
    for engine in O.engines:
        if isinstance(engine, InsertionSortCollider):
            engine.doSort = True


def _convert(body, grain, material):
    """Returns its id."""
    state = body.state
    body.shape = grain
    body.material = material
    volume, inertia = volume_and_inertia(grain)
    state.mass = volume * material.density
    state.inertia = (inertia * material.density,) * 3
    velocity, spin = state.vel, state.angVel
    if grain.dim == 2:
        velocity = (velocity[0], velocity[1], 0)
        spin = (0, 0, spin[2])
    # NewtonIntegrator then carries the state along and applies no force
    state.blockedDOFs = "xyzXYZ"
    state.vel, state.angVel = velocity, spin
    return body.id
