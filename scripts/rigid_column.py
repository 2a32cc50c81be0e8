"""Granular columns that collapse on a frictional floor: rigid disks by contact dynamics.

Run it with YADE: ``scripts/yade -n -x scripts/rigid_column.py --out DIR``. Disks settle between a
smooth wall, the plane of symmetry, and a gate, a column of the height H0 and the half-width L0 on a
floor of disks that are held; the gate goes, and they run out to L. ``result.json`` and
``rigid_column.png`` have (L - L0)/L0 over the aspect ratio a = H0/L0 by contact dynamics and, with
``--linear``, by YADE's linear law (springs, dashpots, friction), from the same packing, beside what
Staron & Hinch (J. Fluid Mech. 545, 2005) found by two-dimensional contact dynamics: 2.5 a for
a < 2, 3.25 a^0.7 above.
"""

import argparse
import json
import math
import time
from pathlib import Path

import numpy as np
import yade.utils
from matplotlib.figure import Figure
from yade import (
    Ip2_ViscElMat_ViscElMat_ViscElPhys,
    Law2_ScGeom_ViscElPhys_Basic,
    O,
    Sphere,
    ViscElMat,
)

import softgrain as sg
from softgrain import command_line

DIAMETER = 0.01  # m, of a disk on average
SPREAD = 0.2  # of the radii about their mean
DENSITY = 2000.0  # kg/m3
GRAVITY = 10.0  # m/s2
MOTION = 0.02  # of the mean radius, by the fastest disk in a step
LONGEST_STEP = 4e-4  # s
RESTITUTION = 0.5  # of the linear law; contact dynamics has none
STILL = 1e-5  # kinetic energy over m g H0 at which a column stands, a deposit lies
NEAR = 0.1  # gap over the mean diameter up to which disks belong together


