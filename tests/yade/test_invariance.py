"""What results must not depend on: units, a common velocity of all, the order of the bodies.

Lengths, times and masses multiplied by powers of two give the same bits, multiplied likewise: a
constant with a dimension anywhere would be found here.
"""

import math
from typing import Callable, NamedTuple

import numpy as np
import pytest
from bodies import add_wall, facet_strip
from scenes import ZETA, run

import softgrain as sg
from yade import FrictMat, Matrix3, O, Vector3, utils

RADIUS = 0.01
CELL = 2.1 * RADIUS  # room for a grain
SPREAD = 0.15  # of the radii
SIDE = 3  # grains along a side of a box
#: s; by hand: a critical step is a time but for rounding only, see below.
TIME_STEP = 1e-5


class Units:
    """A length, a time and a mass of the scenes below in those of a run."""

    def __init__(self, length=1.0, time=1.0, mass=1.0):
        self.length, self.time, self.mass = length, time, mass
        self.speed = length / time
        self.acceleration = self.speed / time
        self.density = mass / length**3
        self.stress = mass / (length * time**2)

    def force(self, dim):
        """In the plane forces are per length."""
        return self.stress * self.length ** (dim - 1)

    def energy(self, dim):
        return self.stress * self.length**dim

    def soft(self, massDamping=0.0, stiffnessDamping=0.0, **attributes):
        return sg.SoftMat(
            young=1e6 * self.stress,
            poisson=0.45,
            density=1000 * self.density,
            frictionAngle=0.3,
            massDamping=massDamping / self.time,
            stiffnessDamping=stiffnessDamping * self.time,
            **attributes,
        )

    def rigid(self):
        return FrictMat(frictionAngle=0.2, density=1000 * self.density, young=1e6 * self.stress)


#: Those of micrometres and microseconds, of kilometres and hours, of cells, in powers of two.
OTHER_UNITS = {
    "small": Units(2.0**-20, 2.0**-20, 2.0**-60),
    "large": Units(2.0**10, 2.0**12, 2.0**37),
    "tissue": Units(2.0**-17, 2.0**-5, 2.0**-55),
}


def places(dim=2, side=SIDE):
    """Of the grains of a box, and numbers for each that differ."""
    random = np.random.default_rng(1)
    for cell in np.ndindex(*[side] * dim):
        centre = CELL * (np.array(cell) + 0.5)
        yield np.append(centre, np.zeros(3 - dim)), random.uniform(0, 1, 8)


def add(units, body, numbers, dim=2):
    body.state.vel = Vector3(*(0.6 * numbers[:dim] - 0.3), *[0] * (3 - dim)) * units.speed
    return O.bodies.append(body)


def add_disks(units, material=None, turned=False, **shape):
    for centre, numbers in list(places())[:: -1 if turned else 1]:
        radius = RADIUS * (1 - SPREAD * numbers[-1]) * units.length
        shape = {"zeta": ZETA, **shape}
        material = material or units.soft()
        add(units, sg.soft_disk(centre * units.length, radius, material, **shape), numbers)


def add_rigid_disk(units, centre, numbers):
    body = utils.sphere(centre * units.length, RADIUS * units.length, material=units.rigid())
    body.state.blockedDOFs = "zXY"
    sg.as_disks([add(units, body, numbers)])


def add_walls(units, speed=4.0, dim=2):
    """A box whose upper walls come down."""
    ids = []
    for axis in range(dim):
        for sense, position in ((1, 0), (-1, SIDE * CELL if dim == 2 else 2 * CELL)):
            moves = sense < 0 and (axis == 1 or dim == 3)
            velocity = -speed * units.speed if moves else 0
            place, material = position * units.length, units.rigid()
            wall = add_wall(place, axis, velocity=velocity, sense=sense, material=material)
            ids.append(wall.id)
    return ids


def disks(units, material=None, shape=None, speed=4.0, turned=False, **engines):
    add_disks(units, material, turned, **(shape or {}))
    add_walls(units, speed)
    O.engines = sg.engines(**engines)


def of_shape(speed=4.0, **shape):
    return lambda units: disks(units, shape=shape, speed=speed)


def plane_stress(units):
    disks(units, units.soft(condition="planeStress"))


