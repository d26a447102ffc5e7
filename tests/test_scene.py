"""The scene document: what it means, and every fault refused with path, value and what would be right."""

import contextlib
import copy
import json
import math
from fractions import Fraction
from itertools import product

import jsonschema
import numpy as np
import pytest
from astropy.time import Time
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from attitude import (
    AttitudeError,
    FormatError,
    InputError,
    RigidBody,
    Scene,
    ToleranceError,
    TorqueFreeMotion,
)
from attitude.scene import Times, document_parts
from attitude.scene.builtin_scenes import builtin_names
from attitude.times.instants import Instants
from tests.bodies import ATTITUDE, ATTITUDE_TOLERANCE
from tests.effects import scenes as effect_scenes
from tests.effects.scenes import quantity
from tests.tables import GONE, assert_refused, refusals, replaced

DOCUMENT = {
    "name": "debris",
    "body": {"moments": [1.0, 1.6, 2.1], "unit": "kg m2"},
    "epoch": {"time": "2020-01-01T00:00:00", "scale": "utc"},
    "frame": "GCRF",
    "attitude": {"quaternion": list(ATTITUDE), "order": "wxyz"},
    "angular_velocity": {"value": [0.3, -0.5, 0.9], "unit": "rad/s"},
    "times": {"start": 0, "stop": 60, "step": 0.5, "unit": "s"},
    "effects": [],
}
# One product of a value with its unit, rounded; one part in 2^100 where both parts are kept.
UNIT_ROUNDING = 2.0**-52
TWO_PART_TOLERANCE = 2.0**-100


def changed(**parts):
    return replaced(copy.deepcopy(DOCUMENT), parts)


def run(**parts):
    return Scene.model_validate(changed(**parts)).run()


def at_epoch(**parts):
    """R of the attitude at the epoch."""
    return run(times={"elapsed": [0], "unit": "s"}, **parts).rotation[0].as_matrix()


# -- what a document means ----------------------------------------------------------------------


def test_scene_is_the_motion_it_describes():
    ephemeris = run()
    motion = TorqueFreeMotion(
        RigidBody((1.0, 1.6, 2.1)), ATTITUDE, (0.3, -0.5, 0.9), Time("2020-01-01", scale="utc"), order="wxyz"
    )
    expected = motion.at(np.arange(121) * 0.5)
    assert np.array_equal(ephemeris.quaternion("wxyz"), expected.quaternion("wxyz"))
    assert np.array_equal(ephemeris.angular_velocity, expected.angular_velocity)
    assert (ephemeris.name, ephemeris.frame) == ("debris", "GCRF")
    assert ephemeris.epoch == motion.epoch


def test_euler_angles_carry_inertial_axes_onto_body_axes_one_after_another():
    # a quarter turn about Z carries X onto Y; one about the new X then carries Z onto the old X
    R = at_epoch(attitude={"euler": [90, 90, 0], "sequence": "ZXZ", "unit": "deg"})
    x_body, y_body, z_body = R.T
    assert np.allclose([x_body, y_body, z_body], [[0, 1, 0], [0, 0, 1], [1, 0, 0]], atol=ATTITUDE_TOLERANCE)


SEQUENCES = ["".join(axes) for axes in product("XYZ", repeat=3) if axes[0] != axes[1] != axes[2]]


@pytest.mark.parametrize("sequence", SEQUENCES)
def test_euler_angles_of_any_sequence_are_scipys_intrinsic_ones(sequence):
    for angles in ([20.0, -75.0, 130.0], [-179.0, 181.0, 361.0], [0.0, 90.0, 0.0], [0.0, 0.0, 0.0]):
        R = at_epoch(attitude={"euler": angles, "sequence": sequence, "unit": "deg"})
        expected = Rotation.from_euler(sequence, angles, degrees=True).as_matrix()
        assert np.abs(R - expected).max() <= 4 * ATTITUDE_TOLERANCE


