"""Friction, cohesion, bonds and restitution by pair of materials."""

import gzip
import math
import re

import numpy as np
import pytest
from interface_scenes import BOND, COHESION, SIDE, add_block, damped, interaction
from motion import momentum
from partner_scenes import add_rigid_disk
from scenes import (
    RADIUS,
    add,
    add_disk,
    add_wall,
    assert_goes_on_after_loading,
    assert_threads_change_nothing,
    ready,
    run,
    soft_material,
)
from yade import FrictMat, MatchMaker, O, Quaternion, utils

import softgrain as sg


def test_friction_of_rigid_pairs():
    """The same angles as those of soft grains, by either law."""
    for rigid in ("linear", "nonsmooth"):
        O.reset()
        for x in (0, 1.99 * RADIUS):
            add_rigid_disk((x, 0, 0), RADIUS, friction=0.3)
        O.engines = sg.engines(rigid=rigid, interface={"frictAngle": 0.5})
        O.dt = 1e-6
        run(1)
        assert O.interactions[0, 1].phys.tangensOfFrictionAngle == pytest.approx(math.tan(0.5))


def test_friction_by_pair_of_materials():
    """A MatchMaker of material ids; without a match its algorithm, without one the minimum."""
    angles = (0.1, 0.2, 0.3)
    first, second, third = (damped(frictionAngle=a, label=f"m{a}") for a in angles)
    ids = [O.materials.append(m) for m in (first, second, third)]
    add_block(0, first)
    add_block(-SIDE, second)
    add_block(-2 * SIDE, third)
    match = MatchMaker(matches=((ids[0], ids[1], 0.5),), algo="max")
    ready(interface={"frictAngle": match, "dynamicFrictAngle": 0.15})
    run(2)
    found = {tuple(sorted((i.id1, i.id2))): i.phys for i in O.interactions}
    assert found[0, 1].tangensOfFrictionAngle == pytest.approx(math.tan(0.5))
    assert found[1, 2].tangensOfFrictionAngle == pytest.approx(math.tan(0.3))
    for phys in found.values():
        assert phys.interface.tangensOfDynamicFrictionAngle == pytest.approx(math.tan(0.15))


@pytest.mark.parametrize("algo", ("zero", "avg", "min", "max", "harmAvg"))
def test_pairs_without_a_match_are_as_if_not_given(algo):
    """Whatever the algorithm: nothing but the angle of friction can be computed from materials."""
    material = damped(frictionAngle=0.4)
    other = O.materials.append(damped(label="other"))
    add_block(0, material)
    add_block(-SIDE, material)
    laws = ("dynamicFrictAngle", 0.05), ("cohesion", 1e3), ("bondStrength", 1e3)
    law = {name: MatchMaker(matches=((other, other, v),), algo=algo) for name, v in laws}
    ready(interface=dict(cohesionRange=1e-4, bondEnergy=0.1, **law))
    run(2)
    assert interaction().phys.interface is None
    assert interaction().phys.tangensOfFrictionAngle == pytest.approx(math.tan(0.4))


def test_range_is_that_of_one_pair_of_materials():
    """Not the energy of one over the strength of another."""
    weak, strong = (O.materials.append(damped(label=label)) for label in "ab")
    add_block(0, O.materials[weak])
    strength = MatchMaker(matches=((weak, weak, 1e3), (strong, weak, 1e5)), algo="zero")
    energy = MatchMaker(matches=((weak, weak, 0.05), (weak, strong, 4.0)), algo="zero")
    ready(interface=dict(bondStrength=strength, bondEnergy=energy))
    assert sg.integrator().interfaceRange == pytest.approx(1e-4)
    ready(interface=dict(bondStrength=strength, bondEnergy=6.0))  # of the weak pair
    assert sg.integrator().interfaceRange == pytest.approx(1.2e-2)
    cohesion = MatchMaker(matches=((weak, weak, 2e3),), algo="val", val=0)
    within = MatchMaker(matches=((weak, weak, 1e-4),), algo="val", val=1e-2)
    ready(interface=dict(cohesion=cohesion, cohesionRange=within))
    assert sg.integrator().interfaceRange == pytest.approx(1e-4)


