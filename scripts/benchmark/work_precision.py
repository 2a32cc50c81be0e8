"""Error against run time for formulations, contact geometries, orders and resolutions.

Three problems: a disk between plates and a disk in a closing square box, whose errors are against
converged finite elements, and a compaction of 25 grains, whose error is against a run of the
default method at half the smallest zeta. Each leaves a CSV with all runs and a plot with the Pareto
front marked, and a CSV and a table in which one parameter of the default method is varied at a
time. Run times are only comparable if nothing else runs and ``--jobs`` is 1.
"""

import csv
import itertools
from pathlib import Path

import numpy as np

from softgrain import command_line, finite_elements
from softgrain.runs import new_figure, parse_options, run_all, try_all, write_table

CASES = Path(__file__).resolve().parents[1]

#: Name of the formulation: its options.
FORMULATIONS = {
    "TL nodal": {"formulation": "total", "velocity_update": "nodal"},
    "TL flip": {"formulation": "total", "velocity_update": "flip"},
    "UL": {"formulation": "updated"},
}
CONTACTS = {"points": "s", "surface": "o", "nodes": "^"}  # with the marker of the plot
ORDERS = (2, 3)
RESOLUTIONS = (0.2, 0.14, 0.1, 0.07, 0.05)
COARSE = RESOLUTIONS[:3]  # for the packing, where finer runs by all methods would take hours
FINEST = {"formulation": "total", "velocity_update": "nodal", "contact": "surface", "order": 3}
#: Parameters varied one at a time at zeta = 0.1, with their values; the first is the default, None
#: that of the case.
DEFAULT_ZETA = 0.1
VARIED = {
    "order": (3, 2, 1),
    "node_spacing": (1.25, 1.5, 2.0),
    "surface_spacing": (1.0, 0.6, 0.8, 1.25, 1.5),
    "tolerance": (None, 1e-1, 1e-2, 1e-3, 1e-4),
    "time_step_fraction": (0.9, 0.25, 0.5, 0.7, 0.8),
}
COLUMNS = ("formulation", "contact", "order", "zeta", "wall_seconds", "steps", "error")
VARIED_COLUMNS = ("parameter", "value", "wall_seconds", "steps", "sweeps", "capped", "error")


class Problem:
    """A case with its fixed options and its measure of error."""

    def __init__(self, name, script, settings, error, resolutions):
        self.name, self.script, self.settings = name, CASES / script, settings
        self.error, self.resolutions = error, resolutions


def relative_error(x, y, exact_x, exact_y, low, high):
    """Mean of |y/y_exact - 1| over the samples with low <= x <= high; nan where a run ended
    before."""
    x, y = np.asarray(x), np.asarray(y)
    if x.max() < high - 0.1 * (high - low):
        return np.nan
    inside = (x >= low) & (x <= high)
    exact = finite_elements.interpolated(x[inside], exact_x, exact_y)
    return float(np.mean(np.abs(y[inside] / exact - 1)))


def disk_error(result):
    exact = finite_elements.disk_between_plates("plane_strain")
    return relative_error(
        result["delta_over_D"],
        result["force_over_ED"],
        exact.delta_over_D,
        exact.force_over_ED,
        0.03,
        0.15,
    )


def square_error(result):
    exact = finite_elements.square_cell()
    return relative_error(
        result["wall_displacement_over_D"],
        result["force_over_ED"],
        exact.wall_displacement_over_D,
        exact.force_over_ED,
        0.02,
        0.045,
    )


def compaction_error(finest):
    """Measure against a finer run: mean stresses over windows of 0.02 in phi."""
    edges = np.arange(0.84, 0.921, 0.02)

    def levels(result):
        phi, stress = np.array(result["phi"]), np.array(result["stress_over_E"])
        return np.array([stress[(phi >= a) & (phi < a + 0.02)].mean() for a in edges[:-1]])

    exact = levels(finest)
    return lambda result: float(np.mean(np.abs(levels(result) / exact - 1)))


def problems(options):
    grains = {"grains": 25, "mu": 0.3, "until_phi": 0.93}
    fine, coarse = options.zeta or RESOLUTIONS, options.zeta or COARSE
    finest = {**grains, **FINEST, "zeta": 0.5 * min(coarse)}
    finest = run_all(CASES / "compaction.py", [finest], options)[0]
    return [
        Problem("disk", "hertz.py", {"until": 0.16}, disk_error, fine),
        Problem("square cell", "square_cell.py", {"until_phi": 0.93}, square_error, fine),
        Problem("compaction", "compaction.py", grains, compaction_error(finest), coarse),
    ]


