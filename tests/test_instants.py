"""Instants: any scale, any shape, two parts from calendar to kernel, and nothing built unasked."""

import math
import socket
import subprocess
import sys
import threading
import tracemalloc
from fractions import Fraction

import numpy as np
import pytest
from astropy import units as u
from astropy.time import Time, TimeDelta
from astropy.utils import iers

from attitude import InputError, RigidBody, TorqueFreeMotion
from attitude.times.instants import Instants
from attitude.times.two_part import two_sum
from tests.bodies import ATTITUDE, ATTITUDE_TOLERANCE, angle_between

# A Time is whole days and a fraction of one, so each step from text or scale to another rounds by at most
# 2^-54 d = 4.8 ps; text to UTC and UTC to TAI, for instant and epoch, are four.
TIME_ROUNDING = 4 * 2**-54 * 86400  # s

# Two-part differences and products are exact but for the last bit of the second part.
TWO_PART_TOLERANCE = 2.0**-100

DAY = 86400
# A hundred turns a minute, with some nutation.
SPINNER = RigidBody((199.0, 201.0, 262.0)), ATTITUDE, (0.01, 0.02, 10.472)
FASTEST = 14.0  # rad/s, L / I of the least moment
NS = 1e-9


def spinner(epoch=None):
    return TorqueFreeMotion(*SPINNER, epoch=epoch, order="wxyz")


def two_part(instants):
    """Exact value of each instant's seconds + seconds_low."""
    low = np.zeros(instants.shape) if instants.seconds_low is None else instants.seconds_low
    return [Fraction(a) + Fraction(b) for a, b in zip(instants.seconds.flat, low.flat, strict=True)]


def assert_close(actual, truly, relative=TWO_PART_TOLERANCE):
    for value, true in zip(actual, truly, strict=True):
        assert abs(value - true) <= relative * abs(true)


# -- scales -------------------------------------------------------------------------------------

BEFORE_LEAP = "2016-12-31T23:59:50"
ACROSS_LEAP = {
    "2016-12-31T23:59:50": 0.0,
    "2016-12-31T23:59:59": 9.0,
    "2016-12-31T23:59:60": 10.0,
    "2016-12-31T23:59:60.5": 10.5,
    "2017-01-01T00:00:00": 11.0,
    "2017-01-01T00:01:00": 71.0,
    "2017-01-02T00:00:00": DAY + 11.0,
    "2016-12-31T00:00:00": 10.0 - DAY,
}


def test_utc_across_a_leap_second_is_counted_in_whole_seconds():
    ephemeris = spinner(Time(BEFORE_LEAP, scale="utc")).at(Time(list(ACROSS_LEAP), scale="utc"))
    assert np.abs(ephemeris.elapsed - list(ACROSS_LEAP.values())).max() <= TIME_ROUNDING


def test_attitude_across_a_leap_second_is_that_of_elapsed_seconds():
    motion = spinner(Time(BEFORE_LEAP, scale="utc"))
    dated, counted = motion.at(Time(list(ACROSS_LEAP), scale="utc")), motion.at(list(ACROSS_LEAP.values()))
    apart = angle_between(dated.quaternion("wxyz"), counted.quaternion("wxyz"))
    assert np.abs(apart).max() <= FASTEST * TIME_ROUNDING + 2 * ATTITUDE_TOLERANCE


def test_elapsed_seconds_are_dated_with_second_sixty():
    ephemeris = spinner(Time(BEFORE_LEAP, scale="utc", precision=1)).at(list(ACROSS_LEAP.values()))
    assert [text.removesuffix(".0") for text in ephemeris.time.isot] == list(ACROSS_LEAP)


def test_half_a_century_of_utc_counts_all_leap_seconds():
    ephemeris = spinner(Time("1972-01-01", scale="utc")).at(Time("2017-01-01", scale="utc"))
    # 45 years, of which 12 have 366 days; TAI - UTC went from 10 s to 37 s
    assert abs(ephemeris.elapsed - ((45 * 365 + 12) * DAY + 27)) <= TIME_ROUNDING


@pytest.mark.parametrize("scale", ["utc", "tai", "tt", "tdb", "tcb", "tcg"])
def test_one_instant_is_the_same_in_every_scale(scale):
    motion = spinner(Time("2020-06-01T12:00:00", scale="tai"))
    instant = Time("2021-03-01T06:00:00", scale="tai")
    elapsed = motion.at(getattr(instant, scale)).elapsed
    assert abs(elapsed - (273 * DAY - 6 * 3600)) <= 2 * TIME_ROUNDING


