"""The plugin meets YADE: in plain Python, scripts, batch jobs; it refuses what it does not fit."""

import sys
from pathlib import Path

import pytest
import yade
from scenes import YADE, assert_done, run_python

import softgrain as sg
from softgrain import _host

STEP_A_GRAIN = """
    O.reset()
    grain = sg.soft_disk((0, 0, 0), 0.01, zeta=0.3)
    grain.state.vel = (1, 0, 0)
    O.bodies.append(grain)
    O.engines = sg.engines()
    sg.set_time_step()
    O.run(10, True)
    assert O.iter == 10
    assert abs(grain.state.pos[0] - O.time) < 1e-9 * O.time
    print("done")
"""


@pytest.mark.parametrize("name", _host.OWN_CLASSES)
def test_class_is_part_of_yade_and_of_the_package(name):
    assert getattr(yade, name) is getattr(sg, name) is getattr(yade.wrapper, name)
    assert name in sg.__all__
    assert getattr(yade, name)().dict() is not None


def test_version_is_that_of_the_project():
    text = (Path(__file__).parents[2] / "CMakeLists.txt").read_text()
    assert f"project(softgrain VERSION {sg.__version__} " in text


def test_all_names_exist():
    assert all(hasattr(sg, name) for name in sg.__all__)


def test_guide_lists_all_names():
    guide = (Path(__file__).parents[2] / "doc" / "user_guide.md").read_text()
    listed = guide.partition("Everything in `softgrain.__all__`")[2]
    assert listed and not [name for name in sg.__all__ if f"`{name}`" not in listed]


def test_classes_are_known_as_children_of_their_base():
    assert "SoftGrain" in yade.system.childClasses("Shape")
    assert "SoftMat" in yade.system.childClasses("Material")


def test_second_import_replaces_no_class(tmp_path):
    assert_done(
        run_python(
            """
        import yade
        sphere = yade.wrapper.Sphere
        import softgrain
        grain = yade.wrapper.SoftGrain
        import importlib
        importlib.reload(softgrain)
        assert yade.wrapper.Sphere is sphere and yade.wrapper.SoftGrain is grain
        print("done")
        """,
            tmp_path,
        )
    )


def test_from_yade_import_softgrain(tmp_path):
    assert_done(
        run_python(
            """
        import softgrain
        from yade import softgrain as other
        import yade.softgrain
        assert other is softgrain and yade.softgrain is softgrain
        print("done")
        """,
            tmp_path,
        )
    )


def test_default_engines_take_a_soft_grain(tmp_path):
    """YADE's engines were made before the plugin; their dispatch tables must know its classes."""
    assert_done(
        run_python(
            """
        from yade import *
        assert len(O.engines) >= 4
        import softgrain as sg
        for x in (0, 0.015):
            O.bodies.append(sg.soft_disk((x, 0, 0), 0.01, zeta=0.3))
        O.bodies.append(utils.wall(-0.009, axis=0, material=FrictMat()))
        O.dt = 1e-6
        O.run(3, True)
        assert O.iter == 3
        print("done")
        """,
            tmp_path,
        )
    )


def test_plain_python(tmp_path):
    assert_done(
        run_python(
            "import softgrain as sg\nfrom yade import O\n" + _dedented(STEP_A_GRAIN), tmp_path
        )
    )


def test_script_of_yade(tmp_path):
    """Late classes become names of the script, as YADE's own are."""
    assert_done(
        run_python(
            "import softgrain as sg\nassert SoftMat is sg.SoftMat\n" + _dedented(STEP_A_GRAIN),
            tmp_path,
            command=[YADE, "-n", "-x"],
        )
    )


def test_error_of_a_script_is_its_exit_status(tmp_path):
    process = run_python(
        "import softgrain as sg\nsg.soft_disk((0, 0, 0), -1)\n",
        tmp_path,
        command=[YADE, "-n", "-x"],
    )
    assert process.returncode == 1
    assert "radius = -1" in process.stderr + process.stdout


