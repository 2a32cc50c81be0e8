"""Solvers of the contact problem against each other: work up to a residual.

Run it with YADE: ``scripts/yade -n -x scripts/benchmark/contact_solvers.py --out DIR``. Problems of
single steps of ``scripts/compaction.py``, with their warm starts, are solved from there on by

- nonlinear Gauss-Seidel, contact after contact (``forwards``),
- projected gradients, accelerated after Nesterov with restart (``accelerated projection``),
- the alternating direction method of multipliers (``ADMM``): W + rho D, D its diagonal, is
  factorised once, an iteration takes one solution with it and one projection on Coulomb's cones;
  De Saxce's shift of the normal velocity makes friction follow Coulomb's law (Acary, Bremond and
  Huber, in Advanced Topics in Nonsmooth Dynamics, 2018). For each problem and residual that rho
  counts that needs the fewest iterations.

The last line is what the step itself took (doc/decisions/0026-pairs-on-their-own.md). The residual
is that of the plugin (doc/theory.md). The unit of work is a sweep, one product of W with impulses;
a solution of ADMM counts by the entries of the factors over those of W, the factorisation not at
all. Prints a table of medians and largest values over the problems, which also goes to
``DIR/contact_solvers.md``; what it says: ``doc/decisions/0004-sweep-order.md``.
"""

import statistics
import sys
from pathlib import Path

import numpy as np
from scipy import sparse
from scipy.sparse import linalg

import softgrain as sg
from softgrain import command_line
from softgrain.runs import write_table

sys.path.append(str(Path(sys.argv[0]).resolve().parents[1]))  # scripts/
import compaction  # noqa: E402

PHI = (0.76, 0.80, 0.84, 0.88, 0.915)  # at which a step's problem is taken out
RESIDUALS = (1e-2, 1e-3, 1e-4)
MOST_WORK = 5000  # sweeps, after which a solver is given up
PENALTIES = 10.0 ** np.arange(-4, 1.1, 0.5)  # rho of ADMM


class Problem:
    """Arrays of ``SoftGrainIntegrator.contactProblem``; impulses are of shape (contacts, 2)."""

    def __init__(self, arrays):
        self.normal, self.bias = arrays["normal"], arrays["bias"]
        self.friction, self.start = arrays["friction"], arrays["start"]
        self.wanted = arrays["free_velocity"] + self.bias[:, None] * self.normal
        parts = (arrays[f"delassus_{name}"] for name in ("value", "column", "offset"))
        self.W = sparse.csr_matrix(tuple(parts))
        self.mobility = self.W.diagonal()[:, None]

    def velocity(self, impulse):
        """u + b n."""
        return self.wanted + self.W @ impulse

    def split(self, vectors):
        """Normal components, tangential vectors."""
        normal = np.sum(vectors * self.normal, axis=1)
        return normal, vectors - normal[:, None] * self.normal

    def solved(self, impulse, velocity):
        """Impulses that solve each contact alone: normal part first, then the tangential is cut."""
        normal, tangential = self.split(impulse - velocity / self.mobility)
        normal = np.maximum(normal, 0)
        size = np.maximum(np.linalg.norm(tangential, axis=1), np.finfo(float).tiny)
        kept = np.minimum(1, self.friction * normal / size)
        return normal[:, None] * self.normal + kept[:, None] * tangential

    def nearest_in_cones(self, vectors):
        """Nearest points of Coulomb's cones."""
        normal, tangential = self.split(vectors)
        size = np.linalg.norm(tangential, axis=1)
        mu = self.friction
        on_surface = np.maximum((normal + mu * size) / (1 + mu**2), 0)
        inside = size <= mu * normal
        direction = tangential / np.maximum(size, np.finfo(float).tiny)[:, None]
        surface = on_surface[:, None] * (self.normal + mu[:, None] * direction)
        return np.where(inside[:, None], vectors, surface)

    def energy(self, impulse):
        return np.sum(self.mobility * impulse**2)

    def residual(self, impulse):
        solved = self.solved(impulse, self.velocity(impulse))
        violation = self.energy(solved - impulse)
        scale = max(self.energy(impulse), self.energy(solved))
        return np.sqrt(violation / scale) if violation > 0 else 0.0


def sweeps(problem):
    """Yields work and impulses after each sweep of nonlinear Gauss-Seidel."""
    impulse = problem.start.copy()
    W, rows = problem.W, np.arange(len(impulse))
    for work in range(1, MOST_WORK):
        for k in rows:
            entries = slice(W.indptr[k], W.indptr[k + 1])
            velocity = problem.wanted[k] + W.data[entries] @ impulse[W.indices[entries]]
            trial = impulse[k] - velocity / problem.mobility[k]
            normal = max(trial @ problem.normal[k], 0)
            tangential = trial - (trial @ problem.normal[k]) * problem.normal[k]
            size, bound = np.linalg.norm(tangential), problem.friction[k] * normal
            kept = 1 if size <= bound else bound / size
            impulse[k] = normal * problem.normal[k] + kept * tangential
        yield work, impulse


