"""Files for ParaView, read again by VTK."""

import sys

import numpy as np
import pytest
from periodic_scenes import set_cell
from scenes import RADIUS, add_disk, add_wall, ready, run, soft_material
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline
from vtkmodules.vtkIOXML import vtkXMLPolyDataReader
from yade import FrictMat, O, VTKRecorder, utils

import softgrain as sg


class Read:
    """What is in a file."""

    def __init__(self, file):
        reader = vtkXMLPolyDataReader()
        reader.SetFileName(str(file))
        reader.UpdateInformation()
        key = vtkStreamingDemandDrivenPipeline.TIME_STEPS()
        (self.time,) = reader.GetOutputInformation(0).Get(key)
        reader.Update()
        data = reader.GetOutput()
        self.places = vtk_to_numpy(data.GetPoints().GetData())
        self.verts = data.GetNumberOfVerts()
        self.triangles = vtk_to_numpy(data.GetPolys().GetConnectivityArray()).reshape(-1, 3)
        self.at_places = self._fields(data.GetPointData())
        self.of_triangles = self._fields(data.GetCellData())

    @staticmethod
    def _fields(data):
        arrays = map(data.GetArray, range(data.GetNumberOfArrays()))
        return {array.GetName(): vtk_to_numpy(array) for array in arrays}

    def corners(self, chosen=slice(None)):
        return self.places[self.triangles[chosen]].transpose(1, 0, 2)


def two_pressed(make, **shape):
    """Two grains between walls that close in, in contact with each other and with these."""
    grains = [make((x * RADIUS, 0, 0), RADIUS, soft_material(), **shape) for x in (-1, 1)]
    O.bodies.append(grains)
    for side in (-1, 1):
        add_wall(side * 2 * RADIUS, axis=0, velocity=(-side, 0, 0))
    ready()
    run(60)
    return grains


def test_disks(tmp_path):
    """Their triangles have their area, stresses are those of the points, forces add up."""
    grains = two_pressed(sg.soft_disk, zeta=0.2)
    files = sg.write_vtk(tmp_path / "two-")
    names = [f"two-{name}.60.vtp" for name in ("grains", "points", "contacts", "pairs")]
    assert [file.name for file in files] == names
    drawn, points, contacts, pairs = map(Read, files)
    assert {f.time for f in (drawn, points, contacts, pairs)} == {O.time}
    for grain in grains:
        a, b, c = drawn.corners(drawn.of_triangles["id"] == grain.id)
        area = 0.5 * np.abs(np.cross(b - a, c - a)[:, 2]).sum()
        assert area == pytest.approx(grain.shape.volume(), rel=0.01)
        of_it = points.at_places["id"] == grain.id
        data = grain.shape.points()
        np.testing.assert_array_equal(points.places[of_it], data["position"])
        for name, field in (("F", "F"), ("stress", "cauchy")):
            saved = points.at_places[name][of_it].reshape(-1, 3, 3)
            np.testing.assert_array_equal(saved, data[field])
        velocity = drawn.of_triangles["velocity"][drawn.of_triangles["id"] == grain.id]
        np.testing.assert_array_equal(velocity, np.tile(grain.state.vel, (len(velocity), 1)))
    assert points.at_places["von_mises"].max() > 1e4
    assert drawn.at_places["von_mises"].max() == points.at_places["von_mises"].max()
    assert drawn.at_places["pressure"].min() == points.at_places["pressure"].min()
    expected = sg.contact_forces()
    assert contacts.verts == len(expected["gap"]) > 10
    np.testing.assert_array_equal(contacts.places, expected.pop("point"))
    for name, values in expected.items():
        np.testing.assert_array_equal(contacts.at_places[name], values)
    assert pairs.verts == 3
    np.testing.assert_array_equal(pairs.at_places["normal_force"], sg.pair_forces()["normal_force"])


def volume_of(file, grain):
    """Of the polyhedron: positive only if its sides face outwards."""
    a, b, c = file.corners(file.of_triangles["id"] == grain.id) - np.array(grain.state.pos)
    return np.einsum("ti,ti->", np.cross(a, b), c) / 6


