"""Rigid spheres become soft grains in place."""

import math

import numpy as np
import pytest
from bodies import add_wall
from scenes import RADIUS, ZETA, add_disk, assert_goes_on_after_loading, ready, run, soft_material
from yade import (
    Bo1_Sphere_Aabb,
    Bo1_Wall_Aabb,
    ForceResetter,
    FrictMat,
    Ig2_Sphere_Sphere_ScGeom,
    Ig2_Wall_Sphere_ScGeom,
    InsertionSortCollider,
    InteractionLoop,
    Ip2_FrictMat_FrictMat_FrictPhys,
    Law2_ScGeom_FrictPhys_CundallStrack,
    NewtonIntegrator,
    O,
    Sphere,
    utils,
)

import softgrain as sg


def add_spheres(centers, flat=True, radius=RADIUS):
    material = FrictMat(young=1e7, poisson=0.3, density=2000)
    bodies = [utils.sphere(c, radius, material=material) for c in centers]
    for body in bodies:
        if flat:
            body.state.blockedDOFs = "zXY"
    O.bodies.append(bodies)
    return bodies


def engines_for_both():
    """One list of engines that serves spheres, soft grains and walls."""
    return [
        ForceResetter(),
        InsertionSortCollider(
            [Bo1_Sphere_Aabb(), Bo1_Wall_Aabb(), sg.Bo1_SoftGrain_Aabb()], verletDist=0.05 * RADIUS
        ),
        InteractionLoop(
            [
                Ig2_Sphere_Sphere_ScGeom(),
                Ig2_Wall_Sphere_ScGeom(),
                sg.Ig2_SoftGrain_SoftGrain_SoftGeom(),
                sg.Ig2_Wall_SoftGrain_SoftGeom(),
            ],
            [
                Ip2_FrictMat_FrictMat_FrictPhys(),
                sg.Ip2_SoftMat_SoftMat_SoftPhys(),
                sg.Ip2_FrictMat_SoftMat_SoftPhys(),
            ],
            [Law2_ScGeom_FrictPhys_CundallStrack(), sg.Law2_SoftGeom_SoftPhys_Nonsmooth()],
        ),
        sg.SoftGrainIntegrator(),
        NewtonIntegrator(damping=0),
    ]


def test_soft_disk():
    material = soft_material(density=1500)
    disk = sg.soft_disk(
        (1, 2, 0),
        RADIUS,
        material,
        color=(1, 0, 0),
        mask=5,
        zeta=0.2,
        order=2,
        contact="points",
        quadrature="lattice",
        nodeSpacing=1.5,
        surfaceSpacing=2,
    )
    shape, state = disk.shape, disk.state
    assert (shape.dim, shape.radius, shape.zeta, shape.order) == (2, RADIUS, 0.2, 2)
    assert (shape.contact, shape.quadrature) == ("points", "lattice")
    assert (shape.nodeSpacing, shape.surfaceSpacing) == (1.5, 2)
    assert tuple(state.pos) == (1, 2, 0) and tuple(shape.color) == (1, 0, 0) and disk.mask == 5
    assert disk.material is material or disk.material.density == 1500
    mass = 1500 * math.pi * RADIUS**2
    assert state.mass == pytest.approx(mass, rel=1e-12)
    assert state.inertia[2] == pytest.approx(0.5 * mass * RADIUS**2, rel=1e-12)
    assert set(state.blockedDOFs) == set("xyzXYZ")


def test_soft_sphere():
    ball = sg.soft_sphere((0, 0, 1), RADIUS, soft_material(density=1500), zeta=0.3)
    mass = 1500 * 4 / 3 * math.pi * RADIUS**3
    assert ball.shape.dim == 3
    assert ball.state.mass == pytest.approx(mass, rel=1e-12)
    assert ball.state.inertia[0] == pytest.approx(0.4 * mass * RADIUS**2, rel=1e-12)
    O.bodies.append(ball)
    assert ball.shape.volume() == pytest.approx(4 / 3 * math.pi * RADIUS**3, rel=1e-10)
    assert sg.grain_area(ball) == ball.shape.volume()


