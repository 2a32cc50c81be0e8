"""Contact problems as data: solve one outside a scene."""

from softgrain import _softgrain


def solve_contact_problem(problem, tolerance=1e-10, max_sweeps=100_000):
    """Solve a contact problem by the Gauss-Seidel sweeps of the step, but not pair by pair.

    ``numpy.savez(file, **sg.integrator().contactProblem())`` keeps the problem of the last step;
    ``sg.solve_contact_problem(numpy.load(file))`` solves it, for example to a finer tolerance.

    Args:
        problem (mapping): arrays as ``SoftGrainIntegrator.contactProblem`` gives them (its
            documentation has shapes and units); the sweeps start from ``start``, and ``impulse``
            is not needed.
        tolerance (float): residual at which the sweeps end, > 0 [-].
        max_sweeps (int): cap on sweeps, at least 1.

    Returns:
        dict: ``impulse`` (contacts, dim) [N s], ``residual`` of these [-], ``sweeps`` (float), and
        ``converged``, whether the residual is within the tolerance.

    Raises:
        ValueError: arrays that do not fit together, or a value outside its range.
        KeyError: an array is missing.
    """
    return _softgrain.solveContactProblem(dict(problem), tolerance, max_sweeps)
