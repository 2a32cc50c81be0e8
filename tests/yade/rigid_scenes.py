"""Scenes of rigid bodies in contact dynamics."""

import math

import numpy as np
from scenes import RADIUS, add, add_wall
from yade import FrictMat, O, utils

import softgrain as sg

R = RADIUS
GRAVITY = 10.0


def material(friction=0.3, density=2000.0):
    return FrictMat(young=1e7, poisson=0.3, density=density, frictionAngle=math.atan(friction))


def add_sphere(centre, radius=R, friction=0.3, velocity=(0, 0, 0), blocked=""):
    body = utils.sphere(centre, radius, material=material(friction))
    body.state.blockedDOFs, body.state.vel = blocked, velocity
    return add(body)


def start(dt, gravity=(0, 0, -GRAVITY), **options):
    O.engines = sg.engines(gravity=gravity, rigid="nonsmooth", **options)
    O.dt = dt


def run_until(time):
    while O.time < time - 0.5 * O.dt:
        O.step()


def spheres():
    return [b for b in O.bodies if type(b.shape).__name__ == "Sphere"]


def add_incline(angle):
    """A floor and the gravity that makes it an incline [deg] towards x."""
    add_wall(0, 2, friction=0.5)
    return (GRAVITY * math.sin(math.radians(angle)), 0, -GRAVITY * math.cos(math.radians(angle)))


def pile(dim=3, columns=4, layers=3, **options):
    """Spheres dropped into a box, a little out of order."""
    random = np.random.default_rng(3)
    up, side = dim - 1, 2.2 * R * columns
    for axis in range(dim - 1):
        add_wall(0, axis, friction=0.4)
        add_wall(side, axis, friction=0.4)
    add_wall(0, up, friction=0.4)
    shape = [columns] * (dim - 1) + [layers]
    for place in np.ndindex(*shape):
        centre = np.zeros(3)
        centre[:dim] = (np.array(place) + 0.5) * 2.2 * R + 0.1 * R * random.uniform(-1, 1, dim)
        blocked = "zXY" if dim == 2 else ""
        add_sphere(tuple(centre), R * random.uniform(0.8, 1), 0.4, blocked=blocked)
    gravity = [0, 0, 0]
    gravity[up] = -GRAVITY
    start(2e-4, gravity, **options)


def state():
    return np.array([[*b.state.pos, *b.state.vel, *b.state.angVel] for b in spheres()])
