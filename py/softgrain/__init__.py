"""Soft, deformable grains for the YADE discrete-element platform.

Each grain is a continuum solved by the explicit total-Lagrangian material point method; contacts
are solved by contact dynamics, without any stiffness parameter. Import it inside a YADE script, a
``yade-batch`` job, or plain Python with YADE on the path::

    import softgrain as sg

The YADE classes (``SoftMat``, ``SoftGrain``, ``SoftGrainIntegrator``, ...) become part of ``yade``
and of this package; the functions are listed in ``__all__``.
"""

from pkgutil import extend_path

__path__ = extend_path(__path__, __name__)  # the shared object of a build tree lies elsewhere

from softgrain import _host  # noqa: E402

_classes = _host.load_plugin()
globals().update(_classes)

from softgrain import _softgrain, yade_utils  # noqa: E402
from softgrain.balance import Balance  # noqa: E402
from softgrain.bodies import soft_bodies  # noqa: E402
from softgrain.build import (  # noqa: E402
    soft_block,
    soft_disk,
    soft_ellipse,
    soft_polygon,
    soft_sphere,
    soft_superdisk,
)
from softgrain.cell import cell_stress, cell_volume  # noqa: E402
from softgrain.contact_problem import solve_contact_problem  # noqa: E402
from softgrain.forces import body_forces, contact_forces, pair_forces  # noqa: E402
from softgrain.hardening import Hardened, harden  # noqa: E402
from softgrain.images import ImageGrains, grains_from_image  # noqa: E402
from softgrain.observe import (  # noqa: E402
    coordination_number,
    grain_area,
    integrator,
    packing_fraction,
    von_mises,
    wall_force,
)
from softgrain.picture import draw_packing  # noqa: E402
from softgrain.profile import contact_halfwidth, contact_profile  # noqa: E402
from softgrain.quasi_static import (  # noqa: E402
    quasi_static,
    scale_mass,
    suggest_speed,
    unbalanced_force,
)
from softgrain.rigid_disks import as_disks  # noqa: E402
from softgrain.softening import soften  # noqa: E402
from softgrain.time_loop import (  # noqa: E402
    advance,
    critical_time_step,
    engines,
    insert_before_solve,
    set_time_step,
)
from softgrain.timing import phase_times, reset_times  # noqa: E402
from softgrain.vtk_files import write_vtk  # noqa: E402
from softgrain.walls import wall_box, walls_around  # noqa: E402

yade_utils.replace()

__version__ = _softgrain.version

__all__ = sorted(_classes) + [
    "Balance",
    "Hardened",
    "ImageGrains",
    "advance",
    "as_disks",
    "body_forces",
    "cell_stress",
    "cell_volume",
    "contact_forces",
    "contact_halfwidth",
    "contact_profile",
    "coordination_number",
    "critical_time_step",
    "draw_packing",
    "engines",
    "grain_area",
    "grains_from_image",
    "harden",
    "insert_before_solve",
    "integrator",
    "packing_fraction",
    "pair_forces",
    "phase_times",
    "quasi_static",
    "reset_times",
    "scale_mass",
    "set_time_step",
    "soft_block",
    "soft_bodies",
    "soft_disk",
    "soft_ellipse",
    "soft_polygon",
    "soft_sphere",
    "soft_superdisk",
    "soften",
    "solve_contact_problem",
    "suggest_speed",
    "unbalanced_force",
    "von_mises",
    "wall_box",
    "wall_force",
    "walls_around",
    "write_vtk",
]