@pytest.mark.parametrize("angle", [0.0, 1e-9, 1.0, 3.0, 3.2, 6.0])
def test_every_form_of_one_attitude_is_the_same_attitude(angle):
    rotation = Rotation.from_rotvec(angle * np.array([2.0, -1.0, 2.0]) / 3)
    sequence = "ZXZ" if angle > 1e-3 else "XYZ"
    forms = [
        {"quaternion": rotation.as_quat().tolist(), "order": "xyzw"},
        {"quaternion": rotation.as_quat(scalar_first=True).tolist(), "order": "wxyz"},
        {"matrix": rotation.as_matrix().tolist()},
        {"mrp": rotation.as_mrp().tolist()},
        # beyond half a turn: longer than 1
        {"mrp": (np.tan(angle / 4) * np.array([2.0, -1.0, 2.0]) / 3).tolist()},
        {"euler": rotation.as_euler(sequence).tolist(), "sequence": sequence, "unit": "rad"},
    ]
    for form in forms:
        assert np.abs(at_epoch(attitude=form) - rotation.as_matrix()).max() <= 4 * ATTITUDE_TOLERANCE


@pytest.mark.parametrize("length", [1e9, 1e160, 1e300])
def test_rodrigues_parameters_however_long_are_all_but_a_whole_turn(length):
    R = at_epoch(attitude={"mrp": [0, length, 0]})
    assert np.abs(R - np.eye(3)).max() <= 4 / length + ATTITUDE_TOLERANCE


def test_numbers_are_in_the_unit_beside_them():
    scene = Scene.model_validate(
        changed(
            body={"moments": [1.0, 1.6, 2.1], "unit": "g cm2"},
            angular_velocity={"value": [1.0, 2.0, 3.0], "unit": "deg/h"},
        )
    )
    motion = scene.motion()
    assert motion.body.moments == pytest.approx(np.array([1.0, 1.6, 2.1]) * 1e-7, rel=UNIT_ROUNDING)
    rate = motion.at(0.0).angular_velocity
    assert rate == pytest.approx(np.radians([1.0, 2.0, 3.0]) / 3600, rel=ATTITUDE_TOLERANCE)


def test_tensor_is_taken_as_a_tensor():
    tensor = [[199.0, 0.6, -0.2], [0.6, 201.0, 0.1], [-0.2, 0.1, 262.0]]
    scene = Scene.model_validate(changed(body={"tensor": tensor, "unit": "kg m2"}))
    assert scene.motion().body.tensor.tolist() == tensor


TENTH, THREE_TENTHS = Fraction(0.1), Fraction(0.3)


def grid(start=0, stop=60, unit="s", **more):
    return {"times": {"start": start, "stop": stop, "unit": unit, **more}}


def times(**form):
    return {"times": form}


GRIDS = {
    "step": (grid(0, 1, step=0.1), [k * TENTH for k in range(11)]),
    "step rounded past stop": (grid(0, 0.9, step=0.3), [k * THREE_TENTHS for k in range(4)]),
    "step rounded before stop": (grid(0, 0.3, step=0.1), [k * TENTH for k in range(4)]),
    "span rounded below its steps": (grid(1000, 1000.3, step=0.1), [1000 + k * TENTH for k in range(4)]),
    "stop between steps": (grid(0, 0.99, step=0.1), [k * TENTH for k in range(10)]),
    "step over no span": (grid(5, 5, "min", step=1), [300]),
    "start before the epoch": (grid(-2, 2, "h", step=3), [-7200, 3600]),
    "count": (grid(0, 1, "d", count=4), [0, 28800, 57600, 86400]),
    "count of both ends": (grid(-0.1, 0.1, count=2), [-TENTH, TENTH]),
    "count of one": (grid(7, 7, count=1), [7]),
    "count over no span": (grid(7, 7, count=3), [7, 7, 7]),
    "from the epoch": (times(stop=1, step=0.5, unit="min"), [0, 30, 60]),
    "minutes": (times(elapsed=[3, 0.1, -2], unit="min"), [180, 60 * TENTH, -120]),
    "days": (times(elapsed=[0.1], unit="d"), [86400 * TENTH]),
    "milliseconds": (times(elapsed=[0.1], unit="ms"), [TENTH / 1000]),
}


