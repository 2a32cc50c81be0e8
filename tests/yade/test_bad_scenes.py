"""Bodies, materials and engines that do not go together: each has its own message; none aborts."""

import math
import re

import pytest
from scenes import RADIUS, ZETA, add_disk, add_wall, message_of_step, ready, run, soft_material
from yade import (
    ElastMat,
    FrictMat,
    InteractionLoop,
    NewtonIntegrator,
    O,
    Quaternion,
    Vector3,
    utils,
)

import softgrain as sg


def test_rigid_material_for_a_soft_grain():
    with pytest.raises(ValueError, match="material = FrictMat.*SoftMat"):
        sg.soft_disk((0, 0, 0), RADIUS, FrictMat())


def test_no_soft_grain():
    with pytest.raises(ValueError, match="no soft grain"):
        sg.set_time_step()
    with pytest.raises(ValueError, match="verlet_distance"):
        sg.engines()
    with pytest.raises(ValueError, match="SoftGrainIntegrator"):
        sg.integrator()


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
    message = "body #1 has the material SoftMat but the rigid shape Sphere"
    with pytest.raises(ValueError, match=message):
        sg.engines()
    sphere.material = FrictMat()
    O.engines = sg.engines()
    sphere.material = soft_material()
    assert message in message_of_step()


@pytest.mark.parametrize("missing", ("physDispatcher", "lawDispatcher"))
def test_missing_functors_of_a_loop_do_not_end_the_process(missing):
    """Also where the grains were assembled before, and touch at once."""
    add_disk()
    add_disk((1.99 * RADIUS, 0, 0))
    O.engines = sg.engines()
    sg.set_time_step()
    (loop,) = [e for e in O.engines if isinstance(e, InteractionLoop)]
    kept = getattr(loop, missing).functors
    getattr(loop, missing).functors = []
    assert "InteractionLoop: it finds contacts of soft grains, but has no" in message_of_step()
    getattr(loop, missing).functors = kept
    run(3)
    assert O.interactions.countReal() == 1
    add_disk((3.98 * RADIUS, 0, 0))
    getattr(loop, missing).functors = []
    assert "InteractionLoop: it finds contacts of soft grains, but has no" in message_of_step()
    getattr(loop, missing).functors = kept
    run(3)
    assert O.interactions.countReal() == 2


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


@pytest.mark.parametrize("make", (rigid_sphere, rigid_facet, rigid_box))
@pytest.mark.parametrize("attribute", ("pos", "ori", "vel", "angVel"))
def test_state_of_a_rigid_body_that_is_no_number(make, attribute):
    """Without bounds it would touch nothing any more."""
    disk = add_disk((-0.5 * RADIUS, 0, 0))
    rigid = O.bodies[O.bodies.append(make())]
    ready()
    run(1)
    place = disk.state.pos
    value = Quaternion(math.nan, 0, 0, 0) if attribute == "ori" else (0, 0, math.nan)
    setattr(rigid.state, attribute, value)
    assert f"body #1: state.{attribute} is not finite" in message_of_step()
    assert disk.state.pos == place


def rigid_wall():
    return utils.wall(-1.5 * RADIUS, axis=0, sense=1, material=FrictMat())


@pytest.mark.parametrize(
    "make, attribute, value, message",
    [
        (rigid_box, "extents", (RADIUS, -RADIUS, RADIUS), rf"half a side .* = -{RADIUS} is "),
        (rigid_sphere, "radius", math.nan, r"shape.radius = nan is .* \(0, inf\) m"),
        (rigid_sphere, "radius", 0, r"shape.radius = 0 is .* \(0, inf\) m"),
        (rigid_facet, "vertices", [Vector3(math.nan, 0, 0)] * 3, "shape.vertices are not finite"),
        (rigid_wall, "sense", 2, "shape.sense = 2 is .* -1, 0, 1"),
    ],
)
def test_shape_that_would_bear_nothing(make, attribute, value, message):
    add_disk((-0.5 * RADIUS, 0, 0))
    rigid = O.bodies[O.bodies.append(make())]
    ready()
    run(1)
    setattr(rigid.shape, attribute, value)
    assert re.search(f"body #1: {message}", message_of_step())
