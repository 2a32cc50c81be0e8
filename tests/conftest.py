"""Every test starts from an empty scene."""

import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "scripts"), str(ROOT / "tests" / "shared")]


@pytest.fixture(autouse=True)
def empty_scene():
    import yade

    import softgrain  # noqa: F401

    yade.O.reset()
    yield
    yade.O.reset()
