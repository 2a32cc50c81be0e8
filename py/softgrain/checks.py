"""Checks of arguments that several functions share."""

import operator

import numpy as np
from yade import O


def finite_vector(name, value, size, unit):
    """An argument as a tuple of floats.

    Args:
        name (str): of the argument, for the message.
        value (sequence): numbers.
        size (int): how many there must be.
        unit (str): for the message.

    Raises:
        ValueError: other than so many finite numbers.
    """
    try:
        numbers = tuple(float(number) for number in value)
    except TypeError:
        numbers = ()
    if len(numbers) != size or not np.isfinite(numbers).all():
        raise ValueError(f"{name} = {value}: admissible are {size} finite numbers, in {unit}")
    return numbers


def bodies_of(ids):
    """The bodies with these ids.

    Args:
        ids (iterable of int): ids, each once.

    Returns:
        list of Body.

    Raises:
        ValueError: an id that no body has, or one that comes twice.
    """
    ids = [operator.index(i) for i in ids]
    for i in ids:
        if not 0 <= i < len(O.bodies) or O.bodies[i] is None:
            raise ValueError(f"ids: there is no body #{i}")
    if len(set(ids)) < len(ids):
        raise ValueError(f"ids: #{next(i for i in ids if ids.count(i) > 1)} is given twice")
    return [O.bodies[i] for i in ids]
