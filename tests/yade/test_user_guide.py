"""The examples of doc/user_guide.md, and the script of README.md, run as they stand there."""

import re
from pathlib import Path

import __main__
import pytest

ROOT = Path(__file__).parents[2]
GUIDE = ROOT / "doc" / "user_guide.md"


def blocks_in(text):
    """Of Python."""
    return re.findall(r"^```python\n(.*?)^```", text, re.MULTILINE | re.DOTALL)


def sections():
    """Heading, level, and python blocks of each section."""
    heading = re.compile(r"^(#{2,3}) (.*)$", re.MULTILINE)
    parts = heading.split(GUIDE.read_text())[1:]
    return [
        (title, len(marks), blocks_in(text))
        for marks, title, text in zip(parts[::3], parts[1::3], parts[2::3])
    ]


def examples():
    """Name and code of each example, with what the guide says stands before it."""
    found, beginning, scene = [], "", ""
    for title, level, blocks in sections():
        if title == "Conventions":
            (beginning,) = blocks  # of all examples that are no complete scripts
            continue
        if level == 2:
            scene = blocks[0] if title == "Reading results" else ""
        for k, code in enumerate(blocks):
            before = scene if code != scene else ""
            is_whole = not beginning
            found.append((f"{title} {k}", code if is_whole else beginning + before + code))
    return found


(README,) = blocks_in((ROOT / "README.md").read_text())
EXAMPLES = [("README", README), *examples()]


def test_there_are_examples():
    assert len(EXAMPLES) > 25


@pytest.mark.parametrize("code", [c for _, c in EXAMPLES], ids=[name for name, _ in EXAMPLES])
def test_example(code, tmp_path, monkeypatch):
    """In the names of __main__, where PyRunner looks for its functions."""
    monkeypatch.chdir(tmp_path)
    before = dict(vars(__main__))
    try:
        exec(code, vars(__main__))
    finally:
        for name in set(vars(__main__)) - set(before):
            delattr(__main__, name)
        vars(__main__).update(before)
