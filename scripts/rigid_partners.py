"""Soft disks with rigid partners: an impact and a mixed packing.

Run it with YADE: ``scripts/yade -n -x scripts/rigid_partners.py --out DIR``. ``result.json`` has
the velocities after the impact, and what the contact solver did in the squeezed packing.
"""

import math

import numpy as np
from yade import FrictMat, O, utils

import softgrain as sg
from softgrain import command_line

RADIUS = 0.01  # m, of the soft disks
DENSITY = 2000.0  # kg/m3, of the rigid disks
IMPACT_SPEED = 1.0  # m/s, of the partner
IMPACT_TIME = 4e-3  # s, until both are apart again
PARTNER_YOUNG = (None, 1e7, 1e8, 1e9)  # Pa; None: rigid
PACKING_ROWS = 10
PACKING_SPEED = 0.2  # m/s, of the upper wall
PACKING_END = 0.9  # height at which it stops, over that at the start


def parse_options(arguments=None):
    parser = command_line.case_parser(__doc__, out="rigid_partners")
    add = parser.add_argument
    add("--zeta", type=command_line.resolution, default=0.1, help="relative resolution 2 dr/D [-]")
    add("--mu", type=command_line.non_negative, default=0.3, help="friction [-]")
    return parser.parse_args(arguments)


def soft_material(options, young=1e6, poisson=0.45, density=1000.0):
    return sg.SoftMat(
        young=young, poisson=poisson, density=density, frictionAngle=math.atan(options.mu)
    )


def add_rigid_disk(centre, radius, options):
    """A free rigid disk of YADE; returns its body."""
    material = FrictMat(
        young=1e7, poisson=0.3, density=DENSITY, frictionAngle=math.atan(options.mu)
    )
    body = utils.sphere(centre, radius, material=material)
    body.state.blockedDOFs = "zXY"
    O.bodies.append(body)
    sg.as_disks([body.id])
    return body


def impact(options, young=None):
    """A soft disk at rest is hit off its centre; the partner is rigid, or soft with a Young's
    modulus [Pa]. Velocities and spins of both after IMPACT_TIME."""
    O.reset()
    disk = sg.soft_disk((0, 0, 0), RADIUS, soft_material(options), zeta=options.zeta)
    O.bodies.append(disk)
    centre = (1.51 * RADIUS, 0.5 * RADIUS, 0)
    if young is None:
        partner = add_rigid_disk(centre, RADIUS / 2, options)
    else:
        material = soft_material(options, young, 0.3, DENSITY)
        partner = sg.soft_disk(centre, RADIUS / 2, material, zeta=options.zeta)
        O.bodies.append(partner)
    partner.state.vel = (-IMPACT_SPEED, 0, 0)
    O.engines = sg.engines()
    sg.set_time_step(0.5)
    while O.time < IMPACT_TIME:
        sg.advance(20)
    return {
        "partner": "rigid" if young is None else f"soft, E = {young:g} Pa",
        "velocity": [*np.array(disk.state.vel)[:2], *np.array(partner.state.vel)[:2]],
        "spin": [disk.state.angVel[2], partner.state.angVel[2]],
        "sweeps_per_step": sg.integrator().totalSweeps / sg.integrator().steps,
    }


def squeezed_packing(options):
    """Soft and rigid disks at random on a square lattice, squeezed from above by a tenth."""
    O.reset()
    pitch, random = 2.002 * RADIUS, np.random.default_rng(1)
    soft = random.permutation(PACKING_ROWS**2) < PACKING_ROWS**2 // 2
    material = soft_material(options)
    O.materials.append(material)
    for k, is_soft in enumerate(soft):
        row, column = divmod(k, PACKING_ROWS)
        centre = ((column + 0.5) * pitch, (row + 0.5) * pitch, 0)
        if is_soft:
            O.bodies.append(sg.soft_disk(centre, RADIUS, material, zeta=options.zeta))
        else:
            add_rigid_disk(centre, RADIUS, options)
    side = PACKING_ROWS * pitch
    ids = O.bodies.append(sg.walls_around((0, 0), (side, side), FrictMat(frictionAngle=0)))
    O.engines = sg.engines()
    O.trackEnergy = True
    sg.set_time_step()
    O.bodies[ids[-1]].state.vel = (0, -PACKING_SPEED, 0)
    while O.bodies[ids[-1]].state.pos[1] > PACKING_END * side:
        sg.advance(20)
    integrator = sg.integrator()
    return {
        "soft": int(soft.sum()),
        "rigid": int((~soft).sum()),
        "steps": integrator.steps,
        "contacts": integrator.contacts,
        "sweeps_per_step": integrator.totalSweeps / integrator.steps,
        "capped_steps": integrator.cappedSteps,
        "largest_residual": integrator.largestResidual,
        "largest_overlap_over_dr": integrator.largestOverlap,
    }


def main():
    options = parse_options()
    result = {
        "impact": [impact(options, young) for young in PARTNER_YOUNG],
        "packing": squeezed_packing(options),
    }
    command_line.write_result(options, result)
    for row in result["impact"]:
        velocity = ", ".join(f"{v:+.4f}" for v in row["velocity"])
        spin = ", ".join(f"{w:+.2f}" for w in row["spin"])
        print(f"{row['partner']}: {velocity} m/s, {spin} 1/s, {row['sweeps_per_step']:.2f} sweeps")
    print(result["packing"])


if __name__ == "__main__":
    main()
