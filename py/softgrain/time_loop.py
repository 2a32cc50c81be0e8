"""Engines and time step of scenes with soft grains."""

import threading
import warnings

import numpy as np
from yade import (
    Bo1_Box_Aabb,
    Bo1_Facet_Aabb,
    Bo1_Sphere_Aabb,
    Bo1_Wall_Aabb,
    Box,
    Engine,
    ForceResetter,
    Ig2_Box_Sphere_ScGeom,
    Ig2_Facet_Sphere_ScGeom,
    Ig2_Sphere_Sphere_ScGeom,
    Ig2_Wall_Sphere_ScGeom,
    InsertionSortCollider,
    InteractionLoop,
    Ip2_FrictMat_FrictMat_FrictPhys,
    Law2_ScGeom_FrictPhys_CundallStrack,
    Matrix3,
    NewtonIntegrator,
    O,
    Sphere,
    log,
    wrapper,
)

from softgrain import _softgrain, interface_laws
from softgrain.checks import finite_vector, index, made, number

#: Tag of the scene: ``O.dt`` as last set by set_time_step [s] and the fraction of the critical step
#: that it was.
_OWN_STEP = "softgrain.timeStep"
#: What rigid bodies do to each other, by the name of ``engines(rigid=)``.
_RIGID_LAWS = ("linear", "nonsmooth")
#: Radii that bounding boxes of spheres have, so that the functors "ahead" are asked in time.
_AHEAD = 1.05
#: Distance by which bounding boxes are enlarged, over the smallest radius, if nothing else is said.
_VERLET_SHARE = 0.05


def refuse_background_run(asker):
    """RuntimeError where a script changes bodies while another thread, started by ``O.run()``, is
    at them. (A PyRunner is part of the run: it is called between engines, by that thread.)"""
    if O.running and threading.current_thread() is threading.main_thread():
        raise RuntimeError(f"{asker}: O.run() is going on in the background; call O.pause() first")


def advance(steps):
    """Take steps in the calling thread, as ``O.step()`` does. ``O.run(steps, True)`` takes them in
    another one, looks every 40 ms whether that is done, and may lose an error: this is for short
    stretches. ``O.stopAtIter``, ``O.stopAtTime`` and ``O.pause()`` do not stop it.

    Args:
        steps (int): in [0, inf) [-].

    Raises:
        ValueError: ``steps`` is negative, or no whole number.
        RuntimeError: what stopped a step.
    """
    steps = index("steps", steps)
    if steps < 0:
        raise ValueError(f"steps = {steps} is outside the admissible range [0, inf)")
    for _ in range(steps):
        O.step()


