"""What grains cost that need not be computed: disks in free flight, of which a share has collided.

Run it with YADE: ``scripts/yade -n -x scripts/benchmark/inactive.py --grains 10000 --share 0.01``.
Pairs of disks that start close together collide in the first steps and vibrate from then on; all
others move rigidly. Runs with and without ``rigidMotion`` alternate; user CPU time, medians. Prints
one line of JSON.
"""

import argparse
import json
import math
import resource
import statistics

from yade import O

import softgrain as sg
from softgrain import command_line

RADIUS = 0.01  # m
LATTICE = 2.4 * RADIUS  # m, between centres
SPEED = 0.5  # m/s, of colliding grains


def parse_options(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    add = parser.add_argument
    add("--grains", type=int, default=10000, help="number of grains, at least 4 [-]")
    add("--share", type=float, default=0.01, help="of grains that collide, in [0, 1] [-]")
    add("--zeta", type=command_line.resolution, default=0.11, help="relative resolution 2 dr/D [-]")
    add("--steps", type=int, default=10, help="steps of a run, at least 1 [-]")
    add("--runs", type=int, default=3, help="runs of each kind, at least 1 [-]")
    options = parser.parse_args(arguments)
    for name, least in (("grains", 4), ("steps", 1), ("runs", 1)):
        value = getattr(options, name)
        if value < least:
            parser.error(
                f"argument --{name}: {value} is outside the admissible range [{least}, inf)"
            )
    if not 0 <= options.share <= 1:
        parser.error(f"argument --share: {options.share} is outside the admissible range [0, 1]")
    return options


def make_scene(options):
    """Pairs of disks on a square lattice; the pairs that are to collide come near each other."""
    material = sg.SoftMat(young=1e6, poisson=0.45, density=1000, frictionAngle=math.atan(0.3))
    O.materials.append(material)
    pairs = options.grains // 2
    columns = math.ceil(math.sqrt(pairs / 2))
    colliding = round(options.share * pairs)
    every = pairs / colliding if colliding else math.inf
    bodies = []
    for k in range(pairs):
        row, column = divmod(k, columns)
        collides = int(k / every) != int((k - 1) / every) if k else colliding > 0
        radius = RADIUS * (1 - 0.03 * (7 * k % 5))
        shift = 1.002 * radius if collides else LATTICE / 2
        for side in (-1, 1):
            centre = ((2 * column + 0.5) * LATTICE + side * shift, row * LATTICE, 0)
            body = sg.soft_disk(centre, radius, material, zeta=options.zeta)
            drift = 0.02 * (13 * k % 7 - 3)
            body.state.vel = (-side * SPEED if collides else drift, drift, 0)
            bodies.append(body)
    O.bodies.append(bodies)
    O.engines = sg.engines()
    sg.set_time_step()


def measure(options, rigid):
    """Seconds of user time and active grains of a step, after two that are not counted."""
    engine = sg.integrator()
    engine.rigidMotion = rigid
    O.run(2, True)
    grain_steps = engine.totalGrainSteps
    start = resource.getrusage(resource.RUSAGE_SELF).ru_utime
    O.run(options.steps, True)
    seconds = resource.getrusage(resource.RUSAGE_SELF).ru_utime - start
    return seconds / options.steps, (engine.totalGrainSteps - grain_steps) / options.steps


def main():
    options = parse_options()
    make_scene(options)
    O.run(60, True)  # the pairs have met
    runs = {True: [], False: []}
    for _ in range(options.runs):
        for rigid in runs:
            runs[rigid].append(measure(options, rigid))
    seconds = {rigid: statistics.median(s for s, _ in found) for rigid, found in runs.items()}
    print(
        json.dumps(
            {
                "grains": len(sg.soft_bodies()),
                "active_grains": runs[True][-1][1],
                "ms_per_step": 1e3 * seconds[True],
                "ms_per_step_all_active": 1e3 * seconds[False],
                "share_of_time": seconds[True] / seconds[False],
                "options": {name: str(value) for name, value in vars(options).items()},
            }
        )
    )


if __name__ == "__main__":
    main()
