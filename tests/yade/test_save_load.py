"""A saved run goes on, in a new process, bit by bit as it would have gone on."""

import hashlib

import compaction
import numpy as np
import pytest
from scenes import (
    RADIUS,
    add_disk,
    add_wall,
    assert_done,
    assert_same_bits,
    present_state,
    ready,
    run,
    run_python,
    soft_material,
)
from yade import O, Vector3

import softgrain as sg

FORMATS = ("yade.bz2", "xml.gz")
PHI = 0.85
STEPS = 200

CONTINUE = f"""
    import softgrain as sg
    from yade import O
    O.load("scene.%s")
    from scenes import present_state, run
    import numpy as np
    run({STEPS})
    np.savez("after.npz", **present_state())
    print("done")
"""


def compact_to(phi, folder):
    """The compaction case, coarse and with twelve grains, stopped in the middle."""
    options = compaction.parse_options(
        ["--grains", "12", "--mu", "0.3", "--zeta", "0.25", "--out", str(folder)]
    )
    box = compaction.prepare_rigid(options)
    compaction.make_soft(options)
    box.close(options.speed)
    while sg.packing_fraction(box.area) < phi:
        run(20)


@pytest.fixture(scope="module")
def stopped(tmp_path_factory):
    """Folder with the scene saved in both formats, and the state some steps later."""
    O.reset()
    folder = tmp_path_factory.mktemp("stopped")
    compact_to(PHI, folder)
    for suffix in FORMATS:
        O.save(str(folder / f"scene.{suffix}"))
    before = present_state()
    run(STEPS)
    after = present_state()
    assert sg.integrator().activeContacts > 20
    assert np.abs(after["nodes"] - before["nodes"]).max() > 0.01 * RADIUS
    assert (after["energies"] != 0).sum() >= 5
    yield folder, before, after
    O.reset()


def test_saving_changes_nothing(stopped):
    """Reading and saving in the middle of the run leaves no trace."""
    folder, _, after = stopped
    O.load(str(folder / "scene.yade.bz2"))
    for k in range(STEPS):
        run(1)
        if k % 50 == 20:
            O.save(str(folder / "other.yade.bz2"))
            sg.packing_fraction(1.0)
            present_state()
    assert_same_bits(present_state(), after)


@pytest.mark.parametrize("suffix", FORMATS)
def test_loaded_state(stopped, suffix):
    folder, before, _ = stopped
    O.load(str(folder / f"scene.{suffix}"))
    found = present_state()
    for name in ("nodes", "velocities", "bodies", "orientations", "time"):
        np.testing.assert_array_equal(found[name], before[name], err_msg=name)


def test_energy_right_after_loading(stopped):
    """The integrator still knows the energies it had when saved."""
    folder, before, _ = stopped
    O.load(str(folder / "scene.xml.gz"))
    np.testing.assert_allclose(present_state()["energies"], before["energies"], rtol=1e-12)


@pytest.mark.parametrize("formulation", ("total", "updated"))
def test_energy_of_a_grain_right_after_loading(formulation, tmp_path):
    """In its present shape, which the next step tells of before it moves it."""
    add_disk(formulation=formulation).state.vel = (0, -1, 0)
    add_wall(-RADIUS, 1)
    ready()
    run(40)
    O.save(str(tmp_path / "scene.yade.gz"))
    O.load(str(tmp_path / "scene.yade.gz"))
    loaded = sg.quasi_static()["elastic"]
    run(1)
    assert loaded == pytest.approx(sg.quasi_static()["elastic"], rel=1e-9)
    assert loaded > 0


@pytest.mark.parametrize("suffix", FORMATS)
def test_goes_on_in_the_same_process(stopped, suffix):
    folder, _, after = stopped
    O.load(str(folder / f"scene.{suffix}"))
    run(STEPS)
    assert_same_bits(present_state(), after)


@pytest.mark.parametrize("suffix", FORMATS)
def test_goes_on_in_a_new_process(stopped, suffix):
    folder, _, after = stopped
    assert_done(run_python(CONTINUE % suffix, folder))
    with np.load(folder / "after.npz") as found:
        assert_same_bits(dict(found), after)


def test_kept_in_memory(stopped):
    folder, _, after = stopped
    O.load(str(folder / "scene.yade.bz2"))
    O.saveTmp("stopped")
    run(20)
    O.loadTmp("stopped")
    run(STEPS)
    assert_same_bits(present_state(), after)


def test_saved_file_is_the_same_after_loading(stopped):
    """Loading and saving again adds or loses nothing."""
    folder, _, _ = stopped
    digests = []
    for k in range(2):
        O.load(str(folder / ("scene.xml.gz" if k == 0 else "again0.xml")))
        O.save(str(folder / f"again{k}.xml"))
        digests.append(hashlib.sha256((folder / f"again{k}.xml").read_bytes()).hexdigest())
    assert digests[0] == digests[1]


def test_before_the_first_step(tmp_path):
    """A scene that was saved undeformed starts alike."""
    disk = add_disk()
    disk.state.vel, disk.state.angVel = (1, 2, 0), (0, 0, 30)
    add_wall(-1.02 * RADIUS, 0, friction=0.3)
    ready()
    O.save(str(tmp_path / "scene.yade.bz2"))
    run(50)
    after = present_state()
    O.load(str(tmp_path / "scene.yade.bz2"))
    run(50)
    assert_same_bits(present_state(), after)


