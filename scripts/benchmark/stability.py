"""What runs, what stops with a clear message, and nothing that goes wrong in silence.

Run it with YADE: ``scripts/yade -n -x scripts/benchmark/stability.py --quick --out DIR``. Each
study drives one parameter through its range on a scene of a few grains. A case *runs*, *stops* (an
error that names the parameter or the grain), or is *wrong*: it ran, but a figure is beyond its
bound. Every study runs in a process of its own; ``stability.csv``, ``stability.md`` and
``stability.png`` hold all of them.
"""

import argparse
import csv
import json
import math
import subprocess
import sys
from pathlib import Path

import matplotlib.figure
import numpy as np
import yade.utils
from yade import FrictMat, O

import softgrain as sg
from softgrain import command_line

RADIUS, YOUNG, DENSITY = 0.01, 1e6, 1000.0  # m, Pa, kg/m3
ZETA = 0.2  # coarse: accuracy is not the point
PAIR_MU = 0.5  # friction of two disks that are pressed on each other

#: Bounds of the figures of a case that runs; beyond, it is wrong.
BOUNDS = {
    "energy_error": 0.02,  # of the balance, over the largest energy or work
    "overlap_over_dr": 0.5,
    "momentum_error": 1e-9,  # over the momentum of one grain
    "force_difference": 1e-6,  # of scenes that must be equal, relative
    "drift_over_D": 1e-5,  # of a grain at rest, whose last vibrations settle
    "energy_growth": 1e-3,  # of a grain at rest, over its elastic energy
}


def wave_speed(young=YOUNG, poisson=0.45, density=DENSITY):
    """Of pressure waves in plane strain [m/s]."""
    modulus = young * (1 - poisson) / ((1 + poisson) * (1 - 2 * poisson))
    return math.sqrt(modulus / density)


# --- scenes --------------------------------------------------------------------------------------


def material(mu=0.0, **attributes):
    values = {"young": YOUNG, "poisson": 0.45, "density": DENSITY, **attributes}
    return sg.SoftMat(frictionAngle=math.atan(mu), **values)


def add_disk(center, radius=RADIUS, soft=None, **shape):
    body = sg.soft_disk(center, radius, soft or material(), **{"zeta": ZETA, **shape})
    return O.bodies.append(body)


def add_wall(position, axis, sense, velocity=0.0, mu=0.0):
    wall = O.bodies.append(
        yade.utils.wall(
            position, axis=axis, sense=sense, material=FrictMat(frictionAngle=math.atan(mu))
        )
    )
    O.bodies[wall].state.vel = [velocity if a == axis else 0 for a in range(3)]
    return wall


def prepare(fraction=0.5, **engine):
    O.trackEnergy = True
    O.engines = sg.engines(**engine)
    sg.set_time_step(fraction)


def run(steps):
    """Steps without Python between them; an error that YADE lost on the way is raised here."""
    O.run(steps, True)
    if sg.integrator().lastError:
        raise RuntimeError(sg.integrator().lastError)


def common_figures(balance):
    engine = sg.integrator()
    return {
        "steps": engine.steps,
        "energy_error": balance.error(),
        "overlap_over_dr": engine.largestOverlap,
        "capped_share": engine.cappedSteps / max(engine.steps, 1),
        "sweeps": engine.totalSweeps / max(engine.steps, 1),
    }


def squeeze(bottom, top, speed, distance, scale):
    """Move the top wall down by `distance`; the mean force of both walls over the last quarter,
    over `scale`, their imbalance, and the common figures."""
    O.bodies[top].state.vel = (0, -speed, 0)
    run(1)
    balance = sg.Balance()
    start = O.bodies[top].state.pos[1]
    forces = []
    stride = max(5, round(distance / speed / O.dt / 500))  # each call of YADE's costs a wait
    while (moved := start - O.bodies[top].state.pos[1]) < distance:
        run(stride)
        balance.error()
        if moved > 0.75 * distance:
            forces.append((-O.forces.f(bottom)[1], O.forces.f(top)[1]))
    below, above = np.mean(forces, axis=0)
    return {
        "force": 0.5 * (below + above) / scale,
        "imbalance": abs(above - below) / max(abs(above + below), 1e-300),
        **common_figures(balance),
    }


