"""Values that make no sense: each is refused by name, value and admissible range."""

import math
import re

import pytest
from scenes import RADIUS, add_disk, add_wall, message_of_step, ready, run, soft_material
from yade import Bo1_SoftGrain_Aabb, FrictMat, O, utils

import softgrain as sg

MATERIAL_ERRORS = [
    ({"poisson": 0.5}, "poisson = 0.5 .*(-1, 0.5).*plane strain"),
    ({"poisson": -1}, "poisson = -1 .*(-1, 0.5)"),
    ({"poisson": float("nan")}, "poisson = "),
    ({"young": 0}, "young = 0 .*(0, inf) Pa"),
    ({"young": float("inf")}, "young = inf .*(0, inf) Pa"),
    ({"density": -1}, "density = -1 .*(0, inf) kg/m"),
    ({"massDamping": -1}, "massDamping = -1 .*[0, inf) 1/s"),
    ({"stiffnessDamping": float("nan")}, "stiffnessDamping = nan .*[0, inf) s"),
    ({"massScaling": 0.5}, "massScaling = 0.5 .*[1, inf)"),
    ({"frictionAngle": -0.1}, "frictionAngle = -0.1.*[0, pi/2) rad"),
    ({"frictionAngle": 2}, "frictionAngle = 2.*[0, pi/2) rad"),
    ({"law": "hooke"}, "law = 'hooke' is unknown.*'neoHookean'"),
    ({"condition": "flat"}, "condition = 'flat' is unknown.*'planeStrain', 'planeStress'"),
]


def pattern(text):
    """A regular expression of which only '.*' is special."""
    return ".*".join(re.escape(part) for part in text.split(".*"))


@pytest.mark.parametrize("attributes, message", MATERIAL_ERRORS, ids=str)
def test_material(attributes, message):
    with pytest.raises(ValueError, match=pattern(message)):
        sg.SoftMat(**attributes)


@pytest.mark.parametrize("attributes, message", MATERIAL_ERRORS, ids=str)
def test_material_changed_later(attributes, message):
    """Refused when it is assigned, or in the next step."""
    disk = add_disk()
    ready()
    run(2)
    name, value = next(iter(attributes.items()))
    with pytest.raises((ValueError, RuntimeError), match=pattern(message)):
        setattr(disk.material, name, value)
        run(1)


@pytest.mark.parametrize(
    "attributes, message",
    [
        ({"radius": -1}, "radius = -1.*(0, inf) m"),
        ({"radius": 0}, "radius = 0.*(0, inf) m"),
        ({"zeta": 3}, "zeta = 3 .*0.5]"),
        ({"zeta": 0}, "zeta = 0 .*0.5]"),
        ({"order": 4}, "order = 4 .*1, 2.*3"),
        ({"nodeSpacing": 1}, "nodeSpacing = 1 .*[1.25, 4]"),
        ({"surfaceSpacing": 9}, "surfaceSpacing = 9 .*[0.5, 4]"),
        ({"quadrature": "gauss"}, "quadrature = 'gauss' is unknown.*'cutCell', 'lattice'"),
        ({"contact": "springs"}, "contact = 'springs' is unknown.*'surface', 'points'"),
        ({"formulation": "euler"}, "formulation = 'euler' is unknown.*'total', 'updated'"),
        ({"velocityUpdate": "pic"}, "velocityUpdate = 'pic' is unknown.*'nodal', 'flip'"),
        ({"picShare": 2, "velocityUpdate": "flip"}, "picShare = 2 .*[0, 1]"),
        ({"picShare": 0.1}, "picShare = 0.1 .*velocityUpdate = 'flip'.*formulation = 'updated'"),
        ({"formulation": "updated", "order": 1}, "order = 1 .*2, 3 for formulation = 'updated'"),
    ],
    ids=str,
)
def test_grain(attributes, message):
    attributes = dict(attributes)
    radius = attributes.pop("radius", RADIUS)
    for make in (sg.soft_disk, sg.soft_sphere):
        with pytest.raises(ValueError, match=pattern(message)):
            make((0, 0, 0), radius, soft_material(), **attributes)


def test_grain_of_unknown_attribute():
    with pytest.raises(ValueError, match="resolution is no attribute"):
        sg.soft_disk((0, 0, 0), RADIUS, soft_material(), resolution=0.1)


