"""Soft grains turned into clumps and fixed facets with their outlines."""

import math

import numpy as np
import pytest
from harden_scenes import PLACES, box, rigid_material
from motion import angular_momentum, inertia_of, momenta, momentum
from scenes import (
    RADIUS,
    add_disk,
    add_wall,
    assert_goes_on_after_loading,
    damped_material,
    ready,
    run,
    soft_material,
)
from yade import Facet, FrictMat, Matrix3, O, Quaternion, utils

import softgrain as sg


def distances(points, clump):
    """Of points to the outline of a clump, < 0 inside."""
    members = [O.bodies[i] for i in clump.shape.ids]
    return np.min(
        [np.linalg.norm(points - np.array(m.state.pos), axis=1) - m.shape.radius for m in members],
        axis=0,
    )


def test_motion_of_a_clump():
    """Mass, centre, inertia and both momenta to rounding, outline within the error; two of three
    colliding disks go on as clumps, and with the soft one momentum stays."""
    material = soft_material(frictionAngle=0.5)
    places = ((0, 0, 0), (1.99 * RADIUS, 0.5 * RADIUS, 0), (3.5 * RADIUS, 1.8 * RADIUS, 0))
    disks = [add_disk(place, material=material) for place in places]
    disks[0].state.vel, disks[0].state.angVel = (1, 0.2, 0), (0, 0, 30)
    disks[2].state.vel = (-1, -1, 0)
    ready()
    run(40)
    assert disks[0].shape.energy()["elastic"] > 0
    states = [d.state for d in disks[:2]]
    kept = [
        (s.mass, s.pos, s.vel, d.shape.inertia()[2, 2], s.angVel) for s, d in zip(states, disks)
    ]
    outlines = [d.shape.outline() for d in disks[:2]]
    before = momenta()
    hardened = sg.harden([0, 1], material=rigid_material(), into="clumps", error=0.02)
    assert O.bodies[0] is None and set(hardened.bodies) == {0, 1} and len(hardened.ids) == 2
    for clump_id, outline, (mass, pos, vel, inertia, spin) in zip(hardened.ids, outlines, kept):
        clump = O.bodies[clump_id]
        assert clump.isClump and clump.state.blockedDOFs == "zXY"
        assert clump.state.mass == pytest.approx(mass, rel=1e-14)
        np.testing.assert_array_equal(clump.state.pos, pos)
        np.testing.assert_array_equal(clump.state.vel, vel)
        np.testing.assert_allclose(clump.state.angVel, spin, rtol=1e-12)
        np.testing.assert_allclose(clump.state.inertia, inertia, rtol=1e-12)
        gaps = distances(outline, clump)
        assert gaps.max() < 0.025 * RADIUS and gaps.min() > -0.005 * RADIUS
    np.testing.assert_allclose(momenta(), before, rtol=1e-12, atol=1e-15)
    O.dt *= 0.2
    run(1000)
    scale = np.abs(before).max(axis=1, keepdims=True)
    np.testing.assert_allclose(momenta() / scale, before / scale, rtol=0, atol=1e-9)
    assert max(b.state.vel.norm() for b in O.bodies if b) < 2
    assert len(sg.soft_bodies()) == 1


def test_clump_of_a_ball():
    """3D: principal axes of the deformed ball; its spin and centre are kept in flight."""
    balls = [
        sg.soft_sphere((x * RADIUS, y * RADIUS, 0), RADIUS, soft_material(), zeta=0.4)
        for x, y in ((0, 0), (1.9, 0.5))
    ]
    O.bodies.append(balls)
    balls[0].state.vel, balls[0].state.angVel = (2, 0, 0), (20, 30, 10)
    ready()
    run(25)
    inertia, before = np.array(balls[0].shape.inertia()), momenta()
    assert np.ptp(np.linalg.eigvalsh(inertia)) > 1e-3 * inertia[0, 0]
    outline = balls[0].shape.outline()
    clump = O.bodies[sg.harden([0], material=rigid_material(), into="clumps", error=0.05).ids[0]]
    np.testing.assert_allclose(inertia_of(clump), inertia, rtol=0, atol=1e-12 * inertia.max())
    np.testing.assert_allclose(momenta(), before, rtol=1e-10, atol=1e-15)
    assert np.abs(distances(outline, clump)).max() < 0.1 * RADIUS
    run(200)
    np.testing.assert_allclose(momentum(), before[0], rtol=0, atol=1e-12)
    spin = np.abs(before[1]).max()
    np.testing.assert_allclose(angular_momentum(), before[1], rtol=0, atol=1e-3 * spin)