@pytest.mark.parametrize("later", (None, {"cohesion": 1e3, "cohesionRange": 1e-4}))
def test_old_pairs_are_searched_as_far_as_their_law_reaches(later):
    """New engines do not know it: contacts keep their laws, and the run goes on."""
    law = {"cohesion": 1e3, "cohesionRange": 2e-4}
    for y in (RADIUS, 3 * RADIUS):
        size = (2 * RADIUS, 2 * RADIUS)
        O.bodies.append(sg.soft_block((0, y, 0), size, soft_material(), zeta=0.5))
    O.engines = sg.engines(interface=law)
    run(10)
    O.engines = sg.engines(interface=later)
    run(10)
    assert sg.integrator().interfaceRange == law["cohesionRange"]
    (pair,) = [i for i in O.interactions if i.isReal]
    assert pair.phys.interface.cohesion == law["cohesion"]


def test_plain_pairs_have_no_interface():
    add_block(0, damped(frictionAngle=0.3))
    add_wall(0, 1, friction=0.1)
    ready()
    run(2)
    assert interaction().phys.interface is None
    assert interaction().phys.tangensOfFrictionAngle == pytest.approx(0.1)
    assert sg.integrator().interfaceRange == 0


@pytest.mark.parametrize("law, friction", [(COHESION, 0.3), (BOND, 0)])
def test_force_momentum_and_energy_of_two_blocks(law, friction):
    """Pulled apart by less than the interface bears, then by more. (With nothing against slip they
    would tilt and slide off each other.)"""
    material = damped(frictionAngle=friction)
    upper, lower = add_block(0, material), add_block(-SIDE, material)
    O.trackEnergy = True
    ready(interface=law)
    run(2)
    balance, force = sg.Balance(), 1.7e3 * SIDE
    for k in range(1, 3001):
        for body, sign in ((upper, 1), (lower, -1)):
            O.forces.setPermF(body.id, (0, sign * force * min(k / 500, 1), 0))
        run(1)
    # what holds one block acts on the other
    i = interaction()
    assert i.phys.normalForce.norm() == pytest.approx(force, rel=0.01)
    contacts = i.geom.contacts()
    side = (1 - 2 * contacts["side"])[:, None]
    total = (side * contacts["impulse"]).sum(axis=0) / O.dt
    np.testing.assert_allclose(abs(total[1]), force, rtol=0.01)
    assert (contacts["bond"] == (1 if "bondEnergy" in law else 0)).all()
    mean = (contacts["pressure"] * contacts["area"]).sum() / contacts["area"].sum()
    assert mean == pytest.approx(-1.7e3, rel=0.05)
    pairs = sg.pair_forces()
    assert pairs["area"] == pytest.approx([SIDE], rel=0.05)
    assert pairs["pressure"] == pytest.approx([-1.7e3], rel=0.05)
    for body, sign in ((upper, 1), (lower, -1)):
        O.forces.setPermF(body.id, (0, 1.5 * sign * force, 0))
    while any(i.isReal for i in O.interactions):
        run(1)
        assert O.iter < 9000
    assert np.linalg.norm(momentum()) < 1e-12 * upper.state.mass
    energy = sg.integrator().energy()
    work = 0.2 if "cohesion" in law else 0.1
    assert energy["cohesion"] / SIDE == pytest.approx(work, rel=0.05)
    assert balance.error() < 0.01
    assert sg.integrator().lostBonds == 0


@pytest.mark.parametrize(
    "add_other",
    (lambda: add_wall(0, 1), lambda: add_rigid_disk((0, -RADIUS, 0), RADIUS, fixed=True)),
    ids=("wall", "rigid disk"),
)
def test_cohesion_is_felt_before_touch(add_other):
    """Across its range; not beyond."""
    for gap, attracts in ((0.9e-4, True), (1.5e-4, False)):
        O.reset()
        block = add_block(gap)
        add_other()
        ready(interface=COHESION)
        run(20)
        assert (block.state.vel[1] < -1e-4) == attracts


def rigid_plate(center, half):
    material = FrictMat(frictionAngle=0.5, density=2000)
    return add(utils.box(center, half, fixed=True, material=material))


