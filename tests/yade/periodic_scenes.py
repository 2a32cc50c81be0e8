"""Scenes in a periodic cell."""

import math

import numpy as np
from scenes import RADIUS, add_disk, run, soft_material
from yade import Matrix3, O

import softgrain as sg

DIAMETER = 2 * RADIUS


def set_cell(width, height, depth=1.0):
    """One metre along z: what YADE takes per volume of the cell is per metre of thickness then."""
    O.periodic = True
    O.cell.setBox(width, height, depth)


def flow(xx=0.0, xy=0.0, yx=0.0, yy=0.0, zz=0.0):
    """Velocity gradient of the cell [1/s]."""
    O.cell.velGrad = Matrix3(xx, xy, 0, yx, yy, 0, 0, 0, zz)


def irregular_packing(shift=(0, 0), count=3, friction=0.3, gap=0.0, **material):
    """Touching disks of several sizes on a square lattice with noise, in a square cell."""
    random = np.random.default_rng(7)
    spacing = DIAMETER * (1 + gap)
    set_cell(count * spacing, count * spacing)
    kind = soft_material(frictionAngle=math.atan(friction), **material)
    for i in range(count):
        for j in range(count):
            noise = random.uniform(-0.01, 0.01, 2) * RADIUS
            place = (np.array([i, j]) + 0.5) * spacing + noise + shift
            add_disk((*place, 0), random.uniform(0.95, 0.99) * RADIUS, kind)


def compress(phi, rate):
    flow(xx=-rate, yy=-rate)
    while sg.packing_fraction() < phi:
        run(20)
