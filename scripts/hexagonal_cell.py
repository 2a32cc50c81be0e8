"""Soft disks on a triangular lattice under isotropic compression; the central one is measured.

Run it with YADE: ``scripts/yade -n -x scripts/hexagonal_cell.py --zeta 0.1 --out DIR``. The
frictionless disks lie in rings about the central one. The centres of the outermost ring are moved
as the lattice shrinks; all others are free, so that the central disk and its six neighbours find
their own places. Its cell is measured where it is: w is half of the diameter less the mean
distance from the centre of the central disk to its six contacts. Plane strain; compared with
converged finite elements of one cell.
"""

import math
import time

import numpy as np
from yade import O

import softgrain as sg
from softgrain import cases, command_line, finite_elements

#: Tolerance of the sweeps: ten times that for one disk, since 19 need many more of them.
TOLERANCE = 1e-3
START_PHI = math.pi / math.sqrt(12)


def parse_options(arguments=None):
    parser = command_line.case_parser(__doc__, out="hexagonal_cell")
    cases.add_grain_options(
        parser,
        speed=0.01,
        speed_help="at which the sides of each cell move in [m/s]",
        tolerance=TOLERANCE,
    )
    parser.add_argument(
        "--rings",
        type=command_line.whole_from(2),
        default=2,
        help="rings of disks about the central one, the outermost moved; at least 2 [-]",
    )
    command_line.add_until_phi(parser, start="pi/sqrt(12)", of=" of the central cell")
    options = parser.parse_args(arguments)
    command_line.check_method(parser, options)
    command_line.check_until_phi(parser, options, START_PHI, "pi/sqrt(12)")
    return options


def lattice(rings):
    """Sites of a triangular lattice of unit spacing within so many rings: array (n, 3), the
    central one first and the others ring by ring; and the ring of each."""
    steps = range(-rings, rings + 1)
    sites = [(i, j) for i in steps for j in steps if abs(i + j) <= rings]
    sites.sort(key=lambda site: (ring(*site), site))
    positions = [(i + 0.5 * j, 0.5 * math.sqrt(3) * j, 0.0) for i, j in sites]
    return np.array(positions), np.array([ring(*site) for site in sites])


def ring(i, j):
    """Steps from the origin of a site in the basis at 60 degrees."""
    return max(abs(i), abs(j), abs(i + j))


class Lattice:
    """The disks, and the motion of the outermost ring."""

    def __init__(self, options):
        self.diameter = options.diameter
        sites, rings = lattice(options.rings)
        # every centre moves in by this share of its first distance a second, at the start all of
        # them
        self._rate = 2 * options.speed / options.diameter
        self._first = options.diameter * sites
        self.disks = [cases.add_disk(options, tuple(x)) for x in self._first]
        for disk, x in zip(self.disks, self._first):
            disk.state.vel = tuple(-self._rate * x)
        self._moved = [k for k in range(len(sites)) if rings[k] == options.rings]
        self._held = {k: np.zeros(3) for k in self._moved}
        self.neighbours = [k for k in range(len(sites)) if rings[k] == 1]

    def step(self):
        """A step with the centres of the outermost ring where the lattice has them.

        What would push them off, the contact forces of the last step, is held by a body load; what
        has changed since is corrected in position and velocity. No disk may spin: by symmetry none
        would, but without friction nothing stops one from rolling to where its nodes lie best.
        """
        for k in self._moved:
            disk = self.disks[k]
            disk.state.pos = tuple((1 - self._rate * O.time) * self._first[k])
            disk.state.vel = tuple(-self._rate * self._first[k])
            O.forces.setPermF(disk.id, tuple(self._held[k]))
        for disk in self.disks:
            disk.state.angVel = (0, 0, 0)
        O.step()
        for k in self._moved:
            contacts = np.array(O.forces.f(self.disks[k].id)) - self._held[k]
            self._held[k] = -contacts

    def cell(self):
        """Displacement w/D of the sides of the central cell, phi and phi0 in it."""
        half = np.mean([self._reach(k) for k in self.neighbours])
        area = math.sqrt(12) * half**2
        return np.array(
            [
                0.5 - half / self.diameter,
                sg.grain_area(self.disks[0]) / area,
                0.25 * math.pi * self.diameter**2 / area,
            ]
        )

    def _reach(self, k):
        """Distance from the centre of the central disk to its contact with neighbour k, the mean
        weighted with the forces [m]; half of the distance of the centres without a force."""
        centre = np.array(self.disks[0].state.pos)
        apart = np.array(self.disks[k].state.pos) - centre
        distance = np.linalg.norm(apart)
        for interaction in self.contacts():
            if self.disks[k].id in (interaction.id1, interaction.id2):
                contacts = interaction.geom.contacts()
                force = normal_forces(contacts)
                if force.sum() > 0:
                    return (contacts["point"] - centre) @ apart / distance @ force / force.sum()
        return 0.5 * distance

    def contacts(self):
        """Interactions of the central disk with its neighbours that exist by now."""
        central = self.disks[0].id
        return [i for i in O.interactions.withBody(central) if i.isReal]

    def forces(self):
        """Forces between the central disk and its six neighbours [N/m], by the neighbour's id."""
        central = self.disks[0].id
        found = {i.id1 + i.id2 - central: i.phys.normalForce.norm() for i in self.contacts()}
        return [found.get(self.disks[k].id, 0.0) for k in self.neighbours]

    def halfwidth(self):
        """Mean half-width of the contacts of the central disk [m]."""
        widths = [halfwidth(i) for i in self.contacts()]
        return np.mean(widths) if widths else 0.0


class MeanHalfwidth:
    """Half-width of the contacts of the central disk, averaged over the samples of a window."""

    def __init__(self, disks):
        self._disks = disks
        self.restart()

    def restart(self):
        self._samples = []

    def sample(self):
        """Take in the last step."""
        self._samples.append(self._disks.halfwidth())

    def value(self):
        """[m]"""
        return np.mean(self._samples)


def halfwidth(interaction):
    """Half-width of the contact of two disks [m], along the tangent."""
    profile = sg.contact_profile(interaction)
    return sg.contact_halfwidth(profile["position"], profile["force"])


def normal_forces(contacts):
    """Of contact points, up to a common factor."""
    return np.sum(contacts["impulse"] * contacts["normal"], axis=1)


def compress(options, disks):
    """Shrink the lattice; returns records, averaged over windows."""
    halfwidth = MeanHalfwidth(disks)
    return cases.close_cell(
        options, disks.cell, disks.forces, [halfwidth], halfwidth.value, disks.step
    )


def main():
    options = parse_options()
    disks = Lattice(options)
    cases.start(options)
    started = time.time()
    columns = compress(options, disks)
    cases.report_cell(
        options,
        started,
        columns,
        own_results=lambda forces: {
            "neighbour_forces_over_ED": np.transpose(forces),
            "grains": len(disks.disks),
        },
        exact=(
            finite_elements.hexagonal_cell() if options.poisson == finite_elements.POISSON else None
        ),
        title="triangular lattice",
    )


if __name__ == "__main__":
    main()