def test_bond_with_a_rigid_body():
    """A free box hangs on a soft block, which is bonded to a wall."""
    block = add_block(0)
    add_wall(SIDE, 1)
    box = rigid_plate((0, -0.5 * RADIUS, 0), (RADIUS, 0.5 * RADIUS, RADIUS))
    box.state.blockedDOFs = "zXY"
    box.state.mass, box.state.inertia = 0.2, (1e-5, 1e-5, 1e-5)
    ready(gravity=(0, -10, 0), interface=dict(bondStrength=2e4, bondEnergy=1.0))
    while O.time < 0.8:
        run(50)
    forces = {
        tuple(sorted((i.id1, i.id2))): (i.phys.normalForce + i.phys.shearForce)[1]
        for i in O.interactions
    }
    assert abs(forces[0, 2]) == pytest.approx(2, rel=0.02)
    weight = 2 + 10 * block.state.mass
    assert abs(forces[0, 1]) == pytest.approx(weight, rel=0.02)
    assert abs(box.state.vel[1]) < 1e-3


def test_bonds_on_demand():
    block = add_block(0)
    wall = add_wall(0, 1)
    ready(interface=dict(bondAtTouch=False, **BOND))
    run(2)
    geom = interaction().geom
    assert (geom.contacts()["bond"] == 0).all()
    assert geom.bond() == len(geom.contacts()["bond"]) > 3
    O.forces.setPermF(block.id, (0, 1e3 * SIDE, 0))
    run(300)
    assert block.state.pos[1] - RADIUS < 2e-5
    assert (interaction().geom.contacts()["bond"] == 1).all()
    assert O.forces.f(wall.id)[1] > 0


def bonded_disks(rows=1):
    """Disks, four in a row, that fall on one another, bond, slide and break."""
    material = damped(frictionAngle=math.atan(0.5))
    for row in range(rows):
        for k in range(4):
            y = 0.3 * (k % 2) + 2.002 * row
            add_disk((2.02 * RADIUS * k, y * RADIUS, 0), material=material)
    add_wall(-1.01 * RADIUS, 1, friction=0.5)
    law = dict(bondStrength=3e3, bondEnergy=0.3, dynamicFrictAngle=math.atan(0.3), **COHESION)
    ready(gravity=(3, -50, 0), interface=law)
    O.trackEnergy = True


def test_nothing_bonds_without_a_law_for_it(tmp_path):
    add_block(0, length=4 * SIDE)
    add_block(SIDE)
    ready(interface=COHESION)
    run(5)
    assert interaction().geom.bond() == 0
    O.save(str(tmp_path / "saved.yade.gz"))
    O.load(str(tmp_path / "saved.yade.gz"))
    with pytest.raises(RuntimeError, match="make a step before"):
        interaction().geom.bond()
    run(1)
    assert interaction().geom.bond() == 0


def test_saved_and_loaded(tmp_path):
    bonded_disks()
    run(300)
    bonds = [b for i in O.interactions if i.isReal for b in i.geom.contacts()["bond"]]
    assert {1, 2} & set(bonds)
    assert_goes_on_after_loading(tmp_path / "scene.yade.gz", 200)


def test_same_bits_for_any_number_of_threads():
    """Of so many disks that they share loops, from 32 on, and sweeps, from 16 pairs in each colour
    on."""
    assert_threads_change_nothing(lambda: bonded_disks(rows=12), 300)


def test_sleeping_pairs_keep_their_forces(tmp_path):
    """A block hangs asleep on a ceiling, also after loading, and is woken by more weight."""
    block = add_block(-SIDE, soft_material(poisson=0.3, massDamping=2000))
    add_wall(0, 1)
    ready(gravity=(0, -20, 0), interface=dict(bondStrength=2e4, bondEnergy=1.0, **COHESION))
    while not block.shape.isAsleep():
        run(20)
        assert O.iter < 30000
    weight = 20 * block.state.mass
    place = block.state.pos[1]
    run(100)
    O.save(str(tmp_path / "scene.yade.gz"))
    O.load(str(tmp_path / "scene.yade.gz"))
    run(100)
    (block,) = sg.soft_bodies()
    assert block.shape.isAsleep() and block.state.pos[1] == place
    contacts = interaction().geom.contacts()
    kick = weight / abs(contacts["impulse"][:, 1].sum())
    assert kick * O.dt == pytest.approx(1, rel=0.01)
    assert abs(interaction().phys.normalForce[1]) == pytest.approx(weight, rel=0.01)
    O.forces.setPermF(block.id, (0, -weight, 0))
    run(3000)
    assert not math.isnan(block.state.pos[1])
    assert abs(interaction().phys.normalForce[1]) == pytest.approx(2 * weight, rel=0.02)


