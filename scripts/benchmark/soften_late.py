"""Spheres turned soft when they first bear load, against all at once: the paper's compaction.

Run it with YADE: ``scripts/yade -n -x scripts/benchmark/soften_late.py``. A packing is compacted
once with soft disks from the start, then with disks that are rigid until they bear load (--loads).
The table has the work, the user CPU time and the mean stress on the bottom wall in windows of phi0
(areas of the undeformed disks over that of the box).
"""

import argparse
import math
import resource
import sys
from pathlib import Path

import numpy as np
from yade import FrictMat, O, Sphere

import softgrain as sg
from softgrain import command_line

sys.path.append(str(Path(sys.argv[0]).resolve().parents[1]))  # scripts/
import compaction  # noqa: E402

WINDOWS = (0.72, 0.76, 0.80, 0.84, 0.88, 0.92, 0.95, 0.98)


def parse_options(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    add, positive = parser.add_argument, command_line.positive
    some = command_line.whole_from(compaction.FEWEST_GRAINS)
    add("--grains", type=some, default=100, help="number of grains [-]")
    add("--zeta", type=command_line.resolution, default=0.2, help="relative resolution 2 dr/D [-]")
    add("--mu", type=command_line.non_negative, default=0.3, help="friction between grains [-]")
    add("--speed", type=positive, default=0.5, help="of the top wall [m/s]")
    add("--loads", type=positive, nargs="*", default=[1e-4, 1e-3, 1e-2], help="over E D [-]")
    return parser.parse_args(arguments)


def make_late(options, soft, load):
    """Rigid disks with the friction of the soft ones, to be turned; Newton's damping is off."""
    rigid = FrictMat(
        young=1e8, poisson=0.3, density=compaction.DENSITY, frictionAngle=math.atan(options.mu)
    )
    spheres = [b for b in O.bodies if isinstance(b.shape, Sphere)]
    for body in spheres:
        body.material = rigid
        body.state.vel = body.state.angVel = (0, 0, 0)
    O.engines = sg.engines(verlet_distance=0.05 * compaction.MEAN_RADIUS)
    sg.soften(material=soft, zeta=options.zeta, when="loaded", load=load)


def compact(options, load):
    """One run; returns the mean stress in each window over E, work and time."""
    O.reset()
    box = compaction.prepare_rigid(rigid_options(options))
    solid = sum(math.pi * b.shape.radius**2 for b in O.bodies if hasattr(b.shape, "radius"))
    soft = sg.SoftMat(
        young=compaction.YOUNG,
        poisson=0.45,
        density=compaction.DENSITY,
        frictionAngle=math.atan(options.mu),
    )
    if load is None:
        O.engines = []
        sg.soften(material=soft, zeta=options.zeta)
        O.engines = sg.engines()
    else:
        make_late(options, soft, load)
    box.close(options.speed)
    started, stress, first = resource.getrusage(resource.RUSAGE_SELF).ru_utime, [], None
    for low, high in zip(WINDOWS, WINDOWS[1:]):
        while solid / box.area < low:
            O.step()
        force = time = 0.0
        while solid / box.area < high:
            O.step()
            force -= O.forces.f(box.bottom)[1] * O.dt
            time += O.dt
        stress.append(force / time / box.width / compaction.YOUNG)
        if first is None:
            first = len(sg.soft_bodies())
    integrator = sg.integrator()
    return {
        "stress": stress,
        "points": integrator.pointsUpdated,
        "seconds": resource.getrusage(resource.RUSAGE_SELF).ru_utime - started,
        "soft_at_first": first,
        "soft_at_end": len(sg.soft_bodies()),
    }


def rigid_options(options):
    return argparse.Namespace(grains=options.grains, seed=1)


def main():
    options = parse_options()
    for load in (None, *options.loads):
        result = compact(options, load)
        stress = " ".join(f"{s:.5f}" for s in np.array(result["stress"]))
        print(
            f"{'at once' if load is None else f'load {load:g}'}: points {result['points']:.4g}, "
            f"CPU {result['seconds']:.1f} s, soft {result['soft_at_first']} at {WINDOWS[1]}, "
            f"{result['soft_at_end']} at the end, stress/E {stress}",
            flush=True,
        )


if __name__ == "__main__":
    main()
