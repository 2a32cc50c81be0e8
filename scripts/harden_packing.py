"""A packing of soft disks under stress, some of them turned rigid: what the walls feel.

Run it with YADE: ``scripts/yade -n -x scripts/harden_packing.py --out DIR``. ``result.json`` has
for each treatment the change of the mean forces on the walls, the largest one on the way there, and
how far walls that are held by the stress have moved.
"""

import math
import sys

import numpy as np
from yade import FrictMat, O, pack

import softgrain as sg
from softgrain import command_line, hardening

SIDE = 0.1  # m, of the loose box
RADIUS = 0.01  # m, mean
FRICTION = 0.3
DAMPING = 400  # 1/s, of the soft disks
SAMPLES, STEPS_PER_SAMPLE = 40, 25  # of a mean
CONSOLIDATION = 0.25  # s, longest
LEAST_SHARE = 0.5  # of the stress, that every wall is to bear by then


def parse_options(arguments=None):
    parser = command_line.case_parser(__doc__, out="harden_packing")
    add = parser.add_argument
    add("--zeta", type=command_line.resolution, default=0.15, help="relative resolution [-]")
    add("--seed", type=command_line.seed, default=1, help="of the packing")
    add("--stress", type=command_line.positive, default=2e5, help="on the walls [Pa]; E = 1e6")
    add("--walls", choices=("still", "held"), default="still", help="held: by the stress")
    add(
        "--which",
        choices=("apart", "half"),
        default="apart",
        help="apart: no two that touch each other, nor a wall; half: every second one",
    )
    add(
        "--errors",
        type=command_line.number(hardening.ERROR_RANGE),
        nargs="+",
        default=[0.005, 0.01, 0.02, 0.05],
        help="of the outlines of clumps, over the radius [-]",
    )
    add(
        "--depth",
        type=command_line.fraction,
        default=hardening.DEPTH_OVER_ERROR,
        help="by which spheres may leave the outline, over the error [-]",
    )
    return parser.parse_args(arguments)


def make_packing(options):
    """Disks in a box that its walls squeeze to the stress; ids of disks and walls."""
    grains = O.materials.append(FrictMat(frictionAngle=math.atan(FRICTION), label="grains"))
    cloud = pack.SpherePack()  # of as many of 20 as find room
    corners = (0, 0, 0), (SIDE, SIDE, 0)
    cloud.makeCloud(*corners, rMean=RADIUS, rRelFuzz=0.2, num=20, seed=options.seed)
    ids = cloud.toSimulation(material="grains")
    for i in ids:
        O.bodies[i].state.blockedDOFs = "zXY"
    walls = O.bodies.append(sg.walls_around((0, 0), (SIDE, SIDE), grains))
    soft = sg.SoftMat(
        young=1e6,
        poisson=0.45,
        density=1000,
        frictionAngle=math.atan(FRICTION),
        massDamping=DAMPING,
    )
    sg.soften(ids, material=soft, zeta=options.zeta)
    O.engines = sg.engines(rigid="nonsmooth")
    goal = (-options.stress, -options.stress, 0)
    control = sg.WallStressController(walls=walls, goal=goal)
    sg.insert_before_solve(control)
    sg.set_time_step(0.8)
    while O.time < CONSOLIDATION:
        sg.advance(200)
    return ids, walls


def touched(i, others):
    return any(
        {j.id1, j.id2} & others
        for j in O.interactions.withBody(i)
        if j.isReal and j.phys.activeContacts
    )


def chosen(options, ids, walls):
    if options.which == "half":
        return ids[::2]
    found = []
    for i in ids:
        if not touched(i, set(walls) | set(found)):
            found.append(i)
    return found


