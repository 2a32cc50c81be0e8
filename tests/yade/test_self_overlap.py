"""Grains that bend so far that they would touch themselves, which is not computed."""

import math
import re

import numpy as np
from scenes import RADIUS, add_wall, message_of_step, ready, run, soft_material
from yade import O

import softgrain as sg


def pinched_fork():
    """Two prongs that walls press together, on a common foot."""
    ring = [(0, 0), (5, 0), (5, 6), (3.5, 6), (3.5, 1.5), (1.5, 1.5), (1.5, 6), (0, 6)]
    vertices = [(0.4 * RADIUS * x, 0.4 * RADIUS * y) for x, y in ring]
    O.bodies.append(sg.soft_polygon(vertices, soft_material(massDamping=2000), zeta=0.3))
    width = 2 * RADIUS
    for place, inwards in ((0, 1), (width, -1)):
        add_wall(place, axis=0, velocity=(inwards * 0.5, 0, 0), sense=inwards)


def test_stops_where_prongs_go_through_each_other():
    """The state can be read and saved; with maxOverlap = inf the run goes on."""
    pinched_fork()
    ready()
    message = message_of_step(2000)
    found = re.search(r"soft grain #0 overlaps itself by (.*) point spacings", message)
    assert 1 < float(found[1]) < 2 and "maxOverlap = 1: contact of a grain with itself" in message
    steps, outline = sg.integrator().steps, O.bodies[0].shape.outline()
    O.saveTmp()
    O.loadTmp()
    np.testing.assert_array_equal(O.bodies[0].shape.outline(), outline)
    sg.integrator().maxOverlap = math.inf
    run(20)
    assert sg.integrator().steps == steps + 20
