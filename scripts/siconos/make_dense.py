"""Write the contact problem of a step of a dense packing, and how fast softgrain swept it.

    scripts/yade -n -x scripts/siconos/make_dense.py --result FILE.npz [--grains 400]

For ``speed.py``. Beside the arrays of ``SoftGrainIntegrator.contactProblem``: ``sweeps`` and
``residual`` of that step, and ``seconds_per_sweep``, the median over ``--steps`` steps of the time
of the phase ``solve``, measuring the residual included, over its number of sweeps.
"""

import argparse
import statistics
import sys
from pathlib import Path

import numpy as np
from yade import O

import softgrain as sg
from softgrain import command_line

sys.path.append(str(Path(sys.argv[0]).resolve().parents[1] / "benchmark"))

import scenes  # noqa: E402


def parse_options():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    add = parser.add_argument
    add("--result", type=Path, required=True, help="file to write, .npz")
    some = command_line.whole_from(scenes.compaction.FEWEST_GRAINS)
    add("--grains", type=some, default=400, help="number of grains [-]")
    add("--zeta", type=command_line.resolution, default=0.11, help="relative resolution 2 dr/D [-]")
    add(
        "--node-spacing",
        type=command_line.node_spacing,
        default=1.25,
        help="step of the grid over dr [-]",
    )
    add("--tolerance", type=command_line.positive, default=1e-2, help="of the sweeps [-]")
    add("--steps", type=command_line.whole_from(1), default=50, help="steps measured [-]")
    return parser.parse_args()


def seconds_per_sweep():
    sg.reset_times()
    O.step()
    return sg.phase_times()["solve"][0] / sg.integrator().sweeps


def main():
    options = parse_options()
    scenes.dense_scene(options)
    integrator = sg.integrator()
    integrator.tolerance = options.tolerance
    O.timingEnabled = True
    seconds = statistics.median(seconds_per_sweep() for _ in range(options.steps))
    np.savez_compressed(
        options.result,
        **integrator.contactProblem(),
        sweeps=integrator.sweeps,
        residual=integrator.residual,
        seconds_per_sweep=seconds,
    )
    contacts = int(integrator.contacts)
    print(
        f"{contacts} contacts, {integrator.sweeps:.1f} sweeps to a residual of "
        f"{integrator.residual:.1e}, {1e9 * seconds / contacts:.1f} ns a contact and sweep"
    )


if __name__ == "__main__":
    main()
