#!/usr/bin/python3
"""Time Siconos' Gauss-Seidel solver (NSGS) on a problem of ``make_dense.py`` against softgrain's.

    /usr/bin/python3 scripts/siconos/speed.py PROBLEM.npz

Runs outside YADE, with the Siconos of Debian 12 (Debian 13 has none):

    apt-get install python3-siconos python3-numpy python3-scipy

Both on one thread, from the same impulses, those of the step before. Siconos gets W as a sparse
matrix of 2 x 2 blocks (``fc2d_nsgs_sbm``). Both are timed up to the residual that softgrain
reached; the residual is softgrain's (doc/theory.md) for both.
"""

import argparse
import statistics
import sys
import time
from pathlib import Path

import numpy as np

sys.path.append(str(Path(__file__).resolve().parent))

from compare import oracle, siconos  # noqa: E402

try:
    import scipy.sparse as sparse
except ImportError as error:
    sys.exit(f"speed.py: {error}; on Debian 12: apt-get install python3-scipy")

REPETITIONS = 5
MOST_ITERATIONS = 200


class BlockProblem:
    """A problem of softgrain in 2D, for Siconos in the local frames of the contacts."""

    def __init__(self, arrays):
        self.arrays = arrays
        self.normal = arrays["normal"]
        self.contacts = len(self.normal)
        self.W = sparse.csr_matrix(
            (arrays["delassus_value"], arrays["delassus_column"], arrays["delassus_offset"]),
            shape=(self.contacts, self.contacts),
        )
        self.frames = np.stack(
            [self.normal, np.stack([-self.normal[:, 1], self.normal[:, 0]], axis=1)], axis=1
        )
        self.q = np.einsum("kax,kx->ka", self.frames, arrays["free_velocity"])
        self.q[:, 0] += arrays["bias"]
        self.q = self.q.ravel()
        self.start = np.einsum("kax,kx->ka", self.frames, arrays["start"]).ravel()
        self.friction = np.ascontiguousarray(arrays["friction"])
        _, self.blocks = siconos.SBM_from_csparse(2, self._local_delassus())
        size = 2 * self.contacts
        self.matrix = siconos.NM_create(siconos.NM_SPARSE_BLOCK, size, size)
        self.matrix.matrix1 = self.blocks
        self.problem = siconos.frictionContactProblem_new_with_data(
            2, self.contacts, self.matrix, self.q, self.friction
        )

    def _local_delassus(self):
        """W_kl (a_k . b_l) of the axes of the frames, in blocks."""
        rows = np.repeat(np.arange(self.contacts), np.diff(self.W.indptr))
        blocks = np.einsum(
            "e,eax,ebx->eab", self.W.data, self.frames[rows], self.frames[self.W.indices]
        )
        size = 2 * self.contacts
        matrix = sparse.bsr_matrix((blocks, self.W.indices, self.W.indptr), shape=(size, size))
        return sparse.csc_matrix(matrix)

    def run(self, iterations):
        """Impulses after so many iterations from the start, and the seconds they took."""
        options = siconos.SolverOptions(siconos.SICONOS_FRICTION_2D_NSGS)
        options.iparam[siconos.SICONOS_IPARAM_MAX_ITER] = iterations
        options.dparam[siconos.SICONOS_DPARAM_TOL] = 0
        reaction, velocity = self.start.copy(), np.zeros_like(self.start)
        began = time.perf_counter()
        siconos.fc2d_driver(self.problem, reaction, velocity, options)
        seconds = time.perf_counter() - began
        return np.einsum("kax,ka->kx", self.frames, reaction.reshape(-1, 2)), seconds

    def residual(self, impulse):
        names = ("normal", "bias", "friction")
        normal, bias, friction = (self.arrays[name] for name in names)
        return oracle.residual(
            self.W, self.arrays["free_velocity"], normal, bias, friction, impulse
        )


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("file", type=Path, help="problem, .npz")
    with np.load(parser.parse_args().file) as arrays:
        arrays = dict(arrays)
    problem = BlockProblem(arrays)
    wanted = float(arrays["residual"])
    for iterations in range(1, MOST_ITERATIONS + 1):
        residual = problem.residual(problem.run(iterations)[0])
        if residual <= wanted:
            break
    else:
        sys.exit(f"NSGS has a residual of {residual:.1e}, not {wanted:.1e}, after {iterations}")
    seconds = statistics.median(problem.run(iterations)[1] for _ in range(REPETITIONS))
    sweeps, per_sweep = float(arrays["sweeps"]), float(arrays["seconds_per_sweep"])
    print(
        f"{problem.contacts} contacts, {len(problem.W.data) / problem.contacts:.1f} entries of W a "
        f"contact; residual before: {problem.residual(arrays['start']):.1e}"
    )
    for name, count, total, reached in (
        ("softgrain", sweeps, sweeps * per_sweep, wanted),
        ("Siconos NSGS", iterations, seconds, residual),
    ):
        print(
            f"{name:13} {count:6.1f} sweeps to {reached:.1e}: {1e3 * total:8.2f} ms, "
            f"{1e9 * total / count / problem.contacts:7.1f} ns a contact and sweep, "
            f"{problem.contacts * count / total / 1e6:6.1f} million contacts a second"
        )
    print(
        f"Siconos over softgrain: {seconds / (sweeps * per_sweep):.1f} in time to that residual, "
        f"{seconds / iterations / per_sweep:.1f} a sweep"
    )


if __name__ == "__main__":
    main()
