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

    sweeps: float = 0.0  #: visits of contacts over their number
    residual: float = 0.0  #: of the impulses found


#: Sweeps of every step, so many backwards and then so many forwards.
SWEEPS_EACH_WAY = 2

#: Pairs on their own aim at so much of the tolerance; they have at least 2 contacts, and so many.
MARGIN_ALONE = 0.95
MOST_CONTACTS_ALONE = 128

#: They have helped if no more than this share of the residual is left.
FALL_ALONE = 0.5

#: A sweep that changes more, over the tolerance, need not have its residual measured.
CHANGE_PER_RESIDUAL = 2

#: Overlaps up to this share of dr are left as they are.
RESTING_OVERLAP = 1e-3

#: Overlaps from this share of dr on are worked off at full speed in any case.
URGENT_OVERLAP = 0.05

#: Steps after which an entry into the account of a pair is forgotten, and in which overlaps that
#: were there from the start are worked off whatever that gives.
STEPS_OF_ACCOUNT = 10_000


@dataclass
class OverlapAccount:
    """What the overlaps of a pair lately took from its bodies and gave to them."""

    taken: float = 0.0  #: less what was given, J
    grace: int = STEPS_OF_ACCOUNT  #: steps left while overlaps that the pair began with are there

    def is_good(self, credit):
        """Whether overlaps are to be worked off at full speed; so much may be owed [J]."""
        return self.grace > 0 or self.taken > -credit

    def enter(self, given):
        """Enter what each overlap that is to be worked off gave in a step [J]."""
        if self.grace > 0:
            self.grace = self.grace - 1 if given else 0
        else:
            self.taken = (1 - 1 / STEPS_OF_ACCOUNT) * self.taken - sum(given)


def excess_overlap(gap, point_spacing):
    """What is to be worked off of an overlap [m]."""
    return max(-gap - RESTING_OVERLAP * point_spacing, 0.0)


def closing_bias(gap, point_spacing, dt, settings, at_full_speed):
    """b [m/s]: a gap may close within the step; an overlap opens at a capped speed, and slower if
    it is small and came about against no force, so that the account of the pair is not good."""
    if gap >= 0:
        return gap / dt
    excess = excess_overlap(gap, point_spacing)
    if excess == 0:
        return 0.0
    share = 1.0 if at_full_speed else min(excess / (URGENT_OVERLAP * point_spacing), 1.0) ** 3
    return -min(settings.overlap_relaxation * excess / dt, share * settings.overlap_speed)


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
    violation, scale = residual_parts(delassus, free_velocity, normal, bias, friction, impulse)
    return np.sqrt(violation.sum() / scale) if violation.sum() > 0 else 0.0


def residual_parts(delassus, free_velocity, normal, bias, friction, impulse):
    """W |rho|^2 of each contact and what their sum is compared with; arguments as ``residual``.

    Returns:
        tuple: array of shape (contacts,), and a float [J].
    """
    W = delassus.diagonal()
    u = free_velocity + delassus @ impulse
    solved = np.array(
        [solved_impulse(*contact) for contact in zip(impulse, u, normal, bias, friction, W)]
    ).reshape(impulse.shape)

    def energy(r):
        return W * np.sum(r**2, axis=1)

    return energy(solved - impulse), max(energy(impulse).sum(), energy(solved).sum())


