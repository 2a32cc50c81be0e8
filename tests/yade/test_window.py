"""Soft grains as YADE's window shows them: rendered pictures."""

import numpy as np
import pytest
from draw_scene import without_display
from matplotlib.path import Path
from scenes import RADIUS, assert_done, run_python
from scipy import spatial

BEGIN = """
from draw_scene import Canvas
from scenes import RADIUS, add_disk, add_wall, ready, run, soft_material
import numpy as np
import softgrain as sg
from yade import FrictMat, Gl1_SoftGrain, O, Quaternion

RED, GREEN, BLUE = np.eye(3)
BOX = (-4 * RADIUS, 4 * RADIUS, -4 * RADIUS, 4 * RADIUS)


def save(**pictures):
    outlines = {f"outline{b.id}": b.shape.outline()[:, :2] for b in sg.soft_bodies()}
    np.savez("drawn.npz", box=BOX, **outlines, **pictures)
    print("done")


"""

IN_THE_PLANE = """
add_disk((-1.05 * RADIUS, 0, 0), color=RED)
add_disk((0.9 * RADIUS, 0, 0), color=GREEN)
turns = np.linspace(0, 2 * np.pi, 10, endpoint=False)
lengths = np.where(np.arange(10) % 2, 0.4, 1) * 1.3 * RADIUS
star = np.column_stack([lengths * np.cos(turns), lengths * np.sin(turns)])
star += RADIUS * np.array((1.5, 2.6))
O.bodies.append(sg.soft_polygon(star, soft_material(), zeta=0.3, color=BLUE))
for side, axis in ((-2.1, 0), (3.6, 0)):
    add_wall(side * RADIUS, axis=axis, velocity=(-np.sign(side), 0, 0))
canvas = Canvas(BOX)
ready()
start = canvas.draw(shape=True)
run(250)
O.bodies[2].state.pos -= (RADIUS, 0, 0)
O.bodies[2].state.ori = Quaternion((0, 0, 1), 0.3) * O.bodies[2].state.ori
later = canvas.draw(shape=True)
edges = canvas.draw(shape=True, wire=True)
Gl1_SoftGrain.wire = True
same = canvas.draw(shape=True)
save(start=start, later=later, edges=edges, same=same)
"""

IN_SPACE = """
O.bodies.append(sg.soft_sphere((-1.5 * RADIUS, 0, 0), RADIUS, soft_material(), zeta=0.3, color=RED))
O.bodies.append(sg.soft_block(
    (RADIUS, 0, 0), RADIUS * np.array((3, 1, 2)), soft_material(), zeta=0.3, color=GREEN))
O.bodies[1].state.ori = Quaternion((1, 2, 3), 0.7)
O.bodies[1].state.angVel = (10, 0, 0)
ready()
run(20)
canvas = Canvas(BOX)
save(later=canvas.draw(shape=True), edges=canvas.draw(shape=True, wire=True))
"""

BUILT_UNDER_EYES = """
looked = []
for looks in (False, True):
    O.reset()
    canvas = canvas if looked else Canvas(BOX)
    body = add_disk((-RADIUS, 0, 0.1 * RADIUS), color=RED)
    start = canvas.draw(shape=True) if looks else None
    body.state.pos, body.state.vel = (-RADIUS, 0, -0.1 * RADIUS), (1, 0, 0)
    body.state.ori = Quaternion((0, 0, 1), 0.3)
    moved = canvas.draw(shape=True) if looks else None
    ready()
    run(50)
    looked.append((O.time, O.dt, body.shape.outline(), body.shape.nodeVelocities()))
for one, other in zip(*looked):
    assert np.array_equal(one, other)
save(start=start, later=canvas.draw(shape=True), moved=moved)
"""

BOUNDARY_POINTS = """
add_disk(color=BLUE, contact="points")
save(later=Canvas(BOX).draw(shape=True))
"""

BESIDE_A_RUN = """
import time

body = add_disk((-3 * RADIUS, 0, 0), color=RED)
body.state.vel = (0.01, 0, 0)
ready()
canvas = Canvas(BOX)
pictures, places = [], []
O.run()
end = time.time() + 60
while (len(places) < 20 or places[-1] < places[0] + 3) and time.time() < end:
    time.sleep(0.002)
    pictures.append(canvas.draw(shape=True))
    red = pictures[-1][:, :, 1] < 200
    if red.any():
        places.append(np.nonzero(red)[1].mean())
O.pause()
O.wait()
save(later=canvas.draw(shape=True), places=places)
"""

