"""Where the time goes: each phase of a step, beside the work done and the machine's limits.

Run it on the platform: ``scripts/yade --version && scripts/platform/shell python3
scripts/benchmark/run.py --out doc/benchmarks``. Every case (``scenes.py``) runs in a process of its
own; ``NAME.md`` and ``NAME.csv`` hold all of them, NAME being that of the machine.
"""

import csv
import json
import re
import shlex
import subprocess
import sys
import tempfile
from pathlib import Path

from softgrain import _softgrain, command_line

SCENES = Path(__file__).resolve().with_name("scenes.py")
BUILD = Path(_softgrain.__file__).resolve().parents[2]
ROOFLINE = "softgrain_benchmark_roofline"

#: Cases of different sizes: all grains computed in every step, or each at a rate of its own.
ONE_STEP, OWN_STEPS = "radii 1 : 10, one step", "radii 1 : 10, own steps"

#: Floating-point operations counted for a contact visited by a sweep in 2D: its impulse changes the
#: velocities of some 15 nodes on either side, two operations for each component. (No such number in
#: 3D: pushes move those nodes only that bear contacts, more or fewer from scene to scene.)
FLOPS_PER_VISIT_2D = 2 * 15 * 2 * 2

#: Vectors of each background node that a phase cannot but read and write: x and f; v, f and v+; v+,
#: x and x again. (What grains share stays in the caches; surfaces come on top.)
NODAL_VECTORS = {"updateForces": 2, "predictVelocities": 3, "move": 3}
YADE_ENGINES = ("ForceResetter", "InsertionSortCollider", "InteractionLoop", "NewtonIntegrator")


class Case:
    """A column of the tables: a scene with its settings, those of ``--quick`` on top."""

    def __init__(self, name, scene, quick=None, **settings):
        self.name, self.scene = name, scene
        self.full, self.quick = settings, {**settings, **(quick or {})}


def cases():
    bulk = {"grains": 400, "steps": 100, "repeat": 9}
    apart = {"grains": 20, "steps": 20}
    own = {**bulk, "grains": 100, "own_templates": True}
    packing = {"grains": 400, "steps": 40}
    small = {"grains": 100, "zeta": 0.15}
    many = {"zeta": 0.155, "steps": 10}
    fewer = {"grains": 1000}
    solid = {"dim": 3, "zeta": 0.2, "node_spacing": 2, "grains": 64, "steps": 10}
    fewer_balls = {"grains": 16, "steps": 20}
    pressed = {"grains": 30, "zeta": 0.2}
    loose = {"grains": 25, "zeta": 0.2, "until_phi": 0.9}
    return [
        Case("bulk, h = 2 dr", "bulk", {"steps": 20}, **bulk, node_spacing=2),
        Case("bulk, h = 1.25 dr", "bulk", {"steps": 20}, **bulk),
        Case("bulk, own templates", "bulk", apart, **own),
        Case("bulk, own templates, h = 2 dr", "bulk", apart, **own, node_spacing=2),
        Case("bulk, updated", "bulk", {"steps": 5}, **{**bulk, "steps": 20}, formulation="updated"),
        Case("bulk, 3D quadratic", "bulk", fewer_balls, **solid, order=2),
        Case("bulk, 3D cubic", "bulk", fewer_balls, **solid, order=3),
        Case("dense", "dense", small, **packing),
        Case("dense, weight and damping", "dense", small, **packing, damped=True),
        Case("dense, hexagons", "hexagons", small, **packing),
        Case("rigid", "rigid", {"grains": 100}, **{**packing, "steps": 2000}),
        Case("compaction", "paper", loose, grains=400),
        Case("compaction, h = 2 dr", "paper", loose, grains=400, node_spacing=2),
        Case("compaction, tolerance 1e-3", "paper", loose, grains=400, tolerance=1e-3),
        Case("scale, few", "scale", {}, **many, grains=400),
        Case("scale, many", "scale", fewer, **many, grains=10000),
        Case("scale, own templates", "scale", {}, **many, grains=400, own_templates=True),
        Case("at rest, all computed", "sleeping", fewer, grains=10000, steps=5),
        Case("at rest, skipped", "sleeping", fewer, grains=10000, steps=5, skip=True),
        Case(
            "packing at rest, all computed", "resting", {"zeta": 0.15}, **{**packing, "grains": 25}
        ),
        Case(
            "packing at rest, asleep",
            "resting",
            {"zeta": 0.15},
            **{**packing, "grains": 25},
            skip=True,
        ),
        Case("balls", "balls", {"grains": 27}, **{**solid, "grains": 125}),
        Case("mixed", "mixed", small, **packing),
        Case(ONE_STEP, "sizes", pressed, grains=100, zeta=0.15, steps=100),
        Case(OWN_STEPS, "sizes", pressed, grains=100, zeta=0.15, steps=100, multirate=True),
        Case("save and load", "saving", {**small, "repeat": 3}, grains=400),
    ]


