"""Blocks inside YADE: bodies, bad input, turning, saving, observables."""

import math
import re

import numpy as np
import pytest
from motion import angular_momentum
from neo_hookean import cauchy, with_free_sides
from scenes import (
    YOUNG,
    add,
    add_disk,
    add_wall,
    assert_goes_on_after_loading,
    ready,
    run,
    soft_material,
)
from yade import O, Quaternion

import softgrain as sg

SIZE = (0.02, 0.01)


def add_block(center=(0, 0, 0), size=SIZE, **shape):
    return add(sg.soft_block(center, size, soft_material(), **{"zeta": 0.5, **shape}))


@pytest.mark.parametrize(
    "size, message",
    [
        ((0.02,), "size = (0.02,): admissible are 2 or 3 numbers in the range (0, inf) m"),
        ((0.02, -0.01), "size = (0.02, -0.01): admissible are 2 or 3 numbers in the range (0"),
        ((0.02, float("nan")), "size = (0.02, nan): admissible are 2 or 3 numbers in the range (0"),
        (0.02, "size = 0.02: admissible are 2 or 3 numbers in the range (0, inf) m"),
        ((0.02, 1e-5), "size = [0.02, 1e-05]: admissible is up to 100 times the shortest"),
    ],
)
def test_wrong_size(size, message):
    with pytest.raises(ValueError, match=re.escape(message)):
        sg.soft_block((0, 0, 0), size, soft_material())


@pytest.mark.parametrize(
    "attributes, message",
    [
        ({"form": "star"}, "form = 'star' is unknown; known: 'ball', 'block'"),
        ({"aspect": (2, 1, 1)}, "aspect = 2 is outside the admissible range 1 for a ball"),
        ({"form": "block", "aspect": (2, 1, 2)}, "aspect[2] = 2 is outside"),
        ({"form": "block", "aspect": (2, 1.5, 1)}, "aspect (smaller component) = 1.5 is outside"),
        ({"form": "block", "aspect": (2, 1, 1)}, None),  # the third component is 1 in 2D
        ({"contact": "mesh"}, "contact = 'mesh' is unknown; known: 'surface', 'points', 'nodes'"),
    ],
)
def test_wrong_shape(attributes, message):
    if message is None:
        sg.SoftGrain(dim=2, **attributes)
        return
    with pytest.raises(ValueError, match=re.escape(message)):
        sg.SoftGrain(dim=2, **attributes)


def test_mass_inertia_and_area():
    block = add_block(zeta=0.25)
    area = SIZE[0] * SIZE[1]
    assert block.state.mass == pytest.approx(1000 * area, rel=1e-12)
    inertia = 1000 * area * (SIZE[0] ** 2 + SIZE[1] ** 2) / 12
    assert block.state.inertia[2] == pytest.approx(inertia, rel=1e-12)
    assert block.shape.undeformedVolume() == pytest.approx(area, rel=1e-12)
    assert sg.grain_area(block) == pytest.approx(area, rel=1e-12)
    assert sg.packing_fraction(2 * area, nominal=True) == pytest.approx(0.5, rel=1e-12)


def test_outline_of_a_turned_block():
    block = add_block(center=(1, 2, 0))
    block.state.ori = Quaternion((0, 0, 1), math.pi / 2)
    low, high = (f(block.shape.outline()[:, :2], axis=0) for f in (np.min, np.max))
    np.testing.assert_allclose(high - low, SIZE[::-1], rtol=1e-12)
    np.testing.assert_allclose((low + high) / 2, (1, 2), rtol=1e-12)


def test_cuboid_rests_on_a_wall():
    add_block(size=(0.02, 0.01, 0.03))
    floor = add_wall(-0.005, 1)
    ready(gravity=(0, -1000, 0))
    forces = []
    for _ in range(400):
        O.step()
        forces.append(-O.forces.f(floor.id)[1])
    assert np.mean(forces) == pytest.approx(6e-6 * 1000 * 1000, rel=0.1)


