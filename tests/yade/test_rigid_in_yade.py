"""Contact dynamics of rigid bodies as a part of YADE: its tools, engines, saves and refusals."""

import warnings

import numpy as np
import pytest
import yade
from rigid_scenes import GRAVITY, R, add_sphere, material, pile, start, state
from scenes import (
    add,
    add_disk,
    add_wall,
    assert_done,
    assert_threads_change_nothing,
    ready,
    run,
    run_python,
)
from yade import (
    Bo1_Sphere_Aabb,
    Bo1_Wall_Aabb,
    ForceResetter,
    InsertionSortCollider,
    InteractionLoop,
    Ip2_FrictMat_FrictMat_FrictPhys,
    NewtonIntegrator,
    O,
    utils,
)

import softgrain as sg


def test_tools_of_yade_see_the_forces():
    """Love-Weber stress of a stack of two under its weight."""
    add_wall(0, 2)
    low, high = add_sphere((0, 0, R)), add_sphere((0, 0, 3 * R))
    start(1e-4)
    run(3000)
    weight = GRAVITY * low.state.mass
    stress = utils.getStress(1)
    branches = 2 * weight * R + weight * 2 * R  # of the wall's contact: to the centre
    assert stress[2, 2] == pytest.approx(-branches, rel=1e-3)
    contact = O.interactions[low.id, high.id]
    assert contact.phys.shearForce.norm() < 1e-9 * weight
    assert utils.unbalancedForce() < 1e-6


def add_free_box(place):
    body = utils.box(place, (R, R, R), material=material())
    body.state.blockedDOFs = ""
    return add(body)


def test_warning_of_boxes_that_fall_through_each_other():
    """Once there is something to fall through, members of clumps too; not of what is held."""
    sphere = add_sphere((0, 0, 9 * R))
    box = add_free_box((0, 0, 3 * R))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sg.engines()
        add_wall(0, 2)
        box.state.blockedDOFs = "xyzXYZ"
        sg.engines()
    box.state.blockedDOFs = ""
    with pytest.warns(UserWarning, match=f"#{box.id} is a Box that is free: no contact"):
        sg.engines()
    O.bodies.clump([sphere.id, box.id])
    with pytest.warns(UserWarning, match=f"#{box.id} is a Box that is free: no contact"):
        sg.engines(rigid="nonsmooth")


def test_no_warning_of_boxes_of_one_clump():
    O.bodies.clump([add_free_box((x * R, 0, 0)).id for x in (0, 1.5)])
    add_sphere((0, 0, 9 * R))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sg.engines()


def test_in_a_list_of_engines_of_ones_own():
    add_wall(0, 2)
    ball = add_sphere((0, 0, 1.5 * R))
    O.engines = [
        ForceResetter(),
        InsertionSortCollider([Bo1_Sphere_Aabb(aabbEnlargeFactor=1.05), Bo1_Wall_Aabb()]),
        InteractionLoop(
            [sg.Ig2_Wall_Sphere_ScGeom_Ahead()],
            [Ip2_FrictMat_FrictMat_FrictPhys()],
            [sg.Law2_ScGeom_FrictPhys_Nonsmooth()],
        ),
        sg.SoftGrainIntegrator(),
        NewtonIntegrator(gravity=(0, 0, -GRAVITY), damping=0),
    ]
    O.dt = 2e-4
    run(1000)
    assert ball.state.pos[2] == pytest.approx(R, abs=1e-6 * R)
    assert O.forces.f(ball.id)[2] == pytest.approx(GRAVITY * ball.state.mass, rel=1e-9)


def test_threads_change_nothing():
    """Of so many disks that they share sweeps: from 256 contacts in each colour on."""
    assert_threads_change_nothing(
        lambda: pile(dim=2, columns=200, layers=5), 400, read=lambda: {"states": state()}
    )


def test_goes_on_after_saving(tmp_path):
    pile(dim=2)
    run(1500)
    O.save(str(tmp_path / "scene.yade.bz2"))
    run(300)
    np.save(tmp_path / "expected.npy", state())
    code = """
        import softgrain as sg
        from yade import O
        O.load("scene.yade.bz2")
        from scenes import run
        from rigid_scenes import state
        import numpy as np
        run(300)
        np.testing.assert_array_equal(state(), np.load("expected.npy"))
        print("done")
    """
    assert_done(run_python(code, tmp_path))


def test_linear_law_is_as_before():
    """Without being asked rigid pairs keep YADE's law, and the integrator leaves them alone."""
    add_wall(0, 2)
    add_sphere((0, 0, 0.999 * R))
    O.engines = sg.engines()
    O.dt = 1e-5
    run(5)
    assert sg.integrator().steps == 0
    (contact,) = [i for i in O.interactions if i.isReal]
    assert contact.phys.normalForce.norm() > 0


def test_wrong_use_is_refused():
    with pytest.raises(ValueError, match="verlet_distance"):
        sg.engines(rigid="nonsmooth")
    with pytest.raises(ValueError, match="'linear', 'nonsmooth'"):
        sg.engines(verlet_distance=1e-3, rigid="hertz")
    add_wall(0, 2)
    add_sphere((0, 0, 1.01 * R))
    O.engines = sg.engines(rigid="nonsmooth")
    with pytest.raises(RuntimeError, match="O.dt is not set"):
        run(2)
    O.dt = 1e-4
    O.engines[-1].damping = 0.2
    with pytest.raises(RuntimeError, match="NewtonIntegrator.damping = 0.2"):
        run(2)


def test_shapes_derived_from_a_sphere_are_refused():
    """A functor for spheres is called for them, too, and would see a ball at their first node."""
    first, second = (utils.sphere((x * R, 0, 0), R, material=material()) for x in (0, 1.9))
    second.shape = yade.GridConnection(radius=R)
    O.bodies.append([first, second])
    O.engines = sg.engines(rigid="nonsmooth")
    O.dt = 1e-5
    with pytest.raises(RuntimeError, match="Sphere and GridConnection.*which is for"):
        run(2)


def test_out_of_plane_is_refused_in_2d():
    add_disk()
    add_sphere((3 * R, 0, 0), blocked="zXY")
    add_sphere((4.98 * R, 0, 0.3 * R), blocked="zXY")
    ready(rigid="nonsmooth")
    with pytest.raises(RuntimeError, match="out of the plane"):
        run(2)
