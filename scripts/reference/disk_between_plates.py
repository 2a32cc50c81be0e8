"""Converged finite elements for a disk between two rigid frictionless plates, up to nu = 0.499.

Needs numpy and scipy only: ``python3 scripts/reference/disk_between_plates.py --poisson 0.49``. It
shares nothing with the kernel. A quarter of the disk (plane strain, neo-Hookean) is cut into
biquadratic quadrilaterals whose pressure is linear within each and free to jump between them: the
pair Q9/P1 meets the inf-sup condition, so it does not lock. With ``theta`` the projection of
ln J on these pressures (weights of the reference configuration) the energy is

    mu/2 (I1 - 3 - 2 ln J) + lambda/2 theta^2,

quasi-static equilibrium is found by Newton's method with the exact tangent, and contact with the
plate by an active set of nodes, without penalty. The edge of contact moves from node to node, so
that the force does not converge smoothly enough to be extrapolated: the value is that of the finest
mesh, its uncertainty the difference from the second finest. At nu = 0.45 the values agree with
those of another code within 0.1 %.
"""

import argparse
from pathlib import Path

import numpy as np
import scipy.sparse
import scipy.sparse.linalg

#: Elements along half of the quarter's arc, coarse to fine.
MESHES = (8, 16, 24)
#: Elements shrink towards the pole, where contact begins: the arc's position to this power.
GRADING = 1.5
#: Half the side of the square in the middle of the mesh, over the radius.
CORE = 0.55
#: Iterations in which nodes are released. The set may go round in a circle at the edge of contact;
#: then a node there goes on touching although it pulls, within the uncertainty of the mesh.
RELEASES = 30
#: Newton's steps are shortened so that no point is compressed below this share of its volume: from
#: there they would not find back.
LEAST_VOLUME = 0.4
#: Largest advance of the plates between two equilibria, over D.
ADVANCE = 0.0025
DELTAS = np.concatenate([[0.005, 0.01, 0.015], np.arange(0.02, 0.2001, 0.01)])


class Mesh:
    """Quarter of a disk of radius 1/2, x >= 0 and y >= 0: a square core and two blocks to the arc.

    Attributes:
        nodes (ndarray): positions, shape (nodes, 2).
        elements (ndarray): nodes of each, row by row, shape (elements, 9).
        arc (ndarray): nodes on the arc, from the pole (0, 1/2) on.
    """

    def __init__(self, n):
        self._number = {}
        self._elements = []
        fine = np.linspace(0, 1, 2 * n + 1)
        across = fine**GRADING  # along x, from the pole's axis
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
        self._add(core, across, fine)
        self._add(block(lambda s: core(s, 1), lambda s: np.pi / 2 - s * np.pi / 4), across, outward)
        self._add(block(lambda s: core(1, s), lambda s: s * np.pi / 4), fine, outward, flipped=True)
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
    """Equilibrium of the quarter under a plate at height Y; Young's modulus and diameter 1."""

    def __init__(self, mesh, poisson):
        self.mu = 0.5 / (1 + poisson)
        self.lam = poisson / ((1 + poisson) * (1 - 2 * poisson))
        self.mesh = mesh
        self.x = mesh.nodes.copy()
        self.active = np.zeros(len(mesh.arc), bool)
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

    def press(self, height):
        """Equilibrium under the plate at `height`; the active set is found on the way."""
        arc_y = 2 * self.mesh.arc + 1
        self.active |= self.x.ravel()[arc_y] > height
        for iteration in range(100):
            force, stiffness = self.assemble()
            pulled = self.active & (force[arc_y] > 1e-12) & self._settled & (iteration < RELEASES)
            self.active &= ~pulled
            fixed = np.concatenate([self.held, arc_y[self.active]])
            step = np.zeros(self.x.size)
            step[arc_y[self.active]] = height - self.x.ravel()[arc_y[self.active]]
            free = np.setdiff1d(np.arange(self.x.size), fixed)
            residual = -force - stiffness @ step
            step[free] = scipy.sparse.linalg.spsolve(
                stiffness[free][:, free].tocsc(), residual[free], permc_spec="MMD_AT_PLUS_A"
            )
            share = 1.0
            while (self.strain(self.x + share * step.reshape(-1, 2))[1] <= LEAST_VOLUME).any():
                share *= 0.5
            self.x += share * step.reshape(-1, 2)
            entered = ~self.active & (self.x.ravel()[arc_y] > height + 1e-12)
            self.active |= entered
            self._settled = share == 1 and np.abs(step).max() < 1e-6
            done = share == 1 and np.abs(step).max() < 1e-10
            if done and not entered.any() and not pulled.any():
                return self._result()
        raise RuntimeError(f"no equilibrium at height {height}")

    _settled = False  # forces tell contact from release only near equilibrium

    def _result(self):
        force, _ = self.assemble()
        _, J = self.strain(self.x)
        touching = self.mesh.arc[self.active]
        width = self.x[touching, 0].max() if len(touching) else 0.0
        return -2 * force[2 * touching + 1].sum(), width, 4 * (self.w * J).sum()


def curve(n, poisson, deltas):
    """Force, contact half-width and area at each approach on the mesh of n, shape (deltas, 3)."""
    disk = Disk(Mesh(n), poisson)
    rows, last = [], 0.0
    for delta in deltas:
        for part in np.linspace(last, delta, 1 + int(np.ceil((delta - last) / ADVANCE - 1e-9)))[1:]:
            result = disk.press(0.5 * (1 - part))
        rows.append(result)
        last = delta
        print(f"n = {n}, delta/D = {delta:.3f}: F/(E D) = {rows[-1][0]:.7f}", flush=True)
    return np.array(rows)


def write(file, poisson, deltas, curves):
    finest = curves[-1]
    uncertainty = np.abs(curves[-2][:, 0] / finest[:, 0] - 1)
    meshes = ",".join(f"force_mesh_{n}" for n in MESHES)
    with open(file, "w") as out:
        out.write(
            "# Diametral compression of a disk between two rigid frictionless plates; plane "
            f"strain, nu = {poisson:g}, neo-Hookean\n"
            "# units: lengths /D, force over E D per unit (reference) thickness; delta_over_D = "
            "total approach of the plates\n"
            "# biquadratic displacement, discontinuous linear pressure, quarter of the disk; made "
            f"by scripts/reference/disk_between_plates.py --poisson {poisson:g}\n"
            "delta_over_D,force_over_ED,rel_uncertainty,contact_halfwidth_over_D,"
            f"deformed_area_over_D2,{meshes}\n"
        )
        for k, delta in enumerate(deltas):
            values = [delta, finest[k, 0], uncertainty[k], finest[k, 1], finest[k, 2]]
            out.write(",".join(f"{v:.8g}" for v in values + [c[k, 0] for c in curves]) + "\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--poisson", type=float, default=0.49, help="Poisson's ratio [-]")
    parser.add_argument("--out", type=Path, help="file to write")
    options = parser.parse_args()
    if not -1 < options.poisson < 0.5:
        parser.error(f"argument --poisson: {options.poisson} is outside (-1, 0.5)")
    curves = [curve(n, options.poisson, DELTAS) for n in MESHES]
    write(
        options.out or f"disk_plane_strain_nu{options.poisson:g}.csv",
        options.poisson,
        DELTAS,
        curves,
    )


if __name__ == "__main__":
    main()
