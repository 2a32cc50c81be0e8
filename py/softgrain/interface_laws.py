"""What ``engines(interface=)`` takes: laws of surfaces by pair of materials, checked."""

import math

import numpy as np
from yade import MatchMaker, O, wrapper

from softgrain.checks import number, require_mapping

#: Admissible range and unit of what ``engines(interface=)`` takes as one number for all pairs.
_RANGES = {
    "frictAngle": (f"[0, {math.pi / 2})", "rad"),
    "dynamicFrictAngle": (f"[0, {math.pi / 2})", "rad"),
    "cohesion": ("[0, inf)", "Pa"),
    "cohesionRange": ("[0, inf)", "m"),
    "bondStrength": ("[0, inf)", "Pa"),
    "bondEnergy": ("[0, inf)", "J/m²"),
    "bondStiffness": ("[0, inf)", "Pa/m"),
    "restitution": ("[0, 1]", ""),
}
#: Attributes of ``engines(interface=)`` that act together; those behind the first do nothing
#: without it.
_LAWS = (
    ("cohesion", "cohesionRange"),
    ("bondStrength", "bondEnergy", "bondStiffness", "bondAtTouch"),
    ("restitution",),
)
#: Those that decide how far surfaces attract each other.
_OF_RANGE = ("cohesion", "cohesionRange", "bondStrength", "bondEnergy")
#: Of materials that no MatchMaker names.
_ANY_OTHER_PAIR = (-1, -1)


def checked(interface):
    """The attributes, numbers as MatchMakers; ValueError for what no pair of materials admits."""
    require_mapping("interface", interface, "attributes of Ip2_SoftPhys")
    known = set(wrapper.Ip2_SoftPhys().dict()) - set(wrapper.IPhysFunctor().dict())
    unknown = sorted(set(interface) - known)
    if unknown:
        raise ValueError(f"interface: unknown {unknown}; known: {sorted(known)}")

    attributes = {}
    for name, value in interface.items():
        if name == "bondAtTouch":
            if not isinstance(value, (bool, np.bool_)):
                raise ValueError(f"interface: bondAtTouch = {value!r}; admissible: True, False")
            attributes[name] = bool(value)
        elif isinstance(value, MatchMaker):
            _refuse_unknown_materials(name, value)
            for of_pair in _values(value):
                number(f"interface: {name}", of_pair, *_RANGES[name])
            attributes[name] = value
        else:
            value = number(f"interface: {name}", value, *_RANGES[name])
            attributes[name] = MatchMaker(algo="val", val=value)
    _refuse_idle_attributes(attributes)
    _check_law_of_all_pairs(attributes)
    return attributes


def _refuse_unknown_materials(name, match):
    """YADE passes over what no material is."""
    for index in (index for *pair, _ in match.matches for index in pair):
        if index not in range(len(O.materials)):
            raise ValueError(
                f"interface: {name} is given for material {index:g}; admissible are ids of "
                f"O.materials, whole numbers in [0, {len(O.materials)})"
            )


def longest_range(interface):
    """Largest gap [m] across which any pair of materials can attract each other."""
    matches = [m for m in interface.values() if isinstance(m, MatchMaker)]
    pairs = {(int(a), int(b)) for match in matches for a, b, _ in match.matches}
    return max(_range_of(pair, interface) for pair in pairs | {_ANY_OTHER_PAIR})


def longest_range_in_use():
    """The same of the pairs that are in contact, which keep their laws [m]."""
    laws = [getattr(i.phys, "interface", None) for i in O.interactions if i.isReal]
    ranges = [_reach(*(getattr(law, name) for name in _OF_RANGE)) for law in laws if law]
    return max(ranges, default=0)


def _reach(cohesion, within, strength, energy):
    """Gap up to which cohesion or a bond may attract [m]."""
    return max(within if cohesion > 0 else 0, 2 * energy / strength if strength > 0 else 0)


def _range_of(pair, interface):
    """The same of one pair of materials, by their ids."""
    return _reach(*(_value_of(pair, interface.get(name)) for name in _OF_RANGE))


def _value_of(pair, match):
    """What an attribute (or None) other than an angle is for a pair of materials."""
    if match is None:
        return 0
    named = [value for a, b, value in match.matches if {a, b} == set(pair)]
    return (named + [match.val if match.algo == "val" else 0])[0]


def _refuse_idle_attributes(interface):
    for first, *others in _LAWS:
        idle = [name for name in others if name in interface]
        if idle and first not in interface:
            raise ValueError(f"interface: {idle[0]} does nothing without {first}; give both")


def _check_law_of_all_pairs(interface):
    """What a step would refuse of any pair, which the first contact may show late."""
    law, friction = _law_of_all_pairs(interface)
    try:
        law.check(friction)
    except ValueError as error:
        raise ValueError(f"interface: {error}") from None
    if _acts(law):
        _require_surfaces()


def _acts(law):
    slides = law.tangensOfDynamicFrictionAngle >= 0
    return slides or law.cohesion > 0 or law.bondStrength > 0 or law.restitution > 0


def _require_surfaces():
    for body in O.bodies:
        if body and isinstance(body.shape, wrapper.SoftGrain) and body.shape.contact != "surface":
            raise ValueError(
                f"interface: soft grain #{body.id} has contact = {body.shape.contact!r}; "
                "interface laws need soft grains with contact = 'surface'"
            )


def _law_of_all_pairs(interface):
    """A SoftInterface with the laws whose numbers are the same for all pairs, and the coefficient
    of static friction, 0 where it depends on the pair."""
    known = {}
    for names in _LAWS:
        given = {name: _value_of_all(interface[name]) for name in names if name in interface}
        if None not in given.values():
            known.update(given)
    law = wrapper.SoftInterface(**known)
    static, dynamic = (
        _value_of_all(interface.get(name)) for name in ("frictAngle", "dynamicFrictAngle")
    )
    if None not in (static, dynamic) and static != dynamic:
        law.tangensOfDynamicFrictionAngle = math.tan(dynamic)
    return law, math.tan(static or 0)


def _value_of_all(match):
    """What an attribute is for all pairs; None where that depends on the pair."""
    if not isinstance(match, MatchMaker):
        return match
    return match.val if match.algo == "val" and not match.matches else None


def _values(match):
    """All that a MatchMaker gives by itself."""
    values = [value for _, _, value in match.matches]
    if match.algo == "val":
        values.append(match.val)
    return values