@pytest.mark.parametrize("scale", ["utc", "tt", "tdb", "tcb", "tcg", "ut1"])
def test_epoch_may_be_in_any_scale(scale):
    epoch = Time("2016-06-01T12:00:00", scale="tai")
    elapsed = spinner(getattr(epoch, scale)).at(Time("2016-06-02T12:00:00", scale="tai")).elapsed
    assert abs(elapsed - DAY) <= 2 * TIME_ROUNDING


def test_tdb_runs_fast_and_slow_against_the_motions_seconds():
    dates = ["2020-01-04", "2020-04-04", "2020-07-04", "2020-10-04"]
    instants = Time(dates, scale="tdb")
    ahead = (
        spinner(Time("2000-01-01T12:00:00", scale="tt")).at(instants).elapsed
        - spinner(Time("2000-01-01T12:00:00", scale="tai")).at(Time(dates, scale="tai")).elapsed
    )
    g = np.radians(357.53 + 0.98560028 * (instants.jd - 2451545.0))
    # Astronomical Almanac, section B: TDB - TT to 10 us in these years, 30 us at most
    tdb_less_tt = 0.001657 * np.sin(g) + 0.000022 * np.sin(
        np.radians(246.11 + 0.90251792 * (instants.jd - 2451545.0))
    )
    assert np.ptp(tdb_less_tt) > 3e-3
    assert np.abs(-ahead - tdb_less_tt).max() <= 30e-6


def test_span_of_barycentric_time_is_counted_in_its_own_seconds():
    motion = spinner(Time("2020-01-04", scale="utc"))
    terrestrial, barycentric = (
        motion.at(TimeDelta(91.0, format="jd", scale=scale)).elapsed for scale in ("tt", "tdb")
    )
    assert terrestrial == 91 * DAY
    assert 1e-3 < abs(barycentric - terrestrial) < 2e-3


# -- precision ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("day", "epoch"), [(2451545.0, 2451545.0), (2561117.0, 2451545.0), (2451545.0, 2561117.0)]
)
def test_difference_of_two_dates_is_exact(day, epoch):
    fractions = np.array([0.0, 1 / 3, -0.4999999, 1e-14, 2**-52])
    start = Time(epoch, 0.1, format="jd", scale="tai")
    dates = Time(np.full(5, day), fractions, format="jd", scale="tai")
    exact = [
        (Fraction(high) - Fraction(start.jd1) + Fraction(low) - Fraction(start.jd2)) * DAY
        for high, low in zip(dates.jd1.tolist(), dates.jd2.tolist(), strict=True)
    ]
    assert_close(two_part(spinner(start).at(dates).instants), exact)


def test_a_nanosecond_turns_the_body_by_its_due_after_three_centuries():
    epoch = Time(2451545.0, 0.0, format="jd", scale="tai")
    # 300 Julian years later, and the double nearest to a nanosecond after: no rounding but of that
    instants = Time(2451545.0 + 109575, [0.0, NS / DAY], format="jd", scale="tai")
    ephemeris = spinner(epoch).at(instants)
    assert ephemeris.elapsed[0] == ephemeris.elapsed[1]  # one double holds microseconds there
    turned = angle_between(*ephemeris.quaternion("wxyz"))
    due = np.linalg.norm(ephemeris.angular_velocity[0]) * NS
    assert due > 1e-8
    assert abs(abs(turned) - due) <= 2 * ATTITUDE_TOLERANCE


def test_days_that_are_binary_fractions_give_the_bits_of_seconds():
    k = np.arange(-2000, 2000, 7)
    dates = Time(2451545.0, k / 128, format="jd", scale="tai")  # 1/128 d is 675 s
    motion = spinner(Time(2451545.0, 0.0, format="jd", scale="tai"))
    dated, counted = motion.at(dates), motion.at(675.0 * k)
    assert np.array_equal(dated.quaternion("wxyz"), counted.quaternion("wxyz"))
    assert np.array_equal(dated.angular_velocity, counted.angular_velocity)


@pytest.mark.parametrize(
    ("value", "unit", "seconds"),
    [
        (0.1, u.s, 1),
        (0.1, u.ms, Fraction(1, 1000)),
        (0.1, u.min, 60),
        (0.7, u.h, 3600),
        (1 / 3, u.d, DAY),
        (109575.1, u.d, DAY),
        (300.1, u.yr, 31557600),
    ],
    ids=str,
)
def test_quantity_keeps_both_parts(value, unit, seconds):
    instants = spinner().at(value * unit).instants
    assert_close(two_part(instants), [Fraction(value) * seconds])


