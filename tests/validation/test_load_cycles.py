"""What slow cycles of load take from a disk, which should be what its damping takes."""

import math

import pytest
from bodies import add_wall, soft
from yade import O

import softgrain as sg

RADIUS = 0.01  # m
LOW, HIGH = 0.04, 0.16  # approach of the lid over the diameter


def boxed_disk(zeta, tolerance):
    """A damped disk between four frictionless walls; its lid."""
    material = soft(massDamping=4000)
    O.bodies.append(sg.soft_disk((0, 0, 0), 0.999 * RADIUS, material, zeta=zeta))
    sides = [(axis, side) for axis in (0, 1) for side in (-1, 1)]
    walls = [add_wall(s * RADIUS, a, sense=-s) for a, s in sides]
    O.engines = sg.engines(tolerance=tolerance, maxSweeps=2000)
    O.trackEnergy = True
    sg.set_time_step()
    return walls[3].state


def move(lid, approach, speed):
    """The lid to an approach, over the diameter."""
    goal = RADIUS * (1 - 2 * approach)
    direction = math.copysign(1, goal - lid.pos[1])
    lid.vel = (0, direction * speed, 0)
    while direction * (goal - lid.pos[1]) > 0:
        sg.advance(2)


def last_of_cycles(speed, zeta, tolerance):
    """Energies at the top of the third cycle, what it changed them by, and the largest overlap."""
    O.reset()
    lid = boxed_disk(zeta, tolerance)
    move(lid, HIGH, speed)
    for _ in range(2):
        move(lid, LOW, speed)
        before = sg.integrator().energy()
        move(lid, HIGH, speed)
        top, overlap = sg.integrator().energy(), sg.integrator().overlap
    move(lid, LOW, speed)
    after = sg.integrator().energy()
    return top, {name: after[name] - before[name] for name in after}, overlap


@pytest.mark.parametrize("speed, zeta", [(0.02, 0.11), (0.02, 0.2), (0.004, 0.11)])
def test_a_cycle_of_load_gives_nothing_out(speed, zeta):
    """Overlaps come about at low forces and are worked off at high ones: what that gives is a fifth
    of a per cent of the elastic energy (0.3 to 1.1 while pairs were to owe nothing), and the lid
    does work. The disk holds as much as with a strict solve (1 % less then)."""
    top, change, overlap = last_of_cycles(speed, zeta, tolerance=1e-2)
    assert -0.0025 * top["elastic"] < change["impact"] < 0
    assert change["walls"] > 0
    assert overlap < 3e-3
    strict, _, _ = last_of_cycles(0.02, zeta, tolerance=1e-5)
    assert top["elastic"] == pytest.approx(strict["elastic"], rel=4e-3)
