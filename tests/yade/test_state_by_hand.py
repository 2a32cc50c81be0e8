"""What a script writes into the State of soft grains and is no motion of theirs."""

import math

import pytest
from scenes import RADIUS, add_disk, message_of_step, ready, run
from yade import Quaternion

import softgrain as sg


@pytest.mark.parametrize("attribute", ("pos", "vel"))
def test_state_that_is_no_number(attribute):
    disk = add_disk()
    ready()
    run(2)
    setattr(disk.state, attribute, (float("nan"), 0, 0))
    message = message_of_step(3)
    assert "#0" in message


@pytest.mark.parametrize("ori", [(2, 0, 0, 1), (math.nan, 0, 0, 0)], ids=str)
def test_orientation_that_is_no_rotation(ori):
    body = add_disk()
    ready()
    body.state.ori = Quaternion(*ori)
    assert "soft grain #0: its State.ori has the norm" in message_of_step()


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
