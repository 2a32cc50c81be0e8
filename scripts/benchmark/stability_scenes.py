"""Scenes of ``stability.py``: each function makes one, runs it and returns its figures."""

import math

import numpy as np
from yade import FrictMat, O, utils

import softgrain as sg
from ripples import ripples_of_stress

RADIUS, YOUNG, DENSITY = 0.01, 1e6, 1000.0  # m, Pa, kg/m3
ZETA = 0.2  # coarse: accuracy is not the point
PAIR_MU = 0.5  # friction of two disks that are pressed on each other


def wave_speed(young=YOUNG, poisson=0.45, density=DENSITY):
    """Of pressure waves in plane strain [m/s]."""
    modulus = young * (1 - poisson) / ((1 + poisson) * (1 - 2 * poisson))
    return math.sqrt(modulus / density)


def material(mu=0.0, **attributes):
    values = {"young": YOUNG, "poisson": 0.45, "density": DENSITY, **attributes}
    return sg.SoftMat(frictionAngle=math.atan(mu), **values)


def add_disk(center, radius=RADIUS, soft=None, **shape):
    body = sg.soft_disk(center, radius, soft or material(), **{"zeta": ZETA, **shape})
    return O.bodies.append(body)


def add_wall(position, axis, sense, velocity=0.0, mu=0.0):
    wall = O.bodies.append(
        utils.wall(position, axis=axis, sense=sense, material=FrictMat(frictionAngle=math.atan(mu)))
    )
    O.bodies[wall].state.vel = [velocity if a == axis else 0 for a in range(3)]
    return wall


def prepare(fraction=0.5, **engine):
    O.trackEnergy = True
    O.engines = sg.engines(**engine)
    sg.set_time_step(fraction)


def common_figures(balance):
    engine = sg.integrator()
    return {
        "steps": engine.steps,
        "energy_error": balance.error(),
        "overlap_over_dr": engine.largestOverlap,
        "capped_share": engine.cappedSteps / max(engine.steps, 1),
        "sweeps": engine.totalSweeps / max(engine.steps, 1),
    }


def squeeze(bottom, top, speed, distance, scale):
    """Move the top wall down by `distance`; the mean force of both walls over the last quarter,
    over `scale`, their imbalance, and the common figures."""
    O.bodies[top].state.vel = (0, -speed, 0)
    sg.advance(1)
    balance = sg.Balance()
    start = O.bodies[top].state.pos[1]
    forces = []
    stride = max(5, round(distance / speed / O.dt / 500))
    while (moved := start - O.bodies[top].state.pos[1]) < distance:
        sg.advance(stride)
        balance.error()
        if moved > 0.75 * distance:
            forces.append((-O.forces.f(bottom)[1], O.forces.f(top)[1]))
    below, above = np.mean(forces, axis=0)
    return {
        "force": 0.5 * (below + above) / scale,
        "imbalance": abs(above - below) / max(abs(above + below), 1e-300),
        **common_figures(balance),
    }


def press_disk(
    poisson=0.45,
    condition="planeStrain",
    young=YOUNG,
    density=DENSITY,
    radius=RADIUS,
    speed=0.003,
    depth=0.2,
    origin=(0, 0),
    fraction=0.5,
    dt=None,
    **shape,
):
    """One disk between plates that approach by `depth` D at `speed` times its wave speed."""
    x, y = origin
    soft = material(poisson=poisson, condition=condition, young=young, density=density)
    add_disk((x, y, 0), radius, soft, **shape)
    bottom = add_wall(y - radius, 1, 1)
    top = add_wall(y + radius, 1, -1)
    prepare(fraction)
    if dt is not None:
        O.dt = dt * sg.critical_time_step()
    speed *= wave_speed(young, poisson, density)
    return squeeze(bottom, top, speed, 2 * radius * depth, 2 * young * radius)


