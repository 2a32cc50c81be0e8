"""Functions of ``yade.utils`` that know soft grains once softgrain is imported."""

import math

import numpy as np
import pytest
from scenes import (
    DENSITY,
    RADIUS,
    add_disk,
    add_wall,
    assert_done,
    ready,
    run,
    run_python,
    soft_material,
)
from yade import FrictMat, Matrix3, O, _utils, pack, utils

import softgrain as sg


def test_kinetic_energy_in_a_cell():
    """Relative to the motion of the cell, as YADE has it for rigid bodies."""
    O.periodic = True
    O.cell.setBox(0.2, 0.2, 1)
    O.cell.velGrad = Matrix3(-1, 0.5, 0, 0, -2, 0, 0, 0, 0)
    add_disk((0.04, 0.1, 0), RADIUS, soft_material())
    sphere = utils.sphere((0.16, 0.1, 0), RADIUS, material=FrictMat())
    sphere.state.blockedDOFs = "zXY"
    O.bodies.append(sphere)
    sg.as_disks()
    ready()
    run(20)
    resting = utils.kineticEnergy()
    fast = sg.quasi_static()["kinetic"]
    assert resting < 1e-3 * fast
    for body in O.bodies:
        body.state.vel += (1, 0, 0)
    run(1)
    mass = sum(body.state.mass for body in O.bodies)
    assert utils.kineticEnergy() == pytest.approx(mass / 2, rel=1e-2)


def test_kinetic_energy_in_3d():
    """Of balls that turn, beside that which YADE tells of a sphere and of a clump, once."""
    spheres = [utils.sphere((0, y, 0), RADIUS, material=FrictMat()) for y in (0, 0.1, 0.115)]
    O.bodies.append(spheres[0])
    clump, _ = O.bodies.appendClumped(spheres[1:])
    for body in (spheres[0], O.bodies[clump]):
        body.state.vel, body.state.angVel = (1, -2, 0.5), (30, 40, -20)
    rigid = utils.kineticEnergy()
    assert rigid > 0
    ball = sg.soft_sphere((0, 0, 0.1), RADIUS, soft_material(), zeta=0.4)
    O.bodies.append(ball)
    ball.state.vel, ball.state.angVel = (3, 0, 4), (0, 100, 0)
    ready()
    mass = DENSITY * 4 / 3 * math.pi * RADIUS**3
    energy = mass * (0.5 * 25 + 0.2 * (100 * RADIUS) ** 2)
    assert utils.kineticEnergy() - rigid == pytest.approx(energy, rel=1e-2)
    assert utils.kineticEnergy(True)[1] == ball.id


def test_boxes_and_fabric_by_yade():
    """``utils.aabbExtrema``, ``fabricTensor`` and ``porosity`` of soft grains alone, and of these
    beside a sphere."""
    for x in (1, 3):
        add_disk((x * RADIUS, RADIUS, 0), 1.01 * RADIUS)
    ready()
    run(50)
    outlines = np.concatenate([b.shape.outline() for b in sg.soft_bodies()])
    low, high = np.array(utils.aabbExtrema())
    np.testing.assert_allclose(low[:2], outlines.min(axis=0)[:2])
    np.testing.assert_allclose(high[:2], outlines.max(axis=0)[:2])
    assert high[2] == -low[2] == 1.01 * RADIUS
    np.testing.assert_allclose(utils.aabbExtrema(cutoff=1)[0], utils.aabbExtrema(cutoff=1)[1])
    places = [b.state.pos for b in sg.soft_bodies()]
    np.testing.assert_allclose(utils.aabbExtrema(centers=True), np.sort(places, axis=0))
    with pytest.raises(ValueError, match="cutoff = 2"):
        utils.aabbExtrema(2)
    np.testing.assert_allclose(utils.fabricTensor()[0], np.diag([1, 0, 0]), atol=1e-4)
    box = (6 * RADIUS) ** 2
    assert utils.porosity(box) == pytest.approx(1 - sg.packing_fraction(box), rel=1e-12)
    area = np.prod((high - low)[:2])
    assert utils.porosity() == pytest.approx(1 - sg.packing_fraction(area), rel=1e-12)
    for nothing in (math.nan, "a", None):
        with pytest.raises(ValueError, match="volume = "):
            utils.porosity(nothing)
    inside = utils.fabricTensor(extrema=np.array((low, high)))[0]
    np.testing.assert_array_equal(inside, utils.fabricTensor()[0])
    O.bodies.append(utils.sphere((9 * RADIUS, RADIUS, 0), RADIUS, material=FrictMat()))
    assert _utils.aabbExtrema()[1][0] == pytest.approx(10 * RADIUS)
    filled = sg.packing_fraction(box) + np.pi * RADIUS**2 / box
    assert utils.porosity(box) == pytest.approx(1 - filled, rel=1e-12)


@pytest.mark.parametrize("dim", (2, 3))
@pytest.mark.parametrize("zeta", (0.5, 0.25))
def test_box_and_porosity_of_boundary_points(zeta, dim):
    """Disks, or balls, about them are part of the grain."""
    make = sg.soft_disk if dim == 2 else sg.soft_sphere
    O.bodies.append(make((0, 0, 0), RADIUS, soft_material(), zeta=zeta, contact="points"))
    ready()
    low, high = np.array(utils.aabbExtrema())
    np.testing.assert_allclose(high[:dim], RADIUS, rtol=0.05)
    np.testing.assert_allclose(low, -high)
    full = np.pi / 4 if dim == 2 else np.pi / 6
    assert utils.porosity() == pytest.approx(1 - full, abs=0.1)


