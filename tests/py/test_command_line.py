"""Options and results of the runnable cases."""

import argparse
import json

import numpy as np
import pytest

from softgrain import command_line


@pytest.mark.parametrize(
    "check, good, bad",
    [
        (command_line.positive, ("1", "1e-9", "2.5"), ("0", "-1", "nan", "x", "")),
        (command_line.non_negative, ("0", "0.3"), ("-1e-9", "nan", "x")),
        (command_line.fraction, ("0.5", "1e-3"), ("0", "1", "-1", "nan", "x")),
        (command_line.angle, ("0", "-30", "400"), ("nan", "x")),
        (command_line.node_spacing, ("1.25", "4"), ("1.24", "4.1", "nan", "x")),
        (command_line.surface_spacing, ("0.5", "4"), ("0.49", "4.1", "nan", "x")),
        (command_line.step_fraction, ("1e-3", "1"), ("0", "1.01", "nan", "x")),
    ],
)
def test_number_types(check, good, bad):
    for text in good:
        assert check(text) == float(text)
    for text in bad:
        with pytest.raises(argparse.ArgumentTypeError) as caught:
            check(text)
        assert str(caught.value).startswith(f"{text!r} is not a number")


@pytest.mark.parametrize(
    "check", (command_line.positive, command_line.non_negative, command_line.angle)
)
def test_infinity_is_refused(check):
    with pytest.raises(argparse.ArgumentTypeError):
        check("inf")


def test_output_folder(tmp_path):
    folder = command_line.output_folder(str(tmp_path / "a" / "b"))
    assert folder.is_dir()
    assert command_line.output_folder(str(folder)) == folder
    (tmp_path / "file").write_text("")
    with pytest.raises(argparse.ArgumentTypeError, match="cannot make the folder"):
        command_line.output_folder(str(tmp_path / "file"))


def test_result(tmp_path):
    """Arrays and numbers of numpy become plain JSON; no part is left behind."""
    command_line.write_result(
        tmp_path, {"a": np.arange(3.0), "b": np.float64(0.1), "c": [np.int64(2)], "d": 1}
    )
    assert json.loads((tmp_path / "result.json").read_text()) == {
        "a": [0, 1, 2],
        "b": 0.1,
        "c": [2],
        "d": 1,
    }
    assert [p.name for p in tmp_path.iterdir()] == ["result.json"]


def test_failed_result_leaves_the_old_one(tmp_path):
    command_line.write_result(tmp_path, {"a": 1})
    with pytest.raises((TypeError, ValueError)):
        command_line.write_result(tmp_path, {"a": object()})
    assert json.loads((tmp_path / "result.json").read_text()) == {"a": 1}


def test_progress_bar(capsys):
    with command_line.progress_bar(total=2.0) as bar:
        bar.n = 1.0
        bar.set_postfix_str("half")
        bar.refresh()
    assert "50 %" in capsys.readouterr().err
