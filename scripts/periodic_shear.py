"""Simple shear of soft disks in a periodic cell, at constant normal stress.

Run it with YADE: ``scripts/yade -n -x scripts/periodic_shear.py --out DIR``. A cloud of YADE's is
made soft, compressed with the cell and brought to an isotropic stress by YADE's
PeriTriaxController; then the cell is sheared while both normal stresses are held.
``result.json`` has stresses, packing fraction and shear, ``shear.png`` their curves,
``packing.png`` the packing at the end, with the images of the grains at the borders.
"""

import math

import matplotlib.figure
import numpy as np
from yade import FrictMat, Matrix3, O, PeriTriaxController

import softgrain as sg
from softgrain import command_line
from softgrain.clouds import full_cloud

RADIUS = 0.01  # m
YOUNG, DENSITY = 1e6, 1000.0  # Pa, kg/m3
DAMPING = 400  # 1/s, of the grains
SPREAD = 0.25  # of the radii about their mean
CLOUD_PHI = 0.55  # of the generated cloud
DENSE_PHI = 0.80  # at which the controller of the stresses takes over
RATE = 2.0  # 1/s, of the compression before, and at most under the controller
CALM, CALM_STEPS = 0.01, 500  # error of the stresses, and steps for which it is not passed, at rest
STILL, STILL_STEPS = 1e-6, 5000  # share of RATE below which the cell stands still, and for how long
MOST_REST_STEPS = 500_000  # for which it may take to come to rest


def parse_options(arguments=None):
    parser = command_line.case_parser(__doc__, out="periodic_shear")
    add = parser.add_argument
    add("--grains", type=command_line.whole_from(10), default=40, help="number of disks")
    add("--zeta", type=command_line.resolution, default=0.2, help="relative resolution 2 dr/D [-]")
    add("--mu", type=command_line.non_negative, default=0.3, help="friction [-]")
    add("--stress", type=command_line.positive, default=0.03, help="normal stress over E [-]")
    add("--shear", type=command_line.positive, default=0.4, help="shear at the end [-]")
    add("--rate", type=command_line.positive, default=1.0, help="of shear [1/s]")
    add(
        "--mass",
        type=command_line.positive,
        default=0.03,
        help="of the cell under PeriTriaxController, over density times area of the cell [-]",
    )
    add("--seed", type=command_line.seed, default=1, help="of the packing generator [-]")
    return parser.parse_args(arguments)


def make_scene(options):
    """A loose packing of soft disks; the cell is 1 m along z, so that what YADE relates to its
    volume is per metre of thickness."""
    side = RADIUS * math.sqrt(math.pi * options.grains / CLOUD_PHI)
    O.periodic = True
    O.cell.setBox(side, side, 1)
    cloud = full_cloud(options.grains, (side, side, 0), RADIUS, SPREAD, options.seed, periodic=True)
    ids = cloud.toSimulation(material=FrictMat())
    for i in ids:
        O.bodies[i].state.blockedDOFs = "zXY"
    material = sg.SoftMat(
        young=YOUNG,
        poisson=0.45,
        density=DENSITY,
        frictionAngle=math.atan(options.mu),
        massDamping=DAMPING,
    )
    sg.soften(ids, material=material, zeta=options.zeta, overlap="refuse")
    O.engines = sg.engines()
    return ids


def compress(phi):
    """With the flow of the cell, to a packing fraction."""
    O.cell.velGrad = Matrix3(-RATE, 0, 0, 0, -RATE, 0, 0, 0, 0)
    while sg.packing_fraction() < phi:
        sg.advance(50)


def hold_stress(stress, mass):
    """Add the controller of both normal stresses. It moves the cell as a mass of its own, which is
    to follow what grains do to each other, within the time of a wave across the cell or less."""
    control = PeriTriaxController(
        goal=(-stress, -stress, 0),
        stressMask=3,
        dynCell=True,
        mass=mass * DENSITY * O.cell.size[0] ** 2,
        growDamping=0.5,
        maxStrainRate=(RATE, RATE, 0),
    )
    sg.insert_before_solve(control)
    O.cell.velGrad = Matrix3.Zero


