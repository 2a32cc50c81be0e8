"""Damped grains that came to rest sleep: nothing is done for them, and nothing changes by it."""

import gzip
import math
import re

import numpy as np
import pytest
from periodic_scenes import set_cell
from scenes import (
    RADIUS,
    add_disk,
    add_wall,
    assert_same_bits,
    present_state,
    ready,
    run,
    soft_material,
)
from sleep_scenes import (
    FLOORS,
    GRAVITY,
    all_wake,
    asleep,
    box_below,
    forces,
    heap,
    newton,
    on_all_floors,
    rest,
    rough,
)
from yade import Matrix3, O, Quaternion, Vector3, utils

import softgrain as sg


@on_all_floors
def test_same_results_without(floor):
    """Places and forces to 1e-5 of the radius and of the weight; nothing jumps."""
    states = []
    for sleep in (True, False):
        heap(sleep=sleep, floor=floor)
        run(9000)
        assert all(asleep()) == sleep
        states.append((present_state(), forces()))
        energy = sg.integrator().energy()
    with_it, without = states
    np.testing.assert_allclose(with_it[0]["nodes"], without[0]["nodes"], atol=1e-5 * RADIUS)
    weight = sum(body.state.mass for body in sg.soft_bodies()) * GRAVITY
    np.testing.assert_allclose(with_it[1], without[1], atol=1e-4 * weight)
    assert energy["sleep"] == 0


def test_nothing_is_done():
    heap()
    balance = None
    while not all(asleep()):
        run(1)
        balance = balance or sg.Balance()
    before = balance.error()
    engine = sg.integrator()
    run(2)
    counts = [engine.pointsUpdated, engine.contactsSwept, engine.candidatesTested]
    state, on_bodies = present_state(), forces()
    interactions = [(i.phys.normalForce, i.geom.contacts()["impulse"]) for i in O.interactions]
    run(100)
    assert [engine.pointsUpdated, engine.contactsSwept, engine.candidatesTested] == counts
    assert (engine.activeGrains, engine.sleepingGrains) == (0, 3)
    assert_same_bits({**present_state(), "time": state["time"]}, state)
    np.testing.assert_array_equal(forces(), on_bodies)
    for now, then in zip(O.interactions, interactions):
        assert now.phys.normalForce == then[0]
        np.testing.assert_array_equal(now.geom.contacts()["impulse"], then[1])
    weight = sum(body.state.mass for body in sg.soft_bodies()) * GRAVITY
    walls = [body.id for body in O.bodies if body not in sg.soft_bodies()]
    assert on_bodies[walls, 1].sum() == pytest.approx(-weight, rel=1e-4)
    assert engine.energy()["kinetic"] == 0
    assert 0 < engine.energy()["sleep"] == engine.droppedEnergy
    assert engine.droppedEnergy < 1e-8 * engine.energy()["elastic"]
    assert 0 < engine.droppedMomentum < 1e-5 * weight * 1e-3  # of the weight in a millisecond
    assert balance.error() < before + 1e-9


def load(share):
    """The disk on top by a share of its weight more."""
    top = sg.soft_bodies()[2]
    O.forces.setPermF(top.id, (0, -share * GRAVITY * top.state.mass, 0))


def push_a_disk():
    sg.soft_bodies()[2].state.vel = (0.1, 0, 0)


def shift_a_disk():
    sg.soft_bodies()[2].state.pos += Vector3(0, 0.1 * RADIUS, 0)


def turn_a_disk():
    sg.soft_bodies()[2].state.ori = Quaternion(Vector3(0, 0, 1), 0.1)


def turn_gravity():
    newton().gravity = (1e-3 * GRAVITY, -GRAVITY, 0)


def load_a_disk():
    load(0.1)


def move_a_wall():
    O.bodies[3].state.vel = (0, -0.1, 0)


def shift_a_wall():
    O.bodies[3].state.pos -= Vector3(0, 1e-3 * RADIUS, 0)


def soften_the_material():
    sg.soft_bodies()[0].material.young = 0.9e6


def damp_less():
    sg.soft_bodies()[0].material.massDamping = 100


def smooth_a_pair():
    next(iter(O.interactions)).phys.tangensOfFrictionAngle = 0.01


def erase_a_disk():
    O.bodies.erase(2)


def erase_an_interaction():
    pair = next(iter(O.interactions))
    O.interactions.erase(pair.id1, pair.id2)
    return pair.id1, pair.id2


def switch_off():
    sg.integrator().sleep = False


CHANGES = (
    push_a_disk,
    shift_a_disk,
    turn_a_disk,
    turn_gravity,
    load_a_disk,
    move_a_wall,
    shift_a_wall,
    soften_the_material,
    damp_less,
    smooth_a_pair,
    erase_a_disk,
    erase_an_interaction,
    switch_off,
)


