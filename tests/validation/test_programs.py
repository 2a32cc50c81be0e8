"""Programs whose results no test looks at: they run to their end, as small as they go."""

import subprocess
import sys

import pytest
from runs import SCRIPTS, run_yade

#: Programs for YADE: their options, and a file that they leave.
IN_YADE = {
    "benchmark/contact_solvers": ("--grains=6 --zeta=0.3 --out=.", "contact_solvers.md"),
    "benchmark/insertion": ("--grains=4", None),
    "benchmark/quasi_static": ("--grains=6 --zeta=0.4 --out=.", "quasi_static.md"),
    "benchmark/sleep": ("--grains=4 --zeta=0.4 --until=0.05 --rows=2", None),
    "benchmark/soften_late": ("--grains=6 --zeta=0.4 --speed=2 --loads 1e-3", None),
    "siconos/make_dense": ("--grains=100 --zeta=0.3 --steps=2 --result=dense.npz", "dense.npz"),
    "siconos/make_problems": ("--out=.", "compaction.npz"),
    "stress_control": ("--duration=0.005 --ways wall:1 servo:0.1 --out=.", "result.json"),
    "compare_rigid": ("--grains=6 --until-phi=0.75 --out=.", "comparison.md"),
}

#: The same of programs for Python, which start YADE themselves.
BESIDE_YADE = {
    "figures/figure3": ("--grains=6 --until-phi=0.9 --out=.", "figure3.png"),
    "figures/figure4": ("--grains=6 --until-phi=0.8 --out=.", "figure4a.png"),
    "figures/figure5": ("--grains=6 --until-phi=0.8 --seeds=1 --out=.", "figure5.png"),
    "reference/disk_between_walls": ("--poisson=0.45 --out=fe.txt", "fe.txt"),
}

#: Of these, those that take more than some ten seconds.
LONGER = (
    "benchmark/contact_solvers",
    "benchmark/quasi_static",
    "compare_rigid",
    "figures/figure4",
    "figures/figure5",
    "reference/disk_between_walls",
)


def of(programs):
    return pytest.mark.parametrize(
        "program",
        [pytest.param(p, marks=pytest.mark.slow) if p in LONGER else p for p in programs],
    )


def assert_done(process, folder, file):
    assert process.returncode == 0, process.stdout + process.stderr
    assert file is None or (folder / file).stat().st_size > 0


@of(IN_YADE)
def test_program_in_yade(program, tmp_path):
    options, file = IN_YADE[program]
    assert_done(run_yade(f"{program}.py", *options.split(), folder=tmp_path), tmp_path, file)


@of(BESIDE_YADE)
def test_program_beside_yade(program, tmp_path):
    options, file = BESIDE_YADE[program]
    command = [sys.executable, str(SCRIPTS / f"{program}.py"), *options.split()]
    process = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=1200)
    assert_done(process, tmp_path, file)
