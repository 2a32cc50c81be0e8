"""Loading as in the laboratory: walls under stress, by softgrain's controller and YADE's."""

import numpy as np
import pytest
from laboratory_scenes import STRESS, eight_balls, four_disks, insert_controller
from motion import momentum
from neo_hookean import wave_speed
from scenes import DENSITY, RADIUS, YOUNG, add_disk, add_wall, damped_material, ready, run
from yade import (
    Box,
    O,
    ServoPIDController,
    TriaxialStressController,
    UniaxialStrainer,
)

import softgrain as sg


def wall_distance(walls, axis):
    low, high = (O.bodies[w] for w in walls[2 * axis : 2 * axis + 2])
    thickness = 2 * low.shape.extents[axis] if isinstance(low.shape, Box) else 0
    return high.state.pos[axis] - low.state.pos[axis] - thickness


def held_errors(controller, seconds, axes):
    """Largest relative errors of the stress along the axes during that time."""
    worst = np.zeros(len(axes))
    end = O.time + seconds
    while O.time < end:
        run(1)
        error = [controller.stress()[a] / controller.goal[a] - 1 for a in axes]
        worst = np.maximum(worst, np.abs(error))
    return worst


@pytest.mark.parametrize("gravity", (0, -10))
def test_stress_is_held_in_2d(gravity):
    """On both axes within 1 % at every step, weight of the walls or not; no axis needs tuning."""
    walls = four_disks()
    ready(gravity=(0, gravity, 0))
    controller = insert_controller(walls, goal=(STRESS, 2 * STRESS, 0))
    O.run(2000, True)
    weight = sum(b.state.mass for b in sg.soft_bodies()) * abs(gravity)
    allowed = 0.01 + weight / (2 * abs(STRESS) * wall_distance(walls, 0))
    assert (held_errors(controller, 0.01, (0, 1)) < allowed).all()
    assert controller.strain()[0] < 0 and controller.strain()[1] < controller.strain()[0] + 0.2
    # what stress() says is what the walls bear, over the length between the others
    pushed = -sg.wall_force(walls[3])[1] / wall_distance(walls, 0)
    assert pushed == pytest.approx(2 * STRESS, rel=0.01)
    # in equilibrium, what acts on a wall together is nothing
    assert abs(O.forces.f(walls[3])[1]) < 0.01 * abs(2 * STRESS) * wall_distance(walls, 0)


def test_stress_follows_its_goal():
    """Loading and unloading, while running."""
    walls = four_disks()
    ready()
    controller = insert_controller(walls, goal=(STRESS, STRESS, 0))
    O.run(2000, True)
    loaded = controller.strain()
    controller.goal = (STRESS, 0.5 * STRESS, 0)
    O.run(5000, True)
    assert (held_errors(controller, 0.005, (0, 1)) < 0.01).all()
    assert controller.strain()[1] > loaded[1]


def test_stress_is_held_in_3d():
    """Between Boxes, on three axes."""
    walls = eight_balls()
    ready()
    controller = insert_controller(walls, goal=(STRESS, STRESS, 1.5 * STRESS))
    O.run(2000, True)
    assert (held_errors(controller, 0.005, (0, 1, 2)) < 0.01).all()
    assert controller.strain()[2] < controller.strain()[0] < 0
    controller.walls = walls[:4]  # which it has not driven yet
    assert list(controller.strain()) == [0, 0, 0]


def test_triaxial_compression():
    """One axis by strain rate, stress on the others: both are held."""
    walls = eight_balls()
    ready()
    controller = insert_controller(walls, goal=(STRESS, STRESS, STRESS))
    O.run(2000, True)
    before, start, stress = controller.strain()[2], O.time, controller.stress()[2]
    controller.stressMask, controller.goal = 3, (STRESS, STRESS, -1)
    O.run(1000, True)
    assert controller.strain()[2] - before == pytest.approx(-(O.time - start), rel=1e-3)
    assert (held_errors(controller, 0.002, (0, 1)) < 0.025).all()
    assert controller.stress()[2] < 1.1 * stress


def test_controller_is_saved(tmp_path):
    """A run that was saved goes on with the same bits."""
    walls = four_disks()
    ready()
    insert_controller(walls, goal=(STRESS, STRESS, 0))
    O.run(300, True)
    O.save(str(tmp_path / "scene.xml.gz"))
    O.run(100, True)
    expected = [np.array(b.state.pos) for b in O.bodies]
    O.load(str(tmp_path / "scene.xml.gz"))
    O.run(100, True)
    np.testing.assert_array_equal([np.array(b.state.pos) for b in O.bodies], expected)


@pytest.mark.parametrize(
    "attributes, message",
    [
        ({"walls": [0, 1, 2]}, "number of walls = 3"),
        ({"stressMask": 8}, r"stressMask = 8 .*\[0, 7\]"),
        ({"drag": 0}, r"drag = 0 .*\(0, inf\)"),
        ({"goal": (1, 0, 0)}, "goal = 1 .*Pa where it is a stress"),
    ],
    ids=str,
)
def test_bad_controller(attributes, message):
    with pytest.raises(ValueError, match=message):
        sg.WallStressController(**attributes)


