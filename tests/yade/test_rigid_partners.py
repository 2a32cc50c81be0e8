"""Soft grains against rigid bodies of YADE, in one contact-dynamics solve."""

import math

import numpy as np
import pytest
from scenes import (
    RADIUS,
    add_disk,
    add_wall,
    assert_goes_on_after_loading,
    present_state,
    ready,
    run,
    soft_material,
)
from yade import FrictMat, O, Quaternion, Vector3, utils

import softgrain as sg


def rigid_material(friction=0.3, density=2000.0, young=1e5):
    return FrictMat(young=young, poisson=0.3, density=density, frictionAngle=math.atan(friction))


def add_rigid_disk(center, radius, velocity=(0, 0, 0), spin=0, fixed=False, **material):
    """A rigid disk in the plane, of YADE's sphere; returns its body."""
    body = utils.sphere(center, radius, material=rigid_material(**material), fixed=fixed)
    if not fixed:
        body.state.blockedDOFs = "zXY"
    O.bodies.append(body)
    if not fixed:
        sg.as_disks([body.id])
    body.state.vel, body.state.angVel = velocity, (0, 0, spin)
    return body


def momentum():
    return sum(b.state.mass * np.array(b.state.vel) for b in O.bodies if not b.isClumpMember)


def rest_material():
    """Damped, so that a scene comes to rest."""
    return soft_material(massDamping=300, frictionAngle=math.atan(0.5))


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


def test_conditions_at_the_end_of_the_step():
    """What the solver promises holds for what NewtonIntegrator makes of it: no contact closes, and
    sticking ones do not slide, at the velocities after the step; another force acts too."""
    add_disk(material=soft_material(frictionAngle=0.5))
    ball = add_rigid_disk((0, 1.5 * RADIUS, 0), 0.5 * RADIUS, (0, -0.3, 0))
    O.forces.setPermF(ball.id, (0.05, -2, 0))
    add_wall(-RADIUS, 1, friction=0.5)
    ready(gravity=(0, -10, 0), tolerance=1e-10, maxSweeps=2000)
    seen = 0
    for _ in range(300):
        run(1)
        for i in O.interactions:
            if ball.id not in (i.id1, i.id2) or not i.isReal:
                continue
            contacts = i.geom.contacts()
            active = np.linalg.norm(contacts["impulse"], axis=1) > 0
            seen += active.sum()
    assert seen > 50
    # the ball's velocity is that of the solve: it follows from the forces alone
    velocity = np.array(ball.state.vel)
    run(1)
    expected = velocity + O.dt * (
        np.array(O.forces.f(ball.id)) / ball.state.mass + np.array((0, -10, 0))
    )
    np.testing.assert_allclose(ball.state.vel, expected, rtol=0, atol=1e-12)
    assert sg.integrator().residual < 1e-10


def test_sphere_rests_on_soft_grains():
    """Reaction = weight, and no creep."""
    for x in (-1.0, 1.0):
        add_disk((x * RADIUS, 0, 0), material=rest_material())
    add_wall(-RADIUS, 1, friction=0.5)
    add_wall(-2 * RADIUS, 0)
    add_wall(2 * RADIUS, 0)
    ball = add_rigid_disk((0, 1.2 * RADIUS, 0), 0.5621 * RADIUS, friction=0.5)
    ready(gravity=(0, -10, 0))
    run(6000)
    start = np.array(ball.state.pos)
    total, steps = np.zeros(3), 2000
    for _ in range(steps):
        run(1)
        total += np.array(O.forces.f(ball.id))
    weight = 10 * ball.state.mass
    np.testing.assert_allclose(total / steps, (0, weight, 0), atol=0.01 * weight)
    assert np.linalg.norm(np.array(ball.state.pos) - start) < 1e-4 * RADIUS
    assert np.linalg.norm(ball.state.vel) < 1e-3


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

    def kinetic():
        state = ball.state
        return 0.5 * (
            state.mass * state.vel.squaredNorm() + state.inertia[2] * state.angVel[2] ** 2
        )

    def total():
        e = sg.integrator().energy()
        return sum(e[name] for name in ("kinetic", "elastic", "friction", "impact"))

    run(1)
    before = total() + kinetic()
    run(400)
    energy = sg.integrator().energy()
    assert energy["friction"] > 0
    assert total() + kinetic() == pytest.approx(before, rel=0.01)


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


def add_clump(centers, radius, friction=0.5):
    """A rigid clump of disks; returns its body."""
    spheres = [utils.sphere(c, radius, material=rigid_material(friction=friction)) for c in centers]
    clump, _ = O.bodies.appendClumped(spheres)
    body = O.bodies[clump]
    body.state.blockedDOFs = "zXY"
    sg.as_disks([clump])
    return body


