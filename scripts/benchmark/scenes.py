"""The scenes of ``run.py``, one in a run: ``yade -n -x scenes.py CASE --result FILE [SETTINGS]``.

Each case builds a scene, runs ``repeat`` times ``steps`` steps, and writes what it measured as
JSON: medians over the repetitions of the wall time of a step, of the share of it in which the
process had the processor, of the time of each phase (``sg.phase_times``) and of the work counted,
and the peak memory of the process. In 2D, disks of radius 10 mm, E = 1 MPa, nu = 0.45, unless said
otherwise.
"""

import argparse
import math
import statistics
import sys
import time
from pathlib import Path

import numpy as np
from yade import (
    FrictMat,
    NewtonIntegrator,
    O,
    Quaternion,
    Sphere,
    utils,
)

import softgrain as sg
from softgrain import command_line

sys.path.extend(map(str, Path(sys.argv[0]).resolve().parents[:2]))  # scripts/benchmark/, scripts/

import compaction  # noqa: E402
from measuring import (  # noqa: E402
    counted_work,
    figures_of,
    measure,
    medians,
    peak_memory,
    resident_memory,
)

RADIUS = compaction.MEAN_RADIUS
SPREAD = compaction.RADIUS_SPREAD
RIGID_PHI = 0.80  # of the packing made by rigid DEM: its overlaps are small still
HEXAGON_AREA = 2 * math.sqrt(3)  # over the square of the radius of the circle inside
DENSE_PHI = 0.87  # of the dense packing, undeformed areas: jammed, at a stress of some 0.02 E
PRESSING_SPEED = 2.0  # m/s, of the soft grains up to there; then that of the paper
SIZES_GAP = 0.02  # sizes: between the big disks at the start, over their diameter
SIZES_STRAIN, SIZES_WINDOW = 0.12, 0.005  # sizes: strain before, and while the force is measured
BALLS_STRAIN = 0.06  # balls: of the box in each direction, before measuring
SETTLING_STEPS = 200  # at that speed, before measuring
MOST_SETTLING_STEPS = 50000  # of grains that come to rest
# 1/s, of these and of `dense --damped`: a few times the speed of shear waves over the radius
DAMPING = 4000.0
STIFFNESS_DAMPING = 1e-6  # s, a twentieth of the critical time step
GRAVITY = 9.81  # m/s²
#: Attributes of SoftGrainIntegrator that skip grains at rest or in free flight, where it has them.
SKIPPING = ("rigidMotion", "sleep")


# --- scenes --------------------------------------------------------------------------------------


def skip(allowed):
    """Allow or forbid the integrator to skip grains; whether it can."""
    engine = sg.integrator()
    known = [name for name in SKIPPING if hasattr(engine, name)]
    for name in known:
        setattr(engine, name, allowed)
    return bool(known)


def material(mu=0.3):
    return sg.SoftMat(
        young=compaction.YOUNG,
        poisson=0.45,
        density=compaction.DENSITY,
        frictionAngle=math.atan(mu),
    )


def lattice(count, spacing, dim=2):
    """Corners of the cells of a square (cubic) lattice, the first ``count`` of them."""
    side = math.ceil(count ** (1 / dim) - 1e-9)
    cells = np.indices((side,) * dim).reshape(dim, -1).T[:count]
    return np.pad(spacing * cells.astype(float), ((0, 0), (0, 3 - dim)))


def radii(count):
    return RADIUS * np.random.default_rng(1).uniform(1 - SPREAD, 1 + SPREAD, count)


def fill(centers, sizes, options):
    """Soft grains at these places; all of one template, or each of its own."""
    soft = material()
    make = {2: sg.soft_disk, 3: sg.soft_sphere}[options.dim]
    shape = {
        "order": options.order,
        "nodeSpacing": options.node_spacing,
        "formulation": options.formulation,
    }
    spread = 0.02 if options.own_templates else 0.0
    zetas = options.zeta * np.linspace(1 - spread, 1 + spread, len(centers))
    O.bodies.append(
        [make(tuple(x), r, soft, zeta=z, **shape) for x, r, z in zip(centers, sizes, zetas)]
    )


def start(**engines):
    """Engines, time step, first step; returns the seconds of that step, in which the grains are
    assembled."""
    O.engines = sg.engines(**engines)
    sg.set_time_step()
    began = time.perf_counter()
    O.step()
    return time.perf_counter() - began


def points_per_grain():
    return len(sg.soft_bodies()[0].shape.points()["volume"])


