"""Overlaps of rigid packings, when their spheres turn soft or soft grains turn into spheres."""

from dataclasses import dataclass

from yade import O, Sphere, Vector3, wrapper

from softgrain.cell import nearest_images

#: Overlaps up to this share of the smaller radius are left to be worked off; rigid packings of
#: usual stiffness stay below.
WORKABLE_OVERLAP = 0.05


@dataclass
class Ball:
    """A sphere, or what is to become one.

    Attributes:
        id (int): of the body.
        position (Vector3): of the centre [m].
        radius (float): [m].
        clump (int | None): the clump that it is a member of, whose members overlap by design.
        shrinks (bool): its radius is one of those that are reduced with 'shrink'.
    """

    id: int
    position: Vector3
    radius: float
    clump: int | None
    shrinks: bool

    @classmethod
    def of(cls, body, radius=None, shrinks=True):
        """Of a body, with its radius or another one."""
        clump = body.clumpId if body.isClumpMember else None
        radius = body.shape.radius if radius is None else radius
        return cls(body.id, Vector3(body.state.pos), radius, clump, shrinks)


def overlap_factor(balls, overlap, dim):
    """Common factor of the radii after the choice about overlaps. Spheres and walls that stay
    rigid count as well; soft grains, facets and boxes do not.

    Args:
        balls (list of Ball): what is to be converted.
        overlap (str): as for :func:`soften`.
        dim (int): of the scene; with 2 a periodic cell has no images along z.

    Returns:
        float: in (0, 1]; 1 unless with 'shrink' [-].

    Raises:
        ValueError: an unknown choice, or an overlap that it does not admit.
    """
    if overlap not in ("relax", "shrink", "refuse"):
        raise ValueError(f"overlap = {overlap!r} is unknown; known: 'relax', 'shrink', 'refuse'")
    limit = {"relax": WORKABLE_OVERLAP, "shrink": 1.0, "refuse": 0.0}[overlap]
    pairs = list(_near_pairs(balls, dim))
    worst = max(pairs, key=lambda pair: pair.overlap, default=None)
    swallows = worst and overlap == "shrink" and not worst.factor > 0
    if worst and (worst.overlap > limit or swallows):
        hint = "" if overlap == "shrink" else " or use overlap='shrink'"
        raise ValueError(
            f"overlap = {overlap!r}: bodies #{worst.ids[0]} and #{worst.ids[1]} overlap by "
            f"{100 * worst.overlap:.3g} % of the smaller radius, more than the admissible "
            f"{100 * limit:g} %; relax the rigid packing further{hint}"
        )
    if overlap != "shrink":
        return 1.0
    return min((pair.factor for pair in pairs), default=1.0)


@dataclass
class _NearPair:
    """Two bodies that overlap: by how much of the smaller radius, and the factor of the radii that
    shrink at which they would touch."""

    ids: tuple
    overlap: float
    factor: float


def _near_pairs(balls, dim):
    """The pairs of balls, and of balls and walls, that overlap, of which one shrinks at least. In a
    periodic cell pairs at its borders may come twice."""
    converted = {ball.id for ball in balls}
    others = [
        Ball.of(b, shrinks=False)
        for b in O.bodies
        if b and isinstance(b.shape, Sphere) and b.id not in converted
    ]
    yield from _pairs_of_balls(balls + others, dim)
    for w in O.bodies:
        if not (w and isinstance(w.shape, wrapper.Wall)):
            continue
        axis = w.shape.axis
        for ball in balls:
            distance = abs(ball.position[axis] - w.state.pos[axis])
            if distance < ball.radius:
                factor = distance / ball.radius
                yield _NearPair((w.id, ball.id), 1 - factor, factor)


def _pairs_of_balls(balls, dim):
    """By sorting along x."""
    largest = max(ball.radius for ball in balls)
    images = [
        (ball.position + Vector3(*shift), ball)
        for ball in balls
        for shift in nearest_images(ball.position, largest, dim)
    ]
    images.sort(key=lambda image: (image[0][0] - image[1].radius, image[1].id))
    active = []
    for place, b in images:
        active = [(x, a) for x, a in active if x[0] + a.radius > place[0] - b.radius]
        for x, a in active:
            together = a.clump is not None and a.clump == b.clump
            distance = (x - place).norm()
            if not together and (a.shrinks or b.shrinks) and distance < a.radius + b.radius:
                yield _pair(a, b, distance)
        active.append((place, b))


def _pair(a, b, distance):
    stays = sum(ball.radius for ball in (a, b) if not ball.shrinks)
    shrinks = a.radius + b.radius - stays
    overlap = (a.radius + b.radius - distance) / min(a.radius, b.radius)
    return _NearPair((a.id, b.id), overlap, (distance - stays) / shrinks)
