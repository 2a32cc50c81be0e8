"""The oracle: the method in plain numpy, slow and clear, to check the fast kernel against.

It shares no line with the kernel and takes another route where there is one: B-splines by
recursion, tied nodes by one dense matrix, the Delassus operator by ``H M^-1 H^T``. Grains are
disks. The parts are laid out as those of the kernel:

* :mod:`~softgrain.reference.template`: what never changes, at unit size, with
  :mod:`~softgrain.reference.quadrature`, its material points, and
  :mod:`~softgrain.reference.grid`, its background nodes;
* :mod:`~softgrain.reference.material`: from deformation gradient to stress;
* :mod:`~softgrain.reference.grain`: state, internal force, motion; total and updated Lagrangian;
* :mod:`~softgrain.reference.search`: contacts and their gaps;
* :mod:`~softgrain.reference.interface`: cohesion, friction of contacts that slide;
* :mod:`~softgrain.reference.cell`: a periodic cell;
* :mod:`~softgrain.reference.solver`: impulses by nonlinear Gauss-Seidel;
* :mod:`~softgrain.reference.system`: the step.
"""

from .cell import Cell
from .grain import Grain, UpdatedGrain
from .interface import Interface
from .material import Material
from .search import Contact
from .solver import SolverReport, SolverSettings, residual
from .system import System, Wall
from .template import Recipe, Template

__all__ = [
    "Cell",
    "Contact",
    "Grain",
    "Interface",
    "Material",
    "Recipe",
    "SolverReport",
    "SolverSettings",
    "System",
    "Template",
    "UpdatedGrain",
    "Wall",
    "residual",
]
