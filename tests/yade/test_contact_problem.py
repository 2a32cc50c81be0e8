"""The contact problem of a step: as data, solved on its own, and against Siconos.

The problems in ``tests/data/contact_problems`` were made by ``scripts/siconos/make_problems.py``
and solved by Siconos' NSGS through ``scripts/siconos/compare.py --store``.
"""

from pathlib import Path

import numpy as np
import pytest

import softgrain as sg
from partner_scenes import add_rigid_disk
from scenes import RADIUS, add_disk, add_wall, ready, run, soft_material
from softgrain.reference import residual
from yade import FrictMat, O

FILES = sorted((Path(__file__).resolve().parents[1] / "data" / "contact_problems").glob("*.npz"))
#: Problems with more than one solution in impulses; velocities are unique in all of them.
HYPERSTATIC = ("redundant", "wedged")


def load(file):
    with np.load(file) as arrays:
        return dict(arrays)


def dense(problem):
    """W [1/kg], shape (contacts, contacts)."""
    n = len(problem["bias"])
    W = np.zeros((n, n))
    rows = np.repeat(np.arange(n), np.diff(problem["delassus_offset"]))
    np.add.at(W, (rows, problem["delassus_column"]), problem["delassus_value"])
    return W


def residual_of(problem, impulse):
    """By the oracle."""
    keys = ("free_velocity", "normal", "bias", "friction")
    return residual(dense(problem), *(problem[key] for key in keys), impulse)


def check_conditions(problem, impulse, tolerance):
    """Signorini's and Coulomb's conditions at each contact; returns which states occur."""
    u = problem["free_velocity"] + dense(problem) @ impulse
    n, mu = problem["normal"], problem["friction"]
    u_n, r_n = np.sum(u * n, axis=1) + problem["bias"], np.sum(impulse * n, axis=1)
    u_t, r_t = u - np.sum(u * n, axis=1)[:, None] * n, impulse - r_n[:, None] * n
    slip, pull = np.linalg.norm(u_t, axis=1), np.linalg.norm(r_t, axis=1)
    assert u_n.min() > -tolerance
    assert r_n.min() >= 0
    assert np.abs(u_n * r_n).max() < tolerance
    assert (pull <= mu * r_n + tolerance).all()
    slides = (slip > 1e-6) & (r_n > 1e-6)
    assert np.abs(pull - mu * r_n)[slides].max(initial=0) < tolerance
    assert np.abs(np.sum(u_t * r_t, axis=1) + slip * pull)[slides].max(initial=0) < tolerance
    return {
        "open": (r_n == 0).any(),
        "slip": slides.any(),
        "stick": ((r_n > 1e-6) & (slip < 1e-9)).any(),
    }


def squeezed_scene(steps):
    """A disk between a floor and a lid that comes down, and another beside it; on grids so coarse
    that their contacts feel each other."""
    add_disk((0, 0, 0), nodeSpacing=2)
    add_disk((0.0195, 0.002, 0), nodeSpacing=2)
    add_wall(-0.0099, axis=1, friction=0.5)
    add_wall(0.0125, axis=1, friction=0.5, velocity=(0.5, -1, 0))
    ready()
    run(steps)


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_siconos_finds_the_same(file):
    """Impulses where they are unique; velocities and energy everywhere."""
    problem = load(file)
    answer = sg.solve_contact_problem(problem, tolerance=1e-12)
    assert answer["converged"] and answer["residual"] <= 1e-12
    ours, theirs = answer["impulse"], problem["siconos_impulse"]
    assert residual_of(problem, ours) < 2e-12
    assert residual_of(problem, theirs) < 1e-9

    W, free = dense(problem), problem["free_velocity"]
    scale = np.abs(free + problem["bias"][:, None] * problem["normal"]).max()
    np.testing.assert_allclose(W @ ours, W @ theirs, atol=1e-8 * scale)
    energies = [np.sum(r * (W @ r)) for r in (ours, theirs)]
    np.testing.assert_allclose(*energies, rtol=1e-8)
    if not file.stem.startswith(HYPERSTATIC):
        np.testing.assert_allclose(ours, theirs, atol=1e-7 * np.abs(theirs).max())


def test_stored_problems_show_everything():
    """Open, sticking, sliding and redundant contacts; friction up to 10; both dimensions."""
    seen, dims, friction, singular = set(), set(), 0, False
    for file in FILES:
        problem = load(file)
        states = check_conditions(problem, problem["siconos_impulse"], 1e-8)
        seen |= {state for state, occurs in states.items() if occurs}
        dims.add(problem["normal"].shape[1])
        friction = max(friction, problem["friction"].max())
        W = dense(problem)
        singular |= np.linalg.matrix_rank(W) < len(W)
    assert seen == {"open", "stick", "slip"}
    assert dims == {2, 3}
    assert friction > 5
    assert singular


