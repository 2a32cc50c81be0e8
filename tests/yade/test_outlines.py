"""Polygons, ellipses, superdisks and grains from images inside YADE."""

import math
import re

import numpy as np
import pytest
from PIL import Image
from scenes import DENSITY, YOUNG, add_disk, add_wall, present_state, ready, run, soft_material
from yade import O

import softgrain as sg

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


def add(body):
    O.bodies.append(body)
    return body


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
        (lambda: sg.soft_ellipse((0, 0, 0), (1, 0)), "half_axes = (1, 0): admissible are two"),
        (lambda: sg.soft_ellipse((0, 0, 0), (1, 1, 1)), "half_axes = (1, 1, 1)"),
        (lambda: sg.soft_superdisk((0, 0, 0), (200, 1)), "aspect (component) = 200"),
        (lambda: sg.soft_superdisk((0, 0, 0), (2, 1), 1.0), "exponent = 1 is outside"),
        (lambda: sg.soft_polygon([(0, 0), (2, 2), (2, 0), (0, 3)]), "crosses or touches itself"),
        (lambda: sg.SoftGrain(dim=2, form="polygon"), "a polygon has at least three"),
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
        area, centroid, inertia = sg.outlines.area_and_inertia(vertices)
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
    assert material_moment(body) == pytest.approx(body.state.inertia[2], rel=3e-3)
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
    assert (high - low <= np.ptp(expected, axis=0) + 0.11 * body.shape.radius).all()


def test_congruent_grains_share_their_tables():
    for k, angle in enumerate((0, 0.7, 2.0)):
        shift = (0.05 * k, 0)
        polygon((1 + k) * turned(IRON, angle) + shift)
        superdisk(((1 + k) * 1e-3, (1 + k) * 3e-3), angle=angle, center=(*shift, 0))
    superdisk((3e-3, 1e-3), center=(0.2, 0, 0))
    ready()
    O.step()
    assert sg.integrator().templates == 2
    polygon(IRON * (-1, 1) + (0.3, 0.1))  # the angle iron is its own mirror image
    polygon(STAR + (0.3, 0.2))
    O.step()
    assert sg.integrator().templates == 3


def settled(seconds):
    while seconds > 0:
        seconds -= O.dt
        O.step()


@pytest.mark.parametrize("zeta, tolerance", [(0.14, 0.06), (0.07, 0.03)])
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
    print(f"forces {forces}")
    assert forces[1] == pytest.approx(forces[0], rel=0.01)


def test_uniform_compression_of_a_polygon():
    """A rectangle given as a polygon, squeezed along x between frictionless plates: uniform stress
    of plane strain."""
    width, height = 0.02, 0.01
    corners = np.array([(-width, -height), (width, -height), (width, height), (-width, height)]) / 2
    body = add(sg.soft_polygon(corners, soft_material(massDamping=2000.0), zeta=0.25))
    add_wall(-width / 2, 0, sense=1)
    right = add_wall(width / 2, 0, sense=-1)
    ready(tolerance=1e-3)
    right.state.vel = (-0.05, 0, 0)
    while right.state.pos[0] > 0.98 * width / 2:
        O.step()
    right.state.vel = (0, 0, 0)
    settled(0.02)
    cauchy = body.shape.points()["cauchy"]
    strain = np.mean(body.shape.points()["F"][:, 0, 0]) - 1
    stress = YOUNG / (1 - 0.45**2) * strain  # to first order
    scatter = np.std(cauchy[:, 0, 0]) / abs(np.mean(cauchy[:, 0, 0]))
    lateral = np.abs(np.mean(cauchy[:, 1, 1])) / abs(stress)
    print(f"stress over Hooke's {np.mean(cauchy[:, 0, 0]) / stress:.4f}, scatter {scatter:.4f}")
    assert np.mean(cauchy[:, 0, 0]) == pytest.approx(stress, rel=0.03)
    assert scatter < 0.02 and lateral < 0.02
    force = O.forces.f(right.id)[0]
    assert force == pytest.approx(-stress * height, rel=0.04)


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


def test_angle_irons_and_a_disk_in_the_notch():
    """A disk falls into the notch of a fixed iron's twin, and rests against both of its sides."""
    iron = polygon(turned(IRON, math.pi / 4), zeta=0.2)  # opens upwards
    lowest = turned(IRON, math.pi / 4)[:, 1].min()
    notch = turned(IRON, math.pi / 4)[3]
    add_wall(lowest, 1, sense=1)
    add_wall(notch[0] - 0.0128, 0, sense=1)
    add_wall(notch[0] + 0.0128, 0, sense=-1)
    radius = 0.004
    material = soft_material(massDamping=500.0)
    iron.material.massDamping = 500.0
    disk = add_disk((notch[0], notch[1] + 1.5 * radius, 0), radius, material, zeta=0.25)
    ready(gravity=(0, -50, 0))
    settled(0.15)
    contacts = O.interactions[iron.id, disk.id].geom.contacts()
    pushed = contacts["impulse"][np.linalg.norm(contacts["impulse"], axis=1) > 0]
    assert (pushed[:, 0] > 0).any() and (pushed[:, 0] < 0).any()
    assert disk.state.pos[1] - notch[1] == pytest.approx(math.sqrt(2) * radius, rel=0.05)
    assert disk.state.pos[0] == pytest.approx(notch[0], abs=0.05 * radius)
    assert sg.integrator().largestOverlap < 0.3


