"""scripts/periodic_lattice.py and periodic_shear.py: lattices against finite elements, work of the
cell, stress held while it shears."""

import numpy as np
import pytest
from matplotlib.image import imread
from runs import run_case


@pytest.mark.parametrize("lattice", ("square", "triangular"))
def test_lattice(tmp_path, lattice):
    result = run_case("periodic_lattice", tmp_path, "--lattice", lattice, "--zeta", "0.2")
    assert result["error_max"] < 0.05
    check_stresses(result, isotropy=0.04)


@pytest.mark.slow
@pytest.mark.parametrize("lattice", ("square", "triangular"))
def test_fine_lattice(tmp_path, lattice):
    result = run_case("periodic_lattice", tmp_path, "--lattice", lattice, "--zeta", "0.1")
    assert result["error_max"] < 0.015
    check_stresses(result, isotropy=0.01)


def check_stresses(result, isotropy):
    """Isotropic up to where the surface nodes lie, the same by contacts and by grains; the cell
    does the work of the stress."""
    late = result["wall_displacement_over_D"] >= 0.01
    assert late.sum() > 3 and result["wall_displacement_over_D"][-1] > 0.05
    np.testing.assert_allclose(result["stress_xx"][late], result["stress_yy"][late], rtol=isotropy)
    np.testing.assert_allclose(result["stress_xy"], 0, atol=1e-3 * abs(result["stress_xx"][-1]))
    assert result["grains_against_contacts_max"] < 0.01
    assert abs(result["work_against_stress"]) < 2e-3
    assert result["energy_error"] < 1e-3


@pytest.mark.slow
def test_shear(tmp_path):
    result = run_case("periodic_shear", tmp_path)
    assert result["normal_stress_error_rms"] < 0.005
    late = result["shear"] > 0.2
    assert result["stress_xy_over_target"][late].mean() == pytest.approx(0.26, rel=0.3)
    assert result["largest_overlap_over_dr"] < 0.2
    height, width, _ = imread(tmp_path / "packing.png").shape
    assert height > 600 and width > 600
