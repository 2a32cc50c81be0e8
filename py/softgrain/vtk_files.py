"""Soft grains and their contacts as files of VTK, which ParaView and others read."""

import os
from collections.abc import Iterable
from pathlib import Path

import numpy as np
from yade import O

from softgrain.bodies import is_soft, soft_bodies, some_soft_bodies
from softgrain.forces import contact_forces, pair_forces
from softgrain.grain_mesh import filled, outline_polygon, shell
from softgrain.observe import von_mises


def write_vtk(prefix, what=("grains", "points", "contacts", "pairs")):
    """Write the soft grains, and what they touch with, as they are now, for ParaView: files
    ``<prefix><what>.<O.iter>.vtp``, each with ``O.time`` as its time, beside those of YADE's
    ``VTKRecorder``, which has the rigid bodies (recorders 'spheres', 'facets', 'boxes').

    ========== =================================== ==============================================
    what       is drawn as                         with
    ========== =================================== ==============================================
    'grains'   triangles: in 2D the whole, in 3D   stress, von_mises, pressure [Pa] at the
               the surface (contact 'points': the   corners, from the nearest material point; id,
               convex hull)                        material, velocity [m/s] of each grain
    'points'   material points                     id of the grain, F [-], stress, von_mises,
                                                   pressure [Pa], volume [m³, 2D m²]
    'contacts' contact points                      the arrays of :func:`contact_forces`
    'pairs'    the mean contact point of each pair those of :func:`pair_forces`
    ========== =================================== ==============================================

    stress is the Cauchy stress, material the ``id`` of the ``SoftMat`` (-1: not in
    ``O.materials``). In a periodic cell each grain is drawn once, where its centre is in the cell,
    and so is what belongs to it. Needs VTK's Python modules (Debian: python3-vtk9).

    Args:
        prefix (str | Path): of the names of the files; its folder has to exist.
        what (iterable of str): which files, each a name of the table.

    Returns:
        list of Path: the files, in the order of ``what``.

    Raises:
        ValueError: a prefix that is no name, an unknown file, or a scene without a soft grain.
        OSError: the folder is not there, or a file cannot be written.
        ImportError: VTK's Python modules are not installed.
    """
    if not isinstance(prefix, (str, os.PathLike)):
        raise ValueError(f"prefix = {prefix!r}: admissible is the beginning of a file's name")
    names = (what,) if isinstance(what, str) or not isinstance(what, Iterable) else tuple(what)
    for name in names:
        if not (isinstance(name, str) and name in _CONTENTS):
            raise ValueError(f"what: {name!r} is unknown; known: {', '.join(map(repr, _CONTENTS))}")
    some_soft_bodies("write_vtk")
    folder = Path(f"{os.fspath(prefix)}x").parent
    if not folder.is_dir():
        raise FileNotFoundError(f"prefix = {str(prefix)!r}: there is no folder {str(folder)!r}")
    files = [Path(f"{os.fspath(prefix)}{name}.{O.iter}.vtp") for name in names]
    write = _writer()
    for name, file in zip(names, files):
        write(file, *_CONTENTS[name](), O.time)
    return files


def _writer():
    """VTK is loaded when first asked for: most scenes write no such files."""
    try:
        from softgrain.vtk_polydata import write_polydata
    except ImportError as error:
        raise ImportError("write_vtk needs VTK's Python modules (Debian: python3-vtk9)") from error
    return write_polydata


def _grains():
    """Places, triangles, fields at the places and fields of the triangles."""
    places, triangles, stresses, rows = [], [], [], []
    count = 0
    for body in soft_bodies():
        x, mesh, stress = _mesh(body)
        places.append(x + _into_cell(body.id))
        triangles.append(mesh + count)
        stresses.append(stress)
        rows += [(body.id, body.material.id, *body.state.vel)] * len(mesh)
        count += len(x)
    rows = np.array(rows)
    fields = {
        "id": rows[:, 0].astype(int),
        "material": rows[:, 1].astype(int),
        "velocity": rows[:, 2:],
    }
    return np.vstack(places), np.vstack(triangles), _stress_fields(np.concatenate(stresses)), fields


def _mesh(body):
    data = body.shape.points()
    if body.shape.dim == 3:
        return shell(body, data["position"], data["cauchy"])
    flat, mesh, stress = filled(data["position"][:, :2], data["cauchy"], outline_polygon(body))
    height = np.full(len(flat), body.state.pos[2])
    return np.column_stack([flat, height]), mesh, stress


def _stress_fields(cauchy):
    return {
        "stress": cauchy,
        "von_mises": von_mises(cauchy),
        "pressure": -np.trace(cauchy, axis1=1, axis2=2) / 3,
    }


def _points():
    data = [(body.id, body.shape.points()) for body in soft_bodies()]

    def column(name):
        return np.concatenate([points[name] for _, points in data])

    places = np.vstack([points["position"] + _into_cell(k) for k, points in data])
    fields = {
        "id": np.repeat([k for k, _ in data], [len(points["volume"]) for _, points in data]),
        "F": column("F"),
        "volume": column("volume"),
        **_stress_fields(column("cauchy")),
    }
    return places, None, fields, {}


def _contacts():
    """(Points lie beside their owner, or the grain that a rigid owner touches.)"""
    fields = contact_forces()
    owners = zip(fields["owner"], fields["other"])
    return _beside(fields, [a if is_soft(O.bodies[int(a)]) else b for a, b in owners])


def _pairs():
    fields = pair_forces()
    return _beside(fields, fields["id1"])


def _beside(fields, ids):
    shifts = np.array([_into_cell(int(k)) for k in ids]).reshape(-1, 3)
    return fields.pop("point") + shifts, None, fields, {}


def _into_cell(body_id):
    """Displacement that puts the centre of a body into the periodic cell [m]."""
    centre = O.bodies[body_id].state.pos
    return np.array(O.cell.wrap(centre) - centre) if O.periodic else np.zeros(3)


_CONTENTS = {"grains": _grains, "points": _points, "contacts": _contacts, "pairs": _pairs}