def test_material_by_label_id_and_default():
    O.materials.append(soft_material(label="rubber"))
    assert sg.soft_disk((0, 0, 0), RADIUS, "rubber").material.label == "rubber"
    assert sg.soft_disk((0, 0, 0), RADIUS, 0).material.label == "rubber"
    assert sg.soft_disk((0, 0, 0), RADIUS).material.label == "rubber"
    O.reset()
    assert isinstance(sg.soft_disk((0, 0, 0), RADIUS).material, sg.SoftMat)
    assert len(O.materials) == 1


def test_keeps_motion_and_radius():
    spheres = add_spheres([(0, 0, 0), (3 * RADIUS, RADIUS, 0)])
    for sphere in spheres:
        sphere.state.vel, sphere.state.angVel = (1, 2, 0), (0, 0, 5)
        sphere.shape.color = (0.1, 0.2, 0.3)
    material = soft_material(density=1200)
    assert sg.soften(material=material, zeta=ZETA) == [0, 1]
    for body, center in zip(sg.soft_bodies(), ((0, 0), (3 * RADIUS, RADIUS))):
        assert isinstance(body.shape, sg.SoftGrain) and body.shape.radius == RADIUS
        assert (body.shape.dim, body.shape.zeta) == (2, ZETA)
        assert tuple(body.state.pos) == (*center, 0)
        assert tuple(body.state.vel) == (1, 2, 0) and tuple(body.state.angVel) == (0, 0, 5)
        assert tuple(body.shape.color) == pytest.approx((0.1, 0.2, 0.3))
        assert body.state.mass == pytest.approx(1200 * math.pi * RADIUS**2)
    assert O.dt == pytest.approx(0.85 * sg.critical_time_step())
    O.engines = sg.engines()
    run(50)
    for body, center in zip(sg.soft_bodies(), ((0, 0), (3 * RADIUS, RADIUS))):
        np.testing.assert_allclose(
            np.array(body.state.pos)[:2], np.array(center) + O.time * np.array((1, 2)), rtol=1e-9
        )
        assert body.state.angVel[2] == pytest.approx(5, rel=1e-3)


def test_dimension_of_the_scene():
    add_spheres([(0, 0, 0), (3 * RADIUS, 0, 0)])
    sg.soften(zeta=0.4)
    assert {b.shape.dim for b in sg.soft_bodies()} == {2}
    O.reset()
    add_spheres([(0, 0, 0), (3 * RADIUS, 0, RADIUS)], flat=False)
    sg.soften(zeta=0.4)
    assert {b.shape.dim for b in sg.soft_bodies()} == {3}
    O.reset()
    add_spheres([(0, 0, 0)], flat=False)
    sg.soften(zeta=0.4)
    assert sg.soft_bodies()[0].shape.dim == 3


@pytest.mark.parametrize(
    "centers, flat",
    [
        ([(0, 0, 0), (3 * RADIUS, 0, 0)], False),  # one layer, free to leave it
        ([(0, 0, 0), (3 * RADIUS, 0, RADIUS)], True),  # blocked, not one layer
    ],
)
def test_unclear_dimension(centers, flat):
    add_spheres(centers, flat)
    with pytest.raises(ValueError, match="dim: .*dim=2 or dim=3"):
        sg.soften()
    assert all(isinstance(b.shape, Sphere) for b in O.bodies)
    if not flat:
        sg.soften(dim=2, zeta=0.4)
        assert {b.shape.dim for b in sg.soft_bodies()} == {2}


