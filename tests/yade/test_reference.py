"""The kernel inside YADE against the oracle in numpy: the same scene, step by step."""

import math
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
import pytest

import softgrain as sg
from softgrain import reference
from yade import FrictMat, Matrix3, O, SoftMat, utils

STEPS = 40
TOLERANCE = 1e-10

RADII = (0.010, 0.008)  # m
OBLIQUE = ((0.0, 0.0), (0.0126, 0.0126))  # centres [m]; overlapping by 0.02 R, to be worked off
HEAD_ON = ((0.0, 0.0), (0.01805, 0.0))
VELOCITIES = ((2.0, 1.0), (-3.0, 0.5))  # m/s
SPINS = (150.0, 100.0)  # 1/s
SPEED = 3.0  # m/s, the speed of the scene
# axis, coordinate [m], velocity [m/s] and coefficient of friction of the walls
BOTTOM = (1, -0.0098, (0.5, 2.0), 0.15)  # overlaps the first grain by 0.02 R
TOP = (1, 0.0207, (-0.5, -2.0), 0.6)
SIDE = (0, -0.0098, (1.0, 0.2), 0.3)
DT_FRACTION = 0.3


@dataclass(frozen=True)
class Case:
    """What differs from scene to scene."""

    condition: str = "planeStrain"
    contact: str = "surface"
    order: int = 3
    quadrature: str = "cutCell"
    zeta: tuple = (0.3, 0.25)  # unequal: two batches, the second grain comes first in the kernel
    node_spacing: float = 1.25
    surface_spacing: float = 1.0
    volumetric: str = "pointwise"
    centres: tuple = OBLIQUE
    walls: tuple = (BOTTOM, TOP)
    gravity: float = 0.0  # m/s^2
    friction: float = 0.3
    formulation: str = "total"
    velocity_update: str = "nodal"
    pic_share: float = 0.0
    mass_damping: float = 0.0  # 1/s
    stiffness_damping: float = 0.0  # s
    rates: tuple = (1, 1)  # steps between computations of the forces, as the plugin finds them
    cell: tuple = ()  # base vectors of a periodic cell as columns [m]
    flow: tuple = ((0.0, 0.0), (0.0, 0.0))  # its velocity gradient [1/s]
    interface: tuple = ()  # cohesion [Pa], its range [m], dynamic friction [-]

    @property
    def recipes(self):
        return [
            reference.Recipe(
                zeta,
                order=self.order,
                node_spacing=self.node_spacing,
                surface_spacing=self.surface_spacing,
                quadrature=self.quadrature,
                contact=self.contact,
                volumetric=self.volumetric,
            )
            for zeta in self.zeta
        ]

    @property
    def materials(self):
        angle = math.atan(self.friction)
        damping = self.mass_damping, self.stiffness_damping
        return [
            reference.Material(1e6, 0.45, 1000.0, angle, self.condition, *damping),
            reference.Material(3e6, 0.3, 1500.0, 1.5 * angle, self.condition, *damping),
        ]

    @property
    def kernel_order(self):
        """Ids of the grains by their index in the kernel: batches by recipe, ids within."""
        return sorted((0, 1), key=lambda g: (self.zeta[g], g))


#: Columns of a sheared cell; the second grain of OBLIQUE as seen across two of its borders.
CELL = ((0.05, 0.004), (0.0, 0.05))
ACROSS = ((0.0, 0.0), (0.0126 - 0.054, 0.0126 - 0.05))
FLOW = ((-20.0, 30.0), (5.0, 10.0))
COHESION = (2e4, 3e-4, 0.1)

#: What the contacts of a case are known to do.
EVERYTHING = {"sticking", "sliding", "wall", "grain", "capped overlap", "overlap", "closing gap"}

