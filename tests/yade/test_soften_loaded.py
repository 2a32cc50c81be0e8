"""Spheres that turn soft when they first bear load."""

import math

import numpy as np
import pytest
from motion import momentum
from partner_scenes import add_rigid_disk, rigid_material
from scenes import (
    RADIUS,
    add_disk,
    add_wall,
    assert_done,
    assert_goes_on_after_loading,
    ready,
    run,
    run_python,
    soft_material,
)
from yade import O, Sphere, utils

import softgrain as sg


def late_scene(load=1e-3, **engines):
    """Three disks in a row, the first of which hits the second."""
    for x, speed in ((0, 1), (2.02 * RADIUS, 0), (6 * RADIUS, 0)):
        add_rigid_disk((x, 0, 0), RADIUS, (speed, 0, 0), density=1000, young=1e8)
    O.engines = sg.engines(verlet_distance=0.05 * RADIUS, **engines)
    O.dt = 1e-5
    return sg.soften(material=soft_material(), zeta=0.25, when="loaded", load=load)


def run_until_softened(count):
    softener = [e for e in O.engines if isinstance(e, sg.SoftenWhenLoaded)][0]
    while softener.softened < count:
        run(1)
        assert O.time < 0.1
    return softener


def test_soften_when_loaded():
    """Spheres that touch turn soft, with their momentum; one that is not touched waits."""
    ids = late_scene()
    before = momentum()
    assert not sg.soft_bodies()
    run(10)
    assert not sg.soft_bodies()
    softener = run_until_softened(2)
    assert [b.id for b in sg.soft_bodies()] == ids[:2] and softener.ids == ids[2:]
    run(100)
    np.testing.assert_allclose(momentum(), before, rtol=0, atol=1e-13 * before[0])
    assert softener.softened == 2
    assert O.dt == sg.integrator().dtSet
    first, second, _ = (O.bodies[i].state.vel[0] for i in ids)
    assert first < 0.2 and second > 0.8
    run_until_softened(3)
    run(200)
    np.testing.assert_allclose(momentum(), before, rtol=0, atol=1e-13 * before[0])


def test_in_contact_dynamics():
    """The step in which spheres meet is that of rigid ones; both bear the load, and turn soft. O.dt
    is the integrator's from then on."""
    ids = late_scene(rigid="nonsmooth")
    before = momentum()
    run(10)
    softener = run_until_softened(2)
    assert [b.id for b in sg.soft_bodies()] == ids[:2] and softener.ids == ids[2:]
    run(100)
    np.testing.assert_allclose(momentum(), before, rtol=0, atol=1e-13 * before[0])
    assert O.dt == sg.integrator().dtSet > 1e-5
    run_until_softened(3)
    run(200)
    np.testing.assert_allclose(momentum(), before, rtol=0, atol=1e-13 * before[0])


SCRIPT = """
import softgrain as sg
from yade import O, FrictMat, utils
for x in (0, 0.0199):
    O.bodies.append(utils.sphere((x, 0, 0), 0.01, material=FrictMat()))
    O.bodies[-1].state.blockedDOFs = "zXY"
O.bodies[0].state.vel = (1, 0, 0)
O.engines = sg.engines(verlet_distance=1e-3)
sg.soften(material=sg.SoftMat(), zeta=0.3, when="loaded", load=0)
O.dt = 2e-5
O.run(50, True)
assert len(sg.soft_bodies()) == 2
print("done")
"""


def test_soften_when_loaded_in_a_thread(tmp_path):
    """``O.run`` computes in a thread of its own, without Python's lock; the spheres that go were
    made by Python."""
    assert_done(run_python(SCRIPT, tmp_path, command=["/usr/bin/yade", "-n", "-x"]))


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
    for load in (-1, math.inf):
        with pytest.raises(ValueError, match=f"load = {load}"):
            sg.soften(when="loaded", load=load)


