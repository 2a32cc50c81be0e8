"""What is read from soft scenes."""

import math

import numpy as np
import pytest
from matplotlib.collections import TriMesh
from matplotlib.figure import Figure
from yade import FrictMat, O, utils

import softgrain as sg
from softgrain import picture

SHEAR = 3.0


def stress(rows):
    return np.array(rows, dtype=float)


@pytest.mark.parametrize(
    "cauchy, expected",
    [
        (np.diag([5.0, 5.0, 5.0]), 0),
        (np.diag([2.0, 0.0, 0.0]), 2),
        (np.diag([-2.0, 0.0, 0.0]), 2),
        (np.diag([1.0, 2.0, 4.0]), math.sqrt(7)),
        (stress([[0, SHEAR, 0], [SHEAR, 0, 0], [0, 0, 0]]), math.sqrt(3) * SHEAR),
    ],
)
def test_von_mises(cauchy, expected):
    assert sg.von_mises(cauchy) == pytest.approx(expected, abs=1e-14)


def test_von_mises_of_many():
    tensors = np.stack([np.diag([k, 0.0, 0.0]) for k in range(6)]).reshape(2, 3, 3, 3)
    np.testing.assert_allclose(sg.von_mises(tensors), [[0, 1, 2], [3, 4, 5]])


def two_disks(gap=0.0):
    """Disks of 0.01 and 0.02 m, zeta 0.3, gap between them."""
    material = sg.SoftMat()
    disks = [
        sg.soft_disk((0, 0, 0), 0.01, material, zeta=0.3),
        sg.soft_disk((0.03 + gap, 0, 0), 0.02, material, zeta=0.3),
    ]
    O.bodies.append(disks)
    return disks


def test_areas_and_packing_fraction():
    disks = two_disks()
    solid = math.pi * (0.01**2 + 0.02**2)
    assert sg.grain_area(disks[1]) == pytest.approx(math.pi * 0.02**2, rel=1e-12)
    assert sg.packing_fraction(0.01) == pytest.approx(solid / 0.01, rel=1e-12)
    assert sg.packing_fraction(0.01, nominal=True) == pytest.approx(solid / 0.01, rel=1e-12)


def test_packing_fraction_of_squeezed_grains():
    """The present area is smaller than the nominal one."""
    disks = two_disks()
    O.bodies.append(
        [
            utils.wall(-0.01, axis=0, material=FrictMat()),
            utils.wall(0.05, axis=0, material=FrictMat()),
        ]
    )
    O.bodies[2].state.vel = (3, 0, 0)
    O.engines = sg.engines()
    sg.set_time_step()
    for _ in range(80):
        O.step()
    fraction, nominal = sg.packing_fraction(0.01), sg.packing_fraction(0.01, nominal=True)
    assert 0.9 * nominal < fraction < 0.999 * nominal
    areas = [disk.shape.points()["volume"].sum() for disk in disks]
    assert fraction == pytest.approx(sum(areas) / 0.01, rel=1e-12)
    np.testing.assert_array_equal(sg.wall_force(2), O.forces.f(2))
    assert sg.wall_force(2)[0] < 0


def test_coordination_number():
    """Each end of a contact that carries force counts for its grain; a wall is a neighbour."""
    disks = two_disks(gap=-1e-5)
    O.engines = sg.engines()
    sg.set_time_step()
    assert sg.coordination_number() == 0
    disks[0].state.vel = (1, 0, 0)
    O.step()
    assert sg.coordination_number() == 1
    O.bodies.append(utils.wall(-0.00999, axis=0, material=FrictMat()))
    O.bodies[2].state.vel = (2, 0, 0)
    for _ in range(5):
        O.step()
    assert sg.coordination_number() == pytest.approx(1.5)


def test_soft_bodies_and_integrator():
    disks = two_disks()
    O.bodies.append(utils.wall(-1, axis=0, material=FrictMat()))
    assert [b.id for b in sg.soft_bodies()] == [d.id for d in disks]
    O.engines = sg.engines(label="soft")
    assert isinstance(sg.integrator(), sg.SoftGrainIntegrator)
    O.engines = []
    with pytest.raises(ValueError, match="SoftGrainIntegrator"):
        sg.integrator()


class Ledger:
    """Stands in for the integrator."""

    steps = 1

    def __init__(self, **energy):
        lost = ("friction", "impact", "damping", "sleep", "cohesion")
        self.values = dict.fromkeys(("kinetic", "elastic", "walls", "cell", "loads", *lost), 0.0)
        self.values.update(energy)

    def energy(self):
        return dict(self.values)


def keep_books(monkeypatch, ledger):
    """The ledger instead of an integrator, after a step."""
    monkeypatch.setattr("softgrain.observe.integrator", lambda: ledger)
    O.trackEnergy = True
    O.energy["softKinetic"] = ledger.values["kinetic"]


def test_balance(monkeypatch):
    """Work that is not found again is an error over the largest energy."""
    ledger = Ledger(kinetic=1.0, walls=3.0)
    keep_books(monkeypatch, ledger)
    balance = sg.Balance()
    assert balance.error() == 0
    ledger.values.update(elastic=4.0, friction=1.0, impact=0.5, walls=8.0, loads=0.5)
    assert balance.error() == pytest.approx(0)
    ledger.values.update(elastic=4.8)
    assert balance.error() == pytest.approx(0.8 / 8)
    ledger.values.update(elastic=4.0, loads=1.3)
    assert balance.error() == pytest.approx(0.8 / 8)
    ledger.values.update(friction=1.8)
    assert balance.error() == pytest.approx(0)
    ledger.values.update(loads=0.5, damping=-0.8)
    assert balance.error() == pytest.approx(0)
    ledger.values.update(elastic=0.4, friction=1.0, damping=0.0, walls=3.6)  # the largest was 8
    assert balance.error() == pytest.approx(0.8 / 8)


