"""SPICE CK: CSPICE reads what was written, what it wrote is read, and its pool stays as it was."""

import os
import struct
import subprocess
import sys
import tempfile
import threading
from dataclasses import replace

import numpy as np
import pytest
from astropy.time import Time, TimeDelta

from attitude import AttitudeError, Ephemeris, FormatError, InputError, RigidBody, TorqueFreeMotion
from attitude.cli import main
from attitude.formats import interpolation_nodes
from attitude.formats.spice import ck, text_kernels
from attitude.samples import chunks
from attitude.samples.event import Event
from tests.formats.texts import clock_kernel

spice = pytest.importorskip("spiceypy")

BODY = RigidBody((1.0, 1.6, 2.1))
Q0, OMEGA = (0.1, -0.7, 0.5, 0.5), (0.3, -0.5, 0.9)
# Beside J2000, where SPICE's seconds past it have their digits.
EPOCH = Time(2451545.0, 0.25 / 86400, format="jd", scale="tt")
T = np.arange(60) / 4
STRUCTURE = -999000


@pytest.fixture(autouse=True)
def _empty_pool():
    spice.kclear()
    yield
    spice.kclear()


def motion(frame="ICRF", epoch=EPOCH, body=BODY, omega=OMEGA):
    return TorqueFreeMotion(body, Q0, omega, epoch, order="wxyz", frame=frame)


def written(folder, ephemeris=None, **options):
    """The path of a CK, and the ephemeris that it is of."""
    ephemeris = motion().at(T) if ephemeris is None else ephemeris
    ephemeris.write(folder / "a.bc", **options)
    return folder / "a.bc", ephemeris


def load(path):
    for ending in (".tls", ".tsc", ".tf", ".bc"):
        spice.furnsh(str(path.with_suffix(ending)))


def ticks_of(ephemeris, naif_id=-999):
    """By SPICE, from dates as text."""
    return [spice.sce2c(naif_id, et) for et in ets_of(ephemeris)]


def ets_of(ephemeris):
    return [spice.str2et(f"{date} TDT") for date in texts(ephemeris.time.tt)]


def texts(time):
    time = time.copy(format="isot")
    time.precision = 9
    return [text.replace("T", " ") for text in time.value]


def to_j2000(frame):
    """Of SPICE, or the frame bias of IAU 2006 from its four angles: components to those in the ICRF."""
    if frame != "EME2000":
        return spice.pxform({"ICRF": "J2000", "GCRF": "J2000"}.get(frame, frame), "J2000", 0.0)
    gamma, phi, psi, eps = np.deg2rad(np.array([-0.052928, 84381.412819, -0.041775, 84381.406]) / 3600)
    return (spice.rotate(-eps, 1) @ spice.rotate(-psi, 3) @ spice.rotate(phi, 1) @ spice.rotate(gamma, 3)).T


# -- what SPICE finds in it -----------------------------------------------------------------------


@pytest.mark.parametrize("frame", ["ICRF", "GCRF", "EME2000", "ECLIPJ2000"])
def test_pointing_at_the_records_is_that_of_the_ephemeris(frame, tmp_path):
    path, ephemeris = written(tmp_path, motion(frame).at(T))
    load(path)
    turn = to_j2000(frame)
    for i, ticks in enumerate(ticks_of(ephemeris)):
        matrix, rate, _ = spice.ckgpav(STRUCTURE, ticks, 0, "J2000")
        expected = turn @ ephemeris.rotation[i].as_matrix()
        assert np.abs(matrix - expected.T).max() < 1e-12
        assert np.abs(rate - expected @ ephemeris.angular_velocity[i]).max() < 1e-9 * np.linalg.norm(rate)


def test_frame_by_name_has_attitude_and_its_derivative(tmp_path):
    path, ephemeris = written(tmp_path)
    load(path)
    for i, et in enumerate(ets_of(ephemeris)[:-1]):
        turn = spice.sxform("OBJECT_999_BODY", "J2000", et)
        R, omega = ephemeris.rotation[i].as_matrix(), ephemeris.angular_velocity[i]
        cross = np.array([[0, -omega[2], omega[1]], [omega[2], 0, -omega[0]], [-omega[1], omega[0], 0]])
        assert np.abs(turn[:3, :3] - R).max() < 1e-12
        assert np.abs(turn[3:, :3] - R @ cross).max() < 1e-9
        assert np.abs(spice.pxform("OBJECT_999_BODY", "J2000", et) - R).max() < 1e-12


@pytest.mark.parametrize("type", [2, 3])
def test_between_records_spice_turns_at_a_constant_rate(type, tmp_path):
    path, ephemeris = written(tmp_path, type=type)
    load(path)
    ticks = ticks_of(ephemeris)
    for i in range(len(ticks) - 1):
        matrix, rate, _ = spice.ckgpav(STRUCTURE, 0.5 * (ticks[i] + ticks[i + 1]), 0, "J2000")
        one, other = ephemeris.rotation[i], ephemeris.rotation[i + 1]
        step = (other * one.inv()).as_rotvec()
        halfway = type_of(step * 0.5) * one
        assert np.abs(matrix - halfway.as_matrix().T).max() < 1e-12
        if type == 2:
            assert np.abs(rate - step / 0.25).max() < 1e-9