def accelerated_projection(problem):
    """Yields work and impulses after each projected gradient step, in the metric of D."""
    root = sparse.diags(problem.mobility[:, 0] ** -0.5)
    largest = linalg.eigsh(root @ problem.W @ root, 1, return_eigenvectors=False)[0]
    impulse = ahead = problem.start.copy()
    in_a_row = 0
    for work in range(1, MOST_WORK):
        last = impulse
        impulse = problem.solved(ahead, problem.velocity(ahead) / largest)
        turned = np.sum(problem.mobility * (ahead - impulse) * (impulse - last)) > 0
        in_a_row = 0 if turned else in_a_row + 1
        ahead = impulse + in_a_row / (in_a_row + 3) * (impulse - last)
        yield work, impulse


def admm(problem, penalty):
    """Yields work and impulses within the cones after each iteration."""
    metric = penalty * problem.mobility
    factors = linalg.splu(sparse.csc_matrix(problem.W + sparse.diags(metric[:, 0])))
    price = (factors.L.nnz + factors.U.nnz) / problem.W.nnz
    impulse = problem.start.copy()
    dual = -problem.velocity(impulse) / metric
    for iteration in range(1, int(MOST_WORK / price)):
        _, sliding = problem.split(metric * dual)
        shift = problem.friction * np.linalg.norm(sliding, axis=1)
        wanted = problem.wanted + shift[:, None] * problem.normal
        free = factors.solve(metric * (impulse - dual) - wanted)
        impulse = problem.nearest_in_cones(free + dual)
        dual = dual + free - impulse
        yield iteration * price, impulse


def work_to_residuals(problem, steps):
    """Work at which each of RESIDUALS is reached first; inf: not."""
    reached = []
    for work, impulse in steps:
        residual = problem.residual(impulse)
        while len(reached) < len(RESIDUALS) and residual <= RESIDUALS[len(reached)]:
            reached.append(work)
        if len(reached) == len(RESIDUALS):
            break
    return reached + [np.inf] * (len(RESIDUALS) - len(reached))


def work_of_admm(problem):
    """With the penalty that is best for each residual."""
    return np.min([work_to_residuals(problem, admm(problem, p)) for p in PENALTIES], axis=0)


def problems(options):
    """Of the step in which the compaction passes each of PHI, and its sweeps."""
    case = compaction.parse_options(
        [f"--grains={options.grains}", f"--zeta={options.zeta}", f"--out={options.out}"]
    )
    box = compaction.prepare_rigid(case)
    compaction.make_soft(case)
    box.close(case.speed)
    sg.integrator().tolerance = options.tolerance
    for phi in PHI:
        while sg.packing_fraction(box.area) < phi:
            compaction.O.step()
        yield Problem(sg.integrator().contactProblem()), sg.integrator().sweeps


def parse_options():
    parser = command_line.case_parser(__doc__, out="contact_solvers")
    add = parser.add_argument
    some = command_line.whole_from(compaction.FEWEST_GRAINS)
    add("--grains", type=some, default=25, help="number of grains [-]")
    add("--zeta", type=command_line.resolution, default=0.1, help="relative resolution 2 dr/D [-]")
    add("--tolerance", type=command_line.positive, default=1e-3, help="of the run [-]")
    return parser.parse_args()


def cell(works):
    """Median and largest value, as text."""
    numbers = (statistics.median(works), max(works))
    return " / ".join(f"{n:.0f}" if np.isfinite(n) else f"> {MOST_WORK}" for n in numbers)


def main():
    options = parse_options()
    solvers = {
        "forwards": lambda p: work_to_residuals(p, sweeps(p)),
        "accelerated projection": lambda p: work_to_residuals(p, accelerated_projection(p)),
        "ADMM, the best rho": work_of_admm,
    }
    works = {name: [] for name in solvers}
    of_steps = []
    for problem, of_step in problems(options):
        of_steps.append(of_step)
        print(f"{len(problem.bias)} contacts, {problem.W.nnz} entries", flush=True)
        for name, solve in solvers.items():
            works[name].append(solve(problem))
    rows = [[name, *(cell(column) for column in zip(*work))] for name, work in works.items()]
    rows.append(
        ["the step itself", *(cell(of_steps) if r == options.tolerance else "" for r in RESIDUALS)]
    )
    head = ["solver", *(f"{residual:g}" for residual in RESIDUALS)]
    write_table(options.out / "contact_solvers.md", head, rows)


if __name__ == "__main__":
    main()
