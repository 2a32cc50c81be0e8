"""Polygons, ellipses and superdisks inside YADE."""

import math
import re

import numpy as np
import pytest
from neo_hookean import cauchy, with_free_sides
from scenes import (
    DENSITY,
    RADIUS,
    YOUNG,
    add,
    add_disk,
    add_wall,
    assert_goes_on_after_loading,
    ready,
    run,
    soft_material,
)
from yade import O

import softgrain as sg
from softgrain import outlines

IRON = 1e-3 * np.array([(0, 0), (18, 0), (18, 6), (6, 6), (6, 18), (0, 18)], float)
STAR = 0.01 * np.array(
    [
        (
            (1.0, 0.45)[k % 2] * math.cos(math.pi * k / 5),
            (1.0, 0.45)[k % 2] * math.sin(math.pi * k / 5),
        )
        for k in range(10)
    ]
)


def turned(vertices, angle):
    c, s = math.cos(angle), math.sin(angle)
    return vertices @ np.array([[c, s], [-s, c]])


def polygon(vertices, **shape):
    return add(sg.soft_polygon(vertices, soft_material(), **{"zeta": 0.25, **shape}))


def superdisk(half_axes, exponent=4.0, angle=0.0, center=(0, 0, 0), material=None, **shape):
    return add(
        sg.soft_superdisk(
            center,
            half_axes,
            exponent,
            angle,
            material or soft_material(),
            **{"zeta": 0.25, **shape},
        )
    )


@pytest.mark.parametrize(
    "make, message",
    [
        (lambda: sg.soft_ellipse((0, 0, 0), (1, 0)), "half_axes = (1, 0): admissible are 2"),
        (lambda: sg.soft_ellipse((0, 0, 0), (1, 1, 1)), "half_axes = (1, 1, 1)"),
        (
            lambda: sg.soft_superdisk((0, 0, 0), (200, 1)),
            "half_axes = [200.0, 1.0]: admissible is up to 100 times",
        ),
        (lambda: sg.soft_superdisk((0, 0, 0), (2, 1), 1.0), "exponent = 1 is outside"),
        (lambda: sg.soft_polygon([(0, 0), (2, 2), (2, 0), (0, 3)]), "crosses or touches itself"),
        (lambda: sg.SoftGrain(dim=2, form="polygon"), "a polygon has at least three"),
        (
            lambda: sg.soft_polygon([(0, 0), (1, 0), (0, 1)], quadrature="lattice"),
            "quadrature = 'lattice' is not for polygons",
        ),
        (lambda: sg.SoftGrain(dim=3, form="superdisk"), "dim = 3 is outside"),
        (lambda: sg.SoftGrain(dim=2, exponent=3), "exponent = 3 is outside"),
        (lambda: sg.SoftGrain(dim=2, vertices=[(0, 0)] * 3), "vertices (number) = 3"),
    ],
)
def test_bad_input(make, message):
    with pytest.raises(ValueError, match=re.escape(message)):
        make()


def material_moment(body):
    """Polar moment of the undeformed material points about the centre [kg m]."""
    points = body.shape.points()
    arm = points["position"][:, :2] - np.array(body.state.pos)[:2]
    return DENSITY * points["volume"] @ np.sum(arm**2, axis=1)


