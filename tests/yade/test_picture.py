"""Pictures of packings: what is in them, and where."""

import math

import numpy as np
import pytest
from matplotlib.collections import LineCollection, PolyCollection, TriMesh
from matplotlib.figure import Figure
from matplotlib.path import Path
from scenes import add_wall
from yade import FrictMat, O, geom, utils

import softgrain as sg
from softgrain import picture
from softgrain.outlines import signed_area


def two_disks():
    """Disks of 0.01 and 0.02 m that touch."""
    places = ((0, 0.01), (0.03, 0.02))
    disks = [sg.soft_disk((x, 0, 0), radius, sg.SoftMat(), zeta=0.3) for x, radius in places]
    O.bodies.append(disks)
    return disks


@pytest.fixture
def drawn(monkeypatch):
    """Axes of the pictures that would have been written."""
    axes = []
    monkeypatch.setattr(
        Figure, "savefig", lambda figure, *_, **__: axes.append(figure.axes[0])
    )
    return axes


def the_one(axes, kind):
    (found,) = [c for c in axes.collections if type(c) is kind]
    return found


def test_wall_box():
    for position, axis in ((0, 0), (2, 0), (-1, 1), (3, 1), (7, 2)):
        add_wall(position, axis)
    assert sg.wall_box() == (0, 2, -1, 3)


def test_wall_box_with_too_few_walls():
    add_wall(0, axis=0)
    with pytest.raises(ValueError, match="two walls"):
        sg.wall_box()


@pytest.mark.parametrize("field", ("von_mises", "pressure", None))
@pytest.mark.parametrize("contact", ("surface", "points"))
def test_picture(tmp_path, field, contact):
    O.bodies.append(sg.soft_disk((0, 0, 0), 0.01, sg.SoftMat(), zeta=0.3, contact=contact))
    path = tmp_path / "packing.png"
    sg.draw_packing(
        path, box=(-0.01, 0.01, -0.01, 0.01), field=field, scale=1e6, title="a disk", dpi=50
    )
    assert path.read_bytes()[:4] == b"\x89PNG"
    assert path.stat().st_size > 1000


def test_colours_are_the_stresses(drawn):
    """A disk that a wall strikes and one that nothing touches, and the range of colours."""
    soft = sg.SoftMat(young=1e6)
    disks = [sg.soft_disk((x, 0, 0), 0.01, soft, zeta=0.3) for x in (0, 0.05)]
    O.bodies.append(disks)
    add_wall(-0.01, axis=0, velocity=1, material=FrictMat())
    O.engines = sg.engines()
    sg.set_time_step()
    sg.advance(40)
    for field, sign in (("von_mises", 1), ("pressure", -1 / 3)):
        sg.draw_packing("p.png", field=field, scale=1e6)
        mesh = the_one(drawn[-1], TriMesh)
        struck, free = np.split(mesh.get_array(), 2)
        cauchy = disks[0].shape.points()["cauchy"] / 1e6
        expected = sg.von_mises(cauchy) if field == "von_mises" else sign * np.trace(cauchy.T)
        shown = struck[: len(expected)]
        np.testing.assert_allclose(np.sort(shown), np.sort(expected), atol=1e-12)
        assert np.abs(expected).max() > 1e-3 > 1e6 * np.abs(free).max()
        assert 0.5 * expected.max() < mesh.get_clim()[1] <= expected.max()
        sg.draw_packing("p.png", field=field, scale=1e6, limits=(-0.1, 0.3))
        assert the_one(drawn[-1], TriMesh).get_clim() == (-0.1, 0.3)


@pytest.mark.parametrize(
    "scale, label", ((None, "(kPa)"), (2e6, "/ E"), (1e6, "/ 1e+06 Pa")), ids=str
)
def test_unit_of_the_colours(scale, label):
    O.bodies.append(sg.soft_disk((0, 0, 0), 0.01, sg.SoftMat(young=2e6), zeta=0.3))
    assert picture._unit_label(scale) == label


def test_rigid_bodies_in_the_picture():
    sphere = utils.sphere((0.03, 0.01, 0), 0.01)
    box = utils.box((0, 0.05, 0), (0.02, 0.01, 0.5), orientation=((0, 0, 1), math.pi / 2))
    facet = utils.facet([(0, 0, -1), (0.1, 0.02, 1), (0, 0, 1)])
    parallel = utils.facet([(0, 0, 0.1), (1, 0, 0.1), (0, 1, 0.1)])
    below = utils.box((0, 0, -0.2), (1, 1, 0.1))
    two_disks()
    O.bodies.append([sphere, box, utils.wall(0, axis=0), facet, parallel, below])
    ball, block, line = picture.rigid_polygons()
    assert signed_area(ball) == pytest.approx(math.pi * 1e-4, rel=2e-3)
    assert ball.mean(axis=0) == pytest.approx((0.03, 0.01))
    assert signed_area(block) == pytest.approx(8e-4)
    assert np.ptp(block, axis=0) == pytest.approx((0.02, 0.04))
    assert line.tolist() == [pytest.approx(p) for p in ([0.05, 0.01], [0, 0])]


def test_container_of_facets_hides_nothing(drawn):
    """Of one that is closed before and behind the sides are seen, beneath the grains."""
    two_disks()
    O.bodies.append(geom.facetBox((0.02, 0, 0), (0.04, 0.03, 0.01), wallMask=63))
    sg.draw_packing("p.png")
    lines = [path.vertices for path in the_one(drawn[0], PolyCollection).get_paths()]
    sides = [line for line in lines if np.ptp(line, axis=0).max() > 1e-9]
    places = {tuple(np.round(p, 9)) for line in sides for p in line}
    assert all(abs(abs(x - 0.02) - 0.04) < 1e-9 or abs(abs(y) - 0.03) < 1e-9 for x, y in places)
    kinds = [type(c) for c in drawn[0].collections]
    assert kinds.index(PolyCollection) < kinds.index(TriMesh)


