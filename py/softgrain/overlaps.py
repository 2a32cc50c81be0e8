"""Overlaps of rigid packings, when their spheres turn soft or soft grains turn into spheres."""

from yade import O, Vector3, wrapper

from softgrain.observe import nearest_images

#: Overlaps up to this share of the smaller radius are left to be worked off; rigid packings of
#: usual stiffness stay below.
WORKABLE_OVERLAP = 0.05


def overlap_factor(bodies, overlap):
    """Common factor of the radii after the choice about overlaps.

    Args:
        bodies (list of Body): spheres; walls of the scene count as well.
        overlap (str): as for :func:`soften`.

    Returns:
        float: in (0, 1]; 1 unless with 'shrink' [-].

    Raises:
        ValueError: an unknown choice, or an overlap that it does not admit.
    """
    if overlap not in ("relax", "shrink", "refuse"):
        raise ValueError(f"overlap = {overlap!r} is unknown; known: 'relax', 'shrink', 'refuse'")
    worst, factor, pair = 0.0, 1.0, None
    for distance, reach, smaller, ids in _near_pairs(bodies):
        relative = (reach - distance) / smaller
        if relative > worst:
            worst, pair = relative, ids
        factor = min(factor, distance / reach)
    limit = {"relax": WORKABLE_OVERLAP, "shrink": 1.0, "refuse": 0.0}[overlap]
    if worst > limit:
        raise ValueError(
            f"overlap = {overlap!r}: bodies #{pair[0]} and #{pair[1]} overlap by "
            f"{100 * worst:.2g} % of the smaller radius, more than the admissible "
            f"{100 * limit:g} %; relax the rigid packing further or use overlap='shrink'"
        )
    return factor if overlap == "shrink" else 1.0


def _near_pairs(bodies):
    """Distance, sum of radii, smaller radius and ids of the pairs of spheres (and sphere-wall
    pairs) that may overlap, members of one clump left out, by sorting along x. In a periodic cell
    pairs at its borders may come twice."""
    largest = max(b.shape.radius for b in bodies)
    images = [
        (b.state.pos + Vector3(*shift), b)
        for b in bodies
        for shift in nearest_images(b.state.pos, largest)
    ]
    rows = sorted(
        ((place[0] - b.shape.radius, b.id, place, b) for place, b in images),
        key=lambda row: row[:2],
    )
    active = []
    for low, _, place, b in rows:
        active = [(x, a) for x, a in active if x[0] + a.shape.radius > low]
        for x, a in active:
            if a.isClumpMember and a.clumpId == b.clumpId:
                continue
            distance = (x - place).norm()
            reach = a.shape.radius + b.shape.radius
            if distance < reach:
                yield distance, reach, min(a.shape.radius, b.shape.radius), (a.id, b.id)
        active.append((place, b))
    walls = [w for w in O.bodies if w and isinstance(w.shape, wrapper.Wall)]
    for w in walls:
        for b in bodies:
            distance = abs(b.state.pos[w.shape.axis] - w.state.pos[w.shape.axis])
            if distance < b.shape.radius:
                yield distance, b.shape.radius, b.shape.radius, (w.id, b.id)
