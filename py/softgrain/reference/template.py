"""What never changes about a grain: a disk of radius 1 and density 1 about the origin.

Lengths are in radii. A grain of radius R and density rho has its nodes at R XI, gradients G/R,
point volumes R^2 Vp and nodal masses rho R^2 mI.
"""

import math
from dataclasses import dataclass
from functools import lru_cache, reduce
from itertools import product

import numpy as np

DIM = 2
AREA = np.pi

#: Corners of a square about the origin, the first coordinate running fastest.
CORNERS = np.array([(-1, -1), (1, -1), (-1, 1), (1, 1)])
#: Cells with a centre less than this inside the outline (in dr) are divided at the rim.
RIM_DEPTH = 1.0
#: Cuts are resolved down to 1/2^6 of a cell; there the outline is taken as straight.
CUT_DEPTH = 6
#: Cells that hold less than this share of their area hold no material point.
NEGLIGIBLE_SHARE = 1e-9
#: Nodes that a tied node is extrapolated from; more where several are as far away as the last one.
TIED_TO = 6
#: Nodal masses are balanced where each is at least this share of sum_p Vp0 N_I(Xp).
LEAST_MASS_SHARE = 0.7
#: Most that exact second moments may take from a nodal mass.
LARGEST_INERTIA_SHARE = 0.4
#: Functions of less than this share of the greatest weight are left out of the projection of ln J.
LIGHT_FUNCTION_SHARE = 0.02
#: Patterns of nodes are held so stiffly, over the shear modulus, ...
HOURGLASS_STIFFNESS = 2.0
#: ... where a node has less than this share of the heaviest mass.
HOURGLASS_NODE_SHARE = 0.3


@dataclass(frozen=True)
class Recipe:
    """How a grain is discretised."""

    zeta: float = 0.11  #: 2 dr/D = dr/R, spacing of material points
    order: int = 3  #: of the B-splines: 1, 2 or 3
    node_spacing: float = 1.25  #: h/dr
    surface_spacing: float = 1.0  #: spacing of surface nodes over dr
    quadrature: str = "cutCell"  #: or 'lattice'
    contact: str = "surface"  #: or 'points'
    light_node_share: float = 2e-3  #: nodes lighter than this share of the heaviest are tied
    volumetric: str = "pointwise"  #: or 'projected'
    lumping: str = "balanced"  #: of the masses; or 'rowSums'

    @property
    def contact_spacing(self):
        """Distance of surface nodes over R: denser in coarse grains, as many to a background node
        of the row outside of the outline as to one on a straight side."""
        h = self.node_spacing * self.zeta
        return self.surface_spacing * self.zeta * min(1.0, self.node_spacing / (1 + h))


class Template:
    """Tables of a recipe, all dense.

    Attributes:
        recipe (Recipe): what it was made from.
        point_position (ndarray): Xp, shape (points, 2).
        point_volume (ndarray): Vp0, shape (points,); the sum is pi.
        node_position (ndarray): XI, shape (nodes, 2), in lexicographic order.
        node_mass (ndarray): mI, shape (nodes,); their sum is pi.
        point_shape (ndarray): N_I(Xp), shape (points, nodes).
        point_gradient (ndarray): G_I(Xp), shape (points, nodes, 2).
        volume_projection (ndarray | None): takes ln J at the points to its projection, shape
            (points, points); None where it is taken pointwise.
        hourglass (ndarray): sum over patterns of nodes of kappa m_I q q^T/h^2, shape (nodes,
            nodes): forces over the shear modulus are minus this times x.
        contact_position (ndarray): Xs, shape (contact nodes, 2); on a surface counter-clockwise.
        contact_shape (ndarray): N_I(Xs), shape (contact nodes, nodes).
        contact_radius (float): radius of the disk about a contact node; 0 on a surface.
    """

    def __init__(self, recipe):
        """Make the tables.

        Args:
            recipe (Recipe): how the grain is discretised.
        """
        self.recipe = recipe
        self.point_position, self.point_volume = material_points(recipe.quadrature, recipe.zeta)
        grid = Grid(recipe, self.point_position, self.point_volume)
        self.node_position = grid.node_position
        self.point_shape, self.point_gradient = grid.shapes(self.point_position)
        self.node_mass = self.point_volume @ self.point_shape
        if recipe.lumping == "balanced":
            self.node_mass = balanced_masses(self)
        self.volume_projection = None
        if recipe.volumetric == "projected":
            spacing = 2 * recipe.node_spacing * recipe.zeta
            self.volume_projection = volume_projection(
                self.point_position, self.point_volume, spacing
            )
        self.hourglass = hourglass_stiffness(self)
        if recipe.contact == "surface":
            self.contact_position = surface_nodes(recipe.contact_spacing)
            self.contact_radius = 0.0
        else:
            self.contact_position = boundary_points(recipe.quadrature, recipe.zeta)
            self.contact_radius = 0.5 * recipe.zeta
        self.contact_shape, _ = grid.shapes(self.contact_position)


