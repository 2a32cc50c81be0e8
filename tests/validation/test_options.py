"""Options of the cases: units in the help, and a clear word about what cannot be."""

import adhesion
import compaction
import compare_rigid
import harden_packing
import hertz
import hexagonal_cell
import image_grains
import interfaces
import periodic_lattice
import pytest
import rigid_column
import rigid_packing
import square_cell
import stress_control
from runs import run_case, run_yade

UNITS = {
    "compaction": ("[-]", "[m/s]"),
    "hertz": ("[-]", "[m/s]", "[Pa]", "[kg/m3]", "[m]", "[degrees]"),
    "square_cell": ("[-]", "[m/s]", "[Pa]", "[kg/m3]", "[m]", "[degrees]"),
    "hexagonal_cell": ("[-]", "[m/s]", "[Pa]", "[kg/m3]", "[m]", "[degrees]"),
}
#: Of README.md's table, where all run in the same way.
OTHERS = (
    "image_grains",
    "stress_control",
    "interfaces",
    "adhesion",
    "rigid_partners",
    "harden_packing",
    "rigid_packing",
    "rigid_column",
    "compare_rigid",
    "periodic_lattice",
    "periodic_shear",
)


def yade_script(name, *options):
    return run_yade(f"{name}.py", *options, timeout=60)


@pytest.mark.parametrize("name", UNITS)
def test_help_names_units(name):
    process = yade_script(name, "--help")
    assert process.returncode == 0
    assert all(unit in process.stdout for unit in UNITS[name])


@pytest.mark.parametrize("name", OTHERS)
def test_runs_in_yade(name):
    process = yade_script(name, "--help")
    assert process.returncode == 0, process.stderr
    assert "--out" in process.stdout


def test_exit_status(tmp_path):
    """The status of the whole run, so that a batch of runs notices."""
    process = yade_script("compaction", "--grains", "2", "--out", str(tmp_path))
    assert process.returncode == 2, process.stdout + process.stderr
    assert "argument --grains: '2' is not a whole number in [6, inf)" in process.stderr


#: Of several cases.
CELLS = {
    "--until-phi 0.5": "--until-phi: 0.5 is not above the start at pi/",
    "--orientation east": "--orientation: 'east' is not a number",
    "--zeta 3": "--zeta: ",
}
#: By case, wrong options and what is said about them.
REFUSED = {
    compaction: {
        "--grains 3": "--grains: '3' is not a whole number in [6, inf)",
        "--grains many": "--grains: 'many' is not a whole number in [6, inf)",
        "--seed 0": "--seed: '0' is not a whole number in [1, 1000000000]",
        "--seed 99999999999": "--seed: '99999999999' is not a whole number in [1, 1000000000]",
        "--until-phi 0.5": "--until-phi: 0.5 is not above the start at 0.7",
        "--until-phi 1.5": "--until-phi: '1.5' is not a number in (0, 1)",
        "--mu -1": "--mu: '-1' is not a number in [0, inf)",
        "--speed fast": "--speed: 'fast' is not a number in (0, inf)",
        "--zeta 3": "--zeta: ",
        "--zeta 0": "--zeta: ",
        "--poisson 0.5": "--poisson: ",
        "--poisson -2": "--poisson: ",
        "--contact springs": "--contact: invalid choice: 'springs'",
        "--resolution 1": "--resolution",
        "--out /proc/none": "cannot make the folder '/proc/none'",
    },
    hertz: {
        "--until 1.5": "--until: '1.5' is not a number in (0, 1)",
        "--until 0.05 --speed 0.5": "--speed: the plates approach by 0.07",
        "--young 0": "--young: '0' is not a number in (0, inf)",
        "--zeta 3": "--zeta: ",
        "--poisson 0.5": "--poisson: ",
        "--order 4": "--order: invalid choice: ",
        "--node-spacing 1": "--node-spacing: ",
        "--surface-spacing 0": "--surface-spacing: ",
        "--tolerance 0": "--tolerance: ",
        "--time-step-fraction 1.1": "--time-step-fraction: ",
        "--condition flat": "--condition: invalid choice: 'flat'",
        "--formulation euler": "--formulation: invalid choice: 'euler'",
        "--velocity-update pic": "--velocity-update: invalid choice: 'pic'",
        "--formulation updated --order 1": "--order: 1 is outside the admissible range [2, 3]",
        "--formulation updated --contact nodes": "--contact: nodes needs --formulation total",
        "--volumetric projected --condition plane_stress": "--volumetric: projected needs ",
        "--pic-share 0.1": "--pic-share: 0.1 needs --velocity-update flip",
        "--velocity-update flip --pic-share 2": "--pic-share: '2' is not a number in [0, 1]",
    },
    square_cell: CELLS,
    hexagonal_cell: {**CELLS, "--rings 1": "--rings: '1' is not a whole number in [2, inf)"},
    image_grains: {
        "--image IMAGE --columns 3": "--columns: nothing is drawn where --image is given",
        "--image IMAGE --seed 3": "--seed: nothing is drawn where --image is given",
    },
    adhesion: {
        "--zeta 0.1 0": "--zeta: '0' is not a number in [0.001, 0.5]",
        "--range 0": "--range: '0' is not a number in (0, inf)",
        "--poisson 0.5": "--poisson: '0.5' is not a number in (-1, 0.5)",
    },
    interfaces: {"--zeta 1": "--zeta: '1' is not a number in [0.001, 0.5]"},
    stress_control: {
        "--stress 3e4": "--stress: '3e4' is not a number in (-inf, 0)",
        "--dim 1": "--dim: invalid choice: ",
        "--ways push:1": "--ways: 'push:1' is none of wall, force, servo, triaxial",
        "--ways wall:slow": "--ways: 'slow' is not a number in (0, inf)",
        "--ways triaxial:1": "--ways: triaxial needs --dim 3",
    },
    compare_rigid: {
        "--grains 3": "--grains: '3' is not a whole number in [6, inf)",
        "--mu -1": "--mu: '-1' is not a number in [0, inf)",
        "--poisson 0.3": "--poisson: invalid choice: ",
        "--models springs": "--models: invalid choice: 'springs'",
    },
    harden_packing: {
        "--errors 0.01 0.001": "--errors: '0.001' is not a number in [0.002, 0.3]",
        "--depth 1": "--depth: '1' is not a number in (0, 1)",
    },
    periodic_lattice: {
        "--until 0.01": "--until: 0.01 is not in the range (0.01, 0.115]",
        "--lattice triangular --until 0.06": "--until: 0.06 is not in the range (0.01, 0.057]",
    },
    rigid_column: {
        "--width 1.9": "--width: '1.9' is not a number in [2, inf)",
        "--width 6 --aspects 2 0.1": "--aspects: 0.1 makes no whole row of disks",
        "--linear 3": "--linear: [3.0] are not among --aspects",
    },
    rigid_packing: {
        "--disks 19": "--disks: '19' is not a whole number in [20, inf)",
        "--in-cell 29": "--in-cell: '29' is not a whole number in [30, inf)",
    },
}


