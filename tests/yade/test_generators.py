"""Packings of all of YADE's generators go soft and make steps."""

import math

import numpy as np
import pytest
from scenes import DENSITY, ready, run, soft_material
from yade import FrictMat, O, pack, utils, ymport

import softgrain as sg

RADIUS = 0.01
BOX = ((0, 0, 0), (0.06, 0.06, 0.06))
FLAT = ((0, 0, 0), (0.1, 0.1, 0))


def rigid():
    return FrictMat(young=1e6, poisson=0.3, density=DENSITY, frictionAngle=0.3)


def cloud(corners, number, **how):
    spheres = pack.SpherePack()
    how = how or {"rMean": RADIUS, "rRelFuzz": 0.2}
    assert spheres.makeCloud(*corners, num=number, seed=3, **how) > 4
    return spheres.toSimulation(material=rigid())


def flat_cloud():
    return cloud(FLAT, 12)


def solid_cloud():
    return cloud(BOX, 8, rMean=0.008, rRelFuzz=0.2)


def sizes_of_a_sieve():
    return cloud(FLAT, 20, psdSizes=[0.01, 0.014, 0.02], psdCumm=[0, 0.5, 1.0])


def regular_hexa():
    bodies = pack.regularHexa(pack.inAlignedBox(*BOX), radius=0.0099, gap=0, material=rigid())
    return O.bodies.append(bodies)


def regular_ortho():
    bodies = pack.regularOrtho(pack.inAlignedBox(*BOX), radius=0.0099, gap=0, material=rigid())
    return O.bodies.append(bodies)


def one_layer_of_regular_hexa():
    """The lowest layer: regularHexa fills no box that is just one sphere high."""
    bodies = pack.regularHexa(pack.inAlignedBox(*BOX), radius=0.0099, gap=0, material=rigid())
    lowest = min(b.state.pos[2] for b in bodies)
    return O.bodies.append([b for b in bodies if b.state.pos[2] < lowest + 1e-9])


def regular_ortho_in_a_layer():
    layer = pack.inAlignedBox((0, 0, -0.0101), (0.1, 0.1, 0.0101))
    bodies = pack.regularOrtho(layer, radius=0.01, gap=0, material=rigid())
    return O.bodies.append(bodies)


def random_dense():
    bodies = pack.randomDensePack(
        pack.inAlignedBox(*BOX), radius=0.01, spheresInCell=100, material=rigid(), seed=1
    )
    if isinstance(bodies, pack.SpherePack):
        return bodies.toSimulation(material=rigid())
    return O.bodies.append(bodies)


def net():
    """The nodes of a wire net; its wires are interactions of the rigid material, and end."""
    bodies, _, _ = pack.hexaNet(
        radius=0.002,
        cornerCoord=[0, 0, 0],
        xLength=0.1,
        yLength=0.08,
        mos=0.04,
        a=0.02,
        b=0.02,
        material=rigid(),
    )
    return O.bodies.append(bodies)


def loaded_pack(tmp_path):
    spheres = pack.SpherePack()
    spheres.makeCloud(*FLAT, rMean=RADIUS, num=10, seed=2)
    spheres.save(str(tmp_path / "pack.txt"))
    again = pack.SpherePack()
    again.load(str(tmp_path / "pack.txt"))
    return again.toSimulation(material=rigid())


def imported_text(tmp_path):
    (tmp_path / "spheres.txt").write_text("".join(f"{0.03 * k} 0 0 0.01\n" for k in range(5)))
    return O.bodies.append(ymport.text(str(tmp_path / "spheres.txt"), material=rigid()))


def imported_with_format(tmp_path):
    lines = "".join(f"{0.03 * k} 0 0 0.01 1\n" for k in range(5))
    (tmp_path / "spheres.txt").write_text("#format x_y_z_r_matId\n" + lines)
    O.materials.append([rigid(), rigid()])
    return O.bodies.append(ymport.textExt(str(tmp_path / "spheres.txt"), format="x_y_z_r_matId"))


@pytest.mark.parametrize(
    "generate, dim",
    [
        (flat_cloud, 2),
        (sizes_of_a_sieve, 2),
        (one_layer_of_regular_hexa, 2),
        (regular_ortho_in_a_layer, 2),
        (net, 2),
        (loaded_pack, 2),
        (imported_text, 2),
        (imported_with_format, 2),
        (solid_cloud, 3),
        (regular_hexa, 3),
        (regular_ortho, 3),
        (random_dense, 3),
    ],
)
def test_packing_goes_soft(generate, dim, tmp_path):
    needs_folder = generate in (loaded_pack, imported_text, imported_with_format)
    ids = generate(tmp_path) if needs_folder else generate()
    assert len(ids) > 4
    if dim == 2:
        for i in ids:
            O.bodies[i].state.blockedDOFs = "zXY"
    radii = np.array([O.bodies[i].shape.radius for i in ids])
    places = np.array([O.bodies[i].state.pos for i in ids])
    assert sg.soften(ids, soft_material(), zeta=0.5) == list(ids)
    ready(gravity=(0, -10, 0))
    assert {O.bodies[i].shape.dim for i in ids} == {dim}
    run(10)
    volume = math.pi * radii**2 if dim == 2 else 4 / 3 * math.pi * radii**3
    masses = np.array([O.bodies[i].state.mass for i in ids])
    np.testing.assert_allclose(masses, DENSITY * volume, rtol=1e-9)
    moved = np.array([O.bodies[i].state.pos for i in ids]) - places
    assert np.isfinite(moved).all() and np.abs(moved).max() < 1e-2 * radii.min()
    # the packing falls as one: contacts between its grains move its centre nowhere
    fallen = masses @ moved / masses.sum()
    np.testing.assert_allclose(fallen, (0, -5 * O.time**2, 0), atol=0.15 * 5 * O.time**2)
    engine = sg.integrator()
    assert engine.lastError == "" and engine.largestOverlap < 0.5
    assert engine.templates == 1


def test_a_layer_in_another_plane_is_refused():
    spheres = pack.SpherePack()
    spheres.makeCloud((0, 0, 0), (0.1, 0, 0.1), rMean=RADIUS, num=8, seed=1)
    ids = spheres.toSimulation(material=rigid())
    for i in ids:
        O.bodies[i].state.blockedDOFs = "yXZ"
    for of, dim in ((None, None), (ids, None), (ids, 2)):
        with pytest.raises(ValueError, match="#0 is held, .*a layer lies in a plane z = const"):
            sg.soften(of, soft_material(), dim=dim)


def test_a_single_layer_needs_a_choice():
    bodies = [utils.sphere((0.03 * k, 0, 0), 0.01, material=rigid()) for k in range(3)]
    ids = O.bodies.append(bodies)
    with pytest.raises(ValueError, match="give dim=2 or dim=3"):
        sg.soften(ids, soft_material())
    assert sg.soften(ids, soft_material(), dim=3, zeta=0.5) == ids
