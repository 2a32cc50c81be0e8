"""Cohesion, bonds and two coefficients of friction across the borders of a periodic cell: a pair
across a border does what it does inside."""

import math

import __main__
import numpy as np
import pytest
from periodic_scenes import set_cell
from scenes import (
    DENSITY,
    RADIUS,
    add_disk,
    assert_goes_on_after_loading,
    ready,
    run,
    soft_material,
)
from yade import FrictMat, Matrix3, O, PyRunner, utils

import softgrain as sg

SIDE = 8 * RADIUS
TOUCHING = 1.979 * RADIUS  # and 0.3 R beside it, as far as 2.002 R
LAWS = {
    "cohesion": dict(cohesion=2e3, cohesionRange=2e-4),
    "bond": dict(bondStrength=4e3, bondEnergy=0.4),
    "friction": dict(dynamicFrictAngle=math.atan(0.1)),
}
LAWS["all"] = {name: value for law in LAWS.values() for name, value in law.items()}


def soft_disks(second):
    """Two disks that touch, the second one a period away or not."""
    material = soft_material(massDamping=200.0, frictionAngle=math.atan(0.5))
    return [
        add_disk(place, material=material) for place in ((0.0, 0.0, 0.0), (second, 0.3 * RADIUS, 0))
    ]


def soft_and_rigid_disk(second):
    disk = add_disk(material=soft_material(massDamping=200.0, frictionAngle=math.atan(0.5)))
    sphere = utils.sphere(
        (second, 0.3 * RADIUS, 0),
        RADIUS,
        material=FrictMat(density=DENSITY, frictionAngle=math.atan(0.5)),
    )
    sphere.state.blockedDOFs = "zXY"
    O.bodies.append(sphere)
    sg.as_disks()
    return [disk, sphere]


def present(bodies, start):
    """What the pair is and does, wherever its grains lie."""
    found = [i for i in O.interactions if i.isReal]
    state = {
        "nodes": np.concatenate([b.shape.nodes() - start[b.id][:2] for b in sg.soft_bodies()]),
        "places": [np.array(b.state.pos) - start[b.id] for b in bodies],
        "velocities": [np.array([*b.state.vel, b.state.angVel[2]]) for b in bodies],
        "criticalDt": sg.integrator().criticalDt / O.dt,
        "pairs": len(found),
    }
    if found:
        contacts = found[0].geom.contacts()
        state["image"] = abs(found[0].cellDist[0])
        for name in ("bond", "damage", "node", "side", "force", "pressure", "gap"):
            state[name] = contacts[name]
        state["point"] = contacts["point"] - np.array(bodies[0].state.pos)
        state["sum"] = np.array(found[0].phys.normalForce + found[0].phys.shearForce)
    return state


def pull_apart(bodies, start, meanwhile):
    """Pressed together, sheared, pulled until they part; returns what was met on the way."""
    seen = []
    for step in range(1200):
        share = step / 1200
        force = np.array([24 * share - 2.0, 3 * math.sin(10 * share), 0])
        for body, sign in zip(bodies, (-1, 1)):
            O.forces.setPermF(body.id, sign * force)
        if meanwhile:
            meanwhile(step, bodies, start)
        run(1)
        if step % 40 == 0:
            seen.append(present(bodies, start))
    return seen


def history(make, second, law, meanwhile=None):
    O.reset()
    set_cell(SIDE, SIDE)
    O.trackEnergy = True
    bodies = make(second)
    start = {b.id: np.array(b.state.pos) for b in bodies}
    ready(tolerance=1e-10, maxSweeps=2000, interface=law)
    seen = pull_apart(bodies, start, meanwhile)
    seen.append({"energy": np.array(list(sg.integrator().energy().values()))})
    return seen


