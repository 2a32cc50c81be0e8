"""Work that is counted, and phases that are timed: nothing is done that a scene does not need."""

import itertools
import math
import re
from pathlib import Path

import numpy as np
import pytest
import yade.timing
from scenes import RADIUS, add_disk, add_wall, facet_strip, points_of, ready, run, soft_material
from yade import FrictMat, O, utils

import softgrain as sg

STEPS = 7
ARCHITECTURE = Path(__file__).resolve().parents[2] / "doc" / "architecture.md"


@pytest.fixture(autouse=True)
def timing():
    O.timingEnabled = True
    yield
    O.timingEnabled = False


def two_disks(distance, angle=0.0):
    """Two disks of different radius at a distance over the sum of their radii, approaching."""
    a = add_disk()
    apart = distance * 1.8 * RADIUS
    center = (apart * math.cos(angle), apart * math.sin(angle), 0)
    b = add_disk(center=center, radius=0.8 * RADIUS)
    ready()
    b.state.vel = (-0.1, 0, 0)
    return a, b


def test_grains_far_apart_are_neither_searched_nor_solved():
    a, b = two_disks(distance=3)
    run(STEPS)
    engine = sg.integrator()
    assert engine.pairsSearched == engine.candidatesTested == 0
    assert engine.contactsSwept == engine.totalSweeps == 0
    assert engine.pointsUpdated == points_of(a) + points_of(b)  # then they move rigidly


def test_neighbours_out_of_reach_are_told_apart_by_the_balls_about_them():
    two_disks(distance=1.2, angle=math.pi / 4)  # their boxes overlap, they do not
    run(STEPS)
    engine = sg.integrator()
    assert len(O.interactions) == 1  # potential
    assert engine.pairsSearched == engine.candidatesTested == 0
    assert engine.contactsSwept == engine.totalSweeps == 0


def test_neighbours_that_do_not_touch_keep_their_geometry():
    """It knows the nodes that come near; a new one would be searched from the beginning."""
    two_disks(distance=1.01)
    run(1)
    (pair,) = O.interactions.all()
    geometry = pair.geom
    assert geometry is not None and geometry != sg.SoftGeom()
    run(STEPS)
    assert pair.geom == geometry and not pair.isReal
    while not pair.isReal:
        run(1)
    assert pair.geom == geometry


def test_only_nodes_near_the_other_grain_are_candidates():
    a, b = two_disks(distance=1.001)
    run(STEPS)
    engine = sg.integrator()
    assert engine.contacts > 0
    nodes = len(a.shape.outline()) + len(b.shape.outline())
    assert STEPS * engine.contacts / 2 < engine.candidatesTested < 0.4 * STEPS * nodes


def test_contacts_that_close_nowhere_are_not_swept():
    """Within reach, but going apart."""
    _, b = two_disks(distance=1.001)
    b.state.vel = (0.01, 0, 0)
    engine = sg.integrator()
    for _ in range(STEPS):
        run(1)
        assert engine.contacts > 0
    assert engine.contactsSwept == engine.totalSweeps == 0
    b.state.vel = (-10, 0, 0)
    run(STEPS)
    assert engine.activeContacts > 0 and engine.contactsSwept > 0


def test_contacts_are_counted_in_every_sweep():
    two_disks(distance=1.001)
    engine = sg.integrator()
    visits = 0
    for _ in range(STEPS):
        O.step()
        visits += engine.contacts * engine.sweeps
    assert visits > 0
    assert engine.contactsSwept == pytest.approx(visits, rel=1e-12)


def test_a_wall_is_tested_against_each_node():
    body = add_disk()
    add_wall(-RADIUS, axis=0, sense=1)
    ready()
    run(STEPS)
    engine = sg.integrator()
    assert engine.pairsSearched == STEPS
    assert engine.candidatesTested == STEPS * len(body.shape.outline())


def test_counts_go_on_after_loading(tmp_path):
    two_disks(distance=1.001)
    run(STEPS)
    counts = ("pointsUpdated", "pairsSearched", "candidatesTested", "contactsSwept")
    before = [getattr(sg.integrator(), name) for name in counts]
    O.save(str(tmp_path / "scene.yade.gz"))
    O.load(str(tmp_path / "scene.yade.gz"))
    assert [getattr(sg.integrator(), name) for name in counts] == before
    O.step()
    assert sg.integrator().pointsUpdated == before[0] * (STEPS + 1) / STEPS


