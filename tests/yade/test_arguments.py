"""Functions refuse wrong arguments by name, value and admissible range, and change nothing then."""

import math
import time

import numpy as np
import pytest
from scenes import RADIUS, add_disk
from yade import FrictMat, ForceEngine, O, Quaternion, utils

import softgrain as sg

NAN = math.nan
DISK = dict(center=(0, 0, 0), radius=RADIUS)
IMAGE = np.ones((20, 20), dtype=int)
THIN = [(0, 0), (1, 0), (1, 1e-4), (0, 1e-4)]


@pytest.mark.parametrize(
    "call, message",
    [
        (lambda: sg.soft_disk((NAN, 0, 0), RADIUS), "center = .*3 finite numbers"),
        (lambda: sg.soft_disk((0, 0), RADIUS), "center = .*3 finite numbers"),
        (lambda: sg.soft_polygon([(0, 0), (1, 0), (0, 1)], z=NAN), r"z = nan .*\(-inf, inf\) m"),
        (lambda: sg.soft_ellipse((0, 0, 0), (2, 1), angle=NAN), "angle = nan"),
        (lambda: sg.soft_disk(**DISK, form="block"), "form = 'block': .*sg.soft_block"),
        (lambda: sg.soft_sphere(**DISK, dim=2), "dim = 2: "),
        (lambda: sg.soft_polygon(THIN), "times as long as wide; admissible: at most 500"),
        (lambda: sg.engines(verlet_distance=NAN), r"verlet_distance = nan .*\[0, inf\) m"),
        (lambda: sg.engines(1e-4, gravity=(NAN, 0, 0)), "gravity = .*3 finite numbers"),
        (lambda: sg.soft_polygon([(0, 0), (1, 0), (1, 1), (0, 1)] * 2), "turns by 720 degrees"),
        (lambda: sg.soft_disk("123", RADIUS), "center = 123: .*3 finite numbers"),
        (lambda: sg.soft_disk((0, 0, 0), "1"), r"radius = '1' .*\(0, inf\) m"),
        (lambda: sg.soft_disk((0, 0, 0), True), r"radius = True .*\(0, inf\) m"),
        (lambda: sg.soft_disk((0, 0, 0), np.ones(1)), r"radius = \[1.\] .*\(0, inf\) m"),
        (lambda: sg.set_time_step(True), r"fraction = True .*\(0, 1\]"),
        (lambda: sg.engines(1e-4, residual=0.1), "residual: a result of SoftGrainIntegrator"),
        (lambda: sg.cell_stress(), "cell_stress needs a periodic cell .*O.periodic is False"),
        (lambda: sg.soft_disk(**DISK, zeta="x"), "zeta = 'x' is of no type"),
        (lambda: sg.soft_disk(**DISK, bogus=1), "bogus is no attribute of SoftGrain"),
        (lambda: sg.soft_disk(**DISK, mask=1.5), "mask = 1.5: .*whole number"),
        (lambda: sg.soft_disk(**DISK, color=(1, 2)), r"color = .*3 numbers in \[0, 1\]"),
        (lambda: sg.soft_disk(**DISK, color=(1, 2, 0)), r"color = .*3 numbers in \[0, 1\]"),
        (lambda: sg.soft_ellipse((0, 0, 0), (2, 1), angle="x"), "angle = 'x'"),
        (lambda: sg.engines(1e-4, bogus=1), "bogus is no attribute of SoftGrainIntegrator"),
        (lambda: sg.insert_before_solve(None), "None is no engine"),
        (lambda: sg.insert_before_solve(*[ForceEngine()] * 2), "comes twice, and would act twice"),
        (lambda: sg.soft_ellipse((0, 0, 0), (2, 1), exponent=3), "exponent = 3: .*sg.soft_disk"),
        (lambda: sg.grains_from_image(IMAGE, 1e-3, vertices=[]), "vertices = .*set by the image"),
        (lambda: sg.advance("3"), "steps = '3': .*whole number"),
        (lambda: sg.wall_force("3"), "body_id = '3': .*whole number"),
        (lambda: sg.soften([0], load=-7), r"load = -7 .*\[0, inf\)"),
        (lambda: sg.draw_packing(""), "path = '': .*name of a file"),
        (lambda: sg.draw_packing("p.png", box=(1, 0, 1, 0)), "box = .*xmin < xmax"),
        (lambda: sg.write_vtk(None), "prefix = None: .*beginning of a file's name"),
        (lambda: sg.write_vtk("p", what="spheres"), "what: 'spheres' is unknown; known: 'grains'"),
        (lambda: sg.write_vtk("p", what=3), "what: 3 is unknown"),
        (lambda: sg.write_vtk("p", what=[["grains"]]), r"what: \['grains'\] is unknown"),
        (lambda: sg.soften([0, 0]), "ids: #0 is given twice"),
        (lambda: sg.soften(i for i in [0]), "body #0 is neither a sphere"),
        (lambda: sg.soften([9]), "ids: there is no body #9"),
        (lambda: sg.soften([-1]), "ids: there is no body #-1"),
        (lambda: sg.as_disks([9]), "ids: there is no body #9"),
        (lambda: sg.harden([0, 0], into="clumps"), "ids: #0 is given twice"),
        (lambda: sg.harden([9]), "ids: there is no body #9"),
        (lambda: sg.draw_packing("p.png", box=(0, 1)), "box = .*4 finite numbers"),
        (lambda: sg.draw_packing("p.png", limits=(1,)), "limits = .*2 finite numbers"),
        (lambda: sg.draw_packing("p.png", scale=-1), r"scale = -1 .*\(0, inf\) Pa"),
        (lambda: sg.contact_halfwidth([0, 1], [1, -1]), r"force .*\[0, inf\)"),
        (lambda: sg.contact_halfwidth([0, 1], [1, math.inf]), r"force .*\[0, inf\)"),
        (lambda: sg.contact_profile(None), "interaction = None"),
        (lambda: sg.grain_area(None), "body = None is no soft grain"),
        (lambda: sg.soft_superdisk((0, 0, 0), (1, 1), "a"), "exponent = 'a' is of no type"),
        (lambda: sg.engines(1e-4, interface={"bondAtTouch": 2}), "bondAtTouch = 2; .*True, False"),
        (lambda: sg.wall_force(True), "body_id = True: admissible is a whole number"),
        (lambda: sg.soften([True]), "ids = .True.: admissible are whole numbers"),
        (lambda: sg.grains_from_image(None, 1e-3), "image = None: .*name of a file"),
        (lambda: sg.grains_from_image([[1]], 1, smoothing="a"), r"smoothing = 'a' .*\[0.5, 10\]"),
        (lambda: sg.draw_packing("p.png", dpi=1e9), r"dpi = 1000000000.0 .*\[10, 2400\]"),
        (lambda: sg.draw_packing("p.png", field=np.array(["a", "b"])), "field = .*is unknown"),
        (lambda: sg.contact_halfwidth([0, 1], [1, NAN]), r"force .*\[0, inf\)"),
        (lambda: sg.contact_halfwidth([0, NAN], [1, 1]), r"position .*\(-inf, inf\) m"),
        (lambda: sg.contact_halfwidth([0, 1], [1, 1, 1]), r"shapes \(2,\), \(3,\)"),
        (lambda: sg.soft_disk(("a", 0, 0), RADIUS), "center = .*3 finite numbers"),
        (lambda: sg.soft_disk(**DISK, material="foo"), "material = 'foo' is unknown; known: "),
        (lambda: sg.soft_disk(**DISK, material=99), "material = 99: .* which is empty"),
        (lambda: sg.soft_disk(**DISK, material=-5), "material = -5: .* which is empty"),
        (lambda: sg.soft_disk(**DISK, material=True), "material = True: admissible are a Material"),
        (lambda: sg.soft_disk(**DISK, material=np.zeros(2)), "material = array.*admissible are a"),
        (lambda: sg.SoftMat().waveImpedance(4), "dim = 4 is outside the admissible range 2, 3"),
        (lambda: sg.soft_polygon([(0, 0), (1, 0), (0, 1)], corners=[1.7]), "corners = .*whole"),
        (lambda: sg.soft_polygon([(0, 0), (1, 0), (1,)]), r"vertices: .*shape \(n, 2\)"),
        (lambda: sg.soft_block((0, 0, 0), 5), "size = 5: admissible are 2 or 3 numbers"),
        (lambda: sg.soft_ellipse((0, 0, 0), 0.01), "half_axes = 0.01: admissible are 2 numbers"),
        (lambda: sg.soften([10**20]), r"ids = \[10+\]: admissible are whole numbers in"),
        (lambda: sg.wall_force(10**20), "body_id = 10+: admissible is a whole number in"),
        (lambda: sg.soft_disk(**DISK, mask=2**40), "mask = 10995.*: admissible is a whole number"),
        (lambda: sg.soft_block((0, 0, 0), (1, 0.001)), "size = .*up to 100 times the shortest"),
        (lambda: sg.soft_ellipse((0, 0, 0), (1, 101)), "half_axes = .*up to 100 times the sh"),
        (lambda: sg.grains_from_image(IMAGE, 1.0, background="a"), "background = 'a': admissible"),
        (lambda: sg.grains_from_image(IMAGE, 1.0, corners=()), "corners = .*: set by the image"),
        (
            lambda: sg.grains_from_image(np.full((3, 3), 2**63, dtype=np.uint64), 1.0),
            "image: label 9223372036854775808; admissible",
        ),
        (lambda: sg.soften(0), "ids = 0: admissible are whole numbers"),
        (lambda: sg.soften([0.0]), "ids = .*: admissible are whole numbers"),
        (lambda: sg.soften([1], color=(1, 0, 0)), "color = .*keep that of their spheres"),
        (lambda: sg.soften([1], form="block"), "form = 'block': .*sg.soft_block"),
        (lambda: sg.as_disks([]), "ids: there is no sphere"),
        (lambda: sg.harden([0], FrictMat(), into="clumps", error="a"), r"error = 'a' .*\[0.002, "),
        (lambda: sg.packing_fraction("a"), r"box_area = 'a' .*\(0, inf\)"),
        (lambda: sg.scale_mass("a"), r"factor = 'a' .*\[1, inf\)"),
        (lambda: sg.scale_mass(2, materials=2.5), "materials = 2.5: .*SoftMats, one or more"),
        (lambda: sg.scale_mass(2, materials=[]), r"materials = \[\]: .*SoftMats, one or more"),
        (lambda: sg.engines(interface=3), "interface = 3: .*dict of attributes of Ip2_SoftPhys"),
        (lambda: sg.engines(interface=""), "interface = '': .*dict of attributes"),
        (lambda: sg.engines(maxSweeps=10**30), "maxSweeps = 10+ is of no type"),
        (lambda: sg.harden(into=[]), r"into = \[\] is unknown; known: 'spheres'"),
        (lambda: sg.solve_contact_problem(None), "problem = None: .*dict of arrays"),
        (lambda: sg.grains_from_image("", 1e-3), "image = '': .*name of a file"),
        (lambda: sg.contact_halfwidth("x", [1]), "position = 'x': .*array of numbers"),
        (lambda: sg.von_mises({}), "cauchy = {}: .*array of numbers"),
        (lambda: sg.soft_disk((0, 0, 0), 1e300), r"radius = 1e\+300: the volume"),
        (lambda: sg.von_mises(np.eye(2)), r"cauchy has shape \(2, 2\)"),
        (lambda: sg.draw_packing("p.png", limits=(1, 0)), "limits = .* below the second"),
        (lambda: sg.grains_from_image([[0.5]], 1), "image: float64"),
        (lambda: utils.growParticle(9, 2), "there is no body #9"),
    ],
)
def test_arguments(call, message):
    body = add_disk()
    with pytest.raises(ValueError, match=message):
        call()
    assert [b.id for b in O.bodies] == [body.id] and body.shape.form == "ball"