def test_stars_squeezed_into_each_other():
    """Stars interlock without passing through each other; momentum balance of the walls."""
    stars = [polygon(turned(STAR, 0.5 * k) + (0.022 * (k % 2), 0.022 * (k // 2))) for k in range(4)]
    low, high = -0.012, 0.034
    walls = [add_wall(p, axis, 0.0, sense=s) for axis in (0, 1) for p, s in ((low, 1), (high, -1))]
    for body in stars:
        body.material.massDamping = 500.0
    ready()
    walls[3].state.vel, walls[1].state.vel = (0, -0.3, 0), (-0.3, 0, 0)
    while walls[3].state.pos[1] > 0.026:
        O.step()
    for wall in walls:
        wall.state.vel = (0, 0, 0)
    settled(0.03)
    assert sg.integrator().largestOverlap < 0.5
    forces = [O.forces.f(wall.id)[k // 2] for k, wall in enumerate(walls)]
    assert forces[1] > 0 and forces[3] > 0
    assert forces[0] == pytest.approx(-forces[1], rel=0.05)
    assert forces[2] == pytest.approx(-forces[3], rel=0.05)
    from matplotlib.path import Path

    for body in stars:  # no node of one lies inside another by more than half a spacing
        region = Path(body.shape.outline()[:, :2])
        depth = 0.5 * body.shape.zeta * body.shape.radius
        for other in stars:
            if other is not body:
                inside = region.contains_points(other.shape.outline()[:, :2], radius=-depth)
                outside = region.contains_points(other.shape.outline()[:, :2], radius=depth)
                assert not (inside & outside).any()


def test_saved_polygon_goes_on_with_the_same_bits(tmp_path):
    polygon(STAR)
    superdisk((0.008, 0.005), 3.0, 0.2, (0.001, 0.0149, 0))
    add_wall(STAR[:, 1].min(), 1, friction=0.3)
    ready(gravity=(0, -100, 0))
    run(50)
    O.save(str(tmp_path / "scene.xml"))
    run(50)
    expected = present_state()
    O.load(str(tmp_path / "scene.xml"))
    run(50)
    found = present_state()
    for name in expected:
        np.testing.assert_array_equal(found[name], expected[name], err_msg=name)


def drawn_labels():
    """Two disks side by side and a square, labels 5, 9 and 70, in a picture of 90 x 60 pixels."""
    labels = np.zeros((60, 90), np.uint8)
    rows, columns = np.mgrid[:60, :90] + 0.5
    labels[(columns - 25) ** 2 + (rows - 30) ** 2 < 15**2] = 5
    labels[(columns - 55) ** 2 + (rows - 30) ** 2 < 15**2] = 9
    labels[35:55, 70:85] = 70
    return labels


@pytest.mark.parametrize("how", ("array", "grey", "palette", "colour"))
def test_grains_from_an_image(how, tmp_path):
    labels = drawn_labels()
    names = [5, 9, 70]
    if how == "array":
        image = labels
    else:
        image = tmp_path / "labels.png"
        picture = Image.fromarray(labels)
        if how == "palette":
            picture.putpalette([int(v) for v in np.arange(768) % 256])
        if how == "colour":
            colours = np.zeros((*labels.shape, 3), np.uint8)
            colours[:, :, 1] = labels
            picture = Image.fromarray(colours)
            names = [256 * name for name in names]
        picture.save(image)
    pixel = 1e-4
    found = sg.grains_from_image(image, pixel, soft_material(), zeta=0.25)
    assert found.labels == names and not found.left_out
    assert found.size == pytest.approx((90 * pixel, 60 * pixel))
    assert np.abs(found.area_errors).max() < 0.01
    O.bodies.append(found.bodies)
    left, right, square = found.bodies
    np.testing.assert_allclose(left.state.pos, (25 * pixel, 30 * pixel, 0), atol=0.1 * pixel)
    np.testing.assert_allclose(square.state.pos, (77.5 * pixel, 15 * pixel, 0), atol=0.1 * pixel)
    assert left.state.mass == pytest.approx(DENSITY * math.pi * (15 * pixel) ** 2, rel=0.02)
    ready()
    run(20)
    assert sg.integrator().largestOverlap < 0.1


def test_unusable_labels_are_refused_or_reported():
    labels = drawn_labels()
    labels[0:10, 0:10] = 3
    with pytest.raises(ValueError, match="label 3 touches the border of the image"):
        sg.grains_from_image(labels, 1e-4, soft_material())
    found = sg.grains_from_image(labels, 1e-4, soft_material(), unusable="skip")
    assert found.labels == [5, 9, 70] and list(found.left_out) == [3]


@pytest.mark.parametrize(
    "arguments, message",
    [
        ({"pixel": 0}, "pixel = 0 is outside"),
        ({"unusable": "mend"}, "unusable = 'mend' is unknown"),
        ({"least_pixels": 2}, "least_pixels = 2 is outside"),
        ({"smoothing": 0.1}, "smoothing = 0.1 is outside"),
        ({"image": np.zeros((5, 5))}, "image: float64 of shape (5, 5)"),
        ({"image": np.zeros((5, 5), int)}, "image: no usable label"),
    ],
)
def test_bad_image(arguments, message):
    with pytest.raises(ValueError, match=re.escape(message)):
        sg.grains_from_image(**{"image": drawn_labels(), "pixel": 1e-4, **arguments})