@lru_cache(maxsize=None)
def template(recipe):
    """Return the template of a recipe, made once."""
    return Template(recipe)


def balanced_masses(table):
    """Masses in proportion to the sums over J of abs(L_IJ), L = sum_p Vp0 G_I.G_J, with moments.

    A polynomial of second order in XI times these sums. Mass and centre are those of the sums of
    rows sum_p Vp0 N_I(Xp), second moments those of the points as squares of area Vp0, or as near to
    them as takes no more than LARGEST_INERTIA_SHARE from a node.

    Args:
        table (Template): with the sums of rows as ``node_mass``.

    Returns:
        ndarray: mI, shape (nodes,).
    """
    G, volume = table.point_gradient, table.point_volume
    bound = np.abs(np.einsum("p,pIa,pJa->IJ", volume, G, G, optimize=True)).sum(axis=1)
    at_nodes = _monomials(table.node_position)
    lumped = at_nodes.T @ table.node_mass
    continuum = _monomials(table.point_position).T @ volume
    continuum[[3, 5]] += np.sum(volume**2) / 12

    def with_moments(moments):
        gram = at_nodes.T @ (bound[:, None] * at_nodes)
        return bound * (at_nodes @ np.linalg.lstsq(gram, moments, rcond=None)[0])

    kept, exact = with_moments(lumped), with_moments(continuum)
    if np.any(kept < LEAST_MASS_SHARE * table.node_mass):
        return table.node_mass
    loss = (kept - exact) / kept
    share = min(1.0, LARGEST_INERTIA_SHARE / loss.max())
    return (1 - share) * kept + share * exact


def _monomials(X):
    """1, x, y, x^2, x y, y^2 at X, shape (len(X), 6)."""
    x, y = X.T
    return np.column_stack([np.ones(len(X)), x, y, x * x, x * y, y * y])


def volume_projection(X, volume, spacing):
    """Least-squares projection on the bilinear functions of a square grid about the centre.

    Functions that see too little of the disk are left out, the others scaled to sum to 1.

    Args:
        X (ndarray): material points, shape (points, 2).
        volume (ndarray): their weights, shape (points,).
        spacing (float): step of the grid.

    Returns:
        ndarray: shape (points, points).
    """
    reach = int(np.ceil(1 / spacing)) + 1
    line = np.arange(-reach, reach + 1)
    N = np.array([_outer(factors) for factors in spline(1, X[:, :, None] / spacing - line)])
    weight = volume @ N
    N = N[:, weight >= LIGHT_FUNCTION_SHARE * weight.max()]
    N = N / N.sum(axis=1)[:, None]
    gram = N.T @ (volume[:, None] * N)
    return N @ np.linalg.solve(gram, N.T * volume)


def hourglass_stiffness(table):
    """What holds patterns of nodes (see `Template.hourglass`): second differences along both axes
    over nine nodes of which one is light, in disks with projected volumes."""
    recipe, mass = table.recipe, table.node_mass
    stiffness = np.zeros((len(mass), len(mass)))
    if recipe.volumetric == "pointwise" or recipe.order < 2:
        return stiffness
    h = recipe.node_spacing * recipe.zeta
    apart = np.rint((table.node_position[:, None] - table.node_position) / h)
    second_difference = np.select([apart == 0, np.abs(apart) == 1], [-2.0, 1.0])
    for node, row in enumerate(second_difference.prod(axis=2) / 16):
        bearing = row != 0
        light = mass[bearing].min() < HOURGLASS_NODE_SHARE * mass.max()
        if bearing.sum() == 9 and light:
            stiffness += HOURGLASS_STIFFNESS * mass[node] / h**2 * np.outer(row, row)
    return stiffness


