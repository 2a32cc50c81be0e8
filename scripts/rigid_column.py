"""Granular columns that collapse on a frictional floor: rigid disks by contact dynamics.

Run it with YADE: ``scripts/yade -n -x scripts/rigid_column.py --out DIR``. Disks settle between a
smooth wall, the plane of symmetry, and a gate, a column of the height H0 and the half-width L0 on a
flat floor or on one of disks that are held; the gate goes, and they run out to L. ``result.json``
and ``rigid_column.png`` have (L - L0)/L0 over the aspect ratio a = H0/L0 by contact dynamics and,
with ``--linear``, by YADE's linear law (springs, dashpots, friction), from the same packings,
beside what was published (doc/validation.md, Collapsing columns).
"""

import json
import math
import time

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter
from scipy.sparse import csgraph
from scipy.spatial import distance
from yade import (
    Ip2_ViscElMat_ViscElMat_ViscElPhys,
    Law2_ScGeom_ViscElPhys_Basic,
    O,
    Sphere,
    ViscElMat,
    utils,
)

import softgrain as sg
from softgrain import command_line

DIAMETER = 0.01  # m, of a disk on average
SPREAD = 0.2  # of the radii about their mean
DENSITY = 2000.0  # kg/m3
GRAVITY = 10.0  # m/s2
SETTLED = 0.81  # packing fraction of a column, about
FLOOR_TOP = 0.5 * DIAMETER  # m, height of the floor
CLEARANCE = 0.2 * DIAMETER  # m, from there to the cells from which disks fall
BUMPS = 0.1 * DIAMETER  # m, up and down, of a floor of disks
MOTION = 0.02  # of the mean radius, by the fastest disk in a step
LONGEST_STEP = 4e-4  # s
LEAST_RESTITUTION = 0.02  # of the linear law, whose dashpots have no value for 0
STILL = 1e-5  # kinetic energy over m g H0 at which a column stands, a deposit lies
SETTLING = (0.1, 3.0)  # s, a column takes at least and at most
COLLAPSE = (1, 8)  # the same of a collapse, over the time in which a disk falls by H0
NEAR = 0.1  # gap over the mean diameter up to which disks belong together
OVERLAP_UNIT = 0.1  # R, in which overlaps of rigid bodies are counted

#: Run-out (L - L0)/L0 = factor a below the bound, factor a^power above: (bound, factor; factor,
#: power).
PUBLISHED = {
    "Staron & Hinch 2005, contact dynamics": (2, 2.5, 3.25, 0.7),
    "Kumar 2015, linear law": (2.3, 1.67, 2.5, 2 / 3),
    "Lube et al. 2005, experiments": (2.3, 1.2, 1.9, 2 / 3),
}
LAWS = {"nonsmooth": "contact dynamics", "linear": "linear law"}


def parse_options(arguments=None):
    parser = command_line.case_parser(__doc__, out="rigid_column")
    add = parser.add_argument
    add(
        "--aspects", type=command_line.positive, nargs="+", default=[0.5, 1, 2, 4], help="H0/L0 [-]"
    )
    add("--linear", type=command_line.positive, nargs="*", default=[], help="those by both laws")
    add(
        "--seeds",
        type=command_line.whole_from(0),
        nargs="+",
        default=[1, 2, 3],
        help="of random places and radii",
    )
    add(
        "--width",
        type=command_line.number("[2, inf)"),
        default=12,
        help="L0 over the mean diameter [-]",
    )
    add("--floor", choices=("disks", "flat"), default="disks", help="what the column stands on")
    add("--mu", type=command_line.non_negative, default=0.5, help="friction [-]")
    add("--restitution", type=command_line.share, default=0.5, help="of either law [-]")
    add("--tolerance", type=command_line.positive, default=1e-2, help="of the contact sweeps [-]")
    add("--young", type=command_line.positive, default=1e9, help="of YADE's linear law [Pa]")
    add(
        "--linear-step",
        type=command_line.positive,
        default=0.15,
        help="time step of the linear law over sqrt(m/k) of the smallest disk; 0.05 where strong "
        "dashpots make a restitution near 0 [-]",
    )
    options = parser.parse_args(arguments)
    if missing := set(options.linear) - set(options.aspects):
        parser.error(f"argument --linear: {sorted(missing)} are not among --aspects")
    lowest = min(options.aspects)
    if disks_in_column(lowest, options.width) < columns(options.width):
        parser.error(f"argument --aspects: {lowest} makes no whole row of disks")
    return options


