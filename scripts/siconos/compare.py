#!/usr/bin/python3
"""Solve contact problems by Siconos and compare with the impulses found by softgrain.

    /usr/bin/python3 scripts/siconos/compare.py [--solver newton] [--store] PROBLEM.npz ...

Runs outside YADE, with the Siconos of Debian 12 (Debian 13 has none):

    apt-get install python3-siconos python3-numpy

A problem is a file of arrays as ``SoftGrainIntegrator.contactProblem`` gives them (see its
documentation), with softgrain's impulses in ``impulse``. Two solvers of Siconos: NSGS, nonlinear
Gauss-Seidel as softgrain's, and a semismooth Newton method (Alart and Curnier), which has nothing
in common with it but may fail where W is singular. Columns of the table: contacts and dimension;
iterations; the residual of softgrain (doc/theory.md) and the one of Siconos, each of both answers,
softgrain's first; largest difference of the velocities over the largest velocity without impulses;
relative difference of the energies r.W r; largest difference of the impulses over the largest one.
Where W is singular on the contacts that carry force (hyperstatic), or friction strong, impulses may
differ between exact solutions.
"""

import argparse
import importlib.util
import sys
from pathlib import Path

import numpy as np

try:
    import siconos.numerics as siconos
except ImportError as error:
    sys.exit(
        f"compare.py: {error}. Siconos is a package of Debian 12, not of Debian 13. On Debian 12: "
        "apt-get install python3-siconos python3-numpy, then run it by /usr/bin/python3"
    )


def load_oracle():
    """The slow solver of softgrain's tests, which needs numpy alone, without the plugin."""
    path = Path(__file__).resolve().parents[2] / "py" / "softgrain" / "reference" / "solver.py"
    spec = importlib.util.spec_from_file_location("softgrain_oracle_solver", path)
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


oracle = load_oracle()


class Problem:
    """A problem of softgrain and the same in the local frames of Siconos.

    Siconos numbers the components of a contact normal first. The bias joins the normal velocity:
    Signorini's condition is on their sum, and friction does not see it.
    """

    def __init__(self, arrays):
        self.normal = arrays["normal"]
        self.contacts, self.dim = self.normal.shape
        self.bias, self.friction = arrays["bias"], arrays["friction"]
        self.free_velocity = arrays["free_velocity"]
        self.W = np.zeros((self.contacts, self.contacts))
        rows = np.repeat(np.arange(self.contacts), np.diff(arrays["delassus_offset"]))
        np.add.at(self.W, (rows, arrays["delassus_column"]), arrays["delassus_value"])

    def velocity(self, impulse):
        return self.free_velocity + self.W @ impulse

    def residual(self, impulse):
        return oracle.residual(
            self.W, self.free_velocity, self.normal, self.bias, self.friction, impulse
        )

    def frames(self, dim):
        """Orthonormal (contacts, dim, dim), the normal first; 2D problems also as flat 3D ones."""
        normal = np.pad(self.normal, ((0, 0), (0, dim - self.dim)))
        # the axis farthest from the normal, made orthogonal to it
        axis = np.eye(dim)[np.argmin(np.abs(normal), axis=1)]
        tangent = axis - np.sum(axis * normal, axis=1)[:, None] * normal
        tangent /= np.linalg.norm(tangent, axis=1)[:, None]
        if dim == 2:
            return np.stack([normal, tangent], axis=1)
        return np.stack([normal, tangent, np.cross(normal, tangent)], axis=1)

    def for_siconos(self, dim):
        """FrictionContactProblem in `dim` dimensions, its q, and the frames."""
        frames = self.frames(dim)
        size = self.contacts * dim
        M = np.einsum("kl,kax,lbx->kalb", self.W, frames, frames).reshape(size, size)
        free = np.pad(self.free_velocity, ((0, 0), (0, dim - self.dim)))
        q = np.einsum("kax,kx->ka", frames, free)
        q[:, 0] += self.bias
        problem = siconos.FrictionContactProblem(dim, M, q.ravel(), self.friction)
        return problem, q.ravel(), frames

    def siconos_measure(self, impulse):
        """Error as Siconos defines it (fc3d_compute_error): De Saxce's natural map over |q|."""
        problem, q, frames = self.for_siconos(3)
        padded = np.pad(impulse, ((0, 0), (0, 3 - self.dim)))
        reaction = np.einsum("kax,kx->ka", frames, padded).ravel()
        options = siconos.SolverOptions(siconos.SICONOS_FRICTION_3D_NSGS)
        velocity = np.zeros_like(reaction)
        return siconos.fc3d_compute_error(
            problem, reaction, velocity, 1e-12, options, np.linalg.norm(q)
        )[1]


