"""Soft grains in a periodic cell."""

import numpy as np
import pytest
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from motion import momentum
from periodic_scenes import DIAMETER, compress, flow, irregular_packing, set_cell
from scenes import (
    DENSITY,
    RADIUS,
    YOUNG,
    add_disk,
    assert_done,
    assert_same_bits,
    assert_threads_change_nothing,
    present_state,
    ready,
    run,
    run_python,
    soft_material,
)
from yade import FrictMat, Matrix3, O, utils

import softgrain as sg


def positions():
    return [b.shape.nodes() for b in sg.soft_bodies()]


def test_motion_with_the_cell_carries_no_stress():
    """Grains apart from each other that a shear carries along; against it they do."""
    set_cell(8 * RADIUS, 8 * RADIUS)
    disks = [add_disk((2 * RADIUS, y * RADIUS, 0)) for y in (1.5, 6)]
    O.cell.velGrad = Matrix3(0, 5, 0, 0, 0, 0, 0, 0, 0)
    for disk in disks:
        disk.state.vel = O.cell.velGrad * disk.state.pos
    ready()
    run(3)
    mass, area = disks[0].state.mass, (8 * RADIUS) ** 2
    unit = mass * (5 * RADIUS) ** 2 / area
    np.testing.assert_allclose(np.array(sg.cell_stress()) / unit, 0, atol=1e-3)
    disks[0].state.vel += (1, 0, 0)
    run(1)
    carried = -2 * mass * 0.5**2 / area
    assert np.array(sg.cell_stress())[0, 0] == pytest.approx(carried, rel=0.01)


@pytest.mark.parametrize("shear", [0.0, 1.0])
def test_where_the_border_lies_does_not_matter(shear):
    """A packing moved across the borders deforms as before, moved with the cell."""
    results = []
    for shift in ((0.0, 0.0), (0.37 * 3 * DIAMETER, -0.21 * 3 * DIAMETER)):
        O.reset()
        irregular_packing(shift)
        ready(tolerance=1e-8, maxSweeps=2000)
        O.dt *= 0.8  # the user's, which stays
        flow(xx=-5.0, yy=-5.0, xy=shear)
        run(500)
        # the cell follows the bodies at the beginning of the next step
        growth = (np.eye(3) + O.dt * np.array(O.cell.velGrad)) @ np.array(O.cell.trsf)
        results.append([x - growth[:2, :2] @ shift for x in positions()])
        borders = [i for i in O.interactions if i.isReal and tuple(i.cellDist) != (0, 0, 0)]
        assert len(borders) >= 5
    for here, there in zip(*results):
        np.testing.assert_allclose(here, there, rtol=0, atol=1e-8 * RADIUS)


def test_two_grains_across_the_border_are_as_two_inside():
    results = []
    for second in (2.02, 2.02 - 8.0):
        O.reset()
        set_cell(8 * RADIUS, 8 * RADIUS)
        disks = [add_disk((x * RADIUS, 0.2 * RADIUS * k, 0)) for k, x in enumerate((0, second))]
        disks[0].state.vel = (0.5, 0, 0)
        ready(tolerance=1e-10, maxSweeps=2000)
        run(60)
        results.append([x - x[0] for x in positions()])
        interaction = O.interactions[0, 1]
        assert tuple(interaction.cellDist) == ((0, 0, 0) if second > 0 else (1, 0, 0))
        assert abs(interaction.geom.contactPoint[0] - disks[0].state.pos[0]) < 1.1 * RADIUS
        point = interaction.geom.contacts()["point"][0]
        assert abs(point[0] - disks[0].state.pos[0]) < 1.2 * RADIUS
    for here, there in zip(*results):
        np.testing.assert_allclose(here, there, rtol=0, atol=1e-9 * RADIUS)


def test_momentum_is_kept_where_images_alone_drive():
    irregular_packing()
    O.cell.homoDeform = 0
    ready()
    flow(xx=-3.0, yy=-3.0, xy=2.0)
    run(600)
    moving = max(np.linalg.norm(b.state.vel) for b in sg.soft_bodies())
    mass = sum(b.state.mass for b in sg.soft_bodies())
    assert moving > 0.01
    assert np.linalg.norm(momentum()) < 1e-12 * mass * moving


