"""Soft grains from a labelled picture, squeezed by four walls.

Run it with YADE: ``scripts/yade -n -x scripts/image_grains.py --out DIR``. The picture is drawn by
the script itself (superdisks, ellipses and pebbles on a jittered grid), as a segmentation of a
photograph would give it: ``labels.png``. Any other one: ``--image FILE --pixel METRES``. Results:
``before.png`` and ``after.png`` (von Mises stress over E), ``result.json`` with the error of the
areas, and the stress on the walls against the packing fraction.
"""

import math
import sys

import numpy as np
from PIL import Image
from yade import FrictMat, O

import softgrain as sg
from softgrain import command_line

YOUNG = 1e6  # Pa
CELL = 48  # pixels, of the grid on which the script draws
MARGIN = 4  # pixels, about it
MOST_COLUMNS = 255  # labels have 16 bits
COLUMNS, SEED = 4, 1  # of the drawing, unless options say otherwise
HALF_AXIS = 19  # pixels, the longer one of superdisks and ellipses
PEBBLE, DENTS = 18, 0.13  # pixels, mean radius of pebbles; over it, depth of their dents
STEPS_PER_RECORD = 100


def parse_options(arguments=None):
    parser = command_line.case_parser(__doc__, out="image_grains")
    add = parser.add_argument
    add(
        "--image",
        type=command_line.input_file,
        help="labelled picture; default: one that the script draws",
    )
    add("--pixel", type=command_line.positive, default=2e-4, help="side of a pixel [m]")
    add(
        "--columns",
        type=command_line.whole_from(1, MOST_COLUMNS),
        help=f"grains drawn along each side of the picture; default: {COLUMNS}",
    )
    add("--zeta", type=command_line.resolution, default=0.2, help="relative resolution 2 dr/D [-]")
    add("--mu", type=command_line.non_negative, default=0.2, help="friction [-]")
    add("--phi", type=command_line.fraction, default=0.95, help="packing fraction to end at [-]")
    add("--speed", type=command_line.positive, default=0.3, help="of each wall [m/s]")
    add("--seed", type=command_line.seed, help=f"of the drawing; default: {SEED}")
    options = parser.parse_args(arguments)
    if options.image is None:
        options.columns = options.columns or COLUMNS
        options.seed = options.seed or SEED
        return options
    for name in ("columns", "seed"):
        if getattr(options, name) is not None:
            parser.error(f"argument --{name}: nothing is drawn where --image is given")
    return options


def draw_labels(columns, seed):
    """A picture of columns x columns grains that do not touch: labels from 1 on, 0 between them."""
    rng = np.random.default_rng(seed)
    size = columns * CELL + 2 * MARGIN
    rows, cols = np.mgrid[:size, :size] + 0.5
    labels = np.zeros((size, size), np.uint16)
    for k in range(columns**2):
        centre = (
            MARGIN + CELL * (np.array([k % columns, k // columns]) + 0.5) + rng.uniform(-2, 2, 2)
        )
        angle, ratio = rng.uniform(0, math.pi), rng.uniform(0.6, 1)
        x, y = cols - centre[0], rows - centre[1]
        c, s = math.cos(angle), math.sin(angle)
        along, across = c * x + s * y, (c * y - s * x) / ratio
        if k % 3 == 2:  # a pebble with dents
            bumps = 1 + DENTS * np.cos(3 * np.arctan2(y, x) + angle) * (1 + (k % 2))
            inside = np.hypot(along, across) < PEBBLE * bumps
        else:
            exponent = (2, 4)[k % 3]
            inside = np.abs(along) ** exponent + np.abs(across) ** exponent < HALF_AXIS**exponent
        labels[inside] = k + 1
    return labels


def make_scene(options):
    """Grains and four walls close around them; returns the grains and the ids of the walls."""
    soft = sg.SoftMat(
        young=YOUNG,
        poisson=0.45,
        density=1000,
        frictionAngle=math.atan(options.mu),
        massDamping=100,
        label="soft",
    )
    O.materials.append(soft)
    O.materials.append(FrictMat(frictionAngle=0, label="walls"))
    image = options.image
    if image is None:
        image = options.out / "labels.png"
        Image.fromarray(draw_labels(options.columns, options.seed)).save(image)
    grains = sg.grains_from_image(image, options.pixel, "soft", unusable="skip", zeta=options.zeta)
    for label, reason in grains.left_out.items():
        print(f"label {label} is left out: it {reason}")
    O.bodies.append(grains.bodies)
    O.engines = sg.engines()
    sg.set_time_step(0.8)
    outlines = np.vstack([b.shape.outline()[:, :2] for b in grains.bodies])
    walls = sg.walls_around(outlines.min(axis=0), outlines.max(axis=0), "walls")
    for k, wall in enumerate(walls):
        wall.state.vel[k // 2] = (-1) ** k * options.speed
    return grains, O.bodies.append(walls)


def area():
    """Of the box [m²]."""
    left, right, low, high = sg.wall_box()
    return (right - left) * (high - low)


def pressure(walls):
    """Mean normal stress on the four walls over E."""
    left, right, low, high = sg.wall_box()
    force = sum(abs(O.forces.f(i)[k // 2]) for k, i in enumerate(walls))
    return force / (2 * (right - left) + 2 * (high - low)) / YOUNG


def compact(options, walls):
    """Squeeze to the packing fraction; returns records of phi and mean normal stress over E."""
    record, samples = [], []
    phi = sg.packing_fraction(area())
    while phi < options.phi:
        O.step()
        samples.append(pressure(walls))
        phi = sg.packing_fraction(area())
        if len(samples) == STEPS_PER_RECORD or phi >= options.phi:
            record.append((phi, float(np.mean(samples))))
            samples.clear()
    return record


def main():
    options = parse_options()
    grains, walls = make_scene(options)
    start = sg.packing_fraction(area())
    if options.phi <= start:
        sys.exit(f"--phi: {options.phi} is not above that of the start, {start:.3f}")
    sg.draw_packing(options.out / "before.png", box=sg.wall_box(), field=None)
    record = compact(options, walls)
    sg.draw_packing(options.out / "after.png", box=sg.wall_box(), scale=YOUNG)
    engine = sg.integrator()
    result = {
        "grains": len(grains.bodies),
        "largest_area_error": float(np.abs(grains.area_errors).max()),
        "mean_area_error": float(grains.area_errors.mean()),
        "steps": O.iter,
        "sweeps_per_step": engine.totalSweeps / engine.steps,
        "largest_overlap_over_dr": engine.largestOverlap,
        "capped_steps": engine.cappedSteps,
        "coordination": sg.coordination_number(),
        "phi": [phi for phi, _ in record],
        "stress_over_E": [stress for _, stress in record],
    }
    command_line.write_result(options, result)
    print({k: v for k, v in result.items() if not isinstance(v, list)})
    print(f"phi = {record[-1][0]:.3f}, mean normal stress {record[-1][1]:.4f} E")


if __name__ == "__main__":
    main()
