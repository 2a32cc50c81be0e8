"""Converged finite elements for a disk between rigid frictionless walls, up to nu = 0.499.

Two plates, or four walls of a square box that all move in. Needs numpy and scipy only: ``python3
scripts/reference/disk_between_walls.py --walls 2 --poisson 0.49``. It shares nothing with the
kernel. A quarter of the disk (plane strain, neo-Hookean) is cut into
biquadratic quadrilaterals whose pressure is linear within each and free to jump between them: the
pair Q9/P1 meets the inf-sup condition, so it does not lock. With ``theta`` the projection of
ln J on these pressures (weights of the reference configuration) the energy is

    mu/2 (I1 - 3 - 2 ln J) + lambda/2 theta^2,

quasi-static equilibrium is found by Newton's method with the exact tangent, and contact with the
walls by an active set of nodes, without penalty. The edge of contact moves from node to node, so
that the force does not converge smoothly enough to be extrapolated: the value is that of the finest
mesh, its uncertainty the difference from the second finest. At nu = 0.45 the values agree with
those of another code within 0.1 % between plates, within 0.13 % in the box from w = 0.01 D on.
"""

import argparse
from pathlib import Path

import numpy as np
import scipy.sparse
import scipy.sparse.linalg

#: Elements along half of the quarter's arc, coarse to fine.
MESHES = (8, 16, 24)
#: Elements shrink towards the poles, where contact begins: the arc's position to this power.
GRADING = 1.5
#: Half the side of the square in the middle of the mesh, over the radius.
CORE = 0.55
#: Iterations in which nodes are released. The set may go round in a circle at the edge of contact;
#: then a node there goes on touching although it pulls, within the uncertainty of the mesh.
RELEASES = 30
#: Newton's steps are shortened so that no point is compressed below this share of its volume: from
#: there they would not find back.
LEAST_VOLUME = 0.4
#: Largest way of a wall between two equilibria, over D.
ADVANCE = 0.00125
#: Ways of each wall at which forces are written, over D: of plates half their approach.
PLATE_WAYS = 0.5 * np.concatenate([[0.005, 0.01, 0.015], np.arange(0.02, 0.2001, 0.01)])
BOX_STEP = 0.0025


class Mesh:
    """Quarter of a disk of radius 1/2, x >= 0 and y >= 0: a square core and two blocks to the arc.

    Elements shrink towards the pole (0, 1/2), and where four walls touch towards (1/2, 0), too.

    Attributes:
        nodes (ndarray): positions, shape (nodes, 2).
        elements (ndarray): nodes of each, row by row, shape (elements, 9).
        arc (ndarray): nodes on the arc, from the pole (0, 1/2) on.
    """

    def __init__(self, n, walls):
        self._number = {}
        self._elements = []
        fine = np.linspace(0, 1, 2 * n + 1)
        across = fine**GRADING  # along x, from the pole's axis
        up = across if walls == 4 else fine  # along y
        half = CORE / 2

        def core(s, t):
            # bulged, so that no element degenerates at the corner of the square
            bulge = 1 - 0.15 * s * s * t * t
            return bulge * half * np.array([s, t])

        def block(side, angle):
            def place(s, t):
                arc = 0.5 * np.array([np.cos(angle(s)), np.sin(angle(s))])
                return (1 - t) * side(s) + t * arc

            return place

        outward = 1 - (1 - fine) ** 1.2  # finer towards the arc
        self._add(core, across, up)
        self._add(block(lambda s: core(s, 1), lambda s: np.pi / 2 - s * np.pi / 4), across, outward)
        self._add(block(lambda s: core(1, s), lambda s: s * np.pi / 4), up, outward, flipped=True)
        self.nodes = np.array(list(self._number))
        self.elements = np.array(self._elements)
        on_arc = np.flatnonzero(np.abs(np.linalg.norm(self.nodes, axis=1) - 0.5) < 1e-9)
        self.arc = on_arc[np.argsort(self.nodes[on_arc, 0])]

    def _add(self, place, s, t, flipped=False):
        grid = np.array([[self._node(place(a, b)) for b in t] for a in s])
        for i in range(0, len(s) - 2, 2):
            for j in range(0, len(t) - 2, 2):
                cell = grid[i : i + 3, j : j + 3]
                self._elements.append((cell if flipped else cell.T).ravel())

    def _node(self, x):
        key = tuple(np.round(x, 12) + 0.0)
        return self._number.setdefault(key, len(self._number))


def line_shapes(s):
    """Quadratic shape functions on [-1, 1] and their derivatives."""
    return (
        np.array([0.5 * s * (s - 1), 1 - s * s, 0.5 * s * (s + 1)]),
        np.array([s - 0.5, -2 * s, s + 0.5]),
    )


