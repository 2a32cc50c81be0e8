"""Uniaxial compaction of soft disks in a box (Nezamabadi & Radjai 2024, section 3.2).

Run it with YADE: ``scripts/yade -n -x -j2 scripts/compaction.py --grains 100 --until-phi 0.95 --out
DIR``. A packing is prepared with YADE's generator and rigid DEM, its spheres are turned into soft
disks in place, and the top wall moves down at constant speed; plane strain, frictionless walls.
``positions.npy`` has the grains' centres at the start and at each record of ``result.json``: an
array (records + 1, grains, 2) [m].
"""

import math
import time

import matplotlib.figure
import numpy as np
from yade import (
    Bo1_Sphere_Aabb,
    Bo1_Wall_Aabb,
    ForceResetter,
    FrictMat,
    Ig2_Sphere_Sphere_ScGeom,
    Ig2_Wall_Sphere_ScGeom,
    InsertionSortCollider,
    InteractionLoop,
    Ip2_FrictMat_FrictMat_FrictPhys,
    Law2_ScGeom_FrictPhys_CundallStrack,
    NewtonIntegrator,
    O,
    Sphere,
    utils,
)

import softgrain as sg
from softgrain import cases, command_line
from softgrain.clouds import full_cloud

YOUNG = 1e6  # Pa, the paper's value; results over E do not depend on it
DENSITY = 1000  # kg/m3, the paper's value
MEAN_RADIUS = 0.01  # m, the paper's value
RADIUS_SPREAD = 0.15  # uniform in mean (1 +- spread): weak, yet enough not to crystallise
CLOUD_PHI = 0.45  # of the generated cloud
FEWEST_GRAINS = 6  # fewer do not fit side by side, and overlap more than can be relaxed
START_PHI = 0.70  # of the loose packing made by rigid DEM, below random loose packing for all mu
RECORDS_PER_UNIT_PHI = 400
JAMMING_PHI = 0.84  # of frictionless disks; the paper's Figure 3b
FILLED_PHI = 0.85  # at which the grains would fill a square box, about the densest one
RIGID_YOUNG, RIGID_POISSON = 1e8, 0.3  # Pa, -: stiff, so that rigid DEM leaves small overlaps
RIGID_DAMPING = 0.4  # NewtonIntegrator.damping of rigid DEM
RIGID_SPEED = 2.0  # m/s, of the top wall in rigid DEM: damping takes the motion out again after it
RIGID_SETTLING_STEPS = 5000


def parse_options(arguments=None):
    parser = command_line.case_parser(__doc__, out="compaction")
    add = parser.add_argument
    some = command_line.whole_from(FEWEST_GRAINS)
    add("--grains", type=some, default=400, help="number of grains [-]")
    add("--mu", type=command_line.non_negative, default=0.3, help="friction between grains [-]")
    add("--zeta", type=command_line.resolution, default=0.11, help="relative resolution 2 dr/D [-]")
    add("--poisson", type=command_line.poisson, default=0.45, help="Poisson's ratio [-]")
    add("--speed", type=command_line.positive, default=0.5, help="of the top wall [m/s]")
    command_line.add_until_phi(parser, start=f"{START_PHI}")
    command_line.add_method_options(parser)
    add("--seed", type=command_line.seed, default=1, help="of the packing generator [-]")
    options = parser.parse_args(arguments)
    command_line.check_method(parser, options)
    command_line.check_until_phi(parser, options, START_PHI, f"{START_PHI}")
    return options


class Box:
    """Four walls: left, right, bottom fixed; top moves."""

    def __init__(self, width, height):
        walls = sg.walls_around((0, 0), (width, height), "walls")
        self.left, self.right, self.bottom, self.top = O.bodies.append(walls)
        self.width = width

    @property
    def height(self):
        return O.bodies[self.top].state.pos[1]

    @property
    def area(self):
        return self.width * self.height

    def close(self, speed):
        """Move the top wall down at this speed [m/s]."""
        O.bodies[self.top].state.vel = (0, -speed, 0)


