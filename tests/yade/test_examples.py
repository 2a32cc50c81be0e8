"""Example scripts of the YADE package with three lines changed: soft grains in them."""

import subprocess
from pathlib import Path

import pytest
from scenes import YADE

EXAMPLES = Path("/usr/share/doc/yade/examples")

needs_examples = pytest.mark.skipif(
    not EXAMPLES.is_dir(), reason="the examples of the yade package are not installed"
)


def run_example(name, changes, steps, check, folder):
    """Run a packaged example with some lines replaced, then a check; returns what it printed.

    Args:
        name (str): path of the example in the folder of the package.
        changes (dict): what lines become; each must be there once.
        steps (dict): replacements that only shorten the run or take out the window.
        check (str): code appended.
        folder (Path): to run in.
    """
    lines = (EXAMPLES / name).read_text().splitlines()
    for old, new in {**changes, **steps}.items():
        places = [k for k, line in enumerate(lines) if line.strip() == old]
        assert len(places) == 1, f"{name}: {old!r} stands {len(places)} times"
        indent = lines[places[0]][: -len(lines[places[0]].lstrip())] if lines[places[0]] else ""
        lines[places[0]] = indent + new
    script = folder / Path(name).name
    script.write_text("\n".join(lines) + "\n" + check)
    process = subprocess.run(
        [YADE, "-n", "-x", str(script)], cwd=folder, capture_output=True, text=True, timeout=300
    )
    told = process.stdout + process.stderr
    assert process.returncode == 0 and "done" in process.stdout, told
    return told


@needs_examples
def test_simple_scene(tmp_path):
    """simple-scene/simple-scene.py: the ball that falls on a box is soft, and comes to rest with its
    weight on the box."""
    run_example(
        "simple-scene/simple-scene.py",
        {
            "o = Omega()  # for advaned folks: this creates default MetaBody as well": (
                "import softgrain as sg; o = Omega()"
            ),
            "o.dt = .01 * PWaveTimeStep()": (
                "sg.soften([1], sg.SoftMat(young=2e6, massDamping=20, frictionAngle=.5), zeta=.4)"
            ),
            "o.save('/tmp/a.xml.bz2')": "o.engines = sg.engines(gravity=[0, 0, -9.81])",
        },
        {"O.run(20000)": "O.run(6000, True)"},
        """
ball, weight = O.bodies[1], 9.81 * O.bodies[1].state.mass
force = O.forces.f(0)
assert ball.state.vel.norm() < 1e-3, ball.state.vel
assert abs(force[2] + weight) < 1e-2 * weight, (force, weight)
assert 1.3 < ball.state.pos[2] < 1.5, ball.state.pos
assert ball.shape.energy()["elastic"] > 0
print("done")
""",
        tmp_path,
    )
