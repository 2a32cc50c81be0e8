"""Soft grains against rigid bodies of YADE, in one contact-dynamics solve."""

import math

import numpy as np
import pytest
from motion import kinetic_energy, momentum
from partner_scenes import (
    add_clump,
    add_rigid_disk,
    assert_comes_to_rest,
    bed_of_grains,
    facets_along,
    rest_material,
    rigid_material,
)
from scenes import (
    RADIUS,
    add_disk,
    add_wall,
    assert_goes_on_after_loading,
    assert_threads_change_nothing,
    ready,
    run,
    soft_material,
)
from yade import FrictMat, O, utils

import softgrain as sg


def test_as_disks():
    """Mass and inertia per metre of thickness, as those of a soft disk."""
    soft = add_disk(material=soft_material(density=2000))
    body = add_rigid_disk((1, 0, 0), RADIUS)
    run_mass = math.pi * RADIUS**2 * 2000
    assert body.state.mass == pytest.approx(run_mass, rel=1e-12)
    assert body.state.mass == pytest.approx(soft.state.mass, rel=1e-12)
    assert body.state.inertia[2] == pytest.approx(soft.state.inertia[2], rel=1e-12)
    ball = utils.sphere((2, 0, 0), RADIUS, material=rigid_material())
    O.bodies.append(ball)
    with pytest.raises(ValueError, match="zXY"):
        sg.as_disks()


def test_momentum_and_reactions():
    """An oblique impact with friction: what one body gets the other loses."""
    disk = add_disk(material=soft_material(frictionAngle=0.5))
    ball = add_rigid_disk((1.51 * RADIUS, 0.3 * RADIUS, 0), 0.5 * RADIUS, (-2, 0, 0), 30)
    ready()
    O.dt = 0.4 * sg.critical_time_step()  # the user's, so that it does not change
    run(1)
    before, touched = momentum(), 0
    for _ in range(300):
        velocity, spin = np.array(ball.state.vel), ball.state.angVel[2]
        run(1)
        touched += sg.integrator().activeContacts > 0
        force = np.array(O.forces.f(ball.id))
        np.testing.assert_allclose(O.forces.f(disk.id), -force, rtol=1e-12, atol=1e-15)
        gained = ball.state.mass * (np.array(ball.state.vel) - velocity)
        np.testing.assert_allclose(gained, O.dt * force, rtol=0, atol=1e-15)
        turned = ball.state.inertia[2] * (ball.state.angVel[2] - spin)
        assert turned == pytest.approx(O.dt * O.forces.t(ball.id)[2], abs=1e-17)
    np.testing.assert_allclose(momentum(), before, rtol=0, atol=1e-13 * abs(before[0]))
    assert touched > 20 and sg.integrator().activeContacts == 0
    assert ball.state.vel[0] > -1.5 and abs(ball.state.angVel[2] - 30) > 5
    assert sg.integrator().cappedSteps == 0


def contacts_with(ball):
    """By the body and number of what touches, as they were when the step began, with the impulses
    of the step."""
    found = {}
    for i in O.interactions:
        if ball.id in (i.id1, i.id2) and i.isReal:
            arrays = i.geom.contacts()
            for k, key in enumerate(zip(arrays["side"], arrays["node"])):
                found[key] = {name: array[k] for name, array in arrays.items()}
    return found


def is_sticking(contact, mu):
    normal = contact["impulse"].dot(contact["normal"])
    shear = np.linalg.norm(contact["impulse"] - normal * contact["normal"])
    return shear < 0.999 * mu * normal


def shift_of_outline(before, after, point):
    """Of a place near an outline, straight between the nodes of that [m]."""
    along = np.roll(before, -1, axis=0) - before
    t = np.einsum("ij,ij->i", point - before, along) / np.einsum("ij,ij->i", along, along)
    t = np.clip(t, 0, 1)[:, None]
    nearest = np.argmin(np.linalg.norm(before + t * along - point, axis=1))
    moved = after - before
    return ((1 - t) * moved + t * np.roll(moved, -1, axis=0))[nearest]