def run_case(case, threads, options):
    """Figures of a case; None, and a line on stderr, if it failed."""
    settings = case.quick if options.quick else case.full
    with tempfile.TemporaryDirectory() as folder:
        result, log = Path(folder) / "result.json", Path(folder) / "log.txt"
        command = ["yade", "-n", "-x", f"-j{threads}", str(SCENES), case.scene]
        command.append(f"--result={result}")
        for name, value in settings.items():
            flag = "--" + name.replace("_", "-")
            command += [flag] if value is True else [f"{flag}={value}"]
        print(f"running {case.name}, {threads} thread(s)", file=sys.stderr)
        with open(log, "w") as file:
            subprocess.run(command, stdout=file, stderr=file, cwd=folder)
        if result.exists():
            return json.loads(result.read_text())
        print(f"failed: {case.name}\n{log.read_text()[-2000:]}", file=sys.stderr)
        return None


# --- the machine ---------------------------------------------------------------------------------


def machine_name():
    """With family and model, since virtual machines may call different processors the same."""
    fields = {}
    for line in Path("/proc/cpuinfo").read_text().splitlines():
        key, _, value = line.partition(":")
        fields.setdefault(key.strip(), value.strip())
    which = [f"{key} {fields[key]}" for key in ("cpu family", "model") if key in fields]
    return ", ".join([fields.get("model name", "unknown processor"), *which])


def limits(threads):
    """Peak and bandwidth of this machine: what ``roofline.cpp`` prints."""
    if not (BUILD / "build.ninja").exists():
        sys.exit(f"{BUILD} is no build folder: this program needs a plugin built, not installed")
    subprocess.run(["ninja", "-C", str(BUILD), ROOFLINE], check=True, stdout=subprocess.DEVNULL)
    program = BUILD / "scripts/benchmark/kernel" / ROOFLINE
    return json.loads(subprocess.check_output([str(program), str(threads)]))


# --- figures -------------------------------------------------------------------------------------


def flops_per_point(settings):
    """Floating-point operations that a material point needs with a plain stencil: dim^2
    multiply-adds for each of its (order + 1)^dim nodes, once for F and once for the forces. The
    law is not counted."""
    dim, order = settings.get("dim", 2), settings.get("order", 3)
    return 2 * 2 * dim**2 * (order + 1) ** dim


def costs(figures, settings, limit):
    """Rows (name, value) of what follows from times and counts."""
    phases, counts = figures["phases"], figures["counts"]
    wall = figures["wall"] * figures["busy"]
    peak = 1e9 * limit["peak_gflops"]
    rows = {}
    if counts.get("pointsUpdated"):
        bulk = phases["updateForces"] / counts["pointsUpdated"]
        rows["updateForces, ns a point"] = 1e9 * bulk
        rows["updateForces, % of peak multiply-adds"] = (
            100 * flops_per_point(settings) / bulk / peak
        )
        rows["all phases, ns a point"] = 1e9 * wall / counts["pointsUpdated"]
    if counts.get("contactsSwept"):
        visit = phases["solve"] / counts["contactsSwept"]
        rows["solve, ns a contact and sweep"] = 1e9 * visit
        if settings.get("dim", 2) == 2:
            rows["solve, % of peak multiply-adds"] = 100 * FLOPS_PER_VISIT_2D / visit / peak
        rows["sweeps a step"] = counts["totalSweeps"]
    if counts.get("pairsSearched"):
        search = phases.get("findContacts", 0.0)
        rows["findContacts, ns a pair"] = 1e9 * search / counts["pairsSearched"]
        rows["findContacts, % of the step"] = 100 * search / wall
    if counts:
        own = sum(phases.get(name, 0.0) for name in YADE_ENGINES)
        rows["YADE's own engines, % of the step"] = 100 * own / wall
    if "nodes" in figures:
        rows.update(shares_of_bandwidth(figures, settings, limit))
    if "setup" in figures:
        rows["set-up, us a grain"] = 1e6 * figures["setup"] / figures["grains"]
    rows["us a grain and step"] = 1e6 * wall / figures["grains"]
    if "dt" in figures:
        rows["s a simulated second and grain"] = wall / figures["dt"] / figures["grains"]
    return rows


