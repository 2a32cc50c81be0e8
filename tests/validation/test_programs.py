"""Programs whose results no test looks at: they run to their end, as small as they go."""

import subprocess
import sys

import pytest
from runs import SCRIPTS, run_yade

#: Programs for YADE: options, and a file that they leave.
IN_YADE = {
    "benchmark/contact_solvers.py": ("--grains=6 --zeta=0.3 --out=.", "contact_solvers.md"),
    "benchmark/insertion.py": ("--grains=4", None),
    "benchmark/quasi_static.py": ("--grains=6 --zeta=0.4 --out=.", "quasi_static.md"),
    "benchmark/sleep.py": ("--grains=4 --zeta=0.4 --until=0.05 --rows=2", None),
    "benchmark/soften_late.py": ("--grains=6 --zeta=0.4 --speed=2 --loads 1e-3", None),
    "siconos/make_dense.py": ("--grains=6 --zeta=0.3 --steps=2 --result=dense.npz", "dense.npz"),
    "siconos/make_problems.py": ("--out=.", "compaction.npz"),
    "stress_control.py": ("--duration=0.005 --ways wall:1 servo:0.1 --out=.", "result.json"),
    "compare_rigid.py": ("--grains=6 --until-phi=0.75 --out=.", "comparison.md"),
}

#: Programs for Python that start YADE themselves.
BESIDE_YADE = {
    "figures/figure3.py": ("--grains=6 --until-phi=0.9 --out=.", "figure3.png"),
    "figures/figure4.py": ("--grains=6 --until-phi=0.8 --out=.", "figure4a.png"),
    "figures/figure5.py": ("--grains=6 --until-phi=0.8 --out=.", "figure5.png"),
    "reference/disk_between_walls.py": ("--poisson=0.45 --way=0.01 --out=fe.txt", "fe.txt"),
}


def assert_done(process, folder, file):
    assert process.returncode == 0, process.stdout + process.stderr
    assert file is None or (folder / file).stat().st_size > 0


@pytest.mark.slow
@pytest.mark.parametrize("script", IN_YADE)
def test_program_in_yade(script, tmp_path):
    options, file = IN_YADE[script]
    assert_done(run_yade(script, *options.split(), folder=tmp_path), tmp_path, file)


@pytest.mark.slow
@pytest.mark.parametrize("script", BESIDE_YADE)
def test_program_beside_yade(script, tmp_path):
    options, file = BESIDE_YADE[script]
    command = [sys.executable, str(SCRIPTS / script), *options.split()]
    process = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=1200)
    assert_done(process, tmp_path, file)
