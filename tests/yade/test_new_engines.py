"""O.engines assigned anew: what they find of bodies and of the time step; rigid bodies that touch,
from contact dynamics to it, to laws with stiffness and back."""

import math

import pytest
import yade
from periodic_scenes import flow, set_cell
from rigid_scenes import GRAVITY, R, add_sphere, start
from scenes import RADIUS, add_disk, add_wall, ready, run
from yade import (
    Bo1_Sphere_Aabb,
    Bo1_Wall_Aabb,
    ForceResetter,
    Ig2_Sphere_Sphere_ScGeom,
    Ig2_Sphere_Sphere_ScGeom6D,
    Ig2_Wall_Sphere_ScGeom,
    InsertionSortCollider,
    InteractionLoop,
    Ip2_FrictMat_FrictMat_FrictPhys,
    Law2_ScGeom_FrictPhys_CundallStrack,
    NewtonIntegrator,
    O,
    utils,
)

import softgrain as sg


def test_all_bodies_are_found_after_one_was_erased():
    """YADE's own new collider knows none of them then."""
    floor = add_wall(0, 1)
    grain = add_disk((0, 1.5 * RADIUS, 0))
    other = add_disk((9 * RADIUS, 9 * RADIUS, 0))
    gravity = (0, -500, 0)
    O.engines = sg.engines(gravity=gravity)
    run(5)
    O.bodies.erase(other.id)
    run(50)
    O.engines = sg.engines(gravity=gravity)
    run(1500)
    assert grain.state.pos[1] > 0.8 * RADIUS
    assert O.bodies[floor.id].intrs()


#: What an integrator adds up over a run.
SUMS = (
    "steps",
    "totalSweeps",
    "totalGrainSteps",
    "pointsUpdated",
    "pointsMeasured",
    "pairsSearched",
    "candidatesTested",
    "contactsSwept",
    "cappedSteps",
    "droppedMomentum",
    "droppedEnergy",
    "lostBonds",
)


@pytest.mark.parametrize("tracks", (False, True))
def test_engines_used_again_in_another_scene(tracks):
    """After O.reset() they begin like new ones."""
    found = []
    for engines in (None, "those of the scene before"):
        if engines:
            engines = O.engines
            O.reset()
        disk = add_disk((0, 1.001 * RADIUS, 0))
        add_wall(0, axis=1)
        O.trackEnergy = tracks
        ready(gravity=(0, -500, 0))
        if engines:
            O.engines = engines
        O.dt = 2e-5
        run(200)
        found.append((*disk.state.pos, *disk.state.vel))
        found[-1] += tuple(getattr(sg.integrator(), name) for name in SUMS)
        if tracks:
            found[-1] += tuple(sg.integrator().energy().values())
    assert found[0] == found[1]


def test_the_collider_keeps_its_way_when_grains_of_a_cell_are_erased():
    """On the other one it may never end."""
    O.periodic = True
    O.cell.setBox(99 * RADIUS, 99 * RADIUS, 99 * RADIUS)
    add_disk()
    other = add_disk((9 * RADIUS, 0, 0))
    O.engines = sg.engines()
    run(1)
    O.bodies.erase(other.id)
    assert not O.bodies.useRedirection


def test_the_collider_comes_back_to_its_way():
    """Bodies were erased before there were engines, as by sg.soften, which erases clumps."""
    O.periodic = True
    O.cell.setBox(9 * RADIUS, 9 * RADIUS, 9 * RADIUS)
    other = add_disk((7 * RADIUS, 0, 0))
    disks = [add_disk((0.01 * RADIUS, 0, 0)), add_disk((2.02 * RADIUS, 0, 0))]
    O.bodies.erase(other.id)
    assert O.bodies.useRedirection
    ready()
    assert not O.bodies.useRedirection
    disks[0].state.vel = (5, 0, 0)
    while O.time < 0.03 * RADIUS:
        run(1)
    assert sg.integrator().contacts > 0 and disks[1].state.vel[0] > 0.1
    O.bodies.erase(disks[1].id)
    run(20)
    assert not O.bodies.useRedirection


@pytest.mark.parametrize("by_hand", [False, True])
def test_time_step_goes_on_following(by_hand):
    """Whether set_time_step chose it or the integrator itself."""
    add_wall(-RADIUS, 1)
    top = add_wall(RADIUS, 1)
    add_disk()
    O.engines = sg.engines()
    if by_hand:
        sg.set_time_step(0.8)
    top.state.vel = (0, -5, 0)
    run(100)
    O.engines = sg.engines(tolerance=1e-3)
    before = O.dt
    run(150)
    assert sg.integrator().timeStepFraction == (0.8 if by_hand else 0.85)
    assert O.dt < before  # or it would have been refused by now


def test_contacts_go_on_under_new_engines():
    """Although YADE's interactions keep the object of the law that they began with."""
    floor, ball = add_wall(0, 2, friction=0.3), add_sphere((0, 0, R))
    weight = GRAVITY * ball.state.mass
    for _ in range(3):
        start(1e-4)
        run(200)
        assert abs(ball.state.pos[2] - R) < 1e-12
        assert O.forces.f(floor.id)[2] == pytest.approx(-weight, rel=1e-9)
    run(1)
    O.engines = sg.engines(rigid="nonsmooth", gravity=(0, 0, -GRAVITY))
    run(1)  # no step without contact
    assert O.forces.f(floor.id)[2] == pytest.approx(-weight, rel=1e-9)


