"""Options, progress and results common to the runnable cases."""

import argparse
import json
import math
import os
import sys
from pathlib import Path

from tqdm import tqdm

from softgrain import checks


def number(admissible):
    """Argument type: a finite number in a range, e.g. '(0, inf)' (float)."""
    return lambda text: _checked(text, float, admissible, f"a number in {admissible}")


positive = number("(0, inf)")
negative = number("(-inf, 0)")
non_negative = number("[0, inf)")
any_number = number("(-inf, inf)")
fraction = number("(0, 1)")
step_fraction = number("(0, 1]")
share = number("[0, 1]")
poisson = number("(-1, 0.5)")
resolution = number("[0.001, 0.5]")  # zeta
node_spacing = number("[1.25, 4]")  # over dr
surface_spacing = number("[0.5, 4]")  # over dr


def whole_from(least, most=math.inf):
    """Argument type: a whole number from ``least`` to ``most`` (int)."""
    admissible = f"[{least}, {most}{')' if most == math.inf else ']'}"
    return lambda text: _checked(text, int, admissible, f"a whole number in {admissible}")


def seed(text):
    """Argument type: of generators of random packings (int). YADE's takes 32 bits, and some cases
    count on from it."""
    return whole_from(1, 10**9)(text)


def input_file(text):
    """Argument type: a file that is there (Path)."""
    path = Path(text)
    if not path.is_file():
        raise argparse.ArgumentTypeError(f"{text!r} is no file")
    return path


def output_folder(text):
    """Argument type: a folder, made if missing."""
    if not text:
        raise argparse.ArgumentTypeError("'' is no name of a folder")
    folder = Path(text)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise argparse.ArgumentTypeError(f"cannot make the folder {text!r}: {error.strerror}")
    return folder


def _checked(text, kind, admissible, description):
    try:
        value = kind(text)
        good = math.isfinite(value) and checks.in_range(value, admissible)
    except (ValueError, OverflowError):
        good = False
    if not good:
        raise argparse.ArgumentTypeError(f"{text!r} is not {description}")
    return value


def case_parser(doc, out):
    """Parser of a runnable case, with the option ``--out``, a folder that is made if missing.

    Args:
        doc (str): docstring of the case; its first paragraph is shown with the help.
        out (str): folder for results where the option is not given.

    Returns:
        argparse.ArgumentParser: takes the further options of the case.
    """
    parser = argparse.ArgumentParser(description=doc.partition("\n\n")[0])
    parser.add_argument(
        "--out", type=output_folder, default=out, help="folder for results; default: %(default)s"
    )
    return parser


def add_method_options(parser, tolerance=1e-2):
    """Options of a case that choose how grains and contacts are computed.

    Args:
        parser (argparse.ArgumentParser): takes them.
        tolerance (float): default of the contact sweeps [-].

    See :func:`method_attributes` and :func:`engine_attributes`.
    """
    add = parser.add_argument
    add(
        "--contact",
        choices=("surface", "points", "nodes"),
        default="surface",
        help="contact geometry",
    )
    add("--order", type=int, choices=(1, 2, 3), default=3, help="order of the B-splines")
    add("--node-spacing", type=node_spacing, default=1.25, help="step of the grid over dr [-]")
    add("--surface-spacing", type=surface_spacing, default=1.0, help="of surface nodes over dr [-]")
    add("--tolerance", type=positive, default=tolerance, help="of the contact sweeps [-]")
    add(
        "--time-step-fraction",
        type=step_fraction,
        default=0.9,  # pressed grains; set_time_step() has 0.85, for those that fly
        help="time step over the critical one [-]",
    )
    add(
        "--formulation",
        choices=("total", "updated"),
        default="total",
        help="total or updated Lagrangian material point method (updated: order 2 or 3)",
    )
    add(
        "--velocity-update",
        choices=("nodal", "flip"),
        default="nodal",
        help="where velocities live from step to step with formulation total: at the nodes, or at "
        "the material points (the classical cycle); with updated always at the points",
    )
    add(
        "--pic-share",
        type=share,
        default=0.0,
        help="share of PIC beside FLIP where velocities live at the points [-]",
    )


