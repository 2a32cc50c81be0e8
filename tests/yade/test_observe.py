"""What is read from soft scenes."""

import math

import numpy as np
import pytest
from scenes import add_wall
from yade import FrictMat, O, utils

import softgrain as sg

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
    add_wall(-0.01, axis=0, velocity=3, material=FrictMat())
    add_wall(0.05, axis=0, material=FrictMat())
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
    add_wall(-0.00999, axis=0, velocity=2, material=FrictMat())
    for _ in range(5):
        O.step()
    assert sg.coordination_number() == pytest.approx(1.5)


def test_soft_bodies_and_integrator():
    disks = two_disks()
    add_wall(-1, axis=0)
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
    """The ledger instead of an integrator, after a step of a grain."""
    O.bodies.append(sg.soft_disk((0, 0, 0), 0.01))
    monkeypatch.setattr("softgrain.balance.integrator", lambda: ledger)
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
    with pytest.raises(ValueError, match="Balance: the scene has no soft grain"):
        sg.Balance()
    O.bodies.append(sg.soft_disk((0, 0, 0), 0.01))
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