METHODS = (
    {"velocityUpdate": "flip"},
    {"formulation": "updated"},
    {"formulation": "updated", "picShare": 0.1, "order": 2},
)


@pytest.mark.parametrize("suffix", FORMATS)
@pytest.mark.parametrize("method", METHODS, ids=str)
def test_other_methods_go_on(method, suffix, tmp_path):
    """Velocities and deformation gradients that live at the points are saved too."""
    for x, velocity in ((0, 2), (2.01 * RADIUS, -1)):
        disk = add_disk((x, 0, 0), **method)
        disk.state.vel = (velocity, 0, 0)
        disk.state.angVel = (0, 0, 50)
    add_wall(-1.01 * RADIUS, 1, friction=0.3, velocity=(0, 1, 0))
    ready()
    O.trackEnergy = True
    run(20)
    assert sg.integrator().activeContacts > 0
    O.save(str(tmp_path / f"scene.{suffix}"))
    run(60)
    after = present_state()
    O.load(str(tmp_path / f"scene.{suffix}"))
    shape = sg.soft_bodies()[0].shape
    assert {name: getattr(shape, name) for name in method} == method
    run(60)
    assert_same_bits(present_state(), after)


def test_cohesion_acts_after_loading_where_it_did_before(tmp_path):
    """The boxes of grains reach as far as their surfaces look for each other: contacts of a pair
    do not depend on when the collider ran last."""
    disk = add_disk((0, 1.3 * RADIUS, 0))
    disk.state.vel = (0, -2, 0)
    add_wall(0, 1)
    ready(interface={"cohesion": 1e3, "cohesionRange": 0.01 * RADIUS})
    O.saveTmp()
    while O.interactions.countReal() == 0:
        run(1)
    first_contact = O.iter
    run(5)
    after = present_state()
    for before in range(1, first_contact, first_contact // 10):
        O.loadTmp()
        run(before)
        O.save(str(tmp_path / "scene.xml.gz"))
        O.load(str(tmp_path / "scene.xml.gz"))
        run(first_contact + 5 - before)
        assert_same_bits(present_state(), after)


def test_users_motion_before_saving(tmp_path):
    """What the user changed since the last step is not lost."""
    disk = add_disk()
    disk.state.vel = (1, 0, 0)
    ready()
    run(20)
    disk.state.vel = (0, 3, 0)
    disk.state.pos += Vector3(0.01, 0, 0)
    O.save(str(tmp_path / "scene.xml.gz"))
    expected = np.array(disk.state.pos) + O.dt * np.array((0, 3, 0))
    O.load(str(tmp_path / "scene.xml.gz"))
    run(1)
    body = O.bodies[0]
    np.testing.assert_allclose(body.state.vel, (0, 3, 0), atol=1e-9)
    np.testing.assert_allclose(body.state.pos, expected, atol=1e-9)


def test_saved_time_step_of_the_user(tmp_path):
    add_disk()
    ready()
    run(5)
    O.dt = chosen = 0.2 * sg.critical_time_step()
    run(2)
    O.save(str(tmp_path / "scene.xml.gz"))
    O.load(str(tmp_path / "scene.xml.gz"))
    run(5)
    assert O.dt == chosen


def test_saved_in_the_middle_of_a_step(tmp_path):
    """The next engine is the integrator, and the functors of the contacts are not there."""
    add_disk((0, 0.99 * RADIUS, 0))
    add_wall(0, 1)
    ready()
    run(10)
    O.subStepping = True
    while not isinstance(O.engines[O.subStep], sg.SoftGrainIntegrator):
        O.step()
    O.save(str(tmp_path / "half.yade.gz"))
    O.load(str(tmp_path / "half.yade.gz"))
    with pytest.raises(RuntimeError, match="save between steps"):
        O.step()


def test_order_of_grains_that_changes_after_loading(tmp_path):
    """It goes by recipe, law and condition; contacts and bonds stay with their grains."""
    found = []
    for loads in (False, True):
        O.reset()
        kinds = [soft_material(condition="planeStress", label=name) for name in ("here", "there")]
        O.materials.append(kinds)
        for kind, x in zip(kinds, (0, 1.99 * RADIUS)):
            add_disk((x, 0, 0), material=kind)
        ready(interface=dict(bondStrength=1e4, bondEnergy=1.0))
        run(400)
        if loads:
            O.save(str(tmp_path / "scene.yade.gz"))
            O.load(str(tmp_path / "scene.yade.gz"))
        O.materials["there"].condition = "planeStrain"
        run(1)
        (pair,) = [i for i in O.interactions if i.isReal]
        contacts = pair.geom.contacts()
        found.append((sg.integrator().lostBonds, pair.geom.first, *map(list, (
            contacts["side"], contacts["node"], contacts["bond"], contacts["impulse"][:, 0]
        ))))
    assert found[0] == found[1]
    assert found[0][0] == 0 and sum(found[0][4]) > 0
