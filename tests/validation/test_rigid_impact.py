"""scripts/rigid_partners.py: a rigid partner is the limit of stiff soft ones."""

import numpy as np
import pytest
from runs import run_case


@pytest.mark.slow
def test_rigid_partners(tmp_path):
    result = run_case("rigid_partners", tmp_path, "--zeta", "0.2")
    rigid, *_, stiff = result["impact"]
    assert rigid["partner"] == "rigid" and "1e+09" in stiff["partner"]
    np.testing.assert_allclose(rigid["velocity"], stiff["velocity"], atol=0.03)
    packing = result["packing"]
    assert packing["capped_steps"] == 0
    assert packing["largest_residual"] <= 0.01
    assert packing["largest_overlap_over_dr"] < 0.1