def test_outline_of_a_grain_that_was_moved():
    """Changes of State since the last step are in the outline of the clump."""
    disk = add_disk()
    O.bodies.append(
        sg.soft_block((5 * RADIUS, 0, 0), (4 * RADIUS, RADIUS), soft_material(), zeta=0.3)
    )
    ready()
    run(2)
    block = O.bodies[1]
    block.state.pos = (0, 7 * RADIUS, 0)
    block.state.ori = block.state.ori * Quaternion((0, 0, 1), math.pi / 2)
    clump = O.bodies[sg.harden([1], material=rigid_material(), into="clumps").ids[0]]
    places = np.array([O.bodies[i].state.pos for i in clump.shape.ids])
    np.testing.assert_allclose(places[:, 0], 0, atol=0.5 * RADIUS)
    assert np.ptp(places[:, 1]) > 2.5 * RADIUS and abs(places[:, 1].mean() - 7 * RADIUS) < RADIUS
    np.testing.assert_allclose(clump.state.pos, (0, 7 * RADIUS, 0), atol=1e-15)
    assert disk.id == 0


def test_momentum_lost_by_fixing():
    """It is told; the facets follow the outline, and do not move."""
    disk = add_disk((0.3 * RADIUS, 0.2 * RADIUS, 0))
    disk.state.vel, disk.state.angVel = (1, 2, 0), (0, 0, 30)
    ready()
    run(5)
    lost, outline, kinetic = momenta(), disk.shape.outline(), disk.shape.energy()["kinetic"]
    hardened = sg.harden(material=rigid_material(), into="fixed")
    np.testing.assert_allclose(hardened.momentum, lost[0], rtol=1e-12, atol=1e-15)
    np.testing.assert_allclose(hardened.angular_momentum, lost[1], rtol=1e-12, atol=1e-15)
    assert hardened.energy == pytest.approx(kinetic, rel=1e-9)
    facets = [O.bodies[i] for i in hardened.bodies[0]]
    assert all(isinstance(f.shape, Facet) for f in facets) and len(facets) == len(outline)
    for facet, start, end in zip(facets, outline, np.roll(outline, -1, axis=0)):
        corners = np.array([facet.state.pos + v for v in facet.shape.vertices])
        np.testing.assert_allclose(0.5 * (corners[0] + corners[1]), start, atol=1e-15)
        np.testing.assert_allclose(corners[2], end, atol=1e-15)
        assert facet.state.vel.norm() == 0 and facet.state.blockedDOFs == "xyzXYZ"


@pytest.mark.parametrize("rigid", ("linear", "nonsmooth"))
def test_lying_on_fixed_grains(rigid):
    """A soft disk and a rigid one come to lie in the dents between fixed ones. Nothing damps the
    rigid one, which rocks."""
    rest = {"massDamping": 400, "frictionAngle": 0.5}
    for x in (-1.05, 1.05, 3.15):
        add_disk((x * RADIUS, 0, 0), material=soft_material(**rest))
    ready(gravity=(0, -10, 0), rigid=rigid)
    stiff = FrictMat(young=1e7, poisson=0.3, frictionAngle=0.5, density=1000)
    facets = [O.bodies[i] for i in sg.harden(material=stiff, into="fixed").ids]
    soft = add_disk((0, 1.8 * RADIUS, 0), material=soft_material(**rest))
    ball = utils.sphere((2.1 * RADIUS, 1.8 * RADIUS, 0), RADIUS, material=stiff)
    ball.state.blockedDOFs = "zXY"
    O.bodies.append(ball)
    sg.as_disks([ball.id])
    O.dt = 2e-5
    O.run(8000, True)
    borne = np.zeros(3)
    for _ in range(3000):
        run(1)
        borne += sum(np.array(O.forces.f(f.id)) for f in facets) / 3000
        apart = [
            math.hypot(ball.state.pos[0] - x * RADIUS, ball.state.pos[1]) for x in (1.05, 3.15)
        ]
        assert min(apart) > 1.97 * RADIUS and ball.state.pos[1] < 1.8 * RADIUS
    assert soft.state.pos[1] == pytest.approx(math.sqrt(4 - 1.05**2) * RADIUS, abs=0.02 * RADIUS)
    assert soft.state.vel.norm() < 0.02
    assert borne[1] == pytest.approx(-20 * soft.state.mass, rel=0.05)
    assert not any(f.state.vel.norm() for f in facets)


def test_fixed_ball():
    """3D: a soft ball falls on one that was fixed, and stays outside."""
    balls = [
        sg.soft_sphere((0, y * RADIUS, 0), RADIUS, soft_material(massDamping=300), zeta=0.5)
        for y in (0, 2.01)
    ]
    O.bodies.append(balls)
    ready()
    run(1)
    hardened = sg.harden([0], material=rigid_material(), into="fixed")
    assert len(hardened.ids) > 50
    balls[1].state.vel = (0, -0.5, 0)
    lowest = 1.0
    for _ in range(400):
        run(1)
        lowest = min(lowest, balls[1].shape.outline()[:, 1].min())
    assert lowest > 0.8 * RADIUS and balls[1].state.vel[1] > 0


