"""What YADE offers and softgrain does not: each is refused with a message of its own."""

import math
import subprocess

import pytest
from scenes import RADIUS, YADE, add_disk, add_wall, ready, run, soft_material
from yade import (
    FrictMat,
    GlobalStiffnessTimeStepper,
    DragEngine,
    ForceResetter,
    HydroForceEngine,
    LinearDragEngine,
    O,
    PeriTriaxController,
    RungeKuttaCashKarp54Integrator,
    TriaxialStressController,
    utils,
)
import yade
from yade.gridpfacet import gridConnection, gridNode

import softgrain as sg


def add_engine(engine, place=1):
    engines = list(O.engines)
    O.engines = engines[:place] + [engine] + engines[place:]


def without_functor(dispatcher, name):
    loop = O.engines[2]
    part = getattr(loop, dispatcher)
    part.functors = [f for f in part.functors if type(f).__name__ != name]


def other_collider():
    engines = list(O.engines)
    engines[1] = yade.SpatialQuickSortCollider(engines[1].boundDispatcher.functors)
    O.engines = engines


def no_collider():
    O.engines = [e for e in O.engines if not isinstance(e, yade.InsertionSortCollider)]


def soft_clump():
    other = sg.soft_disk((5 * RADIUS, 0, 0), RADIUS, soft_material(), zeta=0.3)
    O.bodies.append(other)
    O.bodies.clump([0, other.id])


def dofs_left_to_newton():
    O.bodies[0].state.blockedDOFs = "zXY"


def soft_material_on_a_sphere():
    O.bodies.append(utils.sphere((5 * RADIUS, 0, 0), RADIUS, material=soft_material()))


def rigid_material_on_a_grain():
    O.bodies[0].material = FrictMat()


def subdomains():
    O.bodies[0].subdomain = 1


def near(body):
    """Another shape within the box of the grain."""
    O.bodies.append(body)


def grid_node():
    body = utils.sphere((0, 0, 0), RADIUS, fixed=True)
    body.shape = yade.GridNode(radius=0.1 * RADIUS)
    near(body)


def cylinder():
    body = utils.sphere((0, 0, 0), RADIUS, fixed=True)
    body.shape = yade.Cylinder(radius=0.1 * RADIUS, length=RADIUS, segment=(RADIUS, 0, 0))
    near(body)
    O.engines[1].boundDispatcher.functors += [yade.Bo1_Cylinder_Aabb()]


def tetra():
    body = utils.tetra([(0, 0, 0), (RADIUS, 0, 0), (0, RADIUS, 0), (0, 0, RADIUS)], fixed=True)
    near(body)
    O.engines[1].boundDispatcher.functors += [yade.Bo1_Tetra_Aabb()]


def tetra_without_bound():
    near(utils.tetra([(0, 0, 0), (RADIUS, 0, 0), (0, RADIUS, 0), (0, 0, RADIUS)], fixed=True))


def grid_connection():
    nodes = [O.bodies.append(gridNode((x * RADIUS, 3 * RADIUS, 0), 0.1)) for x in (-1, 1)]
    O.bodies.append(gridConnection(*nodes, 0.1 * RADIUS))


def free_damped_sphere():
    body = utils.sphere((1.5 * RADIUS, 0, 0), 0.51 * RADIUS, material=FrictMat())
    body.state.blockedDOFs = "zXY"
    O.bodies.append(body)
    O.engines[-1].damping = 0.2


def free_turning_wall():
    wall = add_wall(-RADIUS, axis=1)
    wall.state.blockedDOFs, wall.state.mass = "xz", 1


def massless_wall():
    add_wall(-RADIUS, axis=1).state.blockedDOFs = "xzXYZ"


def endless_wall():
    wall = add_wall(-RADIUS, axis=1)
    wall.state.blockedDOFs, wall.state.mass = "xzXYZ", math.inf


def gravity_across():
    O.engines[-1].gravity = (0, 0, -9.81)


def out_of_plane():
    body = sg.soft_disk((0, 0, RADIUS), RADIUS, soft_material(), zeta=0.3)
    O.bodies.append(body)


def two_and_three_dimensions():
    O.bodies.append(sg.soft_sphere((5 * RADIUS, 0, 0), RADIUS, soft_material(), zeta=0.5))


def two_integrators():
    add_engine(sg.SoftGrainIntegrator(), place=3)


def no_resetter():
    O.engines = list(O.engines)[1:]


def dead_resetter():
    O.engines[0].dead = True


def resetter_behind():
    engines = list(O.engines)
    O.engines = engines[1:] + engines[:1]


def resetter_between():
    add_engine(ForceResetter(), place=4)


