"""Small scenes and subprocesses common to the tests inside YADE."""

import math
import os
import subprocess
import sys
import textwrap

import numpy as np
import pytest

import softgrain as sg
from yade import FrictMat, O, utils

RADIUS = 0.01  # m
WIDE = 20 * RADIUS  # half the width of facets across the plane of 2D grains, m
ZETA = 0.25  # coarse: accuracy is not the point
DENSITY = 1000.0  # kg/m^3
YOUNG = 1e6  # Pa
YADE = "/usr/bin/yade"


def soft_material(**attributes):
    return sg.SoftMat(**{"young": YOUNG, "poisson": 0.45, "density": DENSITY, **attributes})


def damped_material():
    return soft_material(massDamping=300, frictionAngle=0.3)


def add_disk(center=(0, 0, 0), radius=RADIUS, material=None, **shape):
    """A soft disk in the scene; returns its body."""
    shape = {"zeta": ZETA, **shape}
    body = sg.soft_disk(center, radius, material or soft_material(), **shape)
    O.bodies.append(body)
    return body


def points_of(body):
    """Number of the material points of a soft grain."""
    return len(body.shape.points()["volume"])


def add_wall(position, axis, friction=0.0, velocity=(0, 0, 0), sense=0):
    """A wall in the scene; returns its body."""
    material = FrictMat(frictionAngle=math.atan(friction))
    wall = utils.wall(position, axis=axis, sense=sense, material=material)
    wall.state.vel = velocity
    O.bodies.append(wall)
    return wall


def add_facets(start, end, material):
    """Two, that cut the plane of 2D grains in the way from `start` to `end` (over R)."""
    ways = ((start, -1), (end, -1), (end, 1), (start, 1))
    a, b, c, d = ((x * RADIUS, y * RADIUS, z * WIDE) for (x, y), z in ways)
    O.bodies.append([utils.facet(f, material=material) for f in ((a, b, c), (a, c, d))])


def ready(**engines):
    """Engines and time step for the soft grains of the scene; returns O.dt. Half the critical step:
    the tests count steps."""
    O.engines = sg.engines(**engines)
    return sg.set_time_step(0.5)


def run(steps):
    for _ in range(steps):
        O.step()


def largest_stress(body):
    """Largest von Mises stress in a grain [Pa]."""
    return sg.von_mises(body.shape.points()["cauchy"]).max()


def present_state():
    """All that a run goes on from, as arrays by name."""
    grains = sg.soft_bodies()
    energy = sg.integrator().energy() if O.trackEnergy else {}
    return {
        "nodes": np.concatenate([b.shape.nodes() for b in grains]),
        "velocities": np.concatenate([b.shape.nodeVelocities() for b in grains]),
        "bodies": np.array([[*b.state.pos, *b.state.vel, *b.state.angVel] for b in O.bodies]),
        "orientations": np.array(
            [[q[k] for k in range(4)] for q in (b.state.ori for b in O.bodies)]
        ),
        "energies": np.array([energy[name] for name in sorted(energy)]),
        "time": np.array([O.time, O.dt, O.iter]),
    }


def assert_same_bits(found, expected):
    assert set(found) == set(expected)
    for name in expected:
        np.testing.assert_array_equal(found[name], expected[name], err_msg=name)


def assert_goes_on_after_loading(path, steps):
    """Save the scene, run, load it and run again: the same bits."""
    O.save(str(path))
    run(steps)
    expected = present_state()
    O.load(str(path))
    run(steps)
    assert_same_bits(present_state(), expected)


def assert_threads_change_nothing(make_scene, steps, numbers=(1, 2)):
    """The same bits with every one of the numbers of threads, the scene made anew for each."""
    states = []
    for threads in numbers:
        O.reset()
        make_scene()
        sg.integrator().ompThreads = threads
        run(steps)
        states.append(present_state())
    for state in states[1:]:
        assert_same_bits(state, states[0])


def complaint():
    """What the next step says when it refuses the scene."""
    with pytest.raises(RuntimeError) as error:
        O.step()
    return str(error.value)


def message_of_step(steps=1):
    """What O.step says where SoftGrainIntegrator refuses it; the same must stand in lastError."""
    with pytest.raises(RuntimeError) as caught:
        run(steps)
    message = str(caught.value)
    assert sg.integrator().lastError == message
    assert message.startswith(f"SoftGrainIntegrator, step {O.iter}: ")
    return message


def run_python(code, folder, environment=None, command=None):
    """Run code in a new Python (or by another command, to which the file is added) in a folder."""
    script = folder / "script.py"
    script.write_text(textwrap.dedent(code))
    return subprocess.run(
        [*(command or [sys.executable]), str(script)],
        cwd=folder,
        env=environment or dict(os.environ),
        capture_output=True,
        text=True,
        timeout=120,
    )


def assert_done(process):
    """The process ended well and said so as its last word."""
    told = process.stdout + process.stderr
    assert process.returncode == 0, told
    assert "done" in process.stdout, told