def columns(width):
    """How many disks stand side by side."""
    return int(width / (1 + SPREAD))


def disks_in_column(aspect, width):
    return round(SETTLED * aspect * width**2 / (0.25 * math.pi))


def disks():
    """Those that are free."""
    return [b for b in O.bodies if b and isinstance(b.shape, Sphere) and b.dynamic]


def places():
    return np.array([b.state.pos for b in disks()])[:, :2]


def radii():
    return np.array([b.shape.radius for b in disks()])


def heap():
    """The most that hang together; single ones that roll away do not count."""
    centres, radius = places(), radii()
    gaps = distance.cdist(centres, centres) - radius - radius[:, None]
    _, group = csgraph.connected_components(gaps < NEAR * DIAMETER)
    largest = np.argmax(np.bincount(group))
    return [disk for disk, number in zip(disks(), group) if number == largest]


def kinetic_energy(bodies):
    """Of disks [J]."""
    states = [b.state for b in bodies]
    return 0.5 * sum(s.mass * s.vel.squaredNorm() + s.inertia[2] * s.angVel[2] ** 2 for s in states)


def engines(law, options):
    made = sg.engines(
        rigid=law,
        gravity=(0, -GRAVITY, 0),
        verlet_distance=0.1 * DIAMETER,
        interface={"restitution": options.restitution},
        tolerance=options.tolerance,
    )
    if law == "linear":
        made[2].physDispatcher.functors = [Ip2_ViscElMat_ViscElMat_ViscElPhys()]
        made[2].lawDispatcher.functors = [Law2_ScGeom_ViscElPhys_Basic()]
    return made


def shortest_swing():
    """sqrt(m/k) of the smallest disk on a spring k = E R, as the linear law has between equal ones
    [s]; YADE's estimate of a time step knows balls, not disks per metre of thickness."""
    return min(math.sqrt(b.state.mass / (b.mat.young * b.shape.radius)) for b in disks())


def run_until_still(law, options, scale, least, longest):
    """Runs until the kinetic energy of the heap is below STILL of `scale` [J], between two times
    [s]; in contact dynamics with steps that follow the fastest disk."""
    begin = O.time
    linear_step = options.linear_step * shortest_swing()
    while O.time - begin < longest:
        for _ in range(5):
            fastest = max(b.state.vel.norm() for b in disks()) + 1e-9
            O.dt = min(LONGEST_STEP, MOTION * 0.5 * DIAMETER / fastest)
            if law == "linear":
                O.dt = linear_step
            sg.advance(20 if law == "nonsmooth" else 200)
        if O.time - begin > least and kinetic_energy(heap()) < STILL * scale:
            return


def energy_scale():
    """m g H0 [J], with H0 twice the height of the centre of mass."""
    return GRAVITY * sum(2 * b.state.mass * b.state.pos[1] for b in disks())


def material(options, friction):
    """For either law; contact dynamics takes the friction only."""
    return ViscElMat(
        young=options.young,
        poisson=0.3,
        en=max(options.restitution, LEAST_RESTITUTION),
        et=max(options.restitution, LEAST_RESTITUTION),
        density=DENSITY,
        frictionAngle=math.atan(friction),
    )


