"""Effects in the scene document: what they mean in numbers, and every fault refused."""

import ctypes
import math

import numpy as np
import pytest
from astropy.time import Time, TimeDelta
from scipy.spatial.transform import Rotation

from attitude import AttitudeError, InputError, Scene
from attitude.effects import KNOWN_EFFECTS, UserTorque, effect_class
from attitude.effects.magnetic_dipole import G10, G11, H11
from attitude.kernels.layout import EffectCode, EffectRow
from attitude.orbit.path_states import position, velocity
from tests.effects.scenes import EFFECTS, ON_ORBIT, TORQUES, built, document, effect, quantity, scene, torque
from tests.tables import GONE, assert_refused, refusals

TENSOR = {"body": {"tensor": [[3, 0.3, -0.1], [0.3, 2, 0.2], [-0.1, 0.2, 4]], "unit": "kg m2"}}
UPRIGHT = {"attitude": {"quaternion": [1, 0, 0, 0], "order": "wxyz"}}


# -- in and out -----------------------------------------------------------------------------------


@pytest.mark.parametrize("name", EFFECTS)
def test_effect_comes_back_as_it_was(name):
    made = scene(effect(name))
    assert made.document() == document(effect(name))
    again = Scene.from_json(made.to_json())
    assert again == made
    assert again.to_json() == made.to_json()
    assert made.initial_state().mass == (3.0 if name == "ground" else None)


@pytest.mark.parametrize("name", EFFECTS)
@pytest.mark.parametrize("moment", [1e-300, 1e-60, 1e60, 1e300])
def test_moments_whose_squares_overflow_are_refused_under_effects(name, moment):
    moments = {"moments": [moment, 1.5 * moment, 2 * moment]}
    body = {name: value for name, value in document(effect(name))["body"].items() if name != "tensor"}
    made = scene(effect(name), body=body | moments)
    with pytest.raises(InputError, match=r"body: moments from 1e-50 to 1e.50 kg m2 in a scene with effects"):
        made.run()


def test_every_effect_is_known_by_its_type():
    assert set(KNOWN_EFFECTS) == set(EFFECTS)
    for name in KNOWN_EFFECTS:
        assert effect_class(name).model_fields["type"].annotation.__args__ == (name,)
        assert ("attitude" if name in TORQUES else scene(effect(name)).effects[0].ACTS_ON) == effect_class(
            name
        ).ACTS_ON


def test_description_of_the_document_names_every_effect():
    text = str(Scene.model_json_schema())
    for name in KNOWN_EFFECTS:
        assert f"'const': '{name}'" in text
    assert "'tle'" in text
    assert "'const': 'astropy'" in text


def test_initial_state_is_the_document_in_si_units():
    changes = {
        "body": {"moments": [2, 3, 4], "unit": "g cm2", "mass": quantity(5, "g")},
        "position": quantity([1, 2, 3], "km"),
        "velocity": quantity([1, 2, 3], "km/h"),
        "times": {"start": 1, "stop": 2.05, "step": 0.5, "unit": "min"},
    }
    actual = scene(**changes).initial_state()
    assert actual.moments == pytest.approx([2e-7, 3e-7, 4e-7])
    assert (actual.mass, actual.start, actual.stop, actual.frame) == (5e-3, 0.0, 120.0, "GCRF")
    assert actual.position.tolist() == [1000.0, 2000.0, 3000.0]
    assert actual.velocity == pytest.approx(np.array([1, 2, 3]) / 3.6)
    assert actual.epoch == Time("2026-03-20T12:00:00", scale="utc")
    assert actual.orbit_path is None


@pytest.mark.parametrize(
    ("times", "span"),
    [
        ({"elapsed": [5, -3, 2], "unit": "s"}, (-3, 5)),
        ({"elapsed": [5, 7], "unit": "s"}, (0, 7)),
        ({"elapsed": [-5, -7], "unit": "s"}, (-7, 0)),
        ({"start": -2, "stop": 7, "step": 2, "unit": "s"}, (-2, 6)),
        ({"dates": ["2026-03-20T12:01:00"], "scale": "utc"}, (0, 60)),
    ],
    ids=str,
)
def test_span_is_that_of_the_times_with_the_epoch(times, span):
    actual = scene(times=times).initial_state()
    assert (actual.start, actual.stop) == pytest.approx(span, abs=1e-9)