def solve_by_siconos(problem, solver, tolerance, max_iterations):
    """Impulses from zero, and the number of iterations; Newton's method exists in 3D only."""
    dim, kind, driver = {
        ("nsgs", 2): (2, siconos.SICONOS_FRICTION_2D_NSGS, siconos.fc2d_driver),
        ("nsgs", 3): (3, siconos.SICONOS_FRICTION_3D_NSGS, siconos.fc3d_driver),
        ("newton", 2): (3, siconos.SICONOS_FRICTION_3D_NSN_AC, siconos.fc3d_driver),
        ("newton", 3): (3, siconos.SICONOS_FRICTION_3D_NSN_AC, siconos.fc3d_driver),
    }[solver, problem.dim]
    siconos_problem, _, frames = problem.for_siconos(dim)
    options = siconos.SolverOptions(kind)
    options.iparam[siconos.SICONOS_IPARAM_MAX_ITER] = max_iterations
    options.dparam[siconos.SICONOS_DPARAM_TOL] = tolerance
    reaction = np.zeros(problem.contacts * dim)
    velocity = np.zeros_like(reaction)
    driver(siconos_problem, reaction, velocity, options)
    impulse = np.einsum("kax,ka->kx", frames, reaction.reshape(-1, dim))
    return impulse[:, : problem.dim], int(options.iparam[siconos.SICONOS_IPARAM_ITER_DONE])


def comparison(problem, ours, theirs):
    """Differences of two answers: velocities, energy, impulses, each relative."""
    scale = np.abs(problem.free_velocity + problem.bias[:, None] * problem.normal).max()
    velocity = np.abs(problem.velocity(ours) - problem.velocity(theirs)).max() / scale
    energies = [np.sum(r * (problem.W @ r)) for r in (ours, theirs)]
    energy = abs(energies[0] - energies[1]) / max(*energies, np.finfo(float).tiny)
    largest = np.linalg.norm(theirs, axis=1).max() or 1.0
    impulse = np.linalg.norm(ours - theirs, axis=1).max() / largest
    return velocity, energy, impulse


def parse_options():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    add = parser.add_argument
    add("files", nargs="+", type=Path, help="problems, .npz")
    add("--solver", choices=("nsgs", "newton"), default="nsgs", help="of Siconos")
    add("--tolerance", type=float, default=1e-12, help="of Siconos' solver [-]")
    add("--max-iterations", type=int, help="of Siconos' solver; default 10^6, for Newton 500")
    add("--store", action="store_true", help="add the answer to the file, as siconos_impulse")
    options = parser.parse_args()
    if options.max_iterations is None:
        options.max_iterations = {"nsgs": 1_000_000, "newton": 500}[options.solver]
    if not 0 < options.tolerance < 1:
        parser.error(f"--tolerance {options.tolerance} is outside the admissible range (0, 1)")
    if options.max_iterations < 1:
        parser.error(f"--max-iterations {options.max_iterations} is outside [1, inf)")
    return options


def main():
    options = parse_options()
    columns = (
        "contacts",
        "dim",
        "iterated",
        "residual",
        "theirs",
        "Siconos'",
        "theirs",
        "velocity",
        "energy",
        "impulse",
    )
    print(f"{'problem':24}", *(f"{c:>9}" for c in columns))
    for file in options.files:
        with np.load(file) as arrays:
            arrays = dict(arrays)
        problem = Problem(arrays)
        theirs, iterations = solve_by_siconos(
            problem, options.solver, options.tolerance, options.max_iterations
        )
        ours = arrays["impulse"]
        figures = [
            problem.residual(ours),
            problem.residual(theirs),
            problem.siconos_measure(ours),
            problem.siconos_measure(theirs),
            *comparison(problem, ours, theirs),
        ]
        print(
            f"{file.stem:24}",
            f"{problem.contacts:9} {problem.dim:9} {iterations:9}",
            *(f"{x:9.1e}" for x in figures),
        )
        if options.store:
            np.savez_compressed(file, **{**arrays, "siconos_impulse": theirs})


if __name__ == "__main__":
    main()
