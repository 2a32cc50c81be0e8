"""Figure 2a of the paper: F(d) of one disk by total- and updated-Lagrangian MPM, and run times.

The paper finds the same force and half the run time for TLMPM. Run times are comparable only with
``--jobs 1`` and nothing else running.
"""

from pathlib import Path

import numpy as np

from softgrain import command_line, finite_elements
from softgrain.runs import new_figure, parse_options, run_all, write_table

HERTZ = Path(__file__).resolve().parents[1] / "hertz.py"
UNTIL = 0.1  # delta/D
FORMULATIONS = {
    "TLMPM, nodal": {"formulation": "total", "velocity_update": "nodal"},
    "TLMPM, flip": {"formulation": "total", "velocity_update": "flip"},
    "ULMPM": {"formulation": "updated"},
}


def main():
    options = parse_options(
        __doc__,
        jobs=1,
        out="figures",
        zeta={
            "type": command_line.resolution,
            "default": 0.03,
            "help": "relative resolution 2 dr/D [-]",
        },
        contact={
            "choices": ("points", "surface"),
            "default": "points",
            "help": "contact geometry; the paper's is points",
        },
    )
    common = {"contact": options.contact, "zeta": options.zeta, "until": UNTIL}
    settings = [{**common, **chosen} for chosen in FORMULATIONS.values()]
    results = run_all(HERTZ, settings, options)

    figure, axes = new_figure("displacement of the centre d / D", "F / (E D)")
    exact = finite_elements.disk_between_plates("plane_strain")
    shown = exact.delta_over_D <= UNTIL
    axes.plot(exact.delta_over_D[shown] / 2, exact.force_over_ED[shown], "k:", label="FE")
    rows = []
    for name, result in zip(FORMULATIONS, results):
        delta, force = np.array(result["delta_over_D"]), result["force_over_ED"]
        axes.plot(delta / 2, force, lw=1, label=name)
        at_levels = np.interp((0.03, 0.06, 0.1), delta, force)
        step = 1e6 * result["wall_seconds"] / result["steps"]
        rows.append(
            [
                name,
                *[f"{f:.5f}" for f in at_levels],
                f"{result['wall_seconds']:.1f}",
                result["steps"],
                f"{step:.1f}",
                f"{result['wall_seconds'] / results[0]['wall_seconds']:.2f}",
            ]
        )
    axes.legend(frameon=False)
    figure.savefig(options.out / "figure2a.png", dpi=200)
    levels = [f"F/(E D) at delta/D = {level}" for level in (0.03, 0.06, 0.1)]
    head = ["formulation", *levels, "seconds", "steps", "µs a step", "time over TL nodal"]
    rows.append(["paper", "", "", "UL and TL almost the same", "", "", "", "UL about 2"])
    write_table(options.out / "figure2a.md", head, rows)


if __name__ == "__main__":
    main()
