"""Pressure and width of the contact of a disk with a wall."""

import numpy as np
import pytest
from scenes import RADIUS, add_disk, add_wall, ready, run
from yade import O

import softgrain as sg


def pressed(speed=0.5, **shape):
    """A disk between two walls that have closed in; returns the interaction with the lower one."""
    disk = add_disk(zeta=0.1, **shape)
    low = add_wall(-RADIUS, axis=1, velocity=(0, speed, 0))
    add_wall(RADIUS, axis=1, velocity=(0, -speed, 0))
    ready()
    while low.state.pos[1] < -0.95 * RADIUS:
        run(1)
    return O.interactions[disk.id, low.id]


@pytest.mark.parametrize("contact", ("surface", "points"))
def test_pressure_makes_the_force(contact):
    interaction = pressed(contact=contact)
    profile = sg.contact_profile(interaction)
    assert (np.diff(profile["position"]) >= 0).all()
    assert (profile["pressure"] >= 0).all() and profile["pressure"].max() > 0
    total = interaction.phys.normalForce.norm()
    assert profile["force"].sum() == pytest.approx(total, rel=1e-12)
    np.testing.assert_allclose(profile["pressure"] * profile["length"], profile["force"])
    assert len(set(profile["node"])) == len(profile["node"])


def test_tributary_lengths():
    """They fill the contact: spacings of about dr."""
    profile = sg.contact_profile(pressed())
    np.testing.assert_allclose(profile["length"], 0.1 * RADIUS, rtol=0.1)


def test_width_on_the_disk():
    """Near Hertz's a = sqrt(4 F R/(pi E*)), and symmetric."""
    interaction = pressed(speed=0.1)
    profile = sg.contact_profile(interaction)
    width = sg.contact_halfwidth(profile["position"], profile["force"])
    force = interaction.phys.normalForce.norm()
    hertz = np.sqrt(4 * force * RADIUS * (1 - 0.45**2) / np.pi / 1e6)
    assert width == pytest.approx(hertz, rel=0.1)
    centre = profile["force"] @ profile["position"] / force
    assert abs(centre) < 0.02 * RADIUS


def test_width_of_an_ellipse():
    """Exact for Hertz's pressure, wherever its centre; none without force."""
    x = np.linspace(-1, 1, 2001)
    assert sg.contact_halfwidth(7 + 3 * x, np.sqrt(1 - x**2)) == pytest.approx(3, rel=1e-4)
    assert sg.contact_halfwidth(x, 0 * x) == 0


def test_pairs_of_disks_are_refused():
    add_disk((-RADIUS, 0, 0))
    add_disk((0.999 * RADIUS, 0, 0))
    ready()
    run(2)
    with pytest.raises(ValueError, match="interaction = #0, #1: not one of a soft disk"):
        sg.contact_profile(O.interactions[0, 1])
