"""Runs that go wrong stop with what, where and a hint; all can be read, saved and resumed."""

import contextlib
import math

import numpy as np
import pytest
from scenes import (
    RADIUS,
    YADE,
    add_disk,
    add_wall,
    assert_done,
    message_of_step,
    ready,
    run,
    run_python,
    soft_material,
)
from yade import NewtonIntegrator, O

import softgrain as sg


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


@pytest.mark.parametrize("mu, locks", ((0.95, False), (1.05, True)))
def test_grain_that_walls_lock_by_friction(mu, locks):
    """A block in the corner of two that close in slides out of it up to mu = 1; the law has no
    other solution beyond than to crush it."""
    material = soft_material(poisson=0.3, frictionAngle=math.atan(mu), massDamping=2000)
    O.bodies.append(sg.soft_block((0, 0, 0), (2 * RADIUS, 2 * RADIUS), material=material, zeta=0.4))
    for axis in (0, 1):
        velocity = [-0.2 if a == axis else 0 for a in range(3)]
        add_wall(RADIUS, axis, friction=mu, velocity=velocity, sense=-1)
    ready()
    if locks:
        message = message_of_step(3000)
        assert "do several walls close in on the grain? With such friction it locks" in message
        return
    run(800)
    assert sg.integrator().largestOverlap < 0.1


@pytest.mark.parametrize("sense, side", ((1, "positive"), (-1, "negative")))
def test_grain_on_the_wrong_side_of_a_wall(sense, side):
    add_disk()
    add_wall(-0.5 * sense * RADIUS, 0, sense=sense)
    O.engines = sg.engines()
    assert f"on the {side} side of the wall, as its sense = {sense} says" in message_of_step()
