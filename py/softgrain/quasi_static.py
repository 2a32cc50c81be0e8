"""Quasi-static loading: how far from it a scene is, how fast a wall may move, mass scaling.

Formulas: ``doc/theory.md``, section 3; measured: ``doc/decisions/0016-quasi-static.md``.
"""

import math
import warnings
from collections.abc import Iterable

import numpy as np
from yade import Material, NewtonIntegrator, NormShearPhys, O, Vector3, wrapper

from softgrain import _softgrain, time_loop
from softgrain.bodies import (
    has_own_motion,
    is_soft,
    material_of,
    some_soft_bodies,
    unscaled_mass,
)
from softgrain.checks import number
from softgrain.materials import found_material

#: Grains whose kinetic energy is below this share of the elastic one count as at rest.
AT_REST = 1e-3


def quasi_static():
    """How far the soft grains of the scene are from equilibrium, after the last step.

    Returns:
        dict: *kinetic*, of all soft grains at the end of the last step, and *elastic*, at its
        beginning, when forces were computed [J, 2D J/m];
        *kinetic_over_elastic* [-], inf where nothing is deformed but something moves;
        *unbalanced_force* [-], see :func:`unbalanced_force`. Both ratios are 0 where there is
        neither motion nor force.

    Raises:
        ValueError: the scene has no soft grain.
    """
    bodies = some_soft_bodies("quasi_static")
    energies = [body.shape.energy() for body in bodies]
    kinetic = sum(energy["kinetic"] for energy in energies)
    elastic = sum(energy["elastic"] for energy in energies)
    return {
        "kinetic": kinetic,
        "elastic": elastic,
        "kinetic_over_elastic": _ratio(kinetic, elastic),
        "unbalanced_force": unbalanced_force(),
    }


def unbalanced_force(largest=False):
    """Mean magnitude of the sum of forces (contacts, ``O.forces``, weight) on all soft grains and
    free rigid bodies (along the axes that are not blocked) over the mean magnitude of the contact
    forces that are not zero, after the last step, as ``utils.unbalancedForce`` has it for rigid
    bodies.

    Args:
        largest (bool): the largest sum of forces on a body in place of their mean.

    Returns:
        float: 0 without any force, inf where something is accelerated without any contact, nan
        where the forces of the last step are not there: before the first step and between
        ``ForceResetter`` and ``SoftGrainIntegrator`` (an engine put in by
        ``sg.insert_before_solve``) [-].
    """
    phys = [i.phys for i in O.interactions if i.isReal and isinstance(i.phys, NormShearPhys)]
    forces = [(p.normalForce + p.shearForce).norm() for p in phys]
    carried = _mean([force for force in forces if force > 0])
    net = _net_forces([b for b in O.bodies if b and has_own_motion(b)])
    if not _softgrain.hasForcesOfLastStep():
        return math.nan
    return _ratio(max(net, default=0.0) if largest else _mean(net), carried)


def _ratio(numerator, denominator):
    if denominator > 0:
        return numerator / denominator
    return math.inf if numerator > 0 else 0.0


def _net_forces(bodies):
    gravity = next(
        (e.gravity for e in O.engines if isinstance(e, NewtonIntegrator) and not e.dead), Vector3()
    )
    sums = [_free_part(b, O.forces.f(b.id) + gravity * _weighed_mass(b)) for b in bodies]
    return [force.norm() for force in sums]


def _free_part(body, force):
    """Without what those who hold a body bear, and what acts across the plane of a 2D grain."""
    if is_soft(body):
        return force if body.shape.dim == 3 else Vector3(force[0], force[1], 0)
    blocked = body.state.blockedDOFs
    return Vector3(*(0 if axis in blocked else f for axis, f in zip("xyz", force)))


def _weighed_mass(body):
    """As gravity has it: mass scaling makes no weight."""
    if is_soft(body):
        return unscaled_mass(body)
    return body.state.mass


def _mean(values):
    """0 of none; the same whatever the order, which in O.interactions depends on threads."""
    return math.fsum(values) / len(values) if values else 0.0


