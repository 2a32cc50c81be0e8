"""Options that ``compare_rigid.py`` passes on to ``run.py``."""

import compaction

from softgrain import command_line, finite_elements


def add_case_options(parser):
    """Add them to an ``argparse.ArgumentParser``."""
    add = parser.add_argument
    add(
        "--poisson",
        type=float,
        choices=finite_elements.CELL_POISSON_RATIOS,
        default=0.2,
        help="Poisson's ratio of the grains; up to 0.237 bonded particles can have it [-]",
    )
    some = command_line.whole_from(compaction.FEWEST_GRAINS)
    add("--grains", type=some, default=25, help="in the packing [-]")
    add("--mu", type=command_line.non_negative, default=0.3, help="friction between grains [-]")
    add(
        "--until-phi",
        type=command_line.positive,
        default=0.95,
        help="nominal packing fraction to stop at, above that of the loose packing [-]",
    )


def check_case_options(parser, options):
    """Leave by ``parser.error`` if the packing would stop before it starts."""
    start = compaction.START_PHI
    command_line.check_until_phi(parser, options, start, f"{start}")


def case_arguments(options):
    """Their values, as words of a command line: list of str."""
    return [
        f"--poisson={options.poisson}",
        f"--grains={options.grains}",
        f"--mu={options.mu}",
        f"--until-phi={options.until_phi}",
    ]