def force_before_resetter():
    add_engine(yade.ForceEngine(ids=[0], force=(1, 0, 0)), place=0)


def controller_before_resetter():
    sides = [(axis, side) for axis in (0, 1) for side in (-1, 1)]
    walls = [add_wall(side * RADIUS, axis, sense=-side).id for axis, side in sides]
    add_engine(sg.WallStressController(walls=walls), place=0)


def force_behind():
    add_engine(yade.ForceEngine(ids=[7, 0], force=(1, 0, 0)), place=4)


def softener_behind():
    add_engine(sg.SoftenWhenLoaded(), place=4)


def dead_collider():
    O.engines[1].dead = True


def resetter_behind_loop():
    engines = list(O.engines)
    O.engines = [*engines[1:3], engines[0], *engines[3:]]


def dead_loop():
    O.engines[2].dead = True


def loop_behind():
    engines = list(O.engines)
    O.engines = engines[:2] + engines[3:] + [engines[2]]


def wall_in_the_plane():
    add_wall(0, axis=2)


def controller_behind():
    walls = [add_wall(x * RADIUS, axis=axis).id for axis in (0, 1) for x in (-2, 2)]
    add_engine(sg.WallStressController(walls=walls, goal=(-1, -1, 0)), place=4)


def stepper_behind():
    add_engine(GlobalStiffnessTimeStepper(), place=4)


REFUSED = [
    (soft_clump, "soft grain in a clump"),
    (subdomains, "MPI subdomains: .*-jN"),
    (dofs_left_to_newton, "blockedDOFs = '.*'; admissible: 'xyzXYZ'"),
    (soft_material_on_a_sphere, "material SoftMat but the rigid shape Sphere"),
    (rigid_material_on_a_grain, "soft shape SoftGrain but the material FrictMat"),
    (grid_node, r"of shape GridNode\. Soft grains touch"),
    (cylinder, r"of shape Cylinder\. Soft grains touch"),
    (tetra, r"of shape Tetra\. Soft grains touch"),
    (tetra_without_bound, "#1 of shape Tetra: no functor of the collider bounds it"),
    (grid_connection, "#3 of shape GridConnection: .* as a Sphere.* add Bo1_GridConnection_Aabb"),
    (free_damped_sphere, "NewtonIntegrator.damping = 0.2"),
    (free_turning_wall, "free to turn, which a Wall cannot"),
    (massless_wall, r"state.mass = 0.*admissible range \(0, inf\) kg"),
    (endless_wall, r"state.mass = inf.*admissible range \(0, inf\) kg"),
    (gravity_across, r"NewtonIntegrator.gravity\[2\] = -9.81 .*admissible range 0 m/s\^2: 2D"),
    (out_of_plane, "must lie in one plane z = const"),
    (two_and_three_dimensions, "dim"),
    (two_integrators, "two SoftGrainIntegrators"),
    (stepper_behind, "GlobalStiffnessTimeStepper stands after SoftGrainIntegrator"),
    (controller_behind, "WallStressController stands after SoftGrainIntegrator"),
    (no_resetter, "no ForceResetter before it in O.engines that is not dead"),
    (dead_resetter, "no ForceResetter before it .* that is not dead: contact forces"),
    (resetter_behind, "no ForceResetter before it .* would act again as loads"),
    (force_before_resetter, "ForceEngine stands before ForceResetter"),
    (controller_before_resetter, "WallStressController stands before ForceResetter"),
    (force_behind, "ForceEngine pushes soft grain #0, but stands after SoftGrainIntegrator"),
    (softener_behind, "SoftenWhenLoaded stands after SoftGrainIntegrator"),
    (dead_collider, "no collider before it in O.engines that is not dead"),
    (resetter_behind_loop, "a ForceResetter stands between InteractionLoop and SoftGrainInteg"),
    (resetter_between, "a ForceResetter stands between .* reactions on rigid bodies"),
    (dead_loop, "no InteractionLoop before it in O.engines that is not dead"),
    (loop_behind, "no InteractionLoop before it"),
    (wall_in_the_plane, "#0: a Wall of axis = 2 lies in the plane"),
    (no_collider, "no collider before it in O.engines"),
    (other_collider, "SpatialQuickSortCollider: .*InsertionSortCollider"),
    (lambda: add_engine(TriaxialStressController(), 4), "internalCompaction = True: soft grains"),
    (lambda: add_engine(PeriTriaxController(dynCell=True, mass=0), 4), r"mass = 0.0+: YADE would"),
    (lambda: add_engine(PeriTriaxController(doneHook="stop()"), 4), r"doneHook = 'stop\(\)': it"),
    (
        lambda: add_engine(PeriTriaxController(stressMask=3), 4),
        r"dynCell = False with stressMask = 3: it.*set dynCell = True",
    ),
    (lambda: add_engine(RungeKuttaCashKarp54Integrator()), "RungeKuttaCashKarp54Integrator: it"),
    (lambda: add_engine(HydroForceEngine()), "HydroForceEngine: it knows spheres only"),
    (lambda: add_engine(DragEngine()), "DragEngine: it knows spheres only"),
    (lambda: add_engine(LinearDragEngine()), "LinearDragEngine: it knows spheres only"),
    (
        lambda: without_functor("lawDispatcher", "Law2_SoftGeom_SoftPhys_Nonsmooth"),
        "has no Law2_SoftGeom_SoftPhys_Nonsmooth",
    ),
    (
        lambda: without_functor("physDispatcher", "Ip2_SoftMat_SoftMat_SoftPhys"),
        "has no Ip2_SoftMat_SoftMat_SoftPhys",
    ),
    (
        lambda: without_functor("physDispatcher", "Ip2_FrictMat_SoftMat_SoftPhys"),
        "has no Ip2_FrictMat_SoftMat_SoftPhys",
    ),
]


