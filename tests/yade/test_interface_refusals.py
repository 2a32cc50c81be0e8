"""Interface laws that are refused, at once where they are known, else in the step."""

import math
import re

import pytest
from interface_scenes import BOND, COHESION, SIDE, add_block, damped, interaction
from scenes import RADIUS, add_disk, add_wall, ready, run, soft_material
from yade import FrictMat, MatchMaker, O

import softgrain as sg


def of_all(value):
    """For all pairs of materials, which the integrator looks at when they meet."""
    return MatchMaker(algo="val", val=value)


@pytest.mark.parametrize(
    "name, value, admissible",
    [
        ("frictAngle", math.nan, "[0, 1.57"),
        ("dynamicFrictAngle", -0.1, "[0, 1.57"),
        ("cohesion", -1.0, "[0, inf) Pa"),
        ("bondEnergy", "much", "[0, inf) J/m²"),
        ("restitution", 2.0, "[0, 1]"),
    ],
)
def test_numbers_are_refused_at_once(name, value, admissible):
    add_block(0)
    shown = repr(value) if isinstance(value, str) else value
    message = f"interface: {name} = {shown} is outside the admissible range {admissible}"
    with pytest.raises(ValueError, match=re.escape(message)):
        sg.engines(interface={name: value})


@pytest.mark.parametrize("pair", [(0, 7), (-1, 0), (0.5, 0)])
def test_materials_that_are_none_are_refused_at_once(pair):
    add_block(0)
    O.materials.append(FrictMat())
    message = r"interface: cohesion is given for material .*admissible are ids of .*\[0, 1\)"
    match = MatchMaker(matches=((*pair, 1e3),), algo="zero")
    with pytest.raises(ValueError, match=message):
        sg.engines(interface={"cohesion": match, "cohesionRange": 1e-4})


@pytest.mark.parametrize(
    "law, message",
    [
        (
            {"dynamicFrictAngle": 0.5, "frictAngle": 0.2},
            r"dynamicFrictAngle = 0.5 is outside the admissible range \[0, 0.2\] rad",
        ),
        ({"cohesion": 1e3, "cohesionRange": 0}, r"cohesionRange = 0 is outside .* \(0, inf\) m"),
        ({"cohesion": 1e3}, "cohesionRange = 0 is outside"),
        ({"bondStrength": 1e3}, r"bondEnergy = 0 is outside .* \(0, inf\) J"),
        ({"bondStiffness": 1e3, **BOND}, r"bondStiffness = 1000 is outside .* \(bondStrength"),
        ({"cohesionRange": 1e-4}, "cohesionRange does nothing without cohesion; give both"),
        ({"bondEnergy": 1.0}, "bondEnergy does nothing without bondStrength; give both"),
        ({"bondStiffness": 1e9}, "bondStiffness does nothing without bondStrength"),
        ({"bondAtTouch": False}, "bondAtTouch does nothing without bondStrength"),
    ],
)
@pytest.mark.parametrize("matched", (False, True))
def test_what_does_not_fit_together_is_refused_at_once(law, message, matched):
    """Numbers for all pairs of materials, however they are given."""
    add_block(0)
    if matched:
        law = {n: v if isinstance(v, bool) else of_all(v) for n, v in law.items()}
    with pytest.raises(ValueError, match=f"interface: {message}"):
        sg.engines(interface=law)


def test_what_depends_on_the_pair_is_left_to_the_step():
    add_block(0)
    other = O.materials.append(FrictMat())
    none = MatchMaker(matches=((other, other, 1e3),), algo="zero")
    for law in (
        {"cohesion": none, "cohesionRange": 1e-4},
        {"cohesion": 1e3, "cohesionRange": none},
        {"bondStrength": 1e3, "bondEnergy": none},
        {"bondStrength": none, "bondEnergy": 0.1, "bondStiffness": none},
        {"dynamicFrictAngle": 0.5},
        {"dynamicFrictAngle": 0.5, "frictAngle": MatchMaker(algo="max")},
        {"cohesion": 0, "cohesionRange": 1e-4, "bondStrength": 0, "bondEnergy": 0.1},
    ):
        sg.engines(interface=law)