@pytest.mark.parametrize("contact", ("surface", "points"))
def test_balls(tmp_path, contact):
    """Surfaces that are closed and face outwards."""
    grains = two_pressed(sg.soft_sphere, zeta=0.3, contact=contact)
    (file,) = sg.write_vtk(str(tmp_path) + "/", what="grains")
    assert file == tmp_path / "grains.60.vtp"
    drawn = Read(file)
    for grain in grains:
        share = volume_of(drawn, grain) / grain.shape.volume()
        assert 0.9 < share < 1.0 if contact == "surface" else 0.5 < share < 1.0
    assert drawn.at_places["von_mises"].max() > 1e4


def test_cell(tmp_path):
    """What belongs together is where the centre of the grain is in the cell."""
    set_cell(6 * RADIUS, 6 * RADIUS)
    for k in range(9):
        periods = (6 * (k % 4), -6 * (k % 2))
        x, y = (1 + 2 * place + period for place, period in zip(divmod(k, 3), periods))
        add_disk((x * RADIUS, y * RADIUS, 0))
    ready()
    O.cell.velGrad = utils.Matrix3(-5, 0, 0, 0, -5, 0, 0, 0, 0)
    run(60)
    grains, points, contacts, pairs = map(Read, sg.write_vtk(tmp_path / "cell-"))
    expected = sg.contact_forces()
    assert len(expected["owner"]) > 20
    centres = np.array([O.cell.wrap(body.state.pos) for body in O.bodies])
    for file, ids in (
        (points, points.at_places["id"]),
        (contacts, expected["owner"]),
        (pairs, pairs.at_places["id1"]),
    ):
        assert np.linalg.norm(file.places - centres[ids], axis=1).max() < 1.2 * RADIUS
    corners = grains.triangles[:, 0]
    near = grains.places[corners] - centres[grains.of_triangles["id"]]
    assert np.linalg.norm(near, axis=1).max() < 1.2 * RADIUS


def test_beside_files_of_yade(tmp_path):
    """Both in one folder, of the same step; materials tell which grains are which."""
    O.materials.append([FrictMat(), soft_material(), soft_material()])
    O.bodies.append(utils.sphere((0, 0, 0), RADIUS, material=0))
    for k in (1, 2):
        place = (2 * k * RADIUS, 0, 0)
        O.bodies.append(sg.soft_disk(place, RADIUS, O.materials[k], zeta=0.3))
    O.engines = sg.engines() + [
        VTKRecorder(fileName=f"{tmp_path}/", recorders=["spheres"], iterPeriod=2)
    ]
    sg.set_time_step()
    run(3)
    sg.write_vtk(f"{tmp_path}/", what=("grains",))
    assert (tmp_path / "grains.3.vtp").exists()
    assert list(tmp_path.glob("spheres.*.vtu"))
    grains = Read(tmp_path / "grains.3.vtp")
    found = set(zip(grains.of_triangles["id"], grains.of_triangles["material"]))
    assert found == {(1, 1), (2, 2)}


def test_before_the_first_step(tmp_path):
    """Without contacts files are there all the same, with no points."""
    add_disk()
    ready()
    files = [Read(file) for file in sg.write_vtk(tmp_path / "p")]
    assert [len(file.places) > 0 for file in files] == [True, True, False, False]


def test_folder_that_is_not_there(tmp_path):
    add_disk()
    with pytest.raises(FileNotFoundError, match="prefix = .*no folder"):
        sg.write_vtk(tmp_path / "none" / "p")
    (tmp_path / "pgrains.0.vtp").mkdir()
    with pytest.raises(OSError, match="cannot be written"):
        sg.write_vtk(tmp_path / "p")


def test_scene_without_soft_grains(tmp_path):
    with pytest.raises(ValueError, match="write_vtk: the scene has no soft grain"):
        sg.write_vtk(tmp_path / "p")


def test_without_vtk(tmp_path, monkeypatch):
    add_disk()
    monkeypatch.setitem(sys.modules, "softgrain.vtk_polydata", None)
    with pytest.raises(ImportError, match="python3-vtk9"):
        sg.write_vtk(tmp_path / "p")
