"""Running the cases of ``scripts/`` and comparing their forces with finite elements."""

import json
import subprocess
from pathlib import Path

import numpy as np

from softgrain import finite_elements

SCRIPTS = Path(__file__).resolve().parents[2] / "scripts"


def run_yade(script, *options, threads=1, folder=None, timeout=3600):
    """Run a script of ``scripts/`` in YADE, in a folder; returns the finished process."""
    return subprocess.run(
        ["/usr/bin/yade", "-n", "-x", f"-j{threads}", str(SCRIPTS / script), *options],
        capture_output=True,
        text=True,
        timeout=timeout,
        cwd=folder,
    )


def run_to_end(script, folder, *options, threads=1):
    """The same where it must succeed, with ``--out`` in that folder."""
    process = run_yade(script, "--out", str(folder), *options, threads=threads, folder=folder)
    assert process.returncode == 0, process.stdout + process.stderr


def run_case(name, folder, *options):
    """Run ``scripts/<name>.py``; returns its result with arrays for lists of numbers."""
    run_to_end(f"{name}.py", folder, *options)
    result = json.loads((folder / "result.json").read_text())
    return {k: np.array(v) if is_numbers(v) else v for k, v in result.items()}


def is_numbers(value):
    return isinstance(value, list) and not any(isinstance(item, dict) for item in value)


def errors(result, curve, abscissa, ordinate="force_over_ED", start=0.0, end=np.inf):
    """Relative errors of a result over a curve of finite elements, where the abscissa lies within
    [start, end]."""
    x = result[abscissa]
    shown = (x >= start) & (x <= end)
    assert shown.sum() > 3
    expected = finite_elements.interpolated(x[shown], curve[abscissa], curve[ordinate])
    return result[ordinate][shown] / expected - 1
