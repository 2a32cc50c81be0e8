"""Converged finite-element solutions to compare with; each file names its case and source."""

from importlib import resources

import numpy as np


def disk_between_plates(condition):
    """Disk between two frictionless plates, neo-Hookean, Poisson's ratio 0.45.

    Args:
        condition (str): 'plane_strain' or 'plane_stress'.

    Returns:
        numpy record array: delta_over_D (total approach of the plates), force_over_ED,
        contact_halfwidth_over_D, deformed_area_over_D2; all dimensionless.

    Raises:
        ValueError: unknown condition.
    """
    if condition not in ("plane_strain", "plane_stress"):
        raise ValueError(
            f"condition = {condition!r} is unknown; known: 'plane_strain', 'plane_stress'"
        )
    file = resources.files(__name__) / f"disk_{condition}_nu0.45.csv"
    with file.open() as lines:
        rows = [line for line in lines if not line.startswith("#")]
    return np.genfromtxt(rows, delimiter=",", names=True).view(np.recarray)
