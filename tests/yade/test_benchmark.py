"""The benchmark of all scenes runs, and its table has the work of each of them."""

import csv
import math
import subprocess
import sys
from pathlib import Path

import pytest
from benchmark.run import ONE_STEP, OWN_STEPS, cases

PROGRAM = Path(__file__).resolve().parents[2] / "scripts" / "benchmark" / "run.py"
YADE_ENGINES = {"ForceResetter", "InsertionSortCollider", "InteractionLoop", "NewtonIntegrator"}
COMPUTED, SKIPPED = "at rest, all computed", "at rest, skipped"
CHOSEN = ("bulk, own templates", "dense", "rigid", COMPUTED, SKIPPED, ONE_STEP, OWN_STEPS)


def run(*arguments):
    command = [sys.executable, str(PROGRAM), "--quick", *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=1800)


def table_of(names, out):
    """Values by (case, section, quantity) of some cases, each of which has a column."""
    done = run("--only", *names, f"--out={out}", "--name=here")
    assert done.returncode == 0, done.stderr
    heads = [line for line in (out / "here.md").read_text().splitlines() if line[:4] == "| | "]
    columns = {cell.strip() for head in heads for cell in head.split("|")} - {""}
    assert columns == {f"{name} (1)" for name in names}
    with open(out / "here.csv") as file:
        return {(r["case"], r["section"], r["quantity"]): r["value"] for r in csv.DictReader(file)}


@pytest.fixture(scope="module")
def table(tmp_path_factory):
    return table_of(CHOSEN, tmp_path_factory.mktemp("benchmark"))


def test_limits_of_the_machine_are_known(table):
    assert table["machine", "limits", "instruction_set"].startswith("x86-64")
    assert float(table["machine", "limits", "peak_gflops"]) > 0


def work(table, case, name):
    return float(table[case, "work a step", name])


def test_work_is_listed_and_grains_apart_have_no_contact(table):
    apart = "bulk, own templates"
    assert work(table, apart, "pointsUpdated") > 0
    assert work(table, apart, "pairsSearched") == work(table, apart, "contactsSwept") == 0
    assert work(table, "dense", "contactsSwept") > work(table, "dense", "totalSweeps") > 0


def test_one_active_grain_in_a_hundred_costs_one_in_a_hundred_point_updates(table):
    skipped, computed = (work(table, case, "pointsUpdated") for case in (SKIPPED, COMPUTED))
    assert 0 < skipped < 0.02 * computed


def test_steps_of_their_own_save_point_updates(table):
    """4.9 times up to the measured steps, 5.1 in these."""

    def before(case):
        return float(table[case, "figures", "point updates before, millions"])

    def points(case):
        return sum(work(table, case, name) for name in ("pointsUpdated", "pointsMeasured"))

    for updates in (before, points):
        assert 0 < 4.5 * updates(OWN_STEPS) < updates(ONE_STEP)


def test_soft_grains_have_phases_and_rigid_ones_engines(table):
    def phases(case):
        return {name for c, section, name in table if (c, section) == (case, "phases, ms a step")}

    assert phases("rigid") == YADE_ENGINES | {"outside the engines"}
    assert phases("rigid") | {"findContacts", "updateForces", "solve"} <= phases("dense")


def test_soft_is_compared_with_rigid(table):
    comparisons = {name for case, _, name in table if case == "compared"}
    assert {
        f"soft over rigid, a {per}, 1 thread(s)" for per in ("grain and step", "simulated second")
    } <= comparisons


def test_what_cannot_be_is_refused():
    assert "invalid choice" in run("--only", "bulge").stderr
    assert "'0' is not a whole number in [1, inf)" in run("--threads", "0").stderr


@pytest.mark.slow
def test_every_case_has_finite_figures(tmp_path):
    names = [case.name for case in cases()]
    table = table_of(names, tmp_path)
    assert {case for case, _, _ in table} == {"machine", "compared", *names}
    del table["machine", "limits", "instruction_set"]
    assert all(math.isfinite(float(value)) for value in table.values())
