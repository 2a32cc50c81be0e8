"""Figure 5 of the paper: ratio of mean displacements, random loose and random close packing.

Displacements of the grains' centres are counted from the start of the compaction; their mean along
y (that of the loading) over that along x is plotted against the packing fraction. As in the paper,
its first peak is taken as random loose packing (RLP) and the first trough after it as random close
packing (RCP). Both scatter much from packing to packing; the packing fractions at which stress and
coordination number take off are given beside them.
"""

import numpy as np

from compactions import COMPACTION, FRICTIONS, RESOLUTION, compact_all, compaction_options, setting
from softgrain.command_line import resolution, whole_from
from softgrain.runs import new_figure, run_folder, write_table

#: Standard deviation in phi of the Gaussian that smooths the ratio before extrema are sought.
SMOOTHING = 0.005
#: Stress over E that tells a jammed packing from one that flows, which carries half of it.
JAMMED_STRESS = 0.005
#: Coordination number of a jammed packing with friction.
ISOSTATIC = 3
#: Packing fractions at which curves are evaluated. Before, hardly any grain has moved.
GRID = np.arange(0.73, 0.98, 0.001)


def displacement_ratio(position):
    """Mean |y - y_0| over mean |x - x_0| of the grains.

    Args:
        position (array (records + 1, grains, 2)): of the centres, the start first [m].

    Returns:
        array (records,): [-].
    """
    moved = np.abs(position[1:] - position[0]).mean(axis=1)
    return moved[:, 1] / np.maximum(moved[:, 0], 1e-9 * moved[:, 1])


def smooth(phi, values):
    """Values smoothed by a Gaussian in phi, on the part of the grid that the run reached."""
    grid = GRID[GRID < phi[-1] - SMOOTHING]
    weight = np.exp(-0.5 * ((grid[:, None] - phi[None, :]) / SMOOTHING) ** 2)
    return grid, weight @ values / weight.sum(axis=1)


def loose_and_close(phi, ratio):
    """Packing fractions of the first peak and of the first trough after it.

    Args:
        phi (array (n,)): packing fractions, increasing [-].
        ratio (array (n,)): smoothed ratio of displacements [-].

    Returns:
        tuple: (phi_RLP, phi_RCP), nan where there is none.
    """
    slope = np.diff(ratio)
    peaks = np.flatnonzero((slope[:-1] > 0) & (slope[1:] <= 0)) + 1
    if len(peaks) == 0:
        return np.nan, np.nan
    troughs = np.flatnonzero((slope[:-1] < 0) & (slope[1:] >= 0)) + 1
    troughs = troughs[troughs > peaks[0]]
    return phi[peaks[0]], phi[troughs[0]] if len(troughs) else np.nan


def takes_off(phi, values, level):
    """Packing fraction from which on the smoothed values stay above a level; nan if they do not."""
    grid, smoothed = smooth(phi, np.asarray(values))
    below = np.flatnonzero(smoothed <= level)
    last = below[-1] if len(below) else -1
    return grid[last + 1] if last + 1 < len(grid) else np.nan


def main():
    options = compaction_options(
        __doc__,
        seeds={"type": whole_from(1), "default": 3, "help": "packings for each friction [-]"},
        zeta={"type": resolution, "default": RESOLUTION, "help": "relative resolution 2 dr/D [-]"},
    )
    seeds = range(1, options.seeds + 1)
    figure, axes = new_figure(r"packing fraction $\phi$", r"mean $|dy|$ / mean $|dx|$", width=6)
    settings = {
        mu: [setting(options, mu=mu, zeta=options.zeta, seed=seed) for seed in seeds]
        for mu in FRICTIONS
    }
    results = iter(compact_all(sum(settings.values(), []), options))
    found = []
    for k, (mu, chosen) in enumerate(settings.items()):
        runs = [next(results) for _ in chosen]
        curves = [curve(*pair, options) for pair in zip(chosen, runs)]
        found.append(np.array([marks(*pair) for pair in zip(curves, runs)]))
        for n, (phi, ratio) in enumerate(curves):
            label = rf"$\mu$ = {mu:g}" if n == 0 else None
            axes.plot(phi, ratio, color=f"C{k}", lw=0.4 if n else 1.2, label=label)
    axes.set_yscale("log")
    axes.legend(frameon=False, fontsize=8, loc="upper left")
    draw_fractions(axes.inset_axes((0.62, 0.1, 0.36, 0.36)), found)
    figure.savefig(options.out / "figure5.png", dpi=200)

    rows = []
    for mu, values in zip(FRICTIONS, found):
        mean, spread = np.nanmean(values, axis=0), np.nanstd(values, axis=0)
        paper = "about 0.84" if mu == 0 else "falls with mu"
        cells = [f"{m:.3f} ± {s:.3f}" for m, s in zip(mean, spread)]
        rows.append([f"{mu:g}", *cells, paper])
    stress, number = f"stress/E above {JAMMED_STRESS:g}", f"coordination above {ISOSTATIC}"
    head = ["mu", "RLP (mean ± standard deviation)", "RCP", stress, number, "RCP of the paper"]
    write_table(options.out / "figure5.md", head, rows)


def marks(displacements, result):
    """RLP, RCP, and where stress and coordination number take off, of one run."""
    return (
        *loose_and_close(*displacements),
        takes_off(np.array(result["phi"]), result["stress_over_E"], JAMMED_STRESS),
        takes_off(np.array(result["phi"]), result["coordination"], ISOSTATIC),
    )


def curve(chosen, result, options):
    """Smoothed ratio of a run."""
    position = np.load(run_folder(COMPACTION, chosen, options.out) / "positions.npy")
    return smooth(np.array(result["phi"]), displacement_ratio(position))


def draw_fractions(inset, found):
    for column, (name, marker) in enumerate((("RLP", "o"), ("RCP", "s"), ("stress", "^"))):
        mean = [np.nanmean(extrema[:, column]) for extrema in found]
        spread = [np.nanstd(extrema[:, column]) for extrema in found]
        inset.errorbar(FRICTIONS, mean, spread, fmt=marker + "-", ms=3, lw=0.8, label=name)
    inset.set_xlabel(r"$\mu$", fontsize=7)
    inset.set_ylabel(r"$\phi$", fontsize=7)
    inset.tick_params(labelsize=6)
    inset.legend(frameon=False, fontsize=6)


if __name__ == "__main__":
    main()