def test_clump_keeps_the_momenta():
    disk = add_disk(material=soft_material(frictionAngle=0.5))
    disk.state.vel = (2, 0, 0)
    r = 0.4 * RADIUS
    clump = add_clump([(1.45 * RADIUS, 0, 0), (1.45 * RADIUS, 2 * r, 0)], r)
    ready()
    run(1)
    before = momentum()

    def angular():
        total = 0
        for b in O.bodies:
            if b.isClumpMember:
                continue
            s = b.state
            total += s.mass * s.pos.cross(s.vel)[2] + s.inertia[2] * s.angVel[2]
        return total

    start = angular()
    run(300)
    np.testing.assert_allclose(momentum(), before, rtol=0, atol=1e-13 * before[0])
    assert abs(clump.state.angVel[2]) > 10
    scale = disk.state.mass * 2 * RADIUS
    assert angular() == pytest.approx(start, abs=0.02 * scale)


def test_clump_rests_on_soft_grains():
    for x in (-1.0, 1.0):
        add_disk((x * RADIUS, 0, 0), material=rest_material())
    add_wall(-RADIUS, 1, friction=0.5)
    add_wall(-2 * RADIUS, 0)
    add_wall(2 * RADIUS, 0)
    r = 0.3 * RADIUS
    clump = add_clump([(x * RADIUS, (1 + 0.3) * RADIUS, 0) for x in (-0.9, -0.3, 0.3, 0.9)], r)
    ready(gravity=(0, -10, 0))
    run(6000)
    start = np.array(clump.state.pos)
    total, steps = 0, 2000
    for _ in range(steps):
        run(1)
        total += sum(O.forces.f(i)[1] for i in clump.shape.members)
    assert total / steps == pytest.approx(10 * clump.state.mass, rel=0.01)
    assert np.linalg.norm(np.array(clump.state.pos) - start) < 1e-4 * RADIUS
    assert np.linalg.norm(clump.state.vel) < 1e-3


def facet_strip(ends, width=4 * RADIUS):
    """Two facets across the plane along each pair of neighbouring points."""
    bodies = []
    for (x0, y0), (x1, y1) in zip(ends, ends[1:]):
        a, b = Vector3(x0, y0, -width), Vector3(x1, y1, -width)
        c, d = Vector3(x1, y1, width), Vector3(x0, y0, width)
        bodies.append(utils.facet((a, b, c), material=rigid_material(0.5)))
        bodies.append(utils.facet((a, c, d), material=rigid_material(0.5)))
    return bodies


def box_strip():
    """Floor and sides of the same container, of boxes."""
    half, thick = 1.05 * RADIUS, 0.3 * RADIUS
    places = ((0, -half - thick, 0), (-half - thick, 0, 0), (half + thick, 0, 0))
    sizes = ((2 * half, thick, RADIUS), (thick, 2 * half, RADIUS), (thick, 2 * half, RADIUS))
    return [
        utils.box(place, size, fixed=True, material=rigid_material(0.5))
        for place, size in zip(places, sizes)
    ]


@pytest.mark.parametrize("kind", ("facets", "boxes"))
def test_container(kind):
    """A grain thrown into a container comes to rest on its floor, whose reaction is the weight."""
    disk = add_disk(material=rest_material())
    disk.state.vel, disk.state.angVel = (0.5, 0.2, 0), (0, 0, 20)
    half = 1.05 * RADIUS
    if kind == "facets":
        # the floor of two pieces: the grain lies on their seam
        ends = [(-half, half), (-half, -half), (0, -half), (half, -half), (half, half)]
        bodies = facet_strip(ends)
    else:
        bodies = box_strip()
    ids = O.bodies.append(bodies)
    ready(gravity=(0, -10, 0))
    run(8000)
    total, steps = np.zeros(3), 2000
    for _ in range(steps):
        run(1)
        total += sum(np.array(O.forces.f(i)) for i in ids)
        assert np.abs(disk.shape.outline()[:, :2]).max() < half + 0.05 * RADIUS
    weight = 10 * disk.state.mass
    # it still rolls to and fro a little: rolling is not damped
    np.testing.assert_allclose(total / steps, (0, -weight, 0), atol=0.05 * weight)
    assert sg.integrator().largestOverlap < 0.2


def test_turned_box_carries():
    """A free box, turned by 30 degrees, is hit and turns on."""
    disk = add_disk(material=soft_material(frictionAngle=0.5))
    disk.state.vel = (1, 0, 0)
    box = utils.box(
        (1.9 * RADIUS, 0.4 * RADIUS, 0),
        (0.5 * RADIUS, 0.8 * RADIUS, RADIUS),
        orientation=Quaternion((0, 0, 1), 0.5),
        fixed=False,
        material=rigid_material(0.5),
    )
    box.state.blockedDOFs = "zXY"
    box.state.mass, box.state.inertia = 0.3, (1e-5, 1e-5, 1e-5)
    O.bodies.append(box)
    ready()
    run(1)
    before = momentum()
    run(400)
    np.testing.assert_allclose(momentum(), before, rtol=0, atol=1e-13 * before[0])
    assert box.state.vel[0] > 0.2 and abs(box.state.angVel[2]) > 1
    assert sg.integrator().cappedSteps == 0


