"""What never changes about a grain: a disk of radius 1 and density 1 about the origin.

Lengths are in radii. A grain of radius R and density rho has its nodes at R XI, gradients G/R,
point volumes R^2 Vp and nodal masses rho R^2 mI.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from .grid import Grid, outer, spline
from .quadrature import boundary_points, material_points

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
    N = np.array([outer(factors) for factors in spline(1, X[:, :, None] / spacing - line)])
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
