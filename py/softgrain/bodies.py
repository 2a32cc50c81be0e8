"""Which bodies of a scene are meant, and what they are."""

from yade import O, wrapper

from softgrain.checks import indices


def is_soft(body):
    """Whether a body is a soft grain (None, and what is no body, is not)."""
    return isinstance(getattr(body, "shape", None), wrapper.SoftGrain)


def soft_bodies():
    """All bodies with a soft shape, by id."""
    return [b for b in O.bodies if is_soft(b)]


def some_soft_bodies(asker):
    """All bodies with a soft shape, by id.

    Args:
        asker (str): who needs them, for the message.

    Raises:
        ValueError: the scene has no soft grain.
    """
    bodies = soft_bodies()
    if not bodies:
        raise ValueError(f"{asker}: the scene has no soft grain")
    return bodies


def has_own_motion(body):
    """Whether forces move a body by itself: a soft grain, or a rigid body that is neither held nor
    a member of a clump. (YADE gives mass to bodies that are held, too.)"""
    return is_soft(body) or (body.dynamic and not body.isClumpMember)


def material_of(body):
    """The SoftMat of a soft grain.

    Raises:
        ValueError: it has another material, or none.
    """
    if not isinstance(body.material, wrapper.SoftMat):
        raise ValueError(
            f"the material of soft grain #{body.id} is {type(body.material).__name__}, no SoftMat"
        )
    return body.material


def unscaled_mass(body):
    """Of a soft grain without mass scaling, of which State.mass tells from the next step on [kg, 2D
    kg/m]."""
    return material_of(body).density * body.shape.undeformedVolume()


def bodies_of(ids, name="ids"):
    """The bodies with these ids.

    Args:
        ids (iterable of int): ids, each once.
        name (str): of the argument, for the message.

    Returns:
        list of Body.

    Raises:
        ValueError: something else, an id that no body has, or one that comes twice.
    """
    ids = indices(name, ids)
    for i in ids:
        if not 0 <= i < len(O.bodies) or O.bodies[i] is None:
            raise ValueError(f"{name}: there is no body #{i}")
    if len(set(ids)) < len(ids):
        raise ValueError(f"{name}: #{next(i for i in ids if ids.count(i) > 1)} is given twice")
    return [O.bodies[i] for i in ids]


def whole_of(body_id):
    """The clump that a body is a member of, or the body itself; by id."""
    body = O.bodies[body_id]
    return body.clumpId if body.isClumpMember else body_id