@pytest.mark.parametrize(
    "case, options",
    [(case, options) for case, known in REFUSED.items() for options in known],
    ids=lambda value: getattr(value, "__name__", value),
)
def test_refusal(case, options, capsys, tmp_path):
    with pytest.raises(SystemExit) as caught:
        words = options.replace("IMAGE", __file__).split()
        case.parse_options(["--out", str(tmp_path), *words])
    assert caught.value.code == 2
    assert REFUSED[case][options] in capsys.readouterr().err


def test_image_grains_ends_at_phi(tmp_path):
    options = ("--columns", "2", "--zeta", "0.3", "--phi", "0.9")
    phi = run_case("image_grains", tmp_path, *options)["phi"]
    assert 0.9 <= phi[-1] < 0.901 and (phi[:-1] < 0.9).all()


def test_stress_that_walls_do_not_bear_in_time(tmp_path):
    process = yade_script("harden_packing", "--stress", "1", "--out", str(tmp_path))
    assert process.returncode == 1, process.stdout + process.stderr
    assert "--stress: after 0.25 s under 1.0 Pa a wall bears 0 of it" in process.stderr


def test_adhesion_that_no_theory_is_for(tmp_path):
    options = ("--cohesion", "1e7", "--range", "1e-3")
    process = yade_script("adhesion", *options, "--out", str(tmp_path))
    assert process.returncode == 1, process.stdout + process.stderr
    assert "adhesion: the disk is pulled off at a contact as wide as itself" in process.stderr


def test_packing_that_begins_where_it_ends(tmp_path):
    """It has a record all the same."""
    options = ("--grains", "6", "--zeta", "0.3", "--until-phi", "0.701", "--speed", "50")
    result = run_case("compaction", tmp_path, *options)
    assert len(result["phi"]) >= 1 and result["phi"][-1] > 0.701


def test_cell_that_the_controller_does_not_shrink(tmp_path):
    options = ("--grains", "10", "--stress", "0.2", "--mu", "0", "--zeta", "0.3")
    process = yade_script("periodic_shear", *options, "--rate", "2", "--out", str(tmp_path))
    assert process.returncode == 1, process.stdout + process.stderr
    assert "the cell stands still at stresses of 0.9" in process.stderr
    assert "Take more --grains or less --stress" in process.stderr


def test_good_options(tmp_path):
    options = compaction.parse_options(
        ["--zeta", "0.2", "--poisson", "-0.2", "--mu", "0", "--out", str(tmp_path)]
    )
    assert (options.zeta, options.poisson, options.mu, options.out) == (0.2, -0.2, 0, tmp_path)
    options = hertz.parse_options(["--zeta", "0.5", "--poisson", "0", "--out", str(tmp_path)])
    assert (options.zeta, options.poisson) == (0.5, 0)
