"""Figure 5 of the paper: ratio of mean displacements, random loose and random close packing.

The first peak of the ratio of the grains' mean displacements along y and x is taken as random loose
packing (RLP), the first trough after it as random close packing (RCP).
"""

import numpy as np

from compactions import FRICTIONS, compact_all, compaction_options, setting
from softgrain.runs import new_figure, write_table

#: Standard deviation in phi of the Gaussian that smooths the ratio before extrema are sought.
SMOOTHING = 0.008


def smooth(phi, ratio):
    """Ratio smoothed in log scale by a Gaussian in phi."""
    phi, logarithm = np.asarray(phi), np.log(np.maximum(ratio, 1e-3))
    weight = np.exp(-0.5 * ((phi[:, None] - phi[None, :]) / SMOOTHING) ** 2)
    return np.exp(weight @ logarithm / weight.sum(axis=1))


def loose_and_close(phi, ratio):
    """Packing fractions of the first peak and of the first trough after it.

    Args:
        phi (array (n,)): packing fractions, increasing [-].
        ratio (array (n,)): smoothed ratio of displacements [-].

    Returns:
        tuple: (phi_RLP, phi_RCP), nan where there is none.
    """
    inside = np.arange(1, len(phi) - 1)
    rises, falls = ratio[1:-1] - ratio[:-2], ratio[2:] - ratio[1:-1]
    peaks = inside[(rises > 0) & (falls <= 0)]
    if len(peaks) == 0:
        return np.nan, np.nan
    troughs = inside[(rises < 0) & (falls >= 0)]
    troughs = troughs[troughs > peaks[0]]
    return phi[peaks[0]], phi[troughs[0]] if len(troughs) else np.nan


def main():
    options = compaction_options(
        __doc__, seeds={"type": int, "default": 3, "help": "packings for each friction [-]"}
    )
    seeds = range(1, options.seeds + 1)
    settings = [setting(options, mu=mu, seed=seed) for mu in FRICTIONS for seed in seeds]
    results = iter(compact_all(settings, options))

    figure, axes = new_figure(r"packing fraction $\phi$", r"mean $|dy|$ / mean $|dx|$", width=6)
    found = []
    for k, mu in enumerate(FRICTIONS):
        extrema = []
        for seed in seeds:
            result = next(results)
            phi, ratio = np.array(result["phi"]), smooth(
                result["phi"], result["displacement_ratio"]
            )
            extrema.append(loose_and_close(phi, ratio))
            label = rf"$\mu$ = {mu:g}" if seed == 1 else None
            axes.plot(phi, ratio, color=f"C{k}", lw=1.2 if seed == 1 else 0.4, label=label)
        found.append(np.array(extrema))
    axes.set_yscale("log")
    axes.legend(frameon=False, fontsize=8, loc="upper left")
    draw_fractions(axes.inset_axes((0.62, 0.62, 0.36, 0.36)), found)
    figure.savefig(options.out / "figure5.png", dpi=200)

    rows = []
    for mu, extrema in zip(FRICTIONS, found):
        mean, spread = np.nanmean(extrema, axis=0), np.nanstd(extrema, axis=0)
        paper = "about 0.84" if mu == 0 else "falls with mu"
        cells = [f"{m:.3f} ± {s:.3f}" for m, s in zip(mean, spread)]
        rows.append([f"{mu:g}", *cells, paper])
    head = ["mu", "RLP (mean ± standard deviation)", "RCP", "RCP of the paper"]
    write_table(options.out / "figure5.md", head, rows)


def draw_fractions(inset, found):
    for column, (name, marker) in enumerate((("RLP", "o"), ("RCP", "s"))):
        mean = [np.nanmean(extrema[:, column]) for extrema in found]
        spread = [np.nanstd(extrema[:, column]) for extrema in found]
        inset.errorbar(FRICTIONS, mean, spread, fmt=marker + "-", ms=3, lw=0.8, label=name)
    inset.set_xlabel(r"$\mu$", fontsize=7)
    inset.set_ylabel(r"$\phi$", fontsize=7)
    inset.tick_params(labelsize=6)
    inset.legend(frameon=False, fontsize=6)


if __name__ == "__main__":
    main()
