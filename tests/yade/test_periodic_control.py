"""YADE's controllers of a periodic cell around soft grains."""

import numpy as np
import pytest
from periodic_scenes import DIAMETER, irregular_packing
from scenes import DENSITY, RADIUS, YOUNG, ready, run, soft_material
from yade import FrictMat, O, Peri3dController, PeriTriaxController, pack, utils

import softgrain as sg


@pytest.mark.parametrize("mass", (3, 0.03))
def test_stress_control_by_yade(mass):
    """PeriTriaxController with the mass of the cell holds the target within 1 %."""
    irregular_packing(massDamping=400.0)
    ready()
    target = -0.05 * YOUNG
    control = PeriTriaxController(
        goal=(target, target, 0),
        stressMask=3,
        dynCell=True,
        mass=mass * DENSITY * (3 * DIAMETER) ** 2,
        growDamping=0.5,
        maxStrainRate=(5, 5, 0),
    )
    sg.insert_before_solve(control)
    run(6000)
    stresses = []
    for _ in range(300):
        O.step()
        stresses.append(np.diag(np.array(utils.getStress()))[:2])
    np.testing.assert_allclose(stresses, target, rtol=0.01)
    assert np.abs(np.array(O.cell.velGrad)).max() < 0.05


#: YADE reads the second point of the path of each strain, also where a path has one: without a
#: second one the controller may, as memory happens to be, stand still at strains of zero.
AT_ZERO = ((0.5, 0), (1, 0))


@pytest.mark.parametrize("dim", (2, 3))
def test_full_stress_and_strain_control_by_yade(dim):
    """Peri3dController: stresses follow their way to the goal within 0.5 % (rms), strains keep to
    theirs. In 2D both normal stresses and the shear strain, in 3D all normal stresses.
    """
    stress = -0.05 * YOUNG
    if dim == 2:
        irregular_packing(massDamping=400.0)
        goal, mask, steps = (stress, stress, 0, 0, 0, 0.05), 0b011, 2000
        paths = dict(zzPath=AT_ZERO, yzPath=AT_ZERO, zxPath=AT_ZERO)
    else:
        pack.randomPeriPack(RADIUS, (0.09, 0.09, 0.09), seed=3, noPrint=True).toSimulation(
            material=FrictMat()
        )
        sg.soften(material=soft_material(massDamping=1000.0, frictionAngle=0.3), zeta=0.5)
        goal, mask, steps = (stress, stress, stress, 0, 0, 0), 0b111, 1500
        paths = dict(yzPath=AT_ZERO, zxPath=AT_ZERO, xyPath=AT_ZERO)
    ready()
    control = Peri3dController(
        goal=goal,
        stressMask=mask,
        nSteps=steps,
        youngEstimation=0.3 * YOUNG,
        maxStrainRate=5,
        doneHook="pass",
        **paths,
    )
    sg.insert_before_solve(control)
    errors = []
    while control.progress < 1:
        O.step()
        assert O.iter < 2 * steps
        if control.progress > 0.5:
            found, wanted = np.array(control.stress), np.array(control.stressIdeal)
            errors.append((found - wanted)[:dim] / stress)
    errors = np.array(errors)
    rms, largest = np.sqrt((errors**2).mean()), np.abs(errors).max()
    print(f"Peri3dController, {dim}D: error of the stresses {rms:.2e} rms, {largest:.2e} at most")
    assert rms < 0.005 and largest < 0.03
    strain = np.array(O.cell.trsf) - np.eye(3)
    assert strain[0, 1] + strain[1, 0] == pytest.approx(goal[5], rel=0.1, abs=1e-9)
    if dim == 2:
        assert strain[2, 2] == pytest.approx(0, abs=1e-12)