def test_soft_grains_do_not_grow():
    body = add_disk()
    with pytest.raises(ValueError, match="bodyID = 0: a SoftGrain does not grow"):
        utils.growParticle(body.id, 1.1)
    sphere = utils.sphere((5 * RADIUS, 0, 0), RADIUS, material=FrictMat())
    utils.growParticle(O.bodies.append(sphere), 1.1)
    assert sphere.shape.radius == pytest.approx(1.1 * RADIUS)


def test_scalars_of_numpy():
    """Wherever a number is asked for."""
    disk = sg.soft_disk(
        (0, 0, 0), np.float32(RADIUS), zeta=np.float64(0.25), order=np.int64(3), mask=np.int64(1)
    )
    O.bodies.append([disk, utils.wall(-RADIUS, axis=1, material=FrictMat())])
    law = {"frictAngle": np.float32(0.3)}
    O.engines = sg.engines(interface=law, maxSweeps=np.int64(99), tolerance=np.float32(1e-2))
    sg.set_time_step(np.float32(0.5))
    sg.advance(np.int64(2))
    assert sg.wall_force(np.int64(1)).shape == (3,)
    assert sg.integrator().maxSweeps == 99


@pytest.mark.parametrize("wrong", [{"vel": (NAN, 0, 0)}, {"ori": ((1, 0, 0), 0.5)}])
def test_refused_spheres_stay_as_they_were(wrong):
    """All of them, the ones before the one that is refused, too."""
    O.materials.append(FrictMat())
    O.bodies.append([utils.sphere((x * RADIUS, 0, 0), RADIUS) for x in (0, 3)])
    for body in O.bodies:
        body.state.vel, body.state.angVel = (1, 2, 3), (4, 5, 6)
    attribute, value = next(iter(wrong.items()))
    last = O.bodies[1].state
    setattr(last, attribute, Quaternion(*value) if attribute == "ori" else value)
    before = [(b.shape, b.material, b.state.mass) for b in O.bodies]
    inertia = [tuple(b.state.inertia) for b in O.bodies]
    with pytest.raises((ValueError, RuntimeError)):
        sg.soften([0, 1], material=sg.SoftMat(young=1e6), dim=2, zeta=0.25)
    assert [(b.shape, b.material, b.state.mass) for b in O.bodies] == before
    assert [tuple(b.state.inertia) for b in O.bodies] == inertia
    first = O.bodies[0].state
    assert (tuple(first.vel), tuple(first.angVel)) == ((1, 2, 3), (4, 5, 6))


def test_a_refused_value_is_refused_in_the_step_too():
    """YADE keeps it."""
    add_disk()
    O.engines = sg.engines()
    with pytest.raises(ValueError):
        sg.integrator().timeStepFraction = -1
    with pytest.raises(RuntimeError, match="timeStepFraction = -1"):
        O.step()


@pytest.mark.parametrize(
    "change",
    [
        sg.soften,
        sg.harden,
        sg.as_disks,
        lambda: sg.scale_mass(2),
        lambda: utils.growParticle(0, 2),
        sg.critical_time_step,
        sg.set_time_step,
    ],
)
def test_bodies_are_not_changed_under_a_run(change):
    """Which another thread is at."""
    O.materials.append(FrictMat())
    add_disk()
    O.engines = sg.engines()
    O.run()
    while O.iter == 0:  # YADE's thread ends the process where it begins after O.reset()
        time.sleep(1e-3)
    try:
        with pytest.raises(RuntimeError, match="background; call O.pause"):
            change()
    finally:
        O.pause()
