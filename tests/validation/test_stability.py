"""scripts/benchmark/stability.py: every case runs or stops with a message that helps."""

import json

import pytest
from runs import SCRIPTS, run_to_end

#: Words in the messages of the values that stop, by study; all others run.
STOPS = {
    "time_step": {1.1: "(0, 1]", 1.2: "(0, 1]"},
    "own_step": dict.fromkeys((0.9, 1.0, 1.1, 1.2), "sg.set_time_step()"),
    "poisson_plane_strain": {-0.7: "smaller zeta", 0.5: "poisson = 0.5"},
    "poisson_plane_stress": dict.fromkeys((-0.5, -0.4), "no thickness"),
    "distance": dict.fromkeys((1e9, 1e12), "radii from the origin"),
}
FAST = ("ripples", "trembling", "poisson_plane_stress", "friction", "distance")
SLOW = (
    "time_step",
    "ripples",
    "own_step",
    "distance",
    "units",
    "poisson_plane_stress",
    "wall_speed",
    "impact_speed",
    "friction",
    "trembling",
    "poisson_plane_strain",
    "poisson_projected",
    "stiffness_ratio",
    "size_ratio",
    "size_ratio_equal_spacing",
    "density_ratio",
    "density_impact",
    "packing",
    "undamped",
    "multirate",
)


def test_every_study_is_made(monkeypatch):
    monkeypatch.syspath_prepend(SCRIPTS / "benchmark")
    import stability

    assert {*SLOW, "at_rest"} == set(stability.STUDIES)


def make(studies, folder, *options):
    """Rows of each study, and the report of all, as the script writes them."""
    run_to_end("benchmark/stability.py", folder, "--only", *studies, *options)
    for name in ("stability.csv", "stability.md", "stability.png"):
        assert (folder / name).stat().st_size > 0
    return {study: json.loads((folder / f"{study}.json").read_text()) for study in studies}


def check(study, rows):
    """No case is wrong, and those that must stop do, with their words."""
    expected = STOPS.get(study, {})
    for row in rows:
        told = f"{study} {row['value']}: {row['outcome']} {row['message']} {row['figures']}"
        words = expected.get(row["value"])
        assert row["outcome"] == ("runs" if words is None else "stops"), told
        assert words is None or words in row["message"], told


@pytest.mark.parametrize("study", FAST)
def test_study_in_short(study, tmp_path):
    check(study, make([study], tmp_path, "--quick")[study])


def test_several_studies_in_processes_of_their_own(tmp_path):
    for study, rows in make(["time_step", "own_step", "units"], tmp_path, "--quick").items():
        check(study, rows)


@pytest.mark.slow
@pytest.mark.parametrize("study", SLOW)
def test_study(study, tmp_path):
    check(study, make([study], tmp_path)[study])


@pytest.mark.slow
def test_at_rest(tmp_path):
    check("at_rest", make(["at_rest"], tmp_path)["at_rest"])