def rest(stress):
    """Until the stresses are near the target for a while; ends the script where the cell stands
    still before, or swings on."""
    calm, still, stride, end = 0, 0, 50, O.iter + MOST_REST_STEPS
    while calm < CALM_STEPS:
        if O.iter >= end:
            raise SystemExit(
                f"periodic_shear: after {MOST_REST_STEPS} steps the stresses still are not within "
                f"{CALM:g} of the target for {CALM_STEPS} steps. Take another --mass of the cell"
            )
        sg.advance(stride)
        present = np.diag(sg.cell_stress())[:2]
        calm = calm + stride if np.all(np.abs(present + stress) < CALM * stress) else 0
        stands = np.abs(np.array(O.cell.velGrad)).max() < STILL * RATE
        still = still + stride if stands and not calm else 0
        if still > STILL_STEPS:
            raise SystemExit(
                f"periodic_shear: the cell stands still at stresses of {-present[0] / stress:.2f} "
                f"and {-present[1] / stress:.2f} of the target: PeriTriaxController shrinks no "
                "cell below 2.1 times its largest grain. Take more --grains or less --stress"
            )


def shear(options, stress):
    """Shear the cell; returns rows of shear, stresses xx, yy, xy over `stress`, phi."""
    diagonal = np.diag(np.array(O.cell.velGrad))
    O.cell.flipFlippable = True
    O.cell.velGrad = Matrix3(diagonal[0], options.rate, 0, 0, diagonal[1], 0, 0, 0, 0)
    rows, start = [], O.time
    with command_line.progress_bar(total=options.shear) as bar:
        while (O.time - start) * options.rate < options.shear:
            sg.advance(25)
            sigma = sg.cell_stress() / stress
            gamma = (O.time - start) * options.rate
            rows.append(
                [gamma, sigma[0, 0], sigma[1, 1], 0.5 * (sigma[0, 1] + sigma[1, 0])]
                + [sg.packing_fraction()]
            )
            command_line.show_progress(bar, gamma, f"shear {gamma:.3f}")
    return np.array(rows).T


def plot(options, columns):
    gamma, xx, yy, xy, phi = columns
    figure = matplotlib.figure.Figure(figsize=(5, 4), layout="constrained")
    above, below = figure.subplots(2, sharex=True)
    for values, label in ((-xx, "normal, x"), (-yy, "normal, y"), (xy, "shear")):
        above.plot(gamma, values, lw=1, label=label)
    above.set(ylabel="stress / target")
    above.legend(frameon=False)
    below.plot(gamma, phi, lw=1, color="black")
    below.set(xlabel="shear", ylabel="packing fraction")
    figure.savefig(options.out / "shear.png", dpi=200)


def main():
    options = parse_options()
    make_scene(options)
    stress = options.stress * YOUNG
    compress(DENSE_PHI)
    hold_stress(stress, options.mass)
    rest(stress)
    columns = shear(options, stress)
    gamma, xx, yy, xy, phi = columns
    late = gamma > 0.5 * gamma[-1]
    error = np.array([xx, yy]) + 1
    command_line.write_result(
        options,
        {
            "shear": gamma,
            "stress_xx_over_target": xx,
            "stress_yy_over_target": yy,
            "stress_xy_over_target": xy,
            "phi": phi,
            "normal_stress_error_rms": float(np.sqrt((error**2).mean())),
            "largest_overlap_over_dr": sg.integrator().largestOverlap,
            "capped_steps": int(sg.integrator().cappedSteps),
            "steps": int(sg.integrator().steps),
        },
    )
    plot(options, columns)
    sg.draw_packing(options.out / "packing.png")
    print(
        f"shear {gamma[-1]:.3f}: stress ratio {xy[late].mean():.3f}, phi {phi[late].mean():.4f}, "
        f"normal stresses off the target by {100 * np.sqrt((error**2).mean()):.2f} % (rms), "
        f"{100 * np.abs(error).max():.2f} % at most. Results in {options.out}/"
    )


if __name__ == "__main__":
    main()