@pytest.mark.parametrize("name", ("iron", "star", "ellipse", "superdisk"))
def test_mass_centre_and_inertia_are_those_of_the_material_points(name):
    center = (0.03, -0.02, 0)
    if name == "ellipse":
        a, b = 0.02, 0.01
        body = add(sg.soft_ellipse(center, (a, b), 0.4, soft_material(), zeta=0.1))
        area, inertia = math.pi * a * b, math.pi * a * b * (a * a + b * b) / 4
    elif name == "superdisk":
        body = superdisk((0.01, 0.01), 20, 0.4, center, zeta=0.1)
        area, inertia = 4e-4, 4e-4 * (8e-4) / 12  # of the square, which it is 2.5 % short of
    else:
        vertices = turned({"iron": IRON, "star": STAR}[name], 0.4)
        body = polygon(vertices, zeta=0.1)
        area, centroid, inertia = outlines.area_and_inertia(vertices)
        center = (*centroid, 0)
    rough = 0.03 if name == "superdisk" else 1e-9
    assert body.state.mass == pytest.approx(DENSITY * area, rel=rough)
    assert body.state.inertia[2] == pytest.approx(DENSITY * inertia, rel=2 * rough)
    np.testing.assert_allclose(body.state.pos, center, atol=1e-12)
    assert body.shape.undeformedVolume() == pytest.approx(body.state.mass / DENSITY, rel=1e-9)
    points = body.shape.points()
    assert points["volume"].sum() == pytest.approx(body.state.mass / DENSITY, rel=1e-9)
    centre = points["volume"] @ points["position"] / points["volume"].sum()
    np.testing.assert_allclose(centre, center, atol=1e-8)
    ratio = material_moment(body) / body.state.inertia[2]
    print(f"{name}: moment of inertia of the points over that of the outline {ratio:.5f}")
    assert ratio == pytest.approx(1, abs=3e-3)
    # what the integrator goes by: nodes, whose moment is larger by the width of the splines
    ready()
    O.step()
    assert body.state.mass == pytest.approx(DENSITY * points["volume"].sum(), rel=1e-9)
    np.testing.assert_allclose(np.array(body.state.pos), center, atol=1e-8)


def test_outline_and_box_of_a_turned_star():
    body = polygon(turned(STAR, 0.3), zeta=0.1)
    ready()
    O.step()
    outline = body.shape.outline()[:, :2]
    expected = turned(STAR, 0.3)
    distance = np.linalg.norm(outline[:, None] - expected[None], axis=2).min(axis=0)
    assert distance.max() < 1e-9  # corners are nodes
    low, high = np.array(body.bound.min)[:2], np.array(body.bound.max)[:2]
    assert (low <= expected.min(axis=0)).all() and (expected.max(axis=0) <= high).all()
    assert (high - low <= np.ptp(expected, axis=0) + 0.3 * body.shape.radius).all()


@pytest.mark.parametrize("axes", ((0.01, 0.02), (0.02, 0.01)))
@pytest.mark.parametrize("make", (sg.soft_ellipse, sg.soft_superdisk))
def test_axes_lie_as_they_are_given(make, axes):
    O.bodies.append(make((0, 0, 0), axes, material=soft_material(), zeta=0.15))
    ready()
    O.step()
    ends = np.abs(O.bodies[0].shape.outline()[:, :2]).max(axis=0)
    np.testing.assert_allclose(ends, axes, rtol=0.01)


def test_congruent_grains_share_their_tables():
    for k, angle in enumerate((0, 0.7, 2.0)):
        polygon((1 + k) * turned(IRON, angle) + (0.2 * k, 0))
        superdisk(((1 + k) * 1e-3, (1 + k) * 3e-3), angle=angle, center=(0.2 * k, -0.1, 0))
    superdisk((3e-3, 1e-3), center=(0, -0.2, 0))
    ready()
    O.step()
    assert sg.integrator().templates == 2
    polygon(IRON * (-1, 1) + (0.2, -0.2))  # the angle iron is its own mirror image
    polygon(STAR + (0.4, -0.2))
    O.step()
    assert sg.integrator().templates == 3


def settled(seconds):
    while seconds > 0:
        seconds -= O.dt
        O.step()


@pytest.mark.parametrize("zeta, tolerance", [(0.14, 0.25), (0.07, 0.06)])
@pytest.mark.parametrize("along", ("minor", "major"))
def test_pressed_ellipse_follows_hertz(along, zeta, tolerance):
    """Half-width of the contact against 2 sqrt(P r/(pi E*)), r the radius of curvature."""
    a, b = 0.015, 0.01
    r, half = (a * a / b, b) if along == "minor" else (b * b / a, a)
    material = soft_material(massDamping=400.0)
    body = superdisk(
        (a, b), 2.0, 0 if along == "minor" else math.pi / 2, (0, 0, 0), material, zeta=zeta
    )
    floor, top = add_wall(-half, 1, sense=1), add_wall(half, 1, sense=-1)
    ready(tolerance=1e-3)
    widths, forces = [], []
    top.state.vel = (0, -0.05, 0)
    while half - top.state.pos[1] < 0.06 * half:
        O.step()
        if half - top.state.pos[1] > 0.04 * half and O.iter % 5 == 0:
            profile = sg.contact_profile(O.interactions[floor.id, body.id])
            widths.append(sg.contact_halfwidth(profile["position"], profile["force"]))
            forces.append(profile["force"].sum())
    modulus = YOUNG / (1 - 0.45**2)
    hertz = 2 * np.sqrt(np.array(forces) * r / (math.pi * modulus))
    ratio = np.mean(widths) / np.mean(hertz)
    print(f"{along} axis, zeta = {zeta}: half-width over Hertz' {ratio:.4f}")
    assert ratio == pytest.approx(1, abs=tolerance)