def test_problem_of_a_step():
    """What the integrator hands out is what it solved."""
    squeezed_scene(150)
    engine = sg.integrator()
    problem = engine.contactProblem()
    assert len(problem["bias"]) == engine.contacts > 10
    assert np.any(problem["impulse"], axis=1).sum() == engine.activeContacts > 5
    W = dense(problem)
    np.testing.assert_allclose(W, W.T, rtol=1e-12)
    assert np.linalg.eigvalsh(W).min() > -1e-12 * np.linalg.eigvalsh(W).max()
    assert residual_of(problem, problem["impulse"]) == pytest.approx(engine.residual, rel=1e-6)
    assert engine.residual <= engine.tolerance

    exact = sg.solve_contact_problem(problem)
    assert exact["converged"]
    change = W @ (exact["impulse"] - problem["impulse"])
    assert 0 < np.linalg.norm(change) < 0.1 * np.linalg.norm(problem["free_velocity"])

    # where nothing follows the compulsory sweeps it is solved by the same ones
    engine.tolerance = 1.0
    run(1)
    problem = engine.contactProblem()
    again = sg.solve_contact_problem(problem, engine.tolerance, engine.maxSweeps)
    assert again["sweeps"] == engine.sweeps == 4
    np.testing.assert_allclose(
        again["impulse"], problem["impulse"], atol=1e-9 * np.abs(problem["impulse"]).max()
    )


def test_problem_outlives_the_scene_it_was_taken_from(tmp_path):
    """Erased bodies do not matter, and files keep everything."""
    squeezed_scene(30)
    before = sg.integrator().contactProblem()
    O.bodies.erase(1)
    after = sg.integrator().contactProblem()
    np.savez(tmp_path / "problem.npz", **after)
    read = load(tmp_path / "problem.npz")
    assert set(read) == set(before)
    for name, array in before.items():
        np.testing.assert_array_equal(read[name], array)


def test_problem_beside_rigid_bodies_that_are_held():
    """They touch each other, and no impulse moves them."""
    for x in (0, 1.99 * RADIUS):
        add_rigid_disk((x, 5 * RADIUS, 0), RADIUS, fixed=True)
    add_disk((0, 3.001 * RADIUS, 0)).state.vel = (0, 1, 0)
    ready(rigid="nonsmooth")
    run(30)
    assert O.interactions.has(0, 1) and sg.integrator().activeContacts > 0
    problem = sg.integrator().contactProblem()
    assert len(problem["bias"]) == sg.integrator().contacts - 1 > 0
    assert residual_of(problem, problem["impulse"]) == pytest.approx(
        sg.integrator().residual, rel=1e-6
    )


def test_no_problem_before_the_first_step():
    add_disk()
    ready()
    assert all(len(array) <= 1 for array in sg.integrator().contactProblem().values())


def test_residual_and_cap_are_reported():
    """Every step has its residual; steps that hit the cap are counted."""
    squeezed_scene(70)
    engine = sg.integrator()
    assert engine.cappedSteps == 0
    assert 0 < engine.largestResidual <= engine.tolerance
    engine.tolerance, engine.maxSweeps = 1e-11, 2
    residuals = []
    for _ in range(10):
        run(1)
        assert engine.sweeps == 2
        residuals.append(engine.residual)
    assert engine.cappedSteps == 10
    assert min(residuals) > 1e-9
    assert engine.largestResidual == max(residuals)
    engine.maxSweeps = 100_000
    run(1)
    assert engine.residual <= 1e-11
    assert engine.sweeps > 4  # of every step
    assert engine.cappedSteps == 10


def cubes_in_a_closing_box():
    """Eight soft cubes side by side, of few nodes, whose contacts share background nodes."""
    rough = FrictMat(frictionAngle=0.3)
    side = 2 * RADIUS
    for place in np.ndindex(2, 2, 2):
        centre = (np.array(place) + 0.5) * side
        cube = sg.soft_block(tuple(centre), (side,) * 3, soft_material(frictionAngle=0.3), zeta=0.5)
        O.bodies.append(cube)
    for axis in range(3):
        for end, sense in ((0, 1), (2 * side, -1)):
            add_wall(end, axis, sense=sense, material=rough)
    O.bodies[-3].state.vel = (0.05, -0.3, 0)  # the one on top
    ready()
    run(40)