@pytest.mark.parametrize("homo", [0, 1, 2])
def test_work_of_the_cell(homo):
    """What the cell does is found in the grains, and it is stress times rate times volume."""
    irregular_packing(massDamping=400.0)
    O.cell.homoDeform = homo
    O.trackEnergy = True
    ready()
    compress(0.80, 1.0)
    balance = sg.Balance()
    energy = sg.integrator().energy()
    done = energy["cell"] + energy["loads"]
    expected = 0.0
    for _ in range(1000):
        strain = O.dt * np.array(O.cell.velGrad)
        O.step()
        expected += np.sum(np.array(utils.getStress()) * strain) * sg.cell_volume()
    energy = sg.integrator().energy()
    done = energy["cell"] + energy["loads"] - done
    assert energy["elastic"] > 0.5  # J/m
    assert balance.error() < 5e-3
    assert done == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize("condition", ("planeStrain", "planeStress"))
def test_stress_of_contacts_and_of_grains_agree(condition):
    """In the mean over a slow compression; and YADE's own sum is that of the contacts. In plane
    stress grains become thicker, by several per cent."""
    irregular_packing(massDamping=400.0, condition=condition)
    ready()
    compress(0.84, 1.0)
    flow(xx=-0.5, yy=-0.3)
    run(200)
    contacts, grains = np.zeros((3, 3)), np.zeros((3, 3))
    for _ in range(200):
        O.step()
        contacts += sg.cell_stress("contacts") / 200
        grains += sg.cell_stress("grains") / 200
    assert -contacts[0, 0] > 0.01 * YOUNG
    plane = np.ix_([0, 1], [0, 1])
    largest = np.abs(contacts).max()
    np.testing.assert_allclose(contacts[plane], grains[plane], rtol=0, atol=0.02 * largest)
    assert (grains[2, 2] < 0) == (condition == "planeStrain")
    yade = np.array(utils.getStress())
    np.testing.assert_allclose(yade[plane], contacts[plane], rtol=0, atol=0.1 * largest)


def test_simple_shear():
    """Bodies leave the cell sideways, contacts come and go, and grains turn with the flow."""
    irregular_packing(massDamping=400.0)
    ready()
    compress(0.86, 1.0)
    O.cell.flipFlippable = True
    flow(xy=3.0)
    start = O.cell.trsf[0, 1]
    seen, stress, count = set(), np.zeros((3, 3)), 0
    while O.cell.trsf[0, 1] - start < 1.2:
        run(20)
        seen |= {(i.id1, i.id2, *i.cellDist) for i in O.interactions if i.isReal}
        stress += sg.cell_stress()
        count += 1
    assert len(seen) > 30
    assert abs(O.cell.hSize[0, 1]) <= 0.6 * O.cell.hSize[0, 0]  # it was flipped
    stress /= count
    assert stress[0, 1] > 0.02 * abs(stress[1, 1])  # it drags back
    # nothing turns the packing as a whole: the mean stress is symmetric
    assert stress[0, 1] == pytest.approx(stress[1, 0], abs=0.02 * abs(stress[1, 1]))
    assert max(abs(b.state.angVel[2]) for b in sg.soft_bodies()) < 100
    assert sg.integrator().largestOverlap < 0.5


def test_grains_at_rest_are_woken_by_the_cell():
    """Two grains that nothing drives sleep until the cell brings the image of one to the other."""
    set_cell(6 * RADIUS, 6 * RADIUS)
    O.cell.homoDeform = 0
    disks = [add_disk((x * RADIUS, RADIUS, 0)) for x in (1, 4)]
    ready()
    run(5)
    assert all(d.shape.isAsleep() for d in disks)
    flow(xx=-5.0)
    run(1)
    assert not any(d.shape.isAsleep() for d in disks)
    while O.cell.size[0] > 4.95 * RADIUS:
        run(10)
    (contact,) = [i for i in O.interactions if i.isReal]
    assert tuple(contact.cellDist) == (-1, 0, 0)
    assert disks[0].state.vel[0] > 0.1 and disks[1].state.vel[0] < -0.1


