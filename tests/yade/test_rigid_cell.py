"""Rigid bodies by contact dynamics in a periodic cell."""

import numpy as np
import pytest
from motion import momentum
from periodic_scenes import flow
from rigid_scenes import R, add_sphere, spheres, start
from scenes import run
from test_rigid_energy import balance
from yade import FrictMat, Matrix3, O, PeriTriaxController, pack, utils

import softgrain as sg

SIDE = 7.8 * R


def lattice(shift=(0, 0, 0), dim=2, friction=0.3, clumps=False):
    """Disks (balls) that nearly touch on a square lattice with noise, in a cell of 4 x 4 (x 4),
    where `shift` would put them or, if they are in no clumps, their images in the cell there;
    returns how far from where they would be without."""
    shifts = []
    random = np.random.default_rng(5)
    O.periodic = True
    O.cell.setBox(SIDE, SIDE, SIDE)
    for place in np.ndindex(*[4] * dim):
        centre = np.zeros(3)
        centre[:dim] = (np.array(place) + 0.5) * SIDE / 4 + 0.02 * R * random.uniform(-1, 1, dim)
        radius = R * random.uniform(0.92, 0.96)
        blocked = "zXY" if dim == 2 else ""
        moved = centre + shift
        if not clumps:
            moved %= SIDE
        shifts.append(moved - centre)
        add_sphere(tuple(moved), radius, friction, blocked=blocked)
    if clumps:
        O.bodies.clump([0, 1])
        O.bodies.clump([3, 7])
    return np.array(shifts)


def bearing_across_borders():
    """Pairs of ids."""
    return {
        (min(i.id1, i.id2), max(i.id1, i.id2))
        for i in O.interactions
        if i.isReal and tuple(i.cellDist) != (0, 0, 0) and i.phys.normalForce.norm() > 0
    }


@pytest.mark.parametrize("dim, clumps", ((2, False), (3, False), (3, True)))
def test_where_the_border_lies_does_not_matter(dim, clumps):
    results, pairs = [], []
    for shift in np.array(((0, 0, 0), (0.37, -0.21, 0 if dim == 2 else 1.6))) * SIDE:
        O.reset()
        shifts = lattice(shift, dim, clumps=clumps)
        start(2e-4, (0, 0, 0), tolerance=1e-10, maxSweeps=5000)
        flow(xx=-0.5, yy=-0.5, zz=-0.5 if dim == 3 else 0, xy=0.7)
        pairs.append(set())
        for _ in range(400):
            run(1)
            pairs[-1] |= bearing_across_borders()
        # the cell follows the bodies at the beginning of the next step
        growth = (np.eye(3) + O.dt * np.array(O.cell.velGrad)) @ np.array(O.cell.trsf)
        results.append([b.state.pos - growth @ s for b, s in zip(spheres(), shifts)])
    assert len(pairs[0]) > 1 and (clumps or len(pairs[1] - pairs[0]) > 1)
    np.testing.assert_allclose(*results, rtol=0, atol=1e-6 * R)


@pytest.mark.parametrize("homo", (0, 2))
def test_energy(homo):
    """What contacts lose the cell has done; and momentum is kept where images alone drive."""
    lattice()
    O.cell.homoDeform = homo
    O.trackEnergy = True
    start(2e-4, (0, 0, 0))
    flow(xx=-0.5, yy=-0.5, xy=2)
    run(1)
    before = balance()[0]
    run(500)
    after, energy = balance()
    lost = energy["rigidFriction"] + energy["rigidImpact"]
    assert energy["rigidFriction"] > 0 and energy["rigidImpact"] > 0
    assert after == pytest.approx(before, abs=1e-10 * lost)
    if homo == 0:
        largest = max(b.state.mass * b.state.vel.norm() for b in spheres())
        assert largest > 0 and np.linalg.norm(momentum()) < 1e-10 * largest


