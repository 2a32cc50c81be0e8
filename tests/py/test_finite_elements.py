"""The finite-element curves that come with the package."""

import numpy as np
import pytest

from softgrain import finite_elements


def force(condition, delta):
    curve = finite_elements.disk_between_plates(condition)
    return np.interp(delta, curve.delta_over_D, curve.force_over_ED)


@pytest.mark.parametrize("delta, expected", [(0.05, 0.01989), (0.1, 0.04921), (0.2, 0.13548)])
def test_plane_strain(delta, expected):
    assert force("plane_strain", delta) == pytest.approx(expected, abs=6e-6)


@pytest.mark.parametrize(
    "condition, modulus", [("plane_strain", 1 / (1 - 0.45**2)), ("plane_stress", 1.0)]
)
def test_line_contact(condition, modulus):
    """At small strain: delta/D = 2f/pi (ln(2 pi/f) - 1), f = F/(E* D)."""
    delta = 0.002
    f = force(condition, delta) / modulus
    assert 2 * f / np.pi * (np.log(2 * np.pi / f) - 1) == pytest.approx(delta, rel=0.01)


@pytest.mark.parametrize("condition", ("plane_strain", "plane_stress"))
def test_curve(condition):
    """Monotonic, and far enough for all cases."""
    curve = finite_elements.disk_between_plates(condition)
    assert (np.diff(curve.delta_over_D) > 0).all() and (np.diff(curve.force_over_ED) > 0).all()
    assert curve.delta_over_D[0] <= 0.002 and curve.delta_over_D[-1] >= 0.25
    assert (np.diff(curve.contact_halfwidth_over_D) > 0).all()
    assert curve.deformed_area_over_D2[0] == pytest.approx(np.pi / 4, rel=1e-3)


def test_unknown_condition():
    with pytest.raises(
        ValueError, match="condition = 'flat' is unknown.*'plane_strain', 'plane_stress'"
    ):
        finite_elements.disk_between_plates("flat")