@pytest.mark.parametrize(
    "law", [COHESION, BOND, {"restitution": 0.5}, {"frictAngle": 0.3, "dynamicFrictAngle": 0.2}]
)
def test_geometries_without_laws_are_refused_at_once(law):
    O.bodies.append(sg.soft_disk((0, RADIUS, 0), RADIUS, damped(), zeta=0.25, contact="points"))
    with pytest.raises(ValueError, match="#0 has contact = 'points'; .* need .* 'surface'"):
        sg.engines(interface=law)
    sg.engines(interface={"frictAngle": 0.3, "dynamicFrictAngle": 0.3})


def test_no_number_from_the_materials():
    """An exception of MatchMaker in the loop would end the process."""
    add_block(0)
    add_wall(0, 1).material.frictionAngle = math.nan
    ready(interface={"frictAngle": MatchMaker(algo="avg")})
    with pytest.raises(RuntimeError, match="frictionAngle of .*FrictMat.* = nan is outside"):
        run(2)


def test_refused_geometry_stays_readable():
    O.engines = sg.engines(interface=COHESION, verlet_distance=0.1 * RADIUS)
    for height in (0, -SIDE):
        O.bodies.append(
            sg.soft_block((0, height, 0), (SIDE, SIDE), damped(), zeta=0.25, contact="nodes")
        )
    sg.set_time_step(0.5)
    with pytest.raises(RuntimeError, match="contact = 'surface'"):
        run(1)
    contacts = interaction().geom.contacts()
    assert len(contacts["bond"]) == len(contacts["gap"]) > 0


def test_bad_input():
    def stops(message, law, late={}, pair="wall", **shape):
        """`late`: attributes that functors are given after sg.engines has checked its own."""
        O.reset()
        O.bodies.append(sg.soft_disk((0, RADIUS, 0), RADIUS, damped(frictionAngle=0.3), **shape))
        if pair == "wall":
            add_wall(0, 1, friction=0.3)
        else:
            O.bodies.append(sg.soft_disk((0, -RADIUS, 0), RADIUS, damped(), **shape))
        ready(interface=law)
        for functor in O.engines[2].physDispatcher.functors:
            for name, value in late.items():
                if hasattr(functor, name):
                    setattr(functor, name, of_all(value))
        with pytest.raises(RuntimeError, match=message):
            run(2)

    stops(
        r"#1 and #0: dynamicFrictAngle = 0.5 is outside .*\[0, 0.291457\] rad",
        {"dynamicFrictAngle": 0.5},
    )
    stops("cohesion = -1 ", {}, {"cohesion": -1.0})
    stops("cohesionRange = 0 ", {}, {"cohesion": 1e3})
    stops("bondEnergy = 0 ", {}, {"bondStrength": 1e3})
    stops("bondStiffness = 1000 ", BOND, {"bondStiffness": 1e3})
    stops("restitution = 2 ", {}, {"restitution": 2.0})
    stops("restitution = 0.5 .*two soft grains", {}, {"restitution": 0.5}, pair="soft")
    stops("contact = 'surface'", {}, {"restitution": 0.5}, contact="points")
    with pytest.raises(ValueError, match="unknown .'stickiness'"):
        sg.engines(interface={"stickiness": 1})
    O.reset()
    add_block(0)
    add_wall(0, 1)
    ready(interface=COHESION, interfaceRange=1e-5)
    with pytest.raises(RuntimeError, match="interfaceRange"):
        run(2)


@pytest.mark.parametrize("angle", (22, -3, math.pi / 2))
def test_angles_of_pairs_are_checked(angle):
    """Degrees, or what else has a tangent above 0."""
    match = MatchMaker(algo="val", val=angle)
    for name in ("frictAngle", "dynamicFrictAngle"):
        with pytest.raises(ValueError, match=f"interface: {name} = .*\\[0, 1.57"):
            sg.engines(interface={name: match}, verlet_distance=0.1 * RADIUS)


def test_angle_of_a_material_is_checked():
    add_disk((0, 0.99 * RADIUS, 0), material=soft_material(frictionAngle=0.5))
    wall = add_wall(0, 1)
    wall.material.frictionAngle = -3
    wall.material.label = "rough"
    ready()
    message = r"#1 and #0: frictionAngle of FrictMat 'rough' = -3 is outside .*\[0, pi/2\) rad"
    with pytest.raises(RuntimeError, match=message):
        run(2)
