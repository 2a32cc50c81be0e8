"""Tractions and width of a contact in 2D."""

import numpy as np
import pytest
from scenes import RADIUS, add_disk, add_wall, ready, run, soft_material
from yade import O

import softgrain as sg
from softgrain.profile import _tangent


def pressed(speed=0.5, friction=0.0, **shape):
    """A disk between two walls that have closed in; returns the interaction with the lower one."""
    disk = add_disk(material=soft_material(frictionAngle=np.arctan(friction)), zeta=0.1, **shape)
    low = add_wall(-RADIUS, axis=1, friction=friction, velocity=(0, speed, 0))
    add_wall(RADIUS, axis=1, friction=friction, velocity=(0, -speed, 0))
    ready()
    while low.state.pos[1] < -0.95 * RADIUS:
        run(1)
    return O.interactions[disk.id, low.id]


@pytest.mark.parametrize("contact", ("surface", "points"))
def test_forces_along_the_wall(contact):
    interaction = pressed(contact=contact)
    profile = sg.contact_profile(interaction)
    assert (np.diff(profile["position"]) >= 0).all()
    total = interaction.phys.normalForce.norm()
    assert profile["force"].sum() == pytest.approx(total, rel=1e-12) and total > 0
    assert len(set(profile["node"])) == len(profile["node"])


def test_tractions_are_those_of_the_contacts():
    """One pressure, whoever is asked; times the lengths it makes the force."""
    interaction = pressed(friction=0.5)
    profile, contacts = sg.contact_profile(interaction), interaction.geom.contacts()
    order = np.argsort(contacts["point"][:, 0], kind="stable")
    np.testing.assert_array_equal(profile["pressure"], contacts["pressure"][order])
    np.testing.assert_array_equal(profile["shear"], contacts["shear"][order, 0])
    np.testing.assert_allclose(profile["length"], 0.1 * RADIUS, rtol=0.1)
    total = interaction.phys.normalForce.norm()  # but for what is carried out of the contact
    assert profile["pressure"] @ profile["length"] == pytest.approx(total, rel=0.1)
    assert np.abs(profile["shear"]).max() > 0.02 * profile["pressure"].max()
    assert (np.abs(profile["shear"]) <= 0.5 * profile["pressure"] * (1 + 1e-9) + 1e-9).all()
    towards = np.array([profile["shear"][k] for k in (0, -1)])  # it holds the spreading disk back
    assert towards[0] * towards[1] <= 0


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


def test_pair_of_disks():
    """Nodes of both, along the tangent."""
    disks = [add_disk((-RADIUS, 0, 0)), add_disk((0.999 * RADIUS, 0, 0))]
    disks[0].state.vel = (1, 0, 0)
    ready()
    run(20)
    interaction = O.interactions[0, 1]
    profile = sg.contact_profile(interaction)
    assert set(profile["side"]) == {0, 1} and (np.diff(profile["position"]) >= 0).all()
    assert np.ptp(profile["position"]) > 0.1 * RADIUS
    assert (profile["pressure"] > 0).any()


@pytest.mark.parametrize(
    "normal, tangent",
    [
        ((0, 1, 0), (1, 0, 0)),
        ((0, -1, 0), (1, 0, 0)),
        ((1, 0, 0), (0, 1, 0)),
        ((-1, 0, 0), (0, 1, 0)),
        ((0.6, -0.8, 0), (0.8, 0.6, 0)),
        ((-0.8, 0.6, 0), (0.6, 0.8, 0)),
        ((0.8, 0.6, 0), (-0.6, 0.8, 0)),
    ],
)
def test_tangent_points_to_where_its_larger_component_grows(normal, tangent):
    assert _tangent(np.array(normal)) == pytest.approx(tangent)


def test_balls_are_refused():
    balls = [sg.soft_sphere((x * RADIUS, 0, 0), RADIUS, soft_material(), zeta=0.5) for x in (0, 2)]
    O.bodies.append(balls)
    balls[0].state.vel = (1, 0, 0)
    ready()
    run(3)
    with pytest.raises(ValueError, match="interaction = #0, #1: not one of a soft grain in 2D"):
        sg.contact_profile(O.interactions[0, 1])


def test_pair_that_is_over():
    """Of a body that was erased: at once, after a step, and after all others."""
    for body in (0, 1):
        O.reset()
        add_disk()
        add_wall(-RADIUS, axis=1, velocity=(0, 0.5, 0))
        ready()
        run(20)
        interaction = O.interactions[0, 1]
        assert len(sg.contact_profile(interaction)["force"]) > 0
        O.bodies.erase(body)
        for forget in (lambda: run(1), O.reset, lambda: None):
            with pytest.raises(ValueError, match="interaction = #., #.: not in contact"):
                sg.contact_profile(interaction)
            forget()