@pytest.mark.parametrize(
    "options, message",
    [
        ({"dim": 4}, r"dim = 4 .*2, 3"),
        ({"zeta": 3}, r"zeta = 3 .*0\.5\]"),
        ({"overlap": "ignore"}, "overlap = 'ignore' is unknown.*'relax', 'shrink', 'refuse'"),
        ({"material": FrictMat()}, "material = FrictMat.*SoftMat"),
        ({"time_step_fraction": 2}, r"fraction = 2 .*\(0, 1\]"),
        ({"ids": [1]}, "ids: body #1 is neither a sphere"),
        ({"ids": []}, "ids: there is no sphere"),
        ({"when": "loaded"}, "when = 'loaded' needs a SoftGrainIntegrator"),
    ],
)
def test_refused_options_change_nothing(options, message):
    sphere = add_spheres([(0, 0, 0)])[0]
    add_wall(-RADIUS, axis=0)
    O.dt = 1e-5
    with pytest.raises(ValueError, match=message):
        sg.soften(**options)
    assert isinstance(sphere.shape, Sphere) and sphere.state.blockedDOFs == "zXY"
    assert isinstance(sphere.material, FrictMat)
    assert not any(isinstance(m, sg.SoftMat) for m in O.materials)
    assert O.dt == 1e-5


def test_relaxed_overlap():
    """Radii stay; the overlap turns into deformation, slowly."""
    add_spheres([(0, 0, 0), (1.97 * RADIUS, 0, 0)])
    sg.soften(zeta=ZETA)
    assert {b.shape.radius for b in sg.soft_bodies()} == {RADIUS}
    O.engines = sg.engines()
    run(1)
    assert sg.integrator().contacts > 0
    assert sg.integrator().overlap > 0.05
    run(300)
    assert sg.integrator().overlap < 0.02
    assert max(abs(b.state.vel[0]) for b in sg.soft_bodies()) < 0.2  # kept slow: c is 61 m/s


def test_overlap_is_that_over_the_smaller_radius():
    """6 % of it, and 3 % of the larger one."""
    add_spheres([(0, 0, 0)])
    add_spheres([((1.5 - 0.03) * RADIUS, 0, 0)], radius=RADIUS / 2)
    with pytest.raises(ValueError, match=r"bodies #0 and #1 overlap by 6(\.0\d*)? %"):
        sg.soften()


@pytest.mark.parametrize("distance, shown", [(1.9, "10"), (1.0, "100")])
def test_overlap_too_large_to_relax(distance, shown):
    add_spheres([(0, 0, 0), (distance * RADIUS, 0, 0)])
    with pytest.raises(
        ValueError, match=rf"bodies #0 and #1 overlap by {shown} % of the smaller radius"
    ) as caught:
        sg.soften()
    assert "admissible 5 %" in str(caught.value) and "overlap='shrink'" in str(caught.value)
    assert isinstance(O.bodies[0].shape, Sphere)


def test_shrunk_radii():
    """One factor for all, so that the closest pair just touches; walls count."""
    add_spheres([(0, 0, 0), (1.9 * RADIUS, 0, 0), (6 * RADIUS, 0, 0)])
    sg.soften(zeta=ZETA, overlap="shrink")
    assert [b.shape.radius for b in sg.soft_bodies()] == pytest.approx([0.95 * RADIUS] * 3)
    O.engines = sg.engines()
    run(1)
    assert sg.integrator().overlap < 1e-9


def test_shrunk_for_a_wall():
    add_spheres([(0, 0, 0), (3 * RADIUS, 0, 0)])
    add_wall(-0.9 * RADIUS, axis=1)
    sg.soften(zeta=ZETA, overlap="shrink")
    assert [b.shape.radius for b in sg.soft_bodies()] == pytest.approx([0.9 * RADIUS] * 2)


@pytest.mark.parametrize("overlap", ["shrink", "refuse"])
def test_spheres_that_stay_rigid_count(overlap):
    add_spheres([(0, 0, 0), (1.9 * RADIUS, 0, 0), (3 * RADIUS, 0, 0)])
    if overlap == "refuse":
        with pytest.raises(ValueError, match="#0 and #1 overlap by 10 %"):
            sg.soften([0], zeta=ZETA, overlap="refuse")
    else:
        sg.soften([0], zeta=ZETA, overlap="shrink")
        assert O.bodies[0].shape.radius == pytest.approx(0.9 * RADIUS)