@pytest.mark.parametrize(
    "order, message",
    [((1, 0, 2, 3), "distance of two walls"), ((2, 3, 0, 1), "no Wall with axis = 0")],
)
def test_walls_in_a_wrong_order(order, message):
    walls = four_disks()
    ready()
    insert_controller([walls[k] for k in order], goal=(STRESS, STRESS, 0))
    with pytest.raises(ValueError, match=message):
        run(1)


def test_goal_along_an_axis_without_walls():
    walls = four_disks()
    ready()
    insert_controller(walls, goal=(STRESS, STRESS, STRESS))
    with pytest.raises(ValueError, match=r"goal\[2\] = .* 0 with four walls"):
        run(1)


@pytest.mark.parametrize("times", ("one twice", "two"))
def test_walls_that_are_pushed_twice_are_refused(times):
    """Their stresses would add up; one that is dead does not count."""
    walls = four_disks()
    ready()
    first = insert_controller(walls, goal=(STRESS, STRESS, 0))
    second = first if times == "one twice" else sg.WallStressController(walls=walls)
    O.engines = [second, *O.engines]
    with pytest.raises(RuntimeError, match=f"push body #{walls[0]} .*would add up"):
        run(1)
    O.engines = [e for e in O.engines if not isinstance(e, sg.WallStressController)]
    second = sg.WallStressController(walls=walls, goal=(STRESS, STRESS, 0), dead=True)
    sg.insert_before_solve(first, second)
    with pytest.raises(ValueError, match="is in O.engines already, and would act twice"):
        sg.insert_before_solve(first)
    run(1)


def test_free_wall():
    walls = four_disks()
    ready()
    O.bodies[walls[1]].state.blockedDOFs = "yzXYZ"  # free along its axis: as if pushed before
    O.bodies[walls[3]].state.blockedDOFs = ""
    insert_controller(walls, goal=(STRESS, STRESS, 0))
    with pytest.raises(ValueError, match=f"body #{walls[3]} is free"):
        run(1)


def test_wall_freed_by_hand_gets_a_mass():
    """Those of YADE have none, and would go to infinity."""
    walls = four_disks()
    ready()
    O.bodies[walls[1]].state.blockedDOFs = "yzXYZ"
    insert_controller(walls, goal=(STRESS, STRESS, 0))
    run(20)
    masses = [O.bodies[walls[k]].state.mass for k in (1, 3)]
    assert masses[0] == pytest.approx(masses[1], rel=0.1)
    assert 3 * RADIUS < O.bodies[walls[1]].state.pos[0] < 4 * RADIUS


def test_stress_without_soft_grains():
    """Walls would stand still in silence; prescribed rates need no grain."""
    walls = four_disks()
    ready()
    for body in sg.soft_bodies():
        O.bodies.erase(body.id)
    controller = insert_controller(walls, goal=(STRESS, STRESS, 0))
    with pytest.raises(RuntimeError, match="stressMask = 7.*there is no soft grain"):
        run(1)
    controller.stressMask = 0
    run(1)


def test_free_wall_keeps_momentum():
    """A wall that flies against a disk: one solve for both, momentum kept to rounding."""
    disk = add_disk()
    wall = add_wall(1.02 * RADIUS, axis=0, velocity=(-1, 0, 0))
    wall.state.blockedDOFs, wall.state.mass = "yzXYZ", 0.5
    ready()
    O.dt = 0.4 * sg.critical_time_step()
    touched = 0
    for _ in range(400):
        run(1)
        touched += sg.integrator().activeContacts > 0
        assert momentum()[0] == pytest.approx(-0.5, rel=1e-12)
    assert touched > 20 and sg.integrator().activeContacts == 0
    assert disk.state.vel[0] < wall.state.vel[0] < 0


def test_free_wall_rests_with_its_weight():
    add_disk(material=damped_material())
    add_wall(-RADIUS, axis=1)
    lid = add_wall(RADIUS, axis=1)
    lid.state.blockedDOFs, lid.state.mass = "xzXYZ", 0.5
    ready(gravity=(0, -10, 0))
    while O.time < 0.6:  # s, of which a swing of the lid takes 0.2
        O.run(1000, True)
    forces, heights = [], []
    for _ in range(6000):
        run(1)
        forces.append(sg.wall_force(lid.id)[1])
        heights.append(lid.state.pos[1])
    assert np.mean(forces) == pytest.approx(5, rel=2e-3)
    assert abs(np.mean(heights) - RADIUS) < 0.01 * RADIUS


def test_wall_that_turns_is_refused():
    add_disk()
    wall = add_wall(-RADIUS, axis=1)
    wall.state.blockedDOFs, wall.state.mass = "xz", 1
    ready()
    with pytest.raises(RuntimeError, match="#1 .Wall. .*free to turn, which a Wall cannot"):
        run(2)


