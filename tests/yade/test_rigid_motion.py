"""Grains that are undeformed and untouched move as rigid bodies: the same results at less work."""

import math

import numpy as np
import pytest
from scenes import (
    RADIUS,
    add_disk,
    add_wall,
    assert_same_bits,
    largest_stress,
    present_state,
    ready,
    run,
    soft_material,
)
from yade import O, Quaternion, Vector3

import softgrain as sg

STEPS = 120


def meeting(spin=0.0, **engine):
    """Two disks fly at each other and at a wall, a third one stays away; returns the bodies."""
    O.reset()
    disks = [add_disk(center) for center in ((0, 0, 0), (2.1 * RADIUS, 0.3 * RADIUS, 0))]
    disks.append(add_disk((0, 10 * RADIUS, 0)))
    for disk, speed in zip(disks, (1.0, -1.5, 0.3)):
        disk.state.vel = (speed, 0, 0)
        disk.state.angVel = (0, 0, spin)
    add_wall(-1.05 * RADIUS, 1, friction=0.3, velocity=(0, 0.5, 0))
    ready(**engine)
    O.trackEnergy = True
    return disks


def test_counts():
    """Nothing is computed for grains that fly; all that touch are."""
    meeting()
    engine = sg.integrator()
    run(1)
    assert engine.activeGrains == 0
    assert [b.shape.isRigid() for b in sg.soft_bodies()] == [True] * 3
    run(STEPS)
    assert engine.energy()["impact"] != 0  # they have met
    assert engine.activeGrains == 2
    assert [b.shape.isRigid() for b in sg.soft_bodies()] == [False, False, True]
    assert 2 < engine.totalGrainSteps < 2 * STEPS


def test_switched_off():
    meeting(rigidMotion=False)
    run(10)
    assert sg.integrator().totalGrainSteps == 30
    assert not any(b.shape.isRigid() for b in sg.soft_bodies())


def test_switched_off_and_on_in_flight():
    disks = meeting()
    run(3)
    sg.integrator().rigidMotion = False
    run(3)
    assert sg.integrator().activeGrains == 3
    sg.integrator().rigidMotion = True
    run(3)
    assert sg.integrator().activeGrains == 0
    np.testing.assert_allclose(disks[0].state.pos, (O.time, 0, 0), atol=1e-14)


@pytest.mark.parametrize("spin, tolerance", ((0.0, 1e-9), (8.0, 1e-3)))
def test_same_results_without(spin, tolerance):
    """To rounding; spinning grains to second order of their turn in a step, which stretches them
    where nodes are moved. (From 9.5/s on that is enough for a node to be met a step earlier.)"""
    states = []
    for rigid in (True, False):
        disks = meeting(spin, rigidMotion=rigid)
        run(STEPS)
        assert disks[0].state.vel[0] < 0.5  # they have met
        assert disks[0].state.vel[1] > 0.3  # and the wall
        states.append(present_state())
    with_it, without = states
    np.testing.assert_allclose(with_it["nodes"], without["nodes"], atol=tolerance * RADIUS)
    np.testing.assert_allclose(with_it["bodies"], without["bodies"], atol=10 * tolerance)
    scale = np.abs(without["energies"]).max()
    np.testing.assert_allclose(with_it["energies"], without["energies"], atol=tolerance * scale)


def test_what_a_rigid_grain_shows():
    """Nodes, outline and points are made when asked for."""
    disk = add_disk((0.1, 0, 0))
    disk.state.vel, disk.state.angVel = (1, 2, 0), (0, 0, 10)
    ready()
    run(200)
    assert disk.shape.isRigid()
    centre, angle = np.array(disk.state.pos)[:2], 10 * O.time
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    np.testing.assert_allclose(centre, (0.1 + O.time, 2 * O.time), rtol=1e-12)
    arms = np.linalg.norm(disk.shape.outline()[:, :2] - centre, axis=1)
    np.testing.assert_allclose(arms, RADIUS, rtol=1e-9)
    nodes, velocities = disk.shape.nodes() - centre, disk.shape.nodeVelocities()
    np.testing.assert_allclose(velocities[:, 0], 1 - 10 * nodes[:, 1], atol=1e-9)
    np.testing.assert_allclose(velocities[:, 1], 2 + 10 * nodes[:, 0], atol=1e-9)
    points = disk.shape.points()
    turns = np.broadcast_to(turn, (len(points["F"]), 2, 2))
    np.testing.assert_allclose(points["F"][:, :2, :2], turns, atol=1e-9)
    assert largest_stress(disk) < 1e-9 * 1e6
    assert disk.shape.volume() == pytest.approx(disk.shape.undeformedVolume(), rel=1e-9)