def test_a_thin_cell_has_no_images_across_the_plane():
    O.periodic = True
    O.cell.setBox(10 * RADIUS, 10 * RADIUS, RADIUS)
    bodies = add_spheres([(RADIUS, RADIUS, 0), (4 * RADIUS, RADIUS, 0)])
    for body, overlap in zip(bodies, ("refuse", "shrink")):
        sg.soften([body.id], soft_material(), overlap=overlap)
    assert [body.shape.radius for body in bodies] == [RADIUS, RADIUS]


def test_coincident_spheres_cannot_shrink():
    add_spheres([(0, 0, 0), (0, 0, 0)])
    with pytest.raises(ValueError, match="overlap.*#0 and #1"):
        sg.soften(overlap="shrink")
    assert isinstance(O.bodies[0].shape, Sphere)


def test_refused_overlap():
    add_spheres([(0, 0, 0), (1.9999 * RADIUS, 0, 0)])
    with pytest.raises(ValueError, match="overlap = 'refuse'"):
        sg.soften(overlap="refuse")
    O.bodies[1].state.pos = (2.0001 * RADIUS, 0, 0)
    assert sg.soften(overlap="refuse", zeta=ZETA) == [0, 1]


def test_in_a_run_with_the_same_engines():
    """Rigid contacts are dropped, soft ones found in the next step; the engines stay."""
    spheres = add_spheres([(0, 0, 0), (2.02 * RADIUS, 0, 0)])
    spheres[0].state.vel = (2, 0, 0)
    add_wall(4 * RADIUS, axis=0, material=FrictMat())
    O.engines = engines = engines_for_both()
    O.dt = 1e-6
    while not any(i.isReal for i in O.interactions):
        run(1)
    run(20)
    velocities = [tuple(b.state.vel) for b in spheres]
    assert velocities[1][0] > 0
    sg.soften(zeta=ZETA)
    assert not any(i.isReal for i in O.interactions.all())
    assert [tuple(b.state.vel) for b in spheres] == velocities
    before = O.iter
    run(1)
    assert [type(e) for e in O.engines] == [type(e) for e in engines]
    assert [(i.id1, i.id2) for i in O.interactions] == [(0, 1)]
    assert isinstance(next(iter(O.interactions)).geom, sg.SoftGeom)
    run(60)
    assert O.iter == before + 61
    assert spheres[1].state.vel[0] > spheres[0].state.vel[0]
    assert O.dt > 1e-5


def test_some_of_the_spheres():
    """The others stay rigid; a contact between both kinds is refused until O.engines know it."""
    spheres = add_spheres([(0, 0, 0), (2.5 * RADIUS, 0, 0), (6 * RADIUS, 0, 0)])
    assert sg.soften(ids=[0, 2], zeta=ZETA) == [0, 2]
    assert isinstance(spheres[1].shape, Sphere)
    spheres[1].state.vel = (-5, 0, 0)
    O.engines = engines_for_both()
    run(5)
    assert spheres[1].state.pos[0] == pytest.approx(2.5 * RADIUS - 5 * O.time, rel=1e-9)
    with pytest.raises(RuntimeError, match="soft grain #0 comes near body #1 of shape Sphere"):
        run(500)
    O.engines = sg.engines()
    run(500)
    assert spheres[1].state.vel[0] > -4


def test_mixed_functors_in_any_order():
    """The order of the rigid and the soft functors in the lists does not matter."""
    add_spheres([(0, 0, 0), (2.05 * RADIUS, 0, 0)])
    add_wall(-1.01 * RADIUS, axis=0, material=FrictMat())
    sg.soften(zeta=ZETA)
    O.bodies[1].state.vel = (-2, 0, 0)
    engines = engines_for_both()
    loop = engines[2]
    loop.geomDispatcher.functors = loop.geomDispatcher.functors[::-1]
    loop.physDispatcher.functors = loop.physDispatcher.functors[::-1]
    loop.lawDispatcher.functors = loop.lawDispatcher.functors[::-1]
    O.engines = engines
    pairs = set()
    for _ in range(200):
        run(1)
        pairs |= {(i.id1, i.id2) for i in O.interactions if i.phys.activeContacts}
    assert {frozenset(p) for p in pairs} == {frozenset((0, 1)), frozenset((0, 2))}
    assert 0.3 < O.bodies[0].state.vel[0] < O.bodies[1].state.vel[0]