class Disk:
    """Equilibrium of the quarter within walls; Young's modulus and diameter 1."""

    def __init__(self, mesh, poisson, walls):
        self.mu = 0.5 / (1 + poisson)
        self.lam = poisson / ((1 + poisson) * (1 - 2 * poisson))
        self.mesh = mesh
        self.x = mesh.nodes.copy()
        #: Unknowns that walls may stop: heights of the arc's nodes, between four walls x, too.
        self.stopped = np.concatenate([2 * mesh.arc + 1, 2 * mesh.arc][: walls // 2])
        self.active = np.zeros(len(self.stopped), bool)
        self._tables()
        at_axis = np.abs(mesh.nodes) < 1e-9
        self.held = np.flatnonzero(at_axis.ravel())
        dofs = 2 * mesh.elements[:, :, None] + np.arange(2)
        self.dofs = dofs.reshape(len(mesh.elements), 18)
        self.rows = np.repeat(self.dofs, 18, axis=1).ravel()
        self.columns = np.tile(self.dofs, (1, 18)).ravel()

    def _tables(self):
        """Gradients, weights and pressure functions at 4 x 4 Gauss points of each element."""
        abscissae, weights = np.polynomial.legendre.leggauss(4)
        X = self.mesh.nodes[self.mesh.elements]
        gradients, volumes, places = [], [], []
        for s, ws in zip(abscissae, weights):
            for t, wt in zip(abscissae, weights):
                (Ns, Ds), (Nt, Dt) = line_shapes(s), line_shapes(t)
                N = np.outer(Nt, Ns).ravel()
                local = np.stack([np.outer(Nt, Ds).ravel(), np.outer(Dt, Ns).ravel()], axis=1)
                jacobian = np.einsum("eai,aj->eij", X, local)
                volume = np.linalg.det(jacobian) * ws * wt
                assert (volume > 0).all()
                gradients.append(np.einsum("aj,eji->eai", local, np.linalg.inv(jacobian)))
                volumes.append(volume)
                places.append(np.einsum("a,eai->ei", N, X))
        self.G = np.stack(gradients, axis=1)
        self.w = np.stack(volumes, axis=1)
        places = np.stack(places, axis=1)
        centre = np.einsum("eq,eqi->ei", self.w, places) / self.w.sum(1)[:, None]
        size = np.sqrt(self.w.sum(1))[:, None, None]
        linear = (places - centre[:, None]) / size
        self.phi = np.concatenate([np.ones_like(linear[..., :1]), linear], axis=2)
        self.gram = np.linalg.inv(np.einsum("eq,eqm,eqn->emn", self.w, self.phi, self.phi))

    def strain(self, x):
        F = np.einsum("eai,eqaj->eqij", x[self.mesh.elements], self.G)
        return F, np.linalg.det(F)

    def assemble(self):
        """Internal forces and tangent stiffness at the present positions."""
        F, J = self.strain(self.x)
        inverse = np.linalg.inv(F)
        moments = np.einsum("eq,eqm,eq->em", self.w, self.phi, np.log(J))
        p = self.lam * np.einsum("eqm,emn,en->eq", self.phi, self.gram, moments)
        g = np.einsum("eqaj,eqji->eqai", self.G, inverse)
        f = self.mu * np.einsum("eq,eqij,eqaj->eai", self.w, F, self.G)
        f += np.einsum("eq,eq,eqai->eai", self.w, p - self.mu, g)
        K = np.einsum("eq,eqak,eqbi->eaibk", self.w * (self.mu - p), g, g, optimize=True)
        shear = self.mu * np.einsum("eq,eqaj,eqbj->eab", self.w, self.G, self.G, optimize=True)
        for i in range(2):
            K[:, :, i, :, i] += shear
        D = np.einsum("eq,eqm,eqai->emai", self.w, self.phi, g).reshape(len(K), 3, 18)
        K = K.reshape(len(K), 18, 18) + self.lam * np.einsum(
            "emi,emn,enj->eij", D, self.gram, D, optimize=True
        )
        size = self.x.size
        force = np.bincount(self.dofs.ravel(), f.ravel(), minlength=size)
        stiffness = scipy.sparse.coo_matrix((K.ravel(), (self.rows, self.columns)), (size, size))
        return force, stiffness.tocsr()

    def press(self, place):
        """Equilibrium with the walls at this distance; the active set is found on the way."""
        stopped = self.stopped
        self.active |= self.x.ravel()[stopped] > place
        for iteration in range(100):
            force, stiffness = self.assemble()
            asked = self._settled or iteration >= RELEASES  # whether nodes pull
            pulled = self.active & (force[stopped] > 1e-12) & self._settled & (iteration < RELEASES)
            self.active &= ~pulled
            fixed = np.concatenate([self.held, stopped[self.active]])
            step = np.zeros(self.x.size)
            step[stopped[self.active]] = place - self.x.ravel()[stopped[self.active]]
            free = np.setdiff1d(np.arange(self.x.size), fixed)
            residual = -force - stiffness @ step
            step[free] = scipy.sparse.linalg.spsolve(
                stiffness[free][:, free].tocsc(), residual[free], permc_spec="MMD_AT_PLUS_A"
            )
            share = 1.0
            while (self.strain(self.x + share * step.reshape(-1, 2))[1] <= LEAST_VOLUME).any():
                share *= 0.5
            self.x += share * step.reshape(-1, 2)
            entered = ~self.active & (self.x.ravel()[stopped] > place + 1e-12)
            self.active |= entered
            self._settled = share == 1 and np.abs(step).max() < 1e-6
            done = share == 1 and np.abs(step).max() < 1e-10
            if done and asked and not entered.any() and not pulled.any():
                return self._result()
        raise RuntimeError(f"no equilibrium with walls at {place}")

    _settled = False  # forces tell contact from release only near equilibrium

    def _result(self):
        force, _ = self.assemble()
        _, J = self.strain(self.x)
        touching = self.mesh.arc[self.active[: len(self.mesh.arc)]]  # the wall above
        width = self.x[touching, 0].max() if len(touching) else 0.0
        return -2 * force[2 * touching + 1].sum(), width, 4 * (self.w * J).sum()


def curve(n, poisson, walls, ways):
    """Force on a wall, contact half-width and area for each way, on the mesh of n: (ways, 3)."""
    disk = Disk(Mesh(n, walls), poisson, walls)
    rows, last = [], 0.0
    for way in ways:
        parts = 1 + int(np.ceil((way - last) / ADVANCE - 1e-9))
        for part in np.linspace(last, way, parts)[1:]:
            result = disk.press(0.5 - part)
        rows.append(result)
        last = way
        print(f"n = {n}, way/D = {way:.4f}: F/(E D) = {rows[-1][0]:.7f}", flush=True)
    return np.array(rows)


def columns(walls, ways, curves):
    """What is written, by name: arrays (ways,)."""
    force, width, area = curves[-1].T
    if walls == 2:
        first = {"delta_over_D": 2 * ways}
    else:
        cell = (1 - 2 * ways) ** 2
        phi, phi0 = area / cell, 0.25 * np.pi / cell
        first = {"wall_displacement_over_D": ways, "phi": phi, "phi0": phi0}
    return {
        **first,
        "force_over_ED": force,
        "rel_uncertainty": np.abs(curves[-2][:, 0] / force - 1),
        "contact_halfwidth_over_D": width,
        "deformed_area_over_D2": area,
        **{f"force_mesh_{n}": c[:, 0] for n, c in zip(MESHES, curves)},
    }


def write(file, poisson, walls, ways, curves):
    case = {
        2: "Diametral compression of a disk between two rigid frictionless plates",
        4: "Disk in a square box whose four rigid frictionless walls move in by w each",
    }[walls]
    way = "delta_over_D = total approach of the plates" if walls == 2 else "force: on one wall"
    far = f" --way {ways[-1]:g}" if walls == 4 else ""
    table = columns(walls, ways, curves)
    with open(file, "w") as out:
        out.write(
            f"# {case}; plane strain, nu = {poisson:g}, neo-Hookean\n"
            f"# units: lengths /D, force over E D per unit (reference) thickness; {way}\n"
            "# biquadratic displacement, discontinuous linear pressure, quarter of the disk; made "
            f"by scripts/reference/disk_between_walls.py --walls {walls} --poisson {poisson:g}"
            f"{far}\n"
        )
        out.write(",".join(table) + "\n")
        for row in zip(*table.values()):
            out.write(",".join(f"{v:.8g}" for v in row) + "\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    add = parser.add_argument
    add("--walls", type=int, choices=(2, 4), default=2, help="two plates, or four walls of a box")
    add("--poisson", type=float, default=0.49, help="Poisson's ratio [-]")
    add("--way", type=float, default=0.1, help="of each wall of the box, over D [-]")
    add("--out", type=Path, help="file to write")
    options = parser.parse_args()
    if not -1 < options.poisson < 0.5:
        parser.error(f"argument --poisson: {options.poisson} is outside (-1, 0.5)")
    if not BOX_STEP <= options.way < 0.5:
        parser.error(f"argument --way: {options.way} is outside [{BOX_STEP}, 0.5)")
    box_ways = BOX_STEP * np.arange(1, round(options.way / BOX_STEP) + 1)
    ways = PLATE_WAYS if options.walls == 2 else box_ways
    curves = [curve(n, options.poisson, options.walls, ways) for n in MESHES]
    name = "disk_plane_strain" if options.walls == 2 else "square_cell"
    file = options.out or f"{name}_nu{options.poisson:g}.csv"
    write(file, options.poisson, options.walls, ways, curves)


if __name__ == "__main__":
    main()