def test_spheres_that_wait_already():
    add_rigid_disk((0, 0, 0), RADIUS)
    O.engines = sg.engines(verlet_distance=0.05 * RADIUS)
    O.dt = 1e-6
    sg.soften(when="loaded", material=soft_material(), zeta=0.25)
    engines = len(O.engines)
    with pytest.raises(ValueError, match="#0 waits already to turn soft"):
        sg.soften(when="loaded", material=soft_material(), zeta=0.25)
    assert len(O.engines) == engines
    assert sg.soften(material=soft_material(), zeta=0.25) == [0]
    run(2)
    (softener,) = [e for e in O.engines if isinstance(e, sg.SoftenWhenLoaded)]
    assert softener.ids == [] and softener.softened == 0


def test_another_sphere_with_the_id_of_one_that_waits():
    material = soft_material()
    for x in (0, 3 * RADIUS):
        add_rigid_disk((x, 0, 0), RADIUS)
    O.engines = sg.engines(verlet_distance=0.05 * RADIUS)
    O.dt = 1e-6
    sg.soften(when="loaded", material=material, zeta=0.25)
    run(1)
    O.bodies.erase(1)
    heir = utils.sphere((3 * RADIUS, 0, 0), RADIUS, material=rigid_material())
    heir.state.blockedDOFs = "zXY"
    O.bodies.insertAtId(heir, 1)
    run(1)
    (softener,) = [e for e in O.engines if isinstance(e, sg.SoftenWhenLoaded)]
    assert softener.ids == [0]


def test_load_without_meaning():
    add_rigid_disk((0, 0, 0), RADIUS)
    with pytest.raises(ValueError, match="load = 0.01: .* when='now'"):
        sg.soften(load=0.01)
    assert isinstance(O.bodies[0].shape, Sphere)


def test_a_load_that_was_refused_does_not_act():
    late_scene()
    softener = [e for e in O.engines if isinstance(e, sg.SoftenWhenLoaded)][0]
    with pytest.raises(ValueError, match="load = -1"):
        softener.load = -1
    with pytest.raises(ValueError, match="load = -1"):
        O.step()
    assert not sg.soft_bodies()


def test_ids_that_are_no_bodies():
    add_disk()
    material = O.bodies[0].material
    softener = sg.SoftenWhenLoaded(ids=[-1, 10**6], shape=sg.SoftGrain(), material=material)
    ready()
    sg.insert_before_solve(softener)
    run(1)
    assert softener.ids == []


def test_id_that_is_named_twice():
    disks = [add_rigid_disk((x * RADIUS, 0, 0), RADIUS) for x in (0, 1.99)]
    O.engines = sg.engines(verlet_distance=0.05 * RADIUS)
    O.dt = 1e-6
    sg.soften(when="loaded", load=0, material=soft_material(), zeta=0.25)
    softener = next(e for e in O.engines if isinstance(e, sg.SoftenWhenLoaded))
    softener.ids = [d.id for d in disks for _ in range(2)]
    run(3)
    assert [b.shape.radius for b in sg.soft_bodies()] == [RADIUS] * 2


def test_shape_of_a_deformed_body():
    """Grains begin undeformed, whoever has the shape."""
    donor = add_disk((-10 * RADIUS, 0, 0), zeta=0.25)
    for x, speed in ((-9 * RADIUS, -3), (-11 * RADIUS, 3)):
        add_wall(x, 0, velocity=(speed, 0, 0))
    ready()
    run(30)
    assert np.ptp(donor.shape.outline()[:, 0]) < 1.95 * RADIUS
    for body in list(O.bodies):
        O.bodies.erase(body.id)
    late_scene()
    softener = [e for e in O.engines if isinstance(e, sg.SoftenWhenLoaded)][0]
    softener.shape = donor.shape
    run_until_softened(1)
    late = sg.soft_bodies()[0]
    assert np.ptp(late.shape.outline()[:, 0]) == pytest.approx(2 * RADIUS, rel=0.01)