@pytest.mark.parametrize("of_yade", (False, True))
def test_flow_of_a_cell_goes_on(of_yade):
    """Grains are not given the velocity of the flow once more, whoever gave it before."""
    set_cell(8 * RADIUS, 8 * RADIUS)
    grain = add_disk((2 * RADIUS, 4 * RADIUS, 0))
    flow(xx=-5.0)
    if of_yade:
        O.engines = [NewtonIntegrator()]
        O.dt = 1e-5
    else:
        ready()
    run(5)
    speed = grain.state.vel[0]
    ready()
    run(1)
    assert speed < -0.05
    assert grain.state.vel[0] == pytest.approx(speed, rel=1e-3)


def engines_with_stiffness(sphere=Ig2_Sphere_Sphere_ScGeom):
    """Of YADE alone."""
    return [
        ForceResetter(),
        InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Wall_Aabb()], verletDist=0.05 * R),
        InteractionLoop(
            [sphere(), Ig2_Wall_Sphere_ScGeom()],
            [Ip2_FrictMat_FrictMat_FrictPhys()],
            [Law2_ScGeom_FrictPhys_CundallStrack()],
        ),
        NewtonIntegrator(damping=0.3, gravity=(0, 0, -GRAVITY)),
    ]


@pytest.mark.parametrize("integrator", (True, False))
@pytest.mark.parametrize("sphere", (Ig2_Sphere_Sphere_ScGeom, Ig2_Sphere_Sphere_ScGeom6D))
def test_from_and_to_engines_with_stiffness(sphere, integrator):
    """Each law bears what lies there already, whatever geometry it wants."""
    floor, ball = add_wall(0, 2, friction=0.3), add_sphere((0, 0, R))
    top = add_sphere((0, 0, 3 * R))
    weight = GRAVITY * (ball.state.mass + top.state.mass)
    for _ in range(2):
        start(1e-4)
        run(200)
        assert O.forces.f(floor.id)[2] == pytest.approx(-weight, rel=1e-6)
        assert {type(i.geom) for i in O.interactions} == {yade.ScGeom}
        assert len(list(O.interactions)) == 2
        O.engines = engines_with_stiffness(sphere)
        if integrator:
            O.engines = O.engines[:-1] + [sg.SoftGrainIntegrator()] + O.engines[-1:]
        O.dt = 0.2 * utils.PWaveTimeStep()
        for body in (ball, top):
            body.state.vel = (0, 0, 0)
        run(2000)
        made = type(O.interactions[ball.id, top.id].geom).__name__
        assert sphere.__name__ == f"Ig2_Sphere_Sphere_{made}"
        assert O.forces.f(floor.id)[2] == pytest.approx(-weight, rel=1e-2)
        assert -0.01 * R < top.state.pos[2] - 3 * R < 1e-4 * R
        for body in (ball, top):
            body.state.vel = (0, 0, 0)


def test_what_is_about_to_touch_is_found_ahead_after_linear_engines():
    add_wall(0, 2, friction=0.3)
    ball = add_sphere((0, 0, 1.0001 * R))
    O.engines = engines_with_stiffness()
    O.dt = 1e-7
    run(2)
    assert len(O.interactions) == 1 and O.interactions.countReal() == 0  # near, but apart
    start(1e-4)
    run(2)
    assert O.interactions.countReal() == 1 and ball.state.pos[2] > R


@pytest.mark.parametrize("tracks", (False, True))
def test_engines_of_rigid_bodies_used_again_in_another_scene(tracks):
    """Impulses of the first step act for that step, not for the last one of the scene before."""

    def slide(dt, steps, engines=None):
        """Of a ball on a floor."""
        O.trackEnergy = tracks
        add_wall(0, 2, friction=0.3)
        ball = add_sphere((0, 0, R), velocity=(1, 0, 0))
        start(dt)
        if engines:
            O.engines = engines
            assert math.isnan(sg.unbalanced_force())
            assert not tracks or not any(sg.integrator().energy().values())
        run(steps)
        energies = sg.integrator().energy() if tracks else {}
        return tuple(ball.state.vel), tuple(ball.state.angVel), energies

    slide(1e-3, 200)
    engines = O.engines
    O.reset()
    found = slide(1e-5, 1, engines)
    O.reset()
    assert found == slide(1e-5, 1)


def test_energies_of_rigid_bodies_do_not_outlive_their_scene():
    O.trackEnergy = True
    add_wall(0, 2, friction=0.3)
    add_sphere((0, 0, R), velocity=(1, 0, 0))
    start(1e-4)
    run(50)
    former = sg.integrator()
    assert former.energy()["rigidFriction"] > 0
    O.reset()
    O.trackEnergy = True
    add_disk()
    O.engines = [former if isinstance(e, sg.SoftGrainIntegrator) else e for e in sg.engines()]
    run(5)
    assert not [name for name in former.energy() if name.startswith("rigid")]
