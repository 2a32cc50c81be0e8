"""The benchmark of all scenes runs, and its table has the work of each of them."""

import csv
import subprocess
import sys
from pathlib import Path

import pytest

PROGRAM = Path(__file__).resolve().parents[2] / "scripts" / "benchmark" / "run.py"
YADE_ENGINES = {"ForceResetter", "InsertionSortCollider", "InteractionLoop", "NewtonIntegrator"}


def run(*arguments):
    command = [sys.executable, str(PROGRAM), "--quick", *arguments]
    return subprocess.run(command, capture_output=True, text=True)


@pytest.fixture(scope="module")
def table(tmp_path_factory):
    """Values by (case, section, quantity) of three small cases."""
    out = tmp_path_factory.mktemp("benchmark")
    done = run("--only", "bulk, own templates", "dense", "rigid", f"--out={out}", "--name=here")
    assert done.returncode == 0, done.stderr
    with open(out / "here.csv") as file:
        rows = list(csv.DictReader(file))
    assert (out / "here.md").read_text().count("| updateForces |") == 2
    return {(r["case"], r["section"], r["quantity"]): r["value"] for r in rows}


def test_limits_of_the_machine_are_known(table):
    assert table["machine", "limits", "instruction_set"].startswith("x86-64")
    assert float(table["machine", "limits", "peak_gflops"]) > 0


def test_work_is_listed_and_grains_apart_have_no_contact(table):
    def work(case, name):
        return float(table[case, "work a step", name])

    apart = "bulk, own templates"
    assert work(apart, "pointsUpdated") > 0
    assert work(apart, "pairsSearched") == work(apart, "contactsSwept") == 0
    assert work("dense", "contactsSwept") > work("dense", "totalSweeps") > 0


def test_soft_grains_have_phases_and_rigid_ones_engines(table):
    def phases(case):
        return {name for c, section, name in table if (c, section) == (case, "phases, ms a step")}

    assert phases("rigid") == YADE_ENGINES | {"outside the engines"}
    assert phases("rigid") | {"findContacts", "updateForces", "solve"} <= phases("dense")


def test_soft_is_compared_with_rigid(table):
    comparisons = {name for case, _, name in table if case == "compared"}
    assert {
        f"soft over rigid, a {per}, 1 thread(s)" for per in ("grain and step", "simulated second")
    } == comparisons


def test_what_cannot_be_is_refused():
    assert "invalid choice" in run("--only", "bulge").stderr
    assert "'0' is not a whole number in [1, inf)" in run("--threads", "0").stderr