def press_pair(radii=(RADIUS, RADIUS), materials=None, depth=0.1, speed=0.003, zetas=(ZETA, ZETA)):
    """Two disks one upon the other between plates that approach by `depth` of the smaller D. All
    have friction: without it the disks would soon slip off each other."""
    materials = materials or (material(PAIR_MU), material(PAIR_MU))
    add_disk((0, radii[0], 0), radii[0], materials[0], zeta=zetas[0])
    add_disk((0, 2 * radii[0] + radii[1], 0), radii[1], materials[1], zeta=zetas[1])
    bottom = add_wall(0, 1, 1, mu=PAIR_MU)
    top = add_wall(2 * sum(radii), 1, -1, mu=PAIR_MU)
    prepare()
    slowest = min(wave_speed(m.young, m.poisson, m.density) for m in materials)
    young = min(m.young for m in materials)
    smaller = 2 * min(radii)
    return squeeze(bottom, top, speed * slowest, depth * smaller, young * smaller)


def collide(speed, densities=(DENSITY, DENSITY)):
    """Two disks head on at `speed` times the wave speed, until they are apart again."""
    c = wave_speed()
    for x, sign, density in ((-1.02 * RADIUS, 1, densities[0]), (1.02 * RADIUS, -1, densities[1])):
        body = add_disk((x, 0, 0), soft=material(density=density))
        O.bodies[body].state.vel = (sign * 0.5 * speed * c, 0, 0)
    prepare()
    before = sum(math.pi * RADIUS**2 * d * s for d, s in zip(densities, (1, -1))) * 0.5 * speed * c
    sg.advance(1)
    balance = sg.Balance()
    end = O.time + 0.04 * RADIUS / (0.5 * speed * c) + 40 * RADIUS / wave_speed(poisson=0.3)
    while O.time < end:
        sg.advance(20)
        balance.error()
    bodies = sg.soft_bodies()
    after = sum(b.state.mass * b.state.vel[0] for b in bodies)
    unit = math.pi * RADIUS**2 * max(densities) * 0.5 * speed * c
    return {
        "momentum_error": abs(after - before) / unit,
        "restitution": (bodies[1].state.vel[0] - bodies[0].state.vel[0]) / (speed * c),
        **common_figures(balance),
    }


def compact(mu=0.3, until=0.9, per_side=3, speed=0.005, zeta=ZETA, **engine):
    """A loose square of disks of two sizes in a box whose top comes down until phi is reached."""
    soft = material(mu)
    pitch = 2.1 * RADIUS
    for k in range(per_side**2):
        i, j = k % per_side, k // per_side
        shift = 0.04 * RADIUS * math.sin(7.0 * k + 1)
        add_disk(
            ((i + 0.5) * pitch + shift, (j + 0.5) * pitch - shift, 0),
            RADIUS * (0.9 if (i + j) % 2 else 1.0),
            soft,
            zeta=zeta,
        )
    width = per_side * pitch
    add_wall(0, 0, 1), add_wall(width, 0, -1), add_wall(0, 1, 1)
    top = add_wall(width, 1, -1, -speed * wave_speed())
    prepare(**engine)
    sg.advance(1)
    balance = sg.Balance()
    phi = 0.0
    while phi < until:
        sg.advance(20 if phi < until - 0.01 else 2)
        balance.error()
        height = O.bodies[top].state.pos[1]
        phi = sg.packing_fraction(width * height)
    return {"phi": phi, "force": O.forces.f(top)[1] / width / YOUNG, **common_figures(balance)}


def ripple(fraction):
    """16 grains as fine as those of the paper's packings, compacted by a wall as fast as there."""
    figures = compact(until=0.94, per_side=4, speed=0.008, zeta=0.11, fraction=fraction)
    ripples = ripples_of_stress() / YOUNG
    return {**figures, "usual_ripple": np.median(ripples), "ripple": ripples.max()}