def add_floor(kind, length, grains, random):
    """A plane, or disks in a row that are held, their tops at about the same height."""
    if kind == "flat":
        O.bodies.append(utils.wall(FLOOR_TOP, axis=1, sense=1, material=grains))
        return
    for x in np.arange(0.5 * DIAMETER, length, DIAMETER):
        centre = (x, BUMPS * random.uniform(-1, 1), 0)
        O.bodies.append(utils.sphere(centre, 0.5 * DIAMETER, material=grains, fixed=True))


def build_column(aspect, seed, options):
    """Disks that have settled between the plane of symmetry and a gate; returns that."""
    O.reset()
    random = np.random.default_rng(seed)
    width, pitch = options.width * DIAMETER, (1 + SPREAD) * DIAMETER
    grains, smooth = material(options, options.mu), material(options, 0)
    farthest = max(run_out(line, aspect) for line in PUBLISHED.values())
    add_floor(options.floor, 2 * (1 + farthest) * width, grains, random)
    O.bodies.append(utils.wall(0, axis=0, sense=1, material=smooth))
    gate = O.bodies.append(utils.wall(width, axis=0, sense=-1, material=smooth))
    side_by_side = columns(options.width)
    for k in range(disks_in_column(aspect, options.width)):
        row, column = divmod(k, side_by_side)
        place = (np.array([column, row]) + 0.5) * [width / side_by_side, pitch]
        place[1] += FLOOR_TOP + CLEARANCE
        radius = 0.5 * DIAMETER * random.uniform(1 - SPREAD, 1 + SPREAD)
        room = 0.5 * pitch - radius
        centre = place + room * random.uniform(-1, 1, 2)
        disk = utils.sphere((*centre, 0), radius, material=grains)
        disk.state.blockedDOFs = "zXY"
        O.bodies.append(disk)
    sg.as_disks([b.id for b in disks()])
    O.engines = engines("nonsmooth", options)
    run_until_still("nonsmooth", options, energy_scale(), *SETTLING)
    return gate


def collapse(law, options, height):
    """Lets the column of the scene go; what became of it."""
    width, scale = options.width * DIAMETER, energy_scale()
    fall = math.sqrt(2 * height / GRAVITY)
    begin, steps, start = O.time, O.iter, time.process_time()
    run_until_still(law, options, scale, *(k * fall for k in COLLAPSE))
    integrator = sg.integrator()
    rest = heap()
    front = max(b.state.pos[0] + b.shape.radius for b in rest)
    top = max(b.state.pos[1] + b.shape.radius for b in rest)
    return {
        "run_out": front / width - 1,
        "height_over_H0": (top - FLOOR_TOP) / height,
        "left_the_heap": 1 - len(rest) / len(disks()),
        "time": O.time - begin,
        "steps": O.iter - steps,
        "cpu_seconds": time.process_time() - start,
        "kinetic_over_m_g_H0": kinetic_energy(rest) / scale,
        "capped_steps": integrator.cappedSteps,
        "largest_overlap_over_R": OVERLAP_UNIT * integrator.largestOverlap,
    }


def case(aspect, seed, options):
    gate = build_column(aspect, seed, options)
    centres = places()
    height = 2 * (centres[:, 1].mean() - FLOOR_TOP)
    width = options.width * DIAMETER
    result = {
        "nominal": aspect,
        "seed": seed,
        "aspect": height / width,
        "disks": len(centres),
        "packing_fraction": math.pi * float((radii() ** 2).sum()) / (height * width),
    }
    O.bodies.erase(gate)
    O.saveTmp("column")
    result["nonsmooth"] = collapse("nonsmooth", options, height)
    result["profile"] = np.column_stack([places(), radii()]).tolist()
    if aspect in options.linear:
        O.loadTmp("column")
        O.engines = engines("linear", options)
        O.interactions.clear()
        result["linear"] = collapse("linear", options, height)
    return result


def run_out(line, aspect):
    """(L - L0)/L0 of a line of PUBLISHED [-]."""
    bound, slope, factor, power = line
    return np.where(np.asarray(aspect) < bound, slope * aspect, factor * np.power(aspect, power))