def parse_options(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    add = parser.add_argument
    aspects = [0.5, 1, 2, 3, 4, 6, 8]
    add("--aspects", type=command_line.positive, nargs="+", default=aspects, help="H0/L0 [-]")
    add("--linear", type=command_line.positive, nargs="*", default=[], help="those by both laws")
    add("--width", type=command_line.positive, default=12, help="L0 over the mean diameter [-]")
    add("--mu", type=command_line.non_negative, default=0.5, help="friction [-]")
    add("--young", type=command_line.positive, default=1e7, help="of YADE's linear law [Pa]")
    add("--seed", type=int, default=1, help="of the random places and radii")
    add(
        "--out",
        type=command_line.output_folder,
        default=Path("rigid_column"),
        help="folder for results",
    )
    options = parser.parse_args(arguments)
    if missing := set(options.linear) - set(options.aspects):
        parser.error(f"argument --linear: {sorted(missing)} are not among --aspects")
    return options


def disks():
    """Those that are free."""
    return [b for b in O.bodies if b and isinstance(b.shape, Sphere) and b.dynamic]


def places():
    return np.array([b.state.pos for b in disks()])[:, :2]


def radii():
    return np.array([b.shape.radius for b in disks()])


def kinetic_energy():
    """Of the disks [J]."""
    states = [b.state for b in disks()]
    return 0.5 * sum(s.mass * s.vel.squaredNorm() + s.inertia[2] * s.angVel[2] ** 2 for s in states)


def engines(law):
    made = sg.engines(rigid=law, gravity=(0, -GRAVITY, 0), verlet_distance=0.1 * DIAMETER)
    if law == "linear":
        made[2].physDispatcher.functors = [Ip2_ViscElMat_ViscElMat_ViscElPhys()]
        made[2].lawDispatcher.functors = [Law2_ScGeom_ViscElPhys_Basic()]
    return made


def run_until_still(law, scale, least, longest):
    """Runs until the kinetic energy is below STILL of `scale` [J], between two times [s]; in
    contact dynamics with steps that follow the fastest disk."""
    begin = O.time
    linear_step = 0.3 * yade.utils.PWaveTimeStep()
    while O.time - begin < longest:
        fastest = max(b.state.vel.norm() for b in disks()) + 1e-9
        O.dt = min(LONGEST_STEP, MOTION * 0.5 * DIAMETER / fastest)
        if law == "linear":
            O.dt = linear_step
        O.run(20 if law == "nonsmooth" else 200, True)
        if O.time - begin > least and kinetic_energy() < STILL * scale:
            return


def energy_scale():
    """m g H0 [J], with H0 twice the height of the centre of mass."""
    return GRAVITY * sum(2 * b.state.mass * b.state.pos[1] for b in disks())


def material(options, friction):
    """For either law: contact dynamics takes the friction only."""
    return ViscElMat(
        young=options.young,
        poisson=0.3,
        en=RESTITUTION,
        et=RESTITUTION,
        density=DENSITY,
        frictionAngle=math.atan(friction),
    )


def add_floor(length, grains, random):
    """Disks in a row that are held, their tops at about half a diameter."""
    for x in np.arange(0.5 * DIAMETER, length, DIAMETER):
        centre = (x, 0.1 * DIAMETER * random.uniform(-1, 1), 0)
        O.bodies.append(yade.utils.sphere(centre, 0.5 * DIAMETER, material=grains, fixed=True))


def build_column(aspect, options):
    """Disks that have settled between the plane of symmetry and a gate; returns that."""
    O.reset()
    random = np.random.default_rng(options.seed)
    width, pitch = options.width * DIAMETER, (1 + SPREAD) * DIAMETER
    grains, smooth = material(options, options.mu), material(options, 0)
    add_floor(2 * (1 + scaling(aspect)) * width, grains, random)
    O.bodies.append(yade.utils.wall(0, axis=0, sense=1, material=smooth))
    gate = O.bodies.append(yade.utils.wall(width, axis=0, sense=-1, material=smooth))
    columns = int(width / pitch)
    area = 0.81 * aspect * width**2  # disks settle to about that packing fraction
    for k in range(round(area / (0.25 * math.pi * DIAMETER**2))):
        row, column = divmod(k, columns)
        place = (np.array([column, row]) + 0.5) * [width / columns, pitch]
        place[1] += 0.7 * DIAMETER
        radius = 0.5 * DIAMETER * random.uniform(1 - SPREAD, 1 + SPREAD)
        room = 0.5 * pitch - radius
        centre = place + room * random.uniform(-1, 1, 2)
        disk = yade.utils.sphere((*centre, 0), radius, material=grains)
        disk.state.blockedDOFs = "zXY"
        O.bodies.append(disk)
    sg.as_disks([b.id for b in disks()])
    O.engines = engines("nonsmooth")
    run_until_still("nonsmooth", energy_scale(), 0.1, 3.0)
    return gate


def front():
    """Farthest reach of the disks that hang together with the one at the plane of symmetry [m];
    single ones that rolled away do not count."""
    centres, radius = places(), radii()
    reached = {int(np.argmin(centres[:, 0]))}
    border = list(reached)
    while border:
        i = border.pop()
        gaps = np.linalg.norm(centres - centres[i], axis=1) - radius - radius[i]
        new = set(np.flatnonzero(gaps < NEAR * DIAMETER).tolist()) - reached
        reached |= new
        border += new
    return float(max(centres[i, 0] + radius[i] for i in reached))


def collapse(law, options, height):
    """Lets the column of the scene go; what became of it."""
    width, scale = options.width * DIAMETER, energy_scale()
    fall = math.sqrt(2 * height / GRAVITY)
    begin, steps, start = O.time, O.iter, time.process_time()
    run_until_still(law, scale, fall, 12 * fall)
    integrator = sg.integrator()
    top = (places()[:, 1] + radii()).max()
    return {
        "run_out": front() / width - 1,
        "height_over_H0": top / height,
        "time": O.time - begin,
        "steps": O.iter - steps,
        "cpu_seconds": time.process_time() - start,
        "kinetic_over_m_g_H0": kinetic_energy() / scale,
        "capped_steps": integrator.cappedSteps,
        "largest_overlap_over_R": 0.1 * integrator.largestOverlap,
    }


def case(aspect, options):
    gate = build_column(aspect, options)
    centres = places()
    height = 2 * centres[:, 1].mean() - DIAMETER
    result = {
        "aspect": height / (options.width * DIAMETER),
        "disks": len(centres),
        "nonsmooth": None,
    }
    O.bodies.erase(gate)
    O.saveTmp("column")
    result["nonsmooth"] = collapse("nonsmooth", options, height)
    result["profile"] = np.column_stack([places(), radii()]).tolist()
    if aspect in options.linear:
        O.loadTmp("column")
        O.engines = engines("linear")
        O.interactions.clear()
        result["linear"] = collapse("linear", options, height)
    return result


def scaling(aspect):
    """Run-out of Staron & Hinch (2005), friction 1 [-]."""
    return np.where(np.asarray(aspect) < 2, 2.5 * aspect, 3.25 * np.power(aspect, 0.7))


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
    a = np.geomspace(0.4, 1.2 * max(c["aspect"] for c in cases), 200)
    left.loglog(a, scaling(a), color="0.5", label="Staron & Hinch 2005")
    for law, mark, name in (("nonsmooth", "o", "contact dynamics"), ("linear", "x", "linear law")):
        points = [(c["aspect"], c[law]["run_out"]) for c in cases if law in c]
        if points:
            left.loglog(*zip(*points), mark, label=name)
    left.set_xlabel("$a = H_0/L_0$")
    left.set_ylabel("$(L - L_0)/L_0$")
    left.legend(frameon=False, fontsize=8)
    last = np.array(cases[-1]["profile"])
    width = result["width"] * DIAMETER
    right.scatter(last[:, 0] / width, last[:, 1] / width, s=2, color="0.3")
    right.axvline(1, color="0.7", lw=0.8)
    right.set_aspect("equal")
    right.set_xlabel("$x/L_0$")
    right.set_title(f"deposit, a = {cases[-1]['aspect']:.1f}", fontsize=9)
    figure.savefig(path, dpi=150)


def main():
    options = parse_options()
    cases = []
    for aspect in sorted(options.aspects):
        cases.append(case(aspect, options))
        shown = {k: v for k, v in cases[-1].items() if k != "profile"}
        print(json.dumps(shown), flush=True)
    result = {
        "mu": options.mu,
        "width": options.width,
        "cases": cases,
        "power_above_2": fitted_power(cases, 2),
    }
    command_line.write_result(options.out, result)
    draw(result, options.out / "rigid_column.png")


if __name__ == "__main__":
    main()