@pytest.mark.parametrize("change", CHANGES, ids=lambda change: change.__name__)
@pytest.mark.parametrize("floor", FLOORS[:2], ids=lambda floor: floor.__name__)
@pytest.mark.parametrize("loaded", (False, True), ids=("", "loaded"))
def test_woken_by(change, floor, loaded, tmp_path):
    heap(floor=floor)
    rest()
    run(5)
    if loaded:
        O.save(str(tmp_path / "asleep.yade.bz2"))
        O.load(str(tmp_path / "asleep.yade.bz2"))
    changed = change()
    run(1)
    if change is erase_an_interaction:  # it is made anew at once: who else would feel it?
        assert asleep() == [k not in changed for k in range(3)]
        return
    all_wake()
    run(1)
    assert sg.integrator().sleepingGrains == 0


@on_all_floors
def test_who_does_not_feel_it_sleeps_on(floor):
    """What holds a sleeper beside one that is awake is little, and nothing is lost of what that
    does to it."""
    heap(floor=floor)
    rest()
    engine, steps = sg.integrator(), 400
    nodes = [body.shape.nodes() for body in sg.soft_bodies()]
    before, swept = forces(), engine.totalGrainSteps
    load(1e-3)
    run(1)
    assert asleep() == [True, True, False]
    assert (engine.activeGrains, engine.sleepingGrains) == (1, 2)
    balance = sg.Balance()
    run(steps)
    assert asleep() == [True, True, False]
    assert engine.totalGrainSteps - swept == steps + 1
    for k in (0, 1):
        np.testing.assert_array_equal(sg.soft_bodies()[k].shape.nodes(), nodes[k])
    more = forces() - before
    weight = GRAVITY * sg.soft_bodies()[2].state.mass
    np.testing.assert_allclose(more[:2, :2].sum(axis=0), (0, -1e-3 * weight), atol=1e-4 * weight)
    np.testing.assert_array_equal(more[3:], 0)
    assert balance.error() < 1e-9
    rest()
    load(0.1)
    run(1)
    all_wake()


@pytest.mark.parametrize("suffix", ("yade.bz2", "xml.gz"))
def test_saved_while_some_sleep(suffix, tmp_path):
    """A loaded run goes on with the same bits: who sleeps beside one that is awake sleeps on, and
    is woken in the same step."""
    heap(floor=box_below)
    rest()
    sg.soft_bodies()[2].state.vel = (1e-5, 0, 0)
    run(10)
    assert asleep() == [True, True, False]
    O.save(str(tmp_path / f"scene.{suffix}"))

    def go_on():
        run(20)
        states = [present_state(), {"forces": forces(), "asleep": np.array(asleep())}]
        assert asleep() == [True, True, False]
        push_a_disk()
        run(1)
        all_wake()
        return [*states, {"steps": np.array([O.iter])}, present_state()]

    after = go_on()
    O.load(str(tmp_path / f"scene.{suffix}"))
    for found, expected in zip(go_on(), after):
        assert_same_bits(found, expected)


def test_sleepers_sleep_on_while_others_come_and_go():
    """The assembly is made anew, of kinds in another order; nothing of the sleepers changes, and
    what falls on them wakes them as before."""
    heap()
    rest()
    run(5)
    nodes = [b.shape.nodes() for b in sg.soft_bodies()]
    pushed = forces()
    far = [add_disk((30 * RADIUS, (20 + 3 * k) * RADIUS, 0), zeta=0.4 - 0.1 * k) for k in (0, 1)]
    run(1)
    O.bodies.erase(far[0].id)
    run(3)
    assert asleep() == [True, True, True, False]
    for body, before in zip(sg.soft_bodies(), nodes):
        np.testing.assert_array_equal(body.shape.nodes(), before)
    np.testing.assert_allclose(forces()[: len(pushed)], pushed, rtol=0, atol=1e-12 * GRAVITY)
    far[1].state.pos = (1.05 * RADIUS, 4.5 * RADIUS, 0)
    far[1].state.vel = (0, -1, 0)
    while all(asleep()[:3]):
        run(1)
        assert O.iter < 40000
    all_wake()


def test_woken_by_a_falling_disk():
    heap()
    add_disk((1.05 * RADIUS, 6 * RADIUS, 0))
    sg.soft_bodies()[3].state.vel = (0, 1, 0)
    newton().gravity = (0, 0, 0)
    for body in sg.soft_bodies()[:3]:
        O.forces.setPermF(body.id, (0, -GRAVITY * body.state.mass, 0))
    while sum(asleep()) < 3:
        run(1)
        assert O.iter < 30000
    sg.soft_bodies()[3].state.pos = (1.05 * RADIUS, 6 * RADIUS, 0)
    sg.soft_bodies()[3].state.vel = (0, -1, 0)
    while sum(asleep()) == 3:
        run(1)
        assert O.iter < 60000
    all_wake()
    run(100)
    assert sg.integrator().activeGrains == 4


