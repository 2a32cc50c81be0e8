"""Each mistake has its own message: the parameter, its value, what is admissible; none aborts."""

import contextlib
import math
import re

import numpy as np
import pytest
from scenes import (
    RADIUS,
    YADE,
    ZETA,
    add_disk,
    add_wall,
    assert_done,
    message_of_step,
    ready,
    run,
    run_python,
    soft_material,
)
from yade import (
    Bo1_SoftGrain_Aabb,
    ElastMat,
    FrictMat,
    InteractionLoop,
    NewtonIntegrator,
    O,
    utils,
)

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


def test_rigid_material_for_a_soft_grain():
    with pytest.raises(ValueError, match="material = FrictMat.*SoftMat"):
        sg.soft_disk((0, 0, 0), RADIUS, FrictMat())


@pytest.mark.parametrize("fraction", (0, -1, 1.01, float("nan")))
def test_time_step_fraction(fraction):
    add_disk()
    with pytest.raises(ValueError, match=r"fraction = .*\(0, 1\]"):
        sg.set_time_step(fraction)


def test_no_soft_grain():
    with pytest.raises(ValueError, match="no soft grain"):
        sg.set_time_step()
    with pytest.raises(ValueError, match="verlet_distance"):
        sg.engines()
    with pytest.raises(ValueError, match="SoftGrainIntegrator"):
        sg.integrator()


def test_time_step_too_large(tmp_path):
    """Refused with the admissible value; nothing has moved; all can be read, saved and resumed."""
    disk = add_disk()
    disk.state.vel = (1, 0, 0)
    ready()
    run(3)
    before, steps = disk.shape.nodes(), sg.integrator().steps
    limit = sg.critical_time_step()
    O.dt = 3 * limit
    message = message_of_step()
    assert (
        "O.dt = " in message and "admissible range (0, " in message and "set_time_step" in message
    )
    named = float(message.split("(0, ")[1].split("]")[0])
    assert named == pytest.approx(limit, rel=1e-4)
    np.testing.assert_array_equal(disk.shape.nodes(), before)
    assert sg.integrator().steps == steps and O.iter == 3
    O.save(str(tmp_path / "scene.xml.gz"))
    O.dt = 0.5 * limit
    run(2)
    assert sg.integrator().lastError == ""
    assert O.iter == 5


@pytest.mark.parametrize("dt", (0.0, float("nan")))
def test_senseless_time_step(dt):
    add_disk()
    ready()
    run(1)
    O.dt = dt
    assert "O.dt = " in message_of_step()


@pytest.mark.parametrize("material", (FrictMat(), None), ids=("FrictMat", "None"))
def test_soft_shape_with_a_rigid_material(material):
    disk = add_disk()
    add_disk((1.9 * RADIUS, 0, 0))
    add_wall(-0.95 * RADIUS, 0)
    disk.material = material
    O.engines = sg.engines()
    kind = "FrictMat" if material else "None"
    assert f"body #0 has the soft shape SoftGrain but the material {kind}" in message_of_step()
    with pytest.raises(ValueError, match="body #0 has the soft shape"):
        sg.set_time_step()
    with pytest.raises(ValueError, match="body #0 has the soft shape"):
        disk.shape.nodes()


def test_rigid_sphere_with_a_soft_material():
    add_disk()
    sphere = utils.sphere((5 * RADIUS, 0, 0), RADIUS, material=soft_material())
    O.bodies.append(sphere)
    O.engines = sg.engines()
    assert "body #1 has the material SoftMat but the rigid shape Sphere" in message_of_step()


def test_missing_integrator_of_newton():
    add_disk()
    O.engines = sg.engines()[:-1]
    with pytest.raises(RuntimeError, match="NewtonIntegrator"):
        run(1)


def test_integrator_of_newton_too_early():
    add_disk()
    engines = sg.engines()
    O.engines = engines[:3] + [engines[4], engines[3]]
    assert "NewtonIntegrator stands before SoftGrainIntegrator" in message_of_step()


def rigid_sphere():
    return utils.sphere((1.5 * RADIUS, 0, 0), RADIUS, material=FrictMat())


def rigid_facet():
    x = 0.9 * RADIUS
    return utils.facet([(x, -1, -1), (x, 1, -1), (x, 0, 1)], material=FrictMat())


def rigid_box():
    return utils.box((1.5 * RADIUS, 0, 0), (RADIUS, RADIUS, RADIUS), material=FrictMat())