CASES = {
    "surface": Case(),
    "points": Case(contact="points", zeta=(0.25, 0.25)),
    "plane stress, quadratic": Case("planeStress", order=2, zeta=(0.25, 0.25), gravity=-3000.0),
    "linear, lattice": Case(order=1, quadrature="lattice", zeta=(0.25, 0.25)),
    "projected": Case(volumetric="projected", zeta=(0.25, 0.25)),
    # a grain between two walls: their order counts in the sweeps, whichever was met first, where
    # the grid is so coarse that their contacts share nodes
    "corner": Case(node_spacing=2.0, walls=(SIDE, BOTTOM, TOP)),
    # the outline bulges out of the box of its nodes
    "sparse outline": Case(surface_spacing=2.8, zeta=(0.25, 0.25), centres=HEAD_ON),
    "damped": Case(mass_damping=3000.0, stiffness_damping=1e-5),
    "damped, plane stress": Case("planeStress", stiffness_damping=1e-5),
    "damped, projected": Case(
        volumetric="projected", zeta=(0.25, 0.25), mass_damping=3000.0, stiffness_damping=1e-5
    ),
    "multirate": Case(zeta=(0.45, 0.12), rates=(3, 1)),
    "multirate, damped": Case(
        zeta=(0.45, 0.12), rates=(3, 1), mass_damping=3000.0, stiffness_damping=1e-6
    ),
    "periodic": Case(cell=CELL, centres=ACROSS, flow=FLOW, walls=()),
    "periodic, points": Case(
        cell=CELL, centres=ACROSS, flow=FLOW, walls=(), contact="points", zeta=(0.25, 0.25)
    ),
    "cohesion, two coefficients of friction": Case(interface=COHESION),
    "periodic, cohesion": Case(cell=CELL, centres=ACROSS, flow=FLOW, walls=(), interface=COHESION),
    "flip": Case(velocity_update="flip"),
    "flip with a share of PIC, points": Case(
        contact="points", zeta=(0.25, 0.25), velocity_update="flip", pic_share=0.1, gravity=-3000.0
    ),
    "updated": Case(formulation="updated"),
    "updated with a share of PIC, plane stress, quadratic, points": Case(
        "planeStress",
        contact="points",
        order=2,
        zeta=(0.25, 0.25),
        gravity=-3000.0,
        formulation="updated",
        pic_share=0.1,
    ),
}


@dataclass
class Snapshot:
    """State after a step; lists by the grain's place in the kernel."""

    positions: list
    velocities: list
    impulses: dict  # (pair, side, node): impulse on the node [N s]
    overlap: float  # deepest, over the mean point spacing
    sweeps: float


def padded(vector):
    return (*vector, 0)


# --- inside YADE --------------------------------------------------------------------------------


def build_in_yade(case):
    O.reset()
    for g, recipe in enumerate(case.recipes):
        m = case.materials[g]
        material = SoftMat(
            young=m.young,
            poisson=m.poisson,
            density=m.density,
            frictionAngle=m.friction_angle,
            condition=m.condition,
            massDamping=m.mass_damping,
            stiffnessDamping=m.stiffness_damping,
        )
        disk = sg.soft_disk(
            padded(case.centres[g]),
            RADII[g],
            material,
            zeta=recipe.zeta,
            order=recipe.order,
            nodeSpacing=recipe.node_spacing,
            surfaceSpacing=recipe.surface_spacing,
            quadrature=recipe.quadrature,
            contact=recipe.contact,
            volumetric=recipe.volumetric,
            formulation=case.formulation,
            velocityUpdate=case.velocity_update,
            picShare=case.pic_share,
        )
        disk.state.vel, disk.state.angVel = padded(VELOCITIES[g]), (0, 0, SPINS[g])
        O.bodies.append(disk)
    for axis, coordinate, velocity, friction in case.walls:
        material = FrictMat(frictionAngle=math.atan(friction))
        wall = utils.wall(coordinate, axis=axis, material=material)
        wall.state.vel = padded(velocity)
        O.bodies.append(wall)
    # the oracle moves nodes, also of grains that could move as rigid bodies
    multirate = max(case.rates) > 1
    interface = {}
    if case.interface:
        cohesion, reach, friction = case.interface
        interface = {
            "cohesion": cohesion,
            "cohesionRange": reach,
            "dynamicFrictAngle": math.atan(friction),
        }
    if case.cell:
        (ax, bx), (ay, by) = case.cell
        (xx, xy), (yx, yy) = case.flow
        O.periodic = True
        O.cell.hSize = Matrix3(ax, bx, 0, ay, by, 0, 0, 0, 1)
        O.cell.velGrad = Matrix3(xx, xy, 0, yx, yy, 0, 0, 0, 0)
    O.engines = sg.engines(
        gravity=(0, case.gravity, 0), rigidMotion=False, multirate=multirate, interface=interface
    )
    O.dt = DT_FRACTION * sg.critical_time_step()


def pair_in_yade(interaction, case):
    """Pair of an interaction as the oracle names it."""
    order = case.kernel_order
    grains = [i for i in (interaction.id1, interaction.id2) if i < len(order)]
    walls = [i - len(order) for i in (interaction.id1, interaction.id2) if i >= len(order)]
    return tuple(sorted(order.index(i) for i in grains)) + tuple(-1 - w for w in walls)


def impulses_in_yade(case):
    found = {}
    for interaction in O.interactions:
        arrays = interaction.geom.contacts()
        pair = pair_in_yade(interaction, case)
        for side, node, impulse in zip(arrays["side"], arrays["node"], arrays["impulse"]):
            found[pair, side, node] = found.get((pair, side, node), 0) + impulse[:2]
    return found


