"""Periodic cells and interfaces in the kernel inside YADE against the oracle in numpy."""

import pytest
from oracle_scenes import OBLIQUE, Case, assert_notices, assert_same, times

#: Columns of a sheared cell; the second grain of OBLIQUE as seen across two of its borders.
CELL = ((0.052, 0.004), (0.0, 0.052))
ACROSS = ((0.0, 0.0), tuple(x - sum(row) for x, row in zip(OBLIQUE[1], CELL)))
FLOW = ((-20.0, 30.0), (5.0, 10.0))
COHESION = (2e4, 3e-4, 0.1)

CASES = {
    "periodic": Case(cell=CELL, centres=ACROSS, flow=FLOW, walls=()),
    "periodic, points": Case(
        cell=CELL, centres=ACROSS, flow=FLOW, walls=(), contact="points", zeta=(0.25, 0.25)
    ),
    "cohesion, two coefficients of friction": Case(interface=COHESION),
    "periodic, cohesion": Case(cell=CELL, centres=ACROSS, flow=FLOW, walls=(), interface=COHESION),
}


@pytest.mark.parametrize("name", CASES)
def test_kernel_does_the_same_as_the_oracle(name):
    assert_same(CASES[name])


def still_before(system):
    """As if the flow of the cell had not begun with the first step."""
    system.cell.last_gradient = system.cell.gradient


CHANGES = {
    "faster_cell": times(1.001, "cell", "gradient"),
    "still_before": still_before,
    "farther_image": times(1 + 1e-7, "cell", "base"),
    "more_cohesion": times(1.001, "interface", "cohesion"),
    "shorter_range": times(0.99, "interface", "cohesion_range"),
    "smoother_sliding": times(0.999, "interface", "dynamic_friction"),
}


@pytest.mark.parametrize("change", CHANGES)
def test_comparison_notices_a_change(change):
    assert_notices(CHANGES[change], CASES["periodic, cohesion"])