@pytest.mark.parametrize("change, message", REFUSED, ids=[message for _, message in REFUSED])
def test_refused(change, message):
    """Before the first step, in which nothing happens then."""
    disk = add_disk()
    ready()
    change()
    before = disk.state.pos
    with pytest.raises((RuntimeError, ValueError), match=message):
        run(2)
    assert disk.state.pos == before


def test_collider_that_dies():
    """Bodies have their boxes by then."""
    add_disk()
    ready()
    run(1)
    dead_collider()
    with pytest.raises(RuntimeError, match="no collider before it .* that is not dead"):
        run(1)


def test_engines_that_are_dead_may_be_there_twice():
    disk = add_disk()
    ready()
    two_integrators()
    O.engines[3].dead = True
    disk.state.vel = (1, 0, 0)
    run(3)
    assert sg.integrator().steps == 3 and disk.state.pos[0] > 0


def test_bodies_that_nothing_is_to_touch():
    add_disk()
    ready()
    tetra_without_bound()
    O.bodies[1].bounded = False
    O.bodies.appendClumped([utils.sphere((5 * RADIUS, x * RADIUS, 0), RADIUS) for x in (0, 1)])
    run(2)


@pytest.mark.parametrize("name", ("FlowEngine", "PeriodicFlowEngine", "TwoPhaseFlowEngine"))
def test_engines_that_some_builds_lack(name):
    if not hasattr(yade, name):
        pytest.skip(f"this YADE was built without {name}")
    add_disk()
    ready()
    add_engine(getattr(yade, name)())
    with pytest.raises(RuntimeError, match=f"{name}: it knows spheres only"):
        run(1)


@pytest.mark.parametrize("young, smaller", ((1e12, True), (1e-3, False)))
def test_time_stepper_of_rigid_bodies(young, smaller):
    """Not refused: the smaller one of both steps is taken."""
    add_disk()
    ready()
    own = O.dt
    material = FrictMat(young=young, density=1000)
    for x in (0, 1.99):
        O.bodies.append(utils.sphere((x * RADIUS, 9 * RADIUS, 0), RADIUS, material=material))
    add_engine(GlobalStiffnessTimeStepper(timeStepUpdateInterval=1), place=3)
    run(5)
    assert (0 < O.dt < 0.05 * own) if smaller else O.dt == own


SCENE = """
import softgrain as sg
O.bodies.append([sg.soft_disk((3 * k, 0, 0), 1, sg.SoftMat(), zeta=0.3) for k in range(3)])
O.engines = [e for e in sg.engines() if not isinstance(e, {left_out})]
O.run(2, True)
"""


@pytest.mark.parametrize("left_out, times", (("sg.SoftGrainIntegrator", 1), ("()", 0)))
def test_grains_that_nobody_moves(tmp_path, left_out, times):
    """Said, not refused: a scene may be looked at before its engines are complete."""
    script = tmp_path / "idle.py"
    script.write_text(SCENE.format(left_out=left_out))
    process = subprocess.run(
        [YADE, "-n", "-x", str(script)], capture_output=True, text=True, timeout=300
    )
    assert process.returncode == 0
    message = "no SoftGrainIntegrator in O.engines, which computes soft grains"
    assert process.stderr.count(message) == times


def test_a_controller_that_is_dead_may_stand_anywhere():
    add_disk()
    ready()
    controller_behind()
    O.engines[4].dead = True
    run(1)
