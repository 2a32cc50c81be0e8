"""Sharp edges of cuboids that cross each other, or those of boxes and facets, between nodes."""

import math

import numpy as np
import pytest
from motion import angular_momentum, momentum
from scenes import (
    RADIUS,
    add,
    assert_goes_on_after_loading,
    assert_threads_change_nothing,
    ready,
    run,
    soft_material,
)
from yade import FrictMat, O, Quaternion, Vector3, utils

import softgrain as sg

ZETA = 0.4
SPEED = 0.5  # m/s
GAP = 0.05 * RADIUS
#: From the middle of a cube to its edge.
TO_EDGE = math.sqrt(2) * RADIUS


def add_cube(center, axis, material=None):
    """One that stands on an edge along `axis`, 0 or 1."""
    material = material or soft_material(poisson=0.3, frictionAngle=0.3)
    cube = sg.soft_block(center, (2 * RADIUS,) * 3, material, zeta=ZETA)
    turned_about = (1, 0, 0) if axis == 0 else (0, 1, 0)
    cube.state.ori = Quaternion(turned_about, math.pi / 4)
    return add(cube)


def add_upper_cube(height=2 * TO_EDGE, x=0):
    """Its lower edge is along y, away from the nodes of what it falls on."""
    cube = add_cube((x + 0.1 * RADIUS, 0.15 * RADIUS, height + GAP), 1)
    cube.state.vel = (0, 0, -SPEED)
    return cube


def add_two_cubes(times=1):
    for x in 4 * RADIUS * np.arange(times):
        add_cube((x, 0, 0), 0)
        add_upper_cube(x=x)
    ready()


def box():
    ori = Quaternion((1, 0, 0), math.pi / 4)
    half = (3 * RADIUS, RADIUS, RADIUS)
    material = FrictMat(frictionAngle=0.3)
    return [utils.box((0, 0, -TO_EDGE), half, orientation=ori, fixed=True, material=material)]


def facets():
    ends = [Vector3(s * 3.1, 0, 0) * RADIUS for s in (-1, 1)]
    material = FrictMat(frictionAngle=0.3)
    return [
        utils.facet([*ends, Vector3(0.1, y, -3) * RADIUS], material=material) for y in (-3, 3)
    ]


def edge_nodes(cube, upwards):
    """Nodes of the edge that is uppermost, or lowest, in the order along it."""
    outline = cube.shape.outline()
    height = outline[:, 2] if upwards else -outline[:, 2]
    found = np.flatnonzero(height > height.max() - 1e-6 * RADIUS)
    return found[np.argsort(outline[found].sum(axis=1))]


def height_of_edge(cube, nodes, along, at):
    places = cube.shape.outline()[nodes]
    return np.interp(at, places[:, along], places[:, 2])


def test_cubes_collide_edge_on_edge():
    """They touch when the edges meet, and stay apart; momenta are kept."""
    add_two_cubes()
    lower, upper = sg.soft_bodies()
    run(1)
    below, above = edge_nodes(lower, True), edge_nodes(upper, False)
    start, spin = momentum(), angular_momentum()
    touched, deepest = None, 0
    while O.time < 2 * GAP / SPEED + 3e-3:
        run(1)
        place = upper.shape.outline()[above].mean(axis=0)[0], lower.shape.outline()[below].mean(
            axis=0
        )[1]
        gap = height_of_edge(upper, above, 1, place[1]) - height_of_edge(lower, below, 0, place[0])
        deepest = max(deepest, -gap)
        if touched is None and lower.state.vel[2] < 0:
            touched = O.time
    assert touched == pytest.approx(GAP / SPEED, abs=2 * O.dt)
    assert deepest < 0.02 * ZETA * RADIUS
    assert lower.state.vel[2] < -0.3 * SPEED
    np.testing.assert_allclose(momentum(), start, rtol=0, atol=1e-12 * np.linalg.norm(start))
    scale = upper.state.mass * SPEED * RADIUS
    np.testing.assert_allclose(angular_momentum(), spin, rtol=0, atol=2e-3 * scale)


