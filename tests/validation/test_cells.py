"""scripts/square_cell.py and hexagonal_cell.py: lattices of disks against finite elements."""

import numpy as np
import pytest
from matplotlib.image import imread
from runs import errors, run_case

from softgrain import finite_elements

ARRAYS = (
    "phi",
    "phi0",
    "wall_displacement_over_D",
    "force_over_ED",
    "contact_halfwidth_over_D",
    "kinetic_over_elastic",
)


def check_results(folder, result, phi):
    """What must hold for both cells."""
    assert {len(result[name]) for name in ARRAYS} == {len(result["phi"])}
    assert result["steps"] > 500 and result["wall_seconds"] > 0 and 1e-6 < result["dt"] < 1e-4
    assert phi - 0.01 < result["phi"][-1] < phi + 0.01
    assert (np.diff(result["phi0"]) > 0).all() and (result["phi0"] > result["phi"]).all()
    height, width, _ = imread(folder / "force.png").shape
    assert height >= 600 and width >= 800


def force_errors(result, curve, start):
    """At equal displacement of the walls."""
    return errors(result, curve, "wall_displacement_over_D", start=start)


@pytest.mark.parametrize("poisson", finite_elements.CELL_POISSON_RATIOS)
def test_square_cell(tmp_path, poisson):
    options = ("--zeta", "0.14", "--until-phi", "0.9", "--poisson", str(poisson))
    result = run_case("square_cell", tmp_path, *options)
    check_results(tmp_path, result, 0.9)
    curve = finite_elements.square_cell(poisson)
    assert np.abs(force_errors(result, curve, start=0.01)).max() < 0.02
    start = curve.wall_displacement_over_D[0]
    areas = errors(result, curve, "wall_displacement_over_D", "phi", start)
    assert np.abs(areas).max() < 1e-3
    walls = [result[f"force_{name}_over_ED"] for name in ("left", "right", "bottom", "top")]
    np.testing.assert_allclose(np.mean(walls, axis=0), result["force_over_ED"], rtol=1e-12)
    late = result["phi"] > 0.85
    np.testing.assert_allclose(np.std(walls, axis=0)[late], 0, atol=0.01 * walls[0][late].min())


def test_hexagonal_cell(tmp_path):
    """Six equal forces between real neighbours."""
    result = run_case("hexagonal_cell", tmp_path, "--zeta", "0.2", "--until-phi", "0.97")
    check_results(tmp_path, result, 0.97)
    assert result["grains"] == 19
    curve = finite_elements.hexagonal_cell()
    assert np.abs(force_errors(result, curve, start=0.01)).max() < 0.05
    six = result["neighbour_forces_over_ED"]
    assert six.shape == (len(result["phi"]), 6)
    np.testing.assert_allclose(six.mean(axis=1), result["force_over_ED"], rtol=1e-12)
    late = result["wall_displacement_over_D"] > 0.01
    assert (six.std(axis=1) / six.mean(axis=1))[late].max() < 0.02


@pytest.mark.parametrize("orientation", ("0", "17"))
def test_fine_square_cell(tmp_path, orientation):
    """At zeta = 0.05 within 1 % up to phi = 0.98, at equal displacement and at equal phi."""
    options = ("--zeta", "0.05", "--orientation", orientation)
    result = run_case("square_cell", tmp_path, *options)
    curve = finite_elements.square_cell()
    assert np.abs(force_errors(result, curve, start=0.01)).max() < 0.01
    equal_phi = errors(result, curve, "phi", start=0.81, end=0.97)
    assert np.abs(equal_phi).max() < 0.01


def test_fine_hexagonal_cell(tmp_path):
    """At zeta = 0.05 within 1 %, at equal displacement and at equal phi, once the contacts are four
    spacings of material points wide; within 0.5 % from six on."""
    result = run_case("hexagonal_cell", tmp_path, "--zeta", "0.05")
    curve = finite_elements.hexagonal_cell()
    assert np.abs(force_errors(result, curve, start=0.005)).max() < 0.01
    assert np.abs(force_errors(result, curve, start=0.01)).max() < 0.005
    assert np.abs(errors(result, curve, "phi", start=0.923)).max() < 0.01
    widths = errors(
        result, curve, "wall_displacement_over_D", "contact_halfwidth_over_D", start=0.01
    )
    assert np.abs(widths).max() < 0.015
