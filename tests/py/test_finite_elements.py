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


@pytest.mark.parametrize(
    "curve, start, closed",
    [
        (finite_elements.square_cell(), np.pi / 4, 0.999),
        (finite_elements.square_cell(0.2), np.pi / 4, 0.98),
        (finite_elements.hexagonal_cell(), np.pi / np.sqrt(12), 0.999),
    ],
    ids=("square", "square, nu = 0.2", "hexagonal"),
)
def test_cells(curve, start, closed):
    """Fractions belong to the displacement, and forces do the work that small strain allows."""
    w = curve.wall_displacement_over_D
    assert (np.diff(w) > 0).all() and (np.diff(curve.force_over_ED) > 0).all()
    np.testing.assert_allclose(curve.phi0, start / (1 - 2 * w) ** 2, rtol=1e-6)
    shrunk = curve.deformed_area_over_D2 / (np.pi / 4)
    np.testing.assert_allclose(curve.phi, curve.phi0 * shrunk, rtol=1e-6)
    assert curve.phi[-1] > closed


def test_interpolated():
    """A power law is met between its points; nothing is made up outside."""
    x = np.linspace(1, 2, 6)
    found = finite_elements.interpolated([1.1, 1.9], x, x**1.5)
    np.testing.assert_allclose(found, np.array([1.1, 1.9]) ** 1.5, rtol=1e-9)
    with pytest.raises(ValueError, match="x = 0.9 .. 1 is outside the curve"):
        finite_elements.interpolated([0.9, 1], x, x)


def test_peak_pressure():
    """Close to Hertz's 2 F/(pi a) where strains are small."""
    curve = finite_elements.disk_between_plates("plane_strain")
    hertz = 2 * curve.force_over_ED / (np.pi * curve.contact_halfwidth_over_D)
    small = curve.delta_over_D <= 0.05
    np.testing.assert_allclose(curve.peak_pressure_over_E[small], hertz[small], rtol=0.02)


def test_unknown_condition():
    with pytest.raises(
        ValueError, match="condition = 'flat' is unknown.*'plane_strain', 'plane_stress'"
    ):
        finite_elements.disk_between_plates("flat")


@pytest.mark.parametrize("poisson, expected", [(0.49, 0.02102), (0.499, 0.02132)])
def test_nearly_incompressible(poisson, expected):
    """Stiffer than nu = 0.45; the area hardly changes."""
    curve = finite_elements.disk_between_plates("plane_strain", poisson)
    assert curve.force_over_ED[curve.delta_over_D == 0.05] == pytest.approx(expected, rel=1e-3)
    assert curve.deformed_area_over_D2.min() > np.pi / 4 * (1 - 2 * (0.5 - poisson))
    assert curve.rel_uncertainty[curve.delta_over_D >= 0.02].max() < 0.005


def test_cell_with_another_poisson():
    """Softer with the smaller ratio; forces of the two finest meshes agree."""
    soft, stiff = finite_elements.square_cell(0.2), finite_elements.square_cell()
    at = np.array([0.01, 0.05, 0.09])
    forces = [
        finite_elements.interpolated(at, c.wall_displacement_over_D, c.force_over_ED)
        for c in (soft, stiff)
    ]
    assert (forces[0] < forces[1]).all()
    assert soft.rel_uncertainty[soft.wall_displacement_over_D >= 0.01].max() < 0.0025


def test_unknown_poisson():
    with pytest.raises(ValueError, match="poisson = 0.3: there are solutions for 0.2, 0.45"):
        finite_elements.square_cell(0.3)
    with pytest.raises(ValueError, match="poisson = 0.3: there are solutions for 0.45, 0.49"):
        finite_elements.disk_between_plates("plane_strain", 0.3)
