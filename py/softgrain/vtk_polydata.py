"""Arrays as a file of triangles or points in VTK's XML format."""

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter


def write_polydata(file, places, triangles, at_places, of_triangles, time):
    """Write a .vtp file.

    Args:
        file (Path): it.
        places (array (n, 3)): corners of the triangles, or points [m].
        triangles (array (t, 3) | None): as indices of places; None: points.
        at_places (dict of arrays (n, ...)): fields by name; matrices (n, 3, 3) row by row.
        of_triangles (dict of arrays (t, ...)): the same of the triangles.
        time (float): that readers show the file at [s].

    Raises:
        OSError: the file cannot be written.
    """
    data, points = vtkPolyData(), vtkPoints()
    points.SetData(numpy_to_vtk(places, deep=True))
    data.SetPoints(points)
    if triangles is None:
        data.SetVerts(_cells(np.arange(len(places))[:, None]))
    else:
        data.SetPolys(_cells(triangles))
    _add(data.GetPointData(), at_places)
    _add(data.GetCellData(), of_triangles)
    _add(data.GetFieldData(), {"TimeValue": np.array([time])})
    writer = vtkXMLPolyDataWriter()
    writer.SetFileName(str(file))
    writer.SetInputData(data)
    if not writer.Write() or writer.GetErrorCode():
        raise OSError(f"{str(file)!r} cannot be written")


def _cells(corners):
    """Cells with the same number of corners each, from their indices (cells, corners)."""
    count, size = corners.shape
    cells = vtkCellArray()
    cells.SetData(
        numpy_to_vtkIdTypeArray(np.arange(0, count * size + 1, size), deep=True),
        numpy_to_vtkIdTypeArray(corners.astype(np.int64).ravel(), deep=True),
    )
    return cells


def _add(fields, arrays):
    for name, values in arrays.items():
        rows = values.reshape(len(values), -1) if values.ndim > 2 else values
        array = numpy_to_vtk(rows, deep=True)
        array.SetName(name)
        fields.AddArray(array)
