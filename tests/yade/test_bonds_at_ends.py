"""Ends of rigid bodies, spheres among them, stand for no area: where nothing else touches, the
contact node beside them is bonded."""

import numpy as np
import pytest
from interface_scenes import BOND, damped, interaction
from scenes import RADIUS, ZETA, ready, run
from yade import FrictMat, O, utils

import softgrain as sg

MAKE = {2: (sg.soft_disk, ZETA), 3: (sg.soft_sphere, 2 * ZETA)}


def add_grain_on_sphere(dim, gap):
    """A grain, and a held sphere beside the middle of a facet of its outline."""
    make, zeta = MAKE[dim]
    grain = make((0, 0, 0), RADIUS, damped(), zeta=zeta)
    O.bodies.append(grain)
    middle = grain.shape.outline()[grain.shape.facets()[0]].mean(axis=0)
    way = np.zeros(3)
    way[:dim] = middle[:dim] / np.linalg.norm(middle)
    sphere = utils.sphere((2 * RADIUS + gap) * way, RADIUS, material=FrictMat(frictionAngle=0))
    sphere.state.blockedDOFs = "xyzXYZ"
    O.bodies.append(sphere)
    return grain, way


@pytest.mark.parametrize("by_hand", (False, True), ids=("at touch", "by hand"))
@pytest.mark.parametrize("dim", MAKE)
def test_end_between_nodes_bonds_the_node_beside_it(dim, by_hand):
    grain, way = add_grain_on_sphere(dim, gap=1e-6)
    O.trackEnergy = True
    ready(interface=dict(bondAtTouch=not by_hand, **BOND))
    run(2)
    if by_hand:
        assert interaction().geom.bond() == 1
        run(1)
    contacts = interaction().geom.contacts()
    (bonded,) = np.flatnonzero(contacts["bond"])
    assert contacts["side"][bonded] == 0
    area = contacts["area"][bonded]
    while (interaction().geom.contacts()["bond"] == 1).any():
        force = min(O.iter / 2000, 1.2) * BOND["bondStrength"] * area
        O.forces.setPermF(grain.id, -force * way)
        run(1)
        assert O.iter < 10000
    work = sg.integrator().energy()["cohesion"]
    assert work == pytest.approx(BOND["bondEnergy"] * area, rel=0.05)
    assert sg.integrator().lostBonds == 0
