"""Clumps of disks become soft grains with the outline of all their members."""

import math

import numpy as np
import pytest
from scenes import DENSITY, RADIUS, ZETA, add_disk, add_wall, ready, run, soft_material
from yade import FrictMat, O, Quaternion, Vector3, utils

import softgrain as sg

APART = 1.2 * RADIUS  # of the members
AREA = RADIUS**2 * (2 * math.pi - 2 * math.acos(0.6) + 2 * 0.6 * 0.8)


def add_clump(center=(0, 0, 0), angle=0.0, flat=True, apart=APART, rise=0.0):
    """Two members, side by side; returns the id of the clump."""
    material = FrictMat(density=2000, frictionAngle=0.3)
    half = Quaternion((0, 0, 1), angle) * Vector3(apart / 2, 0, rise)
    members = [
        utils.sphere(Vector3(center) + sign * half, RADIUS, material=material) for sign in (-1, 1)
    ]
    clump, _ = O.bodies.appendClumped(members)
    if flat:
        O.bodies[clump].state.blockedDOFs = "zXY"
    return clump


def test_place_and_motion_are_kept():
    clump = add_clump((0.1, 0.2, 0), angle=0.5)
    state = O.bodies[clump].state
    state.vel, state.angVel = (1, 2, 0), (0, 0, 5)
    ids = sg.soften([clump], soft_material(), zeta=ZETA)
    body = O.bodies[ids[0]]
    assert [b.id for b in O.bodies] == ids
    assert body.state.mass == pytest.approx(DENSITY * AREA, rel=1e-3)
    ready()
    run(1)
    moved = np.array((1, 2)) * O.time
    outline = body.shape.outline()[:, :2] - moved
    along = APART / 2 * np.array((math.cos(0.5), math.sin(0.5)))
    members = np.array((0.1, 0.2)) + [along, -along]
    distance = np.linalg.norm(outline[:, None] - members, axis=2).min(axis=1)
    np.testing.assert_allclose(distance, RADIUS, rtol=2e-3)
    np.testing.assert_allclose(np.array(body.state.pos)[:2], (0.1, 0.2) + moved, rtol=1e-9)
    np.testing.assert_allclose(np.array(body.state.vel), (1, 2, 0), atol=1e-9)
    assert body.state.angVel[2] == pytest.approx(5, rel=1e-3)


def test_centre_of_members_of_different_size():
    """The centre of mass of YADE's clump is that of balls: the velocity is that of the disks'."""
    material = FrictMat(density=2000)
    members = [
        utils.sphere((0, 0, 0), RADIUS, material=material),
        utils.sphere((RADIUS, 0, 0), 0.5 * RADIUS, material=material),
    ]
    clump, _ = O.bodies.appendClumped(members)
    state = O.bodies[clump].state
    state.blockedDOFs = "zXY"
    state.angVel = (0, 0, 10)
    centre = state.pos
    body = O.bodies[sg.soften([clump], soft_material(), zeta=ZETA)[0]]
    apart = body.state.pos - centre
    assert 0.01 * RADIUS < apart.norm() < 0.2 * RADIUS
    np.testing.assert_allclose(body.state.vel, (-10 * apart[1], 10 * apart[0], 0), atol=1e-15)


def test_look_and_mask_are_kept():
    clump = add_clump()
    for k in (*O.bodies[clump].shape.ids, clump):
        O.bodies[k].mask = 6
    for k in O.bodies[clump].shape.ids:
        O.bodies[k].shape.color = (0.1, 0.5, 0.9)
    (made,) = sg.soften([clump], soft_material(), zeta=ZETA)
    assert O.bodies[made].mask == 6
    assert tuple(O.bodies[made].shape.color) == (0.1, 0.5, 0.9)


def test_congruent_clumps_share_their_table():
    clumps = [add_clump((3 * k * RADIUS, 0, 0), angle=0.7 * k) for k in range(3)]
    sg.soften(clumps, soft_material(), zeta=ZETA)
    ready()
    run(1)
    assert sg.integrator().templates == 1


def test_clumps_and_spheres_in_one_call():
    """The others stay as they are."""
    sphere = utils.sphere((0, 0, 0), RADIUS, material=FrictMat())
    sphere.state.blockedDOFs = "zXY"
    first = O.bodies.append(sphere)
    soft, rigid = add_clump((4 * RADIUS, 0, 0)), add_clump((8 * RADIUS, 0, 0))
    ids = sg.soften([first, soft], soft_material(), zeta=ZETA)
    assert ids[0] == first and ids[1] not in (first, soft, rigid)
    assert [b.id for b in sg.soft_bodies()] == sorted(ids)
    assert O.bodies[rigid].isClump and len(O.bodies[rigid].shape.members) == 2
    assert not sg.soften([rigid], soft_material(), zeta=ZETA) == [rigid]
    assert len(sg.soft_bodies()) == 3


