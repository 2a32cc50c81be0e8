"""Options and results of the runnable cases."""

import argparse
import json
import math

import numpy as np
import pytest

from softgrain import command_line


@pytest.mark.parametrize(
    "check, good, bad",
    [
        (command_line.positive, ("1", "1e-9", "2.5"), ("0", "-1", "nan", "x", "")),
        (command_line.negative, ("-1e-9", "-3"), ("0", "1", "nan", "x")),
        (command_line.non_negative, ("0", "0.3"), ("-1e-9", "nan", "x")),
        (command_line.fraction, ("0.5", "1e-3"), ("0", "1", "-1", "nan", "x")),
        (command_line.any_number, ("0", "-30", "400"), ("nan", "x")),
        (command_line.node_spacing, ("1.25", "4"), ("1.24", "4.1", "nan", "x")),
        (command_line.surface_spacing, ("0.5", "4"), ("0.49", "4.1", "nan", "x")),
        (command_line.step_fraction, ("1e-3", "1"), ("0", "1.01", "nan", "x")),
        (command_line.share, ("0", "0.5", "1"), ("-1e-9", "1.01", "nan", "x")),
        (command_line.resolution, ("0.001", "0.5"), ("0", "0.51", "nan", "x")),
        (command_line.poisson, ("-0.99", "0", "0.49"), ("-1", "0.5", "nan", "x")),
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
    "check",
    (
        command_line.positive,
        command_line.negative,
        command_line.non_negative,
        command_line.any_number,
        command_line.whole_from(0),
    ),
)
def test_infinity_is_refused(check):
    for text in ("inf", "-inf"):
        with pytest.raises(argparse.ArgumentTypeError):
            check(text)


def test_whole_numbers():
    check = command_line.whole_from(4)
    assert [check(text) for text in ("4", "400")] == [4, 400]
    for text in ("3", "-4", "4.5", "1e3", "many", "", "9" * 400):
        with pytest.raises(argparse.ArgumentTypeError) as caught:
            check(text)
        assert str(caught.value) == f"{text!r} is not a whole number in [4, inf)"
    check = command_line.whole_from(1, 255)
    assert [check(text) for text in ("1", "255")] == [1, 255]
    for text in ("0", "256"):
        with pytest.raises(argparse.ArgumentTypeError, match=r"whole number in \[1, 255\]"):
            check(text)


def test_seeds_fit_the_generators_of_yade():
    assert command_line.seed("1000000000") < 2**31 - 1000  # some count on from it
    for text in ("0", "99999999999"):
        with pytest.raises(argparse.ArgumentTypeError):
            command_line.seed(text)


def test_input_file(tmp_path):
    path = tmp_path / "labels.png"
    path.write_bytes(b"")
    assert command_line.input_file(str(path)) == path
    for text in (str(tmp_path), str(tmp_path / "other.png"), ""):
        with pytest.raises(argparse.ArgumentTypeError, match="is no file"):
            command_line.input_file(text)


def test_output_folder(tmp_path):
    folder = command_line.output_folder(str(tmp_path / "a" / "b"))
    assert folder.is_dir()
    assert command_line.output_folder(str(folder)) == folder
    (tmp_path / "file").write_text("")
    with pytest.raises(argparse.ArgumentTypeError, match="cannot make the folder"):
        command_line.output_folder(str(tmp_path / "file"))


def test_case_parser(tmp_path, monkeypatch, capsys):
    """The folder for results is there when options have been read, also that of the default."""
    monkeypatch.chdir(tmp_path)
    parser = command_line.case_parser("What it does.\n\nHow it does it.\n", out="found")
    with pytest.raises(SystemExit):
        parser.parse_args(["--help"])
    said = capsys.readouterr().out
    assert "What it does." in said and "How" not in said and "default: found" in said
    assert not (tmp_path / "found").exists()
    assert parser.parse_args([]).out.resolve() == tmp_path / "found"
    assert (tmp_path / "found").is_dir()
    assert parser.parse_args(["--out", "a/b"]).out.resolve() == tmp_path / "a" / "b"
    assert (tmp_path / "a" / "b").is_dir()


def test_result(tmp_path):
    """Arrays and numbers of numpy become plain JSON; no part is left behind."""
    options = argparse.Namespace(zeta=0.1, out=tmp_path, errors=[0.1, 0.2])
    command_line.write_result(
        options, {"a": np.arange(3.0), "b": np.float64(0.1), "c": [np.int64(2)], "d": 1}
    )
    assert json.loads((tmp_path / "result.json").read_text()) == {
        "a": [0, 1, 2],
        "b": 0.1,
        "c": [2],
        "d": 1,
        "options": {"zeta": "0.1", "out": str(tmp_path), "errors": "[0.1, 0.2]"},
    }
    assert [p.name for p in tmp_path.iterdir()] == ["result.json"]


def test_json_file(tmp_path):
    """Any name, and a list as well; a file that is there is replaced."""
    for value in ([1], [{"a": np.float32(0.5)}]):
        command_line.write_json(tmp_path / "rows.json", value)
    assert json.loads((tmp_path / "rows.json").read_text()) == [{"a": 0.5}]
    assert [p.name for p in tmp_path.iterdir()] == ["rows.json"]


def test_what_is_no_finite_number_is_null(tmp_path):
    value = {"a": math.inf, "b": [1.5, np.float64("nan")], "c": np.array([-np.inf, 2])}
    command_line.write_result(argparse.Namespace(out=tmp_path), value)
    text = (tmp_path / "result.json").read_text()
    assert "Infinity" not in text and "NaN" not in text
    result = {"a": None, "b": [1.5, None], "c": [None, 2.0]}
    assert json.loads(text) == {**result, "options": {"out": str(tmp_path)}}


def test_failed_result_leaves_the_old_one(tmp_path):
    options = argparse.Namespace(out=tmp_path)
    command_line.write_result(options, {"a": 1})
    with pytest.raises((TypeError, ValueError)):
        command_line.write_result(options, {"a": object()})
    kept = {"a": 1, "options": {"out": str(tmp_path)}}
    assert json.loads((tmp_path / "result.json").read_text()) == kept


def test_progress_bar(capsys):
    with command_line.progress_bar(total=2.0) as bar:
        bar.n = 1.0
        bar.set_postfix_str("half")
        bar.refresh()
    assert "50 %" in capsys.readouterr().err
