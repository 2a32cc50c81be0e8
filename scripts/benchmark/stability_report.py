"""Table, page and picture of what ``stability.py`` found.

``studies`` is a dict from the name of a study to its rows: ``value``, ``outcome``, ``message`` and
``figures``.
"""

import csv

import matplotlib.figure


def write_csv(out, studies):
    names = sorted({n for rows in studies.values() for row in rows for n in row["figures"]})
    with open(out / "stability.csv", "w", newline="") as file:
        table = csv.writer(file)
        table.writerow(["study", "value", "outcome", *names, "message"])
        for study, rows in studies.items():
            for row in rows:
                figures = [row["figures"].get(name, "") for name in names]
                table.writerow([study, row["value"], row["outcome"], *figures, row["message"]])


SHOWN = {
    "force": "F",
    "energy_error": "energy error",
    "overlap_over_dr": "overlap/dr",
    "capped_share": "capped",
    "momentum_error": "momentum error",
    "restitution": "restitution",
    "force_difference": "difference of F",
    "drift_over_D": "drift/D",
    "kinetic_over_elastic": "kinetic/elastic",
    "tremor": "kinetic/elastic at the end",
    "energy_growth": "heating",
    "usual_ripple": "usual ripple",
    "ripple": "largest ripple",
}


PAGE = """# Stability

What runs, what stops with a message, and what would be wrong: a case that ran, but with a figure
beyond its bound (`BOUNDS` in `scripts/benchmark/stability.py`). This page is made by

    scripts/yade -n -x scripts/benchmark/stability.py --out DIR

Disks at zeta = 0.2, nu = 0.45, plane strain, at half the critical step (the default is 0.85 of it),
plates at 0.003 of the wave speed, no friction (pairs 0.5, packings 0.3), unless the study says
otherwise. F: mean force of both
plates over E D in the last quarter (compaction: wall stress over E at the end), as the speed of the
study has it; overlap: largest so far; capped: share of the steps whose sweeps hit the cap; heating:
growth of kinetic and elastic energy over the elastic energy; ripple: what the von Mises stress of a
point alternates in time against the points about it, over E, in the middle one of the grains and in
the one that has most. What rest means, and rest from
equilibrium: [decisions/0010](decisions/0010-grains-at-rest.md). What grains bear whose
mean pressure exceeds their Young's modulus:
[decisions/0008](decisions/0008-node-spacing.md#consequences).
"""


def as_text(figure):
    """Empty where there is none, or none that is a number."""
    return "" if figure is None else f"{figure:.3g}"


def write_markdown(out, studies, titles):
    lines = [PAGE]
    for study, rows in studies.items():
        columns = [n for n in SHOWN if any(n in row["figures"] for row in rows)]
        lines += [f"### {titles[study]}", "", f"`--only {study}`", ""]
        lines.append("| value | outcome | " + " | ".join(SHOWN[n] for n in columns) + " |")
        lines.append("|" + "---|" * (2 + len(columns)))
        for row in rows:
            cells = [as_text(row["figures"].get(n)) for n in columns]
            lines.append(f"| {row['value']:g} | {row['outcome']} | " + " | ".join(cells) + " |")
        messages = [f"{row['value']:g}: {row['message']}" for row in rows if row["message"]]
        lines += ["", *(f"- {message}" for message in messages), ""]
    (out / "stability.md").write_text("\n".join(lines))


def draw(out, studies):
    """A mark for each case: one line a study."""
    figure = matplotlib.figure.Figure(figsize=(9, 0.42 * len(studies) + 1.2), layout="constrained")
    axes = figure.add_subplot()
    colours = {"runs": "tab:green", "stops": "tab:orange", "wrong": "tab:red"}
    for line, (study, rows) in enumerate(studies.items()):
        for place, row in enumerate(rows):
            axes.plot(place, -line, "s", ms=14, color=colours[row["outcome"]])
            axes.text(place, -line - 0.42, f"{row['value']:g}", ha="center", fontsize=6)
    axes.set_yticks([-k for k in range(len(studies))], list(studies), fontsize=8)
    axes.set(xticks=[], ylim=(-len(studies) + 0.2, 0.8))
    axes.set(title="runs (green), stops with a message (orange), wrong (red)")
    figure.savefig(out / "stability.png", dpi=150)
