"""YADE's Gl1_NormPhys draws force chains of soft grains: a rendered picture."""

import numpy as np
from draw_scene import without_display
from matplotlib.image import imread
from scenes import assert_done, run_python

DRAWN = """
from matplotlib.image import imsave
from draw_scene import Canvas
from scenes import RADIUS, add_disk, add_wall, ready, run, soft_material
import numpy as np
import softgrain as sg
from yade import Gl1_NormPhys, O

for x, y in ((1, 1), (3, 1), (1, 3), (3, 3)):
    add_disk((x * RADIUS, y * RADIUS, 0), material=soft_material(massDamping=400))
walls = [add_wall(4 * RADIUS * (k % 2), axis=k // 2) for k in range(4)]
ready(tolerance=1e-4)
walls[3].state.vel = (0, -0.2, 0)
while walls[3].state.pos[1] > 3.8 * RADIUS:
    run(1)
walls[3].state.vel = (0, 0, 0)
O.run(2000, True)
Gl1_NormPhys.maxRadius = RADIUS / 4
Gl1_NormPhys.slices = 64  # round: its default is a hexagon, as wide as it is turned
imsave("chains.png", Canvas((0, 4 * RADIUS, 0, 4 * RADIUS)).draw(intrPhys=True))
np.savez(
    "scene.npz",
    place=[O.bodies[k].state.pos for k in range(4)],
    pairs=[(i.id1, i.id2) for i in O.interactions if i.isReal and max(i.id1, i.id2) < 4],
    force=[i.phys.normalForce.norm() for i in O.interactions if i.isReal and max(i.id1, i.id2) < 4],
)
print("done")
"""


def thickness(drawn, middle, along, size):
    """Pixels that are not white on a line across a chain."""
    across = np.array([-along[1], along[0]]) / np.linalg.norm(along)
    steps = np.arange(-0.2, 0.2, 0.5 / size)[:, None]
    column, row = np.floor((middle + steps * across).T * size).astype(int)
    return 0.5 * drawn[size - 1 - row, column].sum()


def test_chains_are_drawn(tmp_path):
    """Cylinders from centre to centre, the thicker the larger the force, and nothing elsewhere."""
    assert_done(run_python(DRAWN, tmp_path, without_display(tmp_path)))
    picture = imread(tmp_path / "chains.png")[:, :, :3]
    scene = np.load(tmp_path / "scene.npz")
    drawn, size = picture.min(axis=2) < 0.99, len(picture)
    places, forces = scene["place"][:, :2] / 0.04, scene["force"]
    assert len(forces) == 4 and 0.01 < drawn.mean() < 0.6
    widths = []
    for first, second in scene["pairs"]:
        for share in (0.1, 0.3, 0.7, 0.9):
            x = (1 - share) * places[first] + share * places[second]
            assert drawn[size - 1 - int(x[1] * size), int(x[0] * size)]
        middle, along = 0.5 * (places[first] + places[second]), places[second] - places[first]
        widths.append(thickness(drawn, middle, along, size))
    np.testing.assert_allclose(
        np.array(widths) / max(widths), forces / forces.max(), rtol=0, atol=1 / max(widths)
    )
    assert forces.min() < 0.6 * forces.max()
    assert not drawn[size // 2, size // 2]  # between the disks