def assert_same(here, there, accuracy):
    scales = {"force": 10.0, "sum": 10.0, "pressure": 1e4, "velocities": 1.0, "energy": 1e-2}
    scales |= {"bond": 1, "damage": 1, "node": 1, "side": 1, "pairs": 1, "criticalDt": 1}
    assert len(here) == len(there)
    for one, other in zip(here, there):
        assert one.keys() == other.keys()
        for name, value in one.items():
            if name == "image":
                continue
            scale = scales.get(name, RADIUS)
            np.testing.assert_allclose(
                other[name], value, rtol=0, atol=accuracy * scale, err_msg=name
            )


@pytest.mark.parametrize("make", (soft_disks, soft_and_rigid_disk))
@pytest.mark.parametrize("law", LAWS)
def test_across_the_border_as_inside(law, make):
    inside, across = (history(make, x, LAWS[law]) for x in (TOUCHING, TOUCHING - SIDE))
    assert {seen["image"] for seen in inside[:-1] if "image" in seen} == {0}
    assert {seen["image"] for seen in across[:-1] if "image" in seen} == {1}
    assert inside[3]["pairs"] == 1 and inside[-2]["pairs"] == 0
    if law in ("bond", "all"):
        bonds = {b for seen in inside[:-1] for b in seen.get("bond", ())}
        assert bonds >= {1, 2}
        assert any((seen.get("damage", np.zeros(1)) % 1 > 0).any() for seen in inside[:-1])
    assert_same(inside, across, 1e-10)


@pytest.mark.parametrize("make", (soft_disks, soft_and_rigid_disk))
def test_wrapped_while_bonded(make):
    """A grain put back into the cell (Cell.wrap) keeps its bonds; each way, and twice."""

    def wrap(step, bodies, start):
        if step in (200, 400, 500):
            shift = np.array([SIDE, 0, 0]) * {200: -1, 400: 2, 500: 1}[step]
            bodies[0].state.pos = bodies[0].state.pos + shift
            start[0] = start[0] + shift

    plain = history(make, TOUCHING, LAWS["all"])
    wrapped = history(make, TOUCHING, LAWS["all"], wrap)
    assert_same(plain, wrapped, 1e-10)


SHEAR, STRETCH = (0, 60, 0, 0), (20, 30, 0, -20)


# (A cell that stretches accelerates images; with homoDeform below 2 their grains do not follow.)
@pytest.mark.parametrize("flow, homo_deform", [(SHEAR, 0), (SHEAR, 1), (SHEAR, 2), (STRETCH, 2)])
@pytest.mark.parametrize("within_step", [False, True])
def test_wrapped_in_a_dense_packing(flow, homo_deform, within_step):
    """By Cell.wrap while the cell moves, all grains at once, between steps or by an engine in one:
    nothing changes but their places."""
    results, shifts = [], []

    def wrap_grains():
        for body in sg.soft_bodies():
            there = O.cell.wrap(body.state.pos)
            shifts.append(np.array(there - body.state.pos))
            body.state.pos = there

    for wraps in (False, True):
        O.reset()
        bonded_packing(shift=(1.2 * RADIUS, 1.2 * RADIUS), count=4)  # a row, a column beyond it
        O.cell.homoDeform = homo_deform
        O.cell.velGrad = Matrix3(*flow[:2], 0, *flow[2:], 0, 0, 0, 0)
        run(400)
        links = sorted((i.id1, i.id2) for i in O.interactions if i.isReal)
        if wraps and within_step:
            __main__.wrap_grains = wrap_grains
            O.engines = [PyRunner(command="wrap_grains()", iterPeriod=1), *O.engines]
        elif wraps:
            wrap_grains()
        run(1)
        O.engines[0].dead = wraps and within_step
        assert sorted((i.id1, i.id2) for i in O.interactions if i.isReal) == links
        run(99)
        results.append([b.shape.nodes() for b in sg.soft_bodies()])
    assert sum(np.linalg.norm(s) > RADIUS for s in shifts) >= 3
    # in a step the cell moves before the engines, and grains after it
    step = np.eye(3) + O.dt * np.array(O.cell.velGrad)
    growth = np.linalg.matrix_power(step, 100 if within_step else 101)
    for here, there, shift in zip(*results, shifts):
        moved = here + (growth @ shift)[:2]
        np.testing.assert_allclose(there, moved, rtol=0, atol=1e-8 * RADIUS)