def shares_of_bandwidth(figures, settings, limit):
    """Rows (name, value) for NODAL_VECTORS, all grains being computed."""
    vector = 8 * settings.get("dim", 2)
    passed = vector * figures["nodes"] * figures["grains"] / (1e9 * limit["memory_gb_per_s"])
    return {
        f"{phase}, % of memory bandwidth": 100 * vectors * passed / figures["phases"][phase]
        for phase, vectors in NODAL_VECTORS.items()
    }


#: Figures that some cases have: name in the table, factor.
EXTRAS = {
    "seconds": ("whole run, s of the clock", 1),
    "setup": ("set-up, s", 1),
    "bytes_per_point": ("memory, bytes a point", 1),
    "save": ("save, s", 1),
    "load": ("load and first step, s", 1),
    "bytes": ("file, MB", 1e-6),
    "whole": ("point updates before, millions", 1e-6),
    "force": ("force on the wall, N/m", 1),
    "skipping": ("grains at rest skipped: 1", 1),
}


def column(case, figures, options, limit):
    """The column of a case: section to {row: value}."""
    settings = case.quick if options.quick else case.full
    general = {name: figures[name] for name in ("threads", "grains", "points") if name in figures}
    general["peak memory, MB"] = 1e-6 * figures["peak_memory"]
    if "steps" in figures:
        general["steps"] = figures["steps"]
    if "wall" in figures:
        general["a step, ms"] = 1e3 * figures["wall"] * figures["busy"]
        general["share of the processor, %"] = 100 * figures["busy"]
    found = {label: factor * figures[k] for k, (label, factor) in EXTRAS.items() if k in figures}
    sections = {"case": general, "figures": found}
    if "wall" in figures:
        sections["figures"].update(costs(figures, settings, limit))
        sections["phases, ms a step"] = {k: 1e3 * v for k, v in figures["phases"].items()}
        sections["work a step"] = figures["counts"]
    return sections


def compare(columns):
    """Figures that take two cases: (what, value)."""
    cost = {key: {**sections["case"], **sections["figures"]} for key, sections in columns.items()}
    found = []

    def ratio(text, row, over, under, threads):
        a, b = cost.get((over, threads), {}), cost.get((under, threads), {})
        if row in a and b.get(row):
            found.append((f"{text}, {threads} thread(s)", a[row] / b[row]))

    for threads in sorted({threads for _, threads in columns}):
        step, each = "a step, ms", "us a grain and step"
        ratio("soft over rigid, a grain and step", each, "dense", "rigid", threads)
        ratio("weight and damping over none", step, "dense, weight and damping", "dense", threads)
        simulated = "s a simulated second and grain"
        ratio("soft over rigid, a simulated second", simulated, "dense", "rigid", threads)
        point = "all phases, ns a point"
        ratio("updated over total", point, "bulk, updated", "bulk, h = 1.25 dr", threads)
        many, few, own = (f"scale, {which}" for which in ("many", "few", "own templates"))
        setup = "set-up, us a grain"
        ratio("many over few grains, a point and step", point, many, few, threads)
        ratio("many over few grains, set-up of a grain", setup, many, few, threads)
        ratio("templates of their own over one, set-up of a grain", setup, own, few, threads)
        for what in (step, "point updates before, millions", "force on the wall, N/m"):
            ratio(f"one step over own steps: {what}", what, ONE_STEP, OWN_STEPS, threads)
        ratio("skipped over computed", step, "at rest, skipped", "at rest, all computed", threads)
        asleep, awake = "packing at rest, asleep", "packing at rest, all computed"
        ratio("asleep over computed", step, asleep, awake, threads)
        for name in dict.fromkeys(name for name, _ in columns):
            one, more = cost.get((name, 1), {}), cost.get((name, threads), {})
            if threads > 1 and step in one and step in more:
                found.append((f"speed-up, {name}, {threads} threads", one[step] / more[step]))
    return found