def surface_nodes(spacing):
    """Equally spaced nodes on the unit circle, counter-clockwise from (1, 0).

    Their number, at least 11, is the nearest one without a divisor 2 or 3: contacts at multiples of
    60 or 90 degrees then meet the nodes at different phases.
    """
    ideal = max(11.0, 2 * np.pi / spacing)
    count = min(
        (n for n in range(11, int(ideal) + 6) if n % 2 and n % 3), key=lambda n: abs(n - ideal)
    )
    angle = 2 * np.pi * np.arange(count) / count
    return np.column_stack([np.cos(angle), np.sin(angle)])


# --- material points ---------------------------------------------------------------------------


def material_points(rule, spacing):
    """Material points on a square lattice of side dr with a cell corner at the centre.

    Args:
        rule (str): 'cutCell': every cell is cut with the outline, its point lies at the centroid of
            what is inside, with that area as weight; cells at the rim, with a centre less than dr
            inside, are first divided into four parts with a point each; 'lattice': cell centres
            inside, equal weights.
        spacing (float): dr.

    Returns:
        tuple: Xp (points, 2); Vp0 (points,), scaled to the exact area pi.
    """
    held = []  # area inside, first moment of it
    for cell, whole in occupied_cells(rule, spacing).items():
        centre = (np.array(cell) + 0.5) * spacing
        if rule == "cutCell" and np.linalg.norm(centre) - 1 > -RIM_DEPTH * spacing:
            parts = (
                moments_inside(c, 0.5 * spacing, CUT_DEPTH - 1)
                for c in quarter_centres(centre, spacing)
            )
            held += [part for part in parts if part[0] > NEGLIGIBLE_SHARE * spacing**DIM]
        else:
            held.append(whole)
    area = np.array([area for area, _ in held])
    return np.array([moment / area for area, moment in held]), area * AREA / area.sum()


def boundary_points(rule, spacing):
    """Centroids of the cells with an empty neighbour, one a cell, shape (cells, 2)."""
    held = occupied_cells(rule, spacing)
    return np.array(
        [moment / area for cell, (area, moment) in held.items() if _has_empty_neighbour(cell, held)]
    )


def occupied_cells(rule, spacing):
    """Cells that hold something.

    Returns:
        dict: cell, in lexicographic order: area inside, first moment of it.
    """
    reach = int(np.ceil(1 / spacing))
    held = {}
    for cell in product(range(-reach, reach), repeat=DIM):
        centre = (np.array(cell) + 0.5) * spacing
        if rule == "cutCell":
            area, moment = moments_inside(centre, spacing, CUT_DEPTH)
        else:
            area, moment = (1.0, centre) if np.linalg.norm(centre) < 1 else (0.0, 0 * centre)
        if area > NEGLIGIBLE_SHARE * spacing**DIM:
            held[cell] = area, moment
    return held


def moments_inside(centre, side, depth):
    """Area and first moment of the part of a square inside the unit circle.

    A cut square is divided into four; at the last level the outline is a straight line at its
    distance from the centre, parallel to a side.

    Args:
        centre (ndarray): of the square, shape (2,).
        side (float): of the square.
        depth (int): levels of division left.

    Returns:
        tuple: area, and first moment of shape (2,).
    """
    distance = math.hypot(*centre) - 1
    half_diagonal = 0.5 * side * np.sqrt(DIM)
    if distance >= half_diagonal:
        return 0.0, np.zeros(DIM)
    if distance <= -half_diagonal or depth == 0:
        area = side**DIM * min(max(0.5 - distance / side, 0.0), 1.0)
        return area, area * centre
    area, moment = 0.0, np.zeros(DIM)
    for c in quarter_centres(centre, side):
        part = moments_inside(c, 0.5 * side, depth - 1)
        area, moment = area + part[0], moment + part[1]
    return area, moment


def quarter_centres(centre, side):
    """Centres of the four parts of a square, shape (4, 2)."""
    return centre + 0.25 * side * CORNERS


def _has_empty_neighbour(cell, held):
    neighbours = (cell + step * axis for axis in np.eye(DIM, dtype=int) for step in (-1, 1))
    return any(tuple(neighbour.tolist()) not in held for neighbour in neighbours)


# --- background grid ---------------------------------------------------------------------------


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
        shape = np.array([_outer(factors) for factors in N])
        gradient = np.empty(shape.shape + (DIM,))
        for p, a in product(range(len(X)), range(DIM)):
            gradient[p, :, a] = _outer([dN[p, b] if b == a else N[p, b] for b in range(DIM)])
        return shape, gradient


def _outer(factors):
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