def press_disk(
    poisson=0.45,
    condition="planeStrain",
    young=YOUNG,
    density=DENSITY,
    radius=RADIUS,
    speed=0.003,
    depth=0.2,
    origin=(0, 0),
    fraction=0.5,
    dt=None,
    **shape,
):
    """One disk between plates that approach by `depth` D at `speed` times its wave speed."""
    x, y = origin
    soft = material(poisson=poisson, condition=condition, young=young, density=density)
    add_disk((x, y, 0), radius, soft, **shape)
    bottom = add_wall(y - radius, 1, 1)
    top = add_wall(y + radius, 1, -1)
    prepare(fraction)
    if dt is not None:
        O.dt = dt * sg.critical_time_step()
    speed *= wave_speed(young, poisson, density)
    return squeeze(bottom, top, speed, 2 * radius * depth, 2 * young * radius)


def press_pair(radii=(RADIUS, RADIUS), materials=None, depth=0.1, speed=0.003, zetas=(ZETA, ZETA)):
    """Two disks one upon the other between plates that approach by `depth` of the smaller D. All
    have friction: without it the disks would soon slip off each other."""
    materials = materials or (material(PAIR_MU), material(PAIR_MU))
    add_disk((0, radii[0], 0), radii[0], materials[0], zeta=zetas[0])
    add_disk((0, 2 * radii[0] + radii[1], 0), radii[1], materials[1], zeta=zetas[1])
    bottom = add_wall(0, 1, 1, mu=PAIR_MU)
    top = add_wall(2 * sum(radii), 1, -1, mu=PAIR_MU)
    prepare()
    slowest = min(wave_speed(m.young, m.poisson, m.density) for m in materials)
    young = min(m.young for m in materials)
    smaller = 2 * min(radii)
    return squeeze(bottom, top, speed * slowest, depth * smaller, young * smaller)


def collide(speed, densities=(DENSITY, DENSITY)):
    """Two disks head on at `speed` times the wave speed, until they are apart again."""
    c = wave_speed()
    for x, sign, density in ((-1.02 * RADIUS, 1, densities[0]), (1.02 * RADIUS, -1, densities[1])):
        body = add_disk((x, 0, 0), soft=material(density=density))
        O.bodies[body].state.vel = (sign * 0.5 * speed * c, 0, 0)
    prepare()
    before = sum(math.pi * RADIUS**2 * d * s for d, s in zip(densities, (1, -1))) * 0.5 * speed * c
    run(1)
    balance = sg.Balance()
    end = O.time + 0.04 * RADIUS / (0.5 * speed * c) + 40 * RADIUS / wave_speed(poisson=0.3)
    while O.time < end:
        run(20)
        balance.error()
    bodies = sg.soft_bodies()
    after = sum(b.state.mass * b.state.vel[0] for b in bodies)
    unit = math.pi * RADIUS**2 * max(densities) * 0.5 * speed * c
    return {
        "momentum_error": abs(after - before) / unit,
        "restitution": (bodies[1].state.vel[0] - bodies[0].state.vel[0]) / (speed * c),
        **common_figures(balance),
    }


def compact(mu=0.3, until=0.9, per_side=3, speed=0.005, zeta=ZETA, **engine):
    """A loose square of disks of two sizes in a box whose top comes down until phi is reached."""
    soft = material(mu)
    pitch = 2.1 * RADIUS
    for k in range(per_side**2):
        i, j = k % per_side, k // per_side
        shift = 0.04 * RADIUS * math.sin(7.0 * k + 1)
        add_disk(
            ((i + 0.5) * pitch + shift, (j + 0.5) * pitch - shift, 0),
            RADIUS * (0.9 if (i + j) % 2 else 1.0),
            soft,
            zeta=zeta,
        )
    width = per_side * pitch
    add_wall(0, 0, 1), add_wall(width, 0, -1), add_wall(0, 1, 1)
    top = add_wall(width, 1, -1, -speed * wave_speed())
    prepare(**engine)
    run(1)
    balance = sg.Balance()
    phi = 0.0
    while phi < until:
        run(20 if phi < until - 0.01 else 2)
        balance.error()
        height = O.bodies[top].state.pos[1]
        phi = sg.packing_fraction(width * height)
    return {"phi": phi, "force": O.forces.f(top)[1] / width / YOUNG, **common_figures(balance)}