def test_user_acts_on_a_rigid_grain():
    disk = add_disk()
    ready(gravity=(0, -10, 0))
    run(10)
    disk.state.ori = Quaternion(Vector3(0, 0, 1), 0.5)
    run(10)
    disk.state.vel = (1, 0, 0)
    disk.state.pos = (0.5, 0, 0)
    run(20)
    assert disk.shape.isRigid()
    assert disk.state.pos[0] == pytest.approx(0.5 + O.dt * 20, rel=1e-9)
    assert disk.state.vel[1] == pytest.approx(-10 * O.dt * 20, rel=1e-9)
    assert 2 * math.asin(disk.state.ori[2]) == pytest.approx(0.5, rel=1e-9)


@pytest.mark.parametrize("suffix", ("yade.bz2", "xml.gz"))
@pytest.mark.parametrize("update", ("nodal", "flip"))
def test_save_and_load_in_flight(update, suffix, tmp_path):
    """A loaded run goes on with the same bits, through the meeting."""
    for x, speed in ((0, 1), (2.1 * RADIUS, -1)):
        disk = add_disk((x, 0.1 * x, 0), velocityUpdate=update)
        disk.state.vel, disk.state.angVel = (speed, 0.1, 0), (0, 0, 7)
    ready(gravity=(0, -10, 0))
    O.trackEnergy = True
    run(10)
    assert sg.integrator().activeGrains == 0
    O.save(str(tmp_path / f"scene.{suffix}"))
    run(2 * STEPS)
    assert sg.integrator().activeGrains == 2
    after = present_state()
    O.load(str(tmp_path / f"scene.{suffix}"))
    assert sg.soft_bodies()[0].shape.isRigid()
    run(2 * STEPS)
    assert_same_bits(present_state(), after)


def test_bodies_and_materials_change_in_flight():
    disks = meeting()
    run(5)
    O.bodies.erase(disks[2].id)
    added = add_disk((0, -10 * RADIUS, 0))
    disks[1].material.density = 500
    run(5)
    assert sg.integrator().activeGrains == 0
    np.testing.assert_allclose(disks[0].state.pos, (O.time, 0, 0), atol=1e-14)
    np.testing.assert_allclose(disks[1].state.vel, (-1.5, 0, 0), atol=1e-12)
    np.testing.assert_allclose(added.state.pos, (0, -10 * RADIUS, 0), atol=1e-14)
    assert disks[1].state.mass == pytest.approx(500 * math.pi * RADIUS**2, rel=1e-9)


def test_block_in_3d_tumbles():
    """Angular momentum stays, the angular velocity does not."""
    block = sg.soft_block((0, 0, 0), (0.04, 0.02, 0.03), soft_material(), zeta=0.4)
    block.state.angVel = (5, 12, 8)
    O.bodies.append(block)
    ready()
    run(3000)
    assert block.shape.isRigid()
    assert np.linalg.norm(np.array(block.state.angVel) - (5, 12, 8)) > 0.5
    sides = block.shape.outline()
    lengths = np.sort(np.linalg.svd(sides - sides.mean(axis=0))[1])
    start = np.sort(np.linalg.svd(np.array(reference_outline()))[1])
    np.testing.assert_allclose(lengths, start, rtol=1e-6)


def reference_outline():
    """Outline of the block of :func:`test_block_in_3d_tumbles` before it moved, about its mean."""
    O.reset()
    block = sg.soft_block((0, 0, 0), (0.04, 0.02, 0.03), soft_material(), zeta=0.4)
    O.bodies.append(block)
    outline = block.shape.outline()
    return outline - outline.mean(axis=0)


@pytest.mark.parametrize("dim, axis", [(2, (0, 0, 1)), (3, (0, 1, 0))])
@pytest.mark.parametrize("rigid", (True, False))
def test_turned_by_hand_a_grain_flies_on(dim, axis, rigid):
    """Velocity and spin stay what State says; nothing is deformed."""
    make = sg.soft_disk if dim == 2 else sg.soft_sphere
    body = make((0, 0, 0), RADIUS, soft_material(), zeta=0.4)
    O.bodies.append(body)
    body.state.vel, body.state.angVel = (1, 2, 0), (0, 0, 7)
    ready(rigidMotion=rigid)
    run(5)
    body.state.ori = Quaternion(axis, math.pi / 2) * body.state.ori
    run(5)
    np.testing.assert_allclose(body.state.vel, (1, 2, 0), atol=1e-9)
    np.testing.assert_allclose(body.state.angVel, (0, 0, 7), atol=1e-3)
    np.testing.assert_allclose(body.state.pos, O.time * np.array((1, 2, 0)), atol=1e-12)
    assert body.shape.volume() == pytest.approx(body.shape.undeformedVolume(), rel=1e-4)
