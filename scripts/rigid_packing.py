"""Packings of rigid grains prepared by contact dynamics, and beside it by YADE's linear DEM.

Run it with YADE: ``scripts/yade -n -x scripts/rigid_packing.py --out DIR``. ``result.json`` has, of
a box into which spheres fall, what the solver did and how still they lie in the end, with the
processor time per step of both laws on that same packing; of loose disks squeezed by walls
under a force until they are jammed, packing, overlaps and processor time by both laws; and of disks
and spheres under pressure in a periodic cell, without and with friction, packing and stress.
"""

import json
import math
import time

import numpy as np
from yade import FrictMat, O, PeriTriaxController, Sphere, utils

import softgrain as sg
from softgrain import clouds, command_line

RADIUS = 0.01  # m, of the largest sphere
DENSITY = 2000.0  # kg/m3
GRAVITY = 10.0  # m/s2
FORCE = 10.0  # N, of a wall on the disks
COLUMNS = 8  # spheres side by side in the box
BOX_STEP, BOX_TIME = 2e-4, 2.0  # s
SQUEEZE_STEP = 5e-4  # s
SQUEEZE_DAMPING = 0.2  # NewtonIntegrator.damping of the linear law
SHORTEST = 0.5  # s, of a squeeze
STILL = 1e-3  # unbalanced force at which a squeezed packing counts as jammed
LONGEST = 6.0  # s, of a squeeze
PRESSURE = 1000.0  # Pa, of the cell on spheres; N/m on disks
CELL_STEP = 3e-4  # s
CELL_RATE = 0.5  # 1/s, at most
LOOSE = {2: 0.5, 3: 0.35}  # packing fraction at the start
STEADY = 0.02  # error of the stress at which a cell counts as at rest
LINEAR_STEP = 0.3  # over YADE's estimate of the critical one
BEARING = 1e-6  # least force of a contact that bears, over the force that presses
OVERLAP_UNIT = 0.1  # R, in which the integrator counts overlaps of rigid bodies
PITCH = 2.25 * RADIUS  # of the spheres above the box


def parse_options(arguments=None):
    parser = command_line.case_parser(__doc__, out="rigid_packing")
    add = parser.add_argument
    add("--spheres", type=command_line.whole_from(1), default=2000, help="in the box")
    # walls are as heavy as the disks: before few light ones FORCE would drive them too fast
    add("--disks", type=command_line.whole_from(20), default=400, help="squeezed by walls")
    add(
        "--in-cell",
        type=command_line.whole_from(30),  # YADE wants cells of some grains side by side
        default=100,
        help="disks, spheres in a periodic cell",
    )
    add("--mu", type=command_line.non_negative, default=0.3, help="friction [-]")
    add("--young", type=command_line.positive, default=1e7, help="of YADE's linear law [Pa]")
    return parser.parse_args(arguments)


def material(options, mu=None):
    mu = options.mu if mu is None else mu
    return FrictMat(young=options.young, poisson=0.3, density=DENSITY, frictionAngle=math.atan(mu))


def spheres():
    return [b for b in O.bodies if isinstance(b.shape, Sphere)]


def kinetic_energy():
    """Of the spheres [J]."""
    states = [b.state for b in spheres()]
    return 0.5 * sum(
        s.mass * s.vel.squaredNorm() + np.dot(s.inertia, np.square(s.angVel)) for s in states
    )


def step_of_the_linear_law():
    """[s]"""
    return LINEAR_STEP * utils.PWaveTimeStep()


def time_per_step(steps):
    """Processor time of a step [ms]."""
    start = time.process_time()
    sg.advance(steps)
    return 1e3 * (time.process_time() - start) / steps


def bearing_contacts(force):
    """Those between spheres, and of spheres with walls, that matter beside a force [N, 2D N/m]."""
    real = [i for i in O.interactions if i.isReal]
    return [i for i in real if i.phys.normalForce.norm() > BEARING * force]


def sphere_ends(bearing):
    """How often these contacts touch a sphere: twice, but once where they are with a wall."""
    return sum(
        isinstance(O.bodies[k].shape, Sphere) for i in bearing for k in (i.id1, i.id2)
    )


def largest_overlap(bearing):
    """Of these contacts; 0 of none [m]."""
    return max((i.geom.penetrationDepth for i in bearing), default=0.0)


