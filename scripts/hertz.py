"""One soft disk pressed between two frictionless plates (Nezamabadi & Radjai 2024, section 3.1).

Run it with YADE: ``scripts/yade -n -x scripts/hertz.py --zeta 0.1 --contact surface --out DIR``.
The bottom plate is fixed, the top one moves down at constant speed. The force is compared with
converged finite elements. (The paper says plane stress, but its E* = E/(1 - nu^2) is that of plane
strain, the default here.)
"""

import argparse
import math
import time
from pathlib import Path

import matplotlib.figure
import numpy as np
import yade.utils
from yade import FrictMat, O

import softgrain as sg
from softgrain import command_line, finite_elements

#: omega R / c_s of the lowest vibration of a free disk (Lamb), nu = 0.45; it changes little with
#: nu.
LOWEST_MODE = 2.3525
#: Forces are averaged over windows of this many periods of that mode, in which the disk bounces
#: between the plates about once.
PERIODS_PER_WINDOW = 2


def parse_options(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    add = parser.add_argument
    add("--zeta", type=command_line.resolution, default=0.1, help="relative resolution 2 dr/D [-]")
    add("--young", type=command_line.positive, default=1e6, help="Young's modulus [Pa]")
    add("--poisson", type=command_line.poisson, default=0.45, help="Poisson's ratio [-]")
    add("--density", type=command_line.positive, default=1000.0, help="density [kg/m3]")
    add("--diameter", type=command_line.positive, default=0.02, help="diameter of the disk [m]")
    add(
        "--condition",
        choices=("plane_strain", "plane_stress"),
        default="plane_strain",
        help="what closes the third dimension",
    )
    add(
        "--contact",
        choices=("surface", "points", "nodes"),
        default="surface",
        help="contact geometry",
    )
    command_line.add_method_options(parser)
    add(
        "--speed",
        type=command_line.positive,
        default=0.02,
        help="of the top plate [m/s]; the paper's 0.1 makes the force ripple",
    )
    add(
        "--until",
        type=command_line.fraction,
        default=0.2,
        metavar="DELTA_OVER_D",
        help="approach of the plates over the diameter to stop at [-]",
    )
    add("--out", type=command_line.output_folder, default=Path("hertz"), help="folder for results")
    options = parser.parse_args(arguments)
    command_line.check_method(parser, options)
    return options


def make_scene(options):
    """The disk just touching both plates; returns the ids of the bottom and the top plate."""
    radius = options.diameter / 2
    condition = {"plane_strain": "planeStrain", "plane_stress": "planeStress"}[options.condition]
    O.materials.append(FrictMat(frictionAngle=0, label="plates"))
    disk = sg.soft_disk(
        (0, 0, 0),
        radius,
        zeta=options.zeta,
        contact=options.contact,
        **command_line.method_attributes(options),
        material=sg.SoftMat(
            young=options.young,
            poisson=options.poisson,
            density=options.density,
            condition=condition,
        ),
    )
    O.bodies.append(disk)
    bottom = O.bodies.append(yade.utils.wall(-radius, axis=1, sense=1, material="plates"))
    top = O.bodies.append(yade.utils.wall(radius, axis=1, sense=-1, material="plates"))
    O.bodies[top].state.vel = (0, -options.speed, 0)
    O.engines = sg.engines()
    sg.set_time_step()
    return bottom, top


def approach(options, top):
    """Approach of the plates over the diameter."""
    return 0.5 - O.bodies[top].state.pos[1] / options.diameter


def window_seconds(options):
    """Two periods of the lowest vibration."""
    shear_speed = math.sqrt(options.young / (2 * (1 + options.poisson)) / options.density)
    return PERIODS_PER_WINDOW * 2 * math.pi / (LOWEST_MODE * shear_speed / (options.diameter / 2))


def press(options, bottom, top):
    """Press the disk; returns rows (delta/D, bottom force, top force) averaged over windows."""
    length = options.speed * window_seconds(options) / options.diameter
    rows = []
    with command_line.progress_bar(total=options.until) as bar:
        while approach(options, top) < options.until:
            start = approach(options, top)
            sums = np.zeros(3)
            steps = 0
            while approach(options, top) < start + length:
                delta = approach(options, top)
                O.step()
                sums += (delta, -O.forces.f(bottom)[1], O.forces.f(top)[1])
                steps += 1
            rows.append(sums / steps)
            reached = approach(options, top)
            command_line.show_progress(bar, reached, f"delta/D {reached:.4f}")
    return np.array(rows)


def plot_force(options, delta, force):
    figure = matplotlib.figure.Figure(figsize=(5, 4), layout="constrained")
    axes = figure.add_subplot()
    if options.poisson == 0.45:
        exact = finite_elements.disk_between_plates(options.condition)
        shown = exact.delta_over_D <= options.until
        axes.plot(
            exact.delta_over_D[shown],
            exact.force_over_ED[shown],
            color="black",
            lw=1,
            label="finite elements, converged",
        )
    axes.plot(
        delta,
        force,
        "o",
        ms=3,
        mfc="none",
        label=rf"softgrain, $\zeta$ = {options.zeta:g}, {options.contact}",
    )
    axes.set(
        xlabel=r"approach of the plates $\delta$ / D",
        ylabel="force F / (E D)",
        xlim=(0, None),
        ylim=(0, None),
        title=options.condition.replace("_", " "),
    )
    axes.legend(frameon=False)
    axes.grid(alpha=0.3)
    figure.savefig(options.out / "force.png", dpi=200)


def main():
    options = parse_options()
    bottom, top = make_scene(options)
    started = time.time()
    rows = press(options, bottom, top)
    seconds = time.time() - started
    delta, below, above = rows[:, 0], *(rows[:, 1:] / (options.young * options.diameter)).T
    force = 0.5 * (below + above)
    engine = sg.integrator()
    command_line.write_result(
        options.out,
        {
            "delta_over_D": delta,
            "force_over_ED": force,
            "force_top_over_ED": above,
            "force_bottom_over_ED": below,
            "window_over_D": options.speed * window_seconds(options) / options.diameter,
            "wall_seconds": seconds,
            "steps": int(engine.steps),
            "dt": O.dt,
            "sweeps_per_step": engine.totalSweeps / engine.steps,
            "capped_steps": int(engine.cappedSteps),
            "residual_max": engine.largestResidual,
            "options": {name: str(value) for name, value in vars(options).items()},
        },
    )
    plot_force(options, delta, force)
    print(
        f"delta/D = {delta[-1]:.4f}, F/(E D) = {force[-1]:.5f}; {int(engine.steps)} steps in "
        f"{seconds:.1f} s, "
        f"forces averaged over windows of {1e3 * window_seconds(options):.2f} ms. Results in "
        f"{options.out}/"
    )


if __name__ == "__main__":
    main()
