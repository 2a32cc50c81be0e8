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
    assert len(changes) <= 3
    process = subprocess.run(
        [YADE, "-n", "-x", str(script)], cwd=folder, capture_output=True, text=True, timeout=300
    )
    told = process.stdout + process.stderr
    assert process.returncode == 0 and "done" in process.stdout, told
    return told


@needs_examples
def test_simple_scene(tmp_path):
    """simple-scene/simple-scene.py: a soft ball falls on a box and rests there with its weight."""
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
        {"O.run(20000)": "O.run(9000, True)"},
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


SOFT_BALLS = "sg.soften(material=sg.SoftMat(massDamping=20, frictionAngle=.5), zeta=.4, dim=3)"


@needs_examples
def test_billiard(tmp_path):
    """billiard.py: sixteen soft balls collide; momentum is kept."""
    run_example(
        "billiard.py",
        {
            "O.dt = .01 * PWaveTimeStep()": (
                "import softgrain as sg; "
                "sg.soften(material=sg.SoftMat(density=rhoBall), zeta=.4, dim=3)"
            ),
            "from yade import qt": "O.engines = sg.engines()",
        },
        {"qt.View()": "O.run(1000, True)"},
        """
momentum = sum((b.state.mass * b.state.vel for b in O.bodies), Vector3.Zero)
assert (momentum - Vector3(0, massBall * velBall, 0)).norm() < 1e-9 * velBall, momentum
assert O.bodies[schlagBall].state.vel[1] < .8 * velBall
assert sum(O.bodies[i].state.vel.norm() > .01 * velBall for i in sphereIds) > 3
print("done")
""",
        tmp_path,
    )


@needs_examples
def test_kinematic(tmp_path):
    """test/kinematic.py: soft balls on a circle and a helix, by YADE's kinematic engines."""
    run_example(
        "test/kinematic.py",
        {
            "O.engines = [": "import softgrain as sg; O.engines = [",
            "NewtonIntegrator(warnNoForceReset=False),": "*sg.engines(verlet_distance=.01),",
            "O.dt = 1e-6": SOFT_BALLS,
        },
        {"O.saveTmp()": "O.run(1000, True)"},
        """
for ball, start in zip(O.bodies, (-1, 1)):
    pos = ball.state.pos
    assert abs(hypot(pos[0], pos[1]) - 1) < 1e-4, pos
    assert abs(pos[0] - start * cos(O.time)) < 1e-3 and abs(pos[2] - .1 * O.time) < 1e-9
    assert ball.shape.isRigid()
print("done")
""",
        tmp_path,
    )


@needs_examples
def test_wall(tmp_path):
    """test/wall.py: balls fall into a corner of walls; these bear their weight together."""
    run_example(
        "test/wall.py",
        {
            "O.materials.append(FrictMat(young=30e9, density=1000, poisson=.2, "
            "frictionAngle=.5))": (
                "import softgrain as sg; O.materials.append(FrictMat(density=1000))"
            ),
            "O.dt = PWaveTimeStep()": SOFT_BALLS,
            "O.save('/tmp/a.xml')": "O.engines = sg.engines(gravity=[10, 10, 10])",
        },
        {
            "from yade import qt": "",
            "qt.Controller()": "",
            "qt.View()": "",
            "O.run()": "O.run(4000, True)",
        },
        """
weight = 10 * sum(b.state.mass for b in sg.soft_bodies())
borne = sum((Vector3(*sg.wall_force(k)) for k in range(4)), Vector3.Zero)
assert (borne - weight * Vector3.Ones).norm() < .05 * weight, (borne, weight)
assert max(b.state.vel.norm() for b in sg.soft_bodies()) < .2
print("done")
""",
        tmp_path,
    )


@needs_examples
def test_remove_body(tmp_path):
    """test/remove-body.py: soft balls beside new rigid ones on facets, both erased at random. The
    packaged script asks for an attribute of the collider that this YADE has no more."""
    collider = "InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Facet_Aabb()],"
    run_example(
        "test/remove-body.py",
        {
            "O.dt = 1e-4": (
                "import softgrain as sg; "
                "sg.soften(material=sg.SoftMat(), zeta=.5, dim=3, overlap='shrink'); "
                "O.engines = sg.engines(gravity=(0, 0, -10))"
            ),
        },
        {
            collider + " nBins=5, sweepLength=5e-3),": collider + " verletDist=5e-3),",
            "for i in range(0, 100):": "for i in range(0, 20):",
            "for i in range(0, 1000):": "for i in range(0, 30):",
            "import random, sys": "import random, sys; random.seed(2)",
            "from yade import qt": "",
            "qt.Controller()": "",
            "qt.View()": "",
        },
        """
assert O.iter == 1500 and 0 < len(sg.soft_bodies()) < 20
print("done")
""",
        tmp_path,
    )
