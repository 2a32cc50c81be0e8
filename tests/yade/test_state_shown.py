"""What a script writes into the State of soft grains is seen at once in what is read of them."""

import __main__
import numpy as np
import pytest
from scenes import RADIUS, ZETA, ready, run, soft_material
from yade import O, PyRunner, Quaternion, utils

import softgrain as sg

TURN = Quaternion((0, 0, 1), 0.7)
PLACE, VELOCITY, SPIN = (0.4, -0.3, 0), (3.0, -1.0, 0), (0, 0, 40.0)


def collided(dim, **shape):
    """Two blocks that have run into each other, aslant: deformed, turning, vibrating."""
    sides, material = (2 * RADIUS, 1.5 * RADIUS, RADIUS)[:dim], soft_material()
    for x in (0, 2.02 * RADIUS):
        centre = (x, 0.2 * x, 0)
        O.bodies.append(sg.soft_block(centre, sides, material, zeta=ZETA, **shape))
    hit = O.bodies[0]
    hit.state.vel, hit.state.ori = (2, 0.3, 0), Quaternion((0, 0, 1), 0.1)
    ready()
    while sg.integrator().activeContacts == 0:
        run(10)
    run(50)
    assert np.linalg.norm(hit.state.angVel) > 1
    return hit


def shown(body):
    grain = body.shape
    arrays = {"outline": grain.outline(), "nodes": grain.nodes(), **grain.points()}
    return {**arrays, "inertia": np.array(grain.inertia())}


def change(body):
    body.state.pos, body.state.ori = PLACE, TURN * body.state.ori
    body.state.vel, body.state.angVel = VELOCITY, SPIN


def assert_close(found, expected):
    for name, value in expected.items():
        scale = np.abs(value).max()
        np.testing.assert_allclose(found[name], value, rtol=0, atol=1e-7 * scale, err_msg=name)


@pytest.mark.parametrize("dim, formulation", [(2, "total"), (3, "total"), (2, "updated")])
def test_as_the_next_step_makes_it(dim, formulation):
    body = collided(dim, formulation=formulation)
    before = shown(body)
    change(body)
    found = shown(body)
    assert np.abs(found["outline"] - before["outline"]).max() > 10 * RADIUS
    O.dt = 1e-12
    run(1)
    assert_close(shown(body), found)


@pytest.mark.parametrize("dim, formulation", [(2, "total"), (3, "total"), (2, "updated")])
def test_velocities_and_energy(dim, formulation):
    body = collided(dim, formulation=formulation)
    rotation = np.array(TURN.toRotationMatrix())
    centre, mass = np.array(body.state.pos), body.state.mass
    velocity, spin = np.array(body.state.vel), np.array(body.state.angVel)
    vibration = body.shape.nodeVelocities() - rigid(body.shape.nodes(), centre, velocity, spin)
    inertia = rotation @ np.array(body.shape.inertia()) @ rotation.T
    energy, elastic = (body.shape.energy()[name] for name in ("kinetic", "elastic"))
    change(body)
    expected = vibration @ rotation[:dim, :dim].T + rigid(
        body.shape.nodes(), np.array(PLACE), np.array(VELOCITY), np.array(SPIN)
    )
    found = body.shape.nodeVelocities()
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9 * np.abs(expected).max())
    energy += 0.5 * mass * (np.dot(VELOCITY, VELOCITY) - velocity @ velocity)
    energy += 0.5 * (SPIN @ inertia @ SPIN - (rotation @ spin) @ inertia @ (rotation @ spin))
    assert body.shape.energy()["kinetic"] == pytest.approx(energy, rel=1e-9)
    assert body.shape.energy()["elastic"] == elastic
    others = utils.kineticEnergy() - energy
    assert others == pytest.approx(O.bodies[1].shape.energy()["kinetic"], rel=1e-9)


def rigid(places, centre, velocity, spin):
    dim = places.shape[1]
    arms = np.zeros((len(places), 3))
    arms[:, :dim] = places - centre[:dim]
    return (velocity + np.cross(spin, arms))[:, :dim]


def test_nothing_between_two_engines_of_a_step():
    """State is a step behind there."""
    body, seen = collided(2), []
    O.engines = O.engines[:-1] + [PyRunner(command="look()", iterPeriod=1), O.engines[-1]]
    __main__.look = lambda: seen.append(body.shape.outline())
    run(1)
    np.testing.assert_array_equal(seen[0], body.shape.outline())
    assert np.linalg.norm(body.state.vel) * O.dt > 1e-6 * RADIUS
