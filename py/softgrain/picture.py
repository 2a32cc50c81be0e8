"""Pictures of packings: outlines of the grains, coloured by stress (the paper's Figure 3)."""

import os

import numpy as np
from matplotlib.collections import LineCollection, PolyCollection, TriMesh
from matplotlib.figure import Figure
from matplotlib.tri import Triangulation
from yade import O, wrapper

from softgrain.bodies import material_of, soft_bodies
from softgrain.cell import nearest_images
from softgrain.checks import finite_vector, number
from softgrain.grain_mesh import filled, outline_polygon
from softgrain.observe import von_mises

#: Size of a picture, without its colour bar, and the room for the title [inches].
WIDTH, LEAST_HEIGHT, LARGEST_HEIGHT, TITLE_HEIGHT = 6.5, 1.8, 9.0, 0.4
#: Pictures that are so many times as wide as high have their colour bar below.
BAR_BELOW = 2.5
#: Percentile of the stresses at which colours end if no limits are given: single points stick out.
HIGHEST_SHOWN = 99
#: Stresses that differ by less, in their unit, are those of rounding.
FLAT = 1e-9
#: Corners of the polygon that a rigid sphere is drawn as.
CORNERS_OF_A_CIRCLE = 72


def draw_packing(path, box=None, field="von_mises", scale=None, limits=None, title=None, dpi=200):
    """Draw all soft disks with their outlines and a stress field inside, rigid spheres, boxes and
    facets in grey, which may be all there is. Grains with contact 'points' are drawn as their
    boundary points by angle, without notches. In a periodic cell, which is outlined by dashes, all
    of them where they reach into it, those at its borders with their images.

    Args:
        path (str | Path): picture file; the suffix decides the format (png, pdf, svg).
        box (tuple | None): (xmin, xmax, ymin, ymax) of the walls to draw [m].
        field (str | None): 'von_mises' or 'pressure' of the Cauchy stress; None: plain grains.
        scale (float | None): stresses are divided by it (e.g. Young's modulus), > 0 [Pa]; None: in
            kPa.
        limits (tuple | None): (low, high) of the colours; None: from 0 (pressure: the lowest) to
            the 99th percentile.
        title (str | None): above the picture.
        dpi (float): resolution of bitmaps, in [10, 2400] [dots an inch].

    Raises:
        ValueError: an unknown field, nothing to draw, or a value out of its range.
        OSError: the folder is not there, or may not be written to.
    """
    _refuse_names(path, field)
    box, limits = _checked_box(box), _checked_limits(limits)
    scale = None if scale is None else number("scale", scale, "(0, inf)", "Pa")
    dpi = number("dpi", dpi, "[10, 2400]")
    disks = soft_bodies()
    if any(b.shape.dim == 3 for b in disks):
        raise ValueError("draw_packing draws scenes in 2D; this one has soft grains in 3D")
    images = [(b, shift) for b in disks for shift in _shifts(b.state.pos, outline_polygon(b))]
    outlines = [outline_polygon(b) + shift for b, shift in images]
    rigid = [polygon + shift for polygon in rigid_polygons() for shift in _shifts_of(polygon)]
    if not (outlines or rigid):
        raise ValueError("draw_packing draws soft disks and rigid bodies; the scene has none")
    figure = Figure(figsize=_size(outlines + rigid, box), layout="constrained")
    axes = figure.add_subplot()
    axes.add_collection(PolyCollection(rigid, facecolors="0.75", edgecolors="0.35", linewidths=0.5))
    if field and disks:
        _draw_field(figure, axes, images, outlines, field, scale, limits)
    else:
        axes.add_collection(PolyCollection(outlines, facecolors="0.85", edgecolors="none"))
    closed = [np.vstack([o, o[:1]]) for o in outlines]
    axes.add_collection(LineCollection(closed, colors="black", linewidths=0.5))
    _draw_frames(axes, box)
    axes.set_aspect("equal")
    axes.set_axis_off()
    axes.autoscale_view()
    if title:
        axes.set_title(title)
    figure.savefig(path, dpi=dpi, bbox_inches="tight")


