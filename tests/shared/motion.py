"""Momenta and energy of bodies, by default of all that have a mass; a clump counts, not its
members."""

import numpy as np
from yade import O

import softgrain as sg


def moving(bodies):
    bodies = O.bodies if bodies is None else bodies
    return [b for b in bodies if not b.isClumpMember and b.state.mass > 0]


def momentum(bodies=None):
    return sum(b.state.mass * np.array(b.state.vel) for b in moving(bodies))


def inertia_of(body):
    """In axes of space; of a soft grain as it is deformed."""
    if isinstance(body.shape, sg.SoftGrain):
        return np.array(body.shape.inertia())
    axes = np.array(body.state.ori.toRotationMatrix())
    return axes @ np.diag(body.state.inertia) @ axes.T


def angular_momentum(bodies=None):
    """About the origin."""
    return sum(
        np.cross(b.state.pos, b.state.mass * np.array(b.state.vel))
        + inertia_of(b) @ np.array(b.state.angVel)
        for b in moving(bodies)
    )


def momenta(bodies=None):
    """Linear and angular, shape (2, 3)."""
    return np.array([momentum(bodies), angular_momentum(bodies)])


def kinetic_energy(bodies=None):
    """As of rigid bodies [J, in 2D J/m]."""
    total = 0.0
    for b in moving(bodies):
        spin = np.array(b.state.angVel)
        total += (b.state.mass * b.state.vel.squaredNorm() + spin @ inertia_of(b) @ spin) / 2
    return total