def rest(steps):
    """A disk in a corner with friction; gravity aslant grows slowly to 0.03 E/(rho D), then
    `steps` steps at rest. (On a plane alone it might roll, at no cost.)"""
    add_disk((RADIUS, RADIUS, 0), soft=material(0.5), zeta=0.3)
    add_wall(0, 1, 1, mu=0.5), add_wall(0, 0, 1, mu=0.5)
    prepare()
    newton = O.engines[-1]
    full = 0.03 * YOUNG / (DENSITY * 2 * RADIUS)
    ramp = 4000
    for k in range(ramp):
        g = full * 0.5 * (1 - math.cos(math.pi * (k + 1) / ramp))
        newton.gravity = (-0.5 * g, -g, 0)
        run(5)
    first = window_of_rest()
    run(max(steps - 4000, 0))
    last = window_of_rest()
    return {
        "steps": sg.integrator().steps,
        "drift_over_D": float(np.linalg.norm(last[:2] - first[:2])) / (2 * RADIUS),
        "kinetic_over_elastic": last[2] / last[3],
        "energy_growth": max(last[2] + last[3] - first[2] - first[3], 0.0) / first[3],
        "overlap_over_dr": sg.integrator().largestOverlap,
    }


def window_of_rest():
    """Mean position, kinetic and elastic energy over 2000 steps, some hundred vibrations."""
    rows = []
    for _ in range(200):
        run(10)
        x, y, _ = sg.soft_bodies()[0].state.pos
        energy = sg.integrator().energy()
        rows.append((x, y, energy["kinetic"], energy["elastic"]))
    return np.mean(rows, axis=0)


# --- studies -------------------------------------------------------------------------------------


def time_step(quick):
    """Fraction of the critical step (set_time_step)"""
    for fraction in (
        (0.1, 0.5, 0.9, 1.0, 1.2) if quick else (0.1, 0.3, 0.5, 0.7, 0.9, 1.0, 1.1, 1.2)
    ):
        yield fraction, lambda: press_disk(fraction=fraction, depth=0.3)


def own_step(quick):
    """O.dt by hand over the critical step of the undeformed grains"""
    for fraction in (0.5, 1.2) if quick else (0.1, 0.5, 0.9, 1.0, 1.1, 1.2):
        yield fraction, lambda: press_disk(dt=fraction, depth=0.3)


def wall_speed(quick):
    """Speed of a plate over the wave speed"""
    for speed in (0.01, 0.1) if quick else (0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 1.0):
        yield speed, lambda: press_disk(speed=speed, depth=0.3)


def impact_speed(quick):
    """Speed of a head-on impact of two disks over the wave speed"""
    for speed in (0.02, 0.2) if quick else (0.005, 0.02, 0.05, 0.1, 0.2, 0.4, 0.8):
        yield speed, lambda: collide(speed)


def friction(quick):
    """Coefficient of friction; 9 grains compacted to phi = 0.9"""
    for mu in (0.3, 10.0) if quick else (0.0, 0.1, 0.3, 1.0, 3.0, 10.0):
        yield mu, lambda: compact(mu=mu, per_side=2 if quick else 3)


def slow(nu):
    """The usual speed where pressure waves are fast but others are not."""
    return 0.003 * wave_speed() / wave_speed(poisson=nu) if nu < 0.5 else 0.003


def poisson_plane_strain(quick):
    """Poisson's ratio in plane strain, delta/D = 0.3 (-0.5 runs with zeta = 0.1)"""
    for nu in (-0.5, 0.499) if quick else (-0.5, -0.3, 0.0, 0.3, 0.45, 0.49, 0.499, 0.5):
        yield nu, lambda: press_disk(poisson=nu, depth=0.3, speed=slow(nu))


def poisson_plane_stress(quick):
    """Poisson's ratio in plane stress, delta/D = 0.3"""
    for nu in (-0.5, 0.49) if quick else (-0.5, -0.4, -0.3, 0.0, 0.3, 0.45, 0.49, 0.499):
        yield nu, lambda: press_disk(poisson=nu, condition="planeStress", depth=0.3, speed=slow(nu))


def poisson_projected(quick):
    """Poisson's ratio with volumetric='projected', plane strain, delta/D = 0.3"""
    for nu in (0.499,) if quick else (0.3, 0.49, 0.499):
        yield nu, lambda: press_disk(poisson=nu, depth=0.3, speed=slow(nu), volumetric="projected")


def stiffness_ratio(quick):
    """Ratio of Young's moduli of two disks pressed on each other"""
    for ratio in (1.0, 1e3) if quick else (1.0, 10.0, 100.0, 1e3, 1e4):
        pair = material(PAIR_MU), material(PAIR_MU, young=ratio * YOUNG)
        yield ratio, lambda: press_pair(materials=pair, speed=0.005)


def size_ratio(quick):
    """Ratio of radii of two disks pressed on each other, the same zeta"""
    for ratio in (1.0, 20.0) if quick else (1.0, 2.0, 5.0, 10.0, 20.0):
        yield ratio, lambda: press_pair(radii=(ratio * RADIUS, RADIUS), speed=0.003 / ratio)


