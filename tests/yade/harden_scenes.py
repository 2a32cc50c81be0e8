"""Scenes in which soft grains turn rigid."""

import numpy as np
from scenes import RADIUS, YOUNG, add_wall
from yade import FrictMat, O

import softgrain as sg

PLACES = [(x * RADIUS, y * RADIUS, 0) for x in (1, 3) for y in (1, 3)]


def rigid_material(young=YOUNG / RADIUS):
    return FrictMat(young=young, poisson=0.3, frictionAngle=0.3, density=1000)


def box():
    return [add_wall(4 * RADIUS * (k % 2), axis=k // 2) for k in range(4)]


def inertia_in_space(body):
    turn = np.array(body.state.ori.toRotationMatrix())
    return turn @ np.diag(body.state.inertia) @ turn.T


def momenta_of(mass, position, velocity, inertia, spin):
    linear = mass * np.array(velocity)
    return linear, np.cross(position, linear) + inertia @ np.array(spin)


def all_momenta():
    """Of all free bodies, with tensors of inertia."""
    total = np.zeros((2, 3))
    for b in O.bodies:
        if not b or b.isClumpMember or b.state.mass == 0:
            continue
        soft = isinstance(b.shape, sg.SoftGrain)
        inertia = np.array(b.shape.inertia()) if soft else inertia_in_space(b)
        total += momenta_of(b.state.mass, b.state.pos, b.state.vel, inertia, b.state.angVel)
    return total
