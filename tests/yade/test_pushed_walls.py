"""Walls that WallStressController has freed, once it pushes them no more."""

import pytest
from laboratory_scenes import STRESS, four_disks, insert_controller
from scenes import RADIUS, ready, run
from yade import FrictMat, O, ParallelEngine, utils

import softgrain as sg


def consolidated():
    """Four disks that walls have pressed together; the walls, and their controller."""
    walls = four_disks()
    ready()
    controller = insert_controller(walls, goal=(STRESS, STRESS, 0))
    O.run(2000, True)
    return walls, controller


def die(controller):
    controller.dead = True


def leave(controller):
    O.engines = [e for e in O.engines if not isinstance(e, sg.WallStressController)]


def make_engines_anew(controller):
    O.engines = sg.engines()


def save_and_leave(controller):
    O.saveTmp()
    O.loadTmp()
    leave(controller)


def die_and_begin_time_anew(controller):
    die(controller)
    O.resetTime()


ENDS = (die, leave, make_engines_anew, save_and_leave, die_and_begin_time_anew)


@pytest.mark.parametrize("end", ENDS)
def test_walls_stay_where_they_were_once_nothing_pushes_them(end):
    walls, controller = consolidated()
    places = [O.bodies[w].state.pos for w in walls]
    pressed = sg.wall_force(walls[3])[1]
    end(controller)
    run(200)
    assert [O.bodies[w].state.pos for w in walls] == places
    assert sg.wall_force(walls[3])[1] == pytest.approx(pressed, rel=0.02)
    assert "softgrain.pushedWalls" not in O.tags.keys()
    run(1)
    lid = O.bodies[walls[3]].state
    lid.vel = (0, -0.01, 0)
    before = O.time
    run(10)
    assert lid.pos[1] == pytest.approx(places[3][1] - 0.01 * (O.time - before), abs=1e-12)


@pytest.mark.parametrize("end", ENDS)
def test_wall_that_is_given_a_velocity_when_its_controller_goes(end):
    walls, controller = consolidated()
    end(controller)
    lid, side = (O.bodies[walls[k]].state for k in (3, 1))
    place, before = lid.pos[1], O.time
    lid.vel = (0, -0.02, 0)
    run(10)
    assert lid.pos[1] == pytest.approx(place - 0.02 * (O.time - before), abs=1e-12)
    assert side.vel == (0, 0, 0)


def test_wall_that_is_pushed_alone_is_the_user_s():
    """A free wall without a controller stays free."""
    walls = four_disks()
    lid = O.bodies[walls[3]].state
    lid.blockedDOFs, lid.mass = "xzXYZ", 0.1
    ready()
    O.forces.setPermF(walls[3], (0, -1, 0))
    run(50)
    assert lid.blockedDOFs == "xzXYZ"
    assert lid.vel[1] != 0


def test_controller_in_a_parallel_engine():
    walls = four_disks()
    ready()
    controller = insert_controller(walls, goal=(STRESS, STRESS, 0))
    O.engines = [ParallelEngine([e]) if e is controller else e for e in O.engines]
    assert any(isinstance(e, ParallelEngine) for e in O.engines)
    O.run(2000, True)
    assert controller.stress()[1] == pytest.approx(STRESS, rel=0.01)


def test_bodies_that_take_the_ids_of_pushed_walls():
    walls = four_disks()
    ready()
    insert_controller(walls, goal=(STRESS, STRESS, 0))
    run(10)
    O.engines = []
    O.bodies.clear()
    O.interactions.clear()
    material = FrictMat(density=1000)
    for k in range(9):
        O.bodies.append(utils.sphere((3 * k * RADIUS, 0, 0), RADIUS, material=material))
        O.bodies[k].state.blockedDOFs, O.bodies[k].state.vel = "zXY", (0, 1, 0)
    O.bodies.append(sg.soft_disk((0, 9 * RADIUS, 0), RADIUS, zeta=0.3))
    ready()
    run(3)
    assert all(O.bodies[k].state.vel == (0, 1, 0) for k in range(9))


def test_stress_of_a_controller_that_is_no_engine_of_the_scene():
    """Of the walls with these ids, whatever scene it acted in before."""
    walls, controller = consolidated()
    O.saveTmp()
    O.loadTmp()
    leave(controller)
    stress = controller.stress()
    assert stress[1] == pytest.approx(STRESS, rel=0.02)
    assert controller.strain()[1] < 0
