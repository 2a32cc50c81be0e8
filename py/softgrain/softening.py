"""Turning spheres of a scene into soft grains, in place, and into disks."""

import math

from yade import InsertionSortCollider, O, Sphere, Vector3, wrapper

from softgrain.build import soft_material, volume_and_inertia
from softgrain.observe import nearest_images
from softgrain.time_loop import check_fraction, set_time_step

#: Overlaps up to this share of the smaller radius are left to be worked off; rigid packings of
#: usual stiffness stay below.
WORKABLE_OVERLAP = 0.05
#: Members of a clump count as touching, not overlapping, at this share of two radii: rounding.
TOUCHING = 0.999
#: Spheres lie in one plane where their centres differ by less than this share of a radius.
ONE_PLANE = 1e-6


def soften(
    ids=None,
    material=-1,
    zeta=0.11,
    dim=None,
    overlap="relax",
    time_step_fraction=0.8,
    when="now",
    load=1e-3,
    **shape,
):
    """Turn spheres of the scene into soft grains in place, keeping position, velocity, spin and
    radius.

    Spheres become disks (dim = 2) where the scene is two-dimensional: all of them in one plane
    z = const, with the out-of-plane degrees of freedom ``z``, ``X`` and ``Y`` blocked. Interactions
    of the converted spheres are dropped; the contacts of the soft grains are found in the next
    step. ``O.dt`` is set for the scene (see :func:`set_time_step`).

    Rigid packings carry their load by overlaps. They are treated by choice:

    * ``overlap='relax'`` (default): radii are kept; the overlaps are worked off over several steps
      with a capped speed (``SoftGrainIntegrator.overlapRelaxation``, ``overlapSpeed``), which turns
      them into deformation. Refused if an overlap is larger than 5 % of the smaller radius.
    * ``overlap='shrink'``: all radii are reduced by one common factor so that no two grains, and no
      grain and wall, overlap.
    * ``overlap='refuse'``: any overlap is an error.

    With ``when='loaded'`` spheres stay rigid until they first bear load, each for itself: a
    ``SoftenWhenLoaded`` before the ``SoftGrainIntegrator`` of ``O.engines`` turns them. Until then
    they touch each other by YADE's law, soft grains by contact dynamics; ``O.dt`` is the script's
    before the first one is turned, the integrator's from then on. In 2D they get the mass of disks
    at once (:func:`as_disks`). Overlaps are those of the rigid law at the load: they are relaxed.

    Args:
        ids (iterable of int | None): bodies to convert; None: all spheres that are not in clumps.
        material (SoftMat | int | str): material of the soft grains, as in :func:`soft_disk`.
        zeta (float): relative resolution 2 dr/D, in [0.001, 0.5] [-].
        dim (int | None): 2 or 3; None: by the scene.
        overlap (str): 'relax', 'shrink' or 'refuse'.
        time_step_fraction (float): O.dt over the critical step, in (0, 1] [-].
        when (str): 'now' or 'loaded'.
        load (float): with 'loaded', force of a contact over E D (3D: E D^2) above which a sphere is
            turned, E of the material, D its diameter, >= 0 [-].
        **shape: further attributes of ``SoftGrain``.

    Returns:
        list of int: ids of the bodies that were, or are to be, converted.

    Raises:
        ValueError: a body is no sphere, the scene's dimension is not clear, an overlap is refused,
            or a parameter is out of its range. Nothing has been changed then.
    """
    check_fraction("time_step_fraction", time_step_fraction)
    bodies = _spheres(ids)
    dim = _dimension(bodies) if dim is None else dim
    material = soft_material(material)
    if when == "loaded":
        if overlap != "relax":
            raise ValueError(f"overlap = {overlap!r} with when='loaded'; admissible: 'relax'")
        grain = wrapper.SoftGrain(radius=1, dim=dim, zeta=zeta, **shape)
        _soften_when_loaded(bodies, grain, material, load, time_step_fraction)
        return [b.id for b in bodies]
    if when != "now":
        raise ValueError(f"when = {when!r} is unknown; known: 'now', 'loaded'")
    factor = overlap_factor(bodies, overlap)
    shapes = [
        wrapper.SoftGrain(
            radius=factor * b.shape.radius, dim=dim, zeta=zeta, color=b.shape.color, **shape
        )
        for b in bodies
    ]
    drop_interactions(bodies)
    for body, grain in zip(bodies, shapes):
        _convert(body, grain, material)
    set_time_step(time_step_fraction)
    return [b.id for b in bodies]


def _soften_when_loaded(bodies, grain, material, load, fraction):
    ids = [b.id for b in bodies]
    softener = wrapper.SoftenWhenLoaded(ids=ids, shape=grain, material=material, load=load)
    engines = list(O.engines)
    places = [k for k, e in enumerate(engines) if isinstance(e, wrapper.SoftGrainIntegrator)]
    if not places:
        raise ValueError(
            "when = 'loaded' needs a SoftGrainIntegrator in O.engines; assign O.engines = "
            "sg.engines(verlet_distance=...) first"
        )
    if grain.dim == 2:
        as_disks(ids)
    engines[places[0]].timeStepFraction = fraction
    O.engines = engines[: places[0]] + [softener] + engines[places[0] :]