def bonded_packing(shift=(0, 0), count=3):
    """Disks of several sizes on a square lattice, nearly touching, all pairs bonded."""
    random = np.random.default_rng(3)
    spacing = 2 * RADIUS
    set_cell(count * spacing, count * spacing)
    material = soft_material(massDamping=200.0, frictionAngle=math.atan(0.5))
    for i in range(count):
        for j in range(count):
            noise = random.uniform(-0.01, 0.01, 2) * RADIUS
            place = (np.array([i, j]) + 0.5) * spacing + noise + shift
            add_disk((*place, 0), random.uniform(0.97, 0.99) * RADIUS, material)
    ready(tolerance=1e-8, maxSweeps=2000, interface=LAWS["all"])
    O.dt *= 0.8  # the user's, which stays


def strain(xx=0.0, xy=0.0, yy=0.0):
    O.cell.velGrad = Matrix3(xx, xy, 0, 0, yy, 0, 0, 0, 0)


def test_where_the_border_lies_does_not_matter():
    """A packing pressed together, bonded, stretched and sheared, moved across the borders."""
    results = []
    for shift in ((0.0, 0.0), (0.37 * 6 * RADIUS, -0.21 * 6 * RADIUS)):
        O.reset()
        bonded_packing(shift)
        strain(xx=-10.0, yy=-10.0)
        run(200)
        strain(xx=12.0, yy=2.0, xy=3.0)
        run(500)
        growth = (np.eye(3) + O.dt * np.array(O.cell.velGrad)) @ np.array(O.cell.trsf)
        real = {(i.id1, i.id2): i for i in O.interactions if i.isReal}
        results.append(
            {
                "nodes": [b.shape.nodes() - growth[:2, :2] @ shift for b in sg.soft_bodies()],
                "pairs": sorted(real),
                "bonds": [real[key].geom.contacts()["bond"].tolist() for key in sorted(real)],
            }
        )
        borders = [i for i in real.values() if tuple(i.cellDist) != (0, 0, 0)]
        assert len(borders) >= 3
    here, there = results
    assert here["pairs"] == there["pairs"] and here["bonds"] == there["bonds"]
    assert {1, 2} <= {bond for bonds in here["bonds"] for bond in bonds}
    for one, other in zip(here["nodes"], there["nodes"]):
        np.testing.assert_allclose(other, one, rtol=0, atol=1e-10 * RADIUS)


def test_flipped_while_bonded():
    """Cell.flipCell names the images anew; bonds, forces and motion stay."""
    results = []
    for flips in (False, True):
        O.reset()
        bonded_packing()
        O.cell.flipFlippable = flips
        O.cell.hSize = O.cell.hSize * Matrix3(1, 0.49, 0, 0, 1, 0, 0, 0, 1)
        strain(xy=10.0)
        run(400)
        results.append([b.shape.nodes() for b in sg.soft_bodies()])
        assert (O.cell.hSize[0, 1] < 0) == flips
    bonds = [b for i in O.interactions if i.isReal for b in i.geom.contacts()["bond"]]
    assert 1 in bonds
    for one, other in zip(*results):
        np.testing.assert_allclose(other, one, rtol=0, atol=1e-9 * RADIUS)


def test_saved_and_loaded(tmp_path):
    bonded_packing((0.37 * 6 * RADIUS, 0))
    O.trackEnergy = True
    strain(xx=-10.0, yy=-10.0)
    run(200)
    strain(xx=12.0, yy=2.0, xy=3.0)
    run(200)
    bonds = [b for i in O.interactions if i.isReal for b in i.geom.contacts()["bond"]]
    assert 1 in bonds
    assert any(i.cellDist[0] != 0 for i in O.interactions if i.isReal)
    assert_goes_on_after_loading(tmp_path / "scene.yade.gz", 200)