@pytest.mark.parametrize("bodies", (box, facets))
def test_cube_falls_on_an_edge(bodies):
    """Of a box, or of two facets that meet in a ridge: once, and not through it."""
    O.bodies.append(bodies())
    cube = add_upper_cube(TO_EDGE)
    ready()
    lowest = math.inf
    edge = edge_nodes(cube, False)
    while O.time < GAP / SPEED + 3e-3:
        run(1)
        lowest = min(lowest, height_of_edge(cube, edge, 1, 0))
    assert -0.02 * ZETA * RADIUS < lowest < 0.02 * ZETA * RADIUS
    assert cube.state.vel[2] > -0.5 * SPEED
    crossings = [(i.geom.contacts()["node"] == -1).sum() for i in O.interactions]
    assert sum(crossings) == 1


def fall_on_ridge(turn):
    """A cube on the ridge of two facets, the whole scene turned; returns its velocity afterwards,
    turned back."""
    ends = [Vector3(x, 0, 0) * RADIUS for x in (-3, 3)]
    for y in (-3, 3):
        foot = Vector3(0.1, y, -3) * RADIUS
        corners = [turn * x for x in (*ends, foot)]
        O.bodies.append(utils.facet(corners, material=FrictMat(frictionAngle=0.3)))
    cube = add_upper_cube(TO_EDGE)
    cube.state.pos, cube.state.vel = turn * cube.state.pos, turn * cube.state.vel
    cube.state.ori = turn * cube.state.ori
    ready()
    while O.time < GAP / SPEED + 4e-3:
        run(1)
    return np.array(turn.conjugate() * cube.state.vel)


def test_a_ridge_of_facets_bears_however_it_lies():
    expected = fall_on_ridge(Quaternion((1, 0, 0), 0))
    assert expected[2] > 0.7 * SPEED
    rng = np.random.default_rng(3)
    for _ in range(6):
        O.reset()
        turn = Quaternion(Vector3(*rng.normal(size=3)).normalized(), rng.uniform(0.1, 3))
        np.testing.assert_allclose(fall_on_ridge(turn), expected, rtol=0, atol=1e-6 * SPEED)


def fall_on_upright_facet(offset, speed):
    """The edge of a cube crosses that of one facet, so far from its middle; returns how fast it
    goes up, and how deep that of the facet was in it [dr]."""
    corners = [Vector3(x, 0, z) * RADIUS for x, z in ((-3, 0), (3, 0), (0, -4))]
    O.bodies.append(utils.facet(corners, material=FrictMat(frictionAngle=0.3)))
    cube = add_cube((0, offset * RADIUS, TO_EDGE + GAP), 1)
    cube.state.vel = (0, 0, -speed)
    ready()
    edge, lowest = edge_nodes(cube, False), 0
    while O.time < GAP / speed + 6e-3:
        run(1)
        lowest = min(lowest, height_of_edge(cube, edge, 1, 0))
    return cube.state.vel[2], -lowest / (ZETA * RADIUS)


@pytest.mark.parametrize("offset", (0.32, 0.3333, 0.36, 0.45))
def test_an_upright_facet_bears_an_edge_wherever(offset):
    """At a node, which is pressed in, too, and near the end of the edge, where the facet is less
    far from the next edge of the cube."""
    up, depth = fall_on_upright_facet(offset, 1.5)
    assert up > 0.5 and depth < 0.1


def test_crossing_edges_go_on_after_loading(tmp_path):
    add_two_cubes()
    while O.time < GAP / SPEED + 1e-3:
        run(1)
    (interaction,) = list(O.interactions)
    contacts = interaction.geom.contacts()
    crossing = contacts["node"] == -1
    assert crossing.sum() == 1 and contacts["force"][crossing].any()
    assert_goes_on_after_loading(tmp_path / "edges.yade.gz", 20)


def test_threads_do_not_change_crossing_edges():
    """Of so many cubes that they share loops, from 32 on, and sweeps, from 16 pairs in each colour
    on."""
    assert_threads_change_nothing(lambda: add_two_cubes(20), 60)