@pytest.mark.parametrize("dim", (2, 3))
def test_spheres_of_another_density(dim):
    """They get the mass of soft grains at once: what they carry stays when they turn."""
    for x, speed in ((0, 1), (2.02 * RADIUS, 0)):
        sphere = utils.sphere((x, 0, 0), RADIUS, material=rigid_material(density=2600, young=1e7))
        sphere.state.blockedDOFs = "zXY" if dim == 2 else ""
        sphere.state.vel = (speed, 0, 0)
        O.bodies.append(sphere)
    O.engines = sg.engines(verlet_distance=0.05 * RADIUS)
    O.dt = 1e-5
    material = soft_material()
    sg.soften(material=material, zeta=0.25 if dim == 2 else 0.4, dim=dim, when="loaded")
    volume = math.pi * RADIUS**2 if dim == 2 else 4 / 3 * math.pi * RADIUS**3
    state = O.bodies[0].state
    assert state.mass == pytest.approx(material.density * volume)
    assert state.inertia[2] == pytest.approx((0.5 if dim == 2 else 0.4) * state.mass * RADIUS**2)
    before = momentum()
    run_until_softened(2)
    np.testing.assert_allclose(momentum(), before, rtol=0, atol=1e-12 * before[0])


def test_step_of_spheres_that_stay_rigid():
    """It is not raised beyond what they go with: a column of stiff ones on one that turns soft."""
    disks = [add_rigid_disk((0, 2 * RADIUS * k, 0), RADIUS, young=1e9) for k in range(6)]
    add_wall(-RADIUS, 1)
    O.engines = sg.engines(verlet_distance=0.05 * RADIUS, gravity=(0, -9.81, 0))
    O.dt = 3e-6  # a fifth of RADIUS (density/young)^(1/2)
    sg.soften([disks[0].id], material=soft_material(), zeta=0.25, when="loaded", load=1e-5)
    run_until_softened(1)
    run(4000)
    assert 3e-6 <= O.dt <= 5e-6
    heights = [d.state.pos[1] / RADIUS for d in disks]
    np.testing.assert_allclose(heights, 2 * np.arange(6), rtol=0, atol=0.1)


def test_step_after_the_last_sphere_has_turned():
    """It is that of soft grains alone."""
    for x in (0, 1.999 * RADIUS):
        add_rigid_disk((x, 0, 0), RADIUS, density=1000, young=1e10)
    O.engines = sg.engines(verlet_distance=0.05 * RADIUS)
    O.dt = 1e-7
    sg.soften(material=soft_material(), zeta=0.25, when="loaded", load=0)
    run_until_softened(2)
    run(3)
    assert O.dt > 1e-5


@pytest.mark.parametrize("dim", (2, 3))
@pytest.mark.parametrize("young", (1e7, 5e10))
def test_the_force_that_turns_the_last_spheres_acts_for_their_step(dim, young):
    """Not for that of the soft grains, which is up to some hundred times as long."""
    for x, speed in ((0, 0.5), (2.01 * RADIUS, -0.5)):
        if dim == 2:
            add_rigid_disk((x, 0, 0), RADIUS, (speed, 0, 0), density=1000, young=young)
        else:
            sphere = utils.sphere((x, 0, 0), RADIUS, material=rigid_material(young=young))
            sphere.state.vel = (speed, 0, 0)
            O.bodies.append(sphere)
    O.engines = sg.engines(verlet_distance=0.05 * RADIUS)
    O.dt = 0.3 * utils.PWaveTimeStep()
    sg.soften(material=soft_material(), zeta=0.25, dim=dim, when="loaded")
    run_until_softened(2)
    second = O.bodies[1].state
    assert second.vel[0] == pytest.approx(-0.5, rel=0.1)
    while O.time < 0.02:
        run(10)
    assert O.dt > 1e-5
    assert 0.8 < second.vel[0] / 0.5 < 1


