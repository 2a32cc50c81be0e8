"""How far from quasi-static loading is, measured: speed of walls, damping, mass scaling.

Run it with YADE: ``scripts/yade -n -x scripts/benchmark/quasi_static.py --out DIR``. Two scenes: a
disk between plates, and the compaction of ``scripts/compaction.py`` with few coarse grains. Prints
tables, which also go to ``DIR/quasi_static.md``; what they say:
``doc/decisions/0016-quasi-static.md``.
"""

import itertools
import math
import sys
from pathlib import Path

import numpy as np
from yade import FrictMat, O, utils

import softgrain as sg
from softgrain import command_line
from softgrain.runs import markdown_table

sys.path.append(str(Path(sys.argv[0]).resolve().parents[1]))  # scripts/
import compaction  # noqa: E402

YOUNG, POISSON, DENSITY, RADIUS = 1e6, 0.45, 1000.0, 0.01  # Pa, -, kg/m3, m
WAVE_MODULUS = YOUNG * (1 - POISSON) / ((1 + POISSON) * (1 - 2 * POISSON))  # Pa
IMPEDANCE = math.sqrt(DENSITY * WAVE_MODULUS)  # rho c [Pa s/m]
APPROACH = (0.1, 0.2)  # of the plates, over the diameter
PHI = (0.84, 0.88, 0.92)
WINDOW = 0.005  # of phi on both sides, over which records are averaged


def squeeze(speed, zeta, **material):
    """Mean force at both plates over E D from each approach to 1.1 of it, and energy ratio."""
    O.reset()
    soft = sg.SoftMat(young=YOUNG, poisson=POISSON, density=DENSITY, **material)
    O.bodies.append(sg.soft_disk((0, 0, 0), RADIUS, soft, zeta=zeta))
    plates = [
        utils.wall(y, axis=1, sense=s, material=FrictMat(frictionAngle=0))
        for y, s in ((-RADIUS, 1), (RADIUS, -1))
    ]
    bottom, top = O.bodies.append(plates)
    O.engines = sg.engines()
    sg.set_time_step()
    O.bodies[top].state.vel = (0, -speed, 0)
    rows = []
    for approach in APPROACH:
        forces, ratios = [], []
        while (gone := (RADIUS - O.bodies[top].state.pos[1]) / (2 * RADIUS)) < 1.1 * approach:
            O.step()
            if gone > approach:
                forces.append([sg.wall_force(top)[1], -sg.wall_force(bottom)[1]])
                ratios.append(sg.quasi_static()["kinetic_over_elastic"])
        force = np.mean(forces, axis=0) / (YOUNG * 2 * RADIUS)
        rows.append((force, np.mean(ratios)))
    return rows


def compact(out, speed, grains, zeta, scaling=1, **material):
    """Stress over E at bottom and top, energy ratio and unbalanced force at each phi; steps; time
    of forces and velocities in a step [s]."""
    O.reset()
    options = compaction.parse_options(
        [
            *("--grains", str(grains), "--zeta", str(zeta), "--speed", str(speed)),
            *("--until-phi", str(PHI[-1]), "--out", str(out / "compaction")),
        ]
    )
    box = compaction.prepare_rigid(options)
    compaction.make_soft(options)
    for name, value in material.items():
        setattr(O.materials["grains"], name, value)
    sg.scale_mass(scaling)
    O.timingEnabled = True
    sg.reset_times()
    recorder, _ = compaction.compact(options, box)
    records = {name: np.array(values, float) for name, values in recorder.records.items()}
    names = ("stress_over_E", "stress_top_over_E", "kinetic_over_elastic", "unbalanced_force")
    rows = []
    for phi in PHI:
        near = np.abs(records["phi"] - phi) <= WINDOW
        rows.append([records[name][near].mean() for name in names])
    times = sg.phase_times()
    steps = int(sg.integrator().steps)
    bulk = sum(times[phase][0] for phase in ("updateForces", "predictVelocities")) / steps
    O.timingEnabled = False
    return rows, steps, bulk


def table(title, head, rows):
    return f"### {title}\n\n{markdown_table(head, rows)}\n"


def speeds_of_plates(zeta):
    """Share: rho c v over F/D of the slow run."""
    slow = squeeze(0.005, zeta, massDamping=2000)
    rows = []
    for speed, alpha in itertools.product((0.02, 0.1, 0.5, 2.0), (0, 2000)):
        found = squeeze(speed, zeta, massDamping=alpha)
        for approach, (force, ratio), (exact, _) in zip(APPROACH, found, slow):
            share = IMPEDANCE * speed / (YOUNG * exact.mean())
            errors = [f"{100 * e:.2g} %" for e in force / exact.mean() - 1]
            rows.append((speed, alpha, approach, f"{share:.2g}", *errors, f"{ratio:.2g}"))
    head = (
        "v [m/s]",
        "alpha [1/s]",
        "delta/D",
        "share",
        "error top",
        "error bottom",
        "kinetic/elastic",
    )
    return table("A disk between plates", head, rows)


def compactions(out, grains, zeta):
    runs = [
        ("v = 0.5", {"speed": 0.5}),
        ("v = 0.125", {"speed": 0.125}),
        ("v = 0.03", {"speed": 0.03}),
        ("v = 0.03, alpha = 2000/s", {"speed": 0.03, "massDamping": 2000}),
        ("v = 0.125, alpha = 200/s", {"speed": 0.125, "massDamping": 200}),
        ("v = 0.125, alpha = 2000/s", {"speed": 0.125, "massDamping": 2000}),
        ("v = 0.125, beta = 1e-5 s", {"speed": 0.125, "stiffnessDamping": 1e-5}),
        ("v = 0.125, mass x 16", {"speed": 0.125, "scaling": 16}),
    ]
    rows = []
    for name, choices in runs:
        records, steps, bulk = compact(out, grains=grains, zeta=zeta, **choices)
        root = math.sqrt(choices.get("scaling", 1))
        for phi, (bottom, top, ratio, unbalanced) in zip(PHI, records):
            share = root * IMPEDANCE * choices["speed"] / (YOUNG * max(bottom, top))
            figures = (bottom, top, share, ratio, unbalanced)
            rows.append(
                (name, phi, *(f"{figure:.2g}" for figure in figures), steps, f"{1e6 * bulk:.0f}")
            )
    head = (
        "run",
        "phi",
        "bottom/E",
        "top/E",
        "share",
        "kinetic/elastic",
        "unbalanced",
        "steps",
        "bulk [us]",
    )
    return table(f"Compaction of {grains} grains, mu = 0.3", head, rows)


def parse_options(arguments=None):
    parser = command_line.case_parser(__doc__, out="quasi_static")
    add = parser.add_argument
    some = command_line.whole_from(compaction.FEWEST_GRAINS)
    add("--grains", type=some, default=30, help="of the compaction [-]")
    add("--zeta", type=command_line.resolution, default=0.25, help="relative resolution [-]")
    return parser.parse_args(arguments)


def main():
    options = parse_options()
    with open(options.out / "quasi_static.md", "w") as file:
        for text in (
            speeds_of_plates(options.zeta),
            compactions(options.out, options.grains, options.zeta),
        ):
            print(text, flush=True)
            file.write(text + "\n")


if __name__ == "__main__":
    main()
