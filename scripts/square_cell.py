"""One soft disk in a closing square box: the square lattice of identical frictionless disks.

Run it with YADE: ``scripts/yade -n -x scripts/square_cell.py --zeta 0.1 --out DIR``. The four
frictionless walls move in at equal speed; plane strain. Forces, and the width of the contacts, are
compared with converged finite elements at equal displacement of the walls and at equal packing
fraction.
"""

import time

import numpy as np
from yade import O

import softgrain as sg
from softgrain import cases, command_line, finite_elements

WALLS = ("left", "right", "bottom", "top")


def parse_options(arguments=None):
    parser = command_line.case_parser(__doc__, out="square_cell")
    cases.add_grain_options(parser, speed=0.01, speed_help="of each of the four walls [m/s]")
    command_line.add_until_phi(parser, start="pi/4")
    options = parser.parse_args(arguments)
    command_line.check_method(parser, options)
    command_line.check_until_phi(parser, options, np.pi / 4, "pi/4")
    return options


def make_scene(options):
    """The disk just touching four walls; returns its id and theirs."""
    radius = options.diameter / 2
    disk = cases.add_disk(options, (0, 0, 0)).id
    walls = [
        cases.add_wall(-sense * radius, axis=axis, sense=sense, velocity=sense * options.speed)
        for axis in (0, 1)
        for sense in (1, -1)
    ]
    cases.start(options)
    return disk, walls


def close(options, disk, walls):
    """Close the box; returns records, averaged over windows."""
    left, right, bottom, top = walls

    def side(low, high, axis):
        return (O.bodies[high].state.pos[axis] - O.bodies[low].state.pos[axis]) / options.diameter

    def place():
        width, height = side(left, right, 0), side(bottom, top, 1)
        area = width * height * options.diameter**2
        displacement = 0.5 - 0.25 * (width + height)
        return np.array(
            [displacement, sg.packing_fraction(area), sg.packing_fraction(area, nominal=True)]
        )

    def forces():
        f = O.forces.f
        return [-f(left)[0], f(right)[0], -f(bottom)[1], f(top)[1]]

    contacts = [cases.WallContact(disk, wall) for wall in walls]

    def halfwidth():
        return np.mean([contact.halfwidth() for contact in contacts])

    return cases.close_cell(options, place, forces, contacts, halfwidth)


def main():
    options = parse_options()
    disk, walls = make_scene(options)
    started = time.time()
    columns = close(options, disk, walls)
    known = options.poisson in finite_elements.CELL_POISSON_RATIOS
    cases.report_cell(
        options,
        started,
        columns,
        own_results=lambda forces: {f"force_{name}_over_ED": f for name, f in zip(WALLS, forces)},
        exact=finite_elements.square_cell(options.poisson) if known else None,
        title="square cell",
    )


if __name__ == "__main__":
    main()