def measure(problem, options):
    """A row of COLUMNS for each run that ended well."""
    methods = [
        method
        for method in itertools.product(FORMULATIONS, CONTACTS, ORDERS, problem.resolutions)
        if method[:2] != ("UL", "nodes")  # refused
    ]
    settings = [
        {**problem.settings, **FORMULATIONS[f], "contact": contact, "order": order, "zeta": zeta}
        for f, contact, order, zeta in methods
    ]
    results = try_all(problem.script, settings, options)
    return [
        (*method, result["wall_seconds"], result["steps"], problem.error(result))
        for method, result in zip(methods, results)
        if result
    ]


def vary(problem, options):
    """Rows (parameter, value, seconds, steps, sweeps a step, capped steps, error) of runs of the
    default method with one parameter changed; no figures where a run failed."""
    varied = [(name, value) for name, values in VARIED.items() for value in values]
    settings = [
        {
            **problem.settings,
            **FINEST,
            "zeta": DEFAULT_ZETA,
            **({} if value is None else {name: value}),
        }
        for name, value in varied
    ]
    rows = []
    for key, result in zip(varied, try_all(problem.script, settings, options)):
        if result:
            figures = [result[name] for name in ("steps", "sweeps_per_step", "capped_steps")]
            rows.append((*key, result["wall_seconds"], *figures, problem.error(result)))
        else:
            rows.append((*key, *[np.nan] * 5))
    return rows


def table_of_variations(path, rows):
    """Markdown table of :func:`vary`."""
    head = ["parameter", "value", "seconds", "steps", "sweeps a step", "capped", "error %"]
    cells = [
        [
            name.replace("_", " "),
            "default of the case" if value is None else f"{value:g}",
            f"{seconds:.2f}",
            f"{steps:.0f}",
            f"{sweeps:.1f}",
            f"{capped:.0f}",
            f"{100 * error:.2f}",
        ]
        for name, value, seconds, steps, sweeps, capped, error in rows
    ]
    write_table(path, head, cells)


def pareto_front(rows):
    """Rows that no other beats in both time and error, by time."""
    front, best = [], np.inf
    for row in sorted(rows, key=lambda r: (r[4], r[6])):
        if row[6] < best:
            front.append(row)
            best = row[6]
    return front


def draw(path, problem, rows):
    figure, axes = new_figure("run time [s]", "mean relative error", width=7, title=problem.name)
    axes.set_xscale("log")
    axes.set_yscale("log")
    for k, formulation in enumerate(FORMULATIONS):
        for (contact, marker), order in itertools.product(CONTACTS.items(), ORDERS):
            line = [r for r in rows if r[:3] == (formulation, contact, order)]
            if not line:
                continue
            axes.plot(
                [r[4] for r in line],
                [r[6] for r in line],
                marker + {2: ":", 3: "-"}[order],
                color=f"C{k}",
                mfc="none",
                ms=4,
                lw=0.8,
                label=f"{formulation}, {contact}, order {order}",
            )
    front = pareto_front(rows)
    axes.plot([r[4] for r in front], [r[6] for r in front], color="black", lw=3, alpha=0.25)
    axes.legend(frameon=False, fontsize=6, loc="center left", bbox_to_anchor=(1, 0.5))
    figure.savefig(path, dpi=200)


def write_csv(path, columns, rows):
    with open(path, "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(columns)
        writer.writerows(rows)


def main():
    options = parse_options(
        __doc__,
        jobs=1,
        out="work_precision",
        zeta={
            "type": command_line.resolution,
            "nargs": "+",
            "help": "relative resolutions 2 dr/D, the same for all problems [-]",
        },
    )
    for problem in problems(options):
        rows = measure(problem, options)
        name = problem.name.replace(" ", "_")
        write_csv(options.out / f"{name}.csv", COLUMNS, rows)
        draw(options.out / f"{name}.png", problem, rows)
        for row in pareto_front(rows):
            print(f"{problem.name}: {row[:4]}: {row[4]:.1f} s, error {100 * row[6]:.2f} %")
        rows = vary(problem, options)
        write_csv(options.out / f"{name}_varied.csv", VARIED_COLUMNS, rows)
        table_of_variations(options.out / f"{name}_varied.md", rows)


if __name__ == "__main__":
    main()
