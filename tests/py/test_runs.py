"""Runs of a case that are made once and kept."""

import argparse
import json

import pytest

from softgrain import runs

SETTINGS = [{"zeta": 0.1}, {"zeta": 0.2}, {"zeta": 0.1}]


@pytest.fixture
def made(monkeypatch):
    """Folders of the runs that were made, none by YADE; those with zeta = 0.2 fail at the end."""
    folders = []

    def make(script, chosen, folder):
        folders.append(folder)
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "result.json").write_text(json.dumps(chosen))
        return chosen["zeta"] < 0.2

    monkeypatch.setattr(runs, "_make", make)
    return folders


def test_equal_settings_are_one_run(made, tmp_path):
    options = argparse.Namespace(jobs=3, out=tmp_path)
    results = runs.try_all("case.py", SETTINGS, options)
    assert results == [{"zeta": 0.1}, None, {"zeta": 0.1}] and len(made) == 2
    assert runs.try_all("case.py", SETTINGS[:1], options) == [{"zeta": 0.1}] and len(made) == 2


def test_failed_run_is_made_again(made, tmp_path):
    options = argparse.Namespace(jobs=1, out=tmp_path)
    for _ in range(2):
        with pytest.raises(SystemExit, match="1 of 1 runs failed"):
            runs.run_all("case.py", SETTINGS[1:2], options)
    assert len(made) == 2