@pytest.mark.parametrize(
    "make, shape", [(rigid_sphere, "Sphere"), (rigid_facet, "Facet"), (rigid_box, "Box")]
)
def test_rigid_body_without_a_functor(make, shape):
    """A list of engines of the user's that lacks what the pair needs: not passed through."""
    add_disk()
    O.bodies.append(make())
    engines = sg.engines()
    engines[2] = InteractionLoop(
        [sg.Ig2_SoftGrain_SoftGrain_SoftGeom(), sg.Ig2_Wall_SoftGrain_SoftGeom()],
        [sg.Ip2_SoftMat_SoftMat_SoftPhys(), sg.Ip2_FrictMat_SoftMat_SoftPhys()],
        [sg.Law2_SoftGeom_SoftPhys_Nonsmooth()],
    )
    O.engines = engines
    message = message_of_step()
    assert f"soft grain #0 comes near body #1 of shape {shape}" in message
    assert "Ig2_Sphere_SoftGrain_SoftGeom" in message


def test_clump():
    add_disk()
    add_disk((3 * RADIUS, 0, 0))
    O.bodies.clump([0, 1])
    O.engines = sg.engines()
    assert "body #0 is a soft grain in a clump, which is not supported" in message_of_step()


def test_disk_and_ball_in_one_scene():
    add_disk()
    O.bodies.append(sg.soft_sphere((3 * RADIUS, 0, 0), RADIUS, soft_material(), zeta=ZETA))
    O.engines = sg.engines()
    assert "grains #0 and #1 have different dim" in message_of_step()


def test_two_contact_geometries():
    add_disk()
    add_disk((3 * RADIUS, 0, 0), contact="points")
    O.engines = sg.engines()
    message = message_of_step()
    assert "grains #0 and #1 have different contact geometries" in message
    assert "'surface'" in message and "'points'" in message


def test_disks_in_two_planes():
    add_disk()
    add_disk((3 * RADIUS, 0, RADIUS))
    O.engines = sg.engines()
    assert "grain #1: 2D soft grains must lie in one plane z = const" in message_of_step()


@pytest.mark.parametrize("distance", (1.2, 0.5, 1e-3, 0.0))
@pytest.mark.parametrize("make", (sg.soft_disk, sg.soft_sphere))
def test_grains_far_inside_each_other(make, distance):
    for x in (0, distance * RADIUS):
        O.bodies.append(make((x, 0, 0), RADIUS, soft_material(), zeta=0.4))
    O.engines = sg.engines()
    message = message_of_step()
    way = "overlap by" if distance > 0.1 else ": one lies inside the other, an overlap of more"
    assert "bodies #0 and #1" in message and way in message and "maxOverlap = 1" in message
    assert "Hint" in message


@pytest.mark.parametrize("contact", ("surface", "points"))
@pytest.mark.parametrize("offset", (0.0, 0.1, 0.5))
def test_grain_inside_another(offset, contact):
    """No outline crosses the other, yet it is the worst of overlaps."""
    add_disk(contact=contact)
    add_disk((offset * RADIUS, 0, 0), 0.3 * RADIUS, contact=contact)
    O.engines = sg.engines()
    assert "bodies #0 and #1: one lies inside the other" in message_of_step()


def test_grain_across_a_wall():
    add_disk()
    add_wall(-0.5 * RADIUS, 0)
    O.engines = sg.engines()
    assert "#1 and #0 overlap by" in message_of_step()


def assert_readable(disk, path):
    """After an error: positions are finite, and the scene can be saved and loaded."""
    nodes = disk.shape.nodes()
    assert np.isfinite(nodes).all() and np.isfinite(disk.shape.outline()).all()
    O.save(str(path))
    O.load(str(path))
    np.testing.assert_array_equal(sg.soft_bodies()[0].shape.nodes(), nodes)


@pytest.mark.parametrize("speed", (200, 2000))
def test_inverted_point(speed, tmp_path):
    """A wall faster than the waves: the message names grain, point, step and what to do."""
    disk = add_disk(zeta=0.3)
    add_wall(-1.01 * RADIUS, 0, velocity=(speed, 0, 0), sense=1)
    ready()
    message = message_of_step(50)
    assert "soft grain #0, material point " in message and "inverted" in message
    assert "Hint: load more slowly" in message and "timeStepFraction (now 0.5)" in message
    assert "zeta" in message
    assert_readable(disk, tmp_path / "scene.xml.gz")