def search_in_packing(side, zeta=0.25):
    """Pairs searched for each grain, and candidates for each surface node, in a step of a hexagonal
    packing of side^2 disks pressed on each other, which tremble."""
    O.reset()
    spacing = 2 * 0.995 * RADIUS
    for row in range(side):
        for column in range(side):
            x, y = column + 0.5 * (row % 2), math.sqrt(0.75) * row
            add_disk(center=(spacing * x, spacing * y, 0), zeta=zeta)
    ready()
    grains, random = sg.soft_bodies(), np.random.default_rng(1)
    for body, velocity in zip(grains, random.uniform(-0.3, 0.3, (len(grains), 2))):
        body.state.vel = (*velocity, 0)
    run(5 * STEPS)
    engine, nodes = sg.integrator(), sum(len(body.shape.outline()) for body in grains)
    return (
        engine.pairsSearched / (5 * STEPS * len(grains)),
        engine.candidatesTested / (5 * STEPS * nodes),
    )


def test_search_grows_with_the_number_of_grains():
    few, many = search_in_packing(10), search_in_packing(20)
    assert few[0] > 2 and few[1] > 0.1
    assert many == pytest.approx(few, rel=0.2)  # 7 and 8 % more: fewer lie at the rim


def test_search_grows_with_the_number_of_surface_nodes():
    coarse, fine = search_in_packing(8, zeta=0.2), search_in_packing(8, zeta=0.1)
    assert fine[0] == pytest.approx(coarse[0], rel=0.1)
    assert 0 < fine[1] < 1.1 * coarse[1]


@pytest.mark.parametrize("tracked", [False, True])
def test_energies_are_summed_only_where_asked_for(tracked):
    two_disks(distance=1.001)
    O.trackEnergy = tracked
    sg.reset_times()
    run(STEPS)
    times = sg.phase_times()
    for phase in ("balanceEnergy", "publishEnergy"):
        assert times.get(phase, (0, 0))[1] == (STEPS if tracked else 0)


def test_phases_add_up_to_the_engines():
    two_disks(distance=1.001)
    run(1)  # one of them is given its velocity in it, and looked at twice
    sg.reset_times()
    run(STEPS)
    times = sg.phase_times()
    assert sum(seconds for seconds, _ in times.values()) == pytest.approx(
        1e-9 * yade.timing.runtime(), rel=1e-6
    )
    assert {count for name, (_, count) in times.items() if name != "InsertionSortCollider"} == {
        STEPS
    }


def test_phases_bear_the_names_of_the_documentation():
    two_disks(distance=1.001)
    O.trackEnergy = True
    run(STEPS)
    engines = {type(engine).__name__ for engine in O.engines}
    words = set(re.findall(r"\w+", ARCHITECTURE.read_text()))
    assert set(sg.phase_times()) - engines <= words
    assert {"findContacts", "updateForces", "solve", "move"} <= set(sg.phase_times())


def test_times_are_forgotten():
    two_disks(distance=1.001)
    run(STEPS)
    sg.reset_times()
    assert all(seconds == count == 0 for seconds, count in sg.phase_times().values())
    O.step()
    assert sg.phase_times()["findContacts"][1] == sg.phase_times()["solve"][1] == 1


def test_nothing_is_timed_unless_asked_for():
    O.timingEnabled = False
    two_disks(distance=1.001)
    run(STEPS)
    assert sg.integrator().timingDeltas.data == []
    assert sg.phase_times()["findContacts"] == (0, 0)


def sides_of_a_cube(kind):
    """About a ball that they touch, as walls, boxes or pairs of facets."""
    material, far = FrictMat(), 5 * RADIUS
    for axis, side in itertools.product(range(3), (-1, 1)):
        centre, across = np.zeros(3), np.eye(3)[[a for a in range(3) if a != axis]] * far
        centre[axis] = side * RADIUS
        if kind == "walls":
            add_wall(tuple(centre), axis, sense=-side, material=material)
        elif kind == "boxes":
            half = across.sum(axis=0) + 0.5 * RADIUS * np.eye(3)[axis]
            centre[axis] *= 1.5
            O.bodies.append(utils.box(centre, half, material=material, fixed=True))
        else:
            ends = centre - across[0], centre + across[0]
            O.bodies.append(facet_strip(ends, across[1], material))


def test_nodes_far_from_a_side_are_not_candidates():
    """Of boxes and facets no more than of walls: those that the side has before it."""
    tested = {}
    for kind in ("walls", "boxes", "facets"):
        O.reset()
        ball = sg.soft_sphere((0, 0, 0), RADIUS, soft_material(), zeta=0.3)
        O.bodies.append(ball)
        sides_of_a_cube(kind)
        ready()
        run(STEPS)
        tested[kind] = sg.integrator().candidatesTested / (STEPS * len(ball.shape.outline()))
    assert tested["boxes"] <= tested["walls"]
    assert tested["facets"] <= tested["walls"]
    assert tested["boxes"] < 0.5  # of the nodes in a step, with six sides