def test_picture_of_rigid_bodies_alone(tmp_path):
    O.bodies.append([utils.sphere((0.02 * k, 0, 0), 0.01) for k in range(2)])
    sg.draw_packing(tmp_path / "packing.png")
    assert (tmp_path / "packing.png").exists()


def test_picture_errors(tmp_path):
    with pytest.raises(ValueError, match="draws soft disks and rigid bodies; the scene has none"):
        sg.draw_packing(tmp_path / "packing.png")
    two_disks()
    with pytest.raises(ValueError, match="field = 'tresca' is unknown.*'von_mises', 'pressure'"):
        sg.draw_packing(tmp_path / "packing.png", field="tresca")
    O.bodies.append(sg.soft_sphere((0, 0, 0.1), 0.01, sg.SoftMat(), zeta=0.5))
    with pytest.raises(ValueError, match="this one has soft grains in 3D"):
        sg.draw_packing(tmp_path / "packing.png")
    assert not (tmp_path / "packing.png").exists()


def test_colours_stay_in_their_grains(drawn):
    """In those of a concave one, too: the triangles fill the outlines, no more."""
    disks = two_disks()
    notched = [(0.05, 0), (0.1, 0), (0.1, 0.05), (0.08, 0.05), (0.075, 0.015), (0.07, 0.05)]
    grain = sg.soft_polygon([*notched, (0.05, 0.05)], sg.SoftMat(), zeta=0.1)
    O.bodies.append(grain)
    sg.draw_packing("p.png")
    mesh = the_one(drawn[0], TriMesh).get_paths()
    outlines = [body.shape.outline()[:, :2] for body in (*disks, grain)]
    owners = [
        [k for k, outline in enumerate(outlines) if Path(outline).contains_point(centre)]
        for centre in (t.vertices[:3].mean(axis=0) for t in mesh)
    ]
    assert all(len(found) == 1 for found in owners)
    filled = np.zeros(3)
    for triangle, (owner,) in zip(mesh, owners):
        filled[owner] += abs(signed_area(triangle.vertices[:3]))
        low, high = outlines[owner].min(axis=0) - 1e-12, outlines[owner].max(axis=0) + 1e-12
        assert ((low <= triangle.vertices) & (triangle.vertices <= high)).all()
    assert filled == pytest.approx([signed_area(outline) for outline in outlines], rel=0.02)


def test_outlines_rigid_bodies_and_box_are_drawn(drawn):
    disks = two_disks()
    O.bodies.append(utils.sphere((0.03, 0.05, 0), 0.01))
    sg.draw_packing("p.png", box=(-0.1, 0.2, -0.3, 0.4))
    outlines = the_one(drawn[0], LineCollection).get_segments()
    for body, line in zip(disks, outlines, strict=True):
        np.testing.assert_allclose(line[:-1], body.shape.outline()[:, :2], atol=1e-12)
        assert line[0].tolist() == line[-1].tolist()
    (sphere,) = the_one(drawn[0], PolyCollection).get_paths()
    assert sphere.vertices[:-1].mean(axis=0) == pytest.approx((0.03, 0.05))
    (walls,) = drawn[0].get_lines()
    assert walls.get_xydata().min(axis=0).tolist() == [-0.1, -0.3]
    assert walls.get_xydata().max(axis=0).tolist() == [0.2, 0.4]


def test_plain_grains(drawn):
    disks = two_disks()
    sg.draw_packing("p.png", field=None)
    rigid, grains = [c for c in drawn[0].collections if type(c) is PolyCollection]
    assert not rigid.get_paths()
    for body, path in zip(disks, grains.get_paths(), strict=True):
        np.testing.assert_allclose(path.vertices[:-1], body.shape.outline()[:, :2], atol=1e-12)


def test_outline_of_points_goes_round(drawn):
    O.bodies.append(sg.soft_disk((0.02, 0.01, 0), 0.01, sg.SoftMat(), zeta=0.3, contact="points"))
    sg.draw_packing("p.png")
    (line,) = the_one(drawn[0], LineCollection).get_segments()
    turns = np.diff(np.unwrap(np.arctan2(*(line - (0.02, 0.01)).T[::-1])))
    assert (turns > 0).all() and turns.sum() == pytest.approx(2 * math.pi)


@pytest.mark.parametrize("disks, is_below", ((2, False), (12, True)))
def test_label_of_the_colours_is_whole(drawn, disks, is_below):
    """Beside a picture much wider than high there would be no room for it."""
    places = [(0.02 * k, 0, 0) for k in range(disks)]
    O.bodies.append([sg.soft_disk(place, 0.01, sg.SoftMat(), zeta=0.3) for place in places])
    sg.draw_packing("row.png")
    figure = drawn[0].figure
    figure.draw_without_rendering()
    bar = figure.axes[1]
    label = bar.xaxis.label if is_below else bar.yaxis.label
    assert label.get_text() == "von Mises stress (kPa)"
    inside, shown = figure.bbox.padded(1), label.get_window_extent()  # for rounding
    assert inside.x0 <= shown.x0 < shown.x1 <= inside.x1
    assert inside.y0 <= shown.y0 < shown.y1 <= inside.y1