def solve(delassus, free_velocity, normal, bias, friction, impulse, pair, settings):
    """Nonlinear Gauss-Seidel: sweeps of r_k <- proj(r_k - (u_k + b_k n_k)/W_kk).

    Two sweeps go backwards, two forwards. While the residual is larger than the tolerance then, the
    pairs in which it sits are solved on their own (``solve_alone``); where that is not enough, a
    sweep forwards follows, and so on. Each time that the pairs on their own do not help, twice as
    many sweeps as before follow.

    Args:
        delassus (ndarray): W [1/kg], shape (contacts, contacts).
        free_velocity (ndarray): relative velocities without impulses [m/s], shape (contacts, 2).
        normal (ndarray): shape (contacts, 2).
        bias (ndarray): b [m/s], shape (contacts,).
        friction (ndarray): coefficients mu, shape (contacts,).
        impulse (ndarray): start of the sweeps, within the cones [N s], shape (contacts, 2);
            becomes the result.
        pair (list): of each contact, what tells its pair of bodies from others.
        settings (SolverSettings): when to stop.

    Returns:
        SolverReport: number of sweeps, residual.
    """
    report = SolverReport()
    if len(impulse) == 0:
        return report
    problem = (delassus, free_velocity, normal, bias, friction)
    forwards = range(len(impulse))
    sweeps = min(2 * SWEEPS_EACH_WAY, settings.max_sweeps)
    visits = sweeps * len(impulse)
    for k in range(sweeps):
        sweep(*problem, impulse, forwards[::-1] if k < SWEEPS_EACH_WAY else forwards)
    report.residual = residual(*problem, impulse)

    def is_done():
        return report.residual <= settings.tolerance or sweeps == settings.max_sweeps

    between = 1  # sweeps over all, until pairs are solved again
    while not is_done():
        before = report.residual
        visits += solve_pairs_alone(problem, impulse, pair, settings)
        report.residual = residual(*problem, impulse)
        between = 1 if report.residual < FALL_ALONE * before else 2 * between
        for k in range(1, between + 1):
            if is_done():
                break
            change = sweep(*problem, impulse, forwards)
            sweeps, visits = sweeps + 1, visits + len(impulse)
            is_last = k == between or sweeps == settings.max_sweeps
            if is_last or change <= CHANGE_PER_RESIDUAL * settings.tolerance:
                report.residual = residual(*problem, impulse)
    report.sweeps = visits / len(impulse)
    return report


def solve_pairs_alone(problem, impulse, pair, settings):
    """Bring down the violation of pairs until that of all would be within the tolerance.

    Args:
        problem (tuple): first five arguments of ``solve``.
        impulse (ndarray): changed in place.
        pair (list): as ``solve``.
        settings (SolverSettings): tolerance and cap.

    Returns:
        int: visits of contacts.
    """
    members = {}
    for k, name in enumerate(pair):
        members.setdefault(name, []).append(k)
    parts, scale = residual_parts(*problem, impulse)
    violation = {name: parts[contacts].sum() for name, contacts in members.items()}
    level = common_level(violation.values(), (MARGIN_ALONE * settings.tolerance) ** 2 * scale)
    visits = 0
    for name, contacts in members.items():
        if violation[name] > level and 1 < len(contacts) <= MOST_CONTACTS_ALONE:
            sweeps = solve_alone(problem, impulse, contacts, level, settings.max_sweeps)
            visits += sweeps * len(contacts)
    return visits


def common_level(violations, total):
    """Level to which larger violations have to come down for all to sum to the total."""
    level, left, above = 0.0, total, sum(v > 0 for v in violations)
    while above:
        level = left / above
        last = above
        left = total - sum(v for v in violations if v <= level)
        above = sum(v > level for v in violations)
        if above == last:
            break
    return level


def solve_alone(problem, impulse, contacts, violation, max_sweeps):
    """Solve the contacts of a pair, all other impulses held, by extrapolated sweeps.

    After the j-th sweep in a row they go on from r + j/(j + 2) (r - r_before); j starts anew when
    a sweep turns back or changes more than the one before. Where the violation has not fallen by
    the cap the impulses stay as they were.

    Args:
        problem (tuple): first five arguments of ``solve``.
        impulse (ndarray): of all contacts; those of the pair are changed.
        contacts (list): their numbers.
        violation (float): sum W |rho|^2 at which to stop [J].
        max_sweeps (int): cap, at least 1.

    Returns:
        int: number of sweeps.
    """
    delassus, free_velocity, *rest = problem
    W = delassus[np.ix_(contacts, contacts)]
    r = impulse[contacts]
    held = free_velocity[contacts] + delassus[contacts] @ impulse - W @ r
    alone = (W, held, *(array[contacts] for array in rest))
    weight = W.diagonal()[:, None]
    before, in_a_row, last_change = r.copy(), 0, np.inf
    first = residual_parts(*alone, r)[0].sum()
    for sweeps in range(1, max_sweeps + 1):
        start = r.copy()
        sweep(*alone, r, range(len(r)))
        changed = np.sum(weight * (r - start) ** 2)
        if changed <= 4 * violation and residual_parts(*alone, r)[0].sum() <= violation:
            break
        if sweeps == max_sweeps:
            if not residual_parts(*alone, r)[0].sum() < first:
                return sweeps
            break
        turned = np.sum(weight * (r - start) * (r - before)) < 0 or changed > last_change
        last_change = changed
        in_a_row = 0 if turned else in_a_row + 1
        before, r = r, r + in_a_row / (in_a_row + 2) * (r - before)
    impulse[contacts] = r
    return sweeps


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
