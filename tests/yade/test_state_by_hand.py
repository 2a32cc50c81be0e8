"""What a script writes into the State of soft grains and is no motion of theirs."""

import math

import pytest
from scenes import RADIUS, add_disk, message_of_step, ready, run
from yade import Quaternion


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