def method_attributes(options):
    """Attributes of ``SoftGrain`` after :func:`add_method_options`."""
    return {
        "order": options.order,
        "nodeSpacing": options.node_spacing,
        "surfaceSpacing": options.surface_spacing,
        "formulation": options.formulation,
        "velocityUpdate": options.velocity_update,
        "picShare": options.pic_share,
    }


def engine_attributes(options):
    """Attributes of ``SoftGrainIntegrator`` after :func:`add_method_options`."""
    return {"tolerance": options.tolerance, "timeStepFraction": options.time_step_fraction}


def check_method(parser, options):
    """Refuse combinations of :func:`add_method_options` that cannot be."""
    if options.formulation == "updated" and options.order == 1:
        parser.error("argument --order: 1 is outside the admissible range [2, 3] for updated")
    if options.formulation == "updated" and options.contact == "nodes":
        parser.error("argument --contact: nodes needs --formulation total")
    at_points = options.formulation == "updated" or options.velocity_update == "flip"
    if options.pic_share > 0 and not at_points:
        parser.error(
            f"argument --pic-share: {options.pic_share} needs --velocity-update flip or "
            "--formulation updated"
        )


def add_until_phi(parser, start, of=""):
    """Option ``--until-phi``, the packing fraction to stop at.

    Args:
        parser (argparse.ArgumentParser): takes it.
        start (str): name of the packing fraction at the start, for the help.
        of (str): what is packed, for the help; e.g. " of the central cell".

    See :func:`check_until_phi`.
    """
    parser.add_argument(
        "--until-phi",
        type=fraction,
        default=0.98,  # where the paper stops
        help=f"packing fraction{of} to stop at, above {start} [-]",
    )


def check_until_phi(parser, options, start, name):
    """Refuse ``--until-phi`` at or below the packing fraction ``start``, called ``name``."""
    if options.until_phi <= start:
        parser.error(f"argument --until-phi: {options.until_phi} is not above the start at {name}")


def progress_bar(total):
    """Progress bar on stderr; a line now and then where stderr is no terminal."""
    interval = 0.5 if sys.stderr.isatty() else 10
    return tqdm(
        total=total,
        mininterval=interval,
        maxinterval=2 * interval,
        file=sys.stderr,
        bar_format="{percentage:3.0f} %|{bar:24}| {elapsed} < {remaining}{postfix}",
    )


def show_progress(bar, reached, text):
    """Move a bar to ``reached`` of its total, with a text behind it; drawn when it is due."""
    bar.set_postfix_str(text, refresh=False)
    bar.update(min(reached, bar.total) - bar.n)


def write_result(options, result):
    """Write ``result.json`` into the folder of the options, whole or not at all.

    Args:
        options (argparse.Namespace): of the run, ``out`` among them; they are written as texts.
        result (dict): as :func:`write_json` takes it.
    """
    texts = {name: str(value) for name, value in vars(options).items()}
    write_json(options.out / "result.json", {**result, "options": texts})


def write_json(path, value):
    """Write a JSON file, whole or not at all.

    Args:
        path (Path): the file; one that is there is replaced.
        value: lists, dicts, texts and numbers, those of numpy and its arrays included. What is no
            finite number, which JSON does not know, becomes null.

    Raises:
        TypeError, ValueError: the value has something else in it; nothing is written.
    """
    finite = json.loads(json.dumps(value, default=_plain), parse_constant=lambda name: None)
    text = json.dumps(finite, indent=1)
    part = path.with_name(path.name + ".part")
    part.write_text(text + "\n")
    os.replace(part, path)


def _plain(value):
    return value.tolist() if hasattr(value, "tolist") else float(value)