def test_first_step_sees_fast_walls():
    """Where O.dt is left to the integrator, the first search must know the step that follows."""
    disk = add_disk(zeta=0.3)
    wall = add_wall(-1.01 * RADIUS, 0, velocity=(20, 0, 0), sense=1)
    O.engines = sg.engines()
    assert O.dt < 1e-7
    run(30)
    assert disk.shape.outline()[:, 0].min() > wall.state.pos[0] - 0.05 * 0.3 * RADIUS
    assert sg.integrator().largestOverlap < 0.05


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


def test_error_inside_a_run():
    """O.run in the background ends; the integrator still knows why."""
    add_disk()
    ready()
    run(1)
    O.dt = 1.0
    with contextlib.suppress(RuntimeError):  # which YADE's own thread may lose
        O.run(5, True)
    assert "O.dt = 1 s" in sg.integrator().lastError
    assert O.iter == 1


def test_scene_without_the_plugin(tmp_path):
    """A saved soft scene needs the import; with it, it loads in the same process."""
    add_disk()
    ready()
    run(2)
    O.save(str(tmp_path / "scene.xml.gz"))
    assert_done(
        run_python(
            """
        try:
            O.load("scene.xml.gz")
        except RuntimeError as error:
            assert "unregistered class" in str(error), error
        else:
            raise AssertionError("loaded")
        import softgrain
        O.load("scene.xml.gz")
        assert O.iter == 2 and len(O.bodies) == 1
        O.run(2, True)
        assert O.iter == 4
        print("done")
        """,
            tmp_path,
            command=[YADE, "-n", "-x"],
        )
    )


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


def test_body_removed_and_added_in_the_run():
    """Not a mistake: the rest goes on undisturbed."""
    first, second = add_disk(), add_disk((3 * RADIUS, 0, 0))
    first.state.vel = second.state.vel = (1, 0, 0)
    ready()
    run(5)
    O.bodies.erase(first.id)
    run(5)
    add_disk((-3 * RADIUS, 0, 0))
    run(5)
    assert second.state.pos[0] == pytest.approx(3 * RADIUS + O.time, rel=1e-10)
    assert isinstance(O.engines[-1], NewtonIntegrator)


def without_newton():
    O.engines[-1].dead = True


def newton_twice():
    O.engines = [*O.engines, NewtonIntegrator()]


def newton_that_passes_over():
    O.bodies[0].mask, O.engines[-1].mask = 2, 1


@pytest.mark.parametrize(
    "change, message",
    [
        (without_newton, "no NewtonIntegrator after it in O.engines that is not dead"),
        (newton_twice, "two NewtonIntegrators"),
        (newton_that_passes_over, "mask = 1 leaves out soft grain #0 of mask = 2"),
    ],
    ids=lambda value: getattr(value, "__name__", ""),
)
def test_newton_that_does_not_carry_state_along(change, message):
    add_disk()
    ready()
    change()
    assert message in message_of_step()


def test_dead_newton_beside_a_live_one():
    body = add_disk()
    ready()
    newton_twice()
    O.engines[-1].dead = True
    body.state.vel = (1, 0, 0)
    run(2)
    assert body.state.pos[0] == pytest.approx(O.time)


def test_shape_of_two_bodies():
    first = add_disk()
    second = sg.soft_disk((5 * RADIUS, 0, 0), RADIUS, first.material, zeta=ZETA)
    second.shape = first.shape
    O.bodies.append(second)
    O.engines = sg.engines()
    assert "body #0 and body #1 share one SoftGrain" in message_of_step()


@pytest.mark.parametrize("make", (rigid_sphere, rigid_facet, rigid_box))
@pytest.mark.parametrize("material", (ElastMat, None), ids=str)
def test_rigid_body_without_friction(make, material):
    """YADE would end the process: there is no Ip2 for the pair."""
    add_disk()
    body = make()
    body.material = material and material()
    O.bodies.append(body)
    O.engines = sg.engines()
    message = message_of_step()
    name = material.__name__ if material else "None"
    assert f"soft grain #0 comes near body #1 of material {name}" in message
    assert "FrictMat" in message


@pytest.mark.parametrize("dt", (0, math.nan, math.inf))
def test_senseless_time_step_of_rigid_bodies(dt):
    for x in (0, 2.1 * RADIUS):
        O.bodies.append(utils.sphere((x, 0, 0), RADIUS, material=FrictMat()))
    O.engines = sg.engines(rigid="nonsmooth")
    O.dt = dt
    assert "O.dt = " in message_of_step()