@pytest.mark.parametrize(("parts", "seconds"), GRIDS.values(), ids=GRIDS)
def test_times_are_exact_in_two_parts(parts, seconds):
    instants = run(**parts).instants
    rest = np.zeros(instants.shape) if instants.seconds_low is None else instants.seconds_low
    assert len(instants.seconds) == len(seconds)
    for high, low, exact in zip(instants.seconds.tolist(), rest.tolist(), seconds, strict=True):
        assert abs(Fraction(high) + Fraction(low) - exact) <= TWO_PART_TOLERANCE * abs(exact)


@pytest.mark.parametrize("last", [1e6, 123456.789, 1e-7])
def test_counted_grid_ends_where_it_says(last):
    instants = run(times={"start": 0.1, "stop": last + 0.1, "count": 1001, "unit": "s"}).instants
    assert (instants.seconds[0], instants.seconds[-1]) == (0.1, last + 0.1)


BETWEEN_DATES = {
    "leap second": (
        {"start": "2016-12-31T23:59:30", "stop": "2017-01-01T00:00:29.5", "step": 30, "unit": "s"},
        ["2016-12-31T23:59:30", "2016-12-31T23:59:60", "2017-01-01T00:00:29"],
    ),
    "hours": (
        {"start": "2016-12-31T23:00:00.25", "stop": "2017-01-01T00:30:00", "step": 1, "unit": "h"},
        ["2016-12-31T23:00:00.25", "2016-12-31T23:59:60.25"],
    ),
    "count": (
        {"start": "2016-12-01", "stop": "2016-12-03", "count": 3},
        ["2016-12-01", "2016-12-02", "2016-12-03"],
    ),
    "one date": ({"start": "2020-02-29", "stop": "2020-02-29", "count": 1}, ["2020-02-29"]),
}


@pytest.mark.parametrize(("limits", "dates"), BETWEEN_DATES.values(), ids=BETWEEN_DATES)
@pytest.mark.parametrize("epoch", ["2016-12-30T12:00:00", "1976-01-01T00:00:00.1"])
def test_grid_between_dates_is_the_same_as_its_dates_listed(limits, dates, epoch):
    parts = {"epoch": {"time": epoch, "scale": "utc"}}
    ephemeris = run(**parts, times={**limits, "scale": "utc"})
    listed = run(**parts, times={"dates": dates, "scale": "utc"})
    assert len(ephemeris) == len(listed)
    assert np.abs((ephemeris.time - listed.time).sec).max() < 1e-10  # astropy's own dates are as exact


@pytest.mark.parametrize("scale", ["utc", "tai", "tt", "tdb"])
def test_dates_are_in_their_own_scale(scale):
    ephemeris = run(
        times={"dates": ["2020-01-01T00:00:00", "2020-01-02 12:00:00.5", "2020-01-03"], "scale": scale}
    )
    assert ephemeris.time.scale == scale
    expected = Time(["2020-01-01T00:00:00.0", "2020-01-02T12:00:00.5", "2020-01-03T00:00:00.0"], scale=scale)
    assert np.abs((ephemeris.time - expected).sec).max() == 0.0
    assert np.abs((expected.tai - Time("2020-01-01", scale="utc").tai).sec - ephemeris.elapsed).max() < 1e-9


def test_date_of_utc_may_end_in_z_and_be_a_leap_second():
    dates = ["2016-12-31T23:59:60Z", "2017-01-01T00:00:00Z"]
    epoch = {"time": "2016-12-31T23:59:59Z", "scale": "utc"}
    elapsed = run(epoch=epoch, times={"dates": dates, "scale": "utc"}).elapsed
    assert np.abs(elapsed - [1, 2]).max() < 1e-9


FORMS = {
    "2017-001T00:00:30": "2017-01-01T00:00:30",
    "2017001T000030Z": "2017-01-01T00:00:30",
    "2016-12-31T18:59:60.5-05:00": "2016-12-31T23:59:60.5",
    "2017-01-01T05:29:60+0530": "2016-12-31T23:59:60",
    "2017-01-01T01:00+01": "2017-01-01T00:00:00",
    "20170101": "2017-01-01",
}