def test_a_round_superdisk_is_a_disk():
    """Force between plates as that of a disk, whose nodes lie at other phases."""
    forces = []
    for make in (add_disk, lambda **shape: superdisk((0.01, 0.01), 2.0, **shape)):
        O.reset()
        make(material=soft_material(massDamping=400.0), zeta=0.1)
        add_wall(-0.01, 1, sense=1)
        top = add_wall(0.01, 1, sense=-1, velocity=(0, -0.1, 0))
        ready(tolerance=1e-3)
        while top.state.pos[1] > 0.0092:
            O.step()
        sums = 0.0
        for _ in range(50):
            O.step()
            sums += O.forces.f(top.id)[1] / 50
        forces.append(sums)
    print(f"force of a round superdisk over that of a disk {forces[1] / forces[0]:.4f}")
    assert forces[1] == pytest.approx(forces[0], rel=0.01)


def compressed(body, width):
    """Squeeze along x by 2 % between frictionless plates; mean Cauchy stress along x and y,
    and the force on the right plate."""
    body.material.massDamping = 2000.0
    add_wall(-width / 2, 0, sense=1)
    right = add_wall(width / 2, 0, sense=-1)
    ready(tolerance=1e-3)
    right.state.vel = (-0.05, 0, 0)
    while right.state.pos[0] > 0.48 * width:
        O.step()
    right.state.vel = (0, 0, 0)
    settled(0.02)
    points = body.shape.points()
    mean = np.einsum("p,pij->ij", points["volume"], points["cauchy"]) / points["volume"].sum()
    return mean[0, 0], mean[1, 1], O.forces.f(right.id)[0]


@pytest.mark.parametrize("zeta, tolerance", [(0.27, 0.02), (0.11, 0.005)])
def test_uniform_compression_of_a_polygon(zeta, tolerance):
    """A rectangle as a polygon, whose lattice does not end on its sides as that of a block does:
    its mean stress and force against those of uniform plane strain, and of the block."""
    width, height = 0.02, 0.0093
    corners = np.array([(-width, -height), (width, -height), (width, height), (-width, height)]) / 2
    stress, lateral, force = compressed(polygon(corners, zeta=zeta), width)
    exact, _ = cauchy(with_free_sides(0.98, 1, 0.45), YOUNG, 0.45)
    O.reset()
    block = add(sg.soft_block((0, 0, 0), (width, height), soft_material(), zeta=zeta))
    block_stress, _, block_force = compressed(block, width)
    print(
        f"zeta = {zeta}: stress over exact {stress / exact:.4f} (block {block_stress / exact:.4f}),"
        f" force over that of the block {force / block_force:.4f}, lateral {lateral / stress:.4f}"
    )
    assert stress == pytest.approx(exact, rel=tolerance)
    assert abs(lateral) < 1e-3 * abs(stress)
    assert force == pytest.approx(block_force, rel=tolerance)


def test_rotating_superdisk_keeps_its_angular_momentum():
    body = superdisk((0.02, 0.01), 4.0, 0.3)
    body.state.vel, body.state.angVel = (0.1, 0, 0), (0, 0, 400.0)
    ready()
    O.step()
    nodes, velocities = body.shape.nodes(), body.shape.nodeVelocities()
    spin, inertia = body.state.angVel[2], body.state.inertia[2]
    start = spin * inertia
    assert not body.shape.isRigid()  # it spins so fast that it is strained
    assert len(nodes) == len(velocities)
    run(2000)
    now = body.state.angVel[2] * body.state.inertia[2]
    turns = 2000 * O.dt * spin / (2 * math.pi)
    print(f"angular momentum changes by {now / start - 1:.1e} in {turns:.1f} turns")
    assert now == pytest.approx(start, rel=1e-9)