@pytest.mark.parametrize("max_sweeps", (20, 100))
def test_strict_tolerance_out_of_reach_is_no_worse_than_sweeps(max_sweeps):
    """Where pairs feel each other to solve them one by one may not help: that must not be at the
    cost of sweeps over all."""
    cubes_in_a_closing_box()
    engine = sg.integrator()
    engine.tolerance, engine.maxSweeps = 1e-6, max_sweeps
    run(1)
    assert engine.cappedSteps == 1
    plain = sg.solve_contact_problem(engine.contactProblem(), 1e-6, max_sweeps)
    assert plain["sweeps"] == max_sweeps
    assert engine.residual < 1.1 * plain["residual"]


@pytest.mark.parametrize(
    "change, message",
    (
        ({"tolerance": 0}, r"tolerance = 0 .*\(0, inf\)"),
        ({"max_sweeps": 0}, "max_sweeps = 0 .*1, 2"),
        ({"friction": np.array([-1.0, 0.3])}, r"friction = -1 .*\[0, inf\)"),
        ({"friction": np.array([np.inf, 0.3])}, r"friction = inf .*finite numbers"),
        ({"friction": np.zeros(3)}, r"friction has the shape \(3,\)"),
        ({"bias": np.array([np.nan, 0.0])}, "bias = nan .*finite"),
        ({"normal": np.array([[0, 1.0], [0, 2.0]])}, "length of normal = 2 .* 1"),
        ({"normal": np.zeros(4)}, "normal has the shape"),
        ({"normal": np.zeros((2, 4))}, "normal has the shape .*2 or 3"),
        ({"free_velocity": np.zeros((3, 2))}, r"free_velocity has the shape \(3, 2\)"),
        ({"delassus_value": np.array([0.0, 1.0])}, r"diagonal entry of delassus = 0 .*\(0, inf\)"),
        ({"delassus_column": np.array([0, 2])}, r"delassus_column = 2 .*\[0, contacts\)"),
        ({"delassus_offset": np.array([0, 2])}, "rows of delassus = 1 .*one row a contact"),
        ({"delassus_offset": np.array([0, 1, 3])}, "last of delassus_offset = 3 .*offsets"),
    ),
)
def test_bad_problems_are_refused(change, message):
    problem = {
        "normal": np.array([[0.0, 1.0], [1.0, 0.0]]),
        "free_velocity": -np.ones((2, 2)),
        "bias": np.zeros(2),
        "friction": np.array([0.3, 0.3]),
        "delassus_offset": np.array([0, 1, 2]),
        "delassus_column": np.array([0, 1]),
        "delassus_value": np.ones(2),
        "start": np.zeros((2, 2)),
    }
    assert sg.solve_contact_problem(problem)["converged"]
    settings = {key: change[key] for key in ("tolerance", "max_sweeps") if key in change}
    with pytest.raises(ValueError, match=message):
        sg.solve_contact_problem({**problem, **change}, **settings)
    with pytest.raises(ValueError, match=r"problem lacks \['free_velocity', 'start', 'bias', "):
        sg.solve_contact_problem({"normal": problem["normal"]})


@pytest.mark.parametrize(
    "name, change, message",
    [
        ("free_velocity", lambda a: a.T, "free_velocity has the shape"),
        ("bias", lambda a: a[1:], "bias has the shape"),
        ("normal", lambda a: a.ravel(), "normal has the shape"),
        ("delassus_column", lambda a: a + 0.5, "delassus_column .*float64; admissible: integers"),
        ("delassus_column", lambda a: a.astype("i8") + 2**32, "delassus_column .*beyond"),
    ],
)
def test_arrays_that_do_not_fit(name, change, message):
    problem = load(FILES[0])
    problem[name] = change(problem[name])
    with pytest.raises(ValueError, match=message):
        sg.solve_contact_problem(problem)


def test_contact_problem_after_bodies_are_gone():
    """It stands on its own."""
    add_disk()
    held = add_rigid_disk((0, -1.99 * RADIUS, 0), RADIUS, fixed=True)
    other = add_disk((0, 1.99 * RADIUS, 0))
    ready()
    run(2)
    before = sg.integrator().contactProblem()
    assert len(before["bias"]) > 1
    O.bodies.erase(held.id)
    O.bodies.erase(other.id)
    after = sg.integrator().contactProblem()
    for key, value in before.items():
        np.testing.assert_array_equal(after[key], value)
