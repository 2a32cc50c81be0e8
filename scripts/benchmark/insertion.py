"""What it costs to add a grain to a packing and to take it away, against a step without.

Run it with YADE: ``scripts/yade -n -x scripts/benchmark/insertion.py --grains 400``. Touching disks
on a square lattice; CPU time of this process, medians over a few insertions and erasures far from
the packing.
"""

import argparse
import math
import statistics
import time

import numpy as np
from yade import O

import softgrain as sg
from softgrain import command_line

RADIUS = 0.01  # m
REPEATS = 5


def parse_options(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    add = parser.add_argument
    add("--grains", type=command_line.whole_from(1), default=400, help="number of disks")
    add("--zeta", type=command_line.resolution, default=0.25, help="relative resolution 2 dr/D [-]")
    add("--mass-damping", type=command_line.non_negative, default=0.0, help="of the grains [1/s]")
    return parser.parse_args(arguments)


def make_packing(options):
    """Disks of nearly one size that overlap by a little; returns their material."""
    material = sg.SoftMat(
        young=1e6,
        poisson=0.45,
        density=1000,
        frictionAngle=0.3,
        massDamping=options.mass_damping,
    )
    random = np.random.default_rng(1)
    across = math.ceil(math.sqrt(options.grains))
    for k in range(options.grains):
        place = 1.996 * RADIUS * np.array([k % across, k // across])
        radius = RADIUS * (1 - random.uniform(1e-4, 1.5e-4))
        O.bodies.append(sg.soft_disk((*place, 0), radius, material, zeta=options.zeta))
    O.engines = sg.engines()
    sg.set_time_step(0.5)
    return material


def step_time():
    """CPU time of a step [ms]."""
    start = time.process_time()
    O.step()
    return 1e3 * (time.process_time() - start)


def main():
    options = parse_options()
    material = make_packing(options)
    sg.advance(5)
    plain = [step_time() for _ in range(2 * REPEATS)]
    inserted, erased = [], []
    for k in range(REPEATS):
        place = (-(5 + 3 * k) * RADIUS, 0, 0)
        O.bodies.append(sg.soft_disk(place, RADIUS, material, zeta=options.zeta))
        inserted.append(step_time())
        O.step()
    for k in range(REPEATS):
        O.bodies.erase(options.grains + k)
        erased.append(step_time())
        O.step()
    times = {"step": plain, "with an insertion": inserted, "with an erasure": erased}
    print(f"{options.grains} disks, {sg.integrator().contacts} contacts, CPU time:")
    for name, values in times.items():
        print(f"  {name}: {statistics.median(values):.1f} ms")


if __name__ == "__main__":
    main()