def test_servo_holds_a_force():
    """YADE's ServoPIDController at the end of O.engines, with the impedance of the grains for its
    gain: within 0.3 % once it has settled."""
    walls = four_disks()
    target = -STRESS * 4 * RADIUS
    speed = wave_speed(YOUNG, 0.45, DENSITY)
    ready()
    O.engines = O.engines + [
        ServoPIDController(
            ids=[walls[3]],
            axis=(0, 1, 0),
            target=target,
            kP=1 / (1000 * speed * 4 * RADIUS),
            kI=0,
            kD=0,
            iterPeriod=1,
            maxVelocity=0.5,
        )
    ]
    O.run(7000, True)
    for _ in range(300):
        run(1)
        assert sg.wall_force(walls[3])[1] == pytest.approx(target, rel=0.003)


@pytest.mark.parametrize("thickness", (0.2 * RADIUS, 0), ids=("boxes", "walls"))
def test_triaxial_stress_controller(thickness):
    """YADE's own, without its memory of former ways; it sees the stiffness of contacts within a
    step, and no soft grain as dynamic. It holds the stress at every step."""
    walls = eight_balls(thickness)
    ready()
    names = ("left", "right", "bottom", "top", "back", "front")
    triax = TriaxialStressController(
        thickness=thickness,
        internalCompaction=False,
        stressMask=7,
        max_vel=0.5,
        stressDamping=0.8,
        **{f"goal{k}": STRESS for k in (1, 2, 3)},
        **{f"wall_{name}_id": wall for name, wall in zip(names, walls)},
    )
    O.engines = O.engines + [triax]
    O.run(3000, True)
    stresses = []
    for _ in range(600):
        run(1)
        stresses.append([triax.stress(2 * a + 1)[a] for a in range(3)])
    np.testing.assert_allclose(stresses, STRESS, rtol=0.01)
    assert min(i.phys.kn for i in O.interactions.withBody(walls[0])) > 0


def test_uniaxial_strainer():
    """Walls by a strain rate; its mean stress is that of the walls."""
    walls = four_disks()
    ready()
    strainer = UniaxialStrainer(
        strainRate=-5,
        axis=1,
        asymmetry=1,
        posIds=[walls[3]],
        negIds=[walls[2]],
        crossSectionArea=4 * RADIUS,
        blockDisplacements=True,
        blockRotations=True,
        setSpeeds=False,
        stressUpdateInterval=1,
        initAccelTime=0,
    )
    O.engines = O.engines + [strainer]
    start = wall_distance(walls, 1)
    O.run(1500, True)
    assert wall_distance(walls, 1) / start - 1 == pytest.approx(-5 * O.time, rel=0.01)
    mean = (sg.wall_force(walls[2])[1] - sg.wall_force(walls[3])[1]) / (2 * 4 * RADIUS)
    assert strainer.avgStress == pytest.approx(mean, rel=1e-9) and mean < 0.1 * STRESS


@pytest.mark.parametrize("change", ("drag", "mass of grains", "engines"))
def test_mass_of_a_wall_follows_what_it_is_made_of(change):
    """With the mass of before the explicit dashpot would throw the wall about."""
    walls = four_disks()
    ready()
    controller = insert_controller(walls, goal=(STRESS, STRESS, 0))
    O.run(3000, True)
    before = [O.bodies[w].state.mass for w in walls[1::2]]
    if change == "drag":
        controller.drag = 25
    elif change == "engines":
        O.engines = sg.engines()
        controller = insert_controller(walls, goal=(STRESS, STRESS, 0), drag=25)
    else:
        sg.scale_mass(25)
    O.run(1500, True)
    after = [O.bodies[w].state.mass for w in walls[1::2]]
    np.testing.assert_allclose(after, np.multiply(before, 25), rtol=0.05)
    np.testing.assert_allclose(list(controller.stress())[:2], STRESS, rtol=0.01)


def test_wall_too_light_for_its_dashpot_is_refused():
    walls = four_disks()
    ready()
    controller = insert_controller(walls, goal=(STRESS, STRESS, 0))
    O.run(200, True)
    lid = O.bodies[walls[3]].state
    usual = lid.mass
    lid.mass = 2 * usual
    run(5)
    assert lid.mass == 2 * usual  # the user's
    lid.mass = 1e-3 * usual
    with pytest.raises(RuntimeError, match=f"#{walls[3]}, state.mass = .*too light.*admissible"):
        run(1)
    assert controller.drag == 1


def test_controller_used_again_in_another_scene():
    """Its strain is that of the present scene."""
    walls = four_disks()
    ready()
    controller = insert_controller(walls, goal=(-1, -1, 0), stressMask=0)
    run(50)
    engines = O.engines
    O.reset()
    four_disks()  # with the same ids
    for k in (1, 3):
        O.bodies[walls[k]].state.pos *= 2
    O.engines = engines
    run(50)
    assert -1e-2 < controller.strain()[0] < 0