def soft_figures(options):
    return {"grains": len(sg.soft_bodies()), "points": points_per_grain(), **measure(options)}


# --- cases ---------------------------------------------------------------------------------------


def bulk(options):
    """Grains of different radii, spinning far apart: internal forces and motion only."""
    fill(lattice(options.grains, 3 * RADIUS, options.dim), radii(options.grains), options)
    for body in sg.soft_bodies():
        body.state.angVel = (0, 0, 30)
    start()
    skip(False)
    return soft_figures(options)


def compaction_options(options, *further):
    return compaction.parse_options(
        [
            f"--grains={options.grains}",
            f"--zeta={options.zeta}",
            f"--node-spacing={options.node_spacing}",
            f"--tolerance={options.tolerance}",
            f"--out={options.result.resolve().parent / 'compaction'}",
            *further,
        ]
    )


def rigid_packing(options):
    """Rigid disks pressed to RIGID_PHI, in the box of the compaction; its options and box."""
    case = compaction_options(options)
    box = compaction.prepare_rigid(case)
    press(box, case.speed, RIGID_PHI)
    return case, box


def area(shape):
    """Of a disk, or of a hexagon of that radius inside."""
    is_hexagon = getattr(shape, "form", None) == "polygon"
    return (HEXAGON_AREA if is_hexagon else math.pi) * shape.radius**2


def press(box, speed, phi):
    """Move the top wall until undeformed grains would fill the share ``phi`` of the box."""
    solid = sum(area(b.shape) for b in O.bodies if hasattr(b.shape, "radius"))
    box.close(speed)
    while solid / box.area < phi:
        O.step()


def dense_scene(options):
    """The dense frictional packing, under compression at the speed of the paper."""
    case, box = rigid_packing(options)
    compaction.make_soft(case)
    O.trackEnergy = False
    press_soft(case, box)


def press_soft(case, box):
    press(box, PRESSING_SPEED, DENSE_PHI)
    box.close(case.speed)
    sg.advance(SETTLING_STEPS)


def dense(options):
    """Contact and search: the dense frictional packing; with ``--damped`` its grains have weight
    and damping of both kinds."""
    dense_scene(options)
    if options.damped:
        newton = next(e for e in O.engines if isinstance(e, NewtonIntegrator))
        newton.gravity = (0, -GRAVITY, 0)
        soft = sg.soft_bodies()[0].material
        soft.massDamping, soft.stiffnessDamping = DAMPING, STIFFNESS_DAMPING
        sg.advance(1)
    return {**soft_figures(options), "dt": O.dt}


def hexagons(options):
    """Search at corners: the dense packing with hexagons in its disks, turned at random."""
    case, box = rigid_packing(options)
    angles = np.arange(6) * math.pi / 3
    ring = np.column_stack([np.cos(angles), np.sin(angles)])
    turns = np.random.default_rng(1).uniform(0, math.pi / 3, options.grains)
    soft = material()
    O.engines = []
    for body, turn in zip([b for b in O.bodies if isinstance(b.shape, Sphere)], turns):
        place = np.array(body.state.pos)[:2]
        O.bodies.erase(body.id)
        grain = sg.soft_polygon(place + body.shape.radius * ring, soft, zeta=options.zeta)
        grain.state.ori = Quaternion((0, 0, 1), turn)
        O.bodies.append(grain)
    O.engines = sg.engines(tolerance=options.tolerance)
    sg.set_time_step()
    press_soft(case, box)
    return soft_figures(options)


def rigid(options):
    """Rigid DEM of the same packing, with the time step of disks as stiff as the soft grains."""
    case, box = rigid_packing(options)
    press(box, case.speed, DENSE_PHI)
    measured = measure(options)
    O.materials["walls"].young = compaction.YOUNG
    return {"grains": options.grains, **measured, "dt": 0.5 * utils.PWaveTimeStep()}


def paper(options):
    """The compaction of the paper from loose to ``until_phi``, with its energy balance."""
    case = compaction_options(options, f"--until-phi={options.until_phi}")
    box = compaction.prepare_rigid(case)
    compaction.make_soft(case)
    O.timingEnabled = True
    sg.reset_times()
    before, wall, processor = counted_work(), time.perf_counter(), time.process_time()
    _, seconds = compaction.compact(case, box)  # without the time for pictures
    wall, processor = time.perf_counter() - wall, time.process_time() - processor
    steps = int(sg.integrator().steps)
    figures = figures_of(steps, seconds, processor * seconds / wall, before)
    return {
        "grains": options.grains,
        "points": points_per_grain(),
        **figures,
        "seconds": seconds,
        "steps": steps,
    }