def test_conditions_at_the_end_of_the_step():
    """What the solver promises holds for what NewtonIntegrator makes of it: no contact closes, and
    sticking ones do not slide, at the velocities after the step; another force acts too."""
    disk = add_disk(material=soft_material(frictionAngle=0.5))
    ball = add_rigid_disk((0, 1.5 * RADIUS, 0), 0.5 * RADIUS, (0, -0.3, 0))
    O.forces.setPermF(ball.id, (0.05, -2, 0))
    add_wall(-RADIUS, 1, friction=0.5)
    ready(gravity=(0, -10, 0), tolerance=1e-10, maxSweeps=2000)
    closed, sticking = 0, 0
    last = {}
    for _ in range(300):
        place, outline = np.array(ball.state.pos), disk.shape.outline()
        run(1)
        present = contacts_with(ball)
        for key in last.keys() & present.keys():
            if last[key]["impulse"].any():
                closed += 1
                gap = min(last[key]["gap"], 0)  # but for the bend of the surfaces on the way
                assert present[key]["gap"] == pytest.approx(gap, abs=3e-7 * RADIUS)
        velocity, spin = np.array(ball.state.vel), np.array(ball.state.angVel)
        way = O.dt * (np.linalg.norm(velocity) + RADIUS * np.linalg.norm(spin))
        for contact in present.values():
            if is_sticking(contact, 0.3):
                sticking += 1
                point, normal = contact["point"], contact["normal"]
                apart = shift_of_outline(outline, disk.shape.outline(), point)
                apart -= O.dt * (velocity + np.cross(spin, point - place))
                slip = apart - apart.dot(normal) * normal  # 0.03 of the way: the outline is bent
                assert np.linalg.norm(slip) < 0.05 * way
        last = present
    assert closed > 50 and sticking > 50
    # the ball's velocity is that of the solve: it follows from the forces alone
    velocity = np.array(ball.state.vel)
    run(1)
    expected = velocity + O.dt * (
        np.array(O.forces.f(ball.id)) / ball.state.mass + np.array((0, -10, 0))
    )
    np.testing.assert_allclose(ball.state.vel, expected, rtol=0, atol=1e-12)
    assert sg.integrator().residual < 1e-10


def test_sphere_rests_on_soft_grains():
    bed_of_grains()
    ball = add_rigid_disk((0, 1.2 * RADIUS, 0), 0.5621 * RADIUS, friction=0.5)
    assert_comes_to_rest(ball, [ball.id])


def test_rolling_over_a_soft_grain():
    """A ball with spin gets going on a grain that is held by walls; friction turns it."""
    add_disk(material=rest_material())
    for axis in (0, 1):
        add_wall(-RADIUS, axis, friction=0.5)
    add_wall(RADIUS, 0, friction=0.5)
    ball = add_rigid_disk((0.05 * RADIUS, 1.5 * RADIUS, 0), 0.5 * RADIUS, friction=0.5)
    ready(gravity=(0, -10, 0))
    run(4000)
    # it rolls down to the right, clockwise, without sliding
    speed, rim = ball.state.vel[0], -0.5 * RADIUS * ball.state.angVel[2]
    assert speed > 0.005
    assert rim == pytest.approx(ball.state.vel.norm(), rel=0.1)


def test_prescribed_sphere_pushes():
    disk = add_disk()
    ball = add_rigid_disk((-2.02 * RADIUS, 0, 0), RADIUS, (1, 0, 0), fixed=True)
    ready()
    run(250)
    assert ball.state.pos[0] == pytest.approx(-2.02 * RADIUS + O.time, rel=1e-9)
    assert 1.4 < disk.state.vel[0] <= 2.0


def test_blocked_degrees_of_freedom():
    """A sphere that may only move along y does not move along x nor turn."""
    add_disk(material=soft_material(frictionAngle=0.5)).state.vel = (1, 1, 0)
    ball = add_rigid_disk((1.3 * RADIUS, 0.8 * RADIUS, 0), 0.5 * RADIUS)
    ball.state.blockedDOFs = "xzXYZ"
    ready()
    run(150)
    assert ball.state.vel[0] == 0 and ball.state.angVel[2] == 0
    assert ball.state.vel[1] > 0.1


def test_energy_closes():
    disk = add_disk(material=soft_material(frictionAngle=0.5))
    disk.state.vel = (1, 0, 0)
    ball = add_rigid_disk((1.51 * RADIUS, 0.3 * RADIUS, 0), 0.5 * RADIUS, (-1, 0, 0), 30)
    O.trackEnergy = True
    ready()

    def total():
        e = sg.integrator().energy()
        soft = sum(e[name] for name in ("kinetic", "elastic", "friction", "impact"))
        return soft + kinetic_energy([ball])

    run(1)
    before = total()
    run(400)
    energy = sg.integrator().energy()
    assert energy["friction"] > 0
    assert total() == pytest.approx(before, rel=0.01)


@pytest.mark.parametrize("damped", (True, False))
def test_newton_damping_is_refused(damped):
    add_disk()
    ball = add_rigid_disk((1.501 * RADIUS, 0, 0), 0.5 * RADIUS, (-1, 0, 0))
    ball.state.isDamped = damped
    ready()
    O.engines[-1].damping = 0.2
    if damped:
        with pytest.raises(RuntimeError, match="NewtonIntegrator.damping = 0.2"):
            run(50)
    else:
        run(50)
        assert ball.state.vel[0] > -0.9


def test_sphere_out_of_the_plane_is_refused():
    add_disk()
    add_rigid_disk((1.4 * RADIUS, 0, 0.1 * RADIUS), 0.5 * RADIUS)
    ready()
    with pytest.raises(RuntimeError, match="put it into that plane"):
        run(2)