def size_ratio_equal_spacing(quick):
    """Ratio of radii, zeta such that both have the same dr"""
    for ratio in (2.0,) if quick else (2.0, 5.0, 10.0, 20.0):
        radii, zetas = (ratio * RADIUS, RADIUS), (ZETA / ratio, ZETA)
        yield ratio, lambda: press_pair(radii=radii, zetas=zetas, speed=0.003 / ratio)


def density_ratio(quick):
    """Ratio of densities of two disks pressed on each other"""
    for ratio in (1.0, 1e4) if quick else (1.0, 10.0, 100.0, 1e3, 1e4):
        pair = material(PAIR_MU, density=ratio * DENSITY), material(PAIR_MU)
        yield ratio, lambda: press_pair(materials=pair)


def density_impact(quick):
    """Ratio of densities of two disks in a head-on impact at 0.02 of the wave speed"""
    for ratio in (1e4,) if quick else (10.0, 1e3, 1e4):
        yield ratio, lambda: collide(0.02, (ratio * DENSITY, DENSITY))


def packing(quick):
    """Packing fraction of 9 frictionless grains (overlaps count twice in it)"""
    for phi in (0.95,) if quick else (0.9, 0.95, 0.98, 0.99, 0.995, 0.999):
        yield phi, lambda: compact(mu=0.0, until=phi, per_side=2 if quick else 3)


def at_rest(quick):
    """Steps at rest under gravity, in a corner with friction, zeta = 0.3; a tremor is left"""
    for steps in (20_000,) if quick else (20_000, 100_000, 1_000_000):
        yield steps, lambda: rest(steps)


def distance(quick):
    """Distance from the origin over the diameter; the force against that at the origin"""
    at_origin = None
    for far in (0.0, 1e6) if quick else (0.0, 1e3, 1e6, 1e9, 1e12):

        def compare():
            nonlocal at_origin
            figures = press_disk(origin=(far * 2 * RADIUS, -far * 2 * RADIUS), depth=0.1)
            at_origin = at_origin or figures
            return {**figures, "force_difference": difference(figures, at_origin)}

        yield far, compare


def units(quick):
    """Diameter [m]; the dimensionless force against that of a grain of 1 m"""
    of_one_metre = None
    for diameter in (1.0, 1e-6) if quick else (1.0, 1e-9, 1e-6, 1e-3, 1e3, 1e6):

        def compare():
            nonlocal of_one_metre
            figures = press_disk(
                radius=diameter / 2, young=2.5e9 / diameter, density=1800.0, depth=0.1
            )
            of_one_metre = of_one_metre or figures
            return {**figures, "force_difference": difference(figures, of_one_metre)}

        yield diameter, compare


def difference(figures, reference):
    return abs(figures["force"] / reference["force"] - 1)


STUDIES = {
    study.__name__: study
    for study in (
        time_step,
        own_step,
        wall_speed,
        impact_speed,
        friction,
        poisson_plane_strain,
        poisson_plane_stress,
        poisson_projected,
        stiffness_ratio,
        size_ratio,
        size_ratio_equal_spacing,
        density_ratio,
        density_impact,
        packing,
        at_rest,
        distance,
        units,
    )
}


# --- running and reporting -----------------------------------------------------------------------


def outcome(case):
    """What came of a case: 'runs', 'stops' or 'wrong', the message, and the figures."""
    O.reset()
    try:
        figures = case()
    except (ValueError, RuntimeError) as error:
        return "stops", str(error), {}
    broken = [
        f"{name} = {value:.2g} is beyond {BOUNDS[name]:g}"
        for name, value in figures.items()
        if name in BOUNDS and not value <= BOUNDS[name]
    ]
    broken += [f"{name} = {value}" for name, value in figures.items() if not math.isfinite(value)]
    return ("wrong" if broken else "runs"), "; ".join(broken), figures


def make_study(name, options):
    """Run all cases of a study in this process and write its rows."""
    rows = []
    for value, case in STUDIES[name](options.quick):
        verdict, message, figures = outcome(case)
        rows.append({"value": value, "outcome": verdict, "message": message, "figures": figures})
        print(f"{name} {value:g}: {verdict} {message}", file=sys.stderr, flush=True)
    text = json.dumps(rows, indent=1, default=float)
    (options.out / f"{name}.json").write_text(text + "\n")


def make_in_child(name, options):
    """The same in a process of its own: what stopped may have left a scene that is of no use."""
    (options.out / f"{name}.json").unlink(missing_ok=True)  # no rows of an earlier run
    script = sys.argv[0]  # in YADE, __file__ is YADE's own start script
    command = ["yade", "-n", "-x", "-j1", script, f"--only={name}", f"--out={options.out}"]
    subprocess.run(command + ["--quick"] * options.quick, check=True)


