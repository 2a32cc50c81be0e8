"""One soft disk pressed between two frictionless plates (Nezamabadi & Radjai 2024, section 3.1).

Run it with YADE: ``scripts/yade -n -x scripts/hertz.py --zeta 0.1 --contact surface --out DIR``.
The bottom plate is fixed, the top one moves down at constant speed. Force, width and pressure of
the contact are compared with converged finite elements. (The paper says plane stress, but its
E* = E/(1 - nu^2) is that of plane strain, the default here.)
"""

import time

import numpy as np
from yade import O

import softgrain as sg
from softgrain import cases, command_line, finite_elements

#: Pressure profiles are kept at the windows nearest to these approaches over D.
PROFILES_AT = (0.03, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3)
#: Of the way of the plates that the script is to stop at: wider windows of its records miss it.
WIDEST_WINDOW = 0.5


def parse_options(arguments=None):
    parser = command_line.case_parser(__doc__, out="hertz")
    cases.add_grain_options(
        parser,
        speed=0.02,
        speed_help="of the top plate [m/s]; the paper's 0.1 makes the force ripple",
    )
    parser.add_argument(
        "--condition",
        choices=("plane_strain", "plane_stress"),
        default="plane_strain",
        help="what closes the third dimension",
    )
    parser.add_argument(
        "--until",
        type=command_line.fraction,
        default=0.2,
        metavar="DELTA_OVER_D",
        help="approach of the plates over the diameter to stop at [-]",
    )
    options = parser.parse_args(arguments)
    command_line.check_method(parser, options)
    if options.condition == "plane_stress" and options.volumetric == "projected":
        parser.error("argument --volumetric: projected needs --condition plane_strain")
    window = options.speed * cases.window_of(options) / options.diameter
    if window > WIDEST_WINDOW * options.until:
        parser.error(
            f"argument --speed: the plates approach by {window:.2g} D within a window of the "
            f"records, more than {WIDEST_WINDOW} of --until"
        )
    return options


def make_scene(options):
    """The disk just touching both plates; returns the ids of the disk, the bottom and the top
    plate."""
    radius = options.diameter / 2
    condition = {"plane_strain": "planeStrain", "plane_stress": "planeStress"}[options.condition]
    disk = cases.add_disk(options, (0, 0, 0), condition).id
    bottom = cases.add_wall(-radius, axis=1, sense=1)
    top = cases.add_wall(radius, axis=1, sense=-1, velocity=-options.speed)
    cases.start(options)
    return disk, bottom, top


def press(options, disk, bottom, top):
    """Press the disk; returns records, averaged over windows."""

    def approach():
        return 0.5 - O.bodies[top].state.pos[1] / options.diameter

    def forces():
        return -O.forces.f(bottom)[1], O.forces.f(top)[1]

    contacts = [cases.WallContact(disk, bottom), cases.WallContact(disk, top)]
    seconds = cases.window_of(options)
    scale = options.young * options.diameter
    records = {name: [] for name in ("delta", "bottom", "top", "halfwidth", "kinetic", "profile")}
    with command_line.progress_bar(total=options.until) as bar:
        while approach() < options.until:
            delta, force = cases.window_means(seconds, approach, forces, contacts)
            halfwidth = np.mean([c.halfwidth() for c in contacts]) / options.diameter
            values = (
                delta,
                *(force / scale),
                halfwidth,
                sg.quasi_static()["kinetic_over_elastic"],
                profile_of(options, contacts[0]),
            )
            for name, value in zip(records, values):
                records[name].append(value)
            reached = approach()
            command_line.show_progress(bar, reached, f"delta/D {reached:.4f}")
    return {k: v if k == "profile" else np.array(v) for k, v in records.items()}


def profile_of(options, contact):
    """Pressure on a plate, normalised."""
    position, pressure = contact.pressure()
    return {
        "position_over_D": position / options.diameter,
        "pressure_over_E": pressure / options.young,
    }


def profiles(records):
    """The profiles to keep, with their approaches."""
    last = records["delta"][-1]
    nearest = {
        int(np.argmin(np.abs(records["delta"] - at))) for at in PROFILES_AT if at <= last + 0.005
    }
    return [{"delta_over_D": records["delta"][k], **records["profile"][k]} for k in sorted(nearest)]


def main():
    options = parse_options()
    bodies = make_scene(options)
    started = time.time()
    records = press(options, *bodies)
    facts = cases.run_facts(time.time() - started)
    delta, force = records["delta"], 0.5 * (records["bottom"] + records["top"])
    window = cases.window_of(options)
    command_line.write_result(
        options,
        {
            "delta_over_D": delta,
            "force_over_ED": force,
            "force_top_over_ED": records["top"],
            "force_bottom_over_ED": records["bottom"],
            "contact_halfwidth_over_D": records["halfwidth"],
            "pressure_profiles": profiles(records),
            "kinetic_over_elastic": records["kinetic"],
            "window_over_D": options.speed * window / options.diameter,
            **facts,
        },
    )
    known = options.poisson in finite_elements.poisson_ratios(options.condition)
    exact = (
        finite_elements.disk_between_plates(options.condition, options.poisson) if known else None
    )
    cases.plot_force(
        options,
        delta,
        force,
        exact,
        abscissa="delta_over_D",
        xlabel=r"approach of the plates $\delta$ / D",
        title=options.condition.replace("_", " "),
    )
    print(
        f"delta/D = {delta[-1]:.4f}, F/(E D) = {force[-1]:.5f}; {facts['steps']} steps in "
        f"{facts['wall_seconds']:.1f} s, forces averaged over windows of {1e3 * window:.2f} ms. "
        f"Results in {options.out}/"
    )


if __name__ == "__main__":
    main()