@lru_cache(maxsize=None)
def run_in_yade(name):
    """Time step and snapshots after every step."""
    case = CASES[name]
    build_in_yade(case)
    snapshots = []
    for _ in range(STEPS):
        O.step()
        shapes = [O.bodies[i].shape for i in case.kernel_order]
        snapshots.append(
            Snapshot(
                [shape.nodes() for shape in shapes],
                [shape.nodeVelocities() for shape in shapes],
                impulses_in_yade(case),
                sg.integrator().overlap,
                sg.integrator().sweeps,
            )
        )
    assert set(sg.integrator().rates()) == set(case.rates)
    return O.dt, snapshots


# --- the oracle ---------------------------------------------------------------------------------


def build_oracle(case):
    if case.formulation == "updated":
        make, method = reference.UpdatedGrain, {}
    else:
        make, method = reference.Grain, {"flip": case.velocity_update == "flip"}
    grains = [
        make(
            case.recipes[g],
            case.materials[g],
            RADII[g],
            case.centres[g],
            VELOCITIES[g],
            SPINS[g],
            pic_share=case.pic_share,
            **method
        )
        for g in case.kernel_order
    ]
    for grain, g in zip(grains, case.kernel_order):
        grain.rate = case.rates[g]
    walls = []
    for axis, coordinate, velocity, friction in case.walls:
        position = np.zeros(2)
        position[axis] = coordinate
        walls.append(reference.Wall(axis, position, np.array(velocity), math.atan(friction)))
    slowest_wave = min(grain.material.wave_speed for grain in grains)
    settings = reference.SolverSettings(overlap_speed=1e-3 * slowest_wave)
    system = reference.System(grains, walls, settings, np.array([0, case.gravity]))
    if case.cell:
        system.cell = reference.Cell(np.array(case.cell), np.array(case.flow))
    if case.interface:
        system.interface = reference.Interface(*case.interface)
    return system


def impulses_of_oracle(system):
    found = {}
    for pair, c in system.contacts:
        found[pair, c.side, c.node] = found.get((pair, c.side, c.node), 0) + c.impulse + c.pull
    return found


def run_oracle(system, dt, steps):
    snapshots = []
    for _ in range(steps):
        report = system.step(dt)
        snapshots.append(
            Snapshot(
                [grain.state[0] for grain in system.grains],
                [grain.state[1] for grain in system.grains],
                impulses_of_oracle(system),
                system.deepest_overlap(),
                report.sweeps,
            )
        )
    return snapshots


def events(system, dt):
    """What the contacts of the last step did."""
    settings, seen = system.settings, set()
    for pair, c in system.contacts:
        if c.pull.any():
            seen.add("cohesion")
        normal = c.impulse @ c.normal
        if normal == 0:
            continue
        seen.add("sliding" if c.slid else "sticking")
        seen.add("wall" if pair[1] < 0 else "grain")
        if c.gap >= 0:
            seen.add("closing gap")
        elif -settings.overlap_relaxation * c.gap > settings.overlap_speed * dt:
            seen.add("capped overlap")
        else:
            seen.add("overlap")
    return seen


# --- comparison ---------------------------------------------------------------------------------


def deviations(case, found, expected):
    """Largest deviations of two snapshots.

    Positions over the radius, velocities over the speed of the scene, impulses over the largest
    one; overlaps and sweeps as they are.
    """
    radii = [RADII[g] for g in case.kernel_order]
    return {
        "positions": max(
            np.abs(x - y).max() / R for x, y, R in zip(found.positions, expected.positions, radii)
        ),
        "velocities": max(
            np.abs(v - w).max() / SPEED for v, w in zip(found.velocities, expected.velocities)
        ),
        "impulses": impulse_deviation(found.impulses, expected.impulses),
        "overlap": abs(found.overlap - expected.overlap),
        "sweeps": abs(found.sweeps - expected.sweeps),
    }


def impulse_deviation(found, expected):
    """A contact that one side does not list has no impulse there."""
    nothing = np.zeros(2)
    largest = max([np.abs(r).max() for r in expected.values()], default=0) or 1.0
    return max(
        [
            np.abs(found.get(k, nothing) - expected.get(k, nothing)).max() / largest
            for k in found.keys() | expected.keys()
        ],
        default=0.0,
    )


def largest_deviations(case, found, expected):
    steps = [deviations(case, f, e) for f, e in zip(found, expected)]
    return {key: max(step[key] for step in steps) for key in steps[0]}


# --- tests --------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", CASES)
def test_kernel_does_the_same_as_the_oracle(name):
    """Positions, velocities, impulses and sweeps agree in every step."""
    dt, found = run_in_yade(name)
    system = build_oracle(CASES[name])
    expected, seen = [], set()
    for _ in range(STEPS):
        expected += run_oracle(system, dt, steps=1)
        seen |= events(system, dt)
    largest = largest_deviations(CASES[name], found, expected)
    assert max(largest.values()) < TOLERANCE, largest
    case = CASES[name]
    assert ("cohesion" in seen) == bool(case.interface)
    if case.centres == OBLIQUE:
        assert seen >= EVERYTHING
    if case.cell:
        assert seen >= {"sticking", "sliding", "grain", "overlap"}


