"""Interfaces against what they are defined by: pull-off force and work of separation of a block on
a wall, by cohesion and by a bond; a slab that starts with mu_s and slides with mu_d.

    scripts/yade -n -x scripts/interfaces.py --zeta 0.25 0.125 --out interfaces
"""

import math

from yade import FrictMat, O, utils

import softgrain as sg
from softgrain import command_line

HALF = 0.01  # half height of block and slab, m
DENSITY = 1000.0  # kg/m^3
GRAVITY = 10.0  # m/s^2
STATIC, DYNAMIC = 0.5, 0.3  # coefficients of friction
DAMPING = 200.0  # 1/s
WAIT = 0.05  # s, before a slab is pushed
SLIDING_TIME = 0.2  # s, for which it slides
SLIDING = 0.01  # m/s, at which it has started
LAWS = {
    "cohesion": {"cohesion": 2e3, "cohesionRange": 1e-4},
    "bond": {"bondStrength": 2e3, "bondEnergy": 0.1},
}
STRENGTH = 2e3  # of both, Pa
ENERGY = {"cohesion": 0.2, "bond": 0.1}  # J/m^2


def parse_options(arguments=None):
    parser = command_line.case_parser(__doc__, out="interfaces")
    add, zeta = parser.add_argument, command_line.resolution
    add("--zeta", type=zeta, nargs="+", default=[0.25, 0.125], help="relative resolutions [-]")
    return parser.parse_args(arguments)


def make_scene(zeta, length, gravity=0.0, **interface):
    """A block that lies on a wall; returns both."""
    O.reset()
    material = sg.SoftMat(
        young=1e6,
        poisson=0.3,
        density=DENSITY,
        massDamping=DAMPING,
        frictionAngle=math.atan(STATIC),
    )
    block = sg.soft_block((0, HALF, 0), (length, 2 * HALF), material, zeta=zeta)
    wall = utils.wall(0, axis=1, sense=1, material=FrictMat(frictionAngle=math.atan(STATIC)))
    O.bodies.append([block, wall])
    O.engines = sg.engines(gravity=(0, -gravity, 0), interface=interface)
    O.trackEnergy = True
    sg.set_time_step()
    return block, wall


def separation(law, zeta, rate=4e4):
    """Pull with a stress that grows by ``rate`` [Pa/s]; largest stress on the wall over the
    strength, work of separation over what it should be, share of the work that is not found
    again."""
    area = 2 * HALF
    block, wall = make_scene(zeta, area, **LAWS[law])
    sg.advance(2)
    balance, largest = sg.Balance(), 0.0
    while any(i.isReal for i in O.interactions):
        O.forces.setPermF(block.id, (0, rate * O.time * area, 0))
        O.step()
        largest = max(largest, O.forces.f(wall.id)[1] / area)
    work = sg.integrator().energy()["cohesion"] / area
    return {
        "law": law,
        "zeta": zeta,
        "stress_over_strength": largest / STRENGTH,
        "work_over_energy": work / ENERGY[law],
        "energy_error": balance.error(),
        "lost_bonds": sg.integrator().lostBonds,
    }


def sliding(zeta, rate=50.0):
    """Push a slab, eight times as long as high, by an acceleration that grows by ``rate`` [m/s^3];
    friction when it starts, and while it slides, over mu_s and mu_d."""
    slab, _ = make_scene(
        zeta, 16 * HALF, GRAVITY, dynamicFrictAngle=math.atan(DYNAMIC), frictAngle=math.atan(STATIC)
    )
    sg.integrator().tolerance = 1e-3
    while O.time < WAIT:
        sg.advance(10)
    start, push = O.time, 0.0
    while slab.state.vel[0] < SLIDING:
        push = rate * (O.time - start)
        O.forces.setPermF(slab.id, (push * slab.state.mass, 0, 0))
        O.step()
    time, speed = O.time, slab.state.vel[0]
    while O.time < time + SLIDING_TIME:
        sg.advance(10)
    gained = (slab.state.vel[0] - speed) / (O.time - time)
    return {
        "zeta": zeta,
        "static": push / GRAVITY / STATIC,
        "dynamic": (push - gained) / GRAVITY / DYNAMIC,
    }


def main():
    options = parse_options()
    result = {
        "separation": [separation(law, zeta) for law in LAWS for zeta in options.zeta],
        "sliding": [sliding(zeta) for zeta in options.zeta],
    }
    for row in result["separation"] + result["sliding"]:
        print({k: v if isinstance(v, str) else round(v, 5) for k, v in row.items()})
    command_line.write_result(options, result)


if __name__ == "__main__":
    main()
