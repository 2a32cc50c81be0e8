"""Grains under more pressure than they bear: warnings, and runs that do not get on."""

import re

import numpy as np
import pytest
from scenes import RADIUS, YOUNG, add_disk, add_wall, message_of_step, ready, run, soft_material
from yade import O

import softgrain as sg


def disk_between_closing_walls(**shape):
    """The disk and its four walls."""
    disk = add_disk(material=soft_material(massDamping=3000), zeta=0.2, **shape)
    walls = []
    for axis, side in ((0, -1), (0, 1), (1, -1), (1, 1)):
        velocity = [0, 0, 0]
        velocity[axis] = -side
        walls.append(add_wall(side * RADIUS, axis, velocity=velocity))
    ready()
    return disk, walls


def squeeze_all_round(**shape):
    """Four walls about a disk until its mean pressure is 1.3 times its young."""
    disk, walls = disk_between_closing_walls(**shape)
    pressure = 0
    while pressure < 1.3 * YOUNG:
        run(50)
        points = disk.shape.points()
        stress = np.average(points["cauchy"], axis=0, weights=points["volume"])
        pressure = -(stress[0, 0] + stress[1, 1]) / 2
    for wall in walls:
        wall.state.vel = (0, 0, 0)
    run(200)


@pytest.mark.parametrize(
    "shape, warnings",
    [({}, 1), ({"nodeSpacing": 1.5}, 0), ({"nodeSpacing": 2}, 0), ({"basis": "triangles"}, 0)],
)
def test_warning_of_high_pressure(shape, warnings, capfd):
    """Logged once, where it is more than the background grid was found to bear."""
    squeeze_all_round(**shape)
    logged = capfd.readouterr().err
    assert logged.count("soft grain #0 bears a mean pressure of ") == warnings
    assert "critical time step" not in logged


def test_warning_of_a_step_that_has_collapsed(capfd):
    """Logged once, where a crushed grain would keep a run from getting on."""
    disk_between_closing_walls()
    engine, undeformed = sg.integrator(), sg.set_time_step()
    while engine.criticalDt == 0 or engine.criticalDt > 0.005 * undeformed:
        run(10)
        assert O.iter < 3000
    logged = capfd.readouterr().err
    assert logged.count("less than a hundredth of that of the undeformed ones") == 1


def test_a_run_whose_step_is_lost_stops():
    """A point that collapses shortens the step faster than time goes on."""
    disk, _ = disk_between_closing_walls(volumetric="projected")
    message = message_of_step(20_000)
    found = re.search(r"soft grain #0, material point (\d+): its volume has collapsed", message)
    assert found, message
    J = np.linalg.det(disk.shape.points()["F"])
    assert np.argmin(J) == int(found[1]) and J.min() < 1e-4
    assert 1e-12 < O.dt < 1e-9