def test_tolerance_is_a_billionth_of_a_radian_if_left_out():
    assert scene().asked_tolerance == 1e-9
    assert scene(tolerance=quantity(1, "arcsec")).asked_tolerance == pytest.approx(math.pi / 648000)
    assert scene(tolerance=quantity(1e-13, "rad"), solver="gauss").asked_tolerance == 1e-13


# -- what the numbers are -------------------------------------------------------------------------


def rows_of(name, changes=None, **parts):
    made, initial_state = built(name, changes, **(TENSOR | parts))
    rows = made.rows(initial_state)
    assert rows.shape[1] == EffectRow.WIDTH
    return rows, initial_state


def torque_in_body(name, changes=None, rate=(0.0, 0.0, 0.0), t=0.0, **parts):
    """N m, body axes, of a body with a full tensor, at its attitude at the epoch."""
    rows, initial_state = rows_of(name, changes, **parts)
    A = initial_state.axes
    R = A @ body_from_inertial(initial_state).as_matrix()
    r = v = np.ones(3)
    if initial_state.orbit_path is not None:
        path, instant = initial_state.orbit_path, np.array([t])
        r, v = position(path, instant)[0], velocity(path, instant)[0]
    sun = built(name, changes, **(TENSOR | parts))[0].sun(initial_state)
    to_sun = None if sun is None else sun.coefficients[0, :, 0]
    parts = [torque(row, initial_state.moments, R, A @ np.array(rate), r, v, t, to_sun) for row in rows]
    return A.T @ np.sum(parts, axis=0), initial_state


def body_from_inertial(initial_state):
    return Rotation.from_quat(initial_state.attitude, scalar_first=True).inv()


def gauss_field(point):
    """T, Earth-fixed: minus the gradient of the potential of degree 1, by differences (m)."""

    def potential(x):
        radius = np.linalg.norm(x)
        return 6371.2e3 * (6371.2e3 / radius) ** 2 * (G10 * x[2] + G11 * x[0] + H11 * x[1]) / radius

    steps = 100.0 * np.eye(3)
    return -np.array([(potential(point + h) - potential(point - h)) / 200.0 for h in steps])


@pytest.mark.parametrize("t", [0.0, 4000.0])
def test_magnetic_torque_is_by_the_gradient_of_the_potential_that_turns_with_the_earth(t):
    actual, initial_state = torque_in_body("magnetic_dipole", t=t)
    moment = Time("2026-03-20T12:00:00", scale="utc") + TimeDelta(t, format="sec")
    # astropy's own angle, which knows UT1: the difference is 0.004 degrees at most
    angle = moment.earth_rotation_angle("tio").to_value("rad")
    earth_fixed = Rotation.from_euler("z", -angle)
    r = position(initial_state.orbit_path, np.array([t]))[0]
    B = earth_fixed.inv().apply(gauss_field(earth_fixed.apply(r)))
    expected = np.cross([1, -2, 0.5], body_from_inertial(initial_state).apply(B))
    assert actual == pytest.approx(expected, abs=2e-4 * np.linalg.norm(expected))


def test_earths_dipole_is_where_it_is_known_to_be():
    # geomagnetic pole of 2025 at 80.8 N, 72.8 W; 2.98e-5 T at the equator (IGRF-14, pole positions)
    strength, direction, turns = built("magnetic_dipole")[0].source()
    assert strength / 6371.2e3**3 == pytest.approx(2.9734e-5, rel=1e-3)
    assert math.degrees(math.asin(-direction[2])) == pytest.approx(80.8, abs=0.1)
    assert math.degrees(math.atan2(-direction[1], -direction[0])) == pytest.approx(-72.8, abs=0.1)
    assert sum(turns) * 86164.0905 == pytest.approx(1.0, rel=1e-7)


