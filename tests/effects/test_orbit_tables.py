"""Orbits given by tables: against Kepler's equation, and attitudes against those along elements."""

import math
import statistics

import numpy as np
import pytest

from attitude import AttitudeWarning, InputError, Scene
from attitude.frames.rotations import angle_between
from attitude.orbit.path_states import position, velocity
from tests.effects.scenes import quantity
from tests.tables import GONE, assert_refused, replaced

MU, RADIUS = 3.986004418e14, 6378.1e3
LOW, MOLNIYA = (6778137.0, 0.001), (26.6e6, 0.7)
INCLINATION = math.radians(51.6)
DAY = 86400.0
CENTRAL = {"mu": quantity(MU, "m3/s2"), "radius": quantity(RADIUS, "m")}
DOCUMENT = {
    "body": {"moments": [10, 20, 25], "unit": "kg m2"},
    "epoch": {"time": "2026-06-01T00:00:00", "scale": "utc"},
    "frame": "GCRF",
    "attitude": {"quaternion": [1, 0, 0, 0], "order": "wxyz"},
    "angular_velocity": quantity([1.0, 0.7, -0.4], "deg/s"),
    "effects": [{"type": "gravity_gradient"}],
    "tolerance": "best",
}


def states(times, a, e):
    """Positions and velocities (n, 3) by Kepler's equation in 19 digits, from the pericentre at t = 0."""
    one = np.longdouble(1.0)
    n, minor = np.sqrt(one * MU / (one * a) ** 3), np.sqrt(one - one * e * e)
    M = n * np.asarray(times, np.longdouble)
    E = M + e * np.sin(M)
    for _ in range(60):
        E = E - (E - e * np.sin(E) - M) / (1 - e * np.cos(E))
    assert np.abs(E - e * np.sin(E) - M).max() < 1e-16
    speed = n * a / (1 - e * np.cos(E))
    x, y, u, v = a * (np.cos(E) - e), a * minor * np.sin(E), -speed * np.sin(E), speed * minor * np.cos(E)
    c, s = math.cos(INCLINATION), math.sin(INCLINATION)
    return tuple(np.stack(rows, axis=1).astype(float) for rows in ((x, y * c, y * s), (u, v * c, v * s)))


def table(times, a, e, decimals=3, velocity_decimals=None):
    """The document of a table, its numbers rounded to so many decimals of m and m/s."""
    r, v = states(times, a, e)
    orbit = {"times": quantity(list(times), "s"), "positions": quantity(r.round(decimals).tolist(), "m")}
    if velocity_decimals is not None:
        orbit["velocities"] = quantity(v.round(velocity_decimals).tolist(), "m/s")
    return {**orbit, **CENTRAL}


def elements(a, e):
    inclination = quantity(math.degrees(INCLINATION), "deg")
    return {"semi_major_axis": quantity(a, "m"), "eccentricity": e, "inclination": inclination, **CENTRAL}


def scene(orbit, stop, **changes):
    times = {"start": 0, "stop": stop, "count": 200, "unit": "s"}
    return Scene.model_validate(replaced({**DOCUMENT, "times": times, "orbit": orbit}, changes))


def apart(one, other):
    return float(angle_between(one.quaternion("wxyz"), other.quaternion("wxyz")).max())


def steps(step, stop=DAY, before=0.0):
    return np.arange(-before, stop + before + 0.5 * step, step) + 0.0  # no -0


