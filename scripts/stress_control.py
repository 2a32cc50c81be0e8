"""Stress control of walls around soft disks: how each way of it reaches the stress and holds it.

Eight disks (2D, mu = 0.3) or eight balls (3D, --dim 3) in a box are pressed to a stress on all
walls that can move. Reported for each way of control: overshoot, time to settle within 1 %, and
largest error after that, of the mean contact stress on the walls along each axis.
"""

import argparse
import json
import math

import numpy as np
from yade import (
    Box,
    ForceEngine,
    FrictMat,
    O,
    ServoPIDController,
    TriaxialStressController,
    pack,
    utils,
)

import softgrain as sg
from softgrain import command_line

RADIUS = 0.01  # m
YOUNG, POISSON, DENSITY = 1e6, 0.45, 1000.0  # Pa, -, kg/m3
FRICTION = 0.3  # between grains
SPREAD = 0.2  # of the radii of disks about their mean
TOLERATED = 0.01  # error of the stress that counts as settled


def parse_options(arguments=None):
    parser = command_line.case_parser(__doc__, out="stress_control")
    add, positive = parser.add_argument, command_line.positive
    add("--dim", type=int, choices=(2, 3), default=2, help="disks or balls")
    add("--stress", type=command_line.negative, default=-3e4, help="goal, as --stress=-3e4 [Pa]")
    add("--zeta", type=command_line.resolution, default=0.25, help="relative resolution [-]")
    add("--mass-damping", type=command_line.non_negative, default=200, help="of the grains [1/s]")
    add("--tolerance", type=positive, default=1e-2, help="of the contact sweeps [-]")
    add("--duration", type=positive, default=0.1, help="of each run [s]")
    add(
        "--ways",
        type=way,
        nargs="+",
        default=["wall:1", "wall:10", "force:1", "servo:0.1"],
        help="wall:DRAG, force:MASS, servo:GAIN, triaxial:SPEED (3D); 1 where no number is given",
    )
    options = parser.parse_args(arguments)
    if options.dim == 2 and any(kind_and_number(text)[0] == "triaxial" for text in options.ways):
        parser.error("argument --ways: triaxial needs --dim 3")
    return options


def way(text):
    """Argument type: a way of control as in the help."""
    kind, number = kind_and_number(text)
    if kind not in WAYS:
        raise argparse.ArgumentTypeError(f"{text!r} is none of {', '.join(WAYS)}")
    command_line.positive(number)
    return text


def kind_and_number(way):
    """Name of a way of control, and its number as text."""
    kind, _, number = way.partition(":")
    return kind, number or "1"


def impedance():
    """Density of the grains times the speed of pressure waves [Pa s/m]."""
    grain = sg.soft_bodies()[0]
    return grain.material.waveImpedance(grain.shape.dim)


def make_grains(options):
    """Grains in a box; returns the sides of the box [m]."""
    material = sg.SoftMat(
        young=YOUNG,
        poisson=POISSON,
        density=DENSITY,
        frictionAngle=math.atan(FRICTION),
        massDamping=options.mass_damping,
    )
    if options.dim == 3:
        for place in np.ndindex(2, 2, 2):
            center = [(2.02 * k + 1.01) * RADIUS for k in place]
            O.bodies.append(sg.soft_sphere(center, RADIUS, material, zeta=options.zeta))
        return [4.04 * RADIUS] * 3
    side = 8 * RADIUS
    cloud = pack.SpherePack()
    cloud.makeCloud((0, 0, 0), (side, side, 0), rMean=RADIUS, rRelFuzz=SPREAD, num=12, seed=1)
    for center, radius in cloud:
        O.bodies.append(sg.soft_disk(center, radius, material, zeta=options.zeta))
    return [side, side]


def make_walls(sides, boxes):
    """Ids of the walls, lower and upper one along each axis."""
    material = FrictMat(frictionAngle=0)
    if boxes:
        thick = 0.1 * RADIUS
        walls = utils.aabbWalls(
            [(0, 0, 0), tuple(sides)], thickness=2 * thick, oversizeFactor=1.5, material=material
        )
        return O.bodies.append(walls)
    return O.bodies.append(sg.walls_around([0] * len(sides), sides, material))


