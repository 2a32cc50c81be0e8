"""Figure 3 of the paper: the frictionless packing at the start, at jamming and at the end."""

import sys

from matplotlib.image import imread

from compactions import COMPACTION, compact_all, compaction_options, setting
from softgrain.runs import new_figure, run_folder

STATES = ("start", "jammed", "end")


def main():
    options = compaction_options(__doc__)
    chosen = setting(options)
    compact_all([chosen], options)
    folder = run_folder(COMPACTION, chosen, options.out)
    if not (folder / "packing_jammed.png").exists():
        sys.exit(f"--until-phi: {options.until_phi} ends before the packing jams; choose more")
    figure, axes = new_figure("", "", width=13)
    axes.set_axis_off()
    for k, state in enumerate(STATES):
        place = axes.inset_axes((k / 3, 0, 1 / 3, 1))
        place.imshow(imread(folder / f"packing_{state}.png"))
        place.set_axis_off()
    figure.savefig(options.out / "figure3.png", dpi=200)


if __name__ == "__main__":
    main()
