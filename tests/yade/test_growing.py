"""Packings to which grains are added and from which they are taken while they run."""

import gc
import math
import random
import time

import numpy as np
import pytest
from scenes import add_disk, add_wall, ready, run, soft_material
from yade import O

import softgrain as sg


def resident_set():
    """Of this process [MB]."""
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * 4096 / 1e6


def hexagon(rng, place, size, angle):
    """Corners of a hexagon like no other."""
    radii = [size * rng.uniform(0.6, 1.2) for _ in range(6)]
    angles = [angle + math.pi / 3 * k for k in range(6)]
    return [(r * math.cos(t) + place[0], r * math.sin(t) + place[1]) for r, t in zip(radii, angles)]


def any_grain(rng, place, material):
    """A small grain of some shape and size at a place."""
    size, angle = rng.uniform(0.002, 0.004), rng.uniform(0, 6)
    kind = rng.randrange(4)
    if kind == 0:
        return sg.soft_disk((*place, 0), size, material, zeta=0.5)
    if kind == 1:
        return sg.soft_superdisk((*place, 0), (size, size / 2), 3.0, angle, material, zeta=0.5)
    if kind == 2:
        return sg.soft_block((*place, 0), (size, 1.5 * size), material, zeta=0.5)
    corners = hexagon(rng, place, size, angle)  # like no other
    return sg.soft_polygon(corners, material, zeta=0.5)


def pressed_pair(material):
    """Two disks between walls, far from the others."""
    for x in (-0.01, 0.01):
        add_disk((x, -1.0, 0), 0.01, material)
    add_wall(-0.02, 0, sense=1)
    add_wall(0.02, 0, sense=-1, velocity=(-0.05, 0, 0))


@pytest.mark.parametrize("reuse", (False, True))
def test_a_thousand_grains_come_and_go(reuse):
    rng = random.Random(4)
    material = soft_material(massDamping=300.0)
    pressed_pair(material)
    ready(gravity=(0, 0, 0))
    O.dt = 1e-5  # small enough for the smallest grain: the same with and without the others
    present, free_ids, memory, templates = {}, [], [], []
    for k in range(1000):
        if len(present) == 8:
            gone = present.pop(rng.choice(sorted(present)))
            O.bodies.erase(gone)
            free_ids.append(gone)
        column = rng.choice([c for c in range(12) if c not in present])
        body = any_grain(rng, (0.05 + 0.02 * column, 0.0), material)
        if reuse and free_ids:
            present[column] = O.bodies.insertAtId(body, free_ids.pop())
        else:
            present[column] = O.bodies.append(body)
        O.step()
        templates.append(sg.integrator().templates)
        if k % 100 == 99:
            gc.collect()
            memory.append(resident_set())
    print(f"resident set after every 100 grains: {[round(m, 1) for m in memory]} MB")
    assert len(sg.soft_bodies()) == len(present) + 2
    assert max(templates) <= 10
    assert memory[-1] < memory[2] + 10
    found = np.concatenate([b.shape.nodes() for b in sg.soft_bodies()[:2]])

    O.reset()
    pressed_pair(soft_material(massDamping=300.0))
    ready(gravity=(0, 0, 0))
    O.dt = 1e-5
    for _ in range(1000):
        O.step()
    alone = np.concatenate([b.shape.nodes() for b in sg.soft_bodies()])
    difference = np.abs(found - alone).max() / 0.01
    print(f"the pressed pair differs by {difference:.1e} R from one by itself")
    assert difference < 1e-9


def test_an_erased_grain_is_freed():
    for k in range(3):
        add_disk((0.03 * k, 0, 0))
    ready()
    O.step()
    gone = sg.soft_polygon([(0.1, 0), (0.12, 0), (0.1, 0.01)], soft_material(), zeta=0.5)
    O.bodies.append(gone)
    O.step()
    assert sg.integrator().templates == 2
    O.bodies.erase(gone.id)
    O.step()
    assert sg.integrator().templates == 1


def test_grains_of_a_scene_are_freed_with_it():
    """YADE frees no engine that O.engines was set to: the integrator must not keep its grains."""
    memory = []
    for k in range(12):
        for i in range(300):
            add_disk((0.03 * i, 0, 0), zeta=0.11)
        ready()
        run(2)
        O.reset()
        gc.collect()
        memory.append(resident_set())
    left = 1e3 * (memory[-1] - memory[3]) / (8 * 300)
    print(f"a grain leaves {left:.1f} kB")
    assert left < 3  # some 25 are its own


def test_pairs_apart_do_not_keep_what_was_assembled_before():
    """Two that came near keep what was found of them, and go on to be no neighbours."""
    material = soft_material()
    for i in range(60):
        add_disk((2.02 * 0.01 * i, 0, 0), 0.01, material, zeta=0.05)
    ready()
    memory = []
    for k in range(40):
        run(1)
        for i in range(k + 1, 60):
            O.bodies[i].state.pos += (0.04 * 0.01, 0, 0)
        material.density = 1000 + k  # an assembly of its own
        memory.append(resident_set())
    print(f"{memory[5]:.0f} to {memory[-1]:.0f} MB")
    assert O.interactions.countReal() == 0 and len(O.interactions) > 50
    assert memory[-1] < memory[5] + 20  # all grains: 7


@pytest.mark.parametrize("kind", ("disks", "different polygons"))
def test_an_insertion_keeps_the_tables_of_the_others(kind):
    """A step with a new disk: the assembly is made anew, but not the tables of the others."""
    rng = random.Random(2)
    cost = {}
    for count in (20, 80):
        O.reset()
        material = soft_material()
        for k in range(count):
            place = (0.03 * (k % 20), 0.03 * (k // 20))
            if kind == "disks":
                add_disk((*place, 0), material=material)
            else:
                O.bodies.append(sg.soft_polygon(hexagon(rng, place, 0.01, 0), material, zeta=0.25))
        start = time.process_time()
        ready()
        O.step()
        first = time.process_time() - start
        took = []
        for k in range(5):
            add_disk((-0.03 * (k + 1), 0, 0))
            start = time.process_time()
            O.step()
            took.append(time.process_time() - start)
        cost[count] = min(took)
    print(
        f"insertion beside 20 {kind}: {1e3 * cost[20]:.1f} ms, beside 80: {1e3 * cost[80]:.1f};"
        f" first assembly of 80: {1e3 * first:.1f}"
    )
    assert cost[80] < 0.5 * first


def test_all_bodies_cleared_in_contact():
    """YADE leaves interactions behind, and its loop reads their bodies beyond the end of O.bodies:
    they are to be cleared too."""
    for y in range(4):
        add_disk((0, 0.0199 * y, 0))
    ready()
    run(10)
    assert O.interactions.countReal() == 3
    O.bodies.clear()
    O.interactions.clear()
    disk = add_disk()
    run(3)
    assert disk.state.vel.norm() == 0 and sg.integrator().contacts == 0
