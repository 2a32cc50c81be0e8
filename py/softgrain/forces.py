"""Contact forces of the last step as arrays: by contact point, by pair, by body.

Forces are exact; pressures and shear tractions of contact points are smoothed over about one
spacing of background nodes (``doc/theory.md``). With contact geometries other than 'surface' nodes
have no area: these are 0 then, and those of pairs and bodies nan. In 2D forces are per metre of
thickness and areas are lengths.
"""

import numpy as np
from yade import O, wrapper

from softgrain.bodies import is_soft, soft_bodies

#: Forces of all contact points of a pair together.
_SUMS = ("normal_force", "shear_force")


def contact_forces():
    """All contact points of soft grains within reach.

    Returns:
        dict of arrays, pair by pair in the order of their ids: owner (n,), id of the body whose
        node, or end, it is; other (n,), id of the body it touches; point (n, 3), in a periodic cell
        beside the owner, or the other if the owner is rigid [m]; normal (n, 3), into the owner;
        force (n, 3) on the owner [N, 2D N/m]; gap (n,) [m]; area (n,), share of the node in the
        outline [m², 2D m]; pressure (n,) and shear (n, 3), tractions on the owner [Pa].
    """
    vectors = ("point", "normal", "force", "shear")
    names = (*vectors, "gap", "area", "pressure")
    columns = {name: [] for name in ("owner", "other", *names)}
    for interaction in _soft_interactions():
        arrays = interaction.geom.contacts()
        first, second = _sides(interaction)
        on_first = arrays["side"] == 0
        owner, other = np.where(on_first, first, second), np.where(on_first, second, first)
        columns["owner"].append(owner)
        columns["other"].append(other)
        arrays["point"] = _beside_owners(arrays["point"], owner, other)
        for name in names:
            columns[name].append(arrays[name])
    return {
        name: np.concatenate(parts) if parts else _no_rows(name, vectors)
        for name, parts in columns.items()
    }


def pair_forces():
    """Pairs of bodies, at least one of them soft, that exchange force.

    Returns:
        dict of arrays, in the order of the ids: id1, id2 (n,); point (n, 3), mean of the contact
        points by the size of their normal forces, in a periodic cell beside id1 [m]; normal_force
        (n, 3) and shear_force (n, 3), sums of the normal and of the tangential forces of all
        contact points on #2 [N, 2D N/m]; area (n,) of contact, of what presses and what pulls [m²,
        2D m]; pressure (n,), positive where the pair presses, and shear (n,), >= 0, sizes of these
        sums over the area [Pa]. The last two are nan where the area is 0 under a force (contact
        'points' and 'nodes', contacts by ends and edges alone), all three where contact points are
        not there: after ``O.load``, before the next step.
    """
    rows = [_pair(i) for i in _soft_interactions() if i.phys.activeContacts > 0]
    names = ("id1", "id2", "point", *_SUMS, "area", "pressure", "shear")
    return {
        name: np.array([row[k] for row in rows]) if rows else _no_rows(name, ("point", *_SUMS))
        for k, name in enumerate(names)
    }


def _no_rows(name, vectors):
    """The column of that name in a table without rows; ``vectors`` are names of those."""
    if name in vectors:
        return np.zeros((0, 3))
    return np.zeros(0, int if name in ("owner", "other", "id1", "id2") else float)


def body_forces():
    """What contacts of soft grains do to each body, members of a clump each by itself.

    Returns:
        dict of arrays, by id, for all soft grains and the bodies that they exchange force with: id
        (n,); force (n, 3), sum over its pairs [N, 2D N/m]; area (n,) of all its contacts [m², 2D
        m]; pressure (n,), sum of the magnitudes of the normal forces of its pairs over the area,
        whichever way they point, and shear (n,), the same of the shear forces [Pa]; nan as for
        :func:`pair_forces`.
    """
    pairs = pair_forces()
    ids = np.array(
        sorted({b.id for b in soft_bodies()} | {int(k) for k in (*pairs["id1"], *pairs["id2"])}),
        dtype=int,
    )
    place = {body: k for k, body in enumerate(ids)}
    force = np.zeros((len(ids), 3))
    area, pushed, sheared = np.zeros((3, len(ids)))
    for k, ends in enumerate(zip(pairs["id1"], pairs["id2"])):
        for body, sign in zip(ends, (-1, 1)):
            row = place[int(body)]
            force[row] += sign * (pairs["normal_force"][k] + pairs["shear_force"][k])
            area[row] += pairs["area"][k]
            pushed[row] += np.linalg.norm(pairs["normal_force"][k])
            sheared[row] += np.linalg.norm(pairs["shear_force"][k])
    return {
        "id": ids,
        "force": force,
        "area": area,
        "pressure": _over(pushed, area),
        "shear": _over(sheared, area),
    }


def _over(force, area):
    """0 without a force, nan under one where the area is 0 or not known."""
    unknown = np.where((force == 0) & (area == 0), 0.0, np.nan)
    return np.divide(force, area, out=unknown, where=area > 0)


def _soft_interactions():
    """Those of soft grains, in the order of their ids, which that of O.interactions is not."""
    found = [i for i in O.interactions if i.isReal and isinstance(i.phys, wrapper.SoftPhys)]
    return sorted(found, key=lambda i: (min(i.id1, i.id2), max(i.id1, i.id2)))


def _sides(interaction):
    """Ids of the bodies that own contact points of side 0 and of side 1."""
    first = interaction.geom.first
    return first, interaction.id1 + interaction.id2 - first


def _beside_owners(points, owners, others):
    """The image of each point that lies nearest to the soft grain that owns it, or touches it."""
    if not O.periodic:
        return points
    grains = [
        int(owner if is_soft(O.bodies[int(owner)]) else other)
        for owner, other in zip(owners, others)
    ]
    centres = np.array([O.bodies[grain].state.pos for grain in grains]).reshape(-1, 3)
    cell = np.array(O.cell.hSize)
    periods = np.round(np.linalg.solve(cell, (points - centres).T))
    return points - (cell @ periods).T


def _pair(interaction):
    """A row of :func:`pair_forces`."""
    arrays = interaction.geom.contacts()
    normal, shear = np.array(interaction.phys.normalForce), np.array(interaction.phys.shearForce)
    # where the smoothed pressure is not 0 there are nodes beside the contact, too
    carries = arrays["force"].any(axis=1)
    both = [arrays["area"][carries & (arrays["side"] == side)].sum() for side in (0, 1)]
    seen = [area for area in both if area > 0]  # both outlines, or that of the grain
    area = sum(seen) / len(seen) if seen else 0.0
    if len(arrays["side"]) == 0:
        area = np.nan
    sums = np.array([np.linalg.norm(normal), np.linalg.norm(shear)])
    pressure, tangential = _over(sums, np.full(2, area))
    pulls = np.sum(arrays["force"] * arrays["normal"]) < 0
    point = np.array(interaction.geom.contactPoint)
    tractions = (-pressure if pulls else pressure, tangential)
    return interaction.id1, interaction.id2, point, normal, shear, area, *tractions