def test_time_delta_keeps_both_parts():
    days, fractions = np.array([109575.0, -3.0]), np.array([1e-15, 1 / 3])
    instants = spinner().at(TimeDelta(days, fractions, format="jd")).instants
    exact = [
        (Fraction(a) + Fraction(b)) * DAY for a, b in zip(days.tolist(), fractions.tolist(), strict=True)
    ]
    assert_close(two_part(instants), exact)


def test_dates_made_of_elapsed_time_keep_both_parts():
    epoch = Time("2000-01-01T12:00:00", scale="tt")
    span = TimeDelta([109575.0, -109575.0], [1e-13, 0.3], format="jd", scale="tt")
    made = spinner(epoch).at(span).time
    assert np.abs((made - epoch - span).sec).max() <= TIME_ROUNDING


# -- kinds and shapes ---------------------------------------------------------------------------

# 11.25 min are 1/128 d: no kind of time rounds them.
SPANS = {
    "float": 675.0,
    "int": 675,
    "numpy scalar": np.float32(675),
    "seconds": 675 * u.s,
    "minutes": 11.25 * u.min,
    "milliseconds": 675_000 * u.ms,
    "days": u.d / 128,
    "TimeDelta": TimeDelta(675, format="sec"),
    "TimeDelta in TT": TimeDelta(675, format="sec", scale="tt"),
    "date": Time("2020-01-01T00:11:15", scale="tai"),
}


@pytest.mark.parametrize("t", SPANS.values(), ids=SPANS)
def test_every_kind_of_time_gives_the_same_bits(t):
    motion = spinner(Time("2020-01-01", scale="tai"))
    ephemeris = motion.at(t)
    assert ephemeris.elapsed == 675.0
    assert np.array_equal(ephemeris.quaternion("wxyz"), motion.at([675.0]).quaternion("wxyz")[0])


SHAPES = [(), (0,), (1,), (5,), (2, 3), (2, 0), (2, 1, 3)]


@pytest.mark.parametrize("kind", ["floats", "quantity", "span", "date"])
@pytest.mark.parametrize("shape", SHAPES, ids=str)
def test_instants_have_the_shape_they_were_given_in(shape, kind):
    epoch = Time("2020-01-01", scale="utc")
    seconds = np.arange(math.prod(shape), dtype=float).reshape(shape)
    t = {
        "floats": seconds,
        "quantity": seconds * u.min,
        "span": TimeDelta(seconds, format="jd"),
        "date": epoch + TimeDelta(seconds, format="jd"),
    }[kind]
    ephemeris = spinner(epoch).at(t)
    assert ephemeris.shape == ephemeris.elapsed.shape == ephemeris.time.shape == shape
    assert ephemeris.quaternion("wxyz").shape == (*shape, 4)
    assert ephemeris.angular_velocity.shape == (*shape, 3)


def test_nested_lists_of_python_numbers_are_instants():
    assert spinner().at([[0, 1.5], [2, -3]]).elapsed.tolist() == [[0.0, 1.5], [2.0, -3.0]]


# -- the Time that is handed back ---------------------------------------------------------------


@pytest.mark.parametrize(
    ("scale", "form"),
    [("utc", "isot"), ("tai", "iso"), ("tt", "jd"), ("tdb", "mjd"), ("tcb", "jyear"), ("utc", "unix")],
)
def test_dates_come_back_in_the_scale_and_format_they_were_given_in(scale, form):
    dates = getattr(Time(["2020-01-01T00:00:01.25", "2021-01-01T00:00:00"], scale="utc"), scale)
    dates.format = form
    time = spinner(Time("2020-01-01", scale="tai")).at(dates).time
    assert (time.scale, time.format) == (scale, form)
    assert np.array_equal(time.jd1, dates.jd1)
    assert np.array_equal(time.jd2, dates.jd2)


@pytest.mark.parametrize(
    "t", [[1.0, 2.0], [1.0, 2.0] * u.min, TimeDelta([1.0, 2.0], format="sec")], ids=["s", "min", "span"]
)
@pytest.mark.parametrize(("scale", "form"), [("utc", "isot"), ("tt", "mjd"), ("tdb", "iso")])
def test_elapsed_time_is_dated_in_the_scale_and_format_of_the_epoch(t, scale, form):
    epoch = getattr(Time("2020-01-01", scale="utc", precision=6), scale)
    epoch.format = form
    time = spinner(epoch).at(t).time
    assert (time.scale, time.format, time.precision) == (scale, form, 6)


def test_callers_dates_and_ours_do_not_share_memory():
    epoch, dates = Time("2020-01-01"), Time(["2020-01-02", "2020-01-03"])
    ephemeris = spinner(epoch).at(dates)
    epoch.format, dates.format = "mjd", "mjd"
    dates[0] = Time("2019-01-01")
    assert ephemeris.epoch.format == ephemeris.time.format == "iso"
    assert ephemeris.time[0].iso == "2020-01-02 00:00:00.000"