UNEVEN = np.sort(np.concatenate([[0.0, 20000.0], np.random.default_rng(1).uniform(0, 20000.0, 300)]))
# name: (times, a and e, decimals, decimals of the velocities), span
TABLES = {
    "each 30 s": (steps(30.0, 20000.0), LOW, 3, None),
    "each minute": (steps(60.0), LOW, 3, None),
    "each 200 s": (steps(200.0), LOW, 3, None),
    "each 200 s, exact": (steps(200.0), LOW, 9, None),
    "each 400 s": (steps(400.0), LOW, 3, None),
    "each minute, to metres": (steps(60.0), LOW, 0, None),
    "each 200 s, beyond both ends": (steps(200.0, DAY, 2000.0), LOW, 9, None),
    "each minute, velocities": (steps(60.0), LOW, 3, 6),
    "each 400 s, velocities": (steps(400.0), LOW, 3, 6),
    "each 10 min, velocities": (steps(600.0), LOW, 3, 6),
    "each 10 min, e = 0.02, velocities": (steps(600.0, 9000.0), (6.9e6, 0.02), 3, 6),
    "each minute, velocities to cm/s": (steps(60.0), LOW, 3, 2),
    "uneven": (UNEVEN, LOW, 3, None),
    "uneven, velocities": (UNEVEN, LOW, 3, 6),
    "eccentric": (steps(60.0, 40000.0), MOLNIYA, 3, None),
    "eccentric, velocities": (steps(120.0, 40000.0), MOLNIYA, 3, 6),
    "six rows": (steps(60.0, 300.0), LOW, 3, None),
}


@pytest.fixture(scope="module")
def answers():
    """Of each table: (error of its attitudes, bound, error predicted by the plan)."""
    found = {}
    for name, (times, (a, e), *digits) in TABLES.items():
        stop = min(DAY, times[-1])
        made = scene(table(times, a, e, *digits), stop)
        ephemeris, truth = made.run(), scene(elements(a, e), stop).run()
        error = apart(ephemeris, truth) + truth.plan.error_bound
        found[name] = error, ephemeris.plan.error_bound, made.plan().predicted_error
    return found


@pytest.mark.parametrize("name", TABLES)
def test_error_of_interpolation_and_rounding_is_within_the_bound(answers, name):
    error, bound, predicted = answers[name]
    assert error < bound
    assert 0.1 * bound < predicted < 10 * bound


def test_bound_is_not_far_above_the_error(answers):
    """The body is unsymmetric: what may be multiplied by its motion is taken twice."""
    assert statistics.median(bound / error for error, bound, _ in answers.values()) < 40.0


def test_table_of_an_ordinary_low_orbit_is_taken_at_the_default_tolerance():
    made = scene(table(steps(60.0), *LOW), DAY, tolerance=GONE)
    with pytest.warns(AttitudeWarning, match=r"tolerance: 1.0e-09 rad is kept up to"):
        ephemeris = made.run()
    assert apart(ephemeris, scene(elements(*LOW), DAY).run()) < ephemeris.plan.error_bound < 1e-6


def test_path_is_as_exact_as_the_rows():
    path = scene(table(steps(60.0), *LOW), DAY).initial_state().orbit_path
    t = np.linspace(0.0, DAY, 301)
    r, v = states(t, *LOW)
    assert np.abs(position(path, t) - r).max() < 3e-3  # m; rows are rounded to 1e-3
    assert np.abs(velocity(path, t) - v).max() < 1e-3
    assert path.period == pytest.approx(2 * math.pi * math.sqrt(LOW[0] ** 3 / MU), rel=1e-6)


@pytest.mark.parametrize("unit", ["min", "d"])
def test_times_may_be_in_any_unit(unit):
    plain = table(steps(60.0, 6000.0), *LOW)
    factor = {"min": 60.0, "d": 86400.0}[unit]
    other = {**plain, "times": quantity([t / factor for t in plain["times"]["value"]], unit)}
    assert apart(scene(plain, 6000.0).run(), scene(other, 6000.0).run()) < 1e-12