NOT_IN_ORDER = """
add_disk(color=RED)
canvas = Canvas(BOX)
O.bodies[0].material = FrictMat()
picture = canvas.draw(shape=True)
O.bodies[0].material = soft_material()
save(later=picture)
"""


@pytest.fixture
def drawn(tmp_path):
    def draw(code):
        assert_done(run_python(BEGIN + code, tmp_path, without_display(tmp_path)))
        return Drawn(np.load(tmp_path / "drawn.npz"))

    return draw


class Drawn:
    """Pictures and outlines that a process has left."""

    def __init__(self, arrays):
        self.arrays = arrays
        left, right, low, high = arrays["box"]
        size = len(arrays["later"])
        middles = (np.arange(size) + 0.5) / size
        x, y = np.meshgrid(left + (right - left) * middles, high - (high - low) * middles)
        self.pixels = np.column_stack([x.ravel(), y.ravel()])

    def colored(self, name, channel):
        """Pixels in which one colour is the brightest, as a mask."""
        picture = self.arrays[name].astype(int)
        others = np.delete(picture, channel, axis=2).max(axis=2)
        return (picture[:, :, channel] > others + 40).ravel()

    def difference(self, name, channel, polygon):
        """Pixels that differ from those in a polygon, over the latter."""
        expected = Path(polygon).contains_points(self.pixels)
        return (self.colored(name, channel) != expected).sum() / expected.sum()


def test_grains_in_the_plane(drawn):
    """Filled up to their outlines as deformed, indented ones too, and moved by hand."""
    picture = drawn(IN_THE_PLANE)
    for body in range(3):
        assert picture.difference("later", body, picture.arrays[f"outline{body}"]) < 0.03
        filled, edges = (picture.colored(name, body).sum() for name in ("later", "edges"))
        assert 0 < edges < 0.1 * filled
    assert picture.difference("start", 0, picture.arrays["outline0"]) > 0.05
    np.testing.assert_array_equal(picture.arrays["edges"], picture.arrays["same"])


def test_grains_in_space(drawn):
    """They cover what is behind their outline."""
    picture = drawn(IN_SPACE)
    for body in range(2):
        outline = picture.arrays[f"outline{body}"]
        hull = outline[spatial.ConvexHull(outline).vertices]
        assert picture.difference("later", body, hull) < 0.03
        filled, edges = (picture.colored(name, body).sum() for name in ("later", "edges"))
        assert 0.05 * filled < edges < 0.7 * filled


def test_looking_changes_nothing(drawn):
    """Grains are seen, and follow their State, before the first step, which finds them as if nobody
    had looked."""
    picture = drawn(BUILT_UNDER_EYES)
    outline = picture.arrays["outline0"]
    shift = outline.mean(axis=0) - (-RADIUS, 0)
    for name in ("start", "moved"):
        assert picture.difference(name, 0, outline - shift) < 0.03
    assert picture.difference("later", 0, outline) < 0.03


def test_boundary_points(drawn):
    """Dots of three pixels, each at its place."""
    picture = drawn(BOUNDARY_POINTS)
    dots = picture.pixels[picture.colored("later", 2)]
    distances, _ = spatial.cKDTree(picture.arrays["outline0"]).query(dots)
    pixel = np.ptp(picture.arrays["box"][:2]) / len(picture.arrays["later"])
    assert len(dots) == 9 * len(picture.arrays["outline0"]) and distances.max() < 2.2 * pixel


def test_beside_a_run(drawn):
    """A disk that moves is seen to move."""
    picture = drawn(BESIDE_A_RUN)
    places = picture.arrays["places"]
    assert (np.diff(places) >= 0).all() and places[-1] >= places[0] + 3
    assert picture.difference("later", 0, picture.arrays["outline0"]) < 0.03


def test_scene_that_no_step_would_take(drawn):
    """It is drawn all the same: to look is no step."""
    assert drawn(NOT_IN_ORDER).colored("later", 0).mean() > 0.03
