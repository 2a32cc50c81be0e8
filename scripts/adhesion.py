"""A soft disk pulled off a plate that attracts it: pull-off force against the theory of adhesive
line contact.

Traction of Dugdale: sigma_c across gaps up to delta, w = sigma_c delta. Reference: half plane,
plane strain, E* = E/(1 - nu^2); a contact of half-width a, with tractions up to c (Maugis' model in
two dimensions, as in Baney & Hui, J. Appl. Phys. 81, 1997; Johnson & Greenwood, 2008), found from
the singular integral of a contact whose pressure is bounded (`line_contact`). With ever shorter
ranges its largest force becomes that of Johnson, Kendall and Roberts for cylinders (Barquins,
J. Adhesion 26, 1988), F = 3 (pi E* w^2 R/16)^(1/3).

    scripts/yade -n -x scripts/adhesion.py --zeta 0.05 0.025 --out adhesion
"""

import math
import sys

import numpy as np
from yade import FrictMat, O, utils

import softgrain as sg
from softgrain import command_line

DENSITY = 1000.0  # kg/m3
DAMPING = 1000.0  # 1/s
SETTLING = 0.01  # s, in which the attraction closes the contact
POINTS = 120  # of the quadrature over the contact
POINTS_OUTSIDE = 60  # of that over the ring of attraction
BISECTIONS = 30
HALF_WIDTHS = 1e-6, 1.0  # over R, among which that of the largest force is looked for


def parse_options(arguments=None):
    parser = command_line.case_parser(__doc__, out="adhesion")
    add, zeta = parser.add_argument, command_line.resolution
    add("--zeta", type=zeta, nargs="+", default=[0.05, 0.025], help="relative resolutions [-]")
    add("--radius", type=command_line.positive, default=0.01, help="of the disk [m]")
    add("--young", type=command_line.positive, default=1e6, help="Young's modulus [Pa]")
    add("--poisson", type=command_line.poisson, default=0.45, help="Poisson's ratio [-]")
    add("--cohesion", type=command_line.positive, default=1e5, help="traction sigma_c [Pa]")
    add("--range", type=command_line.positive, default=2e-4, help="its range delta [m]")
    add("--time", type=command_line.positive, default=0.06, help="of the pull [s]")
    return parser.parse_args(arguments)


def jkr_force(E, R, w):
    """Pull-off force of a cylinder without range of attraction [N/m]; E is E*."""
    return 3 * (math.pi * E * w**2 * R / 16) ** (1 / 3)


def gap_at_end(a, c, E, R, sigma):
    """Gap at c of a contact of half-width a with traction sigma out to c [m].

    The pressure is q - sigma within a, with q = 0 at its ends, and the gap opens as
    g' = x/R - 2/(pi E*) (Phi(x) - sigma ln((c + x)/(c - x))), where
    Phi(x) = sqrt(x^2 - a^2)/pi int_-a^a f(s)/(sqrt(a^2 - s^2) (x - s)) ds and
    f(s) = pi E* s/(2 R) + sigma ln((c + s)/(c - s)).
    """
    s = a * np.cos((np.arange(POINTS) + 0.5) * math.pi / POINTS)  # Gauss and Chebyshev
    f = math.pi * E * s / (2 * R) + sigma * np.log((c + s) / (c - s))
    t, weight = np.polynomial.legendre.leggauss(POINTS_OUTSIDE)
    t, weight = (t + 1) / 2, weight / 2
    x = a + (c - a) * (1 - (1 - t**2) ** 2)  # denser at both ends, where the slope is steep
    width = (c - a) * 4 * t * (1 - t**2) * weight
    phi = np.sqrt(x**2 - a**2) / POINTS * (f / (x[:, None] - s)).sum(axis=1)
    slope = x / R - 2 / (math.pi * E) * (phi - sigma * np.log((c + x) / (c - x)))
    return (slope * width).sum()


def line_contact(a, E, R, sigma, delta):
    """Pulling force [N/m] of a contact of half-width a: its tractions end where the gap is
    delta."""
    low, high = a, a + math.sqrt(8 * R * delta) + 4 * a
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        if gap_at_end(a, middle, E, R, sigma) < delta:
            low = middle
        else:
            high = middle
    return 2 * sigma * math.sqrt(low**2 - a**2) - math.pi * E * a**2 / (4 * R)


def theory(options):
    """Largest pulling force of the reference [N/m]."""
    R, E = options.radius, options.young / (1 - options.poisson**2)

    def largest(widths):
        forces = [line_contact(a, E, R, options.cohesion, options.range) for a in widths]
        k = int(np.argmax(forces))
        return forces[k], widths[max(k - 1, 0)], widths[min(k + 1, len(widths) - 1)]

    _, low, high = largest(R * np.geomspace(*HALF_WIDTHS, 60))  # stiff disks let go at a point
    if high == R * HALF_WIDTHS[1]:
        raise ValueError(
            "the disk is pulled off at a contact as wide as itself, for which there is no theory: "
            "less cohesion or range, or a larger Young's modulus"
        )
    return largest(np.linspace(low, high, 20))[0]


def make_scene(options, zeta):
    """The disk on the plate; returns both."""
    O.reset()
    R = options.radius
    material = sg.SoftMat(
        young=options.young, poisson=options.poisson, density=DENSITY, massDamping=DAMPING
    )
    disk = sg.soft_disk((0, R, 0), R, material, zeta=zeta)
    plate = utils.wall(0, axis=1, sense=1, material=FrictMat(frictionAngle=0))
    O.bodies.append([disk, plate])
    O.engines = sg.engines(interface={"cohesion": options.cohesion, "cohesionRange": options.range})
    O.trackEnergy = True
    sg.set_time_step()
    return disk, plate


def settle():
    """Let the attraction close the contact; the balance of energies since the start."""
    O.step()
    balance = sg.Balance()
    while O.time < SETTLING:
        sg.advance(20)
    return balance


def pull_off(options, zeta, upper):
    """Pull with a force that grows to `upper`; what the plate bore at most."""
    disk, plate = make_scene(options, zeta)
    balance = settle()
    start, largest = O.time, 0.0
    while any(i.isReal for i in O.interactions):
        load = upper * (O.time - start) / options.time
        O.forces.setPermF(disk.id, (0, load, 0))
        sg.advance(10)
        largest = max(largest, O.forces.f(plate.id)[1])
        if load > 2 * upper:
            raise RuntimeError(f"the disk is still held at {load:.4g} N/m")
    return {
        "zeta": zeta,
        "force": largest,
        "steps": O.iter,
        "energy_error": balance.error(),
        "capped_steps": sg.integrator().cappedSteps,
    }


def main():
    options = parse_options()
    w = options.cohesion * options.range
    try:
        reference = theory(options)
    except ValueError as error:
        sys.exit(f"adhesion: {error}")
    E = options.young / (1 - options.poisson**2)
    result = {"reference": reference, "jkr": jkr_force(E, options.radius, w), "runs": []}
    print(f"theory: {reference:.1f} N/m; without range {result['jkr']:.1f} N/m")
    for zeta in options.zeta:
        found = pull_off(options, zeta, 1.5 * reference)
        found["error"] = found["force"] / reference - 1
        result["runs"].append(found)
        print(f"zeta {zeta}: {found['force']:.1f} N/m, {100 * found['error']:+.1f} %", found)
    command_line.write_result(options, result)


if __name__ == "__main__":
    main()
