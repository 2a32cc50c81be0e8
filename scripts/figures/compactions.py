"""The compactions of the paper's section 3.2, shared by Figures 3 to 5."""

from pathlib import Path

from softgrain.command_line import fraction, whole_from
from softgrain.runs import parse_options, run_all

COMPACTION = Path(__file__).resolve().parents[1] / "compaction.py"
FRICTIONS = (0, 0.1, 0.3, 0.5, 0.7)
RESOLUTION = 0.11  # the paper's choice


def compaction_options(description, **extra):
    """Options of a figure of compactions."""
    return parse_options(
        description,
        jobs=2,
        out="figures",
        # from as many on as compaction.py has it
        grains={"type": whole_from(6), "default": 400, "help": "number of grains [-]"},
        until_phi={"type": fraction, "default": 0.98, "help": "packing fraction to stop at [-]"},
        **extra,
    )


def setting(options, mu=0, zeta=RESOLUTION, seed=1):
    """Options of one compaction."""
    return {
        "grains": options.grains,
        "mu": mu,
        "zeta": zeta,
        "seed": seed,
        "until_phi": options.until_phi,
    }


def compact_all(settings, options):
    """Results of the compactions, in the order of the settings."""
    return run_all(COMPACTION, settings, options)