def test_cohesion_in_3d():
    """A soft cube hangs on a wall."""
    cube = sg.soft_block((0, 0, -RADIUS), (SIDE, SIDE, SIDE), damped(), zeta=0.5)
    O.bodies.append(cube)
    wall = add_wall(0, 2)
    ready(gravity=(0, 0, -10), interface=COHESION)
    run(2000)
    assert O.forces.f(wall.id)[2] == pytest.approx(-10 * cube.state.mass, rel=0.02)
    assert abs(cube.state.pos[2] + RADIUS) < 1e-3 * RADIUS


def test_bonds_that_are_torn_in_one_step_are_counted(tmp_path):
    """Also where the interaction ends by it; the count is saved."""
    upper = add_block(0)
    add_block(-SIDE)
    ready(interface={**BOND, "bondAtTouch": True})
    run(10)
    bonds = (interaction().geom.contacts()["bond"] == 1).sum()
    assert bonds > 5 and sg.integrator().lostBonds == 0
    upper.state.pos = (0, 3 * SIDE, 0)
    run(3)
    assert not [i for i in O.interactions if i.isReal]
    assert sg.integrator().lostBonds == bonds
    O.save(str(tmp_path / "scene.yade.gz"))
    O.load(str(tmp_path / "scene.yade.gz"))
    run(1)
    assert sg.integrator().lostBonds == bonds


@pytest.mark.parametrize("turn", (0.01, 0.26, 0.6))
def test_cohesion_does_not_depend_on_how_far_is_searched(turn):
    """Of a disk and a small one, whose nodes are dense: nodes of the large one that are further off
    than the range stand for places within it."""
    forces = []
    for extra in (0, 2e-3):
        O.reset()
        for height, radius, angle in ((0, RADIUS, 0.45 * turn), (1.2 * RADIUS, 0.2 * RADIUS, turn)):
            body = sg.soft_disk((0, height, 0), radius, soft_material(young=1e8), zeta=0.25)
            body.state.ori = Quaternion((0, 0, 1), angle)
            O.bodies.append(body)
        reach = 2e-4 + extra
        law = dict(cohesion=1e3, cohesionRange=2e-4)
        ready(interface=law, interfaceRange=reach, verlet_distance=0.3 * RADIUS)
        run(1)
        forces.append(interaction().phys.normalForce.norm())
    assert forces[0] > 0.1
    assert forces[0] == pytest.approx(forces[1], rel=1e-9)


@pytest.mark.parametrize(
    "saved, what", (("Interface", "its interface was"), ("Keys", "its contacts were"))
)
def test_history_of_another_version_is_refused(saved, what, tmp_path):
    bonded_disks()
    run(3)
    path = str(tmp_path / "scene.xml.gz")
    O.save(path)
    with gzip.open(path, "rt") as file:
        text = file.read()
    numbers = r"((?:(?!</saved).)*?<count>)([1-9]\d*)(<.*?)<item>[^<]*</item>"
    pattern = rf"(<saved{saved}>){numbers}"
    cut = re.sub(pattern, lambda m: f"{m[1]}{m[2]}{int(m[3]) - 1}{m[4]}", text, flags=re.S)
    assert cut != text
    with gzip.open(path, "wt") as file:
        file.write(cut)
    O.load(path)
    with pytest.raises(RuntimeError, match=f"{what} saved with .* figures"):
        O.step()


@pytest.mark.parametrize("changed", (0, 1))
def test_bonds_stay_where_grains_change_places(changed):
    """Grains of one condition are computed together: another one changes the order of two grains,
    but not which nodes are bonded."""
    materials = [soft_material(condition=name) for name in ("planeStrain", "planeStress")]
    for k in range(2):
        add_disk((1.97 * k * RADIUS, 0, 0), material=materials[(k + changed) % 2])
    ready(interface={**BOND, "bondAtTouch": True})
    run(3)

    def bonds():
        arrays = interaction().geom.contacts()
        return sorted(map(tuple, arrays["point"][arrays["bond"] == 1]), key=lambda x: x[1])

    before = bonds()
    assert len(before) > 1
    for body in sg.soft_bodies():
        body.material = materials[0]
    run(1)
    assert sg.integrator().lostBonds == 0
    np.testing.assert_allclose(bonds(), before, rtol=0, atol=1e-3 * RADIUS)