def press_by_controller(walls, stress, drag):
    """Softgrain's own controller."""
    goal = [stress] * (len(walls) // 2) + [0] * (3 - len(walls) // 2)
    controller = sg.WallStressController(walls=walls, goal=goal, drag=drag)
    sg.insert_before_solve(controller)


def press_by_force(walls, stress, mass):
    """Free walls under YADE's ForceEngine; returns what to do before each step."""
    sides = present_sides(walls)
    forces = []
    for axis in range(len(sides)):
        state = O.bodies[walls[2 * axis + 1]].state
        area = math.prod(sides) / sides[axis]
        state.blockedDOFs = "xyzXYZ".replace("xyz"[axis], "")
        state.mass = mass * DENSITY * area * RADIUS
        forces.append(ForceEngine(ids=[walls[2 * axis + 1]]))
    sg.insert_before_solve(*forces)

    def follow():
        for axis, (engine, area) in enumerate(zip(forces, present_areas(walls))):
            engine.force = [stress * area if k == axis else 0 for k in range(3)]

    return follow


def press_by_servo(walls, stress, gain):
    """Velocity = gain (force - target)/(rho c A); after NewtonIntegrator, for the coming step."""
    servos = []
    for axis, area in enumerate(present_areas(walls)):
        direction = [0, 0, 0]
        direction[axis] = 1
        servos.append(
            ServoPIDController(
                ids=[walls[2 * axis + 1]],
                axis=direction,
                kP=gain / (impedance() * area),
                kI=0,
                kD=0,
                iterPeriod=1,
                maxVelocity=-stress / impedance(),
            )
        )
    O.engines = list(O.engines) + servos

    def follow():
        for servo, area in zip(servos, present_areas(walls)):
            servo.target = -stress * area

    return follow


def press_by_triaxial(walls, stress, share):
    """Velocities up to that share of stress/(rho c). The damping makes the way of a step, summed
    over the steps that remember it, that which closes the gap: (1 - damping)/(1 - damping) of it.
    """
    damping = 0.8
    names = ("left", "right", "bottom", "top", "back", "front")
    controller = TriaxialStressController(
        thickness=2 * O.bodies[walls[0]].shape.extents[0],
        internalCompaction=False,
        stressMask=7,
        goal1=stress,
        goal2=stress,
        goal3=stress,
        max_vel=-share * stress / impedance(),
        stressDamping=damping,
        stiffnessUpdateInterval=10,
        **{f"wall_{name}_id": wall for name, wall in zip(names, walls)},
    )
    O.engines = list(O.engines) + [controller]


def present_sides(walls):
    """Of the space between the walls [m]."""
    sides = []
    for axis, pair in enumerate(zip(walls[::2], walls[1::2])):
        low, high = (O.bodies[w] for w in pair)
        thickness = 2 * low.shape.extents[axis] if isinstance(low.shape, Box) else 0
        sides.append(high.state.pos[axis] - low.state.pos[axis] - thickness)
    return sides


def present_areas(walls):
    """Of the walls along each axis [m², 2D m]."""
    sides = present_sides(walls)
    return [math.prod(sides) / side for side in sides]


def wall_stress(walls):
    """Mean contact stress on both walls along each axis, tension positive [Pa]."""
    return [
        (sg.wall_force(low)[axis] - sg.wall_force(high)[axis]) / (2 * area)
        for axis, (low, high, area) in enumerate(zip(walls[::2], walls[1::2], present_areas(walls)))
    ]


#: By name; each is told the walls, the stress [Pa] and its number, and returns what to do before
#: each step, if anything.
WAYS = {
    "wall": press_by_controller,
    "force": press_by_force,
    "servo": press_by_servo,
    "triaxial": press_by_triaxial,
}


def run_way(way, options):
    """Errors of the held stress over time for one way of control."""
    O.reset()
    sides = make_grains(options)
    kind, number = kind_and_number(way)
    walls = make_walls(sides, boxes=kind == "triaxial")
    O.engines = sg.engines(tolerance=options.tolerance)
    sg.set_time_step()
    follow = WAYS[kind](walls, options.stress, float(number)) or (lambda: None)
    times, stresses = [], []
    while O.time < options.duration:
        follow()
        O.step()
        times.append(O.time)
        stresses.append(wall_stress(walls))
    return np.array(times), np.array(stresses)


def summary(way, times, stresses, options):
    """Overshoot, time to settle, error at the end: of the axis where they are largest."""
    error = stresses / options.stress - 1
    off = np.nonzero(np.abs(error).max(axis=1) > TOLERATED)[0]
    settled = off[-1] + 1 if len(off) else 0
    last = times > 0.8 * options.duration
    return {
        "way": way,
        "overshoot": float(max(error.max(), 0)),
        "settled_after": float(times[settled]) if settled < len(times) else None,
        "mean_error_of_last_fifth": float(np.abs(error[last].mean(axis=0)).max()),
        "largest_error_of_last_fifth": float(np.abs(error[last]).max()),
        "overlap": sg.integrator().largestOverlap,
        "steps": O.iter,
    }


def main():
    options = parse_options()
    results = []
    for way in options.ways:
        times, stresses = run_way(way, options)
        np.savetxt(options.out / f"{way.replace(':', '-')}.txt", np.column_stack([times, stresses]))
        results.append(summary(way, times, stresses, options))
        print(json.dumps(results[-1]))
    command_line.write_result(options, {"ways": results})


if __name__ == "__main__":
    main()
