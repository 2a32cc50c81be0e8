"""What cannot be in a periodic cell is refused."""

import pytest
from periodic_scenes import set_cell
from scenes import RADIUS, add_disk, add_wall, complaint, ready
from yade import Matrix3, O

import softgrain as sg


def test_wall_in_a_cell():
    set_cell(0.1, 0.1)
    add_disk()
    wall = add_wall(0, axis=1)
    for make in (sg.engines, sg.set_time_step):
        with pytest.raises(ValueError, match=f"body #{wall.id} is a Wall, but O.periodic"):
            make()


def test_cell_too_small():
    set_cell(3.9 * RADIUS, 8 * RADIUS)
    add_disk()
    ready()
    message = complaint()
    assert "soft grain #0 spans" in message and "half of its length 0.039 m" in message


def test_cell_leaves_the_plane():
    add_disk()
    O.periodic = True
    O.cell.hSize = Matrix3(0.1, 0, 0.01, 0, 0.1, 0, 0, 0, 1)
    ready()
    assert "O.cell.hSize couples z" in complaint()
    set_cell(0.1, 0.1)
    O.cell.velGrad = Matrix3(0, 0, 0, 0, 0, 0, 0, 0, -1)
    assert "O.cell.velGrad has components of z" in complaint()


def test_common_grid_is_refused():
    set_cell(0.1, 0.1)
    add_disk(contact="nodes")
    ready()
    assert "contact = 'nodes'" in complaint()


def test_reading_without_a_cell():
    add_disk()
    with pytest.raises(ValueError, match="O.periodic is False"):
        sg.packing_fraction()
    set_cell(0.1, 0.1)
    with pytest.raises(ValueError, match="known: 'contacts', 'grains'"):
        sg.cell_stress("walls")
