"""Restitution of rigid bodies in contact dynamics."""

import math

import numpy as np
import pytest
from motion import kinetic_energy, momenta
from rigid_scenes import GRAVITY, R, add_sphere, pile, spheres, start
from scenes import add_wall, run
from yade import FrictMat, MatchMaker, O, utils

import softgrain as sg


def law():
    return O.engines[2].lawDispatcher.functors[1]


@pytest.mark.parametrize("restitution", (0.3, 0.8, 1))
@pytest.mark.parametrize("kind", ("box", "wall", "facet"))
def test_bouncing_ball(kind, restitution):
    """Each time it rises to e^2 of the height; the step decides where in it the ball turns."""
    floor = {
        "box": lambda: utils.box((0, 0, -1), (3, 3, 1), fixed=True, material=FrictMat()),
        "wall": lambda: utils.wall(0, axis=2, material=FrictMat()),
        "facet": lambda: utils.facet(
            [(-30, -10, 0), (30, -10, 0), (0, 30, 0)], material=FrictMat()
        ),
    }[kind]()
    O.bodies.append(floor)
    height, dt = 20 * R, 1e-4
    ball = add_sphere((0, 0, height + R))
    start(dt, interface={"restitution": restitution})
    tops, rising, gap = [], False, height
    while len(tops) < 3 and O.time < 3:
        O.step()
        was_rising, rising = rising, ball.state.vel[2] > 0
        gap = ball.state.pos[2] - R
        assert gap > -1e-12
        if was_rising and not rising:
            tops.append(gap)
    speed = math.sqrt(2 * GRAVITY * height)
    for bounce, top in enumerate(tops, 1):
        expected = height * restitution ** (2 * bounce)
        # each bounce is up to a step late, and its top is seen at a step
        later = 2 * bounce * dt * speed * restitution**bounce
        assert top == pytest.approx(expected, abs=later + (bounce * dt) ** 2 * GRAVITY)
    assert len(tops) == 3


@pytest.mark.parametrize("restitution", (0, 0.4, 1))
def test_head_on(restitution):
    """Newton's law, to rounding."""
    first = add_sphere((-1.2 * R, 0, 0), velocity=(1, 0, 0))
    second = add_sphere((1.2 * R, 0, 0), 0.7 * R, velocity=(-0.5, 0, 0))
    start(1e-4, (0, 0, 0), interface={"restitution": restitution})
    run(200)
    m, n = first.state.mass, second.state.mass
    common = (m * 1 - n * 0.5) / (m + n)
    assert first.state.vel[0] == pytest.approx(
        common - restitution * n / (m + n) * 1.5, rel=1e-12, abs=1e-12
    )
    assert second.state.vel[0] == pytest.approx(
        common + restitution * m / (m + n) * 1.5, rel=1e-12, abs=1e-12
    )


@pytest.mark.parametrize("friction", (0, 0.2, 2))
@pytest.mark.parametrize("restitution", (0.4, 1))
def test_oblique(restitution, friction):
    """Normal speed times e, momenta kept, energy lost by friction and (1 - e^2) alone."""
    first = add_sphere((-1.2 * R, 0, 0), friction=friction, velocity=(1, 0.2, 0.1))
    second = add_sphere((1.2 * R, 0.9 * R, 0.3 * R), 0.7 * R, friction, velocity=(-1, 0, 0.3))
    first.state.angVel = (3, -2, 5)
    O.trackEnergy = True
    start(1e-4, (0, 0, 0), interface={"restitution": restitution})
    run(1)
    before, energy = momenta(), kinetic_energy()
    relative = np.array(second.state.vel - first.state.vel)
    run(200)
    for old, new in zip(before, momenta()):
        assert new == pytest.approx(old, rel=1e-11, abs=1e-14)
    change = np.array(second.state.vel - first.state.vel) - relative
    lost = sg.integrator().energy()
    assert kinetic_energy() <= energy * (1 + 1e-12)
    assert energy - kinetic_energy() == pytest.approx(
        lost["rigidImpact"] + lost["rigidFriction"], rel=1e-9, abs=1e-12 * energy
    )
    if friction == 0:
        normal = change / np.linalg.norm(change)  # the impulse has no other part
        assert change @ normal == pytest.approx(-(1 + restitution) * relative @ normal, rel=1e-12)
        masses = first.state.mass, second.state.mass
        share = 0.5 * np.prod(masses) / sum(masses) * (relative @ normal) ** 2
        assert lost["rigidImpact"] == pytest.approx(
            (1 - restitution**2) * share, rel=1e-9, abs=1e-12 * energy
        )
    else:
        assert lost["rigidFriction"] > 1e-3 * energy
        assert lost["rigidImpact"] > -1e-12 * energy


@pytest.mark.parametrize("dim", (2, 3))
@pytest.mark.parametrize("restitution", (0.5, 0.9))
def test_pile_comes_to_rest(dim, restitution):
    """What falls into a box bounces less and less, and then lies still, but for what rolls or spins
    on the spot, which nothing stops."""
    pile(dim, interface={"restitution": restitution})
    up = dim - 1
    bounces = [max(abs(b.state.vel[up]) for b in spheres())]
    for _ in range(24):
        run(500)
        bounces.append(max(abs(b.state.vel[up]) for b in spheres()))
    assert max(bounces) > 0.02
    assert max(bounces[-3:]) < 1e-6
    assert 0.1 * sg.integrator().largestOverlap < 0.02


def test_by_pair_of_materials():
    """One of two balls bounces, and goes on to after loading."""
    bouncing = FrictMat(label="bouncing")
    floor = O.materials.append(FrictMat(label="floor"))
    O.materials.append(bouncing)
    add_wall(0, axis=2, material=floor)
    for x, material in ((0, "bouncing"), (5 * R, "floor")):
        O.bodies.append(utils.sphere((x, 0, 2 * R), R, material=material))
    match = MatchMaker(matches=((floor, bouncing.id, 0.6),), algo="zero")
    start(1e-4, interface={"restitution": match})
    O.saveTmp()
    speeds = []
    for _ in range(2):
        run(600)
        O.run(1, True)
        speeds.append([b.state.vel[2] for b in spheres()])
        O.loadTmp()
    impact = math.sqrt(2 * GRAVITY * R)
    sinks = GRAVITY * (601e-4 - impact / GRAVITY)
    assert speeds[0] == speeds[1]
    assert speeds[0][0] == pytest.approx(0.6 * impact - sinks, abs=0.01 * impact)
    assert abs(speeds[0][1]) < 1e-12


@pytest.mark.parametrize("value", (-0.1, 1.5, math.nan))
def test_refused(value):
    add_wall(0, 2)
    add_sphere((0, 0, R))
    match = MatchMaker(algo="val", val=0.5)
    start(1e-4, interface={"restitution": match})
    match.val = value  # sg.engines has looked at it
    with pytest.raises(
        RuntimeError, match=r"#0 and #1.*restitution = .* outside the admissible range \[0, 1\]"
    ):
        O.step()