def forces(walls):
    """Normal ones on the walls [N/m]."""
    return np.array([abs(sg.wall_force(w)[k // 2]) for k, w in enumerate(walls)])


def mean_forces(walls):
    total = np.zeros(len(walls))
    for _ in range(SAMPLES):
        sg.advance(STEPS_PER_SAMPLE)
        total += forces(walls)
    return total / SAMPLES


def places(walls):
    return np.array([O.bodies[w].state.pos[k // 2] for k, w in enumerate(walls)])


def lengths(walls):
    x = places(walls)
    return np.array([x[1] - x[0], x[3] - x[2]])


def require_stress(options, walls, force):
    """End the run where the walls have not met the grains in time: there is nothing to compare."""
    share = force / (options.stress * np.repeat(lengths(walls)[::-1], 2))
    if share.min() < LEAST_SHARE:
        sys.exit(
            f"--stress: after {CONSOLIDATION} s under {options.stress} Pa a wall bears "
            f"{share.min():.2g} of it, less than {LEAST_SHARE}; give a higher one"
        )


def start(options):
    """From the consolidated packing."""
    O.loadTmp("consolidated")
    if options.walls == "still":
        (control,) = [e for e in O.engines if isinstance(e, sg.WallStressController)]
        control.stressMask, control.goal = 0, (0, 0, 0)  # rates of strain


def treat(options, which, walls, before, **treatment):
    """Harden, go on; what became of it, None for errors."""
    start(options)
    size = lengths(walls)
    made = sg.harden(which, O.materials["grains"], **treatment)
    parts = [O.bodies[i].shape.ids if O.bodies[i].isClump else [i] for i in made.ids]
    fastest, worst = 0.0, 0.0
    try:
        for _ in range(2 * SAMPLES):
            sg.advance(STEPS_PER_SAMPLE)
            fastest = max(fastest, *(b.state.vel.norm() for b in O.bodies if b))
            worst = max(worst, np.abs(forces(walls) / before - 1).max())
        after = mean_forces(walls)
    except RuntimeError as error:
        return {**treatment, "stopped": str(error).splitlines()[0]}
    return {
        **treatment,
        "rigid_bodies_per_grain": sum(map(len, parts)) / len(made.bodies),
        "force_after_over_before": after / before,
        "mean_change": after.mean() / before.mean() - 1,
        "largest_change": np.abs(after / before - 1).max(),
        "largest_change_on_the_way": worst,
        "fastest": fastest,
        "strain": np.log(lengths(walls) / size),
        "capped_steps": int(sg.integrator().cappedSteps),
    }


def main():
    options = parse_options()
    hardening.DEPTH_OVER_ERROR = options.depth
    ids, walls = make_packing(options)
    which = chosen(options, ids, walls)
    facts = {
        "phi": sg.packing_fraction(float(np.prod(lengths(walls)))),
        "kinetic_over_elastic": sg.quasi_static()["kinetic_over_elastic"],
        "disks": len(ids),
        "hardened": which,
    }
    O.saveTmp("consolidated")
    start(options)
    before = mean_forces(walls)
    require_stress(options, walls, before)
    treatments = [{"into": "clumps", "error": error} for error in options.errors]
    if options.which == "apart":  # fixed ones and walls do not feel each other
        treatments.append({"into": "fixed"})
    treatments.append({"into": "spheres"})
    results = [treat(options, which, walls, before, **t) for t in treatments]
    command_line.write_result(
        options,
        {
            **facts,
            "force_before": before,
            "treatments": results,
        },
    )
    for r in results:
        name = f"{r['into']} {r.get('error', '')}"
        if "stopped" in r:
            print(f"{name:14s} stopped: {r['stopped']}")
            continue
        print(
            f"{name:14s} {r['rigid_bodies_per_grain']:5.1f} bodies a grain; forces change by "
            f"{100 * r['mean_change']:+.2f} % (mean), {100 * r['largest_change']:.2f} % (largest), "
            f"{100 * r['largest_change_on_the_way']:.1f} % on the way; "
            f"fastest {r['fastest']:.3f} m/s; strain {r['strain'][0]:+.1e}, {r['strain'][1]:+.1e}"
        )


if __name__ == "__main__":
    main()