def damped(units):
    disks(units, units.soft(massDamping=300.0, stiffnessDamping=1e-5))


def outlines(units):
    """Of all forms."""
    for centre, numbers in places():
        x, size = centre * units.length, 0.9 * RADIUS * units.length
        angle = 2 * math.pi * numbers[-1]
        material = units.soft()
        if numbers[-2] < 0.3:
            body = sg.soft_ellipse(x, (size, 0.7 * size), angle, material, zeta=ZETA)
        elif numbers[-2] < 0.5:
            body = sg.soft_superdisk(x, (size, size), 4, angle, material, zeta=ZETA)
        elif numbers[-2] < 0.7:
            body = sg.soft_block(x, (1.5 * size, 1.2 * size), material, zeta=ZETA)
        else:
            turns = angle + 2 * math.pi * np.arange(5) / 5
            corners = x[:2] + size * np.column_stack([np.cos(turns), np.sin(turns)])
            body = sg.soft_polygon(corners, material, zeta=ZETA)
        add(units, body, numbers)
    add_walls(units)
    O.engines = sg.engines()


def asleep(units):
    """Held by both sides, or it would rock for long: no damping acts on that."""
    radius = 0.499 * SIDE * CELL * units.length
    place = Vector3(0.5 * SIDE * CELL * units.length, radius, 0)
    O.bodies.append(sg.soft_disk(place, radius, units.soft(massDamping=4000.0), zeta=ZETA))
    add_walls(units, speed=0)
    O.engines = sg.engines(gravity=(0, -1000 * units.acceleration, 0))


def beside_rigid_disks(units):
    for centre, numbers in places():
        if numbers[-1] < 0.5:
            add_rigid_disk(units, centre, numbers)
        else:
            body = sg.soft_disk(
                centre * units.length, RADIUS * units.length, units.soft(), zeta=ZETA
            )
            add(units, body, numbers)
    add_walls(units)
    O.engines = sg.engines(rigid="nonsmooth")


def balls(units):
    for centre, numbers in places(dim=3, side=2):
        radius = RADIUS * units.length
        body = sg.soft_sphere(centre * units.length, radius, units.soft(), zeta=0.35)
        add(units, body, numbers, dim=3)
    add_walls(units, dim=3)
    O.engines = sg.engines()


def cohesive(units):
    law = dict(cohesion=2e4 * units.stress, cohesionRange=1e-4 * units.length)
    disks(units, interface=law)


def bonded(units):
    energy = 0.5 * units.stress * units.length
    law = dict(bondStrength=2e4 * units.stress, bondEnergy=energy)
    disks(units, interface=law)


def under_stress(units):
    add_disks(units)
    walls = add_walls(units, speed=0)
    O.engines = sg.engines()
    goal = Vector3(-2e5, -1e5, 0) * units.stress
    sg.insert_before_solve(sg.WallStressController(walls=walls, goal=goal, stressMask=3))


def periodic(units):
    O.periodic = True
    O.cell.setBox(Vector3(1, 1, 1) * (SIDE * CELL * units.length))
    add_disks(units)
    O.cell.velGrad = Matrix3(-60, 10, 0, 0, -60, 0, 0, 0, 0) / units.time
    O.engines = sg.engines()


def tracked(units):
    O.trackEnergy = True
    disks(units)


def on_facets(units):
    """A rough floor of facets, and a box that comes down."""
    add_disks(units)
    heights = (-0.01, 0.2, 0.0, 0.1, -0.01)
    profile = [Vector3(0.8 * k - 0.1, height, 0) for k, height in enumerate(heights)]
    floor = [point * (CELL * units.length) for point in profile]
    across = Vector3(0, 0, CELL * units.length)
    O.bodies.append(facet_strip(floor, across, units.rigid()))
    half = Vector3(SIDE, 0.5, 1) * (CELL * units.length)
    place = (0.5 * half[0], (SIDE + 0.5) * CELL * units.length, 0)
    lid = utils.box(place, half, fixed=True, material=units.rigid())
    lid.state.vel = (0, -4 * units.speed, 0)
    O.bodies.append(lid)
    O.engines = sg.engines()


class Scene(NamedTuple):
    make: Callable
    dim: int = 2
    steps: int = 300
    sleepers: int = 0


