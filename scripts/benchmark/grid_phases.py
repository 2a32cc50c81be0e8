"""Errors of one disk against how its outline cuts the background grid.

Where the outline just reaches beyond a row of nodes, that row carries little of the grain; how
little follows from R/h, and with it from zeta. The cases of work_precision.py, a disk between
plates and a disk in a closing box, for values of zeta close to each other and some orientations of
the grid: a table with the mean error of the force for each zeta (mean and worst of the
orientations), and the number of steps, which grows where light nodes make them short.
"""

from pathlib import Path

import numpy as np
from work_precision import disk_error, square_error

from softgrain.runs import parse_options, run_all, write_table

CASES = Path(__file__).resolve().parents[1]
RESOLUTIONS = (0.2, 0.19, 0.185, 0.18, 0.175, 0.17, 0.16, 0.15, 0.14, 0.135, 0.13, 0.125, 0.12)
RESOLUTIONS += (0.115, 0.11, 0.105, 0.1, 0.095, 0.09)
ORIENTATIONS = (0, 17, 40)  # degrees
NODE_SPACING = 1.25  # h/dr, the default of the cases
PROBLEMS = (
    ("hertz.py", {"until": 0.16}, disk_error),
    ("square_cell.py", {"until_phi": 0.93}, square_error),
)


def measure(options, script, settings, error):
    """Errors and steps, shape (resolutions, orientations)."""
    chosen = [
        {**settings, "zeta": zeta, "orientation": angle}
        for zeta in RESOLUTIONS
        for angle in ORIENTATIONS
    ]
    results = run_all(CASES / script, chosen, options)
    shape = (len(RESOLUTIONS), len(ORIENTATIONS))
    errors = np.reshape([error(result) for result in results], shape)
    return errors, np.reshape([result["steps"] for result in results], shape)


def main():
    options = parse_options(__doc__, jobs=2, out="grid_phases")
    columns = []
    for script, settings, error in PROBLEMS:
        errors, steps = measure(options, script, settings, error)
        columns.append([f"{100 * e.mean():.2f}, {100 * e.max():.2f}" for e in errors])
        columns.append([str(s.max()) for s in steps])
    phases = [f"{1 / (NODE_SPACING * zeta) % 1:.2f}" for zeta in RESOLUTIONS]
    head = ["zeta", "R/h modulo 1", "disk: error %", "steps", "square cell: error %", "steps"]
    write_table(options.out / "grid_phases.md", head, zip(RESOLUTIONS, phases, *columns))


if __name__ == "__main__":
    main()
