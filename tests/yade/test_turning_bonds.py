"""Bonds of grains that turn together: no slip, no damage, no moment by themselves."""

import math

import numpy as np
import pytest
from interface_scenes import SIDE, damped, interaction
from motion import angular_momentum
from scenes import ready, run
from yade import O

import softgrain as sg

#: Bonds with a gap, over dr, as tension or the way in which they were made leaves one.
GAP = 1 / 125
BOND = dict(bondStrength=1e5, bondEnergy=50.0, bondStiffness=2e8)


def grain(form, place, zeta):
    if form == "superdisk":  # smooth, with sides that are nearly flat
        return sg.soft_superdisk(place, (SIDE / 2, SIDE / 2), 8, material=damped(), zeta=zeta)
    return sg.soft_block(place, (SIDE,) * (3 if form == "cube" else 2), damped(), zeta=zeta)


def turning_pair(form, zeta, spin):
    """Two grains, bonded across a gap, that turn freely about their common centre."""
    gap = GAP * zeta * SIDE / 2
    for sign in (-1, 1):
        O.bodies.append(grain(form, (sign * (SIDE + gap) / 2, 0, 0), zeta))
    ready(interface=BOND, tolerance=1e-4, maxSweeps=500)
    run(3)
    for body in sg.soft_bodies():
        body.state.vel = (0, spin * body.state.pos[0], 0)
        body.state.angVel = (0, 0, spin)
    run(1)
    return gap


def turn_of(body):
    return 2 * math.atan2(body.state.ori[2], body.state.ori[3])


def aside():
    """How far the second block has gone past the first one."""
    first, second = sg.soft_bodies()
    way, angle = np.array(second.state.pos - first.state.pos), turn_of(first)
    return -math.sin(angle) * way[0] + math.cos(angle) * way[1]


def whole_bonds():
    return (interaction().geom.contacts()["bond"] == 1).sum()


@pytest.mark.parametrize(
    "form, zeta, spin, rounding",
    [
        ("square", 0.25, 5, 1e-6),
        ("square", 0.125, 5, 1e-6),
        ("superdisk", 0.125, 5, 1e-6),
        ("cube", 0.5, 20, 1e-4),  # normals of mean places are not quite along the gap
    ],
)
def test_a_bonded_pair_turns_as_one(form, zeta, spin, rounding):
    gap = turning_pair(form, zeta, spin)
    momentum, bonds, start = angular_momentum()[2], whole_bonds(), O.time
    assert bonds > 5
    while O.time - start < math.pi / 2 / spin:
        run(20)
    assert turn_of(sg.soft_bodies()[0]) == pytest.approx(math.pi / 2, rel=0.05)
    assert abs(aside()) < 0.02 * gap * math.pi / 2
    assert angular_momentum()[2] == pytest.approx(momentum, rel=rounding)
    assert whole_bonds() == bonds and interaction().geom.contacts()["damage"].max() == 0


def test_bonds_that_turn_are_not_damaged():
    """Three blocks that cannot give way to each other, at 2 % of the strength of their bonds."""
    zeta, spin = 0.25, 10
    gap = GAP * zeta * SIDE / 2
    O.bodies.append(sg.soft_block((0, -(SIDE + gap) / 2, 0), (2 * SIDE, SIDE), damped(), zeta=zeta))
    for sign in (-1, 1):
        place = (sign * (SIDE + gap) / 2, (SIDE + gap) / 2, 0)
        O.bodies.append(sg.soft_block(place, (SIDE, SIDE), damped(), zeta=zeta))
    ready(interface=dict(bondStrength=2e3, bondEnergy=0.1), tolerance=1e-4, maxSweeps=500)
    O.trackEnergy = True
    run(3)
    for body in sg.soft_bodies():
        body.state.vel = (-spin * body.state.pos[1], spin * body.state.pos[0], 0)
        body.state.angVel = (0, 0, spin)
    run(1)
    balance, start = sg.Balance(), O.time
    while O.time - start < math.pi / spin:
        run(50)
    damage = [i.geom.contacts()["damage"].max() for i in O.interactions if i.isReal]
    assert len(damage) == 3 and max(damage) == 0
    assert sg.integrator().lostBonds == 0
    assert balance.error() < 1e-4