def _spheres(ids):
    if ids is None:
        bodies = [b for b in O.bodies if b and isinstance(b.shape, Sphere) and not b.isClumpMember]
    else:
        bodies = [O.bodies[i] for i in ids]
        for i, body in zip(ids, bodies):
            if body is None or not isinstance(body.shape, Sphere) or body.isClumpMember:
                raise ValueError(
                    f"ids: body #{i} is not a sphere outside clumps; only these can be softened"
                )
    if not bodies:
        raise ValueError("ids: there is no sphere to soften")
    return bodies


def _dimension(bodies):
    flat = all(set("zXY") <= set(b.state.blockedDOFs) for b in bodies)
    solid = not any(set("zXY") & set(b.state.blockedDOFs) for b in bodies)
    heights = [b.state.pos[2] for b in bodies]
    one_layer = max(heights) - min(heights) < ONE_PLANE * min(b.shape.radius for b in bodies)
    if flat and one_layer:
        return 2
    if solid and (not one_layer or len(bodies) == 1):
        return 3
    raise ValueError(
        "dim: the scene is neither clearly 2D (one layer z = const, blockedDOFs including 'zXY') "
        "nor clearly 3D; give dim=2 or dim=3"
    )


def overlap_factor(bodies, overlap):
    """Common factor of the radii after the choice about overlaps.

    Args:
        bodies (list of Body): spheres; walls of the scene count as well.
        overlap (str): as for :func:`soften`.

    Returns:
        float: in (0, 1]; 1 unless with 'shrink' [-].

    Raises:
        ValueError: an unknown choice, or an overlap that it does not admit.
    """
    if overlap not in ("relax", "shrink", "refuse"):
        raise ValueError(f"overlap = {overlap!r} is unknown; known: 'relax', 'shrink', 'refuse'")
    worst, factor, pair = 0.0, 1.0, None
    for distance, reach, smaller, ids in _near_pairs(bodies):
        relative = (reach - distance) / smaller
        if relative > worst:
            worst, pair = relative, ids
        factor = min(factor, distance / reach)
    limit = {"relax": WORKABLE_OVERLAP, "shrink": 1.0, "refuse": 0.0}[overlap]
    if worst > limit:
        raise ValueError(
            f"overlap = {overlap!r}: bodies #{pair[0]} and #{pair[1]} overlap by "
            f"{100 * worst:.2g} % of the smaller radius, more than the admissible "
            f"{100 * limit:g} %; relax the rigid packing further or use overlap='shrink'"
        )
    return factor if overlap == "shrink" else 1.0


def _near_pairs(bodies):
    """Distance, sum of radii, smaller radius and ids of the pairs of spheres (and sphere-wall
    pairs) that may overlap, by sorting along x. In a periodic cell pairs at its borders may come
    twice."""
    largest = max(b.shape.radius for b in bodies)
    images = [
        (b.state.pos + Vector3(*shift), b)
        for b in bodies
        for shift in nearest_images(b.state.pos, largest)
    ]
    rows = sorted(
        ((place[0] - b.shape.radius, b.id, place, b) for place, b in images),
        key=lambda row: row[:2],
    )
    active = []
    for low, _, place, b in rows:
        active = [(x, a) for x, a in active if x[0] + a.shape.radius > low]
        for x, a in active:
            distance = (x - place).norm()
            reach = a.shape.radius + b.shape.radius
            if distance < reach:
                yield distance, reach, min(a.shape.radius, b.shape.radius), (a.id, b.id)
        active.append((place, b))
    walls = [w for w in O.bodies if w and isinstance(w.shape, wrapper.Wall)]
    for w in walls:
        for b in bodies:
            distance = abs(b.state.pos[w.shape.axis] - w.state.pos[w.shape.axis])
            if distance < b.shape.radius:
                yield distance, b.shape.radius, b.shape.radius, (w.id, b.id)


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
        ValueError: a body is neither, its out-of-plane degrees of freedom ``z``, ``X`` and ``Y``
            are not blocked, or a clump has members that overlap or differ in radius. Nothing has
            been changed then.
    """
    if ids is None:
        bodies = [b for b in O.bodies if b and (b.isClump or _is_single_sphere(b))]
    else:
        bodies = [O.bodies[i] for i in ids]
    disks = [(b, _disk_mass_and_inertia(b)) for b in bodies]
    for body, (mass, inertia) in disks:
        body.state.mass = mass
        body.state.inertia = (inertia,) * 3
    return [b.id for b in bodies]


def _is_single_sphere(body):
    return isinstance(body.shape, Sphere) and not body.isClumpMember


def _disk_mass_and_inertia(body):
    """Of a sphere or a clump of spheres, as disks per metre of thickness [kg/m, kg m]."""
    if body is None or not (body.isClump or _is_single_sphere(body)):
        raise ValueError(f"ids: body #{body and body.id} is no sphere outside clumps and no clump")
    if not set("zXY") <= set(body.state.blockedDOFs):
        raise ValueError(
            f"ids: body #{body.id} has blockedDOFs = {body.state.blockedDOFs!r}; a disk of a 2D "
            "scene has at least 'zXY'"
        )
    parts = [O.bodies[i] for i in body.shape.members] if body.isClump else [body]
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