def test_pole_of_the_field_is_the_earths_in_any_frame():
    rows, _ = rows_of("magnetic_dipole", frame="ECLIPJ2000")
    a = rows[0, 5:8] / np.linalg.norm(rows[0, 5:8])
    obliquity = math.radians(84381.448 / 3600)
    assert -a == pytest.approx([0, math.sin(obliquity), math.cos(obliquity)], abs=2e-7)
    rows, _ = rows_of("magnetic_dipole", frame="INERTIAL")
    assert rows[0, 5:7].tolist() == [0.0, 0.0]


def test_torque_acts_from_start_to_stop_and_no_longer():
    made, initial_state = built("constant_torque")
    assert made.intervals(initial_state) is None
    made, initial_state = built("constant_torque", {"start": quantity(1, "min"), "stop": quantity(1, "h")})
    assert made.intervals(initial_state) == [(60.0, 3600.0)]
    date = {"date": "2026-03-20T12:10:00", "scale": "utc"}
    made, initial_state = built("constant_torque", {"start": date})
    assert made.intervals(initial_state) == [pytest.approx((600.0, 6000.0), abs=1e-9)]
    made, initial_state = built("constant_torque", {"stop": quantity(1, "d")})
    assert made.intervals(initial_state) == [(0.0, 6000.0)]


def test_impulse_is_an_angular_one_or_a_force_at_an_arm():
    made, initial_state = built("impulse")
    impulse = made.applied(initial_state)[0]
    assert (impulse.seconds, impulse.inertial, made.moves) == (10.0, False, False)
    assert impulse.angular.tolist() == [0, 0.1, 0.2]
    forced = {
        "angular_impulse": GONE,
        "impulse": quantity([0, 3, 0], "N s"),
        "arm": quantity([200, 0, 0], "cm"),
        "frame": "inertial",
        "time": {"date": "2026-03-20T12:00:20", "scale": "utc"},
    }
    made, initial_state = built("impulse", forced)
    impulse = made.applied(initial_state)[0]
    assert (impulse.seconds, impulse.inertial, made.moves) == (pytest.approx(20.0, abs=1e-9), True, True)
    assert impulse.angular == pytest.approx([0, 0, 6])
    assert impulse.linear.tolist() == [0, 3, 0]


def test_firing_plan_is_in_the_order_of_its_instants():
    first, second = (
        {key: value for key, value in effect("impulse", time=quantity(t, "s")).items() if key != "type"}
        for t in (50, 20)
    )
    plan = {"type": "impulse", "firings": [first, second, first]}
    made = scene(plan)
    assert [impulse.seconds for impulse in made.effects[0].applied(made.initial_state())] == [
        20.0,
        50.0,
        50.0,
    ]
    assert made.document()["effects"] == [plan]


# -- the ground -----------------------------------------------------------------------------------

