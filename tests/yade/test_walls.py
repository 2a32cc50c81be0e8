"""Walls about a box."""

import numpy as np
import pytest
from scenes import RADIUS, add_disk, ready, run
from yade import FrictMat, O, Vector3

import softgrain as sg


def test_walls_around_a_box():
    O.materials.append(FrictMat(label="walls"))
    walls = sg.walls_around(Vector3(-1, 0, 2), np.array([1, 0.5, 3]), "walls")
    O.bodies.append(walls)
    assert [w.shape.axis for w in walls] == [0, 0, 1, 1, 2, 2]
    assert [w.shape.sense for w in walls] == [1, -1] * 3
    assert [w.state.pos[k // 2] for k, w in enumerate(walls)] == [-1, 1, 0, 0.5, 2, 3]
    assert {w.material.label for w in walls} == {"walls"}
    assert sg.wall_box() == (-1, 1, 0, 0.5)


def test_they_bear_what_is_inside():
    half = 0.99 * RADIUS
    ids = O.bodies.append(sg.walls_around((-half, -half), (half, half), FrictMat()))
    add_disk()
    ready()
    run(200)
    outwards = np.array([(-1) ** (k + 1) * sg.wall_force(i)[k // 2] for k, i in enumerate(ids)])
    assert (outwards > 0).all()


@pytest.mark.parametrize(
    "low, high, message",
    [
        ((0, 0), (1, 0), r"low = \(0.0, 0.0\), high = \(1.0, 0.0\): along y low is not below"),
        ((0, 0), (1, 1, 1), "high = .*: admissible are 2 finite numbers, in m"),
        ((0, 0, 0), (1, 1, float("inf")), "high = .*: admissible are 3 finite numbers"),
        (0, (1, 1), "low = 0: admissible are 2 finite numbers"),
    ],
)
def test_what_is_no_box(low, high, message):
    with pytest.raises(ValueError, match=message):
        sg.walls_around(low, high, FrictMat())


def test_unknown_material():
    with pytest.raises(ValueError, match="material = 'steel' is unknown"):
        sg.walls_around((0, 0), (1, 1), "steel")
