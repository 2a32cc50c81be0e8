"""What the runnable cases compared with finite elements share: options, scene, windows of time,
results and plots. Used by ``scripts/hertz.py``, the cells and ``periodic_lattice.py``."""

import math
import time

import matplotlib.figure
import numpy as np
import yade.utils
from yade import FrictMat, O, Quaternion, wrapper

from softgrain import bodies, build, command_line, observe, profile, time_loop
from softgrain.quasi_static import quasi_static

#: omega R / c_s of the lowest vibration of a free disk (Lamb), nu = 0.45; it changes little with
#: nu.
LOWEST_MODE = 2.3525
#: Forces are averaged over windows of this many periods of that mode, in which a disk bounces
#: between its walls about once.
PERIODS_PER_WINDOW = 2
#: The pressure on a wall is sampled this many times a window.
SAMPLES_PER_WINDOW = 10
#: Tolerance of the contact sweeps: sharper than the default for the sake of contact pressures
#: (doc/decisions/0010-grains-at-rest.md), for a sixth more sweeps.
TOLERANCE = 1e-4


def add_grain_options(parser, speed, speed_help, tolerance=TOLERANCE):
    """Add the options of the disk, its method and its loading.

    Args:
        parser (argparse.ArgumentParser): takes them.
        speed (float): default of ``--speed`` [m/s].
        speed_help (str): whose speed it is, and why.
        tolerance (float): default of the contact sweeps [-].
    """
    add = parser.add_argument
    add("--zeta", type=command_line.resolution, default=0.1, help="relative resolution 2 dr/D [-]")
    add("--young", type=command_line.positive, default=1e6, help="Young's modulus [Pa]")
    add("--poisson", type=command_line.poisson, default=0.45, help="Poisson's ratio [-]")
    add("--density", type=command_line.positive, default=1000.0, help="density [kg/m3]")
    add("--diameter", type=command_line.positive, default=0.02, help="diameter of a disk [m]")
    add(
        "--volumetric",
        choices=("pointwise", "projected"),
        default="pointwise",
        help="how the law sees the change of volume; 'projected' for nu above 0.48 or so",
    )
    command_line.add_method_options(parser, tolerance)
    add(
        "--orientation",
        type=command_line.any_number,
        default=0.0,
        help="angle by which the disks' grids are turned [degrees]; the answer should not feel it",
    )
    add("--speed", type=command_line.positive, default=speed, help=speed_help)


def add_disk(options, centre, condition="planeStrain"):
    """Add a soft disk as the options say; returns its body."""
    disk = build.soft_disk(
        centre,
        options.diameter / 2,
        zeta=options.zeta,
        contact=options.contact,
        volumetric=options.volumetric,
        **command_line.method_attributes(options),
        material=wrapper.SoftMat(
            young=options.young,
            poisson=options.poisson,
            density=options.density,
            condition=condition,
        ),
    )
    disk.state.ori = Quaternion((0, 0, 1), math.radians(options.orientation))
    O.bodies.append(disk)
    return disk


def add_wall(position, axis, sense, velocity=0.0):
    """Add a frictionless wall that moves along its axis with a constant velocity [m/s]; returns
    its id."""
    if not any(m.label == "walls" for m in O.materials):
        O.materials.append(FrictMat(frictionAngle=0, label="walls"))
    wall = yade.utils.wall(position, axis=axis, sense=sense, material="walls")
    wall.state.vel[axis] = velocity
    return O.bodies.append(wall)


def start(options):
    """Engines and time step for the scene."""
    O.engines = time_loop.engines(**command_line.engine_attributes(options))
    time_loop.set_time_step(options.time_step_fraction)


def window_seconds(young, poisson, density, diameter):
    """Two periods of the lowest vibration of a disk [s], from its Young's modulus [Pa], Poisson's
    ratio, density [kg/m3] and diameter [m]."""
    shear_speed = math.sqrt(young / (2 * (1 + poisson)) / density)
    return PERIODS_PER_WINDOW * 2 * math.pi / (LOWEST_MODE * shear_speed / (diameter / 2))


def window_of(options):
    """:func:`window_seconds` of a disk as the options of :func:`add_grain_options` say [s]."""
    return window_seconds(options.young, options.poisson, options.density, options.diameter)


class WallContact:
    """Pressure on a wall, averaged over the samples of a window."""

    def __init__(self, disk, wall):
        self._ids = disk, wall
        self.restart()

    def restart(self):
        self._samples = []

    def sample(self):
        """Take in the last step."""
        try:
            interaction = O.interactions[self._ids]
        except IndexError:
            return
        if interaction.isReal:
            self._samples.append(profile.contact_profile(interaction))

    def halfwidth(self):
        """Mean half-width [m]; 0 without contact."""
        widths = [profile.contact_halfwidth(s["position"], s["force"]) for s in self._samples]
        return float(np.mean(widths)) if widths else 0.0

    def pressure(self):
        """Positions from the centre of the force [m] and pressures [Pa] of the nodes that were in
        reach in every sample: mean force over the length that the node stands for. The mean over
        time takes out most of the scatter of single nodes, without an average along the contact,
        which would carry pressure over its edges. Both are empty without contact."""
        nodes = set.intersection(*[set(s["node"]) for s in self._samples] or [set()])
        if not nodes:
            return np.zeros(0), np.zeros(0)
        kept = [np.isin(s["node"], list(nodes)) for s in self._samples]
        mean = {
            name: np.mean([s[name][k] for s, k in zip(self._samples, kept)], axis=0)
            for name in ("position", "force")
        }
        grain = O.bodies[self._ids[0]].shape
        dr = grain.zeta * grain.radius
        length = np.gradient(mean["position"]) if len(nodes) > 1 else dr
        if not mean["force"].sum() > 0:
            return np.zeros(0), np.zeros(0)
        centre = np.dot(mean["force"], mean["position"]) / mean["force"].sum()
        return mean["position"] - centre, mean["force"] / length