@pytest.mark.parametrize("end", ("turned soft", "erased"))
def test_the_time_step_of_spheres_goes_with_the_last_of_them(end):
    """With O.dt bound to a stiffness that is gone a run would take many times as long."""
    ids = late_scene(load=0)
    ids.append(add_rigid_disk((9 * RADIUS, 0, 0), RADIUS, density=1000, young=1e8).id)
    run_until_softened(2)
    run(50)
    assert O.dt < 0.2 * sg.critical_time_step()
    if end == "erased":
        for sphere in ids[2:]:
            O.bodies.erase(sphere)
    else:
        sg.soften(ids[2:], material=soft_material(), zeta=0.25)
    run(1200)
    assert O.dt > 0.5 * sg.critical_time_step()


def test_members_of_clumps_bound_the_time_step():
    """They are as stiff as spheres on their own."""
    late_scene(load=0)
    stiff = rigid_material(density=1000, young=1e8)
    for x in (9, 15):
        places = ((x * RADIUS, 0, 0), ((x + 2) * RADIUS, 0, 0))
        O.bodies.appendClumped([utils.sphere(place, RADIUS, material=stiff) for place in places])
    run_until_softened(2)
    O.bodies.erase(2)
    run(1200)
    assert O.dt < 0.2 * sg.critical_time_step()


def test_spheres_of_another_scene_do_not_turn():
    """Although the engines are used again, and ids are the same."""
    late_scene()
    run(2)
    engines = O.engines
    O.reset()
    for x, speed in ((0, 1), (2.02 * RADIUS, 0)):
        add_rigid_disk((x, 0, 0), RADIUS, (speed, 0, 0), density=1000, young=1e8)
    O.engines = engines
    O.dt = 1e-5
    run(500)
    assert not sg.soft_bodies()
    assert abs(O.bodies[1].state.vel[0]) > 0.5  # they have met


@pytest.mark.parametrize(
    "message, height, attributes",
    (
        ("contact = 'points'", 0, {"contact": "points"}),
        ("dim = 3", 0, {"dim": 3}),
        ("body #1 is centred at z = 0", 0.5 * RADIUS, {}),
    ),
)
@pytest.mark.parametrize("first", ("now", "loaded"))
def test_spheres_that_would_not_fit_are_refused_at_once(message, height, attributes, first):
    """With soft grains that there are, and with those that are to become such; as they are with
    when='now', nothing being changed."""
    add_rigid_disk((0, 9 * RADIUS, height), RADIUS, (0, 0, 0), density=1000, young=1e8)
    sphere = add_rigid_disk((0, 0, 0), RADIUS, (0, 0, 0), density=1000, young=1e8)
    O.engines = sg.engines(verlet_distance=0.05 * RADIUS)
    sg.soften([0], material=soft_material(), zeta=0.25, when=first)
    mass, engines = sphere.state.mass, len(O.engines)
    with pytest.raises(ValueError, match=message):
        sg.soften([1], material=soft_material(), when="loaded", **{"dim": 2, **attributes})
    assert sphere.state.mass == mass and len(O.engines) == engines


def test_bonds_that_end_when_a_sphere_turns_are_counted():
    add_disk((0, 0, 0), material=soft_material())
    for x, speed in ((2, 0), (4.05, -0.5)):
        add_rigid_disk((x * RADIUS, 0, 0), RADIUS, (speed, 0, 0), density=1000, young=1e8)
    bond = {"bondStrength": 2e4, "bondEnergy": 1.0, "bondAtTouch": False}
    O.engines = sg.engines(rigid="nonsmooth", verlet_distance=0.05 * RADIUS, interface=bond)
    sg.set_time_step(0.5)
    run(3)
    bonds = sum(i.geom.bond() for i in O.interactions if i.isReal and hasattr(i.geom, "bond"))
    assert bonds > 0
    sg.soften([1, 2], material=soft_material(), zeta=0.25, when="loaded", load=1e-5)
    run(3)
    assert sg.integrator().lostBonds == 0
    run_until_softened(1)
    assert sg.integrator().lostBonds == bonds