TETRAHEDRON = [[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]
SHAPES = {
    "box": {"box": [1, 2, 3]},
    "cylinder": {"cylinder": {"radius": 1, "height": 3, "axis": "y"}},
    "sphere": {"sphere": 1.5},
    "vertices": {"vertices": TETRAHEDRON},
}


def surface(shape, count=200_000):
    """Points of a shape's surface, many."""
    rng = np.random.default_rng(4)
    u = rng.uniform(-1, 1, (count, 3))
    if "box" in shape:
        u[: count // 2] = np.sign(u[: count // 2])  # its corners, and points on its faces
        u[np.arange(count), rng.integers(0, 3, count)] = rng.choice([-1.0, 1.0], count)
        return u * np.array(shape["box"]) / 2
    if "cylinder" in shape:
        angle = np.pi * u[:, 0]
        # its rims, which are what it can touch with
        return np.stack([np.cos(angle), 1.5 * np.sign(u[:, 1]), np.sin(angle)], axis=1)
    if "sphere" in shape:
        return 1.5 * u / np.linalg.norm(u, axis=1)[:, None]
    return np.array(shape["vertices"], dtype=float)


@pytest.mark.parametrize("name", SHAPES)
def test_lowest_point_is_that_of_all_points(name):
    centre = [0.05, -0.1, 0.2]
    shape = {**SHAPES[name], "centre": centre, "unit": "m"}
    made, initial_state = built(
        "ground", {"shape": shape, "normal": [1, 2, 2]}, position=quantity([0, 0, 20], "m")
    )
    points = body_from_inertial(initial_state).inv().apply(surface(shape) + centre)
    points += [0, 0, 20]
    lowest = (points @ np.array([1, 2, 2]) / 3).min()
    assert made.clearance(initial_state) <= lowest + 1e-12
    assert made.clearance(initial_state) == pytest.approx(lowest, abs=3e-4)


def test_unit_of_a_shape_scales_all_of_it():
    for form in SHAPES.values():
        small, large = (
            effect_class("ground")
            .model_validate(effect("ground", shape={**form, "centre": [0.1, 0, 0], "unit": unit}))
            .shape.hull()
            for unit in ("mm", "m")
        )
        assert small.corners == pytest.approx(1e-3 * large.corners, rel=1e-14)
        assert small.corner_radius == pytest.approx(1e-3 * large.corner_radius, rel=1e-14)
        assert small.size == pytest.approx(1e-3 * large.size, rel=1e-14)


def test_body_may_stand_on_the_ground_but_not_in_it():
    scene(effect("ground"), **UPRIGHT, position=quantity([0, 0, 0.5], "m")).initial_state()
    scene(effect("ground"), **UPRIGHT, position=quantity([0, 0, 0.5 - 1e-16], "m")).initial_state()
    sunk = scene(effect("ground"), **UPRIGHT, position=quantity([0, 0, 0.5 - 1e-9], "m"))
    assert_refused(sunk.initial_state, "/effects/0/height/value", "lowest point is 1e-09 m under it")


# -- faults ---------------------------------------------------------------------------------------


def use_all(whole):
    """Everything that is asked of effects before anything moves."""
    made = Scene.model_validate(whole)
    initial_state = made.initial_state()
    for part in made.effects:
        if part.ACTS_ON == "attitude":
            part.rows(initial_state), part.intervals(initial_state), part.size(initial_state)


@pytest.mark.parametrize(("effects", "changes", "pointer", "message"), refusals("effect_refusals"))
def test_fault_is_refused_with_a_pointer_into_the_document(effects, changes, pointer, message):
    """Effects of a row are the type with its members changed, or what is no such effect."""
    made = [effect(part[0], **dict(*part[1:])) if isinstance(part, list) else part for part in effects]
    named = [part for part in made if isinstance(part, dict) and part.get("type") in EFFECTS]
    whole = document(*named, **changes) | {"effects": made}
    assert_refused(lambda: use_all(whole), pointer, message)


@pytest.mark.parametrize("name", ON_ORBIT)
def test_orbit_is_missed_by_the_effect_that_needs_it(name):
    assert_refused(
        lambda: scene(effect(name), orbit=GONE), "/orbit", f"an orbit, which {name} needs; got nothing"
    )


def test_uniform_gravity_needs_nothing_else():
    made = scene(effect("uniform_gravity"))
    assert made.effects[0].acceleration.si.tolist() == [0, 0, -9.81]
    assert made.effects[0].ACTS_ON == "translation"


JUNK = [None, True, "", 0, -1, 1e308, math.inf, 10**400, [], {}, [0, 0, 0], [[0]], {"value": 1}, "m"]


@pytest.mark.parametrize("name", EFFECTS)
def test_any_junk_in_an_effect_is_refused_or_gives_numbers(name):
    whole = effect(name)
    for key in [key for key in whole if key != "type"]:
        for junk in JUNK:
            try:
                made = scene(effect(name, **{key: junk}))
                initial_state = made.initial_state()
            except AttitudeError:
                continue
            if made.effects[0].ACTS_ON == "attitude":
                rows = made.effects[0].rows(initial_state)
                assert np.isfinite(rows[~np.isposinf(rows)]).all()
                assert made.effects[0].size(initial_state) >= 0.0


# -- effects of the user's own --------------------------------------------------------------------


def called(made, initial_state, t=1.5, q=(0.5, 0.5, 0.5, 0.5), w=(1.0, 2.0, 3.0)):
    """What compiled code gets that calls the address in the row."""
    row = made.rows(initial_state)[0]
    assert row[0] == EffectCode.USER
    address = int(row[1:2].view(np.int64)[0])
    doubles = ctypes.POINTER(ctypes.c_double)
    function = ctypes.CFUNCTYPE(None, ctypes.c_double, doubles, doubles, doubles)(address)
    out = np.zeros(3)
    arrays = [np.array(x, dtype=float) for x in (q, w)]
    function(t, *(array.ctypes.data_as(doubles) for array in (*arrays, out)))
    return out


def test_python_function_is_called_by_its_address():
    seen = []

    def push(t, attitude, rate):
        seen.append((t, attitude.copy(), rate.copy()))
        return -0.5 * rate

    made = scene(UserTorque("brake", push, size=2.0), effect("wheels"))
    brake, initial_state = made.effects[0], made.initial_state()
    assert called(brake, initial_state).tolist() == [-0.5, -1.0, -1.5]
    assert seen[0][0] == 1.5
    assert seen[0][1].tolist() == [0.5, 0.5, 0.5, 0.5]
    assert (brake.label, brake.size(initial_state)) == ("brake", 2.0)
    assert (brake.is_compiled, brake.failure) == (False, None)
    brake.raise_failure()


def test_compiled_function_is_taken_as_it_is():
    numba = pytest.importorskip("numba")
    signature = numba.types.void(numba.types.double, *(numba.types.CPointer(numba.types.double),) * 3)

    @numba.cfunc(signature)
    def push(t, q, w, out):
        for i in range(3):
            out[i] = t * w[i] + q[i]

    initial_state = scene().initial_state()
    for code in (push, push.address, push.ctypes):
        made = UserTorque("push", compiled=code, size=1.0)
        assert made.is_compiled
        assert called(made, initial_state).tolist() == [2.0, 3.5, 5.0]


def fails(*_):
    raise KeyError("no such thruster")


@pytest.mark.parametrize(
    ("function", "kind", "message"),
    [
        (fails, KeyError, "no such thruster"),
        (lambda *_: [1.0, 2.0], InputError, "effect 'mine': a torque of three finite numbers"),
        (lambda *_: [1.0, 2.0, math.nan], InputError, "a torque of three finite numbers"),
        (lambda *_: "much", InputError, "a torque of three finite numbers; got 'much'"),
        (lambda _t, _q: [0, 0, 0], TypeError, "positional argument"),
    ],
    ids=["raises", "two", "nan", "text", "arguments"],
)
def test_failure_of_a_python_function_is_kept_and_stops_with_nan(function, kind, message):
    made = UserTorque("mine", function, size=1.0)
    assert np.isnan(called(made, scene().initial_state())).all()
    assert isinstance(made.failure, kind)
    with pytest.raises(kind, match=message):
        made.raise_failure()
    assert made.failure is None


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"size": 1.0}, "one of function and compiled"),
        ({"size": 1.0, "function": fails, "compiled": 5}, "one of function and compiled"),
        ({"size": 1.0, "function": 5}, "a function of t, attitude and angular velocity"),
        ({"size": 1.0, "compiled": "main"}, "a numba cfunc, a ctypes function or an address"),
        ({"size": 1.0, "compiled": 0}, "a numba cfunc, a ctypes function or an address"),
        ({"size": -1.0, "function": fails}, "a finite number of N m, not below 0"),
        ({"size": math.nan, "function": fails}, "a finite number of N m, not below 0"),
    ],
    ids=["none", "both", "number", "text", "null", "negative", "nan"],
)
def test_what_is_no_function_is_refused(arguments, message):
    with pytest.raises(InputError, match=message):
        UserTorque("mine", **arguments)


def test_scene_with_an_effect_made_in_python_is_no_document():
    made = scene(effect("wheels"), UserTorque("mine", fails, size=1.0))
    for write in (made.to_json, made.document):
        assert_refused(write, "/effects/1", "none made in Python")