def window_means(seconds, place, forces, contacts=(), step=O.step):
    """Step for one window of time.

    Args:
        seconds (float): length of the window, at least one step [s].
        place (callable): where the walls are, quantities that change steadily, as an array.
        forces (callable): what is to be averaged, taken after every step, as an array.
        contacts (iterable): sampled several times; with `restart` and `sample` as WallContact.
        step (callable): makes a step.

    Returns:
        tuple: mean of the place, the mean of its values before the first and the last step, at
        whose times the first and last forces act; mean of the forces.
    """
    for contact in contacts:
        contact.restart()
    start = O.time
    first, total, steps, sampled = place(), 0.0, 0, 0
    while True:
        ends = O.time + 1.5 * O.dt >= start + seconds
        last = place() if ends else None
        step()
        total = total + np.asarray(forces(), float)
        steps += 1
        if O.time - start >= (sampled + 0.5) / SAMPLES_PER_WINDOW * seconds:
            sampled += 1
            for contact in contacts:
                contact.sample()
        if ends:
            return 0.5 * (np.asarray(first) + last), total / steps


def close_cell(options, place, forces, contacts, halfwidth, step=O.step):
    """Step until the packing fraction is that of the options.

    Args:
        options (argparse.Namespace): of the case.
        place (callable): displacement of the sides over D, phi, phi0, as an array.
        forces (callable): on the sides [N/m].
        contacts, step: as for :func:`window_means`.
        halfwidth (callable): of the contacts over the last window, their mean [m].

    Returns:
        array (m, n): over the n windows, as :func:`report_cell` takes it.
    """
    rows = []
    begin = phi = place()[1]
    with command_line.progress_bar(total=options.until_phi - begin) as bar:
        while phi < options.until_phi:
            where, force = window_means(window_of(options), place, forces, contacts, step)
            rows.append(
                [
                    *where,
                    *(force / (options.young * options.diameter)),
                    halfwidth() / options.diameter,
                    quasi_static()["kinetic_over_elastic"],
                ]
            )
            phi = place()[1]
            command_line.show_progress(bar, phi - begin, f"phi {phi:.4f}")
    return np.array(rows).T


def run_facts(seconds):
    """What every case says about its run, for ``result.json``.

    Args:
        seconds (float): that it took [s].
    """
    engine = observe.integrator()
    return {
        "wall_seconds": seconds,
        "steps": int(engine.steps),
        "dt": O.dt,
        "sweeps_per_step": engine.totalSweeps / engine.steps,
        "capped_steps": int(engine.cappedSteps),
        "largest_residual": engine.largestResidual,
        "points_per_grain": len(bodies.soft_bodies()[0].shape.points()["volume"]),
    }


def plot_force(options, x, force, exact, abscissa, xlabel, title):
    """``force.png``: forces over E D against a curve of ``finite_elements`` (None: there is none
    for this Poisson's ratio) with ``abscissa`` the name of its column for x."""
    figure = matplotlib.figure.Figure(figsize=(5, 4), layout="constrained")
    axes = figure.add_subplot()
    if exact is not None:
        shown = exact[exact[abscissa] <= 1.05 * x[-1]]
        axes.plot(
            shown[abscissa],
            shown.force_over_ED,
            color="black",
            lw=1,
            label="finite elements, converged",
        )
    axes.plot(
        x,
        force,
        "o",
        ms=3,
        mfc="none",
        label=rf"softgrain, $\zeta$ = {options.zeta:g}, {options.contact}",
    )
    axes.set(xlabel=xlabel, ylabel="force F / (E D)", xlim=(0, None), ylim=(0, None), title=title)
    axes.legend(frameon=False)
    axes.grid(alpha=0.3)
    figure.savefig(options.out / "force.png", dpi=200)


def report_cell(options, started, columns, own_results, exact, title):
    """Write, plot and print the results of a cell that closes.

    Args:
        options (argparse.Namespace): of the case.
        started (float): when the run began, as ``time.time()`` [s].
        columns (array (m, n)): over the n windows: displacement of the sides over D, phi, phi0,
            forces on the sides over E D (m - 5 rows), half-width of the contacts over D, kinetic
            over elastic energy; all dimensionless.
        own_results (callable): from the forces, further entries of ``result.json``.
        exact (numpy record array | None): curve of ``finite_elements``, None if there is none for
            this Poisson's ratio.
        title (str): of the plot.
    """
    displacement, phi, phi0, *forces, halfwidth, kinetic = columns
    facts = run_facts(time.time() - started)
    force = np.mean(forces, axis=0)
    command_line.write_result(
        options,
        {
            "phi": phi,
            "phi0": phi0,
            "wall_displacement_over_D": displacement,
            "force_over_ED": force,
            **own_results(forces),
            "contact_halfwidth_over_D": halfwidth,
            "kinetic_over_elastic": kinetic,
            **facts,
        },
    )
    plot_force(
        options,
        displacement,
        force,
        exact,
        abscissa="wall_displacement_over_D",
        xlabel="displacement of each side w / D",
        title=title,
    )
    print(
        f"phi = {phi[-1]:.4f}, w/D = {displacement[-1]:.4f}, F/(E D) = {force[-1]:.4f}; "
        f"{facts['steps']} steps in {facts['wall_seconds']:.1f} s. Results in {options.out}/"
    )
