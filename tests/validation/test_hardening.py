"""scripts/harden_packing.py: forces on walls go on when grains of a packing are turned rigid."""

import numpy as np
import pytest
from runs import run_case


def treatments(folder, *options):
    result = run_case("harden_packing", folder, *options)
    assert result["kinetic_over_elastic"] < 1e-3 and len(result["hardened"]) >= 2
    return {(t["into"], t.get("error")): t for t in result["treatments"]}


@pytest.mark.slow
def test_among_soft_grains(tmp_path):
    """Clumps and fixed grains that soft ones surround, between walls that stand still."""
    found = treatments(tmp_path, "--errors", "0.01", "0.05")
    assert found["clumps", 0.01]["largest_change"] < 0.01
    assert found["fixed", None]["largest_change"] < 0.01
    assert found["clumps", 0.05]["largest_change"] < 0.05
    assert found["clumps", 0.01]["largest_change_on_the_way"] < 0.05
    assert "stopped" in found["spheres", None]  # they would overlap too much


@pytest.mark.slow
def test_under_held_stress(tmp_path):
    """Every second grain a clump: rigid ones touch each other and walls, which give way."""
    options = ("--which", "half", "--walls", "held", "--errors", "0.01")
    clumps = treatments(tmp_path, *options)["clumps", 0.01]
    assert abs(clumps["mean_change"]) < 0.04
    assert np.abs(clumps["strain"]).max() < 1e-3