@pytest.mark.parametrize(("text", "date"), FORMS.items())
def test_dates_of_other_forms_are_the_same_instants(text, date):
    """A day of the year, no separators, an offset from UTC, by which leap seconds are not lost."""
    one, other = (run(epoch={"time": each, "scale": "utc"}).epoch for each in (text, date))
    assert abs((one - other).sec) < 1e-12


def test_epoch_and_frame_may_be_left_out():
    ephemeris = run(epoch=GONE, frame=GONE, name=GONE, effects=GONE)
    assert (ephemeris.epoch, ephemeris.frame, ephemeris.name) == (None, "ICRF", "")


# -- in and out ---------------------------------------------------------------------------------


@pytest.mark.parametrize("name", builtin_names())
def test_built_in_scene_runs_and_says_where_it_comes_from(name):
    scene = Scene.builtin(name)
    assert scene.name
    assert scene.description
    ephemeris = scene.run()
    assert len(ephemeris) == scene.times.samples > 50
    assert np.isfinite(ephemeris.quaternion("wxyz")).all()
    assert np.isfinite(ephemeris.angular_velocity).all()


@pytest.mark.parametrize("name", builtin_names())
def test_document_comes_back_as_it_was(name):
    scene = Scene.builtin(name)
    again = Scene.from_json(scene.to_json())
    assert again == scene
    assert again.document() == scene.document()
    assert again.to_json() == scene.to_json()


def test_document_holds_what_was_given_and_no_more():
    document = changed(epoch=GONE, frame=GONE)
    assert Scene.model_validate(document).document() == document
    assert Scene(**document) == Scene.model_validate(document)


def test_scene_does_not_change():
    scene = Scene.model_validate(DOCUMENT)
    with pytest.raises(Exception, match="frozen"):
        scene.name = "other"


# -- faults of a document -----------------------------------------------------------------------


@pytest.mark.parametrize(("parts", "pointer", "message"), refusals("scene_refusals"))
def test_fault_is_refused_with_a_pointer_into_the_document(parts, pointer, message):
    error = assert_refused(lambda: run(**parts), pointer, message)
    part, last = parent(changed(**parts), pointer)
    assert error.value is None or holds(part, last)


def test_number_of_hundreds_of_digits_is_refused_by_its_pointer():
    body = {"moments": [10**400, 1, 1], "unit": "kg m2"}
    assert_refused(lambda: run(body=body), "/body/moments/0", "a number in the range of a double")


def parent(document, pointer):
    """What the pointer goes through, and its last step."""
    *inner, last = [step.replace("~1", "/").replace("~0", "~") for step in pointer.split("/")[1:]]
    for step in inner:
        document = document[int(step)] if isinstance(document, list) else document[step]
    return document, last


def holds(part, step):
    return int(step) < len(part) if isinstance(part, list) else step in part


@pytest.mark.parametrize(
    "tensor",
    [[[1, 0.5, 0], [0.5, 1, 0], [0, 0, 3]], [[1, 2, 0], [2, 1, 0], [0, 0, 1]]],
    ids=["triangle", "negative"],
)
def test_tensor_without_a_body_is_refused_as_a_tensor(tensor):
    with pytest.raises(InputError, match=r"positive principal moments|no principal moment greater") as caught:
        run(body={"tensor": tensor, "unit": "kg m2"})
    assert caught.value.pointer.startswith("/body/tensor")


@pytest.mark.parametrize("document", [None, [], 5, "scene", {1: 2}], ids=str)
def test_document_that_is_no_object_is_refused_as_a_whole(document):
    assert_refused(lambda: Scene.model_validate(document), "", "a JSON object")


def test_other_faults_are_named_beside_the_first():
    with pytest.raises(InputError, match=r"^body: .* \(also missing: times\)$"):
        Scene()
    listed = r"^colour: .* \(also body.moments\[0\]: a number; missing: body.unit; solver: one of .*\)$"
    with pytest.raises(InputError, match=listed):
        Scene.model_validate(changed(body={"moments": ["1", 1, 1]}, colour="red", solver="best"))


