"""Friction against closed-form solutions: partial slip, sliding, a bar on two rollers."""

import math

import numpy as np
import pytest
from bodies import add, add_wall, soft
from scipy import optimize
from yade import FrictMat, O, utils

import softgrain as sg

RADIUS = 0.01  # m
GRAVITY = 9.81  # m/s^2


def run_for(time, each=lambda share: None, steps=10):
    start = O.time
    while O.time < start + time:
        each(min(1, (O.time - start) / time))
        sg.advance(steps)


def bring_up_gravity():
    """Slowly, and let the grains come to rest."""

    def pull(share):
        O.engines[-1].gravity = (0, -GRAVITY * min(1, 2 * share), 0)

    run_for(0.06, pull)


# --- a disk between plates that is pushed sideways ------------------------------------------------


def moments(disk, plates, samples=40):
    """Means over time and both contacts of the shear force and of the second moments of shear and
    pressure about the middle of the contact, each over its force."""
    rows = []
    for _ in range(samples):
        sg.advance(10)
        for plate in plates:
            contacts = O.interactions[disk.id, plate.id].geom.contacts()
            normal, shear = np.abs(contacts["force"][:, 1]), contacts["force"][:, 0]
            x = contacts["point"][:, 0]
            x = x - np.average(x, weights=normal)
            rows.append(
                (shear.sum(), np.sum(shear * x**2) / shear.sum(), np.average(x**2, weights=normal))
            )
    return np.mean(rows, axis=0)


@pytest.mark.parametrize("zeta, error", ((0.1, 0.13), (0.05, 0.04)))
def test_partial_slip(zeta, error):
    """Cattaneo (1938), Mindlin (1949), in the plane: where the shear force is s mu P, shear is that
    of full slip less that of a contact smaller by the root of 1 - s, so that its second moment over
    the force is 2 - s times that of the pressure. (The disk slides without friction while it is
    pressed; shear of full slip would have 1.)"""
    friction, time = 0.5, 0.03
    disk = add(sg.soft_disk((0, 0, 0), RADIUS, soft(0, poisson=0.45, massDamping=2000), zeta=zeta))
    speed = 0.05 * RADIUS / time
    plates = [add_wall(-s * RADIUS, 1, velocity=s * speed, sense=s) for s in (1, -1)]
    O.engines = sg.engines(tolerance=1e-4, maxSweeps=1000, sleep=False)
    sg.set_time_step(0.9)
    run_for(time)
    for plate in plates:
        plate.state.vel = (0, 0, 0)
    run_for(0.01)
    for plate in plates:
        O.interactions[disk.id, plate.id].phys.tangensOfFrictionAngle = friction
    sg.advance(10)
    pressed = abs(sg.wall_force(plates[0].id)[1])
    force = 0
    for share in (0.25, 0.5, 0.75):
        before, force = force, 2 * share * friction * pressed
        run_for(
            0.02,
            lambda part: O.forces.setPermF(disk.id, (before + (force - before) * part, 0, 0)),
        )
        run_for(0.01)
        shear, of_shear, of_pressure = moments(disk, plates)
        assert abs(shear) == pytest.approx(force / 2, rel=0.015)
        assert of_shear / of_pressure == pytest.approx(2 - share, rel=error)


# --- sliding --------------------------------------------------------------------------------------


@pytest.mark.parametrize("zeta, error", ((0.25, 3e-3), (0.125, 1e-3)))
def test_thrown_block_stops(zeta, error):
    """After v^2/(2 mu g)."""
    friction, speed, side = 0.3, 0.3, 0.02
    material = soft(friction, massDamping=500)
    block = add(sg.soft_block((0, side / 2, 0), (2 * side, side), material, zeta=zeta))
    add_wall(0, 1, friction, sense=1)
    O.engines = sg.engines(gravity=(0, 0, 0))
    sg.set_time_step(0.9)
    bring_up_gravity()
    start = block.state.pos[0]
    block.state.vel = (speed, 0, 0)
    run_for(1.5 * speed / (friction * GRAVITY))
    exact = speed**2 / (2 * friction * GRAVITY)
    assert block.state.pos[0] - start == pytest.approx(exact, rel=error)


@pytest.mark.parametrize("young, error", ((5e6, 0.01), (2e7, 0.003)))
def test_bar_on_two_rollers(young, error):
    """That turn towards each other: the nearer one bears more and drags it back, so that it swings
    with omega^2 = 2 mu g/(d - mu h) for ever (Timoshenko's friction oscillator, with the drag half
    a height h below the middle), as long as its speed stays below that of the rims. Of a rigid
    bar: a soft one bends over the rollers."""
    friction, distance, height, start = 0.3, 0.06, 0.01, 0.01
    material = soft(friction, young=young, massDamping=800)
    bar = add(sg.soft_block((start, height / 2, 0), (0.12, height), material, zeta=0.5))
    rollers = []
    for side in (-1, 1):
        rim = FrictMat(frictionAngle=math.atan(friction))
        centre = (side * distance / 2, -RADIUS, 0)
        rollers.append(add(utils.sphere(centre, RADIUS, fixed=True, material=rim)))
    O.engines = sg.engines(gravity=(0, 0, 0))
    sg.set_time_step(0.9)
    bring_up_gravity()
    rollers[0].state.angVel, rollers[1].state.angVel = (0, 0, -60), (0, 0, 60)
    omega = math.sqrt(2 * friction * GRAVITY / (distance - friction * height))
    way = []
    begin = O.time
    run_for(4 * math.pi / omega, lambda _: way.append((O.time - begin, bar.state.pos[0])))

    def swing(time, amplitude, rate, phase, middle):
        return amplitude * np.cos(rate * time + phase) + middle

    found, _ = optimize.curve_fit(swing, *np.transpose(way), p0=(start, omega, 0, 0))
    assert found[1] == pytest.approx(omega, rel=error)
    assert abs(found[0]) == pytest.approx(start, rel=0.005)
    assert abs(found[3]) < 0.01 * start