@pytest.mark.parametrize("clump", (False, True))
def test_what_does_not_fit_with_other_soft_grains_is_left_as_it_is(clump):
    """In another plane, or where one is wrong, which is seen when all are put together."""
    grain = sg.soft_disk((0, 0, 0), RADIUS, soft_material(), zeta=ZETA)
    O.bodies.append(grain)
    apart = 1 if clump else 2.5
    spheres = add_spheres([(5 * RADIUS, 0, RADIUS), ((5 + apart) * RADIUS, 0, RADIUS)])
    ids = [body.id for body in spheres]
    if clump:
        ids = [O.bodies.clump(ids)]
        O.bodies[ids[0]].state.blockedDOFs = "zXY"

    def states():
        return [(b.state.mass, tuple(b.state.vel), b.state.blockedDOFs) for b in spheres]

    before = states()
    count = len([b for b in O.bodies if b])
    with pytest.raises(ValueError, match="2D: the plane of all soft grains, z = 0 m"):
        sg.soften(ids, zeta=ZETA)
    grain.state.pos = (math.nan, 0, RADIUS)
    with pytest.raises(RuntimeError, match="#0.* not finite"):
        sg.soften(ids, zeta=ZETA)
    assert all(isinstance(b.shape, Sphere) and isinstance(b.material, FrictMat) for b in spheres)
    assert states() == before
    assert len([b for b in O.bodies if b]) == count
    grain.state.pos = (0, 0, 0)
    O.engines = sg.engines()
    run(2)


@pytest.mark.parametrize("when", ("now", "loaded"))
def test_held_spheres_stay_rigid(when):
    """A soft grain cannot be held: those of a floor are left out, and refused by name."""
    material = FrictMat(density=1000)
    floor = utils.sphere((0, 0, 0), RADIUS, fixed=True, material=material)
    ball = utils.sphere((0, 2.01 * RADIUS, 0), RADIUS, material=material)
    ball.state.blockedDOFs = "zXY"
    O.bodies.append([floor, ball])
    O.engines = sg.engines()
    options = {"material": soft_material(), "zeta": ZETA, "when": when}
    with pytest.raises(ValueError, match="#0 is held, blockedDOFs = 'xyzXYZ'"):
        sg.soften([0], dim=2, **options)
    assert sg.soften(**options) == [1]
    run(5)
    assert isinstance(floor.shape, Sphere) and floor.state.vel.norm() == 0


@pytest.mark.parametrize("dim, blocked", [(2, "zXYZ"), (3, "Z"), (3, "zXY")])
def test_what_a_sphere_may_not_do_is_not_forgotten(dim, blocked):
    ball = utils.sphere((0, 0, 0), RADIUS, material=FrictMat(density=1000))
    ball.state.blockedDOFs = blocked
    O.bodies.append(ball)
    O.engines = sg.engines()
    with pytest.raises(ValueError, match=f"#0 is held, blockedDOFs = '{blocked}'"):
        sg.soften([0], soft_material(), ZETA, dim=dim)
    assert isinstance(ball.shape, Sphere) and ball.state.blockedDOFs == blocked


def test_run_with_overlaps_from_the_start_goes_on_after_loading(tmp_path):
    """The first steps work them off at full speed, whenever the scene was saved."""
    for x in (0, 1.997 * RADIUS):
        add_disk((x, 0, 0))
    ready()
    run(3)
    assert_goes_on_after_loading(tmp_path / "scene.yade.gz", 40)
