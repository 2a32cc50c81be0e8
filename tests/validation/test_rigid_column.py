"""scripts/rigid_column.py: columns of rigid disks that collapse."""

import pytest
from runs import run_case


def test_small(tmp_path):
    """The taller the further, about as far as by YADE's linear law: see doc/validation.md."""
    sizes = ("--aspects", "1", "3", "--linear", "1", "--width", "6")
    low, tall = run_case("rigid_column", tmp_path, *sizes)["cases"]
    assert 0.6 < low["nonsmooth"]["run_out"] < 2.5
    assert low["nonsmooth"]["run_out"] == pytest.approx(low["linear"]["run_out"], rel=0.5)
    assert 2 < tall["nonsmooth"]["run_out"] / low["nonsmooth"]["run_out"] < 5
    for case in (low, tall):
        assert case["nonsmooth"]["kinetic_over_m_g_H0"] < 1e-4
        assert case["nonsmooth"]["largest_overlap_over_R"] < 0.05
    assert (tmp_path / "rigid_column.png").stat().st_size > 10000