def damped(system):
    for grain in system.grains:
        grain.material = replace(grain.material, mass_damping=1e-2)


def viscous(system):
    for grain in system.grains:
        grain.material = replace(grain.material, stiffness_damping=1e-10)


def stiffer(system):
    for grain in system.grains:
        grain.material = replace(grain.material, young=1.0001 * grain.material.young)


def rougher(system):
    for grain in system.grains:
        angle = 1.001 * grain.material.friction_angle
        grain.material = replace(grain.material, friction_angle=angle)


def faster_walls(system):
    for wall in system.walls:
        wall.velocity = 1.001 * wall.velocity


def more_relaxation(system):
    system.settings.overlap_relaxation *= 1.01


def higher_overlap_speed(system):
    system.settings.overlap_speed *= 1.01


def smaller_tolerance(system):
    system.settings.tolerance *= 0.5


def cold_start(system):
    find = system.find_contacts

    def find_anew(dt):
        system.contacts = []
        find(dt)

    system.find_contacts = find_anew


def walls_in_reverse(system):
    find = system.find_contacts

    def find_and_reverse(dt):
        find(dt)
        system.contacts.sort(key=lambda entry: (entry[0][0], entry[0][1] >= 0, entry[0][1]))

    system.find_contacts = find_and_reverse


CHANGES = (
    damped,
    viscous,
    stiffer,
    rougher,
    faster_walls,
    more_relaxation,
    higher_overlap_speed,
    smaller_tolerance,
    cold_start,
    walls_in_reverse,
)


def faster_cell(system):
    system.cell.gradient = 1.001 * system.cell.gradient


def still_before(system):
    """As if the flow of the cell had not begun with the first step."""
    system.cell.last_gradient = system.cell.gradient


def farther_image(system):
    system.cell.base = (1 + 1e-7) * system.cell.base


def more_cohesion(system):
    system.interface.cohesion *= 1.001


def shorter_range(system):
    system.interface.cohesion_range *= 0.99


def smoother_sliding(system):
    system.interface.dynamic_friction *= 0.999


OF_CELL = (faster_cell, still_before, farther_image, more_cohesion, shorter_range, smoother_sliding)
NOTICED = [("corner", change) for change in CHANGES]
NOTICED += [("periodic, cohesion", change) for change in OF_CELL]


@pytest.mark.parametrize(
    "name, change", NOTICED, ids=lambda value: getattr(value, "__name__", None)
)
def test_comparison_notices_a_change(name, change):
    """An oracle that differs a little does not pass for the same."""
    dt, found = run_in_yade(name)
    system = build_oracle(CASES[name])
    change(system)
    largest = largest_deviations(CASES[name], found, run_oracle(system, dt, steps=40))
    assert largest["positions"] > 10 * TOLERANCE
    assert largest["velocities"] > 10 * TOLERANCE


@pytest.mark.parametrize("node_spacing", (1.25, 2.0, 2.5))
@pytest.mark.parametrize("order", (1, 2, 3))
def test_template_is_that_of_the_oracle(order, node_spacing):
    """Nodes and material points are the same; the undeformed grain is undeformed (F = 1)."""
    O.reset()
    disk = sg.soft_disk((0, 0, 0), 1.0, SoftMat(), zeta=0.25, order=order, nodeSpacing=node_spacing)
    O.bodies.append(disk)
    recipe = reference.Recipe(0.25, order=order, node_spacing=node_spacing)
    expected = reference.Template(recipe)
    np.testing.assert_allclose(disk.shape.nodes(), expected.node_position, atol=1e-14)
    points = disk.shape.points()
    np.testing.assert_allclose(points["position"][:, :2], expected.point_position, atol=1e-14)
    np.testing.assert_allclose(points["F"] - np.eye(3), 0, atol=1e-13)
    np.testing.assert_allclose(points["volume"], expected.point_volume, atol=1e-14)


@pytest.mark.parametrize("contact", ("surface", "points"))
@pytest.mark.parametrize("quadrature", ("cutCell", "lattice"))
def test_contact_nodes_are_those_of_the_oracle(quadrature, contact):
    """On the outline, or one for each cell with an empty neighbour, in the same order."""
    O.reset()
    disk = sg.soft_disk(
        (0, 0, 0), 1.0, SoftMat(), zeta=0.25, quadrature=quadrature, contact=contact
    )
    O.bodies.append(disk)
    expected = reference.Template(reference.Recipe(0.25, quadrature=quadrature, contact=contact))
    outline = disk.shape.outline()[:, :2]
    np.testing.assert_allclose(outline, expected.contact_position, atol=1e-14)
