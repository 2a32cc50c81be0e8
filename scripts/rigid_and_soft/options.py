"""Options of the packing that ``compare_rigid.py`` passes on to ``run.py``."""

from softgrain import command_line


def add_packing_options(parser):
    """Add them to an ``argparse.ArgumentParser``."""
    add = parser.add_argument
    add("--grains", type=command_line.whole_from(4), default=25, help="in the packing [-]")
    add("--mu", type=command_line.non_negative, default=0.3, help="friction between grains [-]")
    add(
        "--until-phi",
        type=command_line.positive,
        default=0.95,
        help="nominal packing fraction to stop at [-]",
    )


def packing_arguments(options):
    """Their values, as words of a command line: list of str."""
    return [
        f"--grains={options.grains}",
        f"--mu={options.mu}",
        f"--until-phi={options.until_phi}",
    ]
