"""Runs of the cases in ``scripts/`` behind figures and benchmarks: each is made once, in a folder
named by its options, and read from there afterwards."""

import json
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from matplotlib.figure import Figure

from softgrain import command_line


def parse_options(description, jobs, out, **extra):
    """Options of a program that makes runs.

    Args:
        description (str): docstring of the program; its first paragraph is shown.
        jobs (int): default number of runs at the same time, each on one thread.
        out (str): default folder for pictures, tables and runs.
        **extra (dict): arguments of ``add_argument`` for further options, by name.

    Returns:
        argparse.Namespace: the options; the folder ``out`` exists.
    """
    parser = command_line.case_parser(description, out)
    for name, settings in extra.items():
        parser.add_argument("--" + name.replace("_", "-"), **settings)
    parser.add_argument(
        "--jobs",
        type=command_line.whole_from(1),
        default=jobs,
        help="runs at the same time, each on one thread [-]",
    )
    return parser.parse_args()


def run_all(script, settings, options):
    """As :func:`try_all`, but the program ends if a run failed, when all others have been made."""
    results = try_all(script, settings, options)
    failures = results.count(None)
    if failures:
        sys.exit(f"{failures} of {len(results)} runs failed")
    return results


def try_all(script, settings, options):
    """Results of a case for each of the settings, in their order.

    Args:
        script (Path): the case, e.g. ``scripts/hertz.py``.
        settings (list of dict): options of the case by name, with underscores.
        options (argparse.Namespace): of :func:`parse_options`.

    Returns:
        list of dict: ``result.json`` of each run; None for a run that failed, which is named on
        stderr. Its output is in ``log.txt`` of its folder.
    """
    folders = [run_folder(script, chosen, options.out) for chosen in settings]
    runs = dict(zip(folders, settings))  # equal settings are one run
    with ThreadPoolExecutor(options.jobs) as pool:
        results = pool.map(lambda folder: _run(script, runs[folder], folder), runs)
        found = dict(zip(runs, results))
    return [found[folder] for folder in folders]


def _run(script, chosen, folder):
    result = folder / "result.json"
    if not result.exists() and not _make(script, chosen, folder):
        result.unlink(missing_ok=True)  # of a run that failed after it
        print(f"failed: see {folder}/log.txt", file=sys.stderr)
        return None
    return json.loads(result.read_text())


def _make(script, chosen, folder):
    """Run the case; whether it ended well."""
    folder.mkdir(parents=True, exist_ok=True)
    print(f"running {folder.name}", file=sys.stderr)
    arguments = [f"--{name.replace('_', '-')}={value}" for name, value in chosen.items()]
    command = ["yade", "-n", "-x", "-j1", str(script), *arguments, f"--out={folder}"]
    with open(folder / "log.txt", "w") as log:
        return subprocess.run(command, stdout=log, stderr=log).returncode == 0


def run_folder(script, chosen, out):
    """Folder of the run of ``script`` with the options ``chosen`` within the folder ``out``."""
    words = [f"{name}={value}" for name, value in chosen.items()]
    return (out / "runs" / "-".join([Path(script).stem, *words])).resolve()


def new_figure(xlabel, ylabel, width=5, **axes_settings):
    """Figure and axes in the style common to all figures, ``width`` inches wide."""
    figure = Figure(figsize=(width, 4), layout="constrained")
    axes = figure.add_subplot()
    axes.set(xlabel=xlabel, ylabel=ylabel, **axes_settings)
    axes.grid(alpha=0.3)
    return figure, axes


def markdown_table(head, rows):
    """A Markdown table (str) of cells of any type, without an end of line behind it."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(str(cell) for cell in line) + " |" for line in lines)


def write_table(path, head, rows):
    """Write a Markdown table to a file, and print it."""
    text = markdown_table(head, rows)
    path.write_text(text + "\n")
    print(text)