def suggest_speed(stress=None, share=0.1):
    """Speed of a wall at which inertia stays below a share of the stress.

    A wall that moves at ``v`` sends waves of the stress ``rho c v`` into the grains it touches,
    with ``c`` the speed of pressure waves, and what moves at ``v`` has at most
    ``(rho c v/stress)²`` times the elastic energy of a body under the uniaxial ``stress``. So
    ``v = share stress/(rho c)``: force errors then stay below ``share`` (measured: mostly far
    below), and the kinetic energy of the imposed motion below ``share²`` of the elastic one, once
    the stress is reached. Vibrations that contacts excite come on top and stay, however slowly the
    wall moves, unless they are damped (``SoftMat.massDamping``). The grain with the largest
    ``rho c`` counts, mass scaling included; free rigid bodies do not, and heavy ones among the
    grains need more time.

    Args:
        stress (float | None): mean stress on the wall from which results are to hold, > 0 [Pa];
            None: a hundredth of the smallest Young's modulus of the soft grains.
        share (float): in (0, 1] [-].

    Returns:
        float: [m/s].

    Raises:
        ValueError: a value is out of its range, or the scene has no soft grain, or one whose
            material is no ``SoftMat``.
    """
    bodies = some_soft_bodies("suggest_speed")
    if stress is None:
        stress = 0.01 * min(material_of(body).young for body in bodies)
    stress = number("stress", stress, "(0, inf)", "Pa")
    share = number("share", share, "(0, 1]")
    return share * stress / max(material_of(b).waveImpedance(b.shape.dim) for b in bodies)


def scale_mass(factor, materials=None):
    """Make soft grains more inert, so that the critical time step grows by sqrt(factor).

    Sets ``SoftMat.massScaling``. Weight (gravity), forces, elasticity and statics stay as they are;
    accelerations and wave speeds fall, so walls must move more slowly by sqrt(factor) for the same
    inertial share (:func:`suggest_speed`). Scaling all grains alike therefore saves nothing over a
    faster wall; scaling the material of the few grains that dictate the step (small, stiff) does.

    ``O.dt`` follows at once where it is kept by the integrator; an ``O.dt`` of the user's stays.

    Args:
        factor (float): on the true density, in [1, inf) [-]; 1 takes the scaling back.
        materials (SoftMat | int | str | list of these | None): a material, or its index or label in
            ``O.materials``; None: those of all soft grains of the scene.

    Returns:
        float: the new critical time step of the undeformed grains [s].

    Raises:
        ValueError: the factor is out of its range, there is no material or one that is no
            ``SoftMat``, or the scene has no soft grain. Nothing has been changed then.
        RuntimeError: a run is going on in the background. Nothing has been changed then.

    Warns:
        UserWarning: the grains move: their velocities stay, so that their momentum and kinetic
            energy jump with their mass.
    """
    time_loop.refuse_background_run("scale_mass")
    bodies = some_soft_bodies("scale_mass")
    factor = number("factor", factor, "[1, inf)")
    if materials is None:
        materials = [material_of(b) for b in bodies]
    elif isinstance(materials, (Material, int, str, np.integer)):
        materials = [materials]
    given = materials
    materials = list(map(found_material, given)) if isinstance(given, Iterable) else []
    if not materials:
        raise ValueError(f"materials = {given}: admissible are SoftMats, one or more, or None")
    for material in materials:
        if not isinstance(material, wrapper.SoftMat):
            raise ValueError(f"materials: {type(material).__name__} is no SoftMat")
    changed = any(material.massScaling != factor for material in materials)
    if changed and quasi_static()["kinetic_over_elastic"] > AT_REST:
        warnings.warn(
            "scale_mass: the grains are not at rest; their momentum and kinetic energy change with "
            "their mass. Scale before they move, or where sg.quasi_static() is small",
            stacklevel=2,
        )
    automatic = time_loop.automatic_fraction()
    before = [material.massScaling for material in materials]
    try:
        for material in materials:
            material.massScaling = factor
        if automatic is not None:
            time_loop.set_time_step(automatic)
        return time_loop.critical_time_step()
    except Exception:
        for material, scaling in zip(materials, before):
            material.massScaling = scaling
        raise