def rest(steps):
    """A disk in a corner with friction; gravity aslant grows slowly to 0.03 E/(rho D), then
    `steps` steps at rest. (On a plane alone it might roll, at no cost.)"""
    add_disk((RADIUS, RADIUS, 0), soft=material(0.5), zeta=0.3)
    add_wall(0, 1, 1, mu=0.5), add_wall(0, 0, 1, mu=0.5)
    prepare()
    newton = O.engines[-1]
    full = 0.03 * YOUNG / (DENSITY * 2 * RADIUS)
    ramp = 4000
    for k in range(ramp):
        g = full * 0.5 * (1 - math.cos(math.pi * (k + 1) / ramp))
        newton.gravity = (-0.5 * g, -g, 0)
        sg.advance(5)
    first = window_of_rest()
    sg.advance(max(steps - 4000, 0))
    last = window_of_rest()
    return {
        "steps": sg.integrator().steps,
        "drift_over_D": float(np.linalg.norm(last[:2] - first[:2])) / (2 * RADIUS),
        "kinetic_over_elastic": last[2] / last[3],
        "energy_growth": max(last[2] + last[3] - first[2] - first[3], 0.0) / first[3],
        "overlap_over_dr": sg.integrator().largestOverlap,
    }


def tremble(mu, damping=0.16, scatter=0.02, steps=15_000):
    """Nine disks of radii within a scatter, damped by so many c/R, squeezed by 6 % between
    frictionless walls, which stand still for so many steps then."""
    soft = material(mu, massDamping=damping * wave_speed() / RADIUS)
    random = np.random.default_rng(0)
    for k in range(9):
        place = ((2 * (k // 3) + 1) * RADIUS, (2 * (k % 3) + 1) * RADIUS, 0)
        add_disk(place, RADIUS * random.uniform(1 - scatter, 1), soft)
    balance = squeeze_and_hold(6 * RADIUS, steps)
    return {
        "tremor": sg.quasi_static()["kinetic_over_elastic"],
        **common_figures(balance),
    }


def stiff_among_soft(ratio, steps):
    """Four small disks, so many times as stiff, in the pores of nine, which all take steps of their
    own (`multirate`), with friction and little damping, squeezed and held as those of `tremble`."""
    damping = 0.027 * wave_speed() / RADIUS
    soft, stiff = (
        material(0.3, young=young, massDamping=damping) for young in (YOUNG, ratio * YOUNG)
    )
    pitch = 2.01 * RADIUS
    for k in range(9):
        add_disk((RADIUS + k // 3 * pitch, RADIUS + k % 3 * pitch, 0), soft=soft)
    for k in range(4):
        place = ((k // 2 + 1) * pitch, (k % 2 + 1) * pitch, 0)
        add_disk(place, 0.35 * RADIUS, stiff)
    balance = squeeze_and_hold(6.02 * RADIUS, steps, multirate=True)
    return {
        "kinetic_over_elastic": sg.quasi_static()["kinetic_over_elastic"],
        **common_figures(balance),
    }


def squeeze_and_hold(side, steps, **engine):
    """Four frictionless walls about disks, of which two close by 6 % and then stand still for so
    many steps; the balance of that time."""
    speed = 0.016 * wave_speed()
    add_wall(0, 0, 1), add_wall(0, 1, 1)
    walls = [add_wall(side, axis, -1, -speed) for axis in (0, 1)]
    prepare(fraction=0.85, **engine)
    sg.advance(math.ceil(0.06 * side / speed / O.dt))
    balance = sg.Balance()
    for wall in walls:
        O.bodies[wall].state.vel = (0, 0, 0)
    sg.advance(steps)
    return balance


def window_of_rest():
    """Mean position, kinetic and elastic energy over 2000 steps, some hundred vibrations."""
    rows = []
    for _ in range(200):
        sg.advance(10)
        x, y, _ = sg.soft_bodies()[0].state.pos
        energy = sg.integrator().energy()
        rows.append((x, y, energy["kinetic"], energy["elastic"]))
    return np.mean(rows, axis=0)
