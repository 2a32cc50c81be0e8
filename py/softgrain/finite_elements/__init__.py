"""Converged finite-element solutions to compare with; each file names its case and source.

All quantities are dimensionless: lengths over the diameter D, stresses over Young's modulus E,
forces over E D (per unit of reference thickness). Poisson's ratio is 0.45.
"""

from importlib import resources

import numpy as np
from scipy.interpolate import CubicSpline

#: Poisson's ratio of all curves.
POISSON = 0.45


def disk_between_plates(condition):
    """Disk between two frictionless plates, neo-Hookean, Poisson's ratio 0.45.

    Args:
        condition (str): 'plane_strain' or 'plane_stress'.

    Returns:
        numpy record array: delta_over_D (total approach of the plates), force_over_ED,
        contact_halfwidth_over_D, peak_pressure_over_E (Cauchy stress in the middle of the contact),
        deformed_area_over_D2; all dimensionless.

    Raises:
        ValueError: unknown condition.
    """
    if condition not in ("plane_strain", "plane_stress"):
        raise ValueError(
            f"condition = {condition!r} is unknown; known: 'plane_strain', 'plane_stress'"
        )
    return _curve(f"disk_{condition}")


def square_cell():
    """Disk in a square box, its four frictionless walls moving in by w each; plane strain.

    Returns:
        numpy record array: wall_displacement_over_D (w), phi (present area of the disk over that of
        the box), phi0 (undeformed area over it), force_over_ED (on one wall),
        contact_halfwidth_over_D, deformed_area_over_D2; all dimensionless.
    """
    return _curve("square_cell")


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


def _curve(name):
    with (resources.files(__name__) / f"{name}_nu0.45.csv").open() as lines:
        rows = [line for line in lines if not line.startswith("#")]
    return np.genfromtxt(rows, delimiter=",", names=True).view(np.recarray)