@pytest.mark.parametrize("place", [(0.0, 0.0), (-1.3, 0.6)])
def test_rigid_disk_across_the_border(place):
    """Reactions on both sides; Newton's integrator lands where the contact solve did."""
    cell = 8 * RADIUS
    set_cell(cell, cell)
    disk = add_disk((place[0] * RADIUS, place[1] * RADIUS, 0))
    sphere = utils.sphere(
        (cell - 2.02 * RADIUS + place[0] * RADIUS, (place[1] + 0.3) * RADIUS, 0),
        RADIUS,
        material=FrictMat(density=DENSITY, frictionAngle=0.5),
    )
    sphere.state.blockedDOFs = "zXY"
    O.bodies.append(sphere)
    sg.as_disks()
    sphere.state.vel = (1.0, 0, 0)
    ready()
    run(150)
    assert disk.state.vel[0] > 0.2
    mass = sphere.state.mass
    assert momentum() == pytest.approx((mass, 0, 0), rel=1e-12, abs=1e-12 * mass)


def test_rigid_disks_flow_with_the_cell():
    """A soft and three rigid disks: cell and homoDeform act on both kinds alike."""
    set_cell(4 * DIAMETER, 4 * DIAMETER)
    for i in range(4):
        for j in range(4):
            centre = ((i + 0.5) * DIAMETER, (j + 0.5) * DIAMETER, 0)
            if (i + j) % 2:
                add_disk(centre)
            else:
                material = FrictMat(young=1e7, density=DENSITY, frictionAngle=0)
                body = utils.sphere(centre, RADIUS, material=material)
                body.state.blockedDOFs = "zXY"
                O.bodies.append(body)
    sg.as_disks()
    ready()
    flow(xx=-1.0, yy=-1.0)
    run(400)
    size = O.cell.size[0]
    for body in O.bodies:
        share = np.array(body.state.pos)[:2] / size * 4
        np.testing.assert_allclose(share, np.floor(share) + 0.5, atol=0.02)
    assert sg.integrator().largestOverlap < 0.1
    assert np.array(utils.getStress())[0, 0] < -0.01 * YOUNG
    with pytest.raises(ValueError, match="is rigid"):
        sg.cell_stress("grains")


def test_stress_with_clumps():
    """Between centres of clumps, not of their members, as utils.getStress has it: at rest without
    a torque."""
    set_cell(4 * DIAMETER, 4 * DIAMETER)
    rigid = FrictMat(density=1000, frictionAngle=0.3)
    soft = soft_material(massDamping=2000, frictionAngle=0.3)
    for i in range(4):
        for j in range(4):
            x, y = (i + 0.5) * DIAMETER, (j + 0.5) * DIAMETER
            if (i + j) % 2 == 0:
                add_disk((x, y, 0), 1.1 * RADIUS, soft)
                continue
            ends = [(x + k * 0.4 * RADIUS, y + k * 0.1 * i * RADIUS, 0) for k in (-1, 1)]
            members = [utils.sphere(end, 0.5 * RADIUS, material=rigid) for end in ends]
            clump, _ = O.bodies.appendClumped(members)
            O.bodies[clump].state.blockedDOFs = "zXY"
    ready(rigid="nonsmooth", tolerance=1e-4, maxSweeps=1000)
    run(1)
    flow(xx=-2, yy=-2)
    while sg.cell_stress()[1, 1] > -0.03 * YOUNG:
        run(20)
    flow()
    run(3000)
    stress, scale = sg.cell_stress()[:2, :2], 0.01 * YOUNG
    assert stress[0, 0] < -scale and stress[1, 1] < -scale
    np.testing.assert_allclose(stress, np.array(utils.getStress())[:2, :2], atol=0.01 * scale)
    assert abs(stress[0, 1] - stress[1, 0]) < 0.01 * scale


