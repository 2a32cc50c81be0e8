"""The kernel inside YADE against the oracle in numpy: the same scene, step by step.

Periodic cells and interfaces: ``test_reference_cells.py``.
"""

import numpy as np
import pytest
from oracle_scenes import (
    BOTTOM,
    HEAD_ON,
    SIDE,
    TOP,
    Case,
    assert_notices,
    assert_same,
    times,
    with_material,
)

import softgrain as sg
from softgrain import reference
from yade import O, SoftMat

CASES = {
    "surface": Case(),
    "points": Case(contact="points", zeta=(0.25, 0.25)),
    "plane stress, quadratic": Case("planeStress", order=2, zeta=(0.25, 0.25), gravity=-3000.0),
    "linear, lattice": Case(order=1, quadrature="lattice", zeta=(0.25, 0.25)),
    "projected": Case(volumetric="projected", zeta=(0.25, 0.25)),
    # a grain between two walls: their order counts in the sweeps, whichever was met first, where
    # the grid is so coarse that their contacts share nodes
    "corner": Case(node_spacing=2.0, walls=(SIDE, BOTTOM, TOP)),
    # the outline bulges out of the box of its nodes
    "sparse outline": Case(surface_spacing=2.8, zeta=(0.25, 0.25), centres=HEAD_ON),
    "damped": Case(mass_damping=3000.0, stiffness_damping=1e-5),
    "damped, plane stress": Case("planeStress", stiffness_damping=1e-5),
    "damped, projected": Case(
        volumetric="projected", zeta=(0.25, 0.25), mass_damping=3000.0, stiffness_damping=1e-5
    ),
    "multirate": Case(zeta=(0.5, 0.12), rates=(3, 1)),
    "multirate, damped": Case(
        zeta=(0.5, 0.12), rates=(3, 1), mass_damping=3000.0, stiffness_damping=1e-6
    ),
    "flip": Case(velocity_update="flip"),
    "flip with a share of PIC, points": Case(
        contact="points", zeta=(0.25, 0.25), velocity_update="flip", pic_share=0.1, gravity=-3000.0
    ),
    "updated": Case(formulation="updated"),
    "updated with a share of PIC, plane stress, quadratic, points": Case(
        "planeStress",
        contact="points",
        order=2,
        zeta=(0.25, 0.25),
        gravity=-3000.0,
        formulation="updated",
        pic_share=0.1,
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_kernel_does_the_same_as_the_oracle(name):
    assert_same(CASES[name])


def cold_start(system):
    find = system.find_contacts

    def find_anew(dt):
        system.contacts = []
        find(dt)

    system.find_contacts = find_anew


def walls_in_reverse(system):
    find = system.find_contacts

    def find_and_reverse(dt):
        find(dt)
        system.contacts.sort(key=lambda entry: (entry[0][0], entry[0][1] >= 0, entry[0][1]))

    system.find_contacts = find_and_reverse


CHANGES = {
    "damped": with_material("mass_damping", lambda alpha: 1e-2),
    "viscous": with_material("stiffness_damping", lambda beta: 1e-10),
    "stiffer": with_material("young", lambda young: 1.0001 * young),
    "rougher": with_material("friction_angle", lambda angle: 1.001 * angle),
    "faster_walls": times(1.001, "walls", "velocity"),
    "more_relaxation": times(1.01, "settings", "overlap_relaxation"),
    "higher_overlap_speed": times(1.01, "settings", "overlap_speed"),
    "smaller_tolerance": times(0.5, "settings", "tolerance"),
    "cold_start": cold_start,
    "walls_in_reverse": walls_in_reverse,
}


@pytest.mark.parametrize("change", CHANGES)
def test_comparison_notices_a_change(change):
    assert_notices(CHANGES[change], CASES["corner"])


@pytest.mark.parametrize("node_spacing", (1.25, 2.0, 2.5))
@pytest.mark.parametrize("order", (1, 2, 3))
def test_template_is_that_of_the_oracle(order, node_spacing):
    """Nodes and material points are the same; the undeformed grain is undeformed (F = 1)."""
    O.reset()
    disk = sg.soft_disk((0, 0, 0), 1.0, SoftMat(), zeta=0.25, order=order, nodeSpacing=node_spacing)
    O.bodies.append(disk)
    recipe = reference.Recipe(0.25, order=order, node_spacing=node_spacing)
    expected = reference.Template(recipe)
    np.testing.assert_allclose(disk.shape.nodes(), expected.node_position, atol=1e-14)
    points = disk.shape.points()
    np.testing.assert_allclose(points["position"][:, :2], expected.point_position, atol=1e-14)
    np.testing.assert_allclose(points["F"] - np.eye(3), 0, atol=1e-13)
    np.testing.assert_allclose(points["volume"], expected.point_volume, atol=1e-14)


@pytest.mark.parametrize("contact", ("surface", "points"))
@pytest.mark.parametrize("quadrature", ("cutCell", "lattice"))
def test_contact_nodes_are_those_of_the_oracle(quadrature, contact):
    """On the outline, or one for each cell with an empty neighbour, in the same order."""
    O.reset()
    kind = {"quadrature": quadrature, "contact": contact}
    disk = sg.soft_disk((0, 0, 0), 1.0, SoftMat(), zeta=0.25, nodeSpacing=2, **kind)
    O.bodies.append(disk)
    expected = reference.Template(reference.Recipe(0.25, node_spacing=2, **kind))
    outline = disk.shape.outline()[:, :2]
    np.testing.assert_allclose(outline, expected.contact_position, atol=1e-14)
