"""What runs, what stops with a clear message, and nothing that goes wrong in silence.

Run it with YADE: ``scripts/yade -n -x scripts/benchmark/stability.py --quick --out DIR``. Each
study drives one parameter through its range on a scene of a few grains. A case *runs*, *stops* (an
error that names the parameter or the grain), or is *wrong*: it ran, but a figure is beyond its
bound. Every study runs in a process of its own; ``stability.csv``, ``stability.md`` and
``stability.png`` hold all of them.
"""

import json
import math
import subprocess
import sys
from pathlib import Path

from yade import O

from softgrain import command_line

sys.path.append(str(Path(sys.argv[0]).resolve().parent))  # in YADE, __file__ is its start script

import stability_report as report  # noqa: E402
from stability_scenes import (  # noqa: E402
    DENSITY,
    PAIR_MU,
    RADIUS,
    YOUNG,
    ZETA,
    collide,
    compact,
    material,
    press_disk,
    press_pair,
    rest,
    ripple,
    stiff_among_soft,
    tremble,
    wave_speed,
)

#: Bounds of the figures of a case that runs; beyond, it is wrong.
BOUNDS = {
    "energy_error": 0.02,  # of the balance, over the largest energy or work
    "overlap_over_dr": 0.5,
    "momentum_error": 1e-9,  # over the momentum of one grain
    "force_difference": 1e-6,  # of scenes that must be equal, relative
    "drift_over_D": 2e-5,  # of a grain at rest, whose last vibrations settle
    "energy_growth": 1e-3,  # of a grain at rest, over its elastic energy
    "tremor": 1e-6,  # kinetic energy of damped grains that should have come to rest, over elastic
    "ripple": 0.022,  # of stress from point to point over E; of an unstable step 0.028
}


# --- studies -------------------------------------------------------------------------------------


def time_step(quick):
    """Fraction of the critical step (set_time_step)"""
    for fraction in (
        (0.1, 0.5, 0.9, 1.0, 1.2) if quick else (0.1, 0.3, 0.5, 0.7, 0.9, 1.0, 1.1, 1.2)
    ):
        yield fraction, lambda: press_disk(fraction=fraction, depth=0.3)


def ripples(quick):
    """Fraction of the critical step; ripples of stress inside 16 grains compacted to phi = 0.94"""
    for fraction in (0.9,) if quick else (0.2, 0.5, 0.8, 0.9, 1.0):
        yield fraction, lambda: ripple(fraction)


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
    """Poisson's ratio in plane strain, delta/D = 0.3"""
    for nu in (-0.5, 0.499) if quick else (-0.7, -0.5, -0.3, 0.0, 0.3, 0.45, 0.49, 0.499, 0.5):
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


def trembling(quick):
    """Coefficient of friction of nine damped disks between frictionless walls that stand still"""
    for mu in (0.0,) if quick else (0.0, 0.1, 0.3, 1.0):
        yield mu, lambda: tremble(mu)


def undamped(quick):
    """Scatter of the radii of nine such disks without damping, mu = 0.3, 60 000 steps later"""
    for scatter in (0.02,) if quick else (0.0, 0.02):
        yield scatter, lambda: tremor_that_stays(scatter, 2000 if quick else 60_000)


def tremor_that_stays(scatter, steps):
    """Nothing takes it out, so no bound holds for it."""
    figures = tremble(0.3, damping=0, scatter=scatter, steps=steps)
    return {"kinetic_over_elastic": figures.pop("tremor"), **figures}


def multirate(quick):
    """Ratio of Young's moduli of small and big disks that take steps of their own, in a packing"""
    for ratio in (10.0,) if quick else (1.0, 3.0, 10.0, 30.0, 100.0, 1000.0):
        yield ratio, lambda: stiff_among_soft(ratio, 2000 if quick else 20_000)


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
        ripples,
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
        trembling,
        undamped,
        multirate,
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
    command_line.write_json(options.out / f"{name}.json", rows)


def make_in_child(name, options):
    """The same in a process of its own: what stopped may have left a scene that is of no use."""
    (options.out / f"{name}.json").unlink(missing_ok=True)  # no rows of an earlier run
    script = sys.argv[0]  # in YADE, __file__ is YADE's own start script
    command = ["yade", "-n", "-x", "-j1", script, f"--only={name}", f"--out={options.out}"]
    subprocess.run(command + ["--quick"] * options.quick, check=True)


def read_rows(out, names):
    return {name: json.loads((out / f"{name}.json").read_text()) for name in names}


def parse_options(arguments=None):
    parser = command_line.case_parser(__doc__, out="stability")
    parser.add_argument(
        "--only", choices=STUDIES, metavar="NAME", nargs="+", help=", ".join(STUDIES)
    )
    parser.add_argument("--quick", action="store_true", help="few values and small scenes")
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
    report.write_csv(options.out, studies)
    titles = {name: STUDIES[name].__doc__ for name in names}
    report.write_markdown(options.out, studies, titles)
    report.draw(options.out, studies)
    wrong = [
        f"{name} {row['value']:g}"
        for name, rows in studies.items()
        for row in rows
        if row["outcome"] == "wrong"
    ]
    print(f"wrong: {', '.join(wrong) or 'none'}. Results in {options.out}/")


if __name__ == "__main__":
    main()
