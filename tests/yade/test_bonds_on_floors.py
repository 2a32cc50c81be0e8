"""Interface laws on floors that several rigid bodies make: on seams contacts go on."""

import numpy as np
import pytest
from interface_scenes import BOND, SIDE, add_block, damped
from scenes import RADIUS, add_wall, ready, run
from yade import FrictMat, O, utils

import softgrain as sg

RIGID = FrictMat(frictionAngle=0, density=2000)
EDGES = tuple(np.linspace(-2 * SIDE, 4 * SIDE, 49))  # every second one below a contact node


def add_wall_floor():
    add_wall(0, axis=1)


def add_facets(edges=EDGES, material=RIGID):
    """Of a floor across the plane of the grains; their ids."""
    facets = []
    for a, b in zip(edges, edges[1:]):
        corners = [(a, 0, -SIDE), (b, 0, -SIDE), (0.5 * (a + b), 0, 2 * SIDE)]
        # the plane of the grains cuts it where it is 2/3 as wide
        middle = 0.5 * (a + b)
        corners = [(middle + 1.5 * (x - middle), y, z) for x, y, z in corners]
        facets.append(utils.facet(corners, material=material))
    return O.bodies.append(facets)


def add_boxes(edges=EDGES):
    O.bodies.append(
        [
            utils.box(
                (0.5 * (a + b), -SIDE, 0), (0.5 * (b - a), SIDE, SIDE), fixed=True, material=RIGID
            )
            for a, b in zip(edges, edges[1:])
        ]
    )


def add_mesh(cells=8):
    """A square floor of triangles across z, nodes of a cube on its seams."""
    x = np.linspace(-SIDE, SIDE, cells + 1)
    O.bodies.append(
        [
            utils.facet([(x[i + di], x[j + dj], 0) for di, dj in corners], material=RIGID)
            for i in range(cells)
            for j in range(cells)
            for corners in (((0, 0), (1, 0), (1, 1)), ((0, 0), (1, 1), (0, 1)))
        ]
    )


FLOORS = {"facets": add_facets, "boxes": add_boxes}
each_floor = pytest.mark.parametrize("floor", FLOORS)


def bonded():
    pairs = [i for i in O.interactions if i.isReal]
    return sum(int((i.geom.contacts()["bond"] == 1).sum()) for i in pairs)


def slide(add_floor):
    """A block that was bonded at touch slides three of its sides far, without friction. Returns
    the work of the bonds over what it takes to break them once, and the speed that is left."""
    O.reset()
    add_floor()
    block = add_block(0, damped())
    O.trackEnergy = True
    ready(gravity=(0, -20, 0), interface=BOND)
    run(300)
    before = sg.integrator().energy()["cohesion"]
    block.state.vel = (0.5, 0, 0)
    while block.state.pos[0] < 3 * SIDE and block.state.vel[0] > 0.05:
        run(10)
    work = sg.integrator().energy()["cohesion"] - before
    return work / (BOND["bondEnergy"] * SIDE), block.state.vel[0]


@each_floor
def test_broken_bonds_stay_broken(floor):
    work, speed = slide(add_wall_floor)
    found = slide(FLOORS[floor])
    assert found[0] == pytest.approx(work, abs=0.1)
    assert found[1] == pytest.approx(speed, rel=0.03)
    assert sg.integrator().lostBonds == 0


def tear(add_floor, grain, axis, toward):
    """Pull bonds made by hand apart, slowly; the largest force, and the work that they took."""
    O.reset()
    add_floor()
    O.bodies.append(grain())
    (body,) = sg.soft_bodies()
    O.trackEnergy = True
    ready(interface=dict(bondAtTouch=False, **BOND))
    run(2)
    area = SIDE if body.shape.dim == 2 else SIDE**2
    assert sum(i.geom.bond() for i in O.interactions if i.isReal) == bonded() > 5
    start, full = np.array(body.state.pos), BOND["bondStrength"] * area
    force = np.zeros(3)
    while np.linalg.norm(np.array(body.state.pos) - start) < 3e-4:
        force += full / 2000 * np.array(toward)
        O.forces.setPermF(body.id, force - 0.1 * full * np.eye(3)[axis] * (toward[axis] == 0))
        run(1)
        assert O.iter < 4000
    work = sg.integrator().energy()["cohesion"]
    return np.linalg.norm(force) / full, work / (BOND["bondEnergy"] * area)


def block():
    return sg.soft_block((0, RADIUS, 0), (SIDE, SIDE), damped(), zeta=0.25)


def cube():
    return sg.soft_block((0, 0, RADIUS), (SIDE, SIDE, SIDE), damped(), zeta=0.5)


@pytest.mark.parametrize("toward", ((0, 1, 0), (1, 0, 0)), ids=("opening", "slip"))
@pytest.mark.parametrize("pieces", (8, 16, 17))
def test_bonds_bear_on_seams(pieces, toward):
    """The same as on a wall, wherever the seams are."""
    edges = np.linspace(-2 * SIDE, 2 * SIDE, pieces * 2 + 1)
    on_wall = tear(add_wall_floor, block, 1, toward)
    on_facets = tear(lambda: add_facets(edges), block, 1, toward)
    np.testing.assert_allclose(on_facets, on_wall, rtol=0.02)
    assert sg.integrator().lostBonds == 0


@pytest.mark.parametrize("toward", ((0, 0, 1), (1, 0, 0)), ids=("opening", "slip"))
def test_bonds_bear_on_a_mesh(toward):
    on_wall = tear(lambda: add_wall(0, axis=2), cube, 2, toward)
    on_mesh = tear(add_mesh, cube, 2, toward)
    np.testing.assert_allclose(on_mesh, on_wall, rtol=0.02)
    assert sg.integrator().lostBonds == 0
