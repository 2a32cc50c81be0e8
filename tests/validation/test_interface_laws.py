"""scripts/interfaces.py and scripts/adhesion.py: laws of interfaces against their parameters and
against the theory of adhesive line contact."""

import math

import adhesion
import pytest
from runs import run_case


def test_separation_and_sliding(tmp_path):
    result = run_case("interfaces", tmp_path)
    for row in result["separation"]:
        assert row["stress_over_strength"] == pytest.approx(1, abs=0.05)
        assert row["work_over_energy"] == pytest.approx(1, abs=0.03)
        assert row["energy_error"] < 0.01
        assert row["lost_bonds"] == 0
    for row in result["sliding"]:
        assert 0.7 < row["static"] < 1.01  # its ends slip first
        assert row["dynamic"] == pytest.approx(1, abs=0.03)


def test_adhesive_disk(tmp_path):
    result = run_case("adhesion", tmp_path, "--zeta", "0.1", "0.05", "0.025")
    for row, bound in zip(result["runs"], (0.05, 0.03, 0.015), strict=True):
        assert abs(row["error"]) < bound
        assert row["energy_error"] < 0.01


def test_pull_off_of_stiff_and_soft_disks(tmp_path):
    """Stiff ones let go at a point, which bears 2 sigma across sqrt(2 R delta) on either side; soft
    ones where it bears what Johnson, Kendall and Roberts found."""
    out = ["--out", str(tmp_path)]
    stiff = adhesion.parse_options(["--young", "1e10", *out])
    point = 2 * stiff.cohesion * math.sqrt(2 * stiff.radius * stiff.range)
    assert adhesion.theory(stiff) == pytest.approx(point, rel=1e-3)
    soft = adhesion.parse_options(["--cohesion", "3e5", "--range", "2e-5", *out])
    E, w = soft.young / (1 - soft.poisson**2), soft.cohesion * soft.range
    jkr = adhesion.jkr_force(E, soft.radius, w)
    assert adhesion.theory(soft) == pytest.approx(jkr, rel=5e-3)
