"""Figure 2b of the paper: F(d) of one disk at four resolutions, and the modulus fitted to it.

The paper fits F = pi/4 E* d, d the displacement of the disk's centre (half the approach of the
plates), and extrapolates the modulus linearly to zeta = 0, where it expects E* = E/(1 - nu^2). The
exact F(d) is not straight, so the fitted modulus depends on the range: the same fit to converged
finite elements is the value to be met.
"""

import math
from pathlib import Path

import numpy as np

from softgrain import finite_elements
from softgrain.runs import new_figure, parse_options, run_all, write_table

HERTZ = Path(__file__).resolve().parents[1] / "hertz.py"
POISSON = 0.45
EFFECTIVE = 1 / (1 - POISSON**2)  # E*/E
RESOLUTIONS = (0.03, 0.05, 0.08, 0.1)
UNTIL = 0.1  # delta/D
CONTACTS = ("points", "surface")


def fitted_modulus(delta, force):
    """E*_o/E of the line through the origin F/(E D) = pi/4 E*_o/E d/D closest to the data."""
    d = np.asarray(delta) / 2
    return float(np.dot(d, force) / np.dot(d, d) * 4 / math.pi)


def exact_curve():
    exact = finite_elements.disk_between_plates("plane_strain")
    shown = exact.delta_over_D <= UNTIL
    return exact.delta_over_D[shown], exact.force_over_ED[shown]


def main():
    options = parse_options(__doc__, jobs=2, out="figures")
    settings = [
        {"contact": contact, "zeta": zeta, "until": UNTIL}
        for contact in CONTACTS
        for zeta in RESOLUTIONS
    ]
    results = run_all(HERTZ, settings, options)
    grid = np.linspace(0, UNTIL, 101)[1:]
    exact = np.interp(grid, *exact_curve())
    truth = fitted_modulus(grid, exact)

    figure, axes = new_figure(
        r"displacement of the centre d / D", r"F / (E* D)", xlim=(0, UNTIL / 2)
    )
    moduli = {contact: [] for contact in CONTACTS}
    styles = {"points": "--", "surface": "-"}
    for chosen, result in zip(settings, results):
        delta, force = np.array(result["delta_over_D"]), np.array(result["force_over_ED"])
        at_grid = np.interp(grid, delta, force)
        moduli[chosen["contact"]].append(fitted_modulus(grid, at_grid))
        axes.plot(
            delta / 2,
            force / EFFECTIVE,
            styles[chosen["contact"]],
            color=f"C{RESOLUTIONS.index(chosen['zeta'])}",
            lw=1,
            label=rf"{chosen['contact']}, $\zeta$ = {chosen['zeta']:g}",
        )
    axes.plot(grid / 2, exact / EFFECTIVE, "k:", label="finite elements")
    axes.set_ylim(bottom=0)
    axes.legend(frameon=False, fontsize=7)
    draw_moduli(axes.inset_axes((0.62, 0.12, 0.36, 0.34)), moduli, truth)
    figure.savefig(options.out / "figure2b.png", dpi=200)

    rows = []
    for contact in CONTACTS:
        limit = np.polyfit(RESOLUTIONS, moduli[contact], 1)[1]
        values = [f"{value:.3f}" for value in moduli[contact]]
        rows.append([f"ours, {contact}", *values, f"{limit:.3f}"])
    rows.append(["paper (points)", *["falls linearly with zeta"] * 4, f"{EFFECTIVE:.3f}"])
    rows.append(["finite elements, same fit", *[""] * 4, f"{truth:.3f}"])
    head = ["E*_o / E", *[f"zeta = {z:g}" for z in RESOLUTIONS], "zeta -> 0, linear"]
    write_table(options.out / "figure2b.md", head, rows)


def draw_moduli(inset, moduli, truth):
    for contact, marker in zip(CONTACTS, "os"):
        slope, limit = np.polyfit(RESOLUTIONS, moduli[contact], 1)
        inset.plot(RESOLUTIONS, moduli[contact], marker, ms=3, color="black", mfc="none")
        zeta = np.array([0, max(RESOLUTIONS)])
        inset.plot(zeta, limit + slope * zeta, color="0.6", lw=0.8)
    inset.axhline(EFFECTIVE, color="C3", lw=0.8, ls=":")
    inset.axhline(truth, color="black", lw=0.8, ls=":")
    inset.set_xlabel(r"$\zeta$", fontsize=7)
    inset.set_ylabel(r"$E^*_o / E$", fontsize=7)
    inset.tick_params(labelsize=6)


if __name__ == "__main__":
    main()
