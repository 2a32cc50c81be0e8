"""Figure 4 of the paper: stress against packing fraction, for resolutions (a) and frictions (b)."""

import numpy as np

from compactions import FRICTIONS, compact_all, compaction_options, setting
from softgrain.runs import new_figure, write_table

RESOLUTIONS = (0.10, 0.11, 0.13, 0.15)
LEVELS = (0.84, 0.88, 0.92, 0.96, 0.98)  # packing fractions of the tables


def draw(path, curves):
    """One line for each (label, result)."""
    figure, axes = new_figure(r"packing fraction $\phi$", r"$\sigma$ / E")
    for label, result in curves:
        axes.plot(result["phi"], result["stress_over_E"], lw=1, label=label)
    axes.set_ylim(bottom=0)
    axes.legend(frameon=False)
    figure.savefig(path, dpi=200)


def table_row(name, result):
    """Stress at the levels, averaged over 0.01 in phi, blank where the run did not reach it."""
    phi, stress = np.array(result["phi"]), np.array(result["stress_over_E"])
    cells = []
    for level in LEVELS:
        near = np.abs(phi - level) < 0.005
        cells.append(f"{stress[near].mean():.4f}" if near.any() else "")
    return [name, *cells]


def main():
    options = compaction_options(__doc__)
    by_resolution = [setting(options, zeta=zeta) for zeta in RESOLUTIONS]
    by_friction = [setting(options, mu=mu) for mu in FRICTIONS]
    distinct = by_resolution + [s for s in by_friction if s["mu"] > 0]
    results = dict(zip(map(str, distinct), compact_all(distinct, options)))

    parts = {"a": [], "b": []}
    for chosen in by_resolution:
        parts["a"].append((rf"$\zeta$ = {chosen['zeta']:.2f}", results[str(chosen)]))
    for chosen in by_friction:
        parts["b"].append((rf"$\mu$ = {chosen['mu']:g}", results[str(chosen)]))
    for part, curves in parts.items():
        draw(options.out / f"figure4{part}.png", curves)
        head = [f"stress / E, Figure 4{part}", *[f"phi = {level:g}" for level in LEVELS]]
        rows = [table_row(label.replace("$", "").lstrip("\\"), r) for label, r in curves]
        write_table(options.out / f"figure4{part}.md", head, rows)


if __name__ == "__main__":
    main()
