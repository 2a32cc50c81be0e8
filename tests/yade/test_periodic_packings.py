"""Packings of YADE's periodic generators go soft."""

import math

import numpy as np
import pytest
from periodic_scenes import flow, set_cell
from scenes import RADIUS, ZETA, assert_goes_on_after_loading, run, soft_material
from yade import FrictMat, Matrix3, O, pack, utils

import softgrain as sg


def test_periodic_cloud_to_soft_disks():
    """YADE leaves the cell of a flat cloud to the script."""
    set_cell(0.16, 0.12)
    cloud = pack.SpherePack()
    cloud.makeCloud((0, 0, 0), (0.16, 0.12, 0), rMean=0.008, rRelFuzz=0.2, num=25, periodic=True)
    ids = cloud.toSimulation(material=FrictMat())
    for i in ids:
        O.bodies[i].state.blockedDOFs = "zXY"
    assert O.periodic and len(ids) > 15
    sg.soften(material=soft_material(), zeta=ZETA, overlap="refuse")
    O.engines = sg.engines()
    start = sg.packing_fraction()
    flow(xx=-10.0, yy=-10.0)
    run(300)
    assert sg.packing_fraction() > 1.02 * start
    assert sg.integrator().largestOverlap < 0.5


def test_overlaps_across_the_border_are_seen():
    set_cell(0.1, 0.1)
    for x in (0.002, 0.095):
        body = utils.sphere((x, 0.05, 0), 0.01, material=FrictMat())
        body.state.blockedDOFs = "zXY"
        O.bodies.append(body)
    with pytest.raises(ValueError, match="#1 and #0 overlap by 130 %"):
        sg.soften(material=soft_material(), zeta=ZETA)


def test_periodic_cloud_to_soft_balls():
    cloud = pack.SpherePack()
    cloud.makeCloud((0, 0, 0), (0.1, 0.1, 0.1), rMean=0.0125, num=30, periodic=True, seed=2)
    cloud.toSimulation(material=FrictMat())
    assert O.periodic and O.cell.size[0] == 0.1
    sg.soften(material=soft_material(), zeta=0.5)
    O.engines = sg.engines()
    O.cell.velGrad = Matrix3(-20, 0, 0, 0, -20, 0, 0, 0, -20)
    while sg.packing_fraction() < 0.66:
        run(10)
    contacts, grains = sg.cell_stress("contacts"), sg.cell_stress("grains")
    assert contacts[0, 0] < 0 and contacts[2, 2] < 0
    assert np.trace(grains) < 0
    assert any(i.isReal and i.cellDist[2] != 0 for i in O.interactions)


def test_dense_periodic_pack_to_soft_balls():
    """Under load as it comes from randomPeriPack; what it overlaps becomes stress."""
    pack.randomPeriPack(RADIUS, (0.09, 0.09, 0.09), seed=3, noPrint=True).toSimulation(
        material=FrictMat()
    )
    assert O.periodic and O.cell.size[0] < 0.085
    before = len(O.bodies)
    sg.soften(material=soft_material(massDamping=1000.0), zeta=0.5)
    O.engines = sg.engines()
    run(60)
    assert len(sg.soft_bodies()) == before > 20
    assert np.diag(sg.cell_stress()).max() < 0
    assert any(i.isReal and i.cellDist[0] != 0 for i in O.interactions)


@pytest.mark.parametrize("seed, fraction", ((1, 0.85), (2, 0.85), (3, 0.7)))
def test_pores_that_have_closed(seed, fraction, tmp_path):
    """Pressed to phi > 1.035 outlines have folds about what is left of the pores: no node before a
    fold is taken for one inside, and a loaded run goes on with the same bits. (Beyond that tips of
    folds pass nodes, at phi = 1.04 in one packing of five, and overlap by up to 1 dr.)"""
    set_cell(0.12, 0.12)
    cloud = pack.SpherePack()
    cloud.makeCloud(
        (0, 0, 0), (0.12, 0.12, 0), rMean=0.01, rRelFuzz=0.2, num=25, seed=seed, periodic=True
    )
    for i in cloud.toSimulation(material=FrictMat(frictionAngle=0)):
        O.bodies[i].state.blockedDOFs = "zXY"
    material = soft_material(young=1e6, poisson=0.4, frictionAngle=math.atan(0.2), massDamping=300)
    sg.soften(material=material, zeta=0.3)
    O.engines = sg.engines()
    sg.set_time_step(fraction)
    flow(xx=-3, yy=-3)
    while sg.packing_fraction() < 1.0325:
        run(100)
        assert O.iter < 6000
    assert_goes_on_after_loading(tmp_path / "scene.xml.gz", 400)
    assert sg.packing_fraction() > 1.035
    assert sg.integrator().largestOverlap < 0.05