def summary(cases):
    """Mean and standard deviation over the seeds, by nominal aspect ratio and law."""
    rows = []
    for law in LAWS:
        for nominal in sorted({c["nominal"] for c in cases if law in c}):
            same = [c for c in cases if c["nominal"] == nominal and law in c]
            over_a = [c[law]["run_out"] / c["aspect"] for c in same]
            rows.append(
                {
                    "law": law,
                    "aspect": float(np.mean([c["aspect"] for c in same])),
                    "run_out_over_a": float(np.mean(over_a)),
                    "scatter": float(np.std(over_a, ddof=1)) if len(same) > 1 else None,
                    "height_over_H0": float(np.mean([c[law]["height_over_H0"] for c in same])),
                }
            )
    return rows


def fitted_power(cases, above):
    """Exponent of run-out over aspect among the cases above a = `above`; None for fewer than
    two."""
    tall = [(c["aspect"], c["nonsmooth"]["run_out"]) for c in cases if c["aspect"] > above]
    if len(tall) < 2:
        return None
    return float(np.polyfit(*np.log(np.array(tall)).T, 1)[0])


def draw(result, path):
    figure = Figure(figsize=(8, 3.4), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(1, 1.4))
    cases = result["cases"]
    aspects = [c["aspect"] for c in cases]
    a = np.geomspace(0.8 * min(aspects), 1.25 * max(aspects), 200)
    for (name, line), style in zip(PUBLISHED.items(), ("-", "--", ":")):
        left.loglog(a, run_out(line, a), style, color="0.5", label=name)
    for (law, name), mark in zip(LAWS.items(), "ox"):
        rows = [r for r in result["summary"] if r["law"] == law]
        if rows:
            mean = np.array([(r["aspect"], r["run_out_over_a"], r["scatter"] or 0) for r in rows])
            at, over_a, scatter = mean.T
            left.errorbar(at, at * over_a, at * scatter, fmt=mark, ms=5, capsize=3, label=name)
    left.set_xlabel("$a = H_0/L_0$")
    left.set_ylabel("$(L - L_0)/L_0$")
    nominal = sorted({c["nominal"] for c in cases})
    left.set_xticks(nominal, labels=[f"{x:g}" for x in nominal])
    left.xaxis.set_minor_formatter(NullFormatter())
    left.set_xlim(a[0], a[-1])
    least = min(r["aspect"] * r["run_out_over_a"] for r in result["summary"])
    left.set_ylim(min(0.5 * a[0], 0.8 * least) if least > 0 else 0.5 * a[0], 4 * a[-1])
    figure.legend(loc="outside lower center", ncols=3, frameon=False, fontsize=8)
    last = np.array(cases[-1]["profile"])
    width = result["width"] * DIAMETER
    right.scatter(last[:, 0] / width, last[:, 1] / width, s=2, color="0.3")
    right.axvline(1, color="0.7", lw=0.8)
    reach = 1 + cases[-1]["nonsmooth"]["run_out"]
    right.set_xlim(0, 1.1 * reach)
    right.set_aspect("equal")
    right.set_xlabel("$x/L_0$")
    right.set_ylabel("$y/L_0$")
    right.set_title(f"deposit, a = {cases[-1]['aspect']:.1f}", fontsize=9)
    figure.savefig(path, dpi=150)


def main():
    options = parse_options()
    cases = []
    for aspect in sorted(options.aspects):
        for seed in options.seeds:
            cases.append(case(aspect, seed, options))
            shown = {k: v for k, v in cases[-1].items() if k != "profile"}
            print(json.dumps(shown), flush=True)
    result = {
        "mu": options.mu,
        "restitution": options.restitution,
        "tolerance": options.tolerance,
        "floor": options.floor,
        "width": options.width,
        "cases": cases,
        "summary": summary(cases),
        "power_above_2": fitted_power(cases, 2),
    }
    for row in result["summary"]:
        print(json.dumps(row))
    command_line.write_result(options, result)
    draw(result, options.out / "rigid_column.png")


if __name__ == "__main__":
    main()
