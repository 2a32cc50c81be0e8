"""Scenes that both the kernel inside YADE and the oracle in numpy run, and their comparison."""

import math
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

import softgrain as sg
from softgrain import reference
from bodies import add_wall
from yade import Matrix3, O, SoftMat

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

#: What a recipe is made of besides zeta: its names in the oracle, and those in YADE.
RECIPE = {
    "order": "order",
    "node_spacing": "nodeSpacing",
    "surface_spacing": "surfaceSpacing",
    "quadrature": "quadrature",
    "contact": "contact",
    "volumetric": "volumetric",
}


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
        common = {name: getattr(self, name) for name in RECIPE}
        common["lumping"] = "rowSums" if self.velocity_update == "flip" else "balanced"
        return [reference.Recipe(zeta, **common) for zeta in self.zeta]

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


#: What the contacts of a case are known to do.
EVERYTHING = {"sticking", "sliding", "wall", "grain", "capped overlap", "overlap", "closing gap"}


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
    recipe = {name: getattr(case, own) for own, name in RECIPE.items()}
    for g, m in enumerate(case.materials):
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
            zeta=case.zeta[g],
            **recipe,
            formulation=case.formulation,
            velocityUpdate=case.velocity_update,
            picShare=case.pic_share,
        )
        disk.state.vel, disk.state.angVel = padded(VELOCITIES[g]), (0, 0, SPINS[g])
        O.bodies.append(disk)
    for axis, coordinate, velocity, friction in case.walls:
        add_wall(coordinate, axis, friction, padded(velocity))
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
def run_in_yade(case):
    """Time step and snapshots after every step."""
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
            **method,
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


def assert_same(case):
    """Positions, velocities, impulses and sweeps agree in every step, and the contacts do what
    those of the case are known to do."""
    dt, found = run_in_yade(case)
    system = build_oracle(case)
    expected, seen = [], set()
    for _ in range(STEPS):
        expected += run_oracle(system, dt, steps=1)
        seen |= events(system, dt)
    largest = largest_deviations(case, found, expected)
    assert max(largest.values()) < TOLERANCE, largest
    assert ("cohesion" in seen) == bool(case.interface)
    if case.centres == OBLIQUE:
        assert seen >= EVERYTHING
    if case.cell:
        assert seen >= {"sticking", "sliding", "grain", "overlap"}


def assert_notices(change, case):
    """An oracle that differs a little does not pass for the same: ``change(system)`` makes it."""
    dt, found = run_in_yade(case)
    system = build_oracle(case)
    change(system)
    largest = largest_deviations(case, found, run_oracle(system, dt, STEPS))
    assert largest["positions"] > 10 * TOLERANCE
    assert largest["velocities"] > 10 * TOLERANCE


def times(factor, part, name):
    """A change: an attribute of a part of the system, or of all its grains or walls, times a
    factor."""

    def change(system):
        owners = getattr(system, part)
        for owner in owners if isinstance(owners, list) else [owners]:
            setattr(owner, name, factor * getattr(owner, name))

    return change


def with_material(name, value):
    """A change: a constant of the material of all grains becomes ``value(constant)``."""

    def change(system):
        for grain in system.grains:
            changed = {name: value(getattr(grain.material, name))}
            grain.material = replace(grain.material, **changed)

    return change