def test_many_faults_are_counted_and_few_are_listed():
    with pytest.raises(InputError, match=r"also unknown: .*; and 81 more\)$") as caught:
        Scene.model_validate(changed(**{f"colour{i}": "red" for i in range(101)}))
    assert str(caught.value).count("colour") == 21  # the first stands twice, by its field and its name


def test_faulty_list_of_instants_is_refused_at_its_first_fault():
    with pytest.raises(InputError, match=r"^times.elapsed\[0\]: a number; got ''$"):
        Scene.model_validate(changed(times={"elapsed": [""] * 100, "unit": "s"}))


def test_twin_of_a_key_among_many_is_found_at_once():
    """A count for each key took half a minute."""
    keys = "".join(f'"k{i}": 0, ' for i in range(100_000))
    with pytest.raises(InputError, match="k99999: each key once"):
        Scene.from_json(f'{{{keys}"k99999": 1}}')


@pytest.mark.parametrize(
    ("parts", "message"),
    [
        ({"efects": []}, r"^efects: unknown key 'efects'; did you mean 'effects'\?; got \[\]$"),
        ({"body": {"momnts": [1, 1, 1], "unit": "kg m2"}}, r"^body.momnts: .* did you mean 'moments'\?"),
        (
            {"effects": [{"type": "drag", "plats": []}]},
            r"^effects\[0\].plats: .*did you mean 'plates'",
        ),
        ({"orbit": {"inclinaton": 1}}, r"^orbit.inclinaton: .*did you mean 'inclination'\?"),
        ({"orbit": {"tle": [], "tles": 1}}, r"^orbit.tles: .*did you mean 'tle'\?"),
        (
            {"orbit": {"times": {"vlaue": 1}, "positions": {}}},
            r"^orbit.times.vlaue: .*did you mean 'value'\?",
        ),
        ({"orbit": {"positions": {"extra": 1}, "x": 1}}, r"^orbit.*unknown key"),
        ({"FRAME": "ICRF"}, r"^FRAME: .*did you mean 'frame'\?"),
        ({"zzz": 1}, r"^zzz: unknown key 'zzz'; known: scene, name, description, body"),
    ],
    ids=str,
)
def test_unknown_key_is_answered_with_the_one_that_was_meant(parts, message):
    with pytest.raises(InputError, match=message):
        Scene.model_validate(changed(**parts))


# -- a built-in scene by its name ---------------------------------------------------------------


def test_members_are_laid_over_the_scene_that_a_document_names():
    times = {"elapsed": [0, 1], "unit": "d"}
    scene = Scene.model_validate({"scene": "toutatis", "times": times})
    assert scene == Scene.model_validate(Scene.builtin("toutatis").document() | {"times": times})
    assert Scene.from_json(scene.to_json()) == scene
    assert "scene" not in scene.document()
    assert Scene(scene="toutatis") == Scene.builtin("toutatis")


@pytest.mark.parametrize("name", [None, 5, ["toutatis"], {}, "tutatis", ""], ids=str)
def test_name_of_no_scene_is_refused(name):
    message = "did you mean 'toutatis'" if name in ("tutatis", ["toutatis"]) else "known: basilisk, "
    assert_refused(lambda: Scene.model_validate({"scene": name}), "/scene", message)


def test_fault_beside_the_name_of_a_scene_is_refused_by_its_own_pointer():
    assert_refused(
        lambda: Scene.model_validate({"scene": "toutatis", "body": {"moments": [1, 1], "unit": "kg m2"}}),
        "/body/moments",
        "3 elements",
    )


def test_schema_requires_of_a_document_that_names_a_scene_nothing_else():
    schema = Scene.model_json_schema()
    assert schema["properties"]["scene"]["enum"] == builtin_names()
    validator = jsonschema.Draft202012Validator(schema)
    assert validator.is_valid({"scene": "toutatis"})
    assert validator.is_valid(DOCUMENT)
    assert not validator.is_valid({"scene": "pluto"})
    assert not validator.is_valid({"name": "x"})