def _refuse_names(path, field):
    if not (field is None or isinstance(field, str) and field in ("von_mises", "pressure")):
        raise ValueError(f"field = {field!r} is unknown; known: 'von_mises', 'pressure', None")
    if not isinstance(path, (str, bytes, os.PathLike)) or not os.path.basename(path):
        raise ValueError(f"path = {path!r}: admissible is the name of a file")


def _checked_box(box):
    if box is None:
        return None
    box = finite_vector("box", box, 4, "m")
    if not (box[0] < box[1] and box[2] < box[3]):
        raise ValueError(f"box = {box}: admissible are xmin < xmax and ymin < ymax")
    return box


def _checked_limits(limits):
    if limits is None:
        return None
    limits = finite_vector("limits", limits, 2, "the unit of the field")
    if not limits[0] < limits[1]:
        raise ValueError(f"limits = {limits}: the first has to be below the second")
    return limits


def _draw_frames(axes, box):
    """The box that is wanted, and the periodic cell, dashed."""
    if box is not None:
        left, right, low, high = box
        axes.plot(
            [left, right, right, left, left], [low, low, high, high, low], color="black", lw=1.4
        )
    if O.periodic:
        corners = np.array([(0, 0), (1, 0), (1, 1), (0, 1), (0, 0)])
        axes.plot(*(np.array(O.cell.hSize)[:2, :2] @ corners.T), color="black", lw=1, ls="--")


def _shifts(centre, polygon):
    """To the images of a body that reach into a periodic cell, in the plane [m]."""
    centre = np.array([centre[0], centre[1], 0])
    size = np.linalg.norm(polygon - centre[:2], axis=1).max()
    flat = {}
    for shift in nearest_images(centre, size):
        if not flat or _reaches_into_cell(polygon + shift[:2]):
            flat.setdefault(tuple(np.round(shift[:2], 12)), shift[:2])
    return list(flat.values())


def _reaches_into_cell(polygon):
    """By more than what grains in contact across the border overlap."""
    shares = np.linalg.solve(np.array(O.cell.hSize)[:2, :2], polygon.T)
    seen = 0.01 * np.ptp(shares, axis=1)
    return np.all((shares.max(axis=1) > seen) & (shares.min(axis=1) < 1 - seen))


def _shifts_of(polygon):
    low, high = polygon.min(axis=0), polygon.max(axis=0)
    return _shifts(0.5 * (low + high), polygon)


def rigid_polygons():
    """Outlines of the rigid spheres and boxes of a 2D scene, seen along z, and the segments in
    which facets cut the plane of the grains; without those that do not reach it.

    Returns:
        list of ndarray: of shape (n, 2) [m]; of a facet (2, 2).
    """
    plane = next((b.state.pos[2] for b in O.bodies if b and _lies_in_plane(b)), 0.0)
    polygons = []
    for body in O.bodies:
        corners, height = _corners(body.shape) if body else (None, 0)
        if corners is None:
            continue
        turn = np.array(body.state.ori.toRotationMatrix())
        places = np.array(body.state.pos) + np.array(corners) @ turn.T
        if isinstance(body.shape, wrapper.Facet):
            polygons += _cut(places, plane)
        elif abs(body.state.pos[2] - plane) < height:
            polygons.append(places[:, :2])
    return polygons


def _lies_in_plane(body):
    return isinstance(body.shape, (wrapper.SoftGrain, wrapper.Sphere))


