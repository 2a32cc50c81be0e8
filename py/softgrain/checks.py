"""Checks of arguments that several functions share; nothing of a scene."""

import math
import operator
from collections.abc import Mapping, Set

import numpy as np


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
    numbers = _numbers(value)
    if len(numbers) != size or not np.isfinite(numbers).all():
        raise ValueError(f"{name} = {value}: admissible are {size} finite numbers, in {unit}")
    return numbers


def rgb(value):
    """The argument ``color``, red, green and blue, as a tuple of floats.

    Raises:
        ValueError: other than three numbers in [0, 1].
    """
    numbers = _numbers(value)
    if len(numbers) != 3 or not all(0 <= share <= 1 for share in numbers):
        raise ValueError(f"color = {value}: admissible are 3 numbers in [0, 1]")
    return numbers


def lengths(name, value, sizes):
    """An argument as a list of positive lengths [m].

    Args:
        name (str): of the argument, for the message.
        value (sequence): numbers.
        sizes (tuple of int): how many there may be.

    Raises:
        ValueError: other than so many numbers in (0, inf).
    """
    numbers = _numbers(value)
    if len(numbers) not in sizes or not all(0 < length < math.inf for length in numbers):
        many = " or ".join(map(str, sizes))
        raise ValueError(f"{name} = {value}: admissible are {many} numbers in the range (0, inf) m")
    return list(numbers)


def array(name, value):
    """An argument as an array of floats, of any shape.

    Args:
        name (str): of the argument, for the message.
        value (array): numbers.

    Raises:
        ValueError: something else.
    """
    try:
        return np.asarray(value, float)
    except (TypeError, ValueError):
        raise ValueError(f"{name} = {value!r}: admissible is an array of numbers") from None


def require_mapping(name, value, content):
    """ValueError for an argument that is no dict or the like.

    Args:
        name (str): of the argument, for the message.
        value (mapping): to be checked.
        content (str): what is in it, for the message.
    """
    if not isinstance(value, Mapping):
        raise ValueError(f"{name} = {value!r}: admissible is a dict of {content}")


def _numbers(value):
    """A tuple of floats; an empty one where the value is no sequence of numbers."""
    if isinstance(value, (str, bytes, Mapping, Set)):  # have items, but no numbers in an order
        return ()
    try:
        return tuple(float(item) for item in value)
    except (TypeError, ValueError):
        return ()


def in_range(value, admissible):
    """Whether a number (float; never nan) is in a range, such as '(0, inf)' or '[0, 1]'."""
    low, high = map(float, admissible[1:-1].split(","))
    above = value >= low if admissible[0] == "[" else value > low
    below = value <= high if admissible[-1] == "]" else value < high
    return above and below


def number(name, value, admissible, unit=""):
    """An argument as a float.

    Args:
        name (str): of the argument, for the message.
        value (float): to be checked; neither bool nor array.
        admissible (str): a range, such as '(0, inf)' or '[0, 1]'.
        unit (str): for the message.

    Returns:
        float: the value.

    Raises:
        ValueError: no number, or outside the range.
    """
    text = isinstance(value, (str, bytes))
    try:  # True would be 1, an array of one number that number
        x = math.nan if text or _is_bool(value) or np.ndim(value) else float(value)
    except (TypeError, ValueError, OverflowError):
        x = math.nan
    if not in_range(x, admissible):
        shown = repr(value) if text else value
        raise ValueError(
            f"{name} = {shown} is outside the admissible range {admissible} {unit}".rstrip()
        )
    return x


def _is_bool(value):
    return isinstance(value, (bool, np.bool_))


def index(name, value):
    """An argument as an int.

    Args:
        name (str): of the argument, for the message.
        value (int): a whole number, numpy's among them.

    Raises:
        ValueError: something else, or of more than 32 bits.
    """
    try:
        return _whole(value)
    except TypeError:
        raise ValueError(
            f"{name} = {value!r}: admissible is a whole number in [-2^31, 2^31 - 1]"
        ) from None


def _whole(value):
    """TypeError for what is no whole number that YADE takes: a bool of Python would be taken for
    one."""
    if _is_bool(value):
        raise TypeError("a bool")
    whole = operator.index(value)
    if not -(2**31) <= whole < 2**31:
        raise TypeError("more than 32 bits")
    return whole


def made(cls, attributes):
    """An object of a class of YADE.

    Args:
        cls (type): the class.
        attributes (dict): by name; scalars of numpy are taken, too, which the class itself refuses.

    Raises:
        ValueError: naming an attribute that the class does not have, or that has a value of
            another type or (by the class itself) out of its range.
    """
    plain = {
        name: value.item() if isinstance(value, np.generic) else value
        for name, value in attributes.items()
    }
    try:
        return cls(**plain)
    except (TypeError, AttributeError, OverflowError):
        for name, value in plain.items():
            _check_type(cls, name, value)
        raise


def _check_type(cls, name, value):
    if not hasattr(cls(), name):
        raise ValueError(f"{name} is no attribute of {cls.__name__}")
    try:
        cls(**{name: value})  # assigned later, it might be read-only
    except (TypeError, AttributeError, OverflowError):
        kind = f"{cls.__name__}.{name}"
        raise ValueError(f"{name} = {value!r} is of no type that {kind} takes") from None
    except ValueError:
        pass  # of its type, and out of a range that may depend on others


def indices(name, values):
    """An argument as a list of int.

    Args:
        name (str): of the argument, for the message.
        values (iterable of int): whole numbers.

    Raises:
        ValueError: not iterable, or something else, or more than 32 bits, in it.
    """
    try:
        return [_whole(value) for value in values]
    except TypeError:
        raise ValueError(
            f"{name} = {values}: admissible are whole numbers in [-2^31, 2^31 - 1]"
        ) from None