def test_box_turned_out_of_the_plane_is_refused():
    add_disk()
    box = utils.box(
        (1.3 * RADIUS, 0, 0), (0.5 * RADIUS,) * 3, orientation=Quaternion((1, 0, 0), 0.5)
    )
    O.bodies.append(box)
    ready()
    with pytest.raises(RuntimeError, match="turn it about z only"):
        run(2)


def test_three_dimensions():
    """A free sphere falls on a soft ball in a box of facets."""
    ball = sg.soft_sphere((0, 0, 0), RADIUS, rest_material(), zeta=0.4)
    O.bodies.append(ball)
    corners = [Vector3(x, y, -RADIUS) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    O.bodies.append(
        [
            utils.facet((corners[0], corners[1], corners[2]), material=rigid_material()),
            utils.facet((corners[0], corners[2], corners[3]), material=rigid_material()),
        ]
    )
    rigid = utils.sphere((0, 0, 1.62 * RADIUS), 0.6 * RADIUS, material=rigid_material())
    rigid.state.vel = (0.02, 0, -0.5)
    O.bodies.append(rigid)
    ready(gravity=(0, 0, -10))
    touched = 0
    for _ in range(200):
        velocity = np.array(rigid.state.vel)
        run(1)
        force = np.array(O.forces.f(rigid.id))
        touched += force[2] > 0
        expected = O.dt * (force / rigid.state.mass + np.array((0, 0, -10)))
        np.testing.assert_allclose(
            np.array(rigid.state.vel) - velocity, expected, rtol=0, atol=1e-13
        )
    assert touched > 10
    assert rigid.state.vel[2] > -0.3


def mixed_scene():
    add_disk((-RADIUS, 0, 0), material=soft_material(frictionAngle=0.5))
    add_disk((1.01 * RADIUS, 0, 0), material=soft_material(frictionAngle=0.5))
    add_rigid_disk((0, 1.15 * RADIUS, 0), 0.52 * RADIUS, (0, -1, 0), friction=0.5)
    add_clump([(-0.4 * RADIUS, -1.3 * RADIUS, 0), (0.4 * RADIUS, -1.3 * RADIUS, 0)], 0.4 * RADIUS)
    O.bodies.append(facet_strip([(-2.02 * RADIUS, -RADIUS), (-2.02 * RADIUS, RADIUS)]))
    ready(gravity=(0, -10, 0))


@pytest.mark.parametrize("suffix", ("yade.bz2", "xml.gz"))
def test_saved_run_goes_on(suffix, tmp_path):
    mixed_scene()
    run(120)
    assert sg.integrator().activeContacts > 0
    assert_goes_on_after_loading(tmp_path / f"scene.{suffix}", 100)


def test_threads_change_nothing():
    states = []
    for threads in (1, 2):
        O.reset()
        mixed_scene()
        sg.integrator().ompThreads = threads
        run(200)
        states.append(present_state())
    for name, value in states[0].items():
        np.testing.assert_array_equal(states[1][name], value, err_msg=name)


def late_scene(load=1e-3):
    """Three disks in a row, the first of which hits the second."""
    for x, speed in ((0, 1), (2.02 * RADIUS, 0), (6 * RADIUS, 0)):
        add_rigid_disk((x, 0, 0), RADIUS, (speed, 0, 0), density=1000, young=1e8)
    O.engines = sg.engines(verlet_distance=0.05 * RADIUS)
    O.dt = 1e-5
    return sg.soften(material=soft_material(), zeta=0.25, when="loaded", load=load)


def test_soften_when_loaded():
    """Spheres that touch turn soft, with their momentum; one that is not touched waits."""
    ids = late_scene()
    before = momentum()
    assert not sg.soft_bodies()
    run(10)
    assert not sg.soft_bodies()
    run(400)
    assert [b.id for b in sg.soft_bodies()] == ids[:2]
    np.testing.assert_allclose(momentum(), before, rtol=0, atol=1e-13 * before[0])
    softener = [e for e in O.engines if isinstance(e, sg.SoftenWhenLoaded)][0]
    assert softener.softened == 2 and softener.ids == ids[2:]
    assert O.dt == sg.integrator().dtSet
    first, second, _ = (O.bodies[i].state.vel[0] for i in ids)
    assert first < 0.2 and second > 0.8
    while not softener.softened == 3:
        run(20)
        assert O.time < 0.1
    run(200)
    np.testing.assert_allclose(momentum(), before, rtol=0, atol=1e-13 * before[0])


def test_soften_when_loaded_is_saved(tmp_path):
    late_scene()
    run(250)
    assert_goes_on_after_loading(tmp_path / "scene.xml.gz", 400)


def test_soften_when_loaded_needs_an_integrator():
    add_rigid_disk((0, 0, 0), RADIUS)
    O.engines = []
    with pytest.raises(ValueError, match="SoftGrainIntegrator"):
        sg.soften(when="loaded")
    with pytest.raises(ValueError, match="when = 'later'"):
        sg.soften(when="later")
    O.engines = sg.engines(verlet_distance=0.05 * RADIUS)
    with pytest.raises(ValueError, match="load = -1"):
        sg.soften(when="loaded", load=-1)