def prepare_rigid(options):
    """Loose packing of rigid disks at phi = START_PHI; leaves the scene and returns its box."""
    O.materials.append(
        FrictMat(
            young=RIGID_YOUNG,
            poisson=RIGID_POISSON,
            density=DENSITY,
            frictionAngle=0,
            label="walls",
        )
    )
    solid = options.grains * math.pi * MEAN_RADIUS**2
    width = math.sqrt(solid / FILLED_PHI)
    box = Box(width, solid / CLOUD_PHI / width)
    corner = (box.width, box.height, 0)
    cloud = full_cloud(options.grains, corner, MEAN_RADIUS, RADIUS_SPREAD, options.seed)
    ids = cloud.toSimulation(material="walls")
    for i in ids:
        O.bodies[i].state.blockedDOFs = "zXY"
    # One thread, sorted interactions: otherwise the order of YADE's sums depends on the threads.
    O.engines = [
        ForceResetter(),
        InsertionSortCollider(
            [Bo1_Sphere_Aabb(), Bo1_Wall_Aabb()], verletDist=0.1 * MEAN_RADIUS, ompThreads=1
        ),
        InteractionLoop(
            [Ig2_Sphere_Sphere_ScGeom(), Ig2_Wall_Sphere_ScGeom()],
            [Ip2_FrictMat_FrictMat_FrictPhys()],
            [Law2_ScGeom_FrictPhys_CundallStrack()],
            ompThreads=1,
            loopOnSortedInteractions=True,
        ),
        NewtonIntegrator(damping=RIGID_DAMPING, ompThreads=1),
    ]
    O.dt = 0.5 * utils.PWaveTimeStep()
    areas = sum(math.pi * b.shape.radius**2 for b in O.bodies if isinstance(b.shape, Sphere))
    box.close(RIGID_SPEED)
    while areas / box.area < START_PHI:
        O.step()
    box.close(0)
    sg.advance(RIGID_SETTLING_STEPS)
    return box


def make_soft(options):
    """Turn the rigid packing soft in place."""
    material = sg.SoftMat(
        young=YOUNG,
        poisson=options.poisson,
        density=DENSITY,
        frictionAngle=math.atan(options.mu),
        label="grains",
    )
    O.materials.append(material)
    O.engines = []
    sg.soften(
        material=material,
        zeta=options.zeta,
        contact=options.contact,
        time_step_fraction=options.time_step_fraction,
        **command_line.method_attributes(options),
    )
    O.engines = sg.engines(**command_line.engine_attributes(options))
    O.trackEnergy = True


def centres():
    """Centres of mass of the grains: array (n, 2)."""
    places = [b.state.pos for b in sg.soft_bodies()]
    return np.array([(x[0], x[1]) for x in places])


class Recorder:
    """What is measured between two records, and all records so far.

    The displacement ratio is mean |dy| over mean |dx| of the grains since the last record, 0 where
    no grain moved sideways.
    """

    def __init__(self, box):
        self.box = box
        self.records = {
            name: []
            for name in (
                "phi",
                "phi0",
                "stress_over_E",
                "stress_top_over_E",
                "displacement_ratio",
                "coordination",
                "kinetic_over_elastic",
                "unbalanced_force",
            )
        }
        self.positions = [centres()]  # at the start and at each record
        self.balance = sg.Balance()
        self.energy_error = 0.0
        self._restart()

    def _restart(self):
        self._bottom = self._top = 0.0
        self._steps = 0

    def step(self):
        """Take in the forces of the last step."""
        self._bottom -= O.forces.f(self.box.bottom)[1]
        self._top += O.forces.f(self.box.top)[1]
        self._steps += 1

    def record(self):
        """Close the window of mean forces and append a record."""
        self.positions.append(centres())
        moved = np.abs(self.positions[-1] - self.positions[-2]).mean(axis=0)
        scale = self._steps * self.box.width * YOUNG
        indicator = sg.quasi_static()
        values = (
            sg.packing_fraction(self.box.area),
            sg.packing_fraction(self.box.area, nominal=True),
            self._bottom / scale,
            self._top / scale,
            moved[1] / moved[0] if moved[0] > 0 else 0.0,
            sg.coordination_number(),
            indicator["kinetic_over_elastic"],
            indicator["unbalanced_force"],
        )
        for name, value in zip(self.records, values):
            self.records[name].append(value)
        self.energy_error = max(self.energy_error, self.balance.error())
        self._restart()

    @property
    def phi(self):
        return self.records["phi"][-1]

    @property
    def stress(self):
        return self.records["stress_over_E"][-1]