def test_batch_job(tmp_path):
    """Each line of the table is a job with its own parameters."""
    (tmp_path / "params.table").write_text("speed\n1.0\n2.0\n")
    code = """
        import softgrain as sg
        from pathlib import Path
        from yade import utils
        utils.readParamsFromTable(speed=0.0, noTableOk=True)
        from yade.params import table
        grain = sg.soft_disk((0, 0, 0), 0.01, zeta=0.3)
        grain.state.vel = (table.speed, 0, 0)
        O.bodies.append(grain)
        O.engines = sg.engines()
        sg.set_time_step()
        O.run(10, True)
        Path(f"job-{table.speed:g}").write_text(repr(grain.state.pos[0] / O.time))
    """
    process = run_python(
        code, tmp_path, command=["/usr/bin/yade-batch", "-j1", "--job-threads=1", "params.table"]
    )
    for speed in (1, 2):
        result = tmp_path / f"job-{speed}"
        assert result.exists(), process.stdout + process.stderr
        assert float(result.read_text()) == pytest.approx(speed, rel=1e-9)


def test_refuses_another_version(tmp_path):
    process = run_python(
        """
        import yade.config
        yade.config.version = "1999.01a"
        import softgrain
        """,
        tmp_path,
    )
    assert process.returncode == 1
    assert "ImportError: softgrain was built for YADE" in process.stderr
    assert "1999.01a" in process.stderr


def test_refuses_other_numbers(tmp_path):
    process = run_python(
        """
        import yade.config
        yade.config.highPrecisionBits = 80
        import softgrain
        """,
        tmp_path,
    )
    assert process.returncode == 1
    assert "ImportError" in process.stderr
    assert "80-bit" in process.stderr


def test_refuses_another_memory_layout(tmp_path):
    """What Python writes does not arrive where the plugin reads it; YADE is left as it was."""
    assert_done(
        run_python(
            """
        import yade
        class Elsewhere:
            stopAtIter = 0
            engines = ()
        yade.O = Elsewhere()
        try:
            import softgrain
        except ImportError as error:
            assert "laid out differently" in str(error), error
        else:
            raise AssertionError("not refused")
        assert not hasattr(yade.wrapper, "SoftGrain")
        print("done")
        """,
            tmp_path,
        )
    )


def test_without_yade(tmp_path):
    environment = {"PYTHONPATH": str(Path(sg.__file__).parents[1])}
    process = run_python("import softgrain\n", tmp_path, environment, [sys.executable])
    assert process.returncode == 1
    assert (
        "ImportError: softgrain is a plugin of YADE, which this Python does not find"
        in process.stderr
    )
    assert "PYTHONPATH" in process.stderr


def _dedented(code):
    return "\n".join(line.strip() for line in code.strip().splitlines())


SCENE = """
    import time
    import softgrain as sg
    from yade import FrictMat, O, utils

    soft = sg.SoftMat(young=1e5, massDamping=10)
    wall = FrictMat(frictionAngle=0)
    for place, axis, sense in ((0, 1, 1), (-0.0121, 0, 1), (0.0121, 0, -1)):
        O.bodies.append(utils.wall(place, axis=axis, sense=sense, material=wall))
    for k in range(6):
        place = (0.001 * (-1) ** k, 0.0105 + 0.021 * k, 0)
        O.bodies.append(sg.soft_disk(place, 0.01, soft, zeta=0.3))
    O.engines = sg.engines(gravity=(0, -9.81, 0), sleep=False)
"""


def test_process_ends_in_a_run(tmp_path):
    """Which goes on in the background."""
    end = """
    O.run()
    time.sleep(1)
    """
    result = run_python(SCENE + end, tmp_path, command=[YADE, "-n", "-x"])
    assert result.returncode == 0, result.stderr[-2000:]