def test_saved_block_goes_on_with_the_same_bits(tmp_path):
    add_block()
    add_disk((0.001, 0.0099, 0), radius=0.005)
    add_wall(-0.005, 1, friction=0.3)
    ready(gravity=(0, -100, 0))
    run(50)
    assert_goes_on_after_loading(tmp_path / "scene.xml", 50)


@pytest.mark.parametrize("contact", ("surface", "points", "nodes"))
def test_geometries_hold_a_block(contact):
    """The weight is carried on average, and the block stays near its place."""
    block = add_block(zeta=0.25, contact=contact)
    floor = add_wall(-0.005, 1)
    ready(gravity=(0, -100, 0))
    forces = []
    while O.time < 0.05:
        O.step()
        forces.append(-O.forces.f(floor.id)[1])
    late = forces[len(forces) // 2 :]
    assert np.mean(late) == pytest.approx(block.state.mass * 100, rel=0.1)
    assert abs(block.state.pos[1]) < 0.15 * SIZE[1]
    pressures = O.interactions[floor.id, block.id].geom.contacts()["pressure"]
    assert (np.max(pressures) > 0) == (contact == "surface")


def test_picture(tmp_path):
    add_block()
    sg.draw_packing(tmp_path / "block.png")
    assert (tmp_path / "block.png").stat().st_size > 1000


def force_over_exact(zeta, size):
    """Of a block squeezed by 5 % along y between frictionless walls, free to widen (nu = 0.3)."""
    strain, height = 0.05, size[1]
    material = soft_material(poisson=0.3, massDamping=2000)
    O.bodies.append(sg.soft_block((0, 0, 0), size, material, zeta=zeta))
    add_wall(-height / 2, axis=1)
    top = add_wall(height / 2, axis=1, velocity=(0, -0.2, 0))
    ready()
    sg.set_time_step(0.8)
    while height / 2 - top.state.pos[1] < strain * height:
        run(5)
    top.state.vel = (0, 0, 0)
    run(1500 if len(size) == 2 else 300)
    squeezed = 0.5 + top.state.pos[1] / height
    stretches = with_free_sides(squeezed, len(size) - 1, 0.3)
    stress, *_ = cauchy(stretches, YOUNG, 0.3)
    area = math.prod(stretches[1:]) * math.prod(size) / height  # as widened
    return -sg.wall_force(top.id)[1] / (stress * area)


@pytest.mark.parametrize(
    "zeta, sides",
    [
        *((zeta, (2, 2)) for zeta in (0.15, 0.18, 0.22, 0.33, 0.4, 0.5)),
        (0.11, (2, 2.3)),
        (0.15, (3.1, 2)),
        *((zeta, (2, 2, 2)) for zeta in (0.3, 0.4, 0.5)),
        (0.4, (2, 2.7, 2.2)),
    ],
)
def test_squeezed_block_is_as_stiff_as_it_should_be(zeta, sides):
    """Whatever its sides are over the spacing of background nodes; a wall that stands still."""
    assert force_over_exact(zeta, [side * 0.01 for side in sides]) == pytest.approx(1, abs=0.012)


@pytest.mark.parametrize("torque", ((1e-6, 0, 0), (0, 2e-6, 0), (3e-6, -1e-6, 2e-6)), ids=str)
def test_torque_on_a_turned_cuboid(torque):
    """It is what the angular momentum gains, along whatever axis."""
    body = add_block(size=(0.01, 0.01, 0.04))
    body.state.ori = Quaternion((1, 2, -1), 0.7)
    ready()
    O.forces.setPermT(body.id, torque)
    run(5)
    before, start = angular_momentum(), O.time
    run(40)
    gained = (angular_momentum() - before) / (O.time - start)
    np.testing.assert_allclose(gained, torque, atol=1e-6 * np.linalg.norm(torque))