def engines(
    verlet_distance=None,
    gravity=(0, 0, 0),
    label=None,
    interface=None,
    rigid="linear",
    **integrator,
):
    """Ready-made list of engines for soft grains and the rigid bodies they touch: walls, spheres,
    clumps of spheres, facets, boxes.

    It prepares the scene for the collider that it makes: bodies are read anew, and in a periodic
    cell ``O.bodies.enableRedirection`` and ``useRedirection`` are set to False, about which YADE is
    not to warn.

    Args:
        verlet_distance (float | None): ``InsertionSortCollider.verletDist``, >= 0 [m]; None: a
            twentieth of the smallest radius of the soft grains, or of the spheres if there are
            none.
        gravity (Vector3): ``NewtonIntegrator.gravity``, finite [m/s²].
        label (str | None): label of the ``SoftGrainIntegrator``.
        interface (dict | None): what surfaces do to each other by pair of materials, attributes of
            ``Ip2_SoftPhys`` (frictAngle, dynamicFrictAngle, cohesion, cohesionRange, bondStrength,
            bondEnergy, bondStiffness, bondAtTouch, restitution), each a ``MatchMaker`` or a number
            for all pairs; ``interfaceRange`` of the integrator follows from it unless it is given.
            To pairs of rigid bodies frictAngle applies, too, and with rigid = 'nonsmooth'
            restitution; the rest to pairs with a soft grain alone.
        rigid (str): how rigid bodies touch each other. 'linear': by YADE's linear law with friction
            (``Law2_ScGeom_FrictPhys_CundallStrack``), whose stiffness may ask for a smaller
            ``O.dt`` than soft grains do: assign it by hand then. 'nonsmooth': by the contact
            dynamics of soft grains, in the same solve (``Law2_ScGeom_FrictPhys_Nonsmooth``), also
            in a scene without soft grains; there ``O.dt`` is to be assigned.
        **integrator: attributes of ``SoftGrainIntegrator``.

    Returns:
        list of Engine: for ``O.engines``.

    Raises:
        ValueError: an attribute is out of its range, or a result, there is no grain and no
            verlet_distance, a wall in a periodic cell, a rigid body with a ``SoftMat``, or
            ``interface`` is no dict, or has an unknown attribute or material, one that does nothing
            without another, or numbers for all pairs that do not fit together or to the contact
            geometry of the grains.
    """
    if rigid not in _RIGID_LAWS:
        known = ", ".join(map(repr, _RIGID_LAWS))
        raise ValueError(f"rigid = {rigid!r} is unknown; known: {known}")
    nonsmooth = rigid == "nonsmooth"
    gravity = finite_vector("gravity", gravity, 3, "m/s²")
    if verlet_distance is None:
        verlet_distance = _usual_verlet_distance()
    verlet_distance = number("verlet_distance", verlet_distance, "[0, inf)", "m")
    _refuse_walls_in_a_cell()
    _refuse_soft_materials_of_rigid_bodies()
    interface = interface_laws.checked({} if interface is None else interface)
    _warn_of_pairs_without_contact()
    longest = max(interface_laws.longest_range(interface), interface_laws.longest_range_in_use())
    integrator.setdefault("interfaceRange", longest)
    if label:
        integrator["label"] = label
    fraction = automatic_fraction()
    if fraction is not None:  # what set_time_step or the integrator until now keeps, it is to keep
        integrator.setdefault("timeStepFraction", fraction)
        integrator.setdefault("dtSet", O.dt)
    solver = _integrator(integrator)
    _let_collider_find_all_bodies()
    return [
        ForceResetter(),
        # in a periodic cell the integrator refuses grains that are too big, with a message
        InsertionSortCollider(
            _bound_functors(nonsmooth),
            verletDist=verlet_distance,
            allowBiggerThanPeriod=True,
            sortAxis=_sort_axis(),
        ),
        InteractionLoop(
            _geometry_functors(nonsmooth),
            _physics_functors(interface),
            _laws(nonsmooth, interface),
        ),
        solver,
        NewtonIntegrator(damping=0, gravity=gravity, prevVelGrad=_present_velocity_gradient()),
    ]


def _integrator(attributes):
    """With these settings; ValueError for what is no attribute, of another type, or a result."""
    engine = made(wrapper.SoftGrainIntegrator, attributes)
    for name in attributes:
        try:
            setattr(engine, name, getattr(engine, name))
        except AttributeError:  # YADE's constructors set what scripts may only read
            raise ValueError(
                f"{name}: a result of SoftGrainIntegrator, which cannot be set"
            ) from None
    return engine


def insert_before_solve(*engines):
    """Put engines into ``O.engines`` right before its ``SoftGrainIntegrator``: those whose forces
    or velocities the coming solve is to see, such as ``WallStressController``,
    ``PeriTriaxController(dynCell=True)``, ``ForceEngine``.

    Args:
        *engines (Engine): in this order.

    Raises:
        ValueError: ``O.engines`` holds no ``SoftGrainIntegrator``, or an argument is no engine, or
            one that is there already, or comes twice.
    """
    present = list(O.engines)
    for k, engine in enumerate(engines):
        if not isinstance(engine, Engine):
            raise ValueError(f"engines: {engine!r} is no engine")
        if engine in present:
            raise ValueError(f"engines: {engine!r} is in O.engines already, and would act twice")
        if engine in engines[:k]:
            raise ValueError(f"engines: {engine!r} comes twice, and would act twice")
    places = [k for k, e in enumerate(present) if isinstance(e, wrapper.SoftGrainIntegrator)]
    if not places:
        raise ValueError(
            "insert_before_solve: O.engines holds no SoftGrainIntegrator; assign O.engines = "
            "sg.engines() first"
        )
    O.engines = present[: places[0]] + list(engines) + present[places[0] :]