def test_rigid_pairs_keep_their_law():
    """Spheres touch each other by YADE's law while they touch soft grains by ours."""
    add_disk()
    add_rigid_disk((1.5 * RADIUS, 0, 0), 0.5 * RADIUS)
    add_rigid_disk((2.49 * RADIUS, 0, 0), 0.5 * RADIUS)
    add_wall(-RADIUS, 0)
    add_wall(2.97 * RADIUS, 0)
    ready()
    run(100)
    kinds = {type(i.geom).__name__ for i in O.interactions if i.isReal}
    assert kinds == {"SoftGeom", "ScGeom"}
    np.testing.assert_allclose(momentum()[1:], 0, atol=1e-15)


def test_contact_does_not_limit_the_time_step_of_a_sphere():
    """What GlobalStiffnessTimeStepper reads off the interaction."""
    add_disk()
    ball = add_rigid_disk((1.49 * RADIUS, 0, 0), 0.5 * RADIUS)
    ready()
    run(5)
    (interaction,) = [i for i in O.interactions if i.isReal and ball.id in (i.id1, i.id2)]
    assert interaction.phys.activeContacts > 0
    assert interaction.phys.kn == interaction.phys.ks == 0


@pytest.mark.parametrize("load", ("force", "weight"))
def test_a_new_step_does_not_kick_what_grains_carry(load):
    """Loads act for as long on it as stress acts in the grains."""
    weight = 600 * RADIUS  # N/m
    material = soft_material(massDamping=6000)
    block = sg.soft_block((0, 0, 0), (4 * RADIUS, 2 * RADIUS), material, zeta=0.25)
    O.bodies.append(block)
    add_wall(-RADIUS, axis=1)
    lid = add_wall(RADIUS, axis=1)
    lid.state.blockedDOFs, lid.state.mass = "xzXYZ", 0.01
    if load == "force":
        O.forces.setPermF(lid.id, (0, -weight, 0))
    ready(gravity=(0, -weight / lid.state.mass if load == "weight" else 0, 0), sleep=False)
    run(6000)
    rest = abs(lid.state.vel[1])
    O.dt /= 2
    run(1)
    kick = weight / lid.state.mass * O.dt / 2
    assert abs(lid.state.vel[1]) < rest + 1e-2 * kick  # the tolerance of the sweeps


def mixed_scene(length=1):
    """A row of soft disks, two for each unit of length, with rigid ones upon them and clumps below;
    beside it facets."""
    for k in range(length):
        middle = 4.02 * RADIUS * k
        for x in (-RADIUS, 1.01 * RADIUS):
            add_disk((middle + x, 0, 0), material=soft_material(frictionAngle=0.5))
        place = (middle, 1.15 * RADIUS, 0)
        add_rigid_disk(place, 0.52 * RADIUS, (0, -1, 0), friction=0.5)
        ends = [(middle + x * RADIUS, -1.3 * RADIUS, 0) for x in (-0.4, 0.4)]
        add_clump(ends, 0.4 * RADIUS)
    O.bodies.append(facets_along([(-2.02 * RADIUS, -RADIUS), (-2.02 * RADIUS, RADIUS)]))
    ready(gravity=(0, -10, 0))


@pytest.mark.parametrize("suffix", ("yade.bz2", "xml.gz"))
def test_saved_run_goes_on(suffix, tmp_path):
    mixed_scene()
    run(100)
    while sg.integrator().activeContacts == 0:
        run(1)
    assert_goes_on_after_loading(tmp_path / f"scene.{suffix}", 100)


def test_threads_change_nothing():
    """Of a row so long that they share loops, from 32 grains on, and sweeps, from 16 pairs in each
    colour on."""
    assert_threads_change_nothing(lambda: mixed_scene(30), 200)


def test_fast_rigid_bodies_are_seen_before_they_touch():
    """The search reaches as far as they come in a step."""
    add_disk()
    add_rigid_disk((2.5 * RADIUS, 0, 0), RADIUS, (-20, 0, 0))
    ready()
    while not any(i.isReal and i.phys.activeContacts for i in O.interactions):
        run(1)
        assert O.time < 1e-3
    assert sg.integrator().largestOverlap < 1e-3


def test_a_run_with_a_body_that_spins_goes_on_after_loading(tmp_path):
    """In 3D impulses have turned with it when the next step begins."""
    material = soft_material(frictionAngle=math.atan(0.8))
    O.bodies.append(sg.soft_sphere((0, 0, 0.99 * RADIUS), RADIUS, material, zeta=0.5))
    size = (9 * RADIUS, 9 * RADIUS, RADIUS)
    surface = FrictMat(frictionAngle=math.atan(0.8))
    box = utils.box((0, 0, -RADIUS), size, material=surface)
    box.state.blockedDOFs = "xyzXYZ"
    box.state.angVel = (0, 0, 20)
    O.bodies.append(box)
    ready(gravity=(4, 0, -200), tolerance=1e-3)
    run(40)
    assert sg.wall_force(1)[2] < 0
    assert_goes_on_after_loading(tmp_path / "scene.yade.gz", 20)