def test_balance_beside_rigid_bodies(monkeypatch):
    """What rigid bodies have by themselves is no measure of what soft grains miss."""
    ledger = Ledger(kinetic=1.0, rigidKinetic=1e3)
    keep_books(monkeypatch, ledger)
    balance = sg.Balance()
    ledger.values.update(kinetic=1.2, walls=0.1)
    assert balance.error() == pytest.approx(0.1 / 1.2)


def test_balance_without_energy(monkeypatch):
    keep_books(monkeypatch, Ledger())
    assert sg.Balance().error() == 0


def test_balance_begins_with_a_step():
    for track in (False, True):
        O.trackEnergy = track
        with pytest.raises(RuntimeError, match="take a step first"):
            sg.Balance()


def test_balance_ends_with_its_energies(monkeypatch):
    """Neither without tracking nor with another integrator are there energies of the last step."""
    ledger = Ledger(kinetic=1.0)
    keep_books(monkeypatch, ledger)
    balance = sg.Balance()
    ledger.steps = 0
    with pytest.raises(RuntimeError, match="take a step first"):
        balance.error()
    ledger.steps, O.trackEnergy = 1, False
    with pytest.raises(RuntimeError, match="O.trackEnergy = False"):
        balance.error()


def test_wall_box():
    for position, axis in ((0, 0), (2, 0), (-1, 1), (3, 1), (7, 2)):
        O.bodies.append(utils.wall(position, axis=axis, material=FrictMat()))
    assert picture.wall_box() == (0, 2, -1, 3)


def test_wall_box_with_too_few_walls():
    O.bodies.append(utils.wall(0, axis=0, material=FrictMat()))
    with pytest.raises(ValueError, match="two walls"):
        picture.wall_box()


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


def test_colours_are_the_stresses(monkeypatch):
    """A disk that a wall strikes and one that nothing touches, and the range of colours."""
    drawn = []
    monkeypatch.setattr(Figure, "savefig", lambda figure, *_, **__: drawn.append(figure))
    soft = sg.SoftMat(young=1e6)
    disks = [sg.soft_disk((x, 0, 0), 0.01, soft, zeta=0.3) for x in (0, 0.05)]
    O.bodies.append(disks)
    O.bodies.append(utils.wall(-0.01, axis=0, material=FrictMat()))
    O.bodies[2].state.vel = (1, 0, 0)
    O.engines = sg.engines()
    sg.set_time_step()
    sg.advance(40)
    for field, sign in (("von_mises", 1), ("pressure", -1 / 3)):
        sg.draw_packing("p.png", field=field, scale=1e6)
        (mesh,) = [c for c in drawn[-1].axes[0].collections if isinstance(c, TriMesh)]
        struck, free = np.split(mesh.get_array(), 2)
        cauchy = disks[0].shape.points()["cauchy"] / 1e6
        expected = sg.von_mises(cauchy) if field == "von_mises" else sign * np.trace(cauchy.T)
        shown = struck[: len(expected)]
        np.testing.assert_allclose(np.sort(shown), np.sort(expected), atol=1e-12)
        assert np.abs(expected).max() > 1e-3 > 1e6 * np.abs(free).max()
        assert 0.5 * expected.max() < mesh.get_clim()[1] <= expected.max()


@pytest.mark.parametrize(
    "scale, label", ((None, "(kPa)"), (2e6, "/ E"), (1e6, "/ 1e+06 Pa")), ids=str
)
def test_unit_of_the_colours(scale, label):
    O.bodies.append(sg.soft_disk((0, 0, 0), 0.01, sg.SoftMat(young=2e6), zeta=0.3))
    assert picture._unit_label(scale) == label


def area(polygon):
    x, y = polygon.T
    return 0.5 * np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))


def test_rigid_bodies_in_the_picture():
    sphere = utils.sphere((0.03, 0.01, 0), 0.01)
    box = utils.box((0, 0.05, 0), (0.02, 0.01, 0.5), orientation=((0, 0, 1), math.pi / 2))
    facet = utils.facet([(0, 0, -1), (0.1, 0.02, 1), (0, 0, 1)])
    two_disks()
    O.bodies.append([sphere, box, utils.wall(0, axis=0), facet])
    ball, block, line = picture.rigid_polygons()
    assert area(ball) == pytest.approx(math.pi * 1e-4, rel=2e-3)
    assert ball.mean(axis=0) == pytest.approx((0.03, 0.01))
    assert area(block) == pytest.approx(8e-4)
    assert np.ptp(block, axis=0) == pytest.approx((0.02, 0.04))
    assert line.tolist() == [pytest.approx(p) for p in ([0, 0], [0.1, 0.02], [0, 0])]


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


@pytest.mark.parametrize("area", (0, -1, math.nan, math.inf))
def test_area_of_a_box_that_cannot_be(area):
    with pytest.raises(ValueError, match=r"box_area = .* is outside the admissible range \(0, inf"):
        sg.packing_fraction(area)


def test_coordination_of_no_grain():
    with pytest.raises(ValueError, match="coordination_number: the scene has no soft grain"):
        sg.coordination_number()


def test_packing_fraction_of_no_grain():
    O.bodies.append(utils.sphere((0, 0, 0), 1, material=FrictMat()))
    with pytest.raises(ValueError, match="packing_fraction: the scene has no soft grain"):
        sg.packing_fraction(4)