def _present_velocity_gradient():
    """What ``NewtonIntegrator`` has given bodies of the flow of a periodic cell: one that does not
    know of it would give it once more."""
    present = [e for e in O.engines if isinstance(e, NewtonIntegrator) and not e.dead]
    return present[0].prevVelGrad if present else Matrix3.Zero


def _usual_verlet_distance():
    radii = _radii(wrapper.SoftGrain) or _radii(Sphere)
    if not radii:
        raise ValueError("verlet_distance: give it, or add soft grains or spheres first")
    return _VERLET_SHARE * min(radii)


def _refuse_soft_materials_of_rigid_bodies():
    """Where one touches a rigid body, YADE's loop ends the process before the integrator looks."""
    for body in O.bodies:
        if body and isinstance(body.material, wrapper.SoftMat):
            if body.shape and not isinstance(body.shape, wrapper.SoftGrain):
                raise ValueError(
                    f"body #{body.id} has the material SoftMat but the rigid shape "
                    f"{type(body.shape).__name__}; use sg.soften() or give it a rigid material "
                    "such as FrictMat"
                )


def _warn_of_pairs_without_contact():
    """Boxes and facets that may fall through each other, and through walls: YADE has no contact for
    them."""
    flat = [b for b in O.bodies if b and isinstance(b.shape, (Box, wrapper.Facet, wrapper.Wall))]
    wholes = [O.bodies[b.clumpId] if b.isClumpMember else b for b in flat]
    free = [
        b
        for b, whole in zip(flat, wholes)
        if whole.dynamic and not isinstance(b.shape, wrapper.Wall)
    ]
    if free and len({whole.id for whole in wholes}) > 1:
        warnings.warn(
            f"body #{free[0].id} is a {type(free[0].shape).__name__} that is free: no contact of "
            "it with other boxes, facets and walls is computed, through which it passes",
            stacklevel=3,
        )


def _refuse_walls_in_a_cell():
    walls = [b.id for b in O.bodies if b and isinstance(b.shape, wrapper.Wall)]
    if O.periodic and walls:
        raise ValueError(
            f"body #{walls[0]} is a Wall, but O.periodic = True: the collider of YADE never ends "
            "with its infinite box in a periodic cell; leave it out"
        )


def _radii(shape):
    return [b.shape.radius for b in O.bodies if b and isinstance(b.shape, shape)]


def _sort_axis():
    """Axis of the collider's first sort, which passes over partners of a floor that is longer than
    a periodic cell along it: the one along which boxes are shortest."""
    boxes = [b for b in O.bodies if b and isinstance(b.shape, Box)]
    if not (O.periodic and boxes):
        return 0
    turns = [np.abs(np.array(b.state.ori.toRotationMatrix())) for b in boxes]
    halves = [turn @ np.array(b.shape.extents) for turn, b in zip(turns, boxes)]
    return int(np.argmin(np.max(halves, axis=0) / np.array(O.cell.size)))


def _let_collider_find_all_bodies():
    """YADE's collider has another way for scenes in which bodies were erased. On that one a new
    collider knows no body until it is told, and in a periodic cell it may never end: there it is
    not to take it (which YADE would call a bug of its own in a warning)."""
    if O.periodic:
        O.bodies.enableRedirection = O.bodies.useRedirection = False
        log.setLevel("BodyContainer", log.ERROR)
    _softgrain.letColliderReadBodies()


def _bound_functors(nonsmooth):
    sphere = Bo1_Sphere_Aabb(aabbEnlargeFactor=_AHEAD) if nonsmooth else Bo1_Sphere_Aabb()
    rigid = [Bo1_Wall_Aabb(), sphere, Bo1_Facet_Aabb(), Bo1_Box_Aabb()]
    return [wrapper.Bo1_SoftGrain_Aabb()] + rigid


