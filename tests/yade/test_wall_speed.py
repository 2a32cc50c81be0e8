"""How fast a wall may move."""

import math

import numpy as np
import pytest
from neo_hookean import wave_speed
from scenes import DENSITY, RADIUS, YOUNG, add_disk, add_wall, ready, soft_material
from yade import FrictMat, O

import softgrain as sg

WAVE_SPEED = wave_speed(YOUNG, 0.45, DENSITY)


def test_suggested_speed():
    """share stress/(rho c), of the grain with the largest impedance."""
    add_disk()
    expected = 0.1 * 0.01 * YOUNG / (DENSITY * WAVE_SPEED)
    assert sg.suggest_speed() == pytest.approx(expected, rel=1e-12)
    assert sg.suggest_speed(stress=0.1 * YOUNG, share=0.2) == pytest.approx(20 * expected)
    sg.scale_mass(4)
    assert sg.suggest_speed() == pytest.approx(0.5 * expected, rel=1e-12)
    add_disk((5 * RADIUS, 0, 0), material=soft_material(density=16 * DENSITY))
    assert sg.suggest_speed() == pytest.approx(0.25 * expected, rel=1e-12)


@pytest.mark.parametrize("dim, condition", [(2, "planeStress"), (3, "planeStrain")])
def test_suggested_speed_of_other_waves(dim, condition):
    """Of sheets, in which they are slower, and of balls."""
    make = sg.soft_disk if dim == 2 else sg.soft_sphere
    material = soft_material(condition=condition, poisson=0.3)
    O.bodies.append(make((0, 0, 0), RADIUS, material, zeta=0.4))
    modulus = 1 / (1 - 0.3**2) if dim == 2 else 0.7 / (1.3 * 0.4)
    expected = 1e-3 * math.sqrt(YOUNG / (modulus * DENSITY))
    assert sg.suggest_speed() == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("argument", [{"stress": 0}, {"stress": math.nan}, {"share": 0}])
def test_suggested_speed_out_of_range(argument):
    add_disk()
    with pytest.raises(ValueError, match="outside the admissible range"):
        sg.suggest_speed(**argument)


@pytest.mark.parametrize("ask", (sg.suggest_speed, lambda: sg.scale_mass(2), sg.harden))
def test_grain_of_another_material_is_named(ask):
    add_disk().material = FrictMat()
    with pytest.raises(ValueError, match="soft grain #0 is FrictMat, no SoftMat"):
        ask()


def press(share=None, speed=None, stress=0.05 * YOUNG, **material):
    """Force at both plates of a disk, averaged from there to 1.1 times the approach at which the
    slow force over the diameter is `stress`, and kinetic over elastic energy in the middle."""
    add_disk(material=soft_material(**material))
    bottom = add_wall(-RADIUS, 1)
    top = add_wall(RADIUS, 1)
    ready()
    speed = speed or sg.suggest_speed(stress, share)
    top.state.vel = (0, -speed, 0)
    begin, end = 0.2 * RADIUS, 0.22 * RADIUS  # F/(E D) = 0.05 at delta/D = 0.1
    forces, indicator = [], None
    while RADIUS - top.state.pos[1] < end:
        O.step()
        if RADIUS - top.state.pos[1] > begin:
            forces.append([abs(sg.wall_force(w.id)[1]) for w in (top, bottom)])
            indicator = indicator or sg.quasi_static()["kinetic_over_elastic"]
    O.reset()
    return np.mean(forces, axis=0), indicator


def test_suggested_speed_holds_what_it_promises():
    """Force errors at both plates within the share, kinetic over elastic within its square."""
    slow, _ = press(speed=0.02)
    for share in (0.1, 0.3):
        force, indicator = press(share=share)
        assert np.abs(force / slow - 1).max() < share
        assert indicator < share**2
    _, indicator = press(share=0.03, massDamping=2000)  # undamped, vibrations hold more than that
    assert indicator < 0.03**2
    force, _ = press(share=1.0, stress=0.5 * YOUNG)  # a speed for ten times the stress
    assert np.abs(force / slow - 1).max() > 0.3