def test_scene_made_in_python_is_refused_as_a_document_is():
    assert_refused(lambda: Scene(**DOCUMENT, colour="red"), "/colour", "unknown key 'colour'")


# -- too much -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "instants",
    [
        grid(0, 1e15, step=1),
        grid(count=10**15),
        times(elapsed=list(range(1001)), unit="s"),
        times(dates=["2020-01-01"] * 1001, scale="utc"),
    ],
    ids=["step", "count", "elapsed", "dates"],
)
def test_too_many_samples_are_refused_before_they_are_made(instants):
    scene = Scene.model_validate(changed(**instants))
    assert scene.times.samples > 1000
    message = f"at most 1000 samples; got '{scene.times.samples} samples'"
    assert_refused(lambda: scene.run(max_samples=1000), "/times", message)


def test_as_many_samples_as_the_limit_are_computed():
    assert len(Scene.model_validate(changed(**grid(0, 999, step=1))).run(max_samples=1000)) == 1000


@pytest.mark.parametrize("count", [2**53, 2**62, 10**30])
def test_more_samples_than_any_memory_holds_are_refused(count):
    with pytest.raises(InputError) as caught:
        run(**grid(count=count))
    assert caught.value.pointer.startswith("/times")


@pytest.mark.parametrize("rate", [[0.3, -0.5, 0.9], [0, 0, 0]], ids=["moving", "still"])
@pytest.mark.parametrize(
    "instants",
    [
        grid(-1e308, 1e308, count=3),
        grid(-1e308, 1e308, step=1e308),
        grid(0, 1e308, unit="d", count=3),
        times(elapsed=[0, 1e305], unit="d"),
        times(elapsed=[0, 1e302], unit="Gyr"),
    ],
    ids=["span overflows", "step overflows", "unit overflows", "value overflows", "value overflows by far"],
)
def test_times_that_no_double_holds_never_become_nan(instants, rate):
    try:
        ephemeris = run(**instants, angular_velocity={"value": rate, "unit": "rad/s"})
    except (InputError, ToleranceError):
        return
    assert np.isfinite(ephemeris.quaternion("wxyz")).all()
    assert np.isfinite(ephemeris.elapsed).all()


def test_time_too_far_for_the_phases_names_the_limit():
    with pytest.raises(ToleranceError, match=r"is beyond .* s"):
        run(**grid(0, 1e20, count=3, unit="d"))


# -- JSON text ----------------------------------------------------------------------------------

TEXT = json.dumps(DOCUMENT)

TEXTS = {
    "NaN": (TEXT.replace("1.6", "NaN"), "finite numbers .*; got 'NaN'"),
    "Infinity": (TEXT.replace("1.6", "Infinity"), "finite numbers .*; got 'Infinity'"),
    "-Infinity": (TEXT.replace("1.6", "-Infinity"), "finite numbers .*; got '-Infinity'"),
    "number beyond a double": (TEXT.replace("1.6", "1e400"), r"body.moments\[1\]: a finite number"),
    "key twice": (
        TEXT.replace('"frame"', '"name": "x", "frame"'),
        "name: each key once; got 'the key twice'",
    ),
    "inner key twice": (TEXT.replace('"order"', '"order": "xyzw", "order"'), "order: each key once"),
    "a list": ("[]", "a JSON object"),
}
NOT_JSON = {
    "number of 5000 digits": (TEXT.replace("1.6", "1" * 5000), "not JSON that can be read.*5000 digits"),
    "cut": (TEXT[:-1], "line 1: not JSON"),
    "cut in a later line": ("{\n\n" + TEXT[1:-20], "line 3: not JSON"),
    "empty": ("", "line 1: not JSON"),
    "more than JSON": (TEXT + "x", "line 1: not JSON: Extra data"),
    "comment": ("// scene\n" + TEXT, "line 1: not JSON"),
    "bytes that are no text": (b"\xff\xff" + TEXT.encode(), "not JSON"),
    "lists without end": ("[" * 100_000, "not JSON that can be read: nested too deeply"),
    "objects without end": ('{"a":' * 100_000, "not JSON that can be read: nested too deeply"),
}