@pytest.mark.parametrize("scale", ["utc", "tai", "tt"])
def test_dates_are_counted_in_their_scale_across_a_leap_second(scale):
    from astropy.time import Time, TimeDelta

    epoch = {"time": "2016-12-31T23:30:00", "scale": "utc"}
    plain = table(steps(60.0, 3600.0, 60.0), *LOW)
    start = Time("2016-12-31T23:30:00", scale="utc")
    moments = start.tai + TimeDelta(np.array(plain["times"]["value"]), format="sec", scale="tai")
    dated = {**plain, "times": {"dates": getattr(moments, scale).isot.tolist(), "scale": scale}}
    one, other = scene(plain, 3600.0, epoch=epoch).run(), scene(dated, 3600.0, epoch=epoch).run()
    assert apart(one, other) < 1e-12
    made = scene(dated, 3600.0, epoch=epoch)
    assert Scene.from_json(made.to_json()) == made


def test_span_may_begin_before_the_epoch():
    times = {"elapsed": [-3000.0, -1000.0, 0.0, 2000.0], "unit": "s"}
    rows = table(steps(60.0, 3000.0, 3600.0), *LOW)
    one, other = scene(rows, 0.0, times=times).run(), scene(elements(*LOW), 0.0, times=times).run()
    assert apart(one, other) < one.plan.error_bound


@pytest.mark.parametrize("effect", ["drag", "solar_pressure"])
def test_plates_along_a_table_have_its_error_in_their_bound(effect):
    plate = {"area": quantity(1.5, "m2"), "normal": [1, 1, 0], "centre": quantity([0.1, 0.9, -0.4], "m")}
    acting = {"type": effect, "plates": [plate]}
    if effect == "drag":
        acting |= {"density": quantity(3e-12, "kg/m3"), "reference_altitude": quantity(400, "km")}
        acting |= {"scale_height": quantity(60, "km"), "corotating": False}
    else:
        acting |= {"sun": {"direction": [1, 0.2, 0.1]}}
    rows = table(steps(300.0, 12000.0), *LOW)
    one, other = (scene(orbit, 12000.0, effects=[acting]).run() for orbit in (rows, elements(*LOW)))
    assert apart(one, other) < one.plan.error_bound
    assert one.plan.error_bound > 3 * other.plan.error_bound


ROWS = table(steps(60.0, 600.0), *LOW, velocity_decimals=6)


@pytest.mark.parametrize(
    ("changes", "pointer", "message"),
    [
        ({"times": quantity(ROWS["times"]["value"][:3], "s")}, "/times/value", "4"),
        ({"times": {"unit": "s"}}, "/times", "exactly one of value, dates"),
        ({"times": {"value": ROWS["times"]["value"]}}, "/times/unit", "a value beside value"),
        ({"times": {**ROWS["times"], "scale": "utc"}}, "/times/scale", "no scale beside value"),
        ({"times": {"dates": ["2026-06-01"] * 11, "scale": "utc"}}, "/times/dates/1", "none twice"),
        ({"times": {"dates": ["June"] * 11, "scale": "utc"}}, "/times/dates/0", "a date such as"),
        ({"positions": quantity(ROWS["positions"]["value"][:-1], "m")}, "/positions/value", "11, one for"),
        ({"velocities": quantity(ROWS["velocities"]["value"][:-1], "m/s")}, "/velocities/value", "11, one"),
        ({"velocities": quantity(ROWS["velocities"]["value"], "km/s")}, "/velocities/value/0", "derivative"),
        (
            {"velocities": quantity([[x + 300, y, z] for x, y, z in ROWS["velocities"]["value"]], "m/s")},
            "/velocities/value/0",
            "the derivative of the positions",
        ),
        ({"velocities": ROWS["positions"]}, "/velocities/unit", "a unit of"),
    ],
)
def test_fault_of_a_table_is_refused(changes, pointer, message):
    with pytest.raises(InputError, match=message) as caught:
        scene(replaced(ROWS, changes), 600.0).initial_state()
    assert caught.value.pointer.startswith(f"/orbit{pointer}")


