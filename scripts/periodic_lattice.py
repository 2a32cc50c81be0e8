"""A lattice of soft disks in a periodic cell that shrinks: what walls do as mirrors, without walls.

Run it with YADE: ``scripts/yade -n -x scripts/periodic_lattice.py --lattice square --out DIR``.
The cell is compressed isotropically by its velocity gradient. The force between neighbours follows
from the mean stress, and is compared with converged finite elements of one disk between
frictionless mirrors. ``result.json`` has it, the stress by contacts and by grains, and the work of
the cell beside stress times strain.
"""

import math

import numpy as np
from yade import Matrix3, O, utils

import softgrain as sg
from softgrain import cases, command_line, finite_elements

RADIUS = 0.01  # m
YOUNG, POISSON, DENSITY = 1e6, finite_elements.POISSON, 1000.0  # Pa, -, kg/m3
WINDOW = cases.window_seconds(YOUNG, POISSON, DENSITY, 2 * RADIUS)  # s
LATE = 0.01  # displacement w/D from which on forces are compared; before, few nodes bear them


def parse_options(arguments=None):
    parser = command_line.case_parser(__doc__, out="periodic_lattice")
    add = parser.add_argument
    add("--lattice", choices=("square", "triangular"), default="square")
    add("--zeta", type=command_line.resolution, default=0.1, help="relative resolution 2 dr/D [-]")
    add(
        "--mu",
        type=command_line.non_negative,
        default=0.3,
        help="friction, which bears nothing here but keeps rows from gliding [-]",
    )
    add("--rate", type=command_line.positive, default=1.0, help="of compression [1/s]")
    add("--until", type=command_line.positive, default=0.05, help="displacement w/D to stop at [-]")
    options = parser.parse_args(arguments)
    end = solution(options.lattice).wall_displacement_over_D[-1]
    if not LATE < options.until <= end:
        parser.error(f"argument --until: {options.until} is not in the range ({LATE}, {end}]")
    fastest = 2 * LATE / WINDOW
    if options.rate > fastest:
        parser.error(
            f"argument --rate: {options.rate} is not in the range (0, {fastest:.3g}] 1/s: forces "
            f"are means over windows of {WINDOW:.2g} s, in which w/D is to grow by {LATE} at most"
        )
    return options


def solution(lattice):
    """By finite elements."""
    cells = {"square": finite_elements.square_cell, "triangular": finite_elements.hexagonal_cell}
    return cells[lattice]()


def make_scene(options):
    """Disks that just touch: 3 x 3, or 4 rows of 3."""
    rows, height = (3, 1.0) if options.lattice == "square" else (4, math.sqrt(0.75))
    diameter = 2 * RADIUS
    O.periodic = True
    O.cell.setBox(3 * diameter, rows * height * diameter, 1)
    material = sg.SoftMat(
        young=YOUNG, poisson=POISSON, density=DENSITY, frictionAngle=math.atan(options.mu)
    )
    for j in range(rows):
        for i in range(3):
            x = i + 0.5 + (0.5 * (j % 2) if options.lattice == "triangular" else 0)
            centre = (x * diameter, (j + 0.5) * height * diameter, 0)
            O.bodies.append(sg.soft_disk(centre, RADIUS, material, zeta=options.zeta))
    O.engines = sg.engines(tolerance=cases.TOLERANCE)
    O.trackEnergy = True
    sg.set_time_step()
    O.cell.velGrad = Matrix3(-options.rate, 0, 0, 0, -options.rate, 0, 0, 0, 0)


def neighbour_force(lattice, stress, distance):
    """Force between neighbours over E D, from the mean normal stress [Pa] and the distance of their
    centres over D."""
    return stress * distance / (YOUNG * (1 if lattice == "square" else math.sqrt(3)))


def compress(options):
    """Returns rows: displacement w/D, phi, stress xx, yy, xy by contacts, xx, yy by grains [Pa],
    work of the cell and sum of stress times strain [J/m]."""
    width = 3 * 2 * RADIUS
    work = {"expected": 0.0}

    def place():
        return np.array([0.5 * (1 - O.cell.size[0] / width), sg.packing_fraction()])

    def step():
        strain = O.dt * np.array(O.cell.velGrad)
        O.step()
        work["expected"] += np.sum(np.array(utils.getStress()) * strain) * O.cell.volume

    def stresses():
        contacts = np.array(utils.getStress())
        grains = sg.cell_stress("grains")
        energy = sg.integrator().energy()
        return np.array(
            [contacts[0, 0], contacts[1, 1], contacts[0, 1], grains[0, 0], grains[1, 1]]
            + [energy["cell"] + energy["loads"], work["expected"]]
        )

    O.step()
    rows = []
    with command_line.progress_bar(total=options.until) as bar:
        while not rows or rows[-1][0] < options.until:
            where, mean = cases.window_means(WINDOW, place, stresses, step=step)
            rows.append([*where, *mean])
            command_line.show_progress(bar, where[0], f"w/D {where[0]:.4f}")
    return np.array(rows).T


def main():
    options = parse_options()
    make_scene(options)
    O.step()
    balance = sg.Balance()
    displacement, phi, xx, yy, xy, grains_xx, grains_yy, done, expected = compress(options)
    stress = -0.5 * (xx + yy)
    force = neighbour_force(options.lattice, stress, 1 - 2 * displacement)
    curve = solution(options.lattice)
    late = (LATE <= displacement) & (displacement <= curve.wall_displacement_over_D[-1])
    exact = finite_elements.interpolated(
        displacement[late], curve.wall_displacement_over_D, curve.force_over_ED
    )
    error = force[late] / exact - 1
    by_grains = -0.5 * (grains_xx + grains_yy)
    result = {
        "wall_displacement_over_D": displacement,
        "phi": phi,
        "force_over_ED": force,
        "stress_xx": xx,
        "stress_yy": yy,
        "stress_xy": xy,
        "stress_by_grains": by_grains,
        "work_of_cell": done,
        "stress_times_strain": expected,
        "error_max": float(np.abs(error).max()),
        "grains_against_contacts_max": float(np.abs(by_grains / stress - 1)[late].max()),
        "work_against_stress": float(done[-1] / expected[-1] - 1),
        "energy_error": balance.error(),
        "steps": int(sg.integrator().steps),
        "capped_steps": int(sg.integrator().cappedSteps),
    }
    command_line.write_result(options, result)
    sg.draw_packing(options.out / "packing.png")
    print(
        f"w/D = {displacement[-1]:.4f}, phi = {phi[-1]:.4f}: force within "
        f"{100 * result['error_max']:.2f} % of finite elements from w/D = {LATE} on, stress by "
        f"grains within {100 * result['grains_against_contacts_max']:.2f} % of that by contacts, "
        f"work {100 * result['work_against_stress']:+.2f} % off stress times strain, "
        f"energy balance {result['energy_error']:.1e}"
    )


if __name__ == "__main__":
    main()