def test_members_may_overlap_each_other_only():
    """Within a clump they must, between clumps the choice counts."""
    clumps = [add_clump(), add_clump((APART + 1.8 * RADIUS, 0, 0))]
    with pytest.raises(ValueError, match="overlap by 20 % of the smaller radius"):
        sg.soften(clumps, soft_material(), zeta=ZETA)
    assert all(O.bodies[i].isClump for i in clumps)
    ids = sg.soften(clumps, soft_material(), zeta=ZETA, overlap="shrink")
    left, right = (O.bodies[i].shape for i in ids)
    ready()
    run(1)
    gap = right.outline()[:, 0].min() - left.outline()[:, 0].max()
    assert -1e-3 * RADIUS < gap < 0.02 * RADIUS  # between nodes of the outlines


def test_at_rest_on_a_wall():
    """A soft dumbbell lies on both its ends; each bears half the weight."""
    clump = add_clump((0, 1.02 * RADIUS, 0), apart=1.6 * RADIUS)
    wall = add_wall(0, axis=1, sense=1)
    material = soft_material(young=1e5, massDamping=200)
    body = O.bodies[sg.soften([clump], material, zeta=ZETA)[0]]
    ready(gravity=(0, -9.81, 0))
    while O.time < 0.2:
        O.step()
    weight = body.state.mass * 9.81
    assert -sg.wall_force(wall.id)[1] == pytest.approx(weight, rel=1e-2)
    contacts = O.interactions[body.id, wall.id].geom.contacts()
    bearing = contacts["force"][:, 1] > 0
    places = contacts["point"][bearing, 0]
    assert (np.abs(np.abs(places) - 0.8 * RADIUS) < 0.3 * RADIUS).all()
    left = contacts["force"][bearing, 1][places < 0].sum()
    assert left == pytest.approx(weight / 2, rel=3e-2)


def test_hardened_and_softened_again():
    """Area within the error of the clump."""
    before = add_disk()
    ready()
    mass = before.state.mass
    clump = sg.harden(material=FrictMat(), into="clumps", error=0.05).ids[0]
    ids = sg.soften([clump], soft_material(), zeta=ZETA)
    assert O.bodies[ids[0]].state.mass == pytest.approx(mass, rel=0.1)


@pytest.mark.parametrize(
    "make, options, message",
    [
        (lambda: [add_clump(flat=False)], {"dim": 3}, "is a clump; in 3D only spheres"),
        (lambda: [add_clump(), 0], {}, "body #0 is neither .*member of clump #2"),
        (lambda: [add_clump(apart=2.1 * RADIUS)], {}, "clump #2: .*parts.*must overlap"),
        (lambda: [add_clump()], {"zeta": 3}, r"zeta = 3 .*0\.5\]"),
        (lambda: [add_clump()], {"when": "loaded"}, "clump #2 with when='loaded'"),
        (lambda: [add_clump(rise=0.1 * RADIUS)], {"dim": 2}, "of clump #2 is centred at z = "),
    ],
    ids=("3D", "member", "apart", "zeta", "loaded", "tilted"),
)
@pytest.mark.parametrize("given", (True, False))
def test_refused_clumps_stay(make, options, message, given):
    """And no material is made."""
    ids, material = make(), [soft_material()] * given
    materials = len(O.materials)
    with pytest.raises(ValueError, match=message):
        sg.soften(ids, *material, **options)
    assert O.bodies[2].isClump and len(O.bodies) == 3 and len(O.materials) == materials


def test_clump_that_does_not_fit_to_other_grains():
    """It is refused before anything is appended, which would leave a gap among the ids."""
    clump = add_clump()
    add_disk((5 * RADIUS, 0, 0))
    count = len(O.bodies)
    with pytest.raises(ValueError, match="contact = 'points': other grains .* 'surface'"):
        sg.soften([clump], soft_material(), contact="points")
    assert len(O.bodies) == count and O.bodies[clump].isClump


@pytest.mark.parametrize("attribute", ("z", "mask", "vertices"))
def test_what_the_clump_decides_on_is_refused(attribute):
    with pytest.raises(ValueError, match=attribute):
        sg.soften([add_clump()], soft_material(), **{attribute: 1})
