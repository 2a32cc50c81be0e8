"""One model of ``models.py`` on one problem: ``yade -n -x run.py MODEL PROBLEM --result FILE``."""

import argparse
import math
import sys
import time
from pathlib import Path

import numpy as np
from yade import O, Sphere

import softgrain as sg
from softgrain import command_line

SCRIPTS = Path(sys.argv[0]).resolve().parents[1]
sys.path[:0] = [str(SCRIPTS)]

import compaction  # noqa: E402
from rigid_and_soft.models import MODELS, YOUNG  # noqa: E402
from rigid_and_soft.options import add_case_options, check_case_options  # noqa: E402

DIAMETER = 0.02  # m, of the grain in the cell
CELL_SPEED = 0.01  # m/s, of each wall of the cell
CELL_END = 0.06  # displacement of each wall of the cell over D
PACKING_SPEED = 0.5  # m/s, of the top wall: the paper's
RECORDS = 100  # of a run


def parse_options():
    parser = argparse.ArgumentParser(description=__doc__)
    add = parser.add_argument
    add("model", choices=MODELS)
    add("problem", choices=PROBLEMS)
    add("--result", type=Path, required=True, help="JSON file to write")
    add_case_options(parser)
    options = parser.parse_args()
    check_case_options(parser, options)
    return options


class Box:
    """Walls at the sides of a box; they move at constant speeds."""

    def __init__(self, low, high, material):
        O.materials.append(material)
        self.walls = O.bodies.append(sg.walls_around(low, high, material))

    def move(self, velocities):
        """Velocities of left, right, bottom, top along their axes [m/s]."""
        for k, (wall, velocity) in enumerate(zip(self.walls, velocities)):
            O.bodies[wall].state.vel[k // 2] = velocity

    def sides(self):
        left, right, bottom, top = [
            O.bodies[wall].state.pos[k // 2] for k, wall in enumerate(self.walls)
        ]
        return right - left, top - bottom

    def forces(self):
        """Of the grains on the walls, outwards [N, of soft grains N/m]."""
        return np.array(
            [(-1, 1)[k % 2] * O.forces.f(wall)[k // 2] for k, wall in enumerate(self.walls)]
        )


def window(box, reached):
    """Step, once at least, until ``reached()``; mean forces."""
    total, steps = np.zeros(4), 0
    while steps == 0 or not reached():
        O.step()
        total += box.forces()
        steps += 1
    return total / steps


def cell(model, options):
    """One grain in a square box whose sides all move in."""
    if not model.deforms:
        return {"displacement": [], "force": []}
    radius = DIAMETER / 2
    model.add([(0, 0)], [radius])
    box = Box((-radius, -radius), (radius, radius), model.wall_material())
    model.start()
    box.move([CELL_SPEED, -CELL_SPEED, CELL_SPEED, -CELL_SPEED])

    def displacement():
        return 0.5 * (1 - box.sides()[0] / DIAMETER)

    rows = []
    for k in range(RECORDS):
        before = displacement()
        force = window(box, lambda: displacement() >= CELL_END * (k + 1) / RECORDS).mean()
        middle = 0.5 * (before + displacement())
        rows.append((middle, force / (model.thickness * YOUNG * DIAMETER)))
    shift, force = np.array(rows).T
    return {"displacement": shift.tolist(), "force": force.tolist()}


def prepared(options):
    """Loose packing by rigid DEM: centres, radii and box sides, the same for all models."""
    case = compaction.parse_options(
        [f"--grains={options.grains}", f"--mu={options.mu}", f"--out={options.result.parent}"]
    )
    box = compaction.prepare_rigid(case)
    spheres = [b for b in O.bodies if isinstance(b.shape, Sphere)]
    centres = [tuple(b.state.pos)[:2] for b in spheres]
    radii = [b.shape.radius for b in spheres]
    sides = box.width, box.height
    O.reset()
    return centres, radii, sides


def packing(model, options):
    """Uniaxial compaction of the packing from below jamming."""
    centres, radii, (width, height) = prepared(options)
    solid = math.pi * float(np.sum(np.square(radii)))
    model.add(centres, radii)
    box = Box((0, 0), (width, height), model.wall_material())
    model.start()
    box.move([0, 0, 0, -PACKING_SPEED])

    def phi():
        sides = box.sides()
        return solid / (sides[0] * sides[1])

    start = phi()
    columns = {"phi0": [], "stress": [], "coordination": []}
    for k in range(RECORDS):
        end = start + (options.until_phi - start) * (k + 1) / RECORDS
        try:
            force = window(box, lambda: phi() >= end)
        except RuntimeError:
            if model.deforms:
                raise
            break  # jammed: the walls press the grains into each other
        columns["phi0"].append(phi())
        columns["stress"].append(force[2] / (model.thickness * YOUNG * width))
        columns["coordination"].append(model.coordination())
    return columns


PROBLEMS = {"cell": cell, "packing": packing}


def main():
    options = parse_options()
    mu = options.mu if options.problem == "packing" else 0.0
    model = MODELS[options.model](mu, options.poisson)
    started = time.time()
    columns = PROBLEMS[options.problem](model, options)
    facts = {"wall_seconds": time.time() - started, "steps": O.iter, "parts": model.parts}
    command_line.write_json(options.result, {**columns, **facts})


if __name__ == "__main__":
    main()