@pytest.mark.parametrize(("text", "message"), TEXTS.values(), ids=TEXTS)
def test_json_that_is_no_scene_is_refused(text, message):
    with pytest.raises(InputError, match=message) as caught:
        Scene.from_json(text, "a.json")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(("text", "message"), NOT_JSON.values(), ids=NOT_JSON)
def test_text_that_is_no_json_is_refused_by_file(text, message):
    with pytest.raises(FormatError, match=message) as caught:
        Scene.from_json(text, "a.json")
    assert "\n" not in str(caught.value)
    assert caught.value.source == "a.json"
    assert str(caught.value).startswith("a.json")


@pytest.mark.parametrize("depth", [10, 100, 500, 900, 990])
def test_nesting_of_any_depth_is_refused(depth):
    nested = "[" * depth + "]" * depth
    with pytest.raises(AttitudeError):
        Scene.from_json(TEXT.replace('"effects": []', f'"effects": {nested}'))


EDGES = [
    None,
    True,
    "",
    "s",
    0,
    -1,
    0.5,
    1e-320,
    1e308,
    -1e308,
    10**400,
    2**63,
    float("nan"),
    [],
    {},
    [0, 0, 0],
]
JUNK = st.recursive(
    st.sampled_from(EDGES) | st.floats() | st.integers() | st.text(max_size=9),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=3), inner, max_size=3),
    max_leaves=5,
)
FORMS = [
    {},
    {"body": {"tensor": [[2, 0.1, 0], [0.1, 2, 0], [0, 0, 3]], "unit": "kg m2"}},
    {"attitude": {"euler": [1, 2, 3], "sequence": "ZXZ", "unit": "deg"}},
    {"attitude": {"matrix": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}},
    {"attitude": {"mrp": [0.1, 0.2, 0.3]}},
    grid(count=5),
    times(elapsed=[1, 2, 3], unit="s"),
    times(dates=["2020-01-01", "2020-01-02"], scale="utc"),
]


def members(part):
    """Every member of a document, at any depth, as (container, key)."""
    items = part.items() if isinstance(part, dict) else enumerate(part) if isinstance(part, list) else ()
    for key, inner in list(items):
        yield part, key
        yield from members(inner)


@pytest.mark.filterwarnings("ignore::attitude.AttitudeWarning")
@pytest.mark.filterwarnings("ignore:ERFA function:erfa.ErfaWarning")
@settings(max_examples=600, deadline=None, database=None, derandomize=True)
@given(
    st.sampled_from(FORMS),
    st.lists(st.tuples(st.floats(0, 1, exclude_max=True), JUNK), min_size=1, max_size=2),
)
def test_any_junk_in_a_document_is_refused_or_gives_attitudes(form, junk):
    document = changed(**copy.deepcopy(form))
    for fraction, value in junk:
        candidates = list(members(document))
        part, key = candidates[int(fraction * len(candidates))]
        part[key] = copy.deepcopy(value)
    with contextlib.suppress(AttitudeError):
        ephemeris = Scene.model_validate(document).run(max_samples=1000)
        assert np.isfinite(ephemeris.quaternion("wxyz")).all()
        assert np.isfinite(ephemeris.angular_velocity).all()


@pytest.mark.parametrize(
    "path", ["missing.json", ".", "a\0.json", "x" * 300], ids=["missing", "folder", "null", "long"]
)
def test_file_that_cannot_be_read_is_named(path, tmp_path):
    with pytest.raises(FormatError, match="cannot be read") as caught:
        Scene.read(f"{tmp_path}/{path}")
    assert caught.value.source.startswith(str(tmp_path))


@pytest.mark.parametrize("name", ["pluto", "", "../scenes/toutatis", "toutatis.json"])
def test_unknown_built_in_scene_is_refused_with_those_there_are(name):
    with pytest.raises(InputError, match=f"known: {', '.join(builtin_names())}$|did you mean 'toutatis'"):
        Scene.builtin(name)


