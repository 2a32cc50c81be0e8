"""The same packing and loading with rigid, bonded, finite-element and soft grains.

Run it with YADE: ``scripts/yade -n -x scripts/compare_rigid.py --out DIR``. Every model runs in a
YADE of its own (``scripts/rigid_and_soft/run.py``), on two problems: one grain in a closing square
box, where converged finite elements say what is right, and the uniaxial compaction of a packing.
Leaves ``result.json``, ``comparison.md`` and ``comparison.png``.
"""

import json
import subprocess
import sys
from pathlib import Path

import matplotlib.figure
import numpy as np

sys.path.append(str(Path(sys.argv[0]).resolve().parent))  # in YADE, __file__ is its start script

from rigid_and_soft import models  # noqa: E402
from rigid_and_soft.models import MODELS  # noqa: E402
from rigid_and_soft.options import (  # noqa: E402
    add_case_options,
    case_arguments,
    check_case_options,
)

from softgrain import command_line, finite_elements  # noqa: E402
from softgrain.runs import markdown_table  # noqa: E402

RUN = Path(models.__file__).with_name("run.py")


def parse_options(arguments=None):
    parser = command_line.case_parser(__doc__, out="compare_rigid")
    add_case_options(parser)
    parser.add_argument(
        "--models", nargs="+", choices=MODELS, default=list(MODELS), help="to be run"
    )
    options = parser.parse_args(arguments)
    check_case_options(parser, options)
    return options


def run(model, problem, options):
    """Results of one model on one problem, from its own process."""
    result = options.out / f"{model}_{problem}.json"
    command = ["yade", "-n", "-x", "-j1", RUN, model, problem, "--result", result]
    command += case_arguments(options)
    print(f"{MODELS[model].label}, {problem} ...", flush=True)
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    if done.returncode != 0:
        raise RuntimeError(f"{model}, {problem}: {done.stdout[-2000:]}{done.stderr[-2000:]}")
    return json.loads(result.read_text())


def upper_limit(curves, name):
    """Of the models that deform, and room above; None without one."""
    tops = [max(curve[name]) for model, curve in curves.items() if MODELS[model].deforms]
    return 1.25 * max(tops) if tops else None


def plot(cells, packings, exact, path):
    figure = matplotlib.figure.Figure(figsize=(9, 4), layout="constrained")
    cell, packing = figure.subplots(1, 2)
    cell.plot(
        exact.wall_displacement_over_D, exact.force_over_ED, color="black", lw=1, label="exact"
    )
    for model in packings:
        name = MODELS[model].label
        cell.plot(cells[model]["displacement"], cells[model]["force"], lw=1.2, label=name)
        packing.plot(packings[model]["phi0"], packings[model]["stress"], lw=1.2, label=name)
    cell.set(
        xlabel="displacement of each side w / D",
        ylabel="force F / (E D)",
        xlim=(0, 0.06),
        ylim=(0, upper_limit(cells, "force")),
        title="one grain in a closing box",
    )
    packing.set(
        xlabel=r"nominal packing fraction $\phi_0$",
        ylabel=r"$\sigma$ / E",
        ylim=(0, upper_limit(packings, "stress")),
        title="packing",
    )
    for axes in (cell, packing):
        axes.grid(alpha=0.3)
        axes.legend(frameon=False, fontsize=8)
    figure.savefig(path, dpi=200)


def error_in_cell(cell, exact):
    """Mean of |F/F_exact - 1| in the cell, from w/D = 0.01 on [%]."""
    shift, force = np.array(cell["displacement"]), np.array(cell["force"])
    inside = (shift > 0.01) & (shift < exact.wall_displacement_over_D[-1])
    expected = finite_elements.interpolated(
        shift[inside], exact.wall_displacement_over_D, exact.force_over_ED
    )
    return 100 * float(np.mean(np.abs(force[inside] / expected - 1)))


def jamming(packing):
    """Nominal packing fraction from which on rigid grains bear more than soft ones could, E; None
    if they do not at the end (a packing may give way once more)."""
    loose = np.flatnonzero(np.array(packing["stress"]) <= 1)
    first = loose[-1] + 1 if len(loose) else 0
    return packing["phi0"][first] if first < len(packing["phi0"]) else None


def table(cells, packings, exact):
    """Markdown: one row a model."""
    head = (
        "model",
        "error in the cell, %",
        "run time of the cell, s",
        "stress/E of the packing at the end",
        "coordination",
        "steps",
        "run time, s",
        "particles or points a grain",
    )
    rows = []
    for model in packings:
        cell, packing = cells[model], packings[model]
        deforms = MODELS[model].deforms
        end = f"{packing['stress'][-1]:.3g} at {packing['phi0'][-1]:.3f}"
        if not deforms and (jammed := jamming(packing)):
            end = f"without bound from {jammed:.3f} on"
        entries = (
            MODELS[model].label,
            f"{error_in_cell(cell, exact):.2g}" if deforms else "cannot deform",
            f"{cell['wall_seconds']:.2g}" if deforms else "",
            end,
            f"{packing['coordination'][-1]:.2f}",
            packing["steps"],
            f"{packing['wall_seconds']:.2g}",
            f"{packing['parts']:.0f}",
        )
        rows.append(entries)
    return markdown_table(head, rows) + "\n"


def main():
    options = parse_options()
    exact = finite_elements.square_cell(options.poisson)
    cells = {model: run(model, "cell", options) for model in options.models}
    packings = {model: run(model, "packing", options) for model in options.models}
    command_line.write_result(options, {"cell": cells, "packing": packings})
    text = table(cells, packings, exact)
    (options.out / "comparison.md").write_text(text)
    plot(cells, packings, exact, options.out / "comparison.png")
    print(text)


if __name__ == "__main__":
    main()
