"""scripts/rigid_packing.py: rigid grains prepared by contact dynamics come to rest."""

import pytest
from runs import run_case


def check_box(box):
    kinetic = box["kinetic_over_m_g_R"]
    assert kinetic[-1] < 1e-4 and kinetic[-1] < 1e-2 * kinetic[0]
    assert box["median_creep_over_R"] < 1e-5
    assert box["reaction_over_weight"] == pytest.approx(1, rel=1e-3)
    # while it is poured the residual, over what is exchanged, is not always reached
    assert box["capped_steps"] < 0.02 * box["steps"]
    assert box["residual"] <= 0.01
    assert box["sweeps_per_step_at_rest"] < 6
    assert box["largest_overlap_over_R"] < 5e-3


def check_squeeze(cases):
    nonsmooth, linear = cases
    assert nonsmooth["unbalanced_force"] < 1e-3 and linear["unbalanced_force"] < 1e-3
    assert nonsmooth["packing_fraction"] == pytest.approx(linear["packing_fraction"], abs=0.02)
    assert nonsmooth["contacts_per_disk"] == pytest.approx(linear["contacts_per_disk"], abs=0.3)
    assert nonsmooth["largest_overlap_over_R"] < 1e-3
    assert nonsmooth["steps"] < 0.3 * linear["steps"]


def check_cells(cells, scatter):
    """Jammed where packings without friction do, looser with it; `scatter`: of small ones."""
    phi = {}
    for cell in cells:
        assert cell["error_of_stress"] < 0.02 and cell["unbalanced_force"] < 2e-3
        assert cell["largest_overlap_over_R"] < 2e-3
        phi[cell["dim"], bool(cell["mu"])] = cell["packing_fraction"]
        if not cell["mu"]:  # twice as many contacts as degrees of freedom of what bears, or nearly
            isostatic = 2 * cell["dim"]
            assert cell["contacts_per_bearing_grain"] == pytest.approx(isostatic, rel=0.12)
    assert phi[2, False] == pytest.approx(0.84, abs=0.01 + scatter)
    assert phi[3, False] == pytest.approx(0.64, abs=0.01 + scatter)
    assert phi[2, True] < phi[2, False] - 0.01 and phi[3, True] < phi[3, False] - 0.01


def test_small(tmp_path):
    sizes = ("--spheres", "200", "--disks", "100", "--in-cell", "60")
    result = run_case("rigid_packing", tmp_path, *sizes)
    check_cells(result["cell"], 0.02)
    check_box(result["box"])
    check_squeeze(result["squeeze"])


@pytest.mark.slow
def test_two_thousand_spheres(tmp_path):
    result = run_case("rigid_packing", tmp_path)
    check_cells(result["cell"], 0)
    check_box(result["box"])
    check_squeeze(result["squeeze"])
