"""Signorini's and Coulomb's conditions at velocity level, by nonlinear Gauss-Seidel.

For each contact, with u the relative velocity at the end of the step and r its impulse,
    0 <= u_n + b  _|_  r_n >= 0,     |r_t| <= mu r_n, sliding opposite to u_t at the bound.
All contacts are coupled by u = u_free + W r, with W = H M^-1 H^T the Delassus operator. Masses are
the same in all directions, so W acts alike on each component.
"""

from dataclasses import dataclass

import numpy as np


@dataclass
class SolverSettings:
    """When the sweeps end and how overlaps are worked off."""

    tolerance: float = 1e-2  #: relative change of the impulses in a sweep, in the norm sum W r^2
    max_sweeps: int = 100
    overlap_relaxation: float = 0.1  #: share of an overlap that is worked off per step
    overlap_speed: float = np.inf  #: cap on the speed of that, m/s


@dataclass
class SolverReport:
    """What the sweeps came to."""

    sweeps: int = 0
    change: float = 0.0  #: relative change of the impulses in the last sweep


def closing_bias(gap, dt, settings):
    """b [m/s]: a gap may close within the step; an overlap opens at a capped speed."""
    if gap >= 0:
        return gap / dt
    return max(settings.overlap_relaxation * gap / dt, -settings.overlap_speed)


def project_on_cone(r, normal, friction):
    """Impulse of Coulomb's cone next to r: normal part first, then the tangential one is cut."""
    r_n = r @ normal
    if r_n <= 0:
        return np.zeros_like(r)
    tangential = r - r_n * normal
    size = np.linalg.norm(tangential)
    if size <= friction * r_n:
        return r
    return r_n * normal + friction * r_n / size * tangential


def solve(delassus, free_velocity, normal, bias, friction, impulse, settings):
    """Nonlinear Gauss-Seidel: sweeps of r_k <- proj(r_k - (u_k + b_k n_k)/W_kk).

    Sweeps go forwards and backwards in turn and end when one changes little.

    Args:
        delassus (ndarray): W [1/kg], shape (contacts, contacts).
        free_velocity (ndarray): relative velocities without impulses [m/s], shape (contacts, 2).
        normal (ndarray): shape (contacts, 2).
        bias (ndarray): b [m/s], shape (contacts,).
        friction (ndarray): coefficients mu, shape (contacts,).
        impulse (ndarray): start of the sweeps [N s], shape (contacts, 2); becomes the result.
        settings (SolverSettings): when to stop.

    Returns:
        SolverReport: number of sweeps, last change.
    """
    report = SolverReport()
    if len(impulse) == 0:
        return report
    for k in range(len(impulse)):
        impulse[k] = project_on_cone(impulse[k], normal[k], friction[k])
    order = range(len(impulse))
    while report.sweeps < settings.max_sweeps:
        changed = total = 0.0
        for k in order if report.sweeps % 2 == 0 else reversed(order):
            W = delassus[k, k]
            u = free_velocity[k] + delassus[k] @ impulse
            r = project_on_cone(impulse[k] - (u + bias[k] * normal[k]) / W, normal[k], friction[k])
            changed += W * np.sum((r - impulse[k]) ** 2)
            total += W * np.sum(r**2)
            impulse[k] = r
        report.sweeps += 1
        report.change = np.sqrt(changed / total) if total > 0 else np.sqrt(changed)
        if report.change <= settings.tolerance:
            break
    return report