def test_a_disk_in_the_notch_of_an_angle_iron():
    """A disk falls into the notch and rests against both of its sides."""
    iron = polygon(IRON, zeta=0.2)
    add_wall(0, 1, sense=1)
    add_wall(0, 0, sense=1)
    radius, corner = 0.004, IRON[3]
    material = soft_material(massDamping=500.0)
    iron.material.massDamping = 500.0
    disk = add_disk((*(corner + 1.3 * radius), 0), radius, material, zeta=0.25)
    ready(gravity=(-30, -30, 0))
    settled(0.15)
    contacts = O.interactions[iron.id, disk.id].geom.contacts()
    pushed = contacts["normal"][np.linalg.norm(contacts["impulse"], axis=1) > 0]
    assert (np.abs(pushed[:, 0]) > 0.9).any() and (np.abs(pushed[:, 1]) > 0.9).any()
    np.testing.assert_allclose(np.array(disk.state.pos)[:2] - corner, radius, rtol=0.03)
    assert sg.integrator().largestOverlap < 0.3


def test_stars_squeezed_into_each_other():
    """Stars interlock, tips in the notches of others, without passing through each other."""
    stars = [polygon(turned(STAR, 0.5 * k) + (0.022 * (k % 2), 0.022 * (k // 2))) for k in range(4)]
    low, high = -0.012, 0.034
    walls = [add_wall(p, axis, 0.0, sense=s) for axis in (0, 1) for p, s in ((low, 1), (high, -1))]
    for body in stars:
        body.material.massDamping = 500.0
    ready()
    walls[3].state.vel, walls[1].state.vel = (0, -0.3, 0), (-0.3, 0, 0)
    while walls[3].state.pos[1] > 0.0185:
        O.step()
    assert sg.coordination_number() > 2
    spacing = stars[0].shape.zeta * stars[0].shape.radius
    deepest = max(
        outlines.depth_inside(a.shape.outline()[:, :2], b.shape.outline()[:, :2]).max()
        for a in stars
        for b in stars
        if a is not b
    )
    overlap = sg.integrator().largestOverlap
    print(f"largest overlap of stars {overlap:.3f} dr, deepest node {deepest / spacing:.3f} dr")
    assert overlap < 0.1 and deepest < 0.1 * spacing


def test_saved_polygon_goes_on_with_the_same_bits(tmp_path):
    polygon(STAR)
    superdisk((0.008, 0.005), 3.0, 0.2, (0.001, 0.0149, 0))
    add_wall(STAR[:, 1].min(), 1, friction=0.3)
    ready(gravity=(0, -100, 0))
    run(50)
    assert_goes_on_after_loading(tmp_path / "scene.xml", 50)


@pytest.mark.parametrize("zeta", (0.19, 0.2))
def test_a_pressed_corner_does_not_stop_a_run(zeta):
    """The least material point in the tip decided on the time step, and was inverted."""
    half = 4 * math.tan(math.radians(30))
    corners = [(0, -half * RADIUS), (4 * RADIUS, 0), (0, half * RADIUS)]
    material = soft_material(poisson=0.4, massDamping=2000)
    triangle = sg.soft_polygon(corners, material, zeta=zeta)
    O.bodies.append(triangle)
    x = triangle.shape.outline()[:, 0]
    add_wall(x.min(), 0, sense=1)
    wall = add_wall(x.max(), 0, sense=-1, velocity=(-0.3, 0, 0))
    O.engines = sg.engines()
    sg.set_time_step(0.85)
    while x.max() - wall.state.pos[0] < 0.9 * RADIUS and O.iter < 1500:
        run(20)
    assert O.iter < 800


def test_a_hair_too_thin_for_the_grid_is_refused():
    """Nodes along it took mass from those that they were tied to."""
    spike = [(0, 0), (1, 0), (3, 0.0005), (1, 0.001), (1, 1), (0, 1)]
    polygon(np.array(spike) * RADIUS, zeta=0.3)
    with pytest.raises(ValueError, match="zeta = 0.3 is outside .*, or thicken the th"):
        ready()
