"""Vibrations of free bars against beam theory, undamped and damped."""

import math

import numpy as np
import pytest
from bodies import DENSITY, YOUNG, add, add_wall
from scipy import linalg, optimize
from yade import FrictMat, O, utils

import softgrain as sg

HEIGHT = 0.01  # m


def add_bar(ratio, zeta, poisson, damping):
    material = sg.SoftMat(young=YOUNG, poisson=poisson, density=DENSITY, massDamping=damping)
    return add(sg.soft_block((0, 0, 0), (ratio * HEIGHT, HEIGHT), material, zeta=zeta))


def damped_swing(time, amplitude, rate, omega, phase, middle):
    return amplitude * np.exp(-rate * time) * np.cos(omega * time + phase) + middle


def watch(read, omega, periods, rate=0.0):
    """Rate of decay [1/s] and angular frequency [1/s] of what swings nearly at omega."""
    start, rows = O.time, []
    while O.time < start + periods * 2 * math.pi / omega:
        sg.advance(2)
        rows.append((O.time - start, read()))
    time, value = np.transpose(rows)
    guess = (np.ptp(value) / 2, rate, omega, 0, value.mean())
    found, _ = optimize.curve_fit(damped_swing, time, value, p0=guess, maxfev=20000)
    return found[1], found[2]


@pytest.mark.parametrize("zeta", (0.5, 0.25))
@pytest.mark.parametrize("mass, stiffness", ((0, 0), (40, 0), (0, 1e-4)))
def test_along(mass, stiffness, zeta):
    """A bar 8 : 1 that plates had squeezed: pi c/L, with the lateral inertia by Rayleigh and Love;
    plane strain. Damping: alpha/2 and beta omega^2/2."""
    poisson, ratio, squeezed = 0.3, 8, 2e-3
    length = ratio * HEIGHT
    bar = add_bar(ratio, zeta, poisson, 3000)
    plates = []
    for side in (-1, 1):
        speed = -side * squeezed * length / 2 / 0.02
        place = side * length / 2
        plates.append(add_wall(place, 0, velocity=speed, sense=-side, material=FrictMat()))
    O.engines = sg.engines()
    sg.set_time_step(0.4)
    while O.time < 0.04:
        if O.time > 0.02:
            for plate in plates:
                plate.state.vel = (0, 0, 0)
        sg.advance(20)
    for plate in plates:
        O.bodies.erase(plate.id)
    bar.material.massDamping, bar.material.stiffnessDamping = mass, stiffness
    sg.set_time_step(0.4)

    thin = math.pi * math.sqrt(YOUNG / (1 - poisson**2) / DENSITY) / length
    lateral = (poisson / (1 - poisson) * math.pi / ratio) ** 2 / 12
    omega = thin / math.sqrt(1 + lateral)

    def along():
        return bar.shape.nodes()[:, 0] - bar.state.pos[0]

    mode = np.sin(np.pi * along() / length)

    def elongation():
        return np.dot(along(), mode) / np.dot(mode, mode)

    expected = mass / 2 + stiffness * omega**2 / 2
    rate, found = watch(elongation, omega, 8, expected)
    assert found == pytest.approx(omega, rel=0.002)
    assert rate == pytest.approx(expected, rel=0.01, abs=3e-4 * omega)


def free_free_bending(ratio, shear_share=5 / 6):
    """Lowest angular frequency of a bar by Timoshenko's theory, poisson = 0 [1/s]: where the
    transfer matrix from end to end lets moment and shear force vanish at both."""
    length, inertia = ratio * HEIGHT, HEIGHT**3 / 12
    slender = 4.730041**2 * math.sqrt(YOUNG * inertia / (DENSITY * HEIGHT * length**4))

    def remainder(omega):
        change = np.zeros((4, 4))  # of deflection, turn, moment, shear force along the bar
        change[0, 1], change[0, 3] = 1, 1 / (shear_share * YOUNG / 2 * HEIGHT)
        change[1, 2] = 1 / (YOUNG * inertia)
        change[2, 1], change[2, 3] = -DENSITY * inertia * omega**2, -1
        change[3, 0] = -DENSITY * HEIGHT * omega**2
        return np.linalg.det(linalg.expm(change * length)[2:, :2])

    return optimize.brentq(remainder, 0.8 * slender, 1.0 * slender)


@pytest.mark.parametrize("zeta, error", ((0.5, 0.06), (0.25, 0.02)))
def test_across(zeta, error):
    """A bar 10 : 1 that hung between two supports, let go."""
    ratio = 10
    length = ratio * HEIGHT
    bar = add_bar(ratio, zeta, 0.0, 300)
    supports = []
    for side in (-1, 1):
        centre = (side * 0.45 * length, -HEIGHT / 2 - 0.003, 0)
        material = FrictMat(frictionAngle=0)
        supports.append(add(utils.sphere(centre, 0.003, fixed=True, material=material)))
    O.engines = sg.engines()
    sg.set_time_step(0.4)
    gravity = 0.001 * length * 384 * YOUNG * HEIGHT**2 / 12 / (5 * DENSITY * length**4)
    while O.time < 0.1:
        O.engines[-1].gravity = (0, -gravity * min(1, O.time / 0.05), 0)
        sg.advance(10)
    O.engines[-1].gravity = (0, 0, 0)
    for support in supports:
        O.bodies.erase(support.id)
    bar.material.massDamping = 0
    outline = bar.shape.outline()
    middle = np.argmin(np.abs(outline[:, 0]) + 10 * np.abs(outline[:, 1] - HEIGHT / 2))
    omega = free_free_bending(ratio)
    _, found = watch(lambda: bar.shape.outline()[middle, 1] - bar.state.pos[1], omega, 10)
    assert found == pytest.approx(omega, rel=error)