def compact(options, box):
    """Move the top wall down until phi is reached; returns the recorder and the seconds it took."""
    draw(options, box, "packing_start")
    box.close(options.speed)
    O.step()
    recorder = Recorder(box)
    solid = sg.packing_fraction(1.0, nominal=True)
    jammed = False
    started = time.time()
    drawing = 0.0
    begin = phi = sg.packing_fraction(box.area)
    with command_line.progress_bar(total=options.until_phi - begin) as bar:
        while phi < options.until_phi or not recorder.records["phi"]:
            next_height = solid / (solid / box.height + box.width / RECORDS_PER_UNIT_PHI)
            while box.height > next_height:
                O.step()
                recorder.step()
            recorder.record()
            phi = recorder.phi
            text = f"phi {phi:.4f}, stress/E {recorder.stress:.2e}"
            command_line.show_progress(bar, phi - begin, text)
            if not jammed and phi >= JAMMING_PHI:
                jammed = True
                paused = time.time()
                draw(options, box, "packing_jammed")
                drawing += time.time() - paused
    seconds = time.time() - started - drawing
    draw(options, box, "packing_end")
    return recorder, seconds


def draw(options, box, name):
    phi = sg.packing_fraction(box.area)
    sg.draw_packing(
        options.out / f"{name}.png",
        box=(0, box.width, 0, box.height),
        scale=YOUNG,
        title=rf"$\phi$ = {phi:.3f}, $\mu$ = {options.mu:g}",
    )


def plot_stress(options, records):
    figure = matplotlib.figure.Figure(figsize=(5, 4), layout="constrained")
    axes = figure.add_subplot()
    axes.plot(records["phi"], records["stress_over_E"], lw=1.5, label="bottom wall")
    axes.plot(records["phi"], records["stress_top_over_E"], lw=0.8, ls="--", label="top wall")
    axes.set(
        xlabel=r"packing fraction $\phi$",
        ylabel=r"$\sigma$ / E",
        ylim=(0, None),
        title=rf"{options.grains} grains, $\mu$ = {options.mu:g}, $\zeta$ = {options.zeta:g}",
    )
    axes.legend(frameon=False)
    axes.grid(alpha=0.3)
    figure.savefig(options.out / "stress.png", dpi=200)


def main():
    options = parse_options()
    box = prepare_rigid(options)
    make_soft(options)
    recorder, seconds = compact(options, box)
    engine = sg.integrator()
    np.save(options.out / "positions.npy", recorder.positions)
    command_line.write_result(
        options,
        {
            **recorder.records,
            **cases.run_facts(seconds),
            "grains": options.grains,
            "largest_overlap_over_dr": engine.largestOverlap,
            "energy_error": recorder.energy_error,
        },
    )
    plot_stress(options, recorder.records)
    print(
        f"phi = {recorder.phi:.4f}, stress/E = {recorder.stress:.4f}; {int(engine.steps)} steps "
        f"in {seconds:.1f} s, "
        f"{engine.totalSweeps / engine.steps:.1f} sweeps a step, largest overlap "
        f"{engine.largestOverlap:.3f} dr, "
        f"energy error {100 * recorder.energy_error:.2f} %. Results in {options.out}/"
    )


if __name__ == "__main__":
    main()
