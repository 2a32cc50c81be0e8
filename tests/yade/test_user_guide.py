"""The examples of doc/user_guide.md run as they stand there."""

import re
from pathlib import Path

import __main__
import pytest

GUIDE = Path(__file__).parents[2] / "doc" / "user_guide.md"


def sections():
    """Heading, level, and python blocks of each section."""
    heading = re.compile(r"^(#{2,3}) (.*)$", re.MULTILINE)
    block = re.compile(r"^```python\n(.*?)^```", re.MULTILINE | re.DOTALL)
    parts = heading.split(GUIDE.read_text())[1:]
    return [
        (title, len(marks), block.findall(text))
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


EXAMPLES = examples()


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