def _geometry_functors(nonsmooth):
    soft = [
        wrapper.Ig2_SoftGrain_SoftGrain_SoftGeom(),
        wrapper.Ig2_Wall_SoftGrain_SoftGeom(),
        wrapper.Ig2_Sphere_SoftGrain_SoftGeom(),
        wrapper.Ig2_Facet_SoftGrain_SoftGeom(),
        wrapper.Ig2_Box_SoftGrain_SoftGeom(),
    ]
    if nonsmooth:
        return soft + [
            wrapper.Ig2_Sphere_Sphere_ScGeom_Ahead(),
            wrapper.Ig2_Facet_Sphere_ScGeom_Ahead(),
            wrapper.Ig2_Box_Sphere_ScGeom_Ahead(),
            wrapper.Ig2_Wall_Sphere_ScGeom_Ahead(),
        ]
    return soft + [
        Ig2_Sphere_Sphere_ScGeom(),
        Ig2_Facet_Sphere_ScGeom(),
        Ig2_Box_Sphere_ScGeom(),
        Ig2_Wall_Sphere_ScGeom(),
    ]


def _physics_functors(interface):
    of_soft = {name: value for name, value in interface.items() if name != "restitution"}
    of_rigid = {name: value for name, value in interface.items() if name == "frictAngle"}
    return [
        wrapper.Ip2_SoftMat_SoftMat_SoftPhys(**of_soft),
        wrapper.Ip2_FrictMat_SoftMat_SoftPhys(**interface),
        Ip2_FrictMat_FrictMat_FrictPhys(**of_rigid),
    ]


def _laws(nonsmooth, interface):
    of_rigid = {name: value for name, value in interface.items() if name == "restitution"}
    return [
        wrapper.Law2_SoftGeom_SoftPhys_Nonsmooth(),
        (
            wrapper.Law2_ScGeom_FrictPhys_Nonsmooth(**of_rigid)
            if nonsmooth
            else Law2_ScGeom_FrictPhys_CundallStrack()
        ),
    ]


def chosen_fraction(name, fraction):
    """The fraction of the critical step that is meant, for None the one in use; ValueError unless
    it is in (0, 1] [-]."""
    return number(name, _fraction_in_use() if fraction is None else fraction, "(0, 1]")


def critical_time_step():
    """Critical time step of the undeformed soft grains of the scene, dt_c = 2/omega_max, less where
    they are damped [s].

    Raises:
        ValueError: the scene has no soft grain, or a body is wrong (see the message).
        RuntimeError: a run is going on in the background: grains that have changed are made anew;
            or the State of a grain is no number.
    """
    refuse_background_run("critical_time_step")
    step = _softgrain.criticalTimeStep()
    if not step > 0:
        raise ValueError("the scene has no soft grain, and so no critical time step")
    return step


def integrators():
    """Those of ``O.engines``, dead ones last; a step refuses more than one that is not."""
    found = [engine for engine in O.engines if isinstance(engine, wrapper.SoftGrainIntegrator)]
    return sorted(found, key=lambda engine: engine.dead)


def automatic_fraction():
    """Fraction of the critical step that ``O.dt`` is kept at; None where it is the user's [-]."""
    for engine in integrators():
        return engine.timeStepFraction if O.dt == engine.dtSet else None
    return _fraction_set()


def _fraction_in_use():
    """That of the integrator; while there is none what was last set, or what a new one has [-]."""
    for engine in integrators():
        return engine.timeStepFraction
    return _fraction_set() or wrapper.SoftGrainIntegrator().timeStepFraction


def _fraction_set():
    """Fraction of the critical step that set_time_step made ``O.dt``; None where it did not [-]."""
    if _OWN_STEP not in O.tags.keys():
        return None
    dt, fraction = map(float, O.tags[_OWN_STEP].split())
    return fraction if O.dt == dt else None


def set_time_step(fraction=None):
    """Set ``O.dt`` to a fraction of the critical step and let the integrator keep it there while
    the grains deform. The first step logs a warning if that is too long for rigid spheres that
    touch by YADE's linear law.

    Args:
        fraction (float | None): in (0, 1] [-]; None: the one in use, ``timeStepFraction`` of the
            ``SoftGrainIntegrator`` or what was last given here; 0.85 if there was none.

    Returns:
        float: the new ``O.dt`` [s].

    Raises:
        ValueError: the fraction is out of its range, or the scene has no soft grain.
        RuntimeError: a run is going on in the background.
    """
    refuse_background_run("set_time_step")
    fraction = chosen_fraction("fraction", fraction)
    O.dt = fraction * critical_time_step()
    O.tags[_OWN_STEP] = f"{O.dt!r} {fraction!r}"
    for engine in integrators():
        engine.timeStepFraction = fraction
        engine.dtSet = O.dt
    return O.dt
