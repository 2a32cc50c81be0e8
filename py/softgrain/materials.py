"""Which material of ``O.materials`` an argument means."""

import operator

import numpy as np
from yade import Material, O, wrapper

#: Label of the material that grains get where a scene has none.
_DEFAULT_MATERIAL = "softMat"


def soft_material(material):
    """The SoftMat that is meant.

    Args:
        material (SoftMat | int | str | None): itself, an index or a label of ``O.materials``; None
            or, as in YADE, -1: the last one there, or a new one with default values, which
            :func:`keep_material` adds.

    Returns:
        SoftMat.

    Raises:
        ValueError: there is none of that kind.
    """
    if material is None or (np.ndim(material) == 0 and material == -1):
        soft = [m for m in O.materials if isinstance(m, wrapper.SoftMat)]
        return soft[-1] if soft else wrapper.SoftMat(label=_DEFAULT_MATERIAL)
    material = found_material(material)
    if not isinstance(material, wrapper.SoftMat):
        raise ValueError(f"material = {type(material).__name__}: soft grains need a SoftMat")
    return material


def found_material(material):
    """The material that is meant.

    Args:
        material (Material | int | str): itself, an index or a label of ``O.materials``.

    Returns:
        Material: of several with that label the first, as YADE takes it.

    Raises:
        ValueError: there is none.
    """
    if isinstance(material, Material):
        return material
    if isinstance(material, str):
        try:
            return O.materials[material or None]  # '' would be the first without a label
        except (KeyError, TypeError):
            known = [m.label for m in O.materials if m.label]
            raise ValueError(f"material = {material!r} is unknown; known: {known}") from None
    try:
        place = -1 if isinstance(material, bool) else operator.index(material)
    except TypeError:
        place = -1
    if not 0 <= place < len(O.materials):
        raise ValueError(
            f"material = {material!r}: admissible are a Material, a label, or an index of "
            f"O.materials, {_known_indices()}"
        )
    return O.materials[place]


def _known_indices():
    return f"in [0, {len(O.materials) - 1}]" if len(O.materials) else "which is empty"


def keep_material(material):
    """Add a material that was made for lack of another to ``O.materials``."""
    if material.label == _DEFAULT_MATERIAL and material.id < 0:
        O.materials.append(material)
