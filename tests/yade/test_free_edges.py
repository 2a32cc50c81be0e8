"""Soft disks pressed on, over and between free edges of facets, which stand in them as blades."""

import math

import pytest
from scenes import RADIUS, add_facets, add_wall, ready, run, soft_material
from yade import FrictMat, O

import softgrain as sg


def materials(young, friction, damping):
    soft = soft_material(
        young=young, poisson=0.3, massDamping=damping, frictionAngle=math.atan(friction)
    )
    return soft, FrictMat(frictionAngle=math.atan(friction))


def press(disk, to, speed=0.5):
    """By a wall from above, to the height `to` (over R); the largest overlap of soft grains."""
    start = disk.state.pos[1] + RADIUS * 1.001
    lid = add_wall(start, axis=1, velocity=-speed, sense=-1)
    ready()
    while lid.state.pos[1] > to * RADIUS:
        run(1)
    return sg.integrator().largestOverlap


def test_disks_fall_over_an_upright_edge():
    soft, rigid = materials(young=5e3, friction=0.3, damping=50)
    box = [((-6, -5), (6, -5)), ((-4, -5), (-4, 20)), ((4, -5), (4, 20))]
    for start, end in [((0, -5), (0, 0)), *box]:
        add_facets(start, end, rigid)
    for k in range(12):
        row, column = divmod(k, 3)
        place = ((column - 1) * 2.15 + 0.07 * row, 1.25 + 2.05 * row, 0)
        radius = RADIUS * (1 - 0.05 * (k % 2))
        O.bodies.append(sg.soft_disk([x * RADIUS for x in place], radius, soft, zeta=0.3))
    ready(gravity=(0, -9.81, 0))
    while O.time < 0.3:
        run(1)
    assert sg.integrator().largestOverlap < 0.15


@pytest.mark.parametrize("zeta", (0.25, 0.15))
def test_disk_is_pressed_on_the_end_of_a_floor(zeta):
    """It is bent about the edge, which cuts into it by half of its height."""
    soft, rigid = materials(young=1e6, friction=0, damping=500)
    add_facets((0, 0), (6, 0), rigid)
    add_facets((-6, -0.6), (0, -0.6), rigid)
    disk = sg.soft_disk((0, 1.001 * RADIUS, 0), RADIUS, soft, zeta=zeta)
    O.bodies.append(disk)
    add_wall(-1.3 * RADIUS, axis=0, sense=1)
    assert press(disk, to=0.6) < 0.2


@pytest.mark.parametrize("slope, height", [(0, 1), (30, 1.5)])
def test_disk_is_pressed_through_a_slot(slope, height):
    """What is above the lips of the slot has not come through them from what is beneath."""
    soft, rigid = materials(young=1e6, friction=0, damping=500)
    along = 4 * math.cos(math.radians(slope)), 4 * math.sin(math.radians(slope))
    for side in (-1, 1):
        start = (side * 0.4, 0)
        add_facets(start, (start[0] + side * along[0], along[1]), rigid)
    disk = sg.soft_disk((0.03 * RADIUS, height * RADIUS, 0), RADIUS, soft, zeta=0.3)
    O.bodies.append(disk)
    assert press(disk, to=0.36) < 0.7