SCENES = {
    "disks": Scene(disks),
    "points": Scene(of_shape(contact="points")),
    "background nodes": Scene(of_shape(contact="nodes", speed=1.0)),
    "plane stress": Scene(plane_stress),
    "projected": Scene(of_shape(volumetric="projected")),
    "flip": Scene(of_shape(velocityUpdate="flip")),
    "updated": Scene(of_shape(formulation="updated")),
    "damped": Scene(damped),
    "outlines": Scene(outlines),
    "asleep": Scene(asleep, steps=10000, sleepers=1),
    "beside rigid disks": Scene(beside_rigid_disks),
    "balls": Scene(balls, dim=3),
    "cohesive": Scene(cohesive),
    "bonded": Scene(bonded),
    "under stress": Scene(under_stress),
    "periodic": Scene(periodic),
    "energies": Scene(tracked),
    "on facets": Scene(on_facets),
}


def make(scene, units):
    O.reset()
    O.trackEnergy = False
    scene.make(units)
    O.dt = TIME_STEP * units.time


def numbers_of_run(scene, units):
    """What a run leaves, in the units of the scenes."""
    make(scene, units)
    run(scene.steps)
    soft = sg.soft_bodies()
    integrator = sg.integrator()
    return {
        "positions": np.array([b.state.pos for b in O.bodies]) / units.length,
        "velocities": np.array([b.state.vel for b in O.bodies]) / units.speed,
        "spins": np.array([b.state.angVel for b in O.bodies]) * units.time,
        "nodes": np.concatenate([b.shape.nodes() for b in soft]) / units.length,
        "forces": np.array([O.forces.f(b.id) for b in O.bodies]) / units.force(scene.dim),
        "energies": np.array([energy for _, energy in O.energy.items()]) / units.energy(scene.dim),
        "solver": np.array([integrator.sweeps, integrator.residual, integrator.sleepingGrains]),
    }


@pytest.mark.parametrize("name", SCENES)
def test_units_change_nothing(name):
    expected = numbers_of_run(SCENES[name], Units())
    assert expected["solver"][-1] == SCENES[name].sleepers
    for other, units in OTHER_UNITS.items():
        found = numbers_of_run(SCENES[name], units)
        for quantity in expected:
            np.testing.assert_array_equal(
                found[quantity], expected[quantity], err_msg=f"{quantity}, {other}"
            )


@pytest.mark.parametrize("name", ["disks", "updated", "damped", "balls"])
def test_critical_step_is_a_time(name):
    """But for rounding: it is measured with roots of what may have odd powers of units."""

    def critical(units):
        make(SCENES[name], units)
        return sg.critical_time_step() / units.time

    expected = critical(Units())
    for units in OTHER_UNITS.values():
        assert critical(units) == pytest.approx(expected, rel=1e-12)


#: Background nodes and the updated formulation have a grid at rest in space.
MOVABLE = (
    "disks",
    "points",
    "projected",
    "flip",
    "damped",
    "outlines",
    "beside rigid disks",
    "balls",
    "bonded",
    "on facets",
)


@pytest.mark.parametrize("name", MOVABLE)
def test_a_common_velocity_changes_nothing(name):
    """Faster than any wave in the grains."""
    scene = SCENES[name]

    def seen_from(velocity):
        make(scene, Units())
        for body in O.bodies:
            body.state.vel += velocity
        run(scene.steps)
        return np.array([body.state.pos - O.time * velocity for body in O.bodies])

    expected = seen_from(Vector3(0, 0, 0))
    found = seen_from(Vector3(100, 50, 0))
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-7 * RADIUS)


@pytest.mark.parametrize("shape", [{}, {"contact": "points"}, {"volumetric": "projected"}])
def test_order_of_grains_changes_nothing(shape):
    """Where contacts are solved exactly. (Not so balls with friction: Coulomb's law may have
    several solutions, and the order of the sweeps tells which is found.)"""

    def places_after(turned):
        make(Scene(lambda units: disks(units, shape=shape, turned=turned)), Units())
        integrator = sg.integrator()
        integrator.tolerance, integrator.maxSweeps = 1e-9, 5000
        run(300)
        return np.array([body.state.pos for body in sg.soft_bodies()])

    found, expected = places_after(True)[::-1], places_after(False)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-7 * RADIUS)
