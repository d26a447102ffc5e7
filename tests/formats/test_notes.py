"""How input was taken that is not as it should be: in the warning, the plan, and files written of it."""

import json

import numpy as np
import pytest

from attitude import AttitudeWarning, Ephemeris, RigidBody, Scene, TorqueFreeMotion
from attitude.samples.resampling import BETWEEN_ATTITUDES_OF_A_FILE

from .texts import aem

ROWS = "2020-01-01T00:00:00 0.0 0.0 0.0 1.0\n2020-01-01T00:00:20 {0} 0.0 0.0 {0}"
EXACT, ROUNDED = (ROWS.format(root) for root in ("0.7071067811865476", "0.70711"))
FEW = "lengths of quaternions differ from 1 by up to"
DOCUMENT = {
    "body": {"moments": [1.0, 2.0, 2.5], "unit": "kg m2"},
    "attitude": {"quaternion": [0.70711, 0.70711, 0.0, 0.0002], "order": "wxyz"},
    "angular_velocity": {"value": [0.0, 0.1, 0.0], "unit": "rad/s"},
    "times": {"start": 0, "stop": 10, "step": 1, "unit": "s"},
}


@pytest.fixture(scope="module")
def lenient(tmp_path_factory):
    path = tmp_path_factory.mktemp("notes") / "few.aem"
    path.write_text(aem(ROUNDED))
    with pytest.warns(AttitudeWarning, match=FEW):
        return Ephemeris.read(path)


def test_plan_of_a_file_names_it_and_says_what_was_taken(lenient):
    assert "few.aem (aem)" in lenient.plan.solver
    assert lenient.plan.error_bound is None
    (note,) = lenient.plan.notes
    assert FEW in note
    assert "few.aem" in note


def test_plan_between_the_attitudes_of_a_file_repeats_the_notes(lenient):
    between = lenient.resampled(lenient.elapsed[:1] + 0.5)
    assert between.plan.notes == lenient.plan.notes
    assert between.plan.bound_source == BETWEEN_ATTITUDES_OF_A_FILE


def test_a_file_read_as_it_should_be_has_no_notes(tmp_path):
    path = tmp_path / "exact.aem"
    Scene.builtin("toutatis").run().in_frame("EME2000")[:20].write(path)
    assert Ephemeris.read(path).plan.notes == ()


@pytest.mark.parametrize(
    "ending", ["aem", "xml", "a", "czml", "csv", "json", "ecsv", "npz", "arrow", "parquet"]
)
def test_notes_go_with_the_attitudes_to_other_files(lenient, tmp_path, ending):
    path = tmp_path / f"other.{ending}"
    lenient.write(path)
    if ending in ("aem", "xml", "a", "czml"):
        assert FEW.encode() in path.read_bytes()
    else:
        assert Ephemeris.read(path).plan.notes == lenient.plan.notes


@pytest.mark.parametrize(
    ("metadata", "said"),
    [
        ({"REF_FRAME_A": "ITRF-97"}, "ITRF-97 is taken for ITRF"),
        ({"OBJECT_ID": None}, "no OBJECT_ID"),
        ({"STOP_TIME": "2020-01-01T00:00:19.9"}, "by less than a unit of its last digit"),
    ],
)
def test_what_is_taken_silently_is_in_the_plan(tmp_path, metadata, said):
    path = tmp_path / "silent.aem"
    path.write_text(aem(EXACT, **metadata))
    assert [said in note for note in Ephemeris.read(path).plan.notes] == [True]


def test_several_files_have_the_notes_of_all(tmp_path):
    first, second = tmp_path / "a.aem", tmp_path / "b.aem"
    first.write_text(aem(ROUNDED))
    second.write_text(
        aem(ROUNDED).replace("2020-01-01T00:0", "2020-01-01T00:1").replace("T00:11:00", "T00:20:00")
    )
    with pytest.warns(AttitudeWarning):
        notes = Ephemeris.read([first, second]).plan.notes
    assert ["a.aem" in notes[0], "b.aem" in notes[1]] == [True, True]


def test_plans_of_scenes_say_what_the_document_had():
    scene = Scene.model_validate(DOCUMENT)
    with pytest.warns(AttitudeWarning, match=FEW):
        plan = scene.plan()
    with pytest.warns(AttitudeWarning, match=FEW):
        ephemeris = scene.run()
    assert plan.notes == ephemeris.plan.notes
    assert len(plan.notes) == 1
    assert "attitude.quaternion" in plan.notes[0]
    assert plan.notes[0] in " ".join(plan.text().split())
    assert json.loads(json.dumps(plan.to_dict()))["notes"] == list(plan.notes)


def test_plans_of_scenes_under_torques_say_it_too():
    torque = {"type": "constant_torque", "torque": {"value": [0, 0, 1e-3], "unit": "N m"}, "frame": "body"}
    body = {"tensor": [[1.0, 1e-9, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.5]], "unit": "kg m2"}
    with pytest.warns(AttitudeWarning):
        notes = Scene.model_validate(DOCUMENT | {"effects": [torque], "body": body}).run().plan.notes
    assert [("symmetric" in note, "quaternion" in note) for note in notes] == [(True, False), (False, True)]


def test_motion_of_an_array_says_it():
    with pytest.warns(AttitudeWarning):
        motion = TorqueFreeMotion(RigidBody([1, 2, 2.5]), [0.70711, 0.70711, 0, 0], [0, 0.1, 0], order="wxyz")
    assert FEW in motion.at(np.arange(3.0)).plan.notes[0]


@pytest.mark.parametrize(
    ("ending", "options", "best", "about"),
    [
        ("bc", {}, {"type": 5, "degree": 15}, 14401),
        ("bc", {"type": 5}, {"type": 5, "degree": 15}, 119),
        ("aem", {}, {"degree": 11}, 211),
        ("a", {}, {"interpolation_order": 11}, 14401),
    ],
)
def test_writer_says_which_degree_would_do_with_fewer(tmp_path, ending, options, best, about):
    """Of Toutatis to 1e-6 rad; the number is that of the file which is then written so, within a tenth."""
    toutatis = Scene.builtin("toutatis").run().in_frame("EME2000")
    written = toutatis.write(tmp_path / f"one.{ending}", interpolation_error=1e-6, **options)
    better = toutatis.write(tmp_path / f"two.{ending}", interpolation_error=1e-6, **best)
    assert written.nodes == about
    names = ", ".join(f"{name}={value}" for name, value in best.items())
    assert written.advice.startswith(f"{names} would keep this error with about ")
    assert int(written.advice.split("about ")[1].split()[0]) == pytest.approx(better.nodes, rel=0.1)
    assert better.nodes < written.nodes


def test_no_degree_is_advised_across_segments(tmp_path):
    kick = {
        "type": "impulse",
        "time": {"value": 5, "unit": "s"},
        "frame": "body",
        "angular_impulse": {"value": [0, 0, 0.1], "unit": "N m s"},
    }
    epoch = {"time": "2026-01-01T00:00:00", "scale": "utc"}
    attitude = {"quaternion": [1.0, 0.0, 0.0, 0.0], "order": "wxyz"}
    scene = Scene.model_validate(DOCUMENT | {"effects": [kick], "epoch": epoch, "attitude": attitude})
    assert scene.write(tmp_path / "kick.a", interpolation_error=1e-6).advice is None