# --- tables --------------------------------------------------------------------------------------


def number(value):
    if value is None:
        return ""
    return f"{value:.0f}" if value == int(value) or abs(value) >= 1000 else f"{value:.3g}"


def tables(columns):
    """Lines of the Markdown tables, one for the cases of each scene."""
    scene_of = {case.name: case.scene for case in cases()}
    for scene in dict.fromkeys(scene_of[name] for name, _ in columns):
        cells = {key: c for key, c in columns.items() if scene_of[key[0]] == scene}
        yield from ("", f"## {scene}", "", *table(cells))


def table(columns):
    """Lines of a Markdown table: a row for each quantity, a column for each case."""
    names = [f"{name} ({threads})" for name, threads in columns]
    lines = ["| | " + " | ".join(names) + " |", "|---" * (len(names) + 1) + "|"]
    for section in ("case", "figures", "phases, ms a step", "work a step"):
        rows = dict.fromkeys(row for c in columns.values() for row in c.get(section, {}))
        if not rows:
            continue
        lines.append(f"| **{section}** |" + " |" * len(names))
        for row in rows:
            cells = [number(c.get(section, {}).get(row)) for c in columns.values()]
            lines.append(f"| {row} | " + " | ".join(cells) + " |")
    return lines


def write_markdown(path, columns, machine):
    lines = [
        f"# {machine_name()}",
        "",
        f"Made by `run.py {shlex.join(sys.argv[1:])}`; numbers of threads in brackets.",
        "",
    ]
    lines += ["| threads | instruction set | peak, GFLOP/s | memory, GB/s | cache, GB/s |"]
    lines += ["|---|---|---|---|---|"]
    for threads, limit in machine.items():
        speeds = [limit[k] for k in ("peak_gflops", "memory_gb_per_s", "cache_gb_per_s")]
        cells = [threads, limit["instruction_set"], *[number(v) for v in speeds]]
        lines.append("| " + " | ".join(str(cell) for cell in cells) + " |")
    lines += ["", "| compared | |", "|---|---|"]
    lines += [f"| {what} | {number(value)} |" for what, value in compare(columns)]
    lines += tables(columns)
    path.write_text("\n".join(lines) + "\n")


def write_csv(path, columns, machine):
    with open(path, "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(("case", "threads", "section", "quantity", "value"))
        for threads, limit in machine.items():
            for quantity, value in limit.items():
                writer.writerow(("machine", threads, "limits", quantity, value))
        for what, value in compare(columns):
            writer.writerow(("compared", "", "", what, f"{value:.6g}"))
        for (name, threads), sections in columns.items():
            for section, rows in sections.items():
                for row, value in rows.items():
                    writer.writerow((name, threads, section, row, f"{value:.6g}"))


def parse_options():
    parser = command_line.case_parser(__doc__, out="benchmark")
    add = parser.add_argument
    add("--quick", action="store_true", help="smaller scenes, under two minutes")
    add(
        "--threads",
        type=command_line.whole_from(1),
        nargs="+",
        default=[1],
        help="numbers of threads [-]",
    )
    names = [case.name for case in cases()]
    add("--only", nargs="+", choices=names, default=names, help="cases", metavar="CASE")
    add("--name", default=re.sub(r"\W+", "_", machine_name().lower()), help="of the tables")
    return parser.parse_args()


def main():
    options = parse_options()
    machine = {threads: limits(threads) for threads in options.threads}
    columns, failures = {}, 0
    for case in cases():
        for threads in options.threads if case.name in options.only else ():
            figures = run_case(case, threads, options)
            if figures:
                columns[case.name, threads] = column(case, figures, options, machine[threads])
            else:
                failures += 1
            write_csv(options.out / f"{options.name}.csv", columns, machine)
            write_markdown(options.out / f"{options.name}.md", columns, machine)
    print((options.out / f"{options.name}.md").read_text())
    if failures:
        sys.exit(f"{failures} cases failed")


if __name__ == "__main__":
    main()
