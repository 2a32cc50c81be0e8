"""Spheres at random, by YADE's generator, that cases start from."""

from yade import pack

#: Seeds tried: a dense cloud may leave no room for the last of its spheres.
MOST_SEEDS = 20


def full_cloud(count, corner, mean_radius, spread, seed=1, periodic=False):
    """So many spheres in a box, by the next seed where one leaves no room for the last of them.

    Args:
        count (int): how many.
        corner (tuple): of the box, opposite to (0, 0, 0); flat clouds: 0 along z [m].
        mean_radius (float): [m].
        spread (float): radii are even in ``mean_radius`` (1 +- spread), in [0, 1) [-].
        seed (int): the first one tried, >= 1.
        periodic (bool): in a periodic cell of that size.

    Returns:
        SpherePack.

    Raises:
        RuntimeError: none of the seeds leaves room.
    """
    for k in range(MOST_SEEDS):
        cloud = pack.SpherePack()
        made = cloud.makeCloud(
            (0, 0, 0),
            corner,
            rMean=mean_radius,
            rRelFuzz=spread,
            num=count,
            periodic=periodic,
            seed=seed + k,
        )
        if made == count:
            return cloud
    raise RuntimeError(f"makeCloud finds no room for {count} spheres; try another seed")