def read_rows(out, names):
    return {name: json.loads((out / f"{name}.json").read_text()) for name in names}


def write_csv(out, studies):
    names = sorted({n for rows in studies.values() for row in rows for n in row["figures"]})
    with open(out / "stability.csv", "w", newline="") as file:
        table = csv.writer(file)
        table.writerow(["study", "value", "outcome", *names, "message"])
        for study, rows in studies.items():
            for row in rows:
                figures = [row["figures"].get(name, "") for name in names]
                table.writerow([study, row["value"], row["outcome"], *figures, row["message"]])


SHOWN = {
    "force": "F",
    "energy_error": "energy error",
    "overlap_over_dr": "overlap/dr",
    "capped_share": "capped",
    "momentum_error": "momentum error",
    "restitution": "restitution",
    "force_difference": "difference of F",
    "drift_over_D": "drift/D",
    "kinetic_over_elastic": "kinetic/elastic",
    "energy_growth": "heating",
}


PAGE = """# Stability

What runs, what stops with a message, and what would be wrong: a case that ran, but with a figure
beyond its bound (`BOUNDS` in `scripts/benchmark/stability.py`). This page is made by

    scripts/yade -n -x scripts/benchmark/stability.py --out DIR

Disks at zeta = 0.2, nu = 0.45, plane strain, unless the study says otherwise. F: mean force of both
plates over E D in the last quarter (compaction: wall stress over E at the end), as the speed of the
study has it; overlap: largest so far; capped: share of the steps whose sweeps hit the cap; heating:
growth of kinetic and elastic energy over the elastic energy. What rest means, and rest from
equilibrium: [decisions/0010](decisions/0010-grains-at-rest.md).
"""


def write_markdown(out, studies):
    lines = [PAGE]
    for study, rows in studies.items():
        columns = [n for n in SHOWN if any(n in row["figures"] for row in rows)]
        lines += [f"### {STUDIES[study].__doc__}", "", f"`--only {study}`", ""]
        lines.append("| value | outcome | " + " | ".join(SHOWN[n] for n in columns) + " |")
        lines.append("|" + "---|" * (2 + len(columns)))
        for row in rows:
            cells = [f"{row['figures'][n]:.3g}" if n in row["figures"] else "" for n in columns]
            lines.append(f"| {row['value']:g} | {row['outcome']} | " + " | ".join(cells) + " |")
        messages = [f"{row['value']:g}: {row['message']}" for row in rows if row["message"]]
        lines += ["", *(f"- {message}" for message in messages), ""]
    (out / "stability.md").write_text("\n".join(lines))


def draw(out, studies):
    """A mark for each case: one line a study."""
    figure = matplotlib.figure.Figure(figsize=(9, 0.42 * len(studies) + 1.2), layout="constrained")
    axes = figure.add_subplot()
    colours = {"runs": "tab:green", "stops": "tab:orange", "wrong": "tab:red"}
    for line, (study, rows) in enumerate(studies.items()):
        for place, row in enumerate(rows):
            axes.plot(place, -line, "s", ms=14, color=colours[row["outcome"]])
            axes.text(place, -line - 0.42, f"{row['value']:g}", ha="center", fontsize=6)
    axes.set_yticks([-k for k in range(len(studies))], list(studies), fontsize=8)
    axes.set(xticks=[], ylim=(-len(studies) + 0.2, 0.8))
    axes.set(title="runs (green), stops with a message (orange), wrong (red)")
    figure.savefig(out / "stability.png", dpi=150)


def parse_options(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "--only", choices=STUDIES, metavar="NAME", nargs="+", help=", ".join(STUDIES)
    )
    parser.add_argument("--quick", action="store_true", help="few values and small scenes")
    parser.add_argument(
        "--out", type=command_line.output_folder, default=Path("stability"), help="for results"
    )
    return parser.parse_args(arguments)


def main():
    options = parse_options()
    names = options.only or list(STUDIES)
    if len(names) == 1:
        make_study(names[0], options)
    else:
        for name in names:
            make_in_child(name, options)
    studies = read_rows(options.out, names)
    write_csv(options.out, studies)
    write_markdown(options.out, studies)
    draw(options.out, studies)
    wrong = [
        f"{name} {row['value']:g}"
        for name, rows in studies.items()
        for row in rows
        if row["outcome"] == "wrong"
    ]
    print(f"wrong: {', '.join(wrong) or 'none'}. Results in {options.out}/")


if __name__ == "__main__":
    main()
