"""Energies of rigid bodies in contact dynamics."""

import numpy as np
import pytest
from motion import kinetic_energy
from rigid_scenes import R, add_incline, add_sphere, material, pile, run_until, start
from scenes import add_disk, add_wall, ready, run, soft_material
from yade import O

import softgrain as sg


def balance():
    """What stays constant [J], and the energies."""
    e = sg.integrator().energy()
    lost = e["rigidFriction"] + e["rigidImpact"]
    return e["rigidKinetic"] + lost - e["rigidWalls"] - e["rigidCell"] - e["rigidLoads"], e


@pytest.mark.parametrize("restitution", (0, 0.6))
@pytest.mark.parametrize("offset", (0, 0.8 * R))
def test_impact(offset, restitution):
    """Head on: what the centres lose of their motion; obliquely friction takes its share."""
    first = add_sphere((-1.2 * R, 0, 0), velocity=(1, 0, 0))
    second = add_sphere((1.2 * R, offset, 0), 0.7 * R, velocity=(-1, 0, 0))
    O.trackEnergy = True
    start(1e-4, (0, 0, 0), interface={"restitution": restitution})
    run(1)
    before = balance()[0]
    assert before == pytest.approx(kinetic_energy(), rel=1e-12)
    run(200)
    after, energy = balance()
    assert after == pytest.approx(before, rel=1e-12)
    assert energy["rigidKinetic"] == pytest.approx(kinetic_energy(), rel=1e-12)
    assert O.energy["rigidImpact"] == energy["rigidImpact"] > 0.1 * before
    assert O.energy.total() == pytest.approx(before, rel=1e-12)  # with YADE's kinetic energy
    if offset == 0:
        masses = first.state.mass, second.state.mass
        lost = (1 - restitution**2) * 0.5 * np.prod(masses) / sum(masses) * 2**2
        assert energy["rigidImpact"] == pytest.approx(lost, rel=1e-12)
        assert energy["rigidFriction"] == pytest.approx(0, abs=1e-15)
    else:
        assert energy["rigidFriction"] > 0.01 * before


def test_sliding_to_rest():
    """All it had goes into friction."""
    add_wall(0, 2, friction=0.5)
    block = add_sphere((0, 0, R), friction=0.5, velocity=(1, 0, 0), blocked="XYZ")
    O.trackEnergy = True
    start(5e-4)
    run_until(0.3)
    energy = balance()[1]
    at_start = 0.5 * block.state.mass
    assert block.state.vel.norm() < 1e-12
    assert energy["rigidFriction"] == pytest.approx(at_start, rel=1e-9)
    assert energy["rigidImpact"] == pytest.approx(0, abs=1e-9 * at_start)


def test_sliding_down_an_incline():
    """Gravity gives what motion and friction take."""
    gravity = add_incline(35)
    block = add_sphere((0, 0, R), friction=0.5, blocked="XYZ")
    O.trackEnergy = True
    start(5e-4, gravity)
    run(1)
    before = balance()[0]
    run(400)
    after, energy = balance()
    fell = gravity[0] * block.state.mass * block.state.pos[0]
    assert after == pytest.approx(before, abs=1e-12 * fell)
    assert energy["rigidLoads"] == pytest.approx(fell, rel=0.01)  # within a step
    assert energy["rigidFriction"] == pytest.approx(
        -0.5 * gravity[2] / gravity[0] * energy["rigidLoads"], rel=1e-3
    )


@pytest.mark.parametrize("restitution", (0, 0.6))
def test_moving_wall_and_many_contacts(restitution):
    """A wall is moved into a pile; bodies that fly count from the start. After loading the run goes
    on with what was summed."""
    pile(columns=3, layers=2, interface={"restitution": restitution})
    O.trackEnergy = True
    run(1)
    before = balance()[0]
    run(400)
    O.bodies[0].state.vel = (0.1, 0, 0)
    run(200)
    O.saveTmp("moving")
    energies = []
    for _ in range(2):
        run(200)
        after, energy = balance()
        scale = energy["rigidLoads"]
        assert energy["rigidWalls"] > 0.001 * scale > 0
        assert energy["rigidFriction"] > 0.01 * scale
        assert after == pytest.approx(before, abs=1e-9 * scale)
        energies.append(energy)
        O.loadTmp("moving")
    assert energies[0] == energies[1]


def test_only_where_energies_are_tracked():
    add_wall(0, 2)
    add_sphere((0, 0, R))
    start(5e-4)
    run(10)
    assert "rigidFriction" not in dict(O.energy.items())
    with pytest.raises(RuntimeError, match="O.trackEnergy = False"):
        sg.integrator().energy()


def test_sums_go_on_as_kinds_of_bodies_change():
    """The first soft grain comes and the last one goes: what was lost stays lost."""
    add_sphere((-1.2 * R, 0, 0), velocity=(1, 0, 0))
    add_sphere((1.2 * R, 0, 0), velocity=(-1, 0, 0))
    far = add_sphere((30 * R, 0, 0))
    O.trackEnergy = True
    start(1e-5, (0, 0, 0), interface={"restitution": 0.5})
    run(1)
    while sg.integrator().energy()["rigidImpact"] == 0:
        run(1)
    run(10)
    before = sg.integrator().energy()["rigidImpact"]
    sg.soften([far.id], material=soft_material(), dim=3, zeta=0.5)
    steps = sg.integrator().steps
    run(5)
    assert sg.integrator().energy()["rigidImpact"] == before
    sg.harden([far.id], material=material())
    run(5)
    assert sg.integrator().energy()["rigidImpact"] == before
    assert sg.integrator().steps == steps + 10


@pytest.mark.parametrize("steps", ([(1e-3, 5), (1e-6, 20)], [(1e-6, 20), (1e-3, 5)]))
def test_tracking_changes_no_flight(steps):
    """Neither where O.dt changes; and the balance knows how the bodies flew."""
    velocities = []
    for track in (False, True):
        O.reset()
        body = add_sphere((0, 0, 50 * R))
        add_sphere((0, 0, 0), blocked="xyzXYZ")
        O.trackEnergy = track
        start(steps[0][0])
        run(1)
        before = balance()[0] if track else 0
        for dt, count in steps:
            O.dt = dt
            run(count)
        if track:
            assert balance()[0] == pytest.approx(before, abs=1e-12 * balance()[1]["rigidLoads"])
        velocities.append(body.state.vel[2])
    assert velocities[0] == velocities[1] < 0


def test_bodies_that_are_damped_fly_beside_a_balance():
    """They touch nothing: NewtonIntegrator may damp them, and the balance leaves them out."""
    O.trackEnergy = True
    add_wall(0, 2)
    add_sphere((0, 0, 5 * R))
    resting = add_sphere((9 * R, 0, R))
    resting.state.isDamped = False
    start(1e-4)
    O.engines[-1].damping = 0.2
    run(20)
    assert sg.integrator().energy()["rigidKinetic"] == 0


def test_energies_come_back_after_o_energy_was_cleared():
    disk = add_disk()
    disk.state.vel = (1, 0, 0)
    O.trackEnergy = True
    ready()
    run(2)
    O.energy.clear()
    run(2)
    assert O.energy["softKinetic"] == pytest.approx(0.5 * disk.state.mass)