@pytest.mark.parametrize(
    "attributes, message",
    [
        ({"timeStepFraction": 1.5}, "timeStepFraction = 1.5 .*(0, 1]"),
        ({"timeStepFraction": 0}, "timeStepFraction = 0 .*(0, 1]"),
        ({"tolerance": -1}, "tolerance = -1 .*(0, inf)"),
        ({"maxSweeps": 0}, "maxSweeps = 0 .*1, 2"),
        ({"overlapRelaxation": 2}, "overlapRelaxation = 2 .*[0, 1]"),
        ({"overlapSpeed": -1}, "overlapSpeed = -1 .*[0, inf]"),
        ({"maxOverlap": 0}, "maxOverlap = 0 .*(0, inf]"),
    ],
    ids=str,
)
def test_integrator(attributes, message):
    with pytest.raises(ValueError, match=pattern(message)):
        sg.engines(verlet_distance=0.1, **attributes)


@pytest.mark.parametrize("margin", (0, -0.1, math.nan, math.inf))
def test_margin_of_boxes(margin):
    with pytest.raises(ValueError, match=pattern("margin = .*(0, inf)")):
        Bo1_SoftGrain_Aabb(margin=margin)


@pytest.mark.parametrize("fraction", (0, -1, 1.01, float("nan")))
def test_time_step_fraction(fraction):
    add_disk()
    with pytest.raises(ValueError, match=r"fraction = .*\(0, 1\]"):
        sg.set_time_step(fraction)


@pytest.mark.parametrize("dt", (0.0, float("nan")))
def test_senseless_time_step(dt):
    add_disk()
    ready()
    run(1)
    O.dt = dt
    assert "O.dt = " in message_of_step()


def test_discretisation_is_read_only():
    disk = add_disk()
    for name, value in (
        ("zeta", 0.1),
        ("radius", 1.0),
        ("dim", 3),
        ("order", 2),
        ("contact", "points"),
        ("formulation", "updated"),
        ("velocityUpdate", "flip"),
    ):
        with pytest.raises(AttributeError):
            setattr(disk.shape, name, value)


def test_saved_wrong_value_is_refused(tmp_path):
    """A file edited by hand is checked as well."""
    add_disk()
    ready()
    path = tmp_path / "scene.xml"
    O.save(str(path))
    text = path.read_text()
    changed = re.sub(r"<poisson>[^<]*</poisson>", "<poisson>0.5</poisson>", text)
    assert changed != text
    path.write_text(changed)
    with pytest.raises((ValueError, RuntimeError), match="poisson = 0.5"):
        O.load(str(path))


def test_refused_mass_scaling_is_not_computed_with():
    disk = add_disk()
    ready()
    run(2)
    with pytest.raises(ValueError, match="massScaling"):
        disk.material.massScaling = 0.5
    assert "massScaling = 0.5 is outside the admissible range [1, inf)" in message_of_step()


def test_refused_margin_stops_the_run():
    add_disk()
    ready()
    run(2)
    functor = next(f for f in O.engines[1].boundDispatcher.functors if hasattr(f, "margin"))
    with pytest.raises(ValueError, match="margin"):
        functor.margin = -1
    assert "margin = -1 is outside the admissible range (0, inf)" in message_of_step()


@pytest.mark.parametrize("angle", (math.nan, 2.0))
def test_refused_friction_angle_is_not_that_of_the_partner(angle):
    """The contact is made after it."""
    disk = add_disk((0, 1.2 * RADIUS, 0))
    disk.state.vel = (0, -1, 0)
    add_wall(0, axis=1, material=FrictMat(frictionAngle=1.0))
    ready()
    with pytest.raises(ValueError, match="frictionAngle"):
        disk.material.frictionAngle = angle
    assert "frictionAngle of SoftMat" in message_of_step(2000)


@pytest.mark.parametrize("dt", (0, math.nan, math.inf))
def test_senseless_time_step_of_rigid_bodies(dt):
    for x in (0, 2.1 * RADIUS):
        O.bodies.append(utils.sphere((x, 0, 0), RADIUS, material=FrictMat()))
    O.engines = sg.engines(rigid="nonsmooth")
    O.dt = dt
    assert "O.dt = " in message_of_step()
