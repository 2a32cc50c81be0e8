"""Converged finite-element solutions to compare with; each file names its case and source.

All quantities are dimensionless: lengths over the diameter D, stresses over Young's modulus E,
forces over E D (per unit of reference thickness).
"""

from importlib import resources

import numpy as np
from scipy.interpolate import CubicSpline

#: Poisson's ratio of the curves, unless another is chosen.
POISSON = 0.45

#: Poisson's ratios of the solutions for a disk in a square box.
CELL_POISSON_RATIOS = (0.2, 0.45)

#: Poisson's ratios of the solutions for a disk between plates.
_POISSON_RATIOS = {"plane_strain": (0.45, 0.49, 0.499), "plane_stress": (0.45,)}


def poisson_ratios(condition):
    """Poisson's ratios that :func:`disk_between_plates` has a solution for."""
    if condition not in _POISSON_RATIOS:
        raise ValueError(
            f"condition = {condition!r} is unknown; known: 'plane_strain', 'plane_stress'"
        )
    return _POISSON_RATIOS[condition]


def disk_between_plates(condition, poisson=POISSON):
    """Disk between two frictionless plates, neo-Hookean.

    Args:
        condition (str): 'plane_strain' or 'plane_stress'.
        poisson (float): Poisson's ratio, one of :func:`poisson_ratios`: 0.45 good to 0.02 %, 0.49
            and 0.499 (plane strain) to about 0.2 %, see the column rel_uncertainty.

    Returns:
        numpy record array: delta_over_D (total approach of the plates), force_over_ED,
        contact_halfwidth_over_D, peak_pressure_over_E (Cauchy stress in the middle of the contact;
        for 0.45 only), deformed_area_over_D2; all dimensionless.

    Raises:
        ValueError: unknown condition, or no solution for this Poisson's ratio.
    """
    _require_solution(poisson, poisson_ratios(condition))
    return _curve(f"disk_{condition}", poisson)


def square_cell(poisson=POISSON):
    """Disk in a square box, its four frictionless walls moving in by w each; plane strain.

    Args:
        poisson (float): Poisson's ratio, one of CELL_POISSON_RATIOS: 0.45 good to 0.02 %, 0.2 to
            about 0.2 % from w = 0.01 D on, see the column rel_uncertainty.

    Returns:
        numpy record array: wall_displacement_over_D (w), phi (present area of the disk over that of
        the box), phi0 (undeformed area over it), force_over_ED (on one wall),
        contact_halfwidth_over_D, deformed_area_over_D2; all dimensionless.

    Raises:
        ValueError: no solution for this Poisson's ratio.
    """
    _require_solution(poisson, CELL_POISSON_RATIOS)
    return _curve("square_cell", poisson)


def hexagonal_cell():
    """Disk between six frictionless walls moving in by w each: the triangular lattice under
    isotropic compression; plane strain. Columns as :func:`square_cell`; the cell's area is
    2 sqrt(3) (D/2 - w)²."""
    return _curve("hexagonal_cell")


def interpolated(x, abscissa, ordinate):
    """A curve at other abscissas, by a cubic spline in the logarithms of both.

    Args:
        x (array): where; within the range of the abscissas, all > 0.
        abscissa, ordinate (array): columns of a curve, all > 0, the abscissa increasing.

    Returns:
        array: ordinates at x.

    Raises:
        ValueError: x is outside the curve.
    """
    x = np.asarray(x, float)
    if x.size and not (abscissa[0] <= x.min() and x.max() <= abscissa[-1]):
        raise ValueError(
            f"x = {x.min():g} .. {x.max():g} is outside the curve, "
            f"[{abscissa[0]:g}, {abscissa[-1]:g}]"
        )
    return np.exp(CubicSpline(np.log(abscissa), np.log(ordinate))(np.log(x)))


def _require_solution(poisson, known):
    if poisson not in known:
        raise ValueError(
            f"poisson = {poisson!r}: there are solutions for {', '.join(map(str, known))}"
        )


def _curve(name, poisson=POISSON):
    with (resources.files(__name__) / f"{name}_nu{poisson}.csv").open() as lines:
        rows = [line for line in lines if not line.startswith("#")]
    return np.genfromtxt(rows, delimiter=",", names=True).view(np.recarray)