def test_box_and_porosity_in_3d():
    """Balls fill what they fill, and a sphere beside them, too."""
    for z in (1, 3):
        O.bodies.append(sg.soft_sphere((0, 0, z * RADIUS), RADIUS, soft_material(), zeta=0.4))
    O.bodies.append(utils.sphere((3 * RADIUS, 0, RADIUS), 0.5 * RADIUS, material=FrictMat()))
    low, high = np.array(utils.aabbExtrema()) / RADIUS
    assert low == pytest.approx((-1, -1, 0), abs=0.02)
    assert high == pytest.approx((3.5, 1, 4), abs=0.02)
    volume = 4 / 3 * math.pi * RADIUS**3
    assert utils.porosity(10 * volume) == pytest.approx(1 - (2 + 0.125) / 10, rel=1e-3)


def test_unbalanced_force_counts_what_rigid_bodies_weigh():
    """A soft disk and a rigid one that lie on the floor are in balance."""
    add_disk(material=soft_material(massDamping=2000))
    rigid = utils.sphere((4 * RADIUS, 0, 0), RADIUS, material=FrictMat(density=DENSITY))
    rigid.state.blockedDOFs = "zXY"
    O.bodies.append(rigid)
    add_wall(-RADIUS, axis=1)
    sg.as_disks()
    ready()
    for k in range(40):
        O.engines[-1].gravity = (0, -200 * min(1, k / 12), 0)
        run(100)
    weight = 200 * DENSITY * math.pi * RADIUS**2
    assert -O.forces.f(2)[1] == pytest.approx(2 * weight, rel=0.1)
    assert utils.unbalancedForce(useMaxForce=True) < 0.2  # without weights above 1


def test_fabric_counts_what_bears():
    """Not what is within reach; parted as YADE parts it."""
    for x, y in ((0, 0), (2, 0), (0, 2.02)):
        add_disk((x * RADIUS * 0.999, y * RADIUS, 0))
    ready()
    while sg.integrator().contacts == sg.integrator().activeContacts:
        O.bodies[2].state.pos -= (0, 1e-3 * RADIUS, 0)  # till it is within reach
        run(1)
    real = [i for i in O.interactions if i.isReal]
    assert len(real) > sum(i.phys.activeContacts > 0 for i in real) == 1
    np.testing.assert_allclose(utils.fabricTensor()[0], np.diag([1, 0, 0]), atol=1e-3)
    strong, weak = utils.fabricTensor(splitTensor=True)
    np.testing.assert_allclose(strong, np.diag([1, 0, 0]), atol=1e-3)
    assert np.isnan(weak).all()
    nothing = utils.fabricTensor(extrema=[(8, 8, 8), (9, 9, 9)])[0]
    assert np.isnan(nothing).all()


def test_fabric_is_that_of_yade():
    """Of rigid balls, with a soft one far away and without."""
    ids = pack.SpherePack([((1.9 * x, 1.8 * y, 1.7 * z), 1) for x, y, z in np.ndindex(3, 3, 2)])
    O.bodies.append([utils.sphere(*s, material=FrictMat(young=1e6)) for s in ids])
    O.engines, O.dt = sg.engines(rigid="linear"), 1e-6
    run(1)

    def fabrics():
        whole = [(-9, -9, -9), (9, 9, 9)]
        split = [{"splitTensor": True, "thresholdForce": t} for t in (math.nan, -1e5, -1.2e5)]
        found = [utils.fabricTensor(extrema=whole, **kind) for kind in ({}, *split)]
        return [np.array(tensor) for tensors in found for tensor in tensors]

    expected = fabrics()
    O.bodies.append(sg.soft_sphere((99, 0, 0), 1, soft_material(), zeta=0.5))
    for found, own in zip(fabrics(), expected, strict=True):
        np.testing.assert_allclose(found, own, atol=1e-12)


SCRIPT = """
from yade.utils import *
import softgrain as sg
O.bodies.append(sg.soft_disk((0, 0, 0), 0.01, sg.SoftMat(young=1e6, poisson=0.3, density=1000)))
O.bodies.append(wall(-0.01, axis=1))
O.engines = sg.engines(gravity=(0, -10, 0))
sg.set_time_step()
O.run(100, True)
assert unbalancedForce() == sg.unbalanced_force() > 0
assert kineticEnergy() == O.bodies[0].shape.energy()["kinetic"] > 0
O.reset()
O.bodies.append(sphere((0, 0, 0), 1, material=FrictMat()))
assert unbalancedForce() != unbalancedForce(), "nan without forces, as YADE has it"
O.bodies[0].state.vel = (2, 0, 0)
assert kineticEnergy(True) == (2 * O.bodies[0].state.mass, 0)
print("done")
"""


def test_spheres_alone_grow():
    """YADE would write where the radius of a sphere is."""
    sphere, facet = (
        utils.sphere((0, 0, 0), RADIUS, material=FrictMat()),
        utils.facet([(0, 0, 0), (1, 0, 0), (0, 1, 0)], material=FrictMat()),
    )
    O.bodies.append([sphere, facet])
    clump, _ = O.bodies.appendClumped([utils.sphere((1, k, 0), RADIUS) for k in (0, 1)])
    for body, kind in ((1, "Facet"), (clump, "clump")):
        with pytest.raises(ValueError, match=f"bodyID = {body}: a {kind} does not grow"):
            utils.growParticle(body, 2)
    with pytest.raises(ValueError, match="bodyID: there is no body #99"):
        utils.growParticle(99, 2)
    utils.growParticle(0, 2)
    assert sphere.shape.radius == 2 * RADIUS


def test_functions_of_utils_in_a_script(tmp_path):
    """The names that a script has had from YADE before; without soft grains YADE's own."""
    assert_done(run_python(SCRIPT, tmp_path, command=["/usr/bin/yade", "-n", "-x"]))
