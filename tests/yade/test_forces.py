"""Contact forces as arrays, and what YADE's own functions make of soft pairs."""

import numpy as np
import pytest
from motion import kinetic_energy
from partner_scenes import add_clump
from scenes import (
    RADIUS,
    YOUNG,
    add_disk,
    add_wall,
    ready,
    run,
    soft_material,
)
from yade import (
    FrictMat,
    GenericSpheresContact,
    NormShearPhys,
    O,
    Quaternion,
    Sphere,
    Wall,
    _utils,
    utils,
)

import softgrain as sg
from softgrain import finite_elements


@pytest.fixture
def packing():
    """Four soft disks, of two resolutions in turn, about a rigid one pressed in a box, at rest; ids
    of the walls."""
    material = soft_material(massDamping=400, frictionAngle=0.3)
    for x, y in ((1, 1), (3, 1), (1, 3), (3, 3)):
        add_disk((x * RADIUS, y * RADIUS, 0), RADIUS, material, zeta=0.25 if x == 1 else 0.3)
    rigid = utils.sphere(
        (2 * RADIUS, 2 * RADIUS, 0), 0.41 * RADIUS, material=FrictMat(frictionAngle=0.3)
    )
    rigid.state.blockedDOFs = "zXY"
    O.bodies.append(rigid)
    sg.as_disks()
    walls = [add_wall(4 * RADIUS * (k % 2), axis=k // 2) for k in range(4)]  # frictionless
    ready(tolerance=1e-4, maxSweeps=1000)
    walls[3].state.vel = (0, -0.2, 0)
    while walls[3].state.pos[1] > 3.8 * RADIUS:
        run(1)
    walls[3].state.vel = (0, 0, 0)
    O.run(3000, True)
    return [w.id for w in walls]


def test_points_make_pairs_make_bodies(packing):
    points, pairs, bodies = sg.contact_forces(), sg.pair_forces(), sg.body_forces()
    assert len(pairs["id1"]) >= 10 and len(points["owner"]) > 30
    largest = np.abs(bodies["force"]).max() + np.linalg.norm(pairs["normal_force"], axis=1).max()
    for body, force in zip(bodies["id"], bodies["force"]):
        # nodes of the body bear its forces, those of others the opposite
        own = points["force"][points["owner"] == body].sum(axis=0)
        others = points["force"][points["other"] == body].sum(axis=0)
        np.testing.assert_allclose(own - others, force, rtol=0, atol=1e-9 * largest)
        np.testing.assert_allclose(sg.wall_force(int(body))[:2], force[:2], atol=1e-9 * largest)
    np.testing.assert_allclose(bodies["force"].sum(axis=0), 0, atol=1e-9 * largest)


def test_forces_of_walls(packing):
    """The same as in O.forces, which have nothing else on a wall that is held."""
    bodies = sg.body_forces()
    for wall in packing:
        found = bodies["force"][bodies["id"] == wall][0]
        np.testing.assert_allclose(found, O.forces.f(wall), atol=1e-9 * np.abs(found).max())


def test_force_on_a_clump_is_that_on_its_members():
    disk = add_disk((0, 0, 0), material=soft_material(frictionAngle=0.5))
    clump = add_clump([(x * RADIUS, 1.18 * RADIUS, 0) for x in (-0.3, 0.3)], 0.24 * RADIUS)
    add_wall(-RADIUS, axis=1)
    ready()
    clump.state.vel = (0, -0.5, 0)
    run(60)
    members = [sg.wall_force(member) for member in clump.shape.members]
    assert all(force[1] > 0 for force in members)
    np.testing.assert_allclose(sg.wall_force(clump.id), np.sum(members, axis=0))
    touched = {int(i) for i in sg.pair_forces()["id1"]} | {int(i) for i in sg.pair_forces()["id2"]}
    assert disk.id in touched
    assert sg.coordination_number() == len(touched - {disk.id}) - 1  # the clump is one body


def test_tractions_make_the_forces():
    """A block that slides under pressure: tractions times areas are the forces, but for what the
    smoothing carries round the corners."""
    material = soft_material(massDamping=600, frictionAngle=1)
    O.bodies.append(sg.soft_block((0, 0, 0), (4 * RADIUS, 2 * RADIUS), material, zeta=0.2))
    floor = add_wall(-RADIUS, axis=1, friction=0.2).id
    top = add_wall(RADIUS, axis=1, velocity=(0, -0.1, 0))
    ready()
    while top.state.pos[1] > 0.98 * RADIUS:
        run(1)
    top.state.vel = (0, 0, 0)
    O.bodies[0].state.vel = (1, 0, 0)
    run(50)
    points, pairs = sg.contact_forces(), sg.pair_forces()
    at = points["other"] == floor
    force = points["force"][at].sum(axis=0)
    assert force[0] == pytest.approx(-0.2 * force[1], rel=0.02)
    np.testing.assert_allclose(
        np.einsum("ij,ij->i", points["shear"], points["normal"]), 0, atol=1e-9 * YOUNG
    )
    traction = points["pressure"][:, None] * points["normal"] + points["shear"]
    total = (points["area"][:, None] * traction)[at].sum(axis=0)
    np.testing.assert_allclose(total, force, atol=0.05 * force[1])
    row = np.nonzero(np.maximum(pairs["id1"], pairs["id2"]) == floor)[0][0]
    assert pairs["area"][row] == pytest.approx(4 * RADIUS, rel=0.1)
    assert pairs["pressure"][row] == pytest.approx(force[1] / pairs["area"][row], rel=1e-9)
    assert pairs["shear"][row] == pytest.approx(abs(force[0]) / pairs["area"][row], rel=1e-9)
    on_floor = {name: column[-2] for name, column in sg.body_forces().items()}
    assert on_floor["id"] == floor
    for name in ("area", "pressure", "shear"):
        assert on_floor[name] == pytest.approx(pairs[name][row], rel=1e-12)


def test_area_of_contact():
    """A disk squeezed between plates: finite elements have its width, which counts no node beside
    it."""
    material = soft_material(poisson=0.45, frictionAngle=0, massDamping=4000)
    O.bodies.append(sg.soft_disk((0, 0, 0), RADIUS, material, zeta=0.1))
    O.bodies[0].state.ori = Quaternion((0, 0, 1), 0.7)
    walls = [add_wall(s * RADIUS, axis=1, velocity=(0, -0.1 * s, 0), friction=0) for s in (-1, 1)]
    ready()
    while walls[1].state.pos[1] > 0.8 * RADIUS:
        run(1)
    for wall in walls:
        wall.state.vel = (0, 0, 0)
    run(500)
    pairs = sg.pair_forces()
    exact = finite_elements.disk_between_plates("plane_strain")
    force = np.linalg.norm(pairs["normal_force"], axis=1).mean() / (YOUNG * 2 * RADIUS)
    width = 4 * RADIUS * np.interp(force, exact.force_over_ED, exact.contact_halfwidth_over_D)
    assert pairs["area"].mean() == pytest.approx(width, rel=0.04)


def test_what_is_not_there_after_loading(tmp_path):
    """Contact points, and with them areas: nan, not 0. Forces of pairs are."""
    add_disk(material=soft_material(massDamping=600))
    add_wall(-0.99 * RADIUS, axis=0)
    add_wall(0.99 * RADIUS, axis=0)
    ready()
    run(100)
    before = sg.pair_forces()
    assert (before["pressure"] > 0).all() and len(before["pressure"]) == 2
    O.save(str(tmp_path / "pressed.yade.bz2"))
    O.load(str(tmp_path / "pressed.yade.bz2"))
    loaded = sg.pair_forces()
    np.testing.assert_array_equal(loaded["normal_force"], before["normal_force"])
    for name in ("area", "pressure", "shear"):
        assert np.isnan(loaded[name]).all() and np.isnan(sg.body_forces()[name]).all()
    run(1)
    np.testing.assert_allclose(sg.pair_forces()["pressure"], before["pressure"], rtol=0.1)


def test_what_pulls_has_a_negative_pressure():
    """Of a pair; that of a body is the size of what acts on it."""
    floor = add_wall(-1.0001 * RADIUS, axis=1)
    add_disk()
    ready(interface={"cohesion": 1e-3 * YOUNG, "cohesionRange": 0.01 * RADIUS})
    floor.state.vel = (0, -0.01, 0)
    run(30)
    pairs, bodies = sg.pair_forces(), sg.body_forces()
    assert sg.wall_force(floor.id)[1] > 0 > pairs["pressure"][0]
    np.testing.assert_allclose(bodies["pressure"], -pairs["pressure"][0], rtol=1e-12)


@pytest.mark.parametrize("contact", ("points", "nodes"))
def test_no_pressure_without_areas(contact):
    """nan, not 0, under a force."""
    add_disk(contact=contact)
    add_wall(-RADIUS, axis=1)
    top = add_wall(RADIUS, axis=1, velocity=(0, -0.1, 0))
    ready()
    while not sg.wall_force(top.id)[1] > 0:
        run(1)
    pairs = sg.pair_forces()
    row = np.nonzero(np.maximum(pairs["id1"], pairs["id2"]) == top.id)[0][0]
    assert pairs["area"][row] == 0 and np.isnan(pairs["pressure"][row])
    assert pairs["shear"][row] == 0


def test_no_contact_gives_empty_arrays():
    add_disk()
    ready()
    run(1)
    assert sg.contact_forces()["force"].shape == (0, 3)
    assert len(sg.pair_forces()["pressure"]) == 0
    bodies = sg.body_forces()
    assert list(bodies["id"]) == [0] and (bodies["force"] == 0).all()


def test_stress_by_yade(packing):
    """utils.getStress, from forces and centres, against the walls; interactions.all() see the
    aggregate of each pair."""
    height, width = (
        O.bodies[packing[k + 1]].state.pos[a] - O.bodies[packing[k]].state.pos[a]
        for k, a in ((2, 1), (0, 0))
    )
    stress = utils.getStress(width * height)
    for axis, (low, high, area) in enumerate(
        ((packing[0], packing[1], height), (packing[2], packing[3], width))
    ):
        mean = (sg.wall_force(low)[axis] - sg.wall_force(high)[axis]) / (2 * area)
        assert stress[axis][axis] == pytest.approx(mean, rel=0.01)
        assert mean < -1e-3 * YOUNG


def test_fabric_by_yade(packing):
    fabric = utils.fabricTensor()[0]
    assert fabric.trace() == pytest.approx(1, rel=1e-6)
    assert abs(fabric[0][1]) < 0.1 and 0.3 < fabric[0][0] < 0.7 and fabric[2][2] == 0


def test_unbalanced_force(packing):
    """At rest next to nothing."""
    assert 0 <= sg.unbalanced_force() < 0.01
    O.bodies[packing[3]].state.vel = (0, -1, 0)
    run(5)
    assert sg.unbalanced_force() > 0.02


def test_unbalanced_force_after_the_time_was_reset(packing):
    before = sg.unbalanced_force()
    O.resetTime()
    assert sg.unbalanced_force() == before


def test_unbalanced_force_by_yade(packing):
    """``utils.unbalancedForce`` counts soft grains and the rigid disk, by all its names."""
    O.bodies[packing[3]].state.vel = (0, -1, 0)
    run(5)
    sums = [O.forces.f(b.id).norm() for b in O.bodies if not isinstance(b.shape, Wall)]
    assert len(sums) == 5
    real = (i.phys for i in O.interactions if i.isReal)
    forces = [(p.normalForce + p.shearForce).norm() for p in real]
    carried = np.mean([force for force in forces if force > 0])
    for unbalanced in (utils.unbalancedForce, _utils.unbalancedForce):
        assert unbalanced() == pytest.approx(np.mean(sums) / carried, rel=1e-12)
        assert unbalanced(useMaxForce=True) == pytest.approx(max(sums) / carried, rel=1e-12)
    assert sg.unbalanced_force() == utils.unbalancedForce()


def test_kinetic_energy_by_yade(packing):
    """``utils.kineticEnergy`` counts soft grains with their vibrations, and the rigid disk."""
    rigid = next(b for b in O.bodies if isinstance(b.shape, Sphere))
    O.bodies[packing[3]].state.vel = (0, -1, 0)
    run(5)
    rigid.state.angVel = (0, 0, 1000)
    soft = {b.id: b.shape.energy()["kinetic"] for b in sg.soft_bodies()}
    energy = kinetic_energy([rigid])
    assert energy > 0 and all(value > 0 for value in soft.values())
    for kinetic in (utils.kineticEnergy, _utils.kineticEnergy):
        assert kinetic() == pytest.approx(sum(soft.values()) + energy, rel=1e-12)
        assert kinetic(findMaxId=True) == (kinetic(), rigid.id)
    assert sum(soft.values()) == pytest.approx(sg.quasi_static()["kinetic"])
    rigid.state.angVel = rigid.state.vel = (0, 0, 0)
    assert utils.kineticEnergy(True)[1] == max(soft, key=soft.get)


def chains():
    """Ends and force of the cylinders that Gl1_NormPhys draws, as its `go` has it, with their
    interactions: (interaction, start (3,), end (3,), force along the normal)."""
    found = []
    for i in O.interactions:
        if not (i.isReal and isinstance(i.phys, sg.SoftPhys) and i.phys.activeContacts):
            continue
        assert isinstance(i.geom, GenericSpheresContact) and isinstance(i.phys, NormShearPhys)
        normal, point = np.array(i.geom.normal), np.array(i.geom.contactPoint)
        assert np.linalg.norm(normal) == pytest.approx(1, rel=1e-12)
        ends = point - i.geom.refR1 * normal, point + i.geom.refR2 * normal
        found.append((i, *ends, np.array(i.phys.normalForce) @ normal))
    return found


def test_force_chains(packing):
    """What YADE's Gl1_NormPhys draws of a packing: cylinders from centre to centre, where walls are
    from the centre through the wall, as thick as the forces between the bodies."""
    drawn = chains()
    assert len(drawn) >= 12
    for i, start, end, force in drawn:
        assert force == pytest.approx(i.phys.normalForce.norm(), rel=1e-12)  # > 0: compression
        for body, place in ((O.bodies[i.id1], start), (O.bodies[i.id2], end)):
            if isinstance(body.shape, Wall):
                continue
            miss = np.linalg.norm(place - np.array(body.state.pos))
            assert miss < 0.15 * RADIUS
    pairs = sg.pair_forces()
    np.testing.assert_allclose(
        sorted(force for *_, force in drawn), sorted(np.linalg.norm(pairs["normal_force"], axis=1))
    )
    shares = np.array(utils.fabricTensor()[0])  # of its normals
    assert shares[0, 0] + shares[1, 1] == pytest.approx(1)


def test_normal_on_a_wide_floor():
    """That of the contact, not the direction to the far centre of a facet or a box; radii reach to
    the centre of a long block. They stay in steps that leave sleeping pairs out."""
    stiff = FrictMat(frictionAngle=0.5)
    plate = [(-0.05, 0, -1), (-0.05, 0, 1), (1, 0, 0)]
    O.bodies.append(utils.facet(plate, fixed=True, material=stiff))
    block = sg.soft_block(
        (0, 2 * RADIUS, 0), (2 * RADIUS, 4 * RADIUS), soft_material(massDamping=600), zeta=0.3
    )
    O.bodies.append(block)
    ready(gravity=(0, -10, 0))
    O.run(3000, True)
    for steps in (1, 20):
        run(steps)
        ((interaction, start, end, force),) = chains()
        np.testing.assert_allclose(interaction.geom.normal, (0, 1, 0), atol=1e-9)
        np.testing.assert_allclose(end, block.state.pos, atol=0.05 * RADIUS)
        np.testing.assert_allclose(end - start, (0, 4 * RADIUS, 0), atol=0.05 * RADIUS)
        assert force == pytest.approx(10 * block.state.mass, rel=0.02)


def test_pair_that_pulls():
    """Tension has the other sign; the normal points from #1 to #2 all the same."""
    disks = [add_disk((x * RADIUS, 0, 0)) for x in (0, 2)]
    bond = {"bondStrength": 1e5, "bondEnergy": 10.0}
    ready(interface=bond)
    run(3)
    disks[1].state.vel = (0.5, 0, 0)
    run(10)
    ((interaction, *_, force),) = chains()
    assert force < 0
    assert force == pytest.approx(-interaction.phys.normalForce.norm(), rel=1e-6)
    np.testing.assert_allclose(interaction.geom.normal, (1, 0, 0), atol=1e-3)