def test_contact_points_lie_beside_their_owners():
    """Of grains of two resolutions, across borders too."""
    set_cell(3 * DIAMETER, 3 * DIAMETER)
    for k in range(9):
        centre = ((k % 3 + 0.5) * DIAMETER, (k // 3 + 0.5) * DIAMETER, 0)
        add_disk(centre, zeta=0.3 if k % 2 else 0.25)
    ready()
    compress(0.84, 1.0)
    points = sg.contact_forces()
    assert len(points["owner"]) > 40
    centres = np.array([O.bodies[int(k)].state.pos for k in points["owner"]])
    assert np.linalg.norm(points["point"] - centres, axis=1).max() < 1.2 * RADIUS


def test_pictures_show_images(tmp_path, monkeypatch):
    """Of a disk inside once, of one at a side twice, of one in the corner four times."""
    drawn = []
    monkeypatch.setattr(Figure, "savefig", lambda figure, *_, **__: drawn.append(figure))
    set_cell(5 * DIAMETER, 5 * DIAMETER)
    for x, y in ((2.5, 2.5), (5, 2.5), (10.1, -5)):
        add_disk((x * DIAMETER, y * DIAMETER, 0))
    ready()
    run(1)
    sg.draw_packing(tmp_path / "cell.png")
    (outlines,) = [c for c in drawn[0].axes[0].collections if isinstance(c, LineCollection)]
    centres = np.array([o[:-1].mean(axis=0) for o in outlines.get_segments()]) / DIAMETER
    expected = [(2.5, 2.5), (0, 2.5), (5, 2.5), (0.1, 0), (5.1, 0), (0.1, 5), (5.1, 5)]
    assert len(centres) == len(expected)
    for place in expected:
        assert np.linalg.norm(centres - place, axis=1).min() < 0.01


LOADED = """
    import numpy as np
    import softgrain as sg
    from yade import O
    from scenes import present_state
    O.load("half.yade.gz")
    for _ in range(150):
        O.step()
    np.savez("loaded.npz", **present_state())
    print("done")
"""


def test_save_and_load(tmp_path):
    irregular_packing(stiffnessDamping=2e-5, massDamping=100.0)
    ready()
    O.trackEnergy = True
    flow(xx=-2.0, yy=-2.0, xy=1.0)
    run(400)
    O.save(str(tmp_path / "half.yade.gz"))
    run(150)
    here = present_state()
    assert_done(run_python(LOADED, tmp_path))
    assert_same_bits(dict(np.load(tmp_path / "loaded.npz")), here)


def test_threads_give_the_same_bits():
    """Of so many grains that they share loops, from 32 on, and sweeps, from 16 pairs in each colour
    on."""

    def make_scene():
        irregular_packing(count=8)
        ready()
        flow(xx=-6.0, yy=-6.0, xy=3.0)

    assert_threads_change_nothing(make_scene, 300, numbers=(1, 2, 3))


@pytest.mark.parametrize("source", ("contacts", "grains"))
def test_stress_of_a_cell_that_drifts(source):
    """Motion of all grains together bears nothing; that against each other does."""
    set_cell(5 * DIAMETER, 5 * DIAMETER)
    for x, speed in ((1, 5), (4, 5)):
        add_disk((x * DIAMETER, DIAMETER, 0)).state.vel = (speed, 0, 0)
    if source == "contacts":  # a held body has a mass, too, but no motion of its own
        place, half = (2 * DIAMETER, 3.5 * DIAMETER, 0), (DIAMETER, 0.1 * DIAMETER, DIAMETER)
        floor = utils.box(place, half, fixed=True, material=FrictMat())
        O.bodies.append(floor)
        assert floor.state.mass > 0
    ready()
    run(2)
    assert np.abs(sg.cell_stress(source)).max() < 1e-9
    O.bodies[0].state.vel = (7, 0, 0)
    run(1)
    mass = O.bodies[0].state.mass
    expected = -mass * 2 * 1**2 / (5 * DIAMETER) ** 2
    assert sg.cell_stress(source)[0, 0] == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("first", (0.101, 0.899))
def test_contact_point_of_a_pair_across_the_border(first):
    """Beside body #1, whichever of the two comes first for the kernel."""
    for zetas in ((0.2, 0.3), (0.3, 0.2)):
        O.reset()
        side = 10 * RADIUS
        set_cell(side, side)
        for x, zeta in zip((first, 1 - first), zetas):
            add_disk((x * side, 0.5 * side, 0), zeta=zeta)
        ready()
        O.bodies[0].state.vel = (-0.5 if first < 0.5 else 0.5, 0, 0)
        pressed = []
        while not pressed:
            run(1)
            pressed = [i for i in O.interactions if i.isReal and i.phys.activeContacts]
        (pair,) = pressed
        apart = pair.geom.contactPoint - O.bodies[pair.id1].state.pos
        assert apart.norm() == pytest.approx(RADIUS, rel=0.1)