def fill_box(options):
    """Spheres above each other, a little out of order, between five walls."""
    O.reset()
    random, side = np.random.default_rng(1), PITCH * COLUMNS
    grains, wall = material(options), material(options)
    places = [(0, 0), (side, 0), (0, 1), (side, 1), (0, 2)]
    O.bodies.append([utils.wall(place, axis=axis, material=wall) for place, axis in places])
    for k in range(options.spheres):
        layer, rest = divmod(k, COLUMNS**2)
        cell = np.array([*divmod(rest, COLUMNS), layer]) + 0.5
        centre = PITCH * cell + 0.08 * RADIUS * random.uniform(-1, 1, 3)
        radius = RADIUS * random.uniform(0.85, 1)
        O.bodies.append(utils.sphere(tuple(centre), radius, material=grains))


def box_at_rest(options):
    """Lets the box come to rest; how still it is in the last tenth of the time."""
    fill_box(options)
    O.engines = sg.engines(rigid="nonsmooth", gravity=(0, 0, -GRAVITY))
    O.dt = BOX_STEP
    steps = round(BOX_TIME / O.dt)
    scale = GRAVITY * RADIUS * sum(b.state.mass for b in spheres())
    kinetic = []
    for _ in range(9):
        sg.advance(steps // 10)
        kinetic.append(kinetic_energy() / scale)
    places = np.array([b.state.pos for b in spheres()])
    integrator = sg.integrator()
    sweeps = integrator.totalSweeps
    cost = time_per_step(steps // 10)
    kinetic.append(kinetic_energy() / scale)
    moved = np.linalg.norm(np.array([b.state.pos for b in spheres()]) - places, axis=1)
    held = sum(O.forces.f(i)[2] for i in range(5))
    result = {
        "spheres": options.spheres,
        "steps": integrator.steps,
        "kinetic_over_m_g_R": kinetic,
        "median_creep_over_R": float(np.median(moved)) / RADIUS,
        "share_that_moved_by_R_over_1000": float(np.mean(moved > 1e-3 * RADIUS)),
        "reaction_over_weight": -held / (scale / RADIUS),
        "contacts": integrator.contacts,
        "active_contacts": integrator.activeContacts,
        "sweeps_per_step": integrator.totalSweeps / integrator.steps,
        "sweeps_per_step_at_rest": (integrator.totalSweeps - sweeps) / (steps // 10),
        "capped_steps": integrator.cappedSteps,
        "residual": integrator.residual,
        "largest_residual": integrator.largestResidual,
        "overlap_over_R": OVERLAP_UNIT * integrator.overlap,
        "largest_overlap_over_R": OVERLAP_UNIT * integrator.largestOverlap,
        "milliseconds_per_step_at_rest": cost,
        "dt": O.dt,
    }
    O.engines = sg.engines(rigid="linear", gravity=(0, 0, -GRAVITY))
    O.interactions.clear()
    O.dt = step_of_the_linear_law()
    sg.advance(200)
    result["linear"] = {"milliseconds_per_step": time_per_step(500), "dt": O.dt}
    return result


def loose_disks(options):
    """Disks on a loose square lattice between four walls, two of which are free and pushed."""
    O.reset()
    random, row = np.random.default_rng(2), math.ceil(math.sqrt(options.disks))
    pitch = 2.6 * RADIUS
    smooth, grains = material(options, 0), material(options)
    ids = O.bodies.append(sg.walls_around((0, 0), (row * pitch, row * pitch), smooth))
    for k in range(options.disks):
        jitter = 0.05 * RADIUS * random.uniform(-1, 1, 2)
        centre = pitch * (np.array(divmod(k, row)) + 0.5) + jitter
        disk = utils.sphere((*centre, 0), RADIUS * random.uniform(0.8, 1.2), material=grains)
        disk.state.blockedDOFs = "zXY"
        disk.state.vel = (*random.uniform(-0.3, 0.3, 2), 0)
        O.bodies.append(disk)
    mass = sum(b.state.mass for b in spheres())
    for axis, k in ((0, 1), (1, 3)):
        state = O.bodies[ids[k]].state
        state.blockedDOFs = ("yzXYZ", "xzXYZ")[axis]
        state.mass, state.inertia = mass, (1, 1, 1)
        O.forces.setPermF(ids[k], [-FORCE * (a == axis) for a in range(3)])
    return ids


def squeeze(options, rigid):
    """From loose to jammed by one of the laws of rigid pairs."""
    ids = loose_disks(options)
    O.engines = sg.engines(rigid=rigid)
    if rigid == "linear":
        O.engines[-1].damping = SQUEEZE_DAMPING
    O.dt = SQUEEZE_STEP if rigid == "nonsmooth" else step_of_the_linear_law()
    start = time.process_time()
    while O.time < LONGEST and not (O.time > SHORTEST and utils.unbalancedForce() < STILL):
        sg.advance(round(0.01 / O.dt))
    cpu = time.process_time() - start
    sides = [O.bodies[ids[k]].state.pos[axis] for axis, k in ((0, 1), (1, 3))]
    bearing = bearing_contacts(FORCE)
    integrator = sg.integrator()
    return {
        "law": rigid,
        "disks": options.disks,
        "packing_fraction": sum(math.pi * b.shape.radius**2 for b in spheres()) / np.prod(sides),
        "contacts_per_disk": sphere_ends(bearing) / options.disks,
        "largest_overlap_over_R": largest_overlap(bearing) / RADIUS,
        "unbalanced_force": utils.unbalancedForce(),
        "time": O.time,
        "dt": O.dt,
        "steps": O.iter,
        "milliseconds_per_step": 1e3 * cpu / O.iter,
        "cpu_seconds": cpu,
        "sweeps_per_step": integrator.totalSweeps / max(integrator.steps, 1),
        "capped_steps": integrator.cappedSteps,
    }


def fill_cell(dim, mu, options):
    """A loose periodic cloud; the sides of its cell along which it is pressed [m]."""
    O.reset()
    O.periodic = True
    grain = math.pi * RADIUS**2 if dim == 2 else 4 / 3 * math.pi * RADIUS**3
    side = (options.in_cell * grain / LOOSE[dim]) ** (1 / dim)
    corner = (side, side, side if dim == 3 else 0)
    cloud = clouds.full_cloud(options.in_cell, corner, RADIUS, 0.2, periodic=True)
    ids = cloud.toSimulation(material=material(options, mu))
    O.cell.setBox(side, side, side if dim == 3 else 1)
    if dim == 2:
        for k in ids:
            O.bodies[k].state.blockedDOFs = "zXY"
        sg.as_disks(ids)


def cell_packing_fraction(dim):
    """In 2D that of the disks."""
    radii = np.array([b.shape.radius for b in spheres()])
    sizes = math.pi * radii**2 if dim == 2 else 4 / 3 * math.pi * radii**3
    return float(sizes.sum() / np.prod(np.array(O.cell.size)[:dim]))


def pressure_control(dim):
    """Of the cell, which moves as a mass of its own: some times that of the grains, or its stress
    would swing between two steps."""
    density = sum(b.state.mass for b in spheres()) / O.cell.volume
    return PeriTriaxController(
        dynCell=True,
        mass=3 * density * O.cell.size[0] ** 2,
        goal=[-PRESSURE] * dim + [0] * (3 - dim),
        stressMask=2**dim - 1,
        maxStrainRate=(CELL_RATE,) * 3,
        growDamping=0.8,
        globUpdate=1,
        maxUnbalanced=0,
    )


def press_cell(dim, mu, options):
    """From a loose cloud to a packing that bears the pressure."""
    fill_cell(dim, mu, options)
    O.engines = sg.engines(rigid="nonsmooth", tolerance=1e-3)
    sg.insert_before_solve(pressure_control(dim))
    O.dt = CELL_STEP

    def error():
        stress = np.diag(np.array(utils.getStress()))[:dim]
        return float(np.abs(stress / -PRESSURE - 1).max())

    start = time.process_time()
    sg.advance(200)
    while O.time < LONGEST and not (error() < STEADY and utils.unbalancedForce() < 2 * STILL):
        sg.advance(10)
    bearing = bearing_contacts(PRESSURE * RADIUS)
    touched = {k for i in bearing for k in (i.id1, i.id2)}
    integrator = sg.integrator()
    return {
        "dim": dim,
        "mu": mu,
        "grains": len(spheres()),
        "packing_fraction": cell_packing_fraction(dim),
        "contacts_per_bearing_grain": 2 * len(bearing) / max(len(touched), 1),
        "bearing_share": len(touched) / len(spheres()),
        "error_of_stress": error(),
        "unbalanced_force": utils.unbalancedForce(),
        "largest_overlap_over_R": largest_overlap(bearing) / RADIUS,
        "time": O.time,
        "steps": O.iter,
        "cpu_seconds": time.process_time() - start,
        "sweeps_per_step": integrator.totalSweeps / integrator.steps,
        "capped_steps": integrator.cappedSteps,
    }


def main():
    options = parse_options()
    result = {
        "cell": [press_cell(dim, mu, options) for dim in (2, 3) for mu in (0, options.mu)],
        "squeeze": [squeeze(options, rigid) for rigid in ("nonsmooth", "linear")],
        "box": box_at_rest(options),
    }
    command_line.write_result(options, result)
    print(json.dumps(result, indent=1))


if __name__ == "__main__":
    main()
