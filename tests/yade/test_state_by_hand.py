"""What a script writes into the State of soft grains and is no motion of theirs."""

import math

import numpy as np
import pytest
from scenes import (
    RADIUS,
    ZETA,
    add_disk,
    add_wall,
    damped_material,
    message_of_step,
    ready,
    run,
    soft_material,
)
from yade import O, Quaternion

import softgrain as sg


@pytest.mark.parametrize("attribute", ("pos", "vel"))
def test_state_that_is_no_number(attribute):
    disk = add_disk()
    ready()
    run(2)
    setattr(disk.state, attribute, (float("nan"), 0, 0))
    message = message_of_step(3)
    assert "#0" in message


def test_farther_away_than_numbers_resolve():
    disk = add_disk((1e6 * RADIUS, 0, 0))
    ready()
    run(2)
    disk.state.pos = (0, -1e200, 0)
    message = message_of_step()
    assert "grain #0 lies 1e+202 radii from the origin, more than the admissible 1e8" in message


@pytest.mark.parametrize("ori", [(2, 0, 0, 1), (math.nan, 0, 0, 0)], ids=str)
def test_orientation_that_is_no_rotation(ori):
    body = add_disk()
    ready()
    body.state.ori = Quaternion(*ori)
    assert "soft grain #0: its State.ori has the norm" in message_of_step()


@pytest.mark.parametrize(
    "attribute, value",
    [
        ("vel", (math.nan, 0, 0)),
        ("ori", Quaternion((1, 0, 0), 0.5)),
        ("ori", Quaternion((0, 1, 0), math.pi)),
        ("ori", Quaternion(2, 0, 0, 1)),
    ],
    ids=str,
)
def test_motion_before_the_first_step(attribute, value):
    """It is refused, and nothing of it stays once it is mended."""
    body, other = add_disk(), add_disk((10 * RADIUS, 0, 0))
    setattr(body.state, attribute, value)
    O.engines = sg.engines()
    O.dt = 1e-6
    assert "soft grain #0: its State" in message_of_step()
    body.state.vel, body.state.ori = (0, 0, 0), Quaternion((0, 0, 1), 0)
    run(2)
    places = [b.shape.nodes() - np.array(b.state.pos)[:2] for b in (body, other)]
    np.testing.assert_allclose(*places, rtol=0, atol=1e-12 * RADIUS)


def test_turned_out_of_the_plane():
    body = add_disk()
    ready()
    body.state.ori = Quaternion((1, 0, 0), 0.5)
    assert "turns it out of the plane of 2D grains" in message_of_step()


@pytest.mark.parametrize(
    "attribute, value",
    [("pos", (0, 0, RADIUS)), ("vel", (1, 0, 1)), ("angVel", (1, 0, 0)), ("angVel", (0, 1, 2))],
)
def test_motion_out_of_the_plane(attribute, value):
    """It would be lost."""
    body = add_disk()
    ready()
    run(2)
    setattr(body.state, attribute, value)
    message = message_of_step()
    assert f"soft grain #0: its State.{attribute}" in message and "plane of 2D grains" in message


@pytest.mark.parametrize("force, torque", [((0, 0, 5), (0, 0, 0)), ((1, 0, 0), (1, 0, 1))])
def test_load_across_the_plane(force, torque):
    """It would be lost."""
    add_disk()
    body = add_disk((4 * RADIUS, 0, 0))
    ready()
    run(2)
    O.forces.setPermF(body.id, force)
    O.forces.setPermT(body.id, torque)
    message = message_of_step()
    assert "soft grain #1: O.forces across the plane of 2D grains (force" in message
    O.forces.setPermF(body.id, (1, 2, 0))
    O.forces.setPermT(body.id, (0, 0, 3))
    run(1)


def test_put_elsewhere_while_in_contact():
    """What it touched is not pushed any more."""
    hit, struck = add_disk(), add_disk((2.002 * RADIUS, 0, 0))
    hit.state.vel = (1, 0, 0)
    ready()
    while sg.integrator().activeContacts == 0:
        run(1)
    hit.state.pos = (-0.5, 0.3, 0)
    before = struck.state.vel[0]
    run(3)
    assert sg.integrator().contacts == 0
    assert struck.state.vel[0] == pytest.approx(before, rel=1e-9)


def test_put_into_another():
    moved = add_disk()
    add_disk((2.002 * RADIUS, 0, 0))
    moved.state.vel = (1, 0, 0)
    ready()
    while sg.integrator().activeContacts == 0:
        run(1)
    moved.state.pos += (0.9 * RADIUS, 0, 0)
    assert "overlap by" in message_of_step()


def free_blocks(gap):
    """Two that lie still, and so sleep."""
    side, material = 2 * RADIUS, soft_material()
    blocks = [
        sg.soft_block((x, 0, 0), (side, side), material, zeta=ZETA) for x in (0, side + gap)
    ]
    O.bodies.append(blocks)
    ready()
    run(20)
    assert all(block.shape.isAsleep() for block in blocks)
    return blocks


@pytest.mark.parametrize("turned", [False, True])
def test_sleeper_put_against_a_sleeper(turned):
    """Neither moves, and nobody else would look for a contact."""
    first, second = free_blocks(gap=0.1 * RADIUS if turned else 0.5 * RADIUS)
    if turned:  # its centre stays, which is all that the collider watches
        first.state.ori = Quaternion((0, 0, 1), 0.2)
    else:
        first.state.pos = (0.52 * RADIUS, 0, 0)
    run(50)
    assert sg.integrator().contacts > 0
    assert not first.shape.isAsleep() and not second.shape.isAsleep()


@pytest.mark.parametrize("asked", (False, True))
def test_sleepers_that_a_smaller_cell_brings_together(asked):
    """Also where the scene is assembled between two steps."""
    O.periodic = True
    O.cell.setBox(6 * RADIUS, 6 * RADIUS, RADIUS)
    blocks = free_blocks(gap=0.5 * RADIUS)
    O.cell.setBox(4.48 * RADIUS, 6 * RADIUS, RADIUS)
    for _ in range(3):
        if asked:
            sg.critical_time_step()
        run(1)
    run(47)
    assert sg.integrator().contacts > 0
    assert not any(block.shape.isAsleep() for block in blocks)


def test_sleeper_whose_floor_is_turned():
    disk, floor = add_disk(material=damped_material()), add_wall(-RADIUS, axis=1)
    floor.state.pos = (-5 * RADIUS, -RADIUS, 0)
    ready(gravity=(0, -10, 0))
    while not disk.shape.isAsleep():
        run(1)
    floor.shape.axis = 0
    run(2)
    assert not disk.shape.isAsleep()
    assert disk.state.vel[1] < 0


def test_sleeper_put_into_a_sleeper():
    free_blocks(gap=0.5 * RADIUS)[0].state.pos = (RADIUS, 0, 0)
    assert "overlap by" in message_of_step(10)


def test_sleepers_that_begin_to_attract_each_other():
    blocks = free_blocks(gap=0.02 * RADIUS)
    law = dict(cohesion=2e3, cohesionRange=0.1 * RADIUS)
    O.engines = sg.engines(interface=law)
    run(50)
    assert sg.integrator().contacts > 0
    assert not any(block.shape.isAsleep() for block in blocks)