def test_callers_seconds_and_ours_do_not_share_memory():
    t = np.array([0.0, 1.0])
    ephemeris = spinner().at(t)
    t[:] = 9.0
    assert ephemeris.elapsed.tolist() == [0.0, 1.0]
    assert ephemeris.angular_velocity[0] == pytest.approx(SPINNER[2], rel=ATTITUDE_TOLERANCE)


def test_ten_million_instants_build_no_time_and_nothing_but_the_answer():
    motion = spinner(Time("2020-01-01"))
    motion.at(np.arange(8.0))  # what compiles, compiles here
    t = np.linspace(0.0, 1e6, 10_000_000)
    tracemalloc.start()
    ephemeris = motion.at(t)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    answer = ephemeris.quaternion("wxyz").nbytes + ephemeris.elapsed.nbytes
    assert peak <= answer + 64 * 2**20
    assert ephemeris.instants._time is None


# -- UT1, and no network ------------------------------------------------------------------------

ut1_is_dubious_outside_its_tables = pytest.mark.filterwarnings("ignore:ERFA function:erfa.ErfaWarning")


@pytest.fixture
def no_network(monkeypatch):
    def refuse(*arguments, **named):
        raise AssertionError("reached for the network")

    monkeypatch.setattr(socket, "socket", refuse)
    monkeypatch.setattr(socket, "getaddrinfo", refuse)


def test_ut1_is_taken_from_the_tables(no_network):
    # IERS Bulletin D: UT1 - UTC is +0.6 s, to a tenth, from 2017-01-01
    elapsed = spinner(Time("2017-01-02", scale="utc")).at(Time("2017-01-02", scale="ut1")).elapsed
    assert elapsed == pytest.approx(-0.6, abs=0.05)


UT1 = {
    "dates": lambda: spinner(Time("2016-01-01")).at(Time(["2016-01-02"], scale="ut1")),
    "epoch": lambda: spinner(Time("2016-01-01", scale="ut1")),
    "dates made": lambda: spinner(Time("2016-01-01", scale="ut1")).at([0.0, 1.0]).time,
    "span": lambda: spinner(Time("2016-01-01")).at(TimeDelta([1.0], format="jd", scale="ut1")),
    "frame": lambda: spinner(Time("2026-11-20", scale="utc")).at([0.0, 1e6]).in_frame("ITRF"),
    "frame of SGP4": lambda: spinner(Time("2016-01-01", scale="ut1")).at([0.0, 1.0]).in_frame("TEME"),
}


CONFIGURATION = ("auto_download", "auto_max_age", "iers_auto_url", "remote_timeout")


@pytest.fixture
def astropys_configuration():
    """As astropy has it by default, with downloads; compared afterwards."""
    with iers.conf.set_temp("auto_download", True), iers.conf.set_temp("auto_max_age", 30.0):
        before = {name: getattr(iers.conf, name) for name in CONFIGURATION}
        yield
        assert {name: getattr(iers.conf, name) for name in CONFIGURATION} == before


@pytest.mark.parametrize("route", UT1.values(), ids=UT1)
def test_tables_of_ut1_are_never_downloaded(route, monkeypatch, no_network, astropys_configuration):
    consulted = []
    monkeypatch.setattr(iers.IERS_Auto, "_refresh_table_as_needed", lambda *_: consulted.append(True))
    route()
    assert not consulted  # of the table that updates itself nothing is asked


def test_other_threads_see_the_users_configuration_throughout(astropys_configuration):
    seen, done = set(), threading.Event()

    def watch():
        while not done.is_set():
            seen.add(iers.conf.auto_download)

    watcher = threading.Thread(target=watch)
    watcher.start()
    try:
        for route in UT1.values():
            route()
    finally:
        done.set()
        watcher.join()
    assert seen == {True}


def test_import_and_use_leave_astropys_configuration_as_it_was():
    program = """
from astropy.utils import data, iers
names = ("auto_download", "auto_max_age", "iers_auto_url", "iers_auto_url_mirror", "remote_timeout")
before = [getattr(iers.conf, name) for name in names], data.conf.allow_internet
import attitude
from astropy.time import Time
motion = attitude.TorqueFreeMotion(
    attitude.RigidBody((1, 2, 2.5)), (1, 0, 0, 0), (1, 2, 3),
    epoch=Time("2016-01-01", scale="ut1"), order="wxyz",
)
ephemeris = motion.at(Time(["2016-01-02"], scale="ut1"))
ephemeris.in_frame("ITRF"), ephemeris.in_frame("TEME"), ephemeris.time.tai
assert before == ([getattr(iers.conf, name) for name in names], data.conf.allow_internet)
"""
    run = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr


@pytest.mark.parametrize(
    "date", ["1973-02-02", "2016-12-31T23:59:59.9", "2017-01-01T00:00:00.3", "2020-02-29T12:34:56"]
)
def test_ut1_is_what_astropy_makes_of_the_same_tables(date):
    epoch = Time("2015-06-01", scale="tai")
    with iers.earth_orientation_table.set(iers.IERS_A(iers.IERS_Auto.read(iers.IERS_A_FILE))):
        expected = Time(date, scale="ut1").tai - epoch
        dated = (epoch + expected).ut1
    (elapsed,) = two_part(spinner(epoch).at(Time(date, scale="ut1")).instants)
    assert abs(elapsed - (Fraction(expected.jd1) + Fraction(expected.jd2)) * DAY) <= TIME_ROUNDING
    made = spinner(epoch).at(TimeDelta(expected)).instants
    made = Instants(made.seconds, made.seconds_low, made.epoch, scale="ut1").time
    assert abs((made - dated).to_value("s")) <= TIME_ROUNDING


def test_ut1_minus_utc_that_the_user_has_set_stands():
    instant = Time("2016-06-01", scale="ut1")
    instant.delta_ut1_utc = 0.25
    elapsed = spinner(Time("2016-06-01", scale="utc")).at(instant).elapsed
    assert elapsed == pytest.approx(-0.25, abs=1e-9)


def test_table_of_ut1_that_the_user_has_set_is_used():
    table = iers.IERS_B.open(iers.IERS_B_FILE)
    table["UT1_UTC"] = table["UT1_UTC"] + 0.125 * u.s
    epoch, instant = Time("2016-06-01", scale="utc"), Time("2016-06-01", scale="ut1")
    bundled = spinner(epoch).at(instant).elapsed
    with iers.earth_orientation_table.set(table):
        elapsed = spinner(epoch).at(instant).elapsed
    assert elapsed - bundled == pytest.approx(-0.125, abs=1e-5)


def test_predictions_of_ut1_are_taken_however_old_they_are(no_network, astropys_configuration):
    last = Time(iers.IERS_Auto.open().meta["predictive_mjd"] + 100.0, format="mjd", scale="ut1")
    assert abs(spinner(Time(last.mjd, format="mjd", scale="utc")).at(last).elapsed) < 1.0


@ut1_is_dubious_outside_its_tables
@pytest.mark.parametrize("date", ["1960-01-01", "2100-01-01"])
def test_ut1_outside_the_tables_is_refused(date):
    outside = Time(date, scale="ut1")
    with pytest.raises(InputError, match="scale 'ut1'") as caught:
        spinner(outside)
    assert caught.value.field == "epoch"
    with pytest.raises(InputError, match="scale 'ut1'") as caught:
        spinner(Time("2000-01-01")).at(outside)
    assert caught.value.field == "t"


@ut1_is_dubious_outside_its_tables
def test_ut1_of_elapsed_time_outside_the_tables_is_refused():
    ephemeris = spinner(Time("2016-01-01", scale="ut1")).at([0.0, 1e10])
    with pytest.raises(InputError, match="scale 'ut1'"):
        _ = ephemeris.time


def test_date_beyond_any_calendar_is_refused():
    still = TorqueFreeMotion(SPINNER[0], ATTITUDE, (0, 0, 0), epoch=Time("2000-01-01"), order="wxyz")
    ephemeris = still.at([1e20])
    with pytest.raises(InputError, match=r"scale 'utc'"):
        _ = ephemeris.time


# -- names and sums -------------------------------------------------------------------------------


@pytest.mark.parametrize(("old", "new"), [("rest", "seconds_low"), ("farthest", "max_abs_seconds")])
def test_old_names_of_instants_warn_and_answer(old, new):
    instants = spinner().at([0.1, -0.3] * u.d).instants
    with pytest.warns(DeprecationWarning, match=new):
        assert np.array_equal(getattr(instants, old), getattr(instants, new))


def test_two_sum_is_exact():
    draw = np.random.default_rng(1)
    a, b = draw.normal(size=(2, 200)) * 10.0 ** draw.integers(-15, 16, (2, 200))
    total, error = two_sum(a, b)
    assert np.array_equal(total, a + b)
    for x, y, high, low in zip(a, b, total, error, strict=True):
        assert Fraction(x) + Fraction(y) == Fraction(high) + Fraction(low)