def type_of(rotation_vector):
    from scipy.spatial.transform import Rotation

    return Rotation.from_rotvec(rotation_vector)


def test_works_at_once_in_a_process_of_its_own(tmp_path):
    written(tmp_path)
    program = (
        "import spiceypy as s; s.furnsh('a.tm'); et = s.str2et('2000-01-01 12:00:05.25 TDT');"
        "print(s.sxform('J2000', 'OBJECT_999_BODY', et)[0][0], s.bodn2c('OBJECT_999'));"
        "print(s.et2utc(et, 'ISOC', 6))"
    )
    run = subprocess.run([sys.executable, "-c", program], cwd=tmp_path, capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    value, number, date = run.stdout.split()
    assert float(value) == pytest.approx(motion().at(5.0).rotation.as_matrix()[0, 0], abs=1e-12)
    assert (number, date) == ("-999", "2000-01-01T11:59:01.066000")


def test_clock_runs_evenly_across_a_leap_second(tmp_path):
    epoch = Time("2016-12-31T23:59:55", scale="utc")
    path, ephemeris = written(tmp_path, motion(epoch=epoch).at(np.arange(12.0)))
    load(path)
    dates = [f"2016-12-31T23:59:{second}" for second in range(55, 61)] + [
        f"2017-01-01T00:00:0{second}" for second in range(6)
    ]
    ticks = [spice.sce2c(-999, spice.str2et(date)) for date in dates]
    assert np.abs(np.diff(ticks) - 65536).max() < 65536e-6  # seconds past J2000 are good to 1e-7 s here
    back = [spice.et2utc(spice.sct2e(-999, tick), "ISOC", 3) for tick in ticks]
    assert back == [f"{date}.000" for date in dates]
    text = spice.sce2s(-999, spice.str2et(dates[5]))
    assert spice.scs2e(-999, text) == pytest.approx(spice.str2et(dates[5]), abs=1e-4)
    assert np.abs((Ephemeris.read(path).time - ephemeris.time).sec).max() < 1e-9


# -- spin ------------------------------------------------------------------------------------------


def segments_of(path):
    """(type, number of records) of each, by SPICE."""
    handle = spice.dafopr(str(path))
    spice.dafbfs(handle)
    found = []
    while spice.daffna():
        summary = spice.dafgs(5)
        _, integers = spice.dafus(summary, 2, 6)
        count = {2: spice.cknr02, 3: spice.cknr03}[integers[2]]
        found.append((integers[2], count(handle, summary)))
    spice.dafcls(handle)
    return found


SPINS = {
    "about the greatest axis": (BODY, (0.0, 0.0, 0.9)),
    "sphere": (RigidBody((2.0, 2.0, 2.0)), OMEGA),
    "at rest": (BODY, (0.0, 0.0, 0.0)),
}


@pytest.mark.parametrize(("body", "omega"), SPINS.values(), ids=SPINS)
def test_spin_is_one_record_of_type_2_and_exact_between_the_instants(body, omega, tmp_path):
    spin = motion(body=body, omega=omega)
    path, _ = written(tmp_path, spin.at(np.arange(0.0, 600.0, 100.0)), type=2)
    assert segments_of(path) == [(2, 1)]
    load(path)
    for t in (0.0, 33.25, 250.0, 499.0, 500.0):
        matrix, rate, _ = spice.ckgpav(STRUCTURE, (t + 0.25) * 65536, 0, "J2000")
        at = spin.at(t)
        assert np.abs(matrix - at.rotation.as_matrix().T).max() < 1e-12
        assert np.allclose(rate, at.rotation.apply(at.angular_velocity.copy()), rtol=0, atol=1e-12)


def test_long_spin_is_cut_where_turning_would_lose_digits(tmp_path):
    spin = motion(omega=(0.0, 0.0, 0.9))
    path, _ = written(tmp_path, spin.at(np.arange(0.0, 5e4, 50.0)), type=2)
    assert segments_of(path) == [(2, 45)]
    load(path)
    for t in np.linspace(0.0, 49950.0, 40):
        matrix, _, _ = spice.ckgpav(STRUCTURE, (t + 0.25) * 65536, 0, "J2000")
        assert np.abs(matrix - spin.at(t).rotation.as_matrix().T).max() < 1e-12


@pytest.mark.parametrize("scale", ["utc", "tai", "tt", "tdb", "ut1"])
def test_every_second_is_dated_as_spice_dates_it(scale, tmp_path):
    """Seconds that are no fraction of a day in binary: the clock's anchor was one second early for 2 of 5."""
    chance = np.random.default_rng(1)
    for year in range(1985, 2026, 5):
        second = float(chance.integers(86400))
        epoch = Time(f"{year}-03-04T00:00:00", scale=scale) + TimeDelta(second, format="sec")
        path, ephemeris = written(tmp_path, motion(epoch=epoch).at(T[:3]))
        load(path)
        coverage = spice.ckcov(str(path), STRUCTURE, False, "INTERVAL", 0.0, "TDB")
        tt = spice.unitim(coverage[0], "TDB", "TDT")
        expected = (ephemeris.time[0].tt - Time("2000-01-01T12:00:00", scale="tt")).sec
        assert abs(tt - expected) < 2e-5, epoch.isot  # a tick
        assert abs((Ephemeris.read(path).time[0].tt - ephemeris.time[0].tt).sec) < 1e-9
        spice.kclear()


@pytest.mark.parametrize(("rate", "count"), [(0.9, 288), (0.003, 2), (-6.0, 1911)])
def test_spin_comes_back_as_the_ends_of_its_records_and_right_angles_between(rate, count, tmp_path):
    """Attitudes at the ends alone tell no whole turns: between them readers would see another motion."""
    spin = motion(omega=(0.0, 0.0, rate))
    path, ephemeris = written(tmp_path, spin.at(np.arange(0.0, 600.0, 100.0)), type=2)
    back = Ephemeris.read(path)
    assert (back.elapsed[0], back.elapsed[-1], len(back)) == (0.25, 500.25, count)
    assert (
        np.abs(
            np.abs((back.quaternion("wxyz")[[0, -1]] * ephemeris.quaternion("wxyz")[[0, -1]]).sum(1)) - 1
        ).max()
        < 1e-13
    )
    t = np.array([0.1, 123.4, 250.0, 377.7, 499.9])
    turned = back.resampled(t + 0.25).rotation.inv() * spin.at(t).rotation
    assert turned.magnitude().max() < 1e-9
    assert np.abs(back.angular_velocity - ephemeris.angular_velocity[0]).max() < 1e-14


# -- segments ----------------------------------------------------------------------------------------


def with_impulses(*seconds, frame="ICRF"):
    whole = motion(frame).at(T)
    events = tuple(Event(at, "impulse", "") for at in seconds)
    quaternion, rate = whole.quaternion("wxyz").copy(), whole.angular_velocity.copy()
    return Ephemeris(quaternion, whole.instants, frame, None, rate, events=events)


@pytest.mark.parametrize("type", [2, 3])
def test_nothing_is_interpolated_across_an_impulse(type, tmp_path):
    path, ephemeris = written(tmp_path, with_impulses(4.9, 10.0), type=type)
    load(path)
    assert len(segments_of(path)) == 3
    ticks = ticks_of(ephemeris)
    cell = spice.ckcov(str(path), STRUCTURE, False, "INTERVAL", 0.0, "SCLK")
    expected = [(ticks[0], ticks[19]), (ticks[20], ticks[39]), (ticks[40], ticks[59])]
    assert [spice.wnfetd(cell, i) for i in range(spice.wncard(cell))] == expected
    with pytest.raises(spice.NotFoundError):
        spice.ckgpav(STRUCTURE, 0.5 * (ticks[39] + ticks[40]), 0, "J2000")
    back = Ephemeris.read(path)
    assert [(event.kind, event.seconds) for event in back.events] == [("segment", 5.25), ("segment", 10.25)]
    assert len(back) == 60


def test_an_attitude_alone_between_impulses_is_kept(tmp_path):
    path, ephemeris = written(tmp_path, with_impulses(4.9, 5.1))
    load(path)
    matrix, _, _ = spice.ckgpav(STRUCTURE, ticks_of(ephemeris)[20], 0, "J2000")
    assert np.abs(matrix - ephemeris.rotation[20].as_matrix().T).max() < 1e-12
    assert np.array_equal(Ephemeris.read(path).quaternion("wxyz"), ephemeris.quaternion("wxyz"))
    with pytest.raises(FormatError, match="type 2 holds intervals"):
        ephemeris.write(tmp_path / "b.bc", type=2)


@pytest.mark.parametrize("type", [2, 3])
def test_blocks_share_their_boundary_so_that_no_time_is_left_out(type, tmp_path, monkeypatch):
    monkeypatch.setattr(chunks, "CHUNK_INSTANTS", 7)
    path, ephemeris = written(tmp_path, type=type)
    assert len(segments_of(path)) == 9
    load(path)
    cell = spice.ckcov(str(path), STRUCTURE, True, "INTERVAL", 0.0, "SCLK")
    assert spice.wncard(cell) == 1
    back = Ephemeris.read(path)
    assert back.events == ()
    assert np.abs(back.quaternion("wxyz") - ephemeris.quaternion("wxyz")).max() < 1e-15
    assert np.array_equal(back.elapsed, T + 0.25)


# -- round trip --------------------------------------------------------------------------------------


@pytest.mark.parametrize("frame", ["ICRF", "ECLIPJ2000"])
def test_bits_of_quaternions_and_instants_come_back(frame, tmp_path):
    ephemeris = motion(frame).at(T)
    ephemeris = replace(ephemeris, name="4179 Toutatis")
    path, _ = written(tmp_path, ephemeris)
    back = Ephemeris.read(path)
    assert np.array_equal(back.quaternion("wxyz"), ephemeris.quaternion("wxyz"))
    assert np.abs(back.angular_velocity - ephemeris.angular_velocity).max() < 1e-15
    assert (back.frame, back.name, back.epoch.scale) == (frame, "4179 Toutatis", "tt")
    assert np.array_equal(back.elapsed, T + 0.25)


def test_attitudes_alone_are_written_without_rates(tmp_path):
    whole = motion().at(T)
    alone = Ephemeris(whole.quaternion("wxyz").copy(), whole.instants, "ICRF")
    for ephemeris, options in ((alone, {}), (whole, {"rates": False})):
        path, _ = written(tmp_path, ephemeris, **options)
        back = Ephemeris.read(path)
        assert not back.has_rate
        assert np.array_equal(back.quaternion("wxyz"), whole.quaternion("wxyz"))
        load(path)
        spice.ckgp(STRUCTURE, ticks_of(whole)[3], 0, "J2000")
        with pytest.raises(spice.NotFoundError):
            spice.ckgpav(STRUCTURE, ticks_of(whole)[3], 0, "J2000")
        spice.kclear()


def test_a_user_may_name_numbers_and_frame(tmp_path):
    ephemeris = motion("INERTIAL").at(T)
    options = {"naif_id": 20004179, "structure_id": -5001, "reference": "GALACTIC", "frame_name": "TOU"}
    path, _ = written(tmp_path, ephemeris, **options)
    load(path)
    matrix, _, _ = spice.ckgpav(-5001, spice.sce2c(20004179, ets_of(ephemeris)[4]), 0, "GALACTIC")
    assert np.abs(matrix - ephemeris.rotation[4].as_matrix().T).max() < 1e-12
    assert spice.namfrm("TOU") == -5001
    with pytest.raises(FormatError, match="clock_id=20004179 takes that clock"):
        Ephemeris.read(path)
    back = Ephemeris.read(path, fk=path.with_suffix(".tf"))
    assert back.frame == "ICRF"
    matrix, _, _ = spice.ckgpav(-5001, spice.sce2c(20004179, ets_of(ephemeris)[4]), 0, "J2000")
    assert np.abs(matrix - back.rotation[4].as_matrix().T).max() < 1e-12


def test_comments_say_convention_frame_and_error(tmp_path):
    path, _ = written(tmp_path, motion("EME2000").at(T))
    handle = spice.dafopr(str(path))
    _, lines, done = spice.dafec(handle, 50, 1000)
    spice.dafcls(handle)
    text = "\n".join(lines)
    assert done
    for part in (
        "q rotates body to inertial",
        "relative to EME2000; here to J2000",
        "the conjugate",
        "interpolation",
    ):
        assert part in text


NAMES = {
    "Åström \N{GREEK SMALL LETTER ALPHA}-1\n": "ASTROM_1_BODY",
    "x" * 90: "X" * 21 + "_BODY",
    "日本": "OBJECT_999_BODY",
}


@pytest.mark.parametrize(("name", "frame"), NAMES.items(), ids=["accents", "long", "other letters"])
def test_frame_is_called_as_the_ephemeris_if_spice_can(name, frame, tmp_path):
    ephemeris = motion().at(T)
    ephemeris = replace(ephemeris, name=name)
    path, _ = written(tmp_path, ephemeris)
    load(path)
    assert spice.namfrm(frame) == STRUCTURE
    assert len(Ephemeris.read(path)) == len(T)


def test_file_names_that_a_text_kernel_cannot_hold_go_without_a_meta_kernel(tmp_path):
    ephemeris = motion().at(T)
    ephemeris.write(tmp_path / "å.bc")
    assert sorted(entry.suffix for entry in tmp_path.iterdir()) == [".bc", ".tf", ".tls", ".tsc"]
    long = "x" * 150 + "'s"
    (tmp_path / "b").mkdir()
    ephemeris.write(tmp_path / "b" / f"{long}.bc")
    program = f"import spiceypy as s; s.furnsh({long!r} + '.tm'); print(s.ktotal('all'))"
    run = subprocess.run([sys.executable, "-c", program], cwd=tmp_path / "b", capture_output=True, text=True)
    assert run.stdout.strip() == "5", run.stderr


def test_name_of_a_text_kernel_is_refused(tmp_path):
    with pytest.raises(FormatError, match=r"\.bc is usual"):
        motion().at(T).write(tmp_path / "a.tf", format="ck")
    assert list(tmp_path.iterdir()) == []


# -- of others ---------------------------------------------------------------------------------------

# Two correlations of a clock of 256 ticks a second, which runs 3 ppm slow and then 5 ppm fast.
RATES = """0.0000000000000D+00   1.2600000012345D+08  1.00000300D+00
           2.5600000000000D+05   1.2600100012645D+08  0.99999500D+00"""


def other_clock(system=2):
    return clock_kernel(82, RATES, system, "0.0D0", "1.099511627776E+12")


def other(folder, system=1, **changes):
    """A CK as another program makes one: Cassini's numbers, two intervals, no rates."""
    (folder / "c.tsc").write_text(other_clock(system))
    ticks = np.array([100.0, 300.0, 1000.0, 300000.0, 300500.0])
    q = np.ascontiguousarray(motion().at(np.arange(5.0)).quaternion("wxyz") * [-1, 1, 1, 1])
    handle = spice.ckopn(str(folder / "c.bc"), "other", 0)
    made = {"inst": -82000, "ref": "J2000", "starts": ticks[[0, 3]], **changes}
    zero = np.zeros((5, 3))
    spice.ckw03(
        handle, 100.0, 300500.0, made["inst"], made["ref"], False, "CAS", 5, ticks, q, zero, 2, made["starts"]
    )
    spice.ckcls(handle)
    return folder / "c.bc", ticks, q


@pytest.mark.parametrize("system", [1, 2], ids=["TDB", "TT"])
def test_clock_of_another_dates_records_as_spice_does(system, tmp_path):
    path, ticks, q = other(tmp_path, system)
    back = Ephemeris.read(path)
    (tmp_path / "a.tls").write_text(text_kernels.leap_seconds())
    spice.furnsh([str(tmp_path / "a.tls"), str(tmp_path / "c.tsc")])
    expected = [spice.unitim(spice.sct2e(-82, tick), "ET", "TDT") for tick in ticks]
    found = (back.epoch.tt - Time("2000-01-01T12:00:00", scale="tt")).sec + back.elapsed
    assert np.abs(found - expected).max() < 1e-6
    assert np.array_equal(back.quaternion("wxyz"), q * [1, -1, -1, -1])
    assert not back.has_rate
    assert [event.seconds for event in back.events] == [back.elapsed[3]]


def test_kernel_of_another_place_is_taken_where_named(tmp_path):
    path, _, _ = other(tmp_path)
    (tmp_path / "c.tsc").rename(tmp_path / "clock.tsc")
    with pytest.raises(FormatError, match=r"SCLK kernel .*c\.tsc cannot be read .*sclk= names another"):
        Ephemeris.read(path)
    assert len(Ephemeris.read(path, sclk=tmp_path / "clock.tsc")) == 5


ANOTHER = {
    "of another spacecraft": (
        -900000,
        r"_900, the clock of structure -900000 .*c\.tsc has clock 82 of ",
    ),
    "of a neighbour": (-81999, "_81, the clock of structure -81999 on spacecraft -81; .*clock_id=-82 takes"),
    "of a body of positive number": (82000, "_-82, the clock of structure 82000 on spacecraft 82; "),
    "of a number that tells none": (-82, "structure -82 does not tell its spacecraft; .*clock_id=-82 takes"),
}


@pytest.mark.parametrize(("structure", "words"), ANOTHER.values(), ids=ANOTHER)
def test_clock_of_another_spacecraft_is_refused_unless_it_is_named(structure, words, tmp_path):
    path, ticks, _ = other(tmp_path, system=2, inst=structure)
    with pytest.raises(FormatError, match=words) as caught:
        Ephemeris.read(path)
    assert caught.value.source == str(path)
    back = Ephemeris.read(path, clock_id=-82)
    assert len(back) == len(ticks)
    since = (back.time[0].tt - Time("2000-01-01T12:00:00", scale="tt")).sec
    assert since == pytest.approx(1.2600000012345e8 + 100 / 256, abs=1e-5)
    with pytest.raises(FormatError, match=r"_-82, which clock_id=82 names; .*c.tsc has clock 82"):
        Ephemeris.read(path, clock_id=82)


def test_of_several_clocks_that_of_the_structure_or_the_one_named_is_taken(tmp_path):
    path, _, _ = other(tmp_path, system=2)
    later = other_clock().replace("_82", "_83").replace("1.2600", "2.2600")
    (tmp_path / "c.tsc").write_text((tmp_path / "c.tsc").read_text() + later.partition("KPL/SCLK")[2])
    mine, named = Ephemeris.read(path), Ephemeris.read(path, clock_id=-83)
    assert (named.time[0] - mine.time[0]).sec == pytest.approx(1e8, abs=1e-3)
    with pytest.raises(FormatError, match=r"_84, which clock_id=-84 names; .* clock 82 .*, clock 83 "):
        Ephemeris.read(path, clock_id=-84)


@pytest.mark.parametrize("clock_id", [0, True, "x", 1.5])
def test_clock_id_is_a_whole_number(clock_id, tmp_path):
    path, _, _ = other(tmp_path)
    with pytest.raises(InputError, match="clock_id: a whole number other than 0"):
        Ephemeris.read(path, clock_id=clock_id)


@pytest.mark.parametrize("naif_id", [-999, -1, 2000433, -2_000_000])
def test_own_files_need_no_name_of_the_clock_where_the_structure_tells_it(naif_id, tmp_path):
    path, ephemeris = written(tmp_path, naif_id=naif_id)
    assert len(Ephemeris.read(path)) == len(ephemeris)
    path, _ = written(tmp_path, naif_id=naif_id, structure_id=naif_id * 1000 + (7 if naif_id > 0 else -7))
    assert len(Ephemeris.read(path)) == len(ephemeris)
    path, _ = written(tmp_path, naif_id=naif_id, structure_id=-12345)
    with pytest.raises(
        FormatError, match=f"_12, the clock of structure -12345 .*clock_id={naif_id} takes that clock"
    ):
        Ephemeris.read(path)
    back = Ephemeris.read(path, clock_id=naif_id)
    assert np.abs((back.time - ephemeris.time).sec).max() < 1e-6


def test_convert_takes_options_of_the_format_that_is_read(tmp_path, capsys):
    path, _, _ = other(tmp_path, inst=-900000)
    assert main(["convert", str(path), "-o", str(tmp_path / "c.csv")]) == 2
    assert "clock_id=-82 takes that clock" in capsys.readouterr().err
    assert main(["convert", str(path), "-q", "-o", str(tmp_path / "c.csv"), "--set", "clock_id=-82"]) == 0
    assert np.array_equal(
        Ephemeris.read(tmp_path / "c.csv").elapsed, Ephemeris.read(path, clock_id=-82).elapsed
    )
    both = [
        "--set",
        "clock_id=-82",
        "--set",
        "structure_id=-5",
        "--set",
        "naif_id=-5",
    ]  # the latter are the writer's
    assert main(["convert", str(path), "-q", "-o", str(tmp_path / "d.bc"), *both]) == 0
    assert len(Ephemeris.read(tmp_path / "d.bc", clock_id=-5)) == 5
    assert main(["convert", str(path), "-o", str(tmp_path / "c.csv"), "--set", "clock=1"]) == 2


def test_structures_are_read_one_at_a_time(tmp_path):
    path, _, _ = other(tmp_path)
    handle = spice.dafopw(str(path))
    q = np.tile([1.0, 0, 0, 0], (2, 1))
    spice.ckw03(
        handle, 1.0, 2.0, -82001, "J2000", False, "B", 2, np.array([1.0, 2.0]), q, np.zeros((2, 3)), 1, [1.0]
    )
    spice.dafcls(handle)
    with pytest.raises(FormatError, match="structure_id is one of -82001, -82000; got None"):
        Ephemeris.read(path)
    assert len(Ephemeris.read(path, structure_id=-82001)) == 2


def test_intervals_of_type_2_with_gaps_and_jumps(tmp_path):
    (tmp_path / "c.tsc").write_text(other_clock())
    start, stop = np.array([0.0, 256.0, 1024.0]), np.array([256.0, 512.0, 1280.0])
    q, rate = np.tile([1.0, 0, 0, 0], (3, 1)), np.tile([0.0, 0, np.pi / 2], (3, 1))
    handle = spice.ckopn(str(tmp_path / "c.bc"), "other", 0)
    spice.ckw02(handle, 0.0, 1280.0, -82000, "J2000", "C", 3, start, stop, q, rate, [1 / 256] * 3)
    spice.ckcls(handle)
    back = Ephemeris.read(tmp_path / "c.bc")
    # the attitude jumps back after the first second, and nothing is known between 2 and 4
    assert np.allclose(back.elapsed - back.elapsed[0], [0, 1, 2, 4, 5], rtol=0, atol=5e-6 * 5)
    assert np.allclose(back.quaternion("wxyz")[:, 3], [0, 0, 0.5**0.5, 0, 0.5**0.5], rtol=0, atol=1e-15)
    assert len(back.events) == 2


def test_bytes_in_the_other_order_are_read(tmp_path):
    path, ephemeris = written(tmp_path)
    path.write_bytes(swapped(path.read_bytes()))
    spice.furnsh(str(path))  # CSPICE takes it for a CK too
    back = Ephemeris.read(path)
    assert np.array_equal(back.quaternion("wxyz"), ephemeris.quaternion("wxyz"))


def swapped(data):
    """A little-endian DAF of one summary record as a big-endian one."""

    def integers(part):
        return np.frombuffer(part, "<i4").astype(">i4").tobytes()

    def doubles(part):
        return np.frombuffer(part, "<f8").astype(">f8").tobytes()

    first = struct.unpack_from("<i", data, 76)[0]
    head = data[:8] + integers(data[8:16]) + data[16:76] + integers(data[76:88]) + b"BIG-IEEE" + data[96:1024]
    at = (first - 1) * 1024
    begin = at + 2048
    summary = doubles(data[at : at + 40]) + integers(data[at + 40 : at + 64]) + data[at + 64 : at + 1024]
    return head + data[1024:at] + summary + data[at + 1024 : begin] + doubles(data[begin:])


# -- the process and its files -----------------------------------------------------------------------


def test_pool_of_the_user_stays_as_it_was(tmp_path):
    (tmp_path / "mine.tls").write_text(text_kernels.leap_seconds())
    spice.furnsh(str(tmp_path / "mine.tls"))
    spice.pdpool("MINE", [1.0, 2.0])
    path, _ = written(tmp_path)
    Ephemeris.read(path)
    assert spice.ktotal("all") == 1
    assert spice.gdpool("MINE", 0, 5).tolist() == [1.0, 2.0]
    with pytest.raises(spice.NotFoundError):
        spice.gnpool("SCLK*", 0, 10)
    with pytest.raises(AttitudeError):
        Ephemeris.read(tmp_path / "mine.tls", format="ck")
    assert not spice.failed()


def test_files_are_written_from_many_threads(tmp_path):
    def work(i):
        (tmp_path / str(i)).mkdir()
        written(tmp_path / str(i), motion().at(T + i))

    threads = [threading.Thread(target=work, args=(i,)) for i in range(6)]
    [thread.start() for thread in threads]
    [thread.join() for thread in threads]
    for i in range(6):
        back = Ephemeris.read(tmp_path / str(i) / "a.bc")
        assert np.array_equal(back.quaternion("wxyz"), motion().at(T + i).quaternion("wxyz"))


class Interruption(BaseException):
    """As Ctrl-C."""


def test_interrupted_write_leaves_no_ck_and_no_open_file(tmp_path, monkeypatch):
    monkeypatch.setattr(chunks, "CHUNK_INSTANTS", 7)
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr(tempfile, "tempdir", None)

    def interrupt(done):
        if done > 0.5:
            raise Interruption

    with pytest.raises(Interruption):
        motion().at(T).write(tmp_path / "a.bc", progress=interrupt)
    left = sorted(entry.name for entry in tmp_path.iterdir())
    assert not [name for name in left if name.endswith(".bc") or "." not in name or name.startswith(".")]
    for _ in range(30):  # CSPICE has few handles for files it writes
        with pytest.raises(Interruption):
            motion().at(T).write(tmp_path / "a.bc", progress=interrupt)
    written(tmp_path)


def test_standard_output_is_no_place_for_several_files(tmp_path, monkeypatch, capfdbinary):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(FormatError, match="ck has companion files"):
        motion().at(T).write("-", format="ck")
    assert capfdbinary.readouterr().out == b""
    assert os.listdir() == []


def test_without_spiceypy_the_extra_is_named(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "spiceypy", None)
    with pytest.raises(FormatError, match=r"spiceypy: pip install 'attitude\[spice\]'"):
        motion().at(T).write(tmp_path / "a.bc")
    assert not (tmp_path / "a.bc").exists()


# -- what is refused ---------------------------------------------------------------------------------

REFUSED = {
    "undated": (lambda: motion(epoch=None).at(T), {}, FormatError, "without an epoch"),
    "a batch": (
        lambda: TorqueFreeMotion(BODY, [Q0, Q0], OMEGA, EPOCH, order="wxyz").at(T),
        {},
        FormatError,
        "one body",
    ),
    "backwards": (lambda: motion().at(T[::-1]), {}, FormatError, "increasing order"),
    "twice": (lambda: motion().at([0.0, 1.0, 1.0]), {}, FormatError, "increasing order"),
    "too long": (lambda: motion().at([0.0, 7e10]), {}, FormatError, "more than the clock"),
    "no reference": (lambda: motion("INERTIAL").at(T), {}, InputError, "reference"),
    "reference of a rotating frame": (
        lambda: motion("INERTIAL").at(T),
        {"reference": "IAU_EARTH"},
        InputError,
        "reference",
    ),
    "reference of a known frame": (lambda: motion().at(T), {"reference": "J2000"}, InputError, "reference"),
    "type 1": (lambda: motion().at(T), {"type": 1}, InputError, "type: 2, 3, 5 or 6"),
    "type 2 without rates": (lambda: motion().at(T), {"type": 2, "rates": False}, InputError, "rates"),
    "no number": (lambda: motion().at(T), {"naif_id": 0}, InputError, "naif_id"),
    "number too large": (lambda: motion().at(T), {"naif_id": -3_000_000}, InputError, "structure_id"),
    "frame of small letters": (lambda: motion().at(T), {"frame_name": "tou"}, InputError, "frame_name"),
}


@pytest.mark.parametrize(("make", "options", "error", "message"), REFUSED.values(), ids=REFUSED)
def test_what_a_ck_cannot_hold_is_refused_and_leaves_no_ck(make, options, error, message, tmp_path):
    with pytest.raises(error, match=message):
        make().write(tmp_path / "a.bc", **options)
    assert not (tmp_path / "a.bc").exists()


def put(at, form, *values):
    """The file with other numbers at a byte."""

    def changed(data):
        data = bytearray(data)
        struct.pack_into(form, data, at, *values)
        return bytes(data)

    return changed


def summary_of(data):
    return (struct.unpack_from("<i", data, 76)[0] - 1) * 1024


def in_summary(at, form, *values):
    return lambda data: put(summary_of(data) + at, form, *values)(data)


def in_array(word, form, *values):
    """Words of the segment, from its first or from its end."""

    def changed(data):
        begin, end = struct.unpack_from("<ii", data, summary_of(data) + 56)
        return put(((begin - 1 if word >= 0 else end) + word) * 8, form, *values)(data)

    return changed


DAMAGED = {
    "empty": (lambda data: b"", "does not begin with DAF/CK"),
    "text": (lambda data: b"KPL/SCLK" + data[8:], "does not begin with DAF/CK"),
    "an SPK": (lambda data: b"DAF/SPK " + data[8:], "does not begin with DAF/CK"),
    "cut in the first record": (lambda data: data[:600], "file record"),
    "VAX": (lambda data: data[:88] + b"VAX-GFLT" + data[96:], "IEEE"),
    "through a text transfer": (lambda data: data.replace(b"\r\n", b"\n\n"), "transfer as text"),
    "other descriptors": (put(8, "<ii", 3, 6), "descriptors of 3 doubles"),
    "cut in the middle": (lambda data: data[: len(data) // 2], "in a file of"),
    "cut before the summaries": (lambda data: data[:1024], "list is corrupt"),
    "summaries in a ring": (
        lambda data: in_summary(0, "<d", summary_of(data) // 1024 + 1)(data),
        "list is corrupt",
    ),
    "no next record": (in_summary(0, "<d", float("nan")), "list is corrupt"),
    "too many summaries": (in_summary(16, "<d", 1e9), "summaries in a record"),
    "array before the file": (in_summary(56, "<i", -5), "an array from -5"),
    "type 5": (in_summary(48, "<i", 5), "a segment of subtype"),
    "of the Earth": (in_summary(44, "<i", 10013), "frame 10013"),
    "rates that are none": (in_summary(52, "<i", 0), "does not match its counts"),
    "count of records": (in_array(-1, "<d", 61.0), "does not match its counts"),
    "no count": (in_array(-1, "<d", 0.0), "a count of 0.0"),
    "NaN": (in_array(2, "<d", float("nan")), "not finite"),
    "not unit": (in_array(0, "<d", 3.0), "unit quaternion"),
    "instants that do not increase": (in_array(60 * 7 + 3, "<d", 1.0), "do not increase"),
    "interval of no record": (in_array(-3, "<d", 17.0), "begin between the records"),
}


@pytest.mark.parametrize(("change", "message"), DAMAGED.values(), ids=DAMAGED)
def test_damaged_files_are_refused(change, message, tmp_path):
    path, _ = written(tmp_path)
    path.write_bytes(change(path.read_bytes()))
    with pytest.raises(FormatError, match=message) as caught:
        Ephemeris.read(path)
    assert caught.value.source == str(path)


CLOCKS = {
    "empty": (lambda text: "", "no SCLK_DATA_TYPE_999, the clock of structure -999000"),
    "open": (lambda text: text.replace("1 )\n\n", "1\n\n"), "closing parenthesis"),
    "no assignment": (lambda text: text.replace("SCLK01_N_FIELDS_999", "N FIELDS"), "no assignment"),
    "type 2": (lambda text: text.replace("TYPE_999         = ( 1 )", "TYPE_999 = ( 2 )"), "not of type 1"),
    "other time": (lambda text: text.replace("SYSTEM_999     = ( 2 )", "SYSTEM_999 = ( 3 )"), "not of type"),
    "word": (lambda text: text.replace("( 68719476736 65536 )", "( a b )"), "not of type 1"),
    "stopped": (lambda text: text.replace("0  0  1 )", "0  0  0 )"), "not of type 1"),
    "later": (
        lambda text: text.replace("( 4503599627370496 )", "( 65536 )"),
        "ticks 16384.0 to 983040.0, of a clock from 0 to 65536.0",
    ),
    "far": (lambda text: text.replace("( 0  0  1 )", "( 0  1D15  1 )"), "beyond any calendar"),
}


@pytest.mark.parametrize(("change", "message"), CLOCKS.values(), ids=CLOCKS)
def test_malformed_clocks_are_refused(change, message, tmp_path):
    path, _ = written(tmp_path)
    clock = path.with_suffix(".tsc")
    text = clock.read_text()
    assert change(text) != text
    clock.write_text(change(text))
    with pytest.raises(FormatError, match=message):
        Ephemeris.read(path)


def test_memory_does_not_grow_with_the_number_of_records(tmp_path):
    program = f"""
import resource, time, numpy as np
from astropy.time import Time
from attitude import RigidBody, TorqueFreeMotion, formats
from attitude.times.instants import Grid
from attitude.samples.chunks import Samples
epoch = Time("2000-01-01T12:00:00", scale="tt")
motion = TorqueFreeMotion(RigidBody((1, 1.6, 2.1)), {Q0}, {OMEGA}, epoch, order="wxyz")
def of(n):
    grid = Grid(0, n / 8, count=n)
    return Samples(n, lambda a, b: motion.ephemeris(grid.part(a, b, epoch)))
formats.write(of(100_000), {str(tmp_path / "a.bc")!r})
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
formats.write(of(400_000), {str(tmp_path / "a.bc")!r})
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before)
"""
    run = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    assert int(run.stdout) < 10 * 1024  # KiB; the records grow by 19 MB


def test_readers_are_told_that_they_turn_evenly():
    assert (
        ck.CkOptions().interpolant
        == ck.CkOptions(type=2).interpolant
        == interpolation_nodes.Interpolant("slerp")
    )
