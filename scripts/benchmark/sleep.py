"""What sleep saves in a heap at rest, and what it changes: ``yade -n -x sleep.py [OPTIONS]``.

Disks of radius 10 mm (E = 1 MPa, nu = 0.45) fall a tenth of a radius into a box and come to rest,
once with and once without ``SoftGrainIntegrator.sleep``. Printed at some times: how many grains
sleep, kinetic over elastic energy of the run without, the largest differences of centres (over the
radius), of forces on walls (over the weight of all) and of forces of pairs (over that of one
grain), and the processor time of both runs since the row before.
"""

import argparse
import math
import time

import numpy as np
from yade import FrictMat, O, utils

import softgrain as sg
from softgrain import command_line

RADIUS = 0.01  # m
YOUNG = 1e6  # Pa
DENSITY = 1000.0  # kg/m3


def make(options, sleep):
    """The scene; returns the ids of its walls."""
    O.reset()
    columns = options.columns
    material = sg.SoftMat(
        young=YOUNG,
        poisson=0.45,
        density=DENSITY,
        frictionAngle=math.atan(options.mu),
        massDamping=options.damping,
    )
    noise = np.random.default_rng(3).uniform(-0.04, 0.04, (options.grains, 2))
    for i, (dx, dy) in enumerate(noise):
        row, column = divmod(i, columns)
        x = (2.1 * column + 0.05 * (row % 2) + dx) * RADIUS
        y = (2.1 * row + 0.1 + dy) * RADIUS
        O.bodies.append(sg.soft_disk((x, y, 0), RADIUS, material, zeta=options.zeta))
    rough = FrictMat(frictionAngle=math.atan(options.mu))
    places = ((-RADIUS, 1), (-1.1 * RADIUS, 0), ((2.1 * (columns - 1) + 1.2) * RADIUS, 0))
    walls = [O.bodies.append(utils.wall(x, axis=a, material=rough)) for x, a in places]
    gravity = options.weight * YOUNG / (DENSITY * 2 * RADIUS)
    O.engines = sg.engines(gravity=(0, -gravity, 0), sleep=sleep)
    sg.set_time_step()
    return walls


def observe(walls):
    """Centres, forces on walls, forces of pairs by their ids, share of kinetic energy, sleepers."""
    bodies = sg.soft_bodies()
    energies = [body.shape.energy() for body in bodies]
    kinetic, elastic = (sum(e[name] for e in energies) for name in ("kinetic", "elastic"))
    return {
        "centres": np.array([body.state.pos for body in bodies]),
        "walls": np.array([O.forces.f(wall) for wall in walls]),
        "pairs": {
            (i.id1, i.id2): np.array(i.phys.normalForce + i.phys.shearForce) for i in O.interactions
        },
        "ratio": kinetic / elastic if elastic > 0 else math.inf,
        "asleep": sg.integrator().sleepingGrains,
    }


def run(options, sleep):
    """What is observed after each share of the time; the processor time of it."""
    walls = make(options, sleep)
    rows = []
    for k in range(options.rows):
        end, began = options.until * (k + 1) / options.rows, time.process_time()
        while O.time < end:
            O.step()
        spent = time.process_time() - began
        rows.append({"time": O.time, "seconds": spent, **observe(walls)})
    return rows


def largest(a, b):
    return max(np.linalg.norm(x - y) for x, y in zip(a, b))


def pair_difference(a, b):
    zero = np.zeros(3)
    return max(np.linalg.norm(a.get(k, zero) - b.get(k, zero)) for k in a.keys() | b.keys())


def parse_options():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    add = parser.add_argument
    add("--grains", type=command_line.whole_from(1), default=50, help="number of grains [-]")
    add(
        "--columns",
        type=command_line.whole_from(1),
        default=7,
        help="grains side by side at the start [-]",
    )
    add("--zeta", type=command_line.resolution, default=0.3, help="relative resolution 2 dr/D [-]")
    add("--weight", type=command_line.positive, default=2e-2, help="rho g D/E [-]")
    add("--damping", type=command_line.non_negative, default=2000.0, help="massDamping [1/s]")
    add("--mu", type=command_line.non_negative, default=0.5, help="coefficient of friction [-]")
    add("--until", type=command_line.positive, default=1.0, help="simulated time [s]")
    add("--rows", type=command_line.whole_from(1), default=10, help="rows to print [-]")
    return parser.parse_args()


def main():
    options = parse_options()
    with_it, without = run(options, True), run(options, False)
    one = math.pi * RADIUS**2 * options.weight * YOUNG / (2 * RADIUS)
    print(
        "time [s] | asleep | kinetic/elastic | centres/R | walls/weight | pairs | "
        "processor time with / without [s]"
    )
    for a, b in zip(with_it, without):
        differences = (
            largest(a["centres"], b["centres"]) / RADIUS,
            largest(a["walls"], b["walls"]) / (options.grains * one),
            pair_difference(a["pairs"], b["pairs"]) / one,
        )
        columns = " | ".join(f"{x:.1e}" for x in (b["ratio"], *differences))
        seconds = f"{a['seconds']:.2f} / {b['seconds']:.2f}"
        print(f"{a['time']:.3f} | {a['asleep']} | {columns} | {seconds}")


if __name__ == "__main__":
    main()