@pytest.mark.parametrize("steps", (1, 4))
def test_moved_by_hand_while_asleep(steps):
    """Once, not in every step: it falls asleep again in the same one."""
    disk = add_disk()
    ready()
    run(5)
    assert asleep() == [True]
    start = disk.shape.outline()[:, :2]
    disk.state.pos = (0.5 * RADIUS, 0, 0)
    disk.state.ori = Quaternion((0, 0, 1), 0.3)
    run(steps)
    c, s = math.cos(0.3), math.sin(0.3)
    expected = start @ [[c, s], [-s, c]] + (0.5 * RADIUS, 0)
    np.testing.assert_allclose(disk.shape.outline()[:, :2], expected, atol=1e-12 * RADIUS)
    np.testing.assert_allclose(disk.state.pos, (0.5 * RADIUS, 0, 0), atol=1e-15)


def test_undamped_grains_do_not_sleep():
    """And are not changed by the switch."""
    states = []
    for sleep in (True, False):
        heap(damping=0, sleep=sleep)
        run(400)
        states.append(present_state())
        assert sg.integrator().droppedMomentum == 0
    assert_same_bits(*states)


@pytest.mark.parametrize("suffix", ("yade.bz2", "xml.gz"))
@pytest.mark.parametrize("when", ("falling asleep", "asleep"))
@on_all_floors
def test_save_and_load(floor, when, suffix, tmp_path):
    """A loaded run goes on with the same bits: asleep, and woken later."""
    heap(floor=floor)
    if when == "asleep":
        rest()
    else:
        run(2000)
    run(10)
    assert all(asleep()) == (when == "asleep")
    O.save(str(tmp_path / f"scene.{suffix}"))

    def go_on():
        rest()
        run(20)
        states = [present_state(), {"forces": forces()}]
        for interaction in sorted(O.interactions, key=lambda i: (i.id1, i.id2)):
            states.append(interaction.geom.contacts())
        turn_gravity()
        run(50)
        assert not any(asleep())
        return [*states, present_state()]

    after = go_on()
    O.load(str(tmp_path / f"scene.{suffix}"))
    assert all(asleep()) == (when == "asleep")
    for found, expected in zip(go_on(), after):
        assert_same_bits(found, expected)


@pytest.mark.parametrize("least, most", ((8, 30), (30, 999)), ids=("pairs", "grains"))
def test_saved_otherwise_is_refused(least, most, tmp_path):
    """Lists of numbers as another version may save them, of pairs and of grains."""
    heap(floor=box_below)
    rest()
    path = str(tmp_path / "scene.xml.gz")
    O.save(path)

    def cut(match):
        items = re.findall("<item>[^<]*</item>", match[0])
        return (
            match[0]
            if not least < len(items) < most
            else match[0]
            .replace(f"<count>{len(items)}<", "<count>4<")
            .replace("".join(re.findall("<item>.*</item>", match[0], re.S)), "".join(items[:4]))
        )

    with gzip.open(path, "rt") as file:
        text = file.read()
    with gzip.open(path, "wt") as file:
        file.write(re.sub("<savedRest>.*?</savedRest>", cut, text, flags=re.S))
    O.load(path)
    with pytest.raises(RuntimeError, match="saved asleep with 4 figures|figures at rest"):
        O.step()


def test_woken_by_a_period_that_changes():
    """Disks in a row that presses on itself across the border, on a box in a periodic cell."""
    set_cell(7.98 * RADIUS, 30 * RADIUS)
    material = soft_material(massDamping=4000.0, frictionAngle=math.atan(0.3))
    for k in range(4):
        add_disk((1.995 * (k + 0.5) * RADIUS, 0, 0), material=material)
    half = (20 * RADIUS, RADIUS, RADIUS)
    middle = (3.99 * RADIUS, -2 * RADIUS, 0)  # all grains lie on the box itself, on no image
    O.bodies.append(utils.box(middle, half, fixed=True, material=rough()))
    ready(gravity=(0, -GRAVITY, 0))
    rest()
    O.cell.hSize = Matrix3(7.9 * RADIUS, 0, 0, 0, 30 * RADIUS, 0, 0, 0, 1)
    run(1)
    all_wake()


def test_another_condition_before_saving(tmp_path):
    """What was known of a sleeping disk in plane strain is of no use in plane stress."""
    forces = []
    for saved in (False, True):
        O.reset()
        floor = add_wall(-RADIUS, 1, friction=0.5)
        wall = add_wall(RADIUS, 1, friction=0.5, velocity=(0, -1, 0))
        disk = add_disk(material=soft_material(massDamping=2000, frictionAngle=0.5))
        ready()
        while wall.state.pos[1] > 0.9 * RADIUS:
            run(1)
        wall.state.vel = (0, 0, 0)
        run(4000)
        assert sg.integrator().sleepingGrains == 1
        pressed = sg.wall_force(floor.id)[1]
        disk.material.condition = "planeStress"
        if saved:
            O.save(str(tmp_path / "asleep.yade.gz"))
            O.load(str(tmp_path / "asleep.yade.gz"))
        run(300)
        forces.append(sg.wall_force(floor.id)[1])
    assert forces[0] == forces[1] != pressed