def mean_forces(walls, steps=1000):
    """On the walls, over a time in which vibrations average out."""
    total = np.zeros((len(walls), 3))
    for _ in range(steps):
        run(1)
        total += [sg.wall_force(w.id) for w in walls]
    return total / steps


@pytest.mark.parametrize("into", ("clumps", "fixed"))
def test_hardened_under_load(into):
    """The one of nine disks in a pressed box that touches no wall: forces on the walls go on, and
    nothing flies apart. Walls that do not give way see the most of what the outline is off by."""
    material = soft_material(massDamping=400, frictionAngle=0.3)
    for x, y in np.ndindex(3, 3):
        add_disk(((2 * x + 1) * RADIUS, (2 * y + 1) * RADIUS, 0), material=material, zeta=0.15)
    walls = [add_wall(6 * RADIUS * (k % 2), axis=k // 2, friction=0.3) for k in range(4)]
    ready(rigid="nonsmooth")
    walls[3].state.vel, walls[1].state.vel = (0, -0.2, 0), (-0.2, 0, 0)
    while walls[3].state.pos[1] > 5.6 * RADIUS:
        run(1)
    walls[3].state.vel = walls[1].state.vel = (0, 0, 0)
    O.run(1500, True)
    before = mean_forces(walls)
    hardened = sg.harden([4], material=FrictMat(frictionAngle=0.3), into=into)
    fastest = 0
    for _ in range(300):
        run(1)
        fastest = max(fastest, *(b.state.vel.norm() for b in O.bodies if b))
    assert fastest < 0.2 and hardened.energy > 0
    after = mean_forces(walls)
    np.testing.assert_allclose(after, before, rtol=0, atol=0.02 * np.abs(before).max())


def test_clumps_go_on_after_loading(tmp_path):
    for place in PLACES:
        add_disk(place)
    box()
    ready()
    run(5)
    sg.harden([0, 2], material=rigid_material(), into="clumps", error=0.05)
    run(5)
    assert_goes_on_after_loading(tmp_path / "clumps.yade.gz", 20)


def test_what_cannot_be_an_outline():
    add_disk(contact="points")
    ready()
    for into, error, message in (
        ("clumps", None, "#0 has contact = 'points', and so no outline"),
        ("fixed", None, "#0 has contact = 'points', and so no outline"),
        ("clumps", 0.001, "error = 0.001 is outside the admissible range"),
        ("clumps", 0.5, "error = 0.5 is outside the admissible range"),
        ("fixed", 0.01, "error = 0.01: it has no meaning"),
    ):
        with pytest.raises(ValueError, match=message):
            sg.harden(material=rigid_material(), into=into, error=error)
    with pytest.raises(ValueError, match="overlap = 'shrink': it has no meaning"):
        sg.harden(material=rigid_material(), into="fixed", overlap="shrink")
    assert len(sg.soft_bodies()) == 1


def test_clump_in_a_periodic_cell():
    """Stress and momentum of the cell go on."""
    O.periodic = True
    O.cell.hSize = Matrix3(6 * RADIUS, 0, 0, 0, 6 * RADIUS, 0, 0, 0, 1)
    material = soft_material(massDamping=400, frictionAngle=0.3)
    for x, y in np.ndindex(3, 3):
        add_disk((2 * x * RADIUS, 2 * y * RADIUS, 0.5), material=material, zeta=0.2)
    ready()
    O.cell.velGrad = Matrix3(-2, 0, 0, 0, -2, 0, 0, 0, 0)
    O.run(800, True)
    O.cell.velGrad = Matrix3.Zero
    O.run(1000, True)
    before, initial = sg.cell_stress(), momentum()
    sg.harden([0], material=FrictMat(frictionAngle=0.3), into="clumps")
    run(1000)
    np.testing.assert_allclose(np.diag(sg.cell_stress()), np.diag(before), rtol=0.04)
    np.testing.assert_allclose(momentum(), initial, rtol=0, atol=1e-9)


def test_fixed_in_a_periodic_cell():
    O.periodic = True
    O.cell.hSize = Matrix3(8 * RADIUS, 0, 0, 0, 8 * RADIUS, 0, 0, 0, 1)
    add_disk((RADIUS, RADIUS, 0.5))
    ready()
    with pytest.raises(ValueError, match="do not follow a periodic cell"):
        sg.harden(material=rigid_material(), into="fixed")


def test_block_in_3d_rests_on_the_floor():
    """No sphere of it is deeper in the floor than contact dynamics takes."""
    side = 2 * RADIUS
    block = sg.soft_block((0, 0, RADIUS), (side, side, side), damped_material(), zeta=0.3)
    O.bodies.append(block)
    add_wall(0, 2)
    ready(gravity=(0, 0, -10), rigid="nonsmooth")
    run(300)
    (clump,) = sg.harden(material=rigid_material(), into="clumps").ids
    O.dt = 5e-5
    run(200)
    assert O.bodies[clump].state.vel.norm() < 0.05
    assert sg.integrator().largestOverlap < 0.6