@pytest.mark.parametrize("shadow", ["conical", "cylindrical"])
@pytest.mark.parametrize("rows", [(60.0, None), (300.0, 6)], ids=["positions", "velocities"])
def test_eclipses_along_a_table_are_those_along_the_elements(shadow, rows):
    plate = {"area": quantity(1.5, "m2"), "normal": [1, 1, 0], "centre": quantity([0.1, 0.9, -0.4], "m")}
    light = {
        "type": "solar_pressure",
        "plates": [plate],
        "sun": {"direction": [1, 0.2, 0.1]},
        "shadow": shadow,
    }
    along = table(steps(rows[0], 12000.0, 600.0), *LOW, velocity_decimals=rows[1])
    found, expected = (
        scene(orbit, 12000.0, effects=[light]).run().events for orbit in (along, elements(*LOW))
    )
    assert [event.kind for event in found] == [event.kind for event in expected]
    assert len(found) == (8 if shadow == "conical" else 4)
    apart_s = [abs(a.seconds - b.seconds) for a, b in zip(found, expected, strict=True)]
    assert max(apart_s) < 1e-5  # rows are rounded to a millimetre, at 7.6 km/s


@pytest.mark.parametrize("name", ["times", "positions", "velocities"])
@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_numbers_that_are_not_finite_are_refused(name, bad):
    values = [row if name == "times" else list(row) for row in ROWS[name]["value"]]
    if name == "times":
        values[3] = bad
    else:
        values[3][1] = bad
    with pytest.raises(InputError, match="a finite number") as caught:
        scene({**ROWS, name: {**ROWS[name], "value": values}}, 600.0)
    assert caught.value.pointer.startswith(f"/orbit/{name}/value/3")


@pytest.mark.parametrize("step", [-60.0, 0.0], ids=["backward", "twice"])
@pytest.mark.parametrize("form", ["value", "dates"])
def test_instants_that_do_not_ascend_are_refused(step, form):
    seconds = list(ROWS["times"]["value"])
    seconds[5] = seconds[4] + step
    times = quantity(seconds, "s")
    if form == "dates":
        dates = [f"2026-06-01T00:{int(t) // 60:02d}:{int(t) % 60:02d}" for t in seconds]
        times = {"dates": dates, "scale": "utc"}
    with pytest.raises(InputError, match="instants in ascending order, none twice") as caught:
        scene({**ROWS, "times": times}, 600.0)
    assert caught.value.pointer == f"/orbit/times/{form}/5"


@pytest.mark.parametrize("count", [1, 2, 3])
def test_few_rows_are_refused_by_their_number(count):
    few = {name: {**ROWS[name], "value": ROWS[name]["value"][:count]} for name in ("times", "positions")}
    with pytest.raises(InputError, match="4 elements") as caught:
        scene({**few, **CENTRAL}, 60.0)
    assert caught.value.pointer == "/orbit/times/value"


def test_table_in_dates_that_ends_before_the_span_is_refused_with_what_it_covers():
    dates = [f"2026-06-01T00:{m:02d}:00" for m in range(11)]
    made = scene({**ROWS, "times": {"dates": dates, "scale": "utc"}}, 700.0)
    assert_refused(made.initial_state, "/orbit/times/dates", r"700.0 s; got '0 s to (600|599.99)")
    # of both ends
    times = {"elapsed": [-60.0, 60.0], "unit": "s"}
    made = scene(ROWS, 0.0, times=times)
    assert_refused(made.initial_state, "/orbit/times/value", r"-60.0 s to 60.0 s; got '0 s to 600 s'")


def test_span_beyond_the_table_is_refused_with_what_it_covers():
    made = scene(ROWS, 700.0)
    assert_refused(made.initial_state, "/orbit/times/value", r"700.0 s; got '0 s to 600 s'")


def test_dates_need_an_epoch():
    dated = {**ROWS, "times": {"dates": [f"2026-06-01T00:{m:02d}:00" for m in range(11)], "scale": "utc"}}
    made = scene(dated, 600.0, epoch=GONE)
    assert_refused(made.initial_state, "/orbit/times/dates", "an epoch in the scene")
