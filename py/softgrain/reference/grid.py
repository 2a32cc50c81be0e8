"""The background grid of a unit disk: B-splines, and nodes tied to others."""

from functools import reduce
from itertools import product

import numpy as np

DIM = 2

#: Nodes that a tied node is extrapolated from; more where several are as far away as the last one.
TIED_TO = 6


def spline(order, x):
    """Uniform B-spline centred on 0, knots one apart, by the recursion of Cox and de Boor.

    N^0 = 1 on [-1/2, 1/2);
    N^k(x) = ((x + (k+1)/2) N^(k-1)(x + 1/2) + ((k+1)/2 - x) N^(k-1)(x - 1/2)) / k.

    Args:
        order (int): k.
        x (ndarray): coordinates in knot distances.

    Returns:
        ndarray: values, shape of x.
    """
    if order == 0:
        return ((x >= -0.5) & (x < 0.5)).astype(float)
    half = 0.5 * (order + 1)
    left, right = spline(order - 1, x + 0.5), spline(order - 1, x - 0.5)
    return ((x + half) * left + (half - x) * right) / order


def spline_derivative(order, x):
    """Derivative of :func:`spline`: N^(k-1)(x + 1/2) - N^(k-1)(x - 1/2)."""
    return spline(order - 1, x + 0.5) - spline(order - 1, x - 0.5)


class Grid:
    """Tensor-product B-splines on a square grid of step h with a node at the centre.

    Of all grid nodes J, those with enough mass carry unknowns (I). The others are tied to them,
    x_J = sum_I T_JI x_I, so that the shape functions on the unknowns are N_I = sum_J T_JI N_J.
    """

    def __init__(self, recipe, point_position, point_volume, also=()):
        """Find the nodes that carry unknowns.

        Args:
            recipe (Recipe): order, step and threshold of tied nodes.
            point_position (ndarray): shape (points, 2).
            point_volume (ndarray): weights of the points, shape (points,).
            also (ndarray): further places where shapes will be asked for, shape (places, 2).
        """
        self._order = recipe.order
        self._step = recipe.node_spacing * recipe.zeta
        farthest = max(np.abs(point_position).max(), np.abs(np.append(also, 1)).max())
        reach = int(np.ceil(farthest / self._step)) + recipe.order
        self._line = np.arange(-reach, reach + 1)
        everywhere = np.array(list(product(self._line, repeat=DIM)))
        shape, _ = self._raw_shapes(point_position)
        mass = point_volume @ shape
        heavy = mass >= recipe.light_node_share * mass.max()
        self.node_position = everywhere[heavy] * self._step
        self._tie = np.zeros((len(everywhere), heavy.sum()))
        self._tie[heavy] = np.eye(heavy.sum())
        for J in np.flatnonzero(~heavy):
            self._tie[J] = affine_extrapolation(everywhere[J], everywhere[heavy])

    def shapes(self, X):
        """N_I(X), shape (len(X), nodes), and G_I(X) = dN_I/dX, shape (len(X), nodes, 2)."""
        shape, gradient = self._raw_shapes(X)
        return shape @ self._tie, np.einsum("pJa,JI->pIa", gradient, self._tie)

    def _raw_shapes(self, X):
        """The same for all nodes J of the grid, in lexicographic order, none tied."""
        x = X[:, :, None] / self._step - self._line  # (points, axis, node on the axis)
        N = spline(self._order, x)
        dN = spline_derivative(self._order, x) / self._step
        shape = np.array([outer(factors) for factors in N])
        gradient = np.empty(shape.shape + (DIM,))
        for p, a in product(range(len(X)), range(DIM)):
            gradient[p, :, a] = outer([dN[p, b] if b == a else N[p, b] for b in range(DIM)])
        return shape, gradient


def outer(factors):
    """Products of one entry of each factor, the last one running fastest."""
    return reduce(np.multiply.outer, factors).ravel()


def affine_extrapolation(X, nodes):
    """Weights w on the nodes nearest to X that reproduce affine functions at X.

    sum_I w_I = 1 and sum_I w_I (X_I - X) = 0 with the least sum_I w_I^2 / t_I, where the trust
    t_I = |X_I - X|^-4 lets nearer nodes carry more: w = t A^T (A t A^T)^-1 (1, 0, 0)^T with the
    columns (1, X_I - X) of A. All nodes as far away as the last one count, so that the weights
    have the symmetry of the grid.

    Args:
        X (ndarray): where, in grid steps, integers of shape (2,).
        nodes (ndarray): all nodes that may carry, in grid steps, integers of shape (nodes, 2).

    Returns:
        ndarray: w, shape (nodes,), zero on all but the nearest.
    """
    arm = nodes - X
    squared = np.sum(arm**2, axis=1)
    nearest = squared <= np.sort(squared)[:TIED_TO][-1]
    A = np.vstack([np.ones(nearest.sum()), arm[nearest].T])
    trust = np.diag(1 / squared[nearest] ** 2)
    weights = np.zeros(len(nodes))
    weights[nearest] = trust @ A.T @ np.linalg.solve(A @ trust @ A.T, [1.0, 0.0, 0.0])
    return weights
