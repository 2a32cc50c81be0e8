"""Rigid bodies inside of soft grains, where no contact node tells."""

import pytest
from partner_scenes import rigid_material
from scenes import RADIUS, add_disk, message_of_step, ready, soft_material
from yade import O, utils

import softgrain as sg


def fixed_box(extents, centre=(0, 0, 0)):
    return utils.box(centre, [e * RADIUS for e in extents], fixed=True, material=rigid_material(0))


def facet_across():
    corners = [(-0.5, 0, -2), (0.5, 0, -2), (0, 0, 4)]
    return utils.facet([[RADIUS * x for x in c] for c in corners], material=rigid_material(0))


@pytest.mark.parametrize("dim", (2, 3))
@pytest.mark.parametrize(
    "make",
    [
        lambda: fixed_box((0.3, 0.3, 0.3)),
        lambda: fixed_box((0.02, 0.3, 0.3)),
        lambda: fixed_box((3, 0.1, 0.1)),
        lambda: fixed_box((0.1, 1, 0.1), (0.2 * RADIUS, -0.8 * RADIUS, 0)),
        facet_across,
        lambda: utils.sphere((0, 0, 0), 0.3 * RADIUS, fixed=True, material=rigid_material(0)),
    ],
    ids=("box", "thin box", "bar through", "punch", "facet", "sphere"),
)
def test_what_is_inside_a_grain_is_refused(dim, make):
    """At once, though no node of the grain is near it."""
    if dim == 2:
        add_disk(zeta=0.1)
    else:
        O.bodies.append(sg.soft_sphere((0, 0, 0), RADIUS, soft_material(), zeta=0.2))
    O.bodies.append(make())
    ready(gravity=(0, -9.81, 0))
    assert "one lies inside the other" in message_of_step()
