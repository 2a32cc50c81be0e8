"""scripts/hertz.py: a disk between two plates against converged finite elements."""

import numpy as np
import pytest
from matplotlib.image import imread
from runs import errors, run_case

from softgrain import finite_elements

ARRAYS = (
    "delta_over_D",
    "force_over_ED",
    "force_top_over_ED",
    "force_bottom_over_ED",
    "contact_halfwidth_over_D",
    "kinetic_over_elastic",
)


def press(folder, *options):
    return run_case("hertz", folder, *options)


def force_errors(result, condition="plane_strain", start=0.05):
    curve = finite_elements.disk_between_plates(condition)
    return errors(result, curve, "delta_over_D", start=start)


def width_errors(result, start):
    curve = finite_elements.disk_between_plates("plane_strain")
    return errors(result, curve, "delta_over_D", "contact_halfwidth_over_D", start)


def pressure_errors(result, start):
    """Root mean square deviation of each profile from Hertz's ellipse with the peak and the width
    of the finite elements, over the peak."""
    curve = finite_elements.disk_between_plates("plane_strain")
    found = []
    for profile in result["pressure_profiles"]:
        delta = profile["delta_over_D"]
        if delta < start:
            continue
        peak, width = (
            finite_elements.interpolated([delta], curve.delta_over_D, curve[name])[0]
            for name in ("peak_pressure_over_E", "contact_halfwidth_over_D")
        )
        x = np.array(profile["position_over_D"]) / width
        inside = np.abs(x) < 1
        ellipse = np.sqrt(1 - x[inside] ** 2)
        found.append(
            np.sqrt(np.mean((np.array(profile["pressure_over_E"])[inside] / peak - ellipse) ** 2))
        )
    return np.array(found)


def test_force_of_the_surface_geometry(tmp_path):
    """Force within 1 % of finite elements, width and pressure close; all results are there."""
    result = press(tmp_path, "--zeta", "0.1", "--contact", "surface")
    assert {len(result[name]) for name in ARRAYS} == {len(result["delta_over_D"])}
    assert result["wall_seconds"] > 0 and result["steps"] > 1000 and 1e-6 < result["dt"] < 1e-4
    assert 0.195 < result["delta_over_D"][-1] < 0.205
    assert (np.diff(result["delta_over_D"]) > 0).all()
    assert np.abs(force_errors(result, start=0.03)).max() < 0.01
    assert np.abs(width_errors(result, start=0.05)).max() < 0.03
    assert len(result["pressure_profiles"]) == 5
    assert pressure_errors(result, start=0.09).max() < 0.08
    assert result["kinetic_over_elastic"][-1] < 3e-3
    mean = 0.5 * (result["force_top_over_ED"] + result["force_bottom_over_ED"])
    np.testing.assert_allclose(mean, result["force_over_ED"], rtol=1e-12)
    late = result["delta_over_D"] > 0.05
    np.testing.assert_allclose(
        result["force_top_over_ED"][late], result["force_bottom_over_ED"][late], rtol=0.03
    )
    height, width, _ = imread(tmp_path / "force.png").shape
    assert height >= 600 and width >= 800


def test_plane_stress(tmp_path):
    """Softer than plane strain, and within 1 % of its own curve."""
    result = press(tmp_path, "--zeta", "0.1", "--condition", "plane_stress", "--until", "0.1")
    assert np.abs(force_errors(result, "plane_stress")).max() < 0.01
    assert force_errors(result, "plane_strain")[-1] < -0.15


@pytest.mark.parametrize(
    "method, limit",
    [(("--velocity-update", "flip"), 0.02), (("--formulation", "updated"), 0.025)],
    ids=("flip", "updated"),
)
def test_other_methods(tmp_path, method, limit):
    """The classical cycle and the updated Lagrangian method, a little further off."""
    result = press(tmp_path, "--zeta", "0.1", "--speed", "0.1", *method)
    assert np.abs(force_errors(result)).max() < limit
    assert np.abs(force_errors(result)).mean() < 0.6 * limit


def test_result_does_not_depend_on_units(tmp_path):
    """Everything scales with the modulus, the diameter and the speed of waves."""
    common = ("--zeta", "0.25", "--until", "0.05")
    one = press(tmp_path, *common)
    # the wave speed is twice that of the first, and so is the speed of the plate
    other = press(
        tmp_path,
        *common,
        "--young",
        "8e6",
        "--density",
        "2000",
        "--diameter",
        "1.0",
        "--speed",
        "0.04"
    )
    assert other["steps"] == pytest.approx(one["steps"], abs=1)
    np.testing.assert_allclose(other["delta_over_D"], one["delta_over_D"], rtol=1e-3)
    np.testing.assert_allclose(other["force_over_ED"], one["force_over_ED"], rtol=2e-2, atol=1e-4)


def test_points_geometry_is_stiffer(tmp_path):
    """The bumpy surface of the paper overestimates the force."""
    result = press(tmp_path, "--zeta", "0.2", "--contact", "points", "--until", "0.08")
    assert 0.1 < force_errors(result).mean() < 2


def test_nodes_geometry_is_stiffer_still(tmp_path):
    """Contact on a common grid acts a part of a grid step before the outlines touch."""
    result = press(tmp_path, "--zeta", "0.2", "--contact", "nodes", "--until", "0.08")
    assert 0.2 < force_errors(result).mean() < 4


@pytest.mark.parametrize("orientation", ("0", "17"))
@pytest.mark.parametrize("condition", ("plane_strain", "plane_stress"))
def test_fine(tmp_path, condition, orientation):
    """At zeta = 0.05 within 0.5 % from delta/D = 0.03 to 0.3, however the grid lies."""
    options = ("--condition", condition, "--orientation", orientation, "--until", "0.3")
    result = press(tmp_path, "--zeta", "0.05", *options)
    assert np.abs(force_errors(result, condition, start=0.03)).max() < 0.005


def test_converges(tmp_path):
    """Half the spacing: closer to finite elements."""
    mean = []
    for zeta in ("0.2", "0.1", "0.05"):
        found = force_errors(press(tmp_path, "--zeta", zeta), start=0.03)
        mean.append(np.abs(found).mean())
    assert mean[2] < mean[1] < mean[0]