def test_body_too_long_for_its_cell_is_refused():
    O.periodic = True
    O.cell.setBox(3.9 * R, 10 * R, 10 * R)
    add_sphere((5 * R, 5 * R, 5 * R))
    O.engines = sg.engines(rigid="nonsmooth")
    O.dt = 1e-4
    with pytest.raises(RuntimeError, match="rigid body #0 spans .* along base vector 0"):
        run(2)


def test_floor_of_long_facets_is_refused():
    """Without any soft grain, too: they would let spheres through."""
    O.periodic = True
    O.cell.setBox(10 * R, 10 * R, 20 * R)
    corners = [(0, 0, 10 * R), (10 * R, 0, 10 * R), (10 * R, 10 * R, 10 * R)]
    O.bodies.append(utils.facet(corners, material=FrictMat()))
    add_sphere((5 * R, 3 * R, 11 * R))
    start(2e-4)
    with pytest.raises(RuntimeError, match="#0 .Facet. spans .* it might touch a sphere on two"):
        run(2)


def test_floor_that_comes_after_the_engines_is_refused():
    O.periodic = True
    O.cell.setBox(10 * R, 10 * R, 20 * R)
    add_sphere((5 * R, 3 * R, 11 * R))
    start(2e-4)
    half = (8 * R, 8 * R, R)
    O.bodies.append(utils.box((5 * R, 5 * R, 9 * R), half, fixed=True, material=FrictMat()))
    with pytest.raises(RuntimeError, match="sortAxis = 0, but rigid body #1 is longer"):
        run(2)


def test_clump_that_would_meet_its_image_is_refused():
    O.periodic = True
    O.cell.setBox(10 * R, 10 * R, 10 * R)
    O.bodies.clump([add_sphere(((1.9 * k + 1) * R, 5 * R, 5 * R)).id for k in range(5)])
    start(1e-3, (0, 0, 0))
    run(2)
    O.cell.velGrad = Matrix3(-1, 0, 0, 0, 0, 0, 0, 0, 0)
    with pytest.raises(RuntimeError, match="clump #5 spans .* it might meet its own image"):
        run(100)
    assert O.cell.size[0] > 9.6 * R


def test_warning_of_a_packing_that_creeps_into_itself(capfd):
    """Once: under stress, where the sweeps leave a little in each step that only the cell could
    take back."""
    O.materials.append(FrictMat(density=1000, frictionAngle=0))
    side, radius = 0.13, 0.01
    O.periodic = True
    O.cell.setBox(side, side, 1)
    cloud = pack.SpherePack()
    cloud.makeCloud(
        (0, 0, 0), (side, side, 0), rMean=radius, rRelFuzz=0.2, num=30, periodic=True, seed=2
    )
    ids = cloud.toSimulation(material=0)
    for k in ids:
        O.bodies[k].state.blockedDOFs = "zXY"
    sg.as_disks(ids)
    mass = 3 * sum(O.bodies[k].state.mass for k in ids)
    control = PeriTriaxController(
        dynCell=True,
        mass=mass,
        growDamping=0.5,
        stressMask=3,
        goal=(-1e4, -1e4, 0),
        maxStrainRate=(2, 2, 0),
    )
    O.engines = sg.engines(rigid="nonsmooth", tolerance=1e-3)
    sg.insert_before_solve(control)
    O.dt = 1e-4
    run(3800)
    assert "of a radius in a periodic cell" not in capfd.readouterr().err
    while 0.1 * sg.integrator().overlap < 0.02 and O.iter < 12000:  # over dr, a tenth of R
        run(100)
    assert capfd.readouterr().err.count("of a radius in a periodic cell") == 1


def test_no_warning_of_overlaps_from_the_start(capfd):
    O.periodic = True
    O.cell.setBox(SIDE, SIDE, SIDE)
    for x in (2, 3.96):
        add_sphere((x * R, 2 * R, 2 * R))
    start(1e-4)
    run(50)
    assert "of a radius in a periodic cell" not in capfd.readouterr().err