def scale(options):
    """Many grains that touch their four neighbours: memory and set-up. *nodes* are the background
    nodes of a grain."""
    fill_start = time.perf_counter()
    before = resident_memory()
    centers = lattice(options.grains, 2 * RADIUS * (1 - 1e-3))
    fill(centers, np.full(options.grains, RADIUS), options)
    making = time.perf_counter() - fill_start
    assembling = start()
    skip(False)
    figures = soft_figures(options)
    bytes_per_point = (resident_memory() - before) / (options.grains * figures["points"])
    return {
        **figures,
        "nodes": len(sg.soft_bodies()[0].shape.nodes()),
        "setup": making + assembling,
        "bytes_per_point": bytes_per_point,
    }


def sleeping(options):
    """Grains at rest apart from each other, one in a hundred pressed on a neighbour. With
    ``--skip`` the integrator leaves out the others if it can (``skipping``)."""
    centers = lattice(options.grains, 2.2 * RADIUS)
    active = np.arange(0, options.grains - 1, 200)  # with its neighbour: one in a hundred
    centers[active, 1] += 0.21 * RADIUS  # overlaps the next one by 0.01 radius
    fill(centers, np.full(options.grains, RADIUS), options)
    start()
    able = skip(options.skip) and options.skip
    sg.advance(SETTLING_STEPS // 10)
    return {**soft_figures(options), "skipping": able}


def resting(options):
    """Damped disks that press on their four neighbours and on four walls, at rest. With ``--skip``
    they sleep if the integrator can (``skipping``)."""
    spacing = 2 * RADIUS * (1 - 1e-3)
    centers = lattice(options.grains, spacing)
    fill(centers, np.full(options.grains, RADIUS), options)
    sg.soft_bodies()[0].material.massDamping = DAMPING
    low, high = -0.5 * spacing, centers.max() + 0.5 * spacing
    O.bodies.append(sg.walls_around((low, low), (high, high), FrictMat()))
    start()
    able = skip(options.skip) and options.skip
    sg.advance(SETTLING_STEPS)
    while able and sg.integrator().sleepingGrains < options.grains:
        sg.advance(SETTLING_STEPS)
        if sg.integrator().steps > MOST_SETTLING_STEPS:
            raise RuntimeError("grains do not fall asleep")
    return {**soft_figures(options), "skipping": able}


def balls(options):
    """Contact and search in 3D: balls in a cubic lattice, between six walls that close in on
    them."""
    centers = lattice(options.grains, 2 * RADIUS, options.dim)
    fill(centers, np.full(options.grains, RADIUS), options)
    rough, high = FrictMat(frictionAngle=math.atan(0.3)), centers.max() + RADIUS
    walls = sg.walls_around((-RADIUS,) * 3, (high,) * 3, rough)
    for k, wall in enumerate(walls):
        wall.state.vel[k // 2] = (-1) ** k * PRESSING_SPEED / 4
    ids = O.bodies.append(walls)
    start()
    skip(False)
    low, width = O.bodies[ids[0]], high + RADIUS
    while low.state.pos[0] + RADIUS < 0.5 * BALLS_STRAIN * width:
        sg.advance(1)
    return {**soft_figures(options), "dt": O.dt}


def mixed(options):
    """Soft grains beside as many rigid spheres, each kind in a square lattice of its own."""
    centers = lattice(options.grains, 2 * RADIUS * (1 - 1e-3))
    fill(centers, np.full(options.grains, RADIUS), options)
    aside, mirror = np.array([-4 * RADIUS, 0, 0]), np.array([-1, 1, 1])
    stiff = FrictMat(young=compaction.YOUNG, density=compaction.DENSITY)
    ids = O.bodies.append(
        [utils.sphere(tuple(x * mirror + aside), RADIUS, material=stiff) for x in centers]
    )
    for i in ids:
        O.bodies[i].state.blockedDOFs = "zXY"
    O.engines = sg.engines()
    sg.set_time_step()
    O.step()
    skip(False)
    return soft_figures(options)


def sizes(options):
    """Big disks in a hexagonal lattice between walls, and in gaps of it a tenth as many small ones,
    of a tenth of their radius, pressed until the gaps have closed. With ``--multirate`` the big
    ones take steps of their own. *force* is the mean on the wall that presses, just before the
    measured steps [N/m], *whole* the point updates up to these."""
    across = math.isqrt(options.grains)
    place = np.indices((across, options.grains // across)).reshape(2, -1).T[:, ::-1]
    column, row = place[:, 1], place[:, 0]
    spacing = 2 * RADIUS * (1 + SIZES_GAP)
    x = spacing * (0.5 + column + 0.5 * (row % 2))
    y = spacing * (0.5 + math.sqrt(0.75) * row)
    big = np.column_stack([x, y, 0 * x])
    inside = big[(column < across - 1) & (row < row.max())]
    gaps = inside + spacing * np.array([0.5, math.sqrt(1 / 12), 0])
    small = gaps[np.linspace(0, len(gaps) - 1, options.grains // 10).astype(int)]
    fill(big, RADIUS * np.random.default_rng(1).uniform(0.97, 1, len(big)), options)
    fill(small, np.full(len(small), RADIUS / 10), options)
    width, height = spacing * (across + 0.5), y.max() + spacing / 2
    rough = FrictMat(frictionAngle=math.atan(0.3))
    ids = O.bodies.append(sg.walls_around((0, 0), (width, height), rough))
    start(multirate=options.multirate)
    skip(False)
    top = O.bodies[ids[-1]]
    top.state.vel = (0, -PRESSING_SPEED / 2, 0)
    while top.state.pos[1] > height * (1 - SIZES_STRAIN):
        O.step()
    forces = []
    while top.state.pos[1] > height * (1 - SIZES_STRAIN - SIZES_WINDOW):
        O.step()
        forces.append(abs(sg.wall_force(top.id)[1]))
    figures = {"force": statistics.fmean(forces), "whole": sg.integrator().pointsUpdated}
    return {**soft_figures(options), **figures, "dt": O.dt}


def saving(options):
    """The dense packing saved and loaded again; *load* includes the first step after it, in which
    the grains are assembled."""
    dense_scene(options)
    file = options.result.resolve().parent / "scene.yade.gz"
    times = []
    for _ in range(options.repeat):
        began = time.perf_counter()
        O.save(str(file))
        saved = time.perf_counter()
        O.load(str(file))
        O.step()
        times.append({"save": saved - began, "load": time.perf_counter() - saved})
    figures = {"grains": options.grains, "points": points_per_grain()}
    return {**figures, **medians(times), "bytes": file.stat().st_size}


def scene(options):
    """A scene of the user's, saved before."""
    O.load(str(options.scene))
    O.step()
    return {**soft_figures(options), "dt": O.dt}


CASES = (
    bulk,
    dense,
    hexagons,
    rigid,
    paper,
    scale,
    sleeping,
    resting,
    balls,
    mixed,
    sizes,
    saving,
    scene,
)


def parse_options():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("case", choices=[case.__name__ for case in CASES])
    add = parser.add_argument
    add("--result", type=Path, required=True, help="JSON file to write")
    add("--grains", type=command_line.whole_from(1), default=400, help="number of grains [-]")
    add("--zeta", type=command_line.resolution, default=0.11, help="relative resolution 2 dr/D [-]")
    add("--dim", type=int, choices=(2, 3), default=2, help="disks or balls")
    add("--order", type=int, choices=(1, 2, 3), default=3, help="order of the B-splines")
    add(
        "--node-spacing",
        type=command_line.node_spacing,
        default=1.25,
        help="step of the grid over dr [-]",
    )
    add("--formulation", choices=("total", "updated"), default="total", help="of the grains")
    add("--own-templates", action="store_true", help="each grain has a resolution of its own")
    add("--steps", type=command_line.whole_from(1), default=20, help="steps in a repetition [-]")
    add("--repeat", type=command_line.whole_from(1), default=5, help="repetitions [-]")
    add(
        "--until-phi",
        type=command_line.fraction,
        default=0.98,
        help="paper: packing fraction to stop at [-]",
    )
    add(
        "--tolerance",
        type=command_line.positive,
        default=1e-2,
        help="dense, paper, saving: of the contact sweeps [-]",
    )
    add("--damped", action="store_true", help="dense: with weight and damping")
    add("--skip", action="store_true", help="sleeping, resting: let the integrator skip grains")
    add("--multirate", action="store_true", help="sizes: let grains take steps of their own")
    add("--scene", type=Path, help="scene: file to load")
    return parser.parse_args()


def main():
    options = parse_options()
    case = next(case for case in CASES if case.__name__ == options.case)
    figures = {"threads": O.numThreads, **case(options), "peak_memory": peak_memory()}
    command_line.write_json(options.result, figures)


if __name__ == "__main__":
    main()
