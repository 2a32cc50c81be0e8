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

    tolerance: float = 1e-2  #: residual at which the sweeps end
    max_sweeps: int = 100
    overlap_relaxation: float = 0.1  #: share of an overlap that is worked off per step
    overlap_speed: float = np.inf  #: cap on the speed of that, m/s


@dataclass
class SolverReport:
    """What the sweeps came to."""

    sweeps: int = 0
    residual: float = 0.0  #: of the impulses found


#: Sweeps of every step, so many backwards and then so many forwards.
SWEEPS_EACH_WAY = 2

#: Overlaps up to this share of dr are left as they are.
RESTING_OVERLAP = 1e-3


def closing_bias(gap, point_spacing, dt, settings):
    """b [m/s]: a gap may close within the step; an overlap opens at a capped speed."""
    if gap >= 0:
        return gap / dt
    excess = min(gap + RESTING_OVERLAP * point_spacing, 0.0)
    return max(settings.overlap_relaxation * excess / dt, -settings.overlap_speed)


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


def solved_impulse(r, u, normal, bias, friction, W):
    """Impulse that solves one contact exactly, the others held; u [m/s] is with the present r."""
    return project_on_cone(r - (u + bias * normal) / W, normal, friction)


def residual(delassus, free_velocity, normal, bias, friction, impulse):
    """How far impulses are from a solution: the natural map in the energy norm.

    With rho_k the change of r_k that would solve contact k alone,
    sqrt(sum W |rho|^2 / max(sum W |r|^2, sum W |r + rho|^2)); 0 where both sums are.

    Args:
        delassus (ndarray): W [1/kg], shape (contacts, contacts).
        free_velocity (ndarray): relative velocities without impulses [m/s], shape (contacts, dim).
        normal (ndarray): shape (contacts, dim).
        bias (ndarray): b [m/s], shape (contacts,).
        friction (ndarray): coefficients mu, shape (contacts,).
        impulse (ndarray): r [N s], shape (contacts, dim).

    Returns:
        float: between 0 and 2 [-].
    """
    W = delassus.diagonal()
    u = free_velocity + delassus @ impulse
    solved = np.array(
        [solved_impulse(*contact) for contact in zip(impulse, u, normal, bias, friction, W)]
    ).reshape(impulse.shape)

    def energy(r):
        return np.sum(W[:, None] * r**2)

    violation = energy(solved - impulse)
    return np.sqrt(violation / max(energy(impulse), energy(solved))) if violation > 0 else 0.0


def solve(delassus, free_velocity, normal, bias, friction, impulse, settings):
    """Nonlinear Gauss-Seidel: sweeps of r_k <- proj(r_k - (u_k + b_k n_k)/W_kk).

    Two sweeps go backwards, all others forwards. After the first two of those the residual is
    measured after each sweep that changes little; they end when it is within the tolerance.

    Args:
        delassus (ndarray): W [1/kg], shape (contacts, contacts).
        free_velocity (ndarray): relative velocities without impulses [m/s], shape (contacts, 2).
        normal (ndarray): shape (contacts, 2).
        bias (ndarray): b [m/s], shape (contacts,).
        friction (ndarray): coefficients mu, shape (contacts,).
        impulse (ndarray): start of the sweeps, within the cones [N s], shape (contacts, 2);
            becomes the result.
        settings (SolverSettings): when to stop.

    Returns:
        SolverReport: number of sweeps, residual.
    """
    report = SolverReport()
    if len(impulse) == 0:
        return report
    problem = (delassus, free_velocity, normal, bias, friction)
    while report.sweeps < settings.max_sweeps:
        forwards = range(len(impulse))
        order = forwards[::-1] if report.sweeps < SWEEPS_EACH_WAY else forwards
        change = sweep(*problem, impulse, order)
        report.sweeps += 1
        enough = report.sweeps >= 2 * SWEEPS_EACH_WAY and change <= 2 * settings.tolerance
        if enough or report.sweeps == settings.max_sweeps:
            report.residual = residual(*problem, impulse)
            if report.residual <= settings.tolerance:
                break
    return report


def sweep(delassus, free_velocity, normal, bias, friction, impulse, order):
    """Solve each contact in turn; returns the relative change of the impulses, in energy norm."""
    changed = total = 0.0
    for k in order:
        W = delassus[k, k]
        u = free_velocity[k] + delassus[k] @ impulse
        r = solved_impulse(impulse[k], u, normal[k], bias[k], friction[k], W)
        changed += W * np.sum((r - impulse[k]) ** 2)
        total += W * np.sum(r**2)
        impulse[k] = r
    if changed == 0:
        return 0.0
    return np.sqrt(changed / total) if total > 0 else np.inf
