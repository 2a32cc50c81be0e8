"""Small scenes and subprocesses common to the tests inside YADE."""

import ctypes
import os
import subprocess
import sys
import textwrap
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from bodies import DENSITY, YOUNG, add, add_wall, facet_strip  # noqa: F401, for the tests

import softgrain as sg
from yade import O

RADIUS = 0.01  # m
WIDE = 20 * RADIUS  # half the width of facets across the plane of 2D grains, m
ZETA = 0.25  # coarse: accuracy is not the point
YADE = "/usr/bin/yade"
TESTS = Path(__file__).resolve().parents[1]


def soft_material(**attributes):
    return sg.SoftMat(**{"young": YOUNG, "poisson": 0.45, "density": DENSITY, **attributes})


def damped_material():
    return soft_material(massDamping=300, frictionAngle=0.3)


def add_disk(center=(0, 0, 0), radius=RADIUS, material=None, **shape):
    """A soft disk in the scene; returns its body."""
    shape = {"zeta": ZETA, **shape}
    return add(sg.soft_disk(center, radius, material or soft_material(), **shape))


def points_of(body):
    """Number of the material points of a soft grain."""
    return len(body.shape.points()["volume"])


def add_facets(start, end, material):
    """Two, that cut the plane of 2D grains in the way from `start` to `end` (over R)."""
    ends = [(x * RADIUS, y * RADIUS, 0) for x, y in (start, end)]
    O.bodies.append(facet_strip(ends, (0, 0, WIDE), material))


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


@contextmanager
def threads_at_hand(number):
    """For scenes made within; scripts/test leaves one to each process, and more are not used then,
    whatever an engine asks for."""
    openmp = ctypes.CDLL("libgomp.so.1")
    before = openmp.omp_get_max_threads()
    openmp.omp_set_num_threads(number)
    try:
        yield
    finally:
        openmp.omp_set_num_threads(before)


def assert_threads_change_nothing(make_scene, steps, numbers=(1, 2), read=present_state):
    """The same bits with every one of the numbers of threads, the scene made anew for each."""
    states = []
    with threads_at_hand(max(numbers)):
        for threads in numbers:
            O.reset()
            make_scene()
            sg.integrator().ompThreads = threads
            run(steps)
            states.append(read())
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
    """Run code in a new Python (or by another command, to which the file is added) in a folder,
    where it finds what these tests import; `environment` is what differs from that of the tests."""
    script = folder / "script.py"
    script.write_text(textwrap.dedent(code))
    paths = [str(TESTS / "yade"), str(TESTS / "shared"), os.environ.get("PYTHONPATH", "")]
    return subprocess.run(
        [*(command or [sys.executable]), str(script)],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(paths), **(environment or {})},
        capture_output=True,
        text=True,
        timeout=120,
    )


def assert_done(process):
    """The process ended well and said so as its last word."""
    told = process.stdout + process.stderr
    assert process.returncode == 0, told
    assert "done" in process.stdout, told
