"""Contact problems as data: solve one outside a scene."""

import numpy as np

from softgrain import _softgrain
from softgrain.checks import index, number, require_mapping

#: Arrays of a problem with a vector, and a number, for each contact.
_VECTORS, _NUMBERS = ("free_velocity", "start"), ("bias", "friction")
_OF_CONTACTS = ("normal", *_VECTORS, *_NUMBERS)
_OF_DELASSUS = ("delassus_offset", "delassus_column", "delassus_value")


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
        ValueError: no mapping, an array is missing, arrays that do not fit together, or a value
            outside its range.
    """
    tolerance = number("tolerance", tolerance, "(0, inf)")
    max_sweeps = index("max_sweeps", max_sweeps)
    require_mapping("problem", problem, "arrays, as SoftGrainIntegrator.contactProblem gives them")
    missing = [name for name in (*_OF_CONTACTS, *_OF_DELASSUS) if name not in problem]
    if missing:
        raise ValueError(f"problem lacks {missing}")
    arrays = {name: np.asarray(problem[name]) for name in _OF_CONTACTS}
    shape = arrays["normal"].shape
    if len(shape) != 2 or shape[1] not in (2, 3):
        raise ValueError(f"normal has the shape {shape}; admissible: (contacts, 2 or 3)")
    for names, expected in ((_VECTORS, shape), (_NUMBERS, shape[:1])):
        for name in names:
            if arrays[name].shape != expected:
                raise ValueError(
                    f"{name} has the shape {arrays[name].shape}; that of normal asks for {expected}"
                )
    for name in ("delassus_offset", "delassus_column"):
        arrays[name] = _indices(name, problem[name])
    arrays["delassus_value"] = np.asarray(problem["delassus_value"])
    return _softgrain.solveContactProblem(arrays, tolerance, max_sweeps)


def _indices(name, array):
    array = np.asarray(array)
    limits = np.iinfo(np.int32)
    if array.size and array.dtype.kind not in "iu":
        raise ValueError(f"{name} holds numbers of type {array.dtype}; admissible: integers")
    if array.size and not (limits.min <= array.min() and array.max() <= limits.max):
        raise ValueError(f"{name} holds numbers beyond {limits.max}")
    return array