def _corners(shape):
    """In the frame of the body, and how far it reaches along z; None for other shapes."""
    if isinstance(shape, wrapper.Sphere):
        angle = np.linspace(0, 2 * np.pi, CORNERS_OF_A_CIRCLE, endpoint=False)
        circle = shape.radius * np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
        return circle, shape.radius
    if isinstance(shape, wrapper.Box):
        width, height, depth = shape.extents
        around = ((-1, -1), (1, -1), (1, 1), (-1, 1))
        return [(x * width, y * height, 0) for x, y in around], depth
    if isinstance(shape, wrapper.Facet):
        return shape.vertices, 0
    return None, 0


def _cut(corners, plane):
    """The segment in which a triangle cuts a plane z = const, as a list; none of one that does not,
    or lies in it."""
    ends = []
    for start, end in zip(corners, np.roll(corners, -1, axis=0)):
        below, above = start[2] - plane, end[2] - plane
        if below == 0:
            ends.append(start[:2])
        elif below * above < 0:
            ends.append((start + below / (below - above) * (end - start))[:2])
    return [np.array(ends)] if len(ends) == 2 else []


def _size(outlines, box):
    points = np.vstack(outlines)
    low, high = points.min(axis=0), points.max(axis=0)
    if box is not None:
        low, high = np.minimum(low, [box[0], box[2]]), np.maximum(high, [box[1], box[3]])
    width, height = high - low
    drawn = WIDTH * height / width if width > 0 else LARGEST_HEIGHT  # 0 of an upright facet
    return WIDTH, np.clip(drawn + TITLE_HEIGHT, LEAST_HEIGHT, LARGEST_HEIGHT)


def _draw_field(figure, axes, images, outlines, field, scale, limits):
    fields = [_point_values(b, shift, field) for b, shift in images]
    unit = scale if scale else 1e3
    values = np.concatenate([v for _, v in fields]) / unit
    limits = limits or _limits_of(values)
    places, triangles, shades = _shaded(fields, outlines)
    mesh = TriMesh(
        Triangulation(places[:, 0], places[:, 1], triangles), cmap="viridis", rasterized=True
    )
    mesh.set_array(shades / unit)
    mesh.set_clim(*limits)
    axes.add_collection(mesh, autolim=False)  # the outlines tell, triangle by triangle is slow
    name = {"von_mises": "von Mises stress", "pressure": "pressure"}[field]
    label = f"{name} {_unit_label(scale)}"
    width, height = figure.get_size_inches()
    if width > BAR_BELOW * height:
        figure.colorbar(mesh, ax=axes, label=label, shrink=0.6, location="bottom")
    else:
        figure.colorbar(mesh, ax=axes, label=label, shrink=0.6, pad=0.02)


def _limits_of(values):
    """Colours from 0, or the lowest where stresses are negative, to the highest shown."""
    low, high = np.percentile(values, (100 - HIGHEST_SHOWN, HIGHEST_SHOWN))
    low = min(0.0, float(low))  # an equivalent stress is never below 0
    return low, float(high) if high > low + FLAT else low + 1


def _unit_label(scale):
    """Of stresses over ``scale`` [Pa]; None: in kPa."""
    if scale is None:
        return "(kPa)"
    moduli = {material_of(b).young for b in soft_bodies()}
    return "/ E" if moduli == {scale} else f"/ {scale:g} Pa"


def _point_values(body, shift, field):
    data = body.shape.points()
    cauchy = data["cauchy"]
    stress = von_mises(cauchy) if field == "von_mises" else -np.trace(cauchy, axis1=1, axis2=2) / 3
    return data["position"][:, :2] + shift, stress


def _shaded(fields, outlines):
    """One mesh for all grains, which is drawn much faster than one each: places (n, 2), triangles
    (m, 3), values at the places."""
    places, triangles, shades, count = [], [], [], 0
    for (points, stress), outline in zip(fields, outlines):
        vertices, mesh, values = filled(points, stress, outline)
        places.append(vertices)
        triangles.append(mesh + count)
        shades.append(values)
        count += len(vertices)
    return np.vstack(places), np.vstack(triangles), np.concatenate(shades)