def test_grid_of_a_dated_scene_builds_no_time(monkeypatch):
    def build(instants, epoch):
        raise AssertionError("a Time was built")

    monkeypatch.setattr(Instants, "_build_time", build)
    document = Scene.builtin("toutatis").document() | {
        "times": {"start": 0, "stop": 40, "count": 5000, "unit": "d"}
    }
    scene = Scene.model_validate(document)
    ephemeris = scene.run()
    assert (len(ephemeris), ephemeris.angular_velocity.shape) == (5000, (5000, 3))
    assert sum(len(chunk) for chunk in scene.chunks(700)) == 5000
    with pytest.raises(AssertionError, match="a Time was built"):
        _ = ephemeris.time


# The motion of a scene

BESIDE_X = {"axis": "z", "to": [1, 0, 0], "below": quantity(60, "deg")}


def test_every_motion_of_a_scene_has_an_epoch_of_its_own():
    scene = Scene.builtin("toutatis")
    first, second = scene.motion(), scene.motion()
    assert (first.at(3e6).quaternion("wxyz") == second.at(3e6).quaternion("wxyz")).all()
    first.epoch.format = "jd"
    assert second.epoch.format != "jd"
    assert scene.motion().epoch.format != "jd"


def test_unit_that_no_text_holds_is_refused_like_any_other():
    document = Scene.builtin("toutatis").document()
    document["angular_velocity"]["unit"] = "\ud800"
    with pytest.raises(InputError, match=r"angular_velocity\.unit"):
        Scene.model_validate(document).motion()


def test_dates_of_a_scene_are_parsed_once(monkeypatch):
    parsed = []
    parse = document_parts.parse_times
    monkeypatch.setattr(document_parts, "parse_times", lambda *each: parsed.append(each) or parse(*each))
    dates = {"dates": ["2026-03-20T12:00:00", "2026-03-21T12:00:00"], "scale": "utc"}
    made = effect_scenes.scene(effect_scenes.effect("gravity_gradient"), times=dates)
    made.run()
    made.plan()
    assert len(parsed) == 1


@pytest.mark.parametrize("drop_below", [0.0, -1.0, math.nan, math.inf, "small"])
@pytest.mark.parametrize(
    "ask",
    [
        lambda scene, limit: scene.plan(drop_below=limit),
        lambda scene, limit: scene.run(drop_below=limit),
        lambda scene, limit: scene.samples(drop_below=limit),
        lambda scene, limit: scene.crossings(BESIDE_X, drop_below=limit),
    ],
    ids=["plan", "run", "samples", "crossings"],
)
def test_angle_to_drop_effects_below_is_above_zero(ask, drop_below):
    for name in ("toutatis", "envisat"):
        with pytest.raises(InputError, match="drop_below: an angle in rad, above 0"):
            ask(Scene.builtin(name), drop_below)


def test_manoeuvre_that_is_left_out_is_in_the_notes_of_plan_and_ephemeris():
    torque = effect_scenes.effect("constant_torque", start=quantity(100, "s"), stop=quantity(900, "s"))
    message = effect_scenes.scene(torque).to_apm()
    before = Scene(apm=message, times={"start": -600, "stop": 0, "count": 3, "unit": "s"})
    note = "apm: the manoeuvre from 100 s to 900 s is outside the times, and left out"
    assert not before.effects
    assert before.plan().notes == (note,)
    assert before.run().plan.notes == (note,)


@pytest.mark.parametrize("deep", [False, True])
def test_copy_with_other_fields_keeps_nothing_of_the_fields_before(deep):
    grid = Times(start=0, stop=10, count=3, unit="s")
    assert grid.samples == 3
    assert grid.model_copy(update={"count": 6}, deep=deep).samples == 6
    one, other = (
        Scene.model_validate(changed(uncertainty={"attitude": quantity([sigma] * 3, "deg")}))
        for sigma in (1, 2)
    )
    covariance = one.run().covariance
    copied = one.model_copy(update={"uncertainty": other.uncertainty}, deep=deep)
    assert np.array_equal(copied.run().covariance, other.run().covariance)
    assert np.array_equal(one.run().covariance, covariance)
