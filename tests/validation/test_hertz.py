"""scripts/hertz.py: a disk between two plates against converged finite elements."""

import json
import subprocess
from pathlib import Path

import numpy as np
import pytest
from matplotlib.image import imread

from softgrain import finite_elements

SCRIPT = Path(__file__).resolve().parents[2] / "scripts" / "hertz.py"
ARRAYS = ("delta_over_D", "force_over_ED", "force_top_over_ED", "force_bottom_over_ED")


def press(folder, *options):
    """Run the case; returns its result with arrays for lists."""
    process = subprocess.run(
        ["/usr/bin/yade", "-n", "-x", "-j1", str(SCRIPT), "--out", str(folder), *options],
        capture_output=True,
        text=True,
        timeout=1200,
        cwd=folder,
    )
    assert process.returncode == 0, process.stdout + process.stderr
    result = json.loads((folder / "result.json").read_text())
    return {k: np.array(v) if isinstance(v, list) else v for k, v in result.items()}


def errors(result, condition="plane_strain", start=0.05):
    """Relative errors of the force from delta/D = start on."""
    exact = finite_elements.disk_between_plates(condition)
    shown = result["delta_over_D"] >= start
    assert shown.sum() > 5
    expected = np.interp(result["delta_over_D"][shown], exact.delta_over_D, exact.force_over_ED)
    return result["force_over_ED"][shown] / expected - 1


def test_force_of_the_surface_geometry(tmp_path):
    """Within 2 % of finite elements; all results are there."""
    result = press(tmp_path, "--zeta", "0.1", "--contact", "surface")
    assert {len(result[name]) for name in ARRAYS} == {len(result["delta_over_D"])}
    assert result["wall_seconds"] > 0 and result["steps"] > 1000 and 1e-6 < result["dt"] < 1e-4
    assert 0.195 < result["delta_over_D"][-1] < 0.205
    assert (np.diff(result["delta_over_D"]) > 0).all()
    assert np.abs(errors(result)).max() < 0.02
    mean = 0.5 * (result["force_top_over_ED"] + result["force_bottom_over_ED"])
    np.testing.assert_allclose(mean, result["force_over_ED"], rtol=1e-12)
    late = result["delta_over_D"] > 0.05
    np.testing.assert_allclose(
        result["force_top_over_ED"][late], result["force_bottom_over_ED"][late], rtol=0.03
    )
    height, width, _ = imread(tmp_path / "force.png").shape
    assert height >= 600 and width >= 800


def test_plane_stress(tmp_path):
    """Softer than plane strain, and within 2 % of its own curve."""
    result = press(tmp_path, "--zeta", "0.1", "--condition", "plane_stress", "--until", "0.1")
    assert np.abs(errors(result, "plane_stress")).max() < 0.02
    assert errors(result, "plane_strain")[-1] < -0.15


@pytest.mark.parametrize(
    "method, limit",
    [(("--velocity-update", "flip"), 0.02), (("--formulation", "updated"), 0.025)],
    ids=("flip", "updated"),
)
def test_other_methods(tmp_path, method, limit):
    """The classical cycle and the updated Lagrangian method, a little further off."""
    result = press(tmp_path, "--zeta", "0.1", "--speed", "0.1", *method)
    assert np.abs(errors(result)).max() < limit
    assert np.abs(errors(result)).mean() < 0.6 * limit


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
    assert 0.1 < errors(result).mean() < 2


def test_nodes_geometry_is_stiffer_still(tmp_path):
    """Contact on a common grid acts a part of a grid step before the outlines touch."""
    result = press(tmp_path, "--zeta", "0.2", "--contact", "nodes", "--until", "0.08")
    assert 0.2 < errors(result).mean() < 4


@pytest.mark.slow
@pytest.mark.parametrize("condition", ("plane_strain", "plane_stress"))
def test_converges(tmp_path, condition):
    """Half the spacing: closer to finite elements."""
    mean = []
    for zeta in ("0.1", "0.05"):
        found = np.abs(errors(press(tmp_path, "--zeta", zeta, "--condition", condition), condition))
        assert found.max() < 0.02
        mean.append(found.mean())
    assert mean[1] < mean[0]
