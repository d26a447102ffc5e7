"""CKs that CSPICE writes (types 1, 2, 3, 5, 6; its frames and clocks), read as CSPICE reads them."""

import ctypes

import numpy as np
import pytest
from astropy.time import Time, TimeDelta

from attitude import Ephemeris, FormatError, InputError, RigidBody, Scene, TorqueFreeMotion
from attitude.formats.spice import reference_frames, sclk, text_kernels
from attitude.frames import rotations
from tests.formats.texts import clock_kernel

spice = pytest.importorskip("spiceypy")

INST, SC = -900000, -900
J2000 = Time("2000-01-01T12:00:00", scale="tt")
TICKS_PER_SECOND = 256
MOTION = TorqueFreeMotion(
    RigidBody((1.0, 1.6, 2.1)), (0.1, -0.7, 0.5, 0.5), (0.03, -0.05, 0.09), order="wxyz"
)
SECONDS = np.array([1.0, 2, 3.5, 5, 7, 8, 9, 11, 12.5, 14, 16, 18, 21, 22, 23, 25, 26, 27, 29, 30])
STARTS = np.array([0, 9, 14])  # records at which intervals begin


@pytest.fixture(autouse=True)
def no_kernels():
    spice.kclear()
    yield
    spice.kclear()


def clock(folder, rows="0 757382469.184 1", system=2, starts="0", ends="1.0995116277E+12"):
    (folder / "a.tsc").write_text(clock_kernel(900, rows, system, starts, ends))
    (folder / "a.tls").write_text(text_kernels.leap_seconds())
    spice.furnsh([str(folder / "a.tls"), str(folder / "a.tsc")])


def records(seconds):
    """Ticks, SPICE's quaternions with their derivatives, and velocities with theirs, along inertial axes."""
    made, step = MOTION.at(seconds), 1e-3
    ticks = seconds * TICKS_PER_SECOND
    q = made.quaternion("wxyz")
    omega = rotations.rotate(q, made.angular_velocity)
    pure = np.concatenate([np.zeros((len(q), 1)), made.angular_velocity], axis=1)
    slope = 0.5 * rotations.product(q, pure)
    nearby = [MOTION.at(seconds + d) for d in (-step, step)]
    before, after = (rotations.rotate(n.quaternion("wxyz"), n.angular_velocity) for n in nearby)
    conjugated = [np.ascontiguousarray(rotations.conjugate(part)) for part in (q, slope)]
    return ticks, *conjugated, omega, (after - before) / (2 * step)


def packets(subtype, seconds):
    ticks, q, dq, av, dav = records(seconds)
    return ticks, np.ascontiguousarray(
        np.concatenate([[q, dq], [q], [q, dq, av, dav], [q, av]][subtype], axis=1)
    )


def added(
    path, kind, seconds=SECONDS, starts=STARTS, ref="J2000", flag=True, subtype=0, window=4, cover=None
):
    """A segment of this type, at the end of the file."""
    handle = spice.dafopw(str(path)) if path.exists() else spice.ckopn(str(path), "a", 0)
    ticks, q, _, av, _ = records(seconds)
    first, last = (ticks[0], ticks[-1]) if cover is None else np.multiply(cover, TICKS_PER_SECOND)
    n = len(ticks)
    if kind == 1:
        spice.ckw01(handle, first, last, INST, ref, flag, "A", n, ticks, q, av)
    elif kind == 2:
        ends = np.append(ticks[1:], ticks[-1] + TICKS_PER_SECOND) - np.where(
            np.isin(np.arange(n) + 1, starts), 9, 0
        )
        rates = np.full(n, 1 / TICKS_PER_SECOND)
        spice.ckw02(handle, ticks[0], ends[-1], INST, ref, "A", n, ticks, ends, q, av, rates)
    elif kind == 3:
        spice.ckw03(handle, first, last, INST, ref, flag, "A", n, ticks, q, av, len(starts), ticks[starts])
    elif kind == 5:
        degree = 2 * window - 1 if subtype in (0, 2) else window - 1
        table, rate = packets(subtype, seconds)[1], 1 / TICKS_PER_SECOND
        span, intervals = (first, last, INST, ref), (len(starts), ticks[starts])
        spice.ckw05(handle, subtype, degree, *span, flag, "A", ticks, table, rate, *intervals)
    spice.dafcls(handle)


def added_type_6(path, parts, bounds, takes_last, flag=True):
    """Mini-segments (subtype, window, seconds) between bounds; spiceypy does not wrap CSPICE's writer."""
    libspice = pytest.importorskip("spiceypy.utils.libspicehelper").libspice
    handle = spice.ckopn(str(path), "a", 0)
    tables = [packets(subtype, seconds) for subtype, _, seconds in parts]
    degrees = [2 * window - 1 if subtype in (0, 2) else window - 1 for subtype, window, _ in parts]

    def ints(values):
        return (ctypes.c_int * len(values))(*values)

    def doubles(values):
        values = np.concatenate([np.ravel(value) for value in values])
        return (ctypes.c_double * len(values))(*values)

    edges = np.multiply(bounds, TICKS_PER_SECOND)
    counts = ints([len(table[0]) for table in tables])
    libspice.ckw06_(
        ints([handle]), ints([INST]), b"J2000", ints([int(flag)]), doubles([edges[0]]), doubles([edges[-1]]),
        b"A", ints([len(parts)]), counts, ints([part[0] for part in parts]), ints(degrees),
        doubles([table[1] for table in tables]), doubles([[1 / TICKS_PER_SECOND] * len(parts)]),
        doubles([table[0] for table in tables]), doubles([edges]), ints([int(takes_last)]), 5, 1,
    )  # fmt: skip
    spice.dafcls(handle)


def assert_as_spice_reads(path, reference="J2000", count=None, **options):
    """Dates to 1e-9 s, attitudes to 1e-12 and rates to 1e-12 of their size, at every instant read."""
    back = Ephemeris.read(path, **options)
    spice.furnsh(str(path))
    tt = (back.epoch.tt - J2000).sec + back.elapsed
    ticks = np.rint([spice.sce2c(SC, spice.unitim(t, "TDT", "ET")) for t in tt])
    for i, tick in enumerate(ticks):
        assert abs(spice.unitim(spice.sct2e(SC, tick), "ET", "TDT") - tt[i]) < 1e-9 + 2 * np.spacing(tt[i])
        if back.has_rate:
            matrix, velocity, _ = spice.ckgpav(INST, tick, 0.0, reference)
            expected = matrix @ velocity
            assert np.abs(back.angular_velocity[i] - expected).max() <= 1e-12 * np.linalg.norm(expected)
        else:
            matrix, _ = spice.ckgp(INST, tick, 0.0, reference)
        q = rotations.from_matrix(np.asarray(matrix).T)
        assert rotations.angle_between(q, back.quaternion("wxyz")[i]) < 1e-12
    assert count is None or len(back) == count
    return back


KINDS = {
    "1": {"kind": 1},
    "2": {"kind": 2},
    "3": {"kind": 3},
    **{f"5, subtype {k}": {"kind": 5, "subtype": k} for k in range(4)},
    "5, window of 8": {"kind": 5, "subtype": 1, "window": 8},
    "5, window of 2": {"kind": 5, "subtype": 2, "window": 2},
}


@pytest.mark.parametrize("arguments", KINDS.values(), ids=KINDS)
@pytest.mark.parametrize("flag", [True, False], ids=["rates", "no rates"])
def test_segment_is_read_as_spice_reads_it(arguments, flag, tmp_path):
    clock(tmp_path)
    added(tmp_path / "a.bc", **arguments, flag=flag)
    back = assert_as_spice_reads(tmp_path / "a.bc")
    assert back.has_rate == (flag or arguments["kind"] == 2)
    assert len(back) >= len(SECONDS)
    expected = [] if arguments["kind"] == 1 else SECONDS[STARTS[1:]] - SECONDS[0]
    found = np.array([event.seconds for event in back.events]) - back.elapsed[0]
    if arguments["kind"] != 2:  # rates of constant rotation do not lead from record to record here
        assert np.abs(found - expected).max(initial=0.0) < 1e-6


def test_hundreds_of_records_pass_over_the_directories(tmp_path):
    clock(tmp_path)
    seconds = np.arange(450.0) / 2 + 1
    for kind, subtype in ((1, 0), (2, 0), (3, 0), (5, 0), (5, 1)):
        path = tmp_path / "a.bc"
        path.unlink(missing_ok=True)
        added(path, kind, seconds, np.arange(0, 450, 2), subtype=subtype, window=2)
        spice.kclear()
        clock(tmp_path)
        assert_as_spice_reads(path)


@pytest.mark.parametrize("takes_last", [True, False], ids=["last", "first"])
@pytest.mark.parametrize("flag", [True, False], ids=["rates", "no rates"])
def test_mini_segments_are_read_within_their_bounds(takes_last, flag, tmp_path):
    clock(tmp_path)
    parts = [(0, 4, SECONDS[:9]), (1, 6, SECONDS[6:14]), (2, 2, SECONDS[12:17]), (3, 4, SECONDS[15:])]
    added_type_6(tmp_path / "a.bc", parts, (1.0, 11.0, 22.0, 25.0, 30.0), takes_last, flag)
    assert_as_spice_reads(tmp_path / "a.bc", count=len(SECONDS))


def test_more_than_a_hundred_mini_segments_have_a_directory(tmp_path):
    clock(tmp_path)
    seconds = np.arange(1.0, 242.0)
    parts = [(0, 2, seconds[i : i + 3]) for i in range(0, 240, 2)]
    added_type_6(tmp_path / "a.bc", parts, seconds[::2], True)
    assert_as_spice_reads(tmp_path / "a.bc", count=len(seconds))


@pytest.mark.parametrize("arguments", [KINDS[name] for name in KINDS if name not in "12"], ids=str)
def test_attitudes_between_the_records_are_those_of_spice(arguments, tmp_path):
    clock(tmp_path)
    path = tmp_path / "a.bc"
    added(path, **arguments)
    back = Ephemeris.read(path)
    spice.furnsh(str(path))
    # ticks in every interval, near both of its ends and in the middle; back.elapsed begins at a whole second
    ticks = np.concatenate([np.arange(a, b)[[1, 30, (b - a) // 2, -1]] for a, b in spans_of(STARTS)])
    between = back.resampled(back.elapsed[0] + ticks / TICKS_PER_SECOND - SECONDS[0])
    for tick, q in zip(ticks, between.quaternion("wxyz"), strict=True):
        matrix, _ = spice.ckgp(INST, float(tick), 0.0, "J2000")
        assert rotations.angle_between(rotations.from_matrix(np.asarray(matrix).T), q) < 1e-12


def spans_of(starts):
    """First and last tick of each pair of records that an interval interpolates between."""
    ticks = (SECONDS * TICKS_PER_SECOND).astype(int)
    return [(ticks[i], ticks[i + 1]) for i in range(len(ticks) - 1) if i + 1 not in starts]


# -- segments that overlap ------------------------------------------------------------------------------


@pytest.mark.parametrize("kinds", [(3, 3), (3, 5), (5, 3), (2, 3), (3, 1), (1, 3), (1, 1)], ids=str)
@pytest.mark.parametrize("inner", [0, 1], ids=["the inner one first", "the inner one last"])
def test_overlapping_segments_are_ranked_as_spice_ranks_them(kinds, inner, tmp_path):
    clock(tmp_path)
    spans = [(SECONDS, STARTS), (np.array([6.5, 7.25, 8.0, 10.0]), np.array([0, 2]))]
    for k, kind in enumerate(kinds):
        seconds, starts = spans[k if inner else 1 - k]
        added(tmp_path / "a.bc", kind, seconds, starts)
    back = assert_as_spice_reads(tmp_path / "a.bc")
    assert (np.diff(back.elapsed) > 0).all()


def test_later_segment_has_the_instant_at_which_two_meet(tmp_path):
    clock(tmp_path)
    for seconds in (np.array([5.0, 6.0, 7.0]), np.array([1.0, 3.0, 5.0])):
        added(tmp_path / "a.bc", 3, seconds, np.array([0]))
    assert_as_spice_reads(tmp_path / "a.bc", count=5)


def test_descriptor_limits_what_is_covered(tmp_path):
    clock(tmp_path)
    added(tmp_path / "a.bc", 5, cover=(1.0, 20.0))
    assert_as_spice_reads(tmp_path / "a.bc", count=12)


# -- frames ---------------------------------------------------------------------------------------------

FIXED = """KPL/FK
\\begindata
FRAME_A_ONE=-900100
FRAME_-900100_NAME='A_ONE'
FRAME_-900100_CLASS=4
FRAME_-900100_CLASS_ID=-900100
FRAME_-900100_CENTER=-900
TKFRAME_-900100_RELATIVE='B1950'
TKFRAME_-900100_SPEC='ANGLES'
TKFRAME_-900100_UNITS='DEGREES'
TKFRAME_-900100_ANGLES=(10.0 20.0 -35)
TKFRAME_-900100_AXES=(3 1 2)
FRAME_A_TWO=-900200
FRAME_-900200_NAME='A_TWO'
FRAME_-900200_CLASS=4
FRAME_-900200_CLASS_ID=-900200
FRAME_-900200_CENTER=-900
TKFRAME_A_TWO_RELATIVE='A_ONE'
TKFRAME_A_TWO_SPEC='QUATERNION'
TKFRAME_A_TWO_Q=(0.5 0.5 -0.5 0.5)
FRAME_A_THREE=-900300
FRAME_-900300_NAME='A_THREE'
FRAME_-900300_CLASS=4
FRAME_-900300_CLASS_ID=-900300
FRAME_-900300_CENTER=-900
TKFRAME_-900300_RELATIVE='A_TWO'
TKFRAME_-900300_SPEC='MATRIX'
TKFRAME_-900300_MATRIX=(0.6 0.8 0 -0.8 0.6 0 0 0 1)
FRAME_A_CK=-900400
FRAME_-900400_NAME='A_CK'
FRAME_-900400_CLASS=3
FRAME_-900400_CLASS_ID=-900400
FRAME_-900400_CENTER=-900
CK_-900000_SCLK=-900
\\begintext
"""


def test_matrices_of_the_21_inertial_frames_are_those_of_spice():
    for number, (name, _, _) in reference_frames.BUILT_IN.items():
        assert spice.frmnam(number) == name
        expected = spice.pxform("J2000", name, 0.0)
        assert np.abs(reference_frames.built_in_matrix(number) - expected).max() < 1e-15


@pytest.mark.parametrize("number", reference_frames.BUILT_IN)
def test_attitudes_relative_to_an_inertial_frame_are_read_relative_to_the_icrf(number, tmp_path):
    name = reference_frames.BUILT_IN[number][0]
    clock(tmp_path)
    added(tmp_path / "a.bc", 3, ref=name)
    reference = "ECLIPJ2000" if name == "ECLIPJ2000" else "J2000"
    back = assert_as_spice_reads(tmp_path / "a.bc", reference)
    assert back.frame == ("ECLIPJ2000" if name == "ECLIPJ2000" else "ICRF")


@pytest.mark.parametrize("name", ["A_ONE", "A_TWO", "A_THREE"])
def test_attitudes_relative_to_a_frame_of_a_frame_kernel_are_read_with_it(name, tmp_path):
    clock(tmp_path)
    (tmp_path / "f.tf").write_text(FIXED)
    spice.furnsh(str(tmp_path / "f.tf"))
    added(tmp_path / "a.bc", 3, ref=name)
    with pytest.raises(
        FormatError, match=r"SPICE's frame -900\d00; a frame that a frame kernel defines needs fk="
    ):
        Ephemeris.read(tmp_path / "a.bc")
    assert assert_as_spice_reads(tmp_path / "a.bc", fk=tmp_path / "f.tf").frame == "ICRF"


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("x", "x"), r"frame -900400 \(A_CK\), which is that of another CK \(class 3\)"),
        (("FRAME_-900400_CLASS=3", "FRAME_-900400_CLASS=4"), r"no complete definition of frame -900400"),
        (
            ("FRAME_-900400_CLASS=3", "FRAME_-900400_CLASS=4\nTKFRAME_-900400_RELATIVE='A_CK'\n"
             "TKFRAME_-900400_SPEC='MATRIX'\nTKFRAME_-900400_MATRIX=(1 0 0 0 1 0 0 0 1)"),
            "more than 20 frames",
        ),
        (
            ("FRAME_-900400_CLASS=3", "FRAME_-900400_CLASS=4\nTKFRAME_-900400_RELATIVE='J2000'\n"
             "TKFRAME_-900400_SPEC='MATRIX'\nTKFRAME_-900400_MATRIX=(1 0 0 0 1 0 0 0 2)"),
            "no complete definition of frame",
        ),
    ],
    ids=["another CK", "incomplete", "fixed to itself", "no rotation"],
)  # fmt: skip
def test_frames_that_are_not_fixed_to_an_inertial_one_are_refused(change, message, tmp_path):
    clock(tmp_path)
    (tmp_path / "f.tf").write_text(FIXED)
    spice.furnsh(str(tmp_path / "f.tf"))
    added(tmp_path / "a.bc", 3, ref="A_CK")
    (tmp_path / "f.tf").write_text(FIXED.replace(*change))
    with pytest.raises(FormatError, match=message):
        Ephemeris.read(tmp_path / "a.bc", fk=tmp_path / "f.tf")


# -- clocks ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("system", [1, 2], ids=["TDB", "TT"])
@pytest.mark.parametrize(
    "date",
    [
        "@2024-JAN-01-12:01:09.184",
        "@2024-01-01/12:01:09.184",
        "@01-JAN-2024-12:01:09.184",
        "@2024-JAN-1-12:01:09.184",
        "@1-January-2024/12:01:09.184",
        "@JAN-01-2024-12:01:09.184",
        "@2024-JAN-01",
        "@2024-JAN-01-12:01",
    ],
)
def test_dates_among_coefficients_are_those_of_spice(date, system, tmp_path):
    clock(tmp_path, f"0 {date} 1", system)
    added(tmp_path / "a.bc", 3)
    assert_as_spice_reads(tmp_path / "a.bc", count=len(SECONDS))


@pytest.mark.parametrize(
    "text", ["@2024", "@noon", "@2024-13-01", "@2024-FOO-01", "@2024-01-32", "2024-01-01", "@"]
)
def test_other_text_is_no_date(text):
    with pytest.raises(ValueError):  # noqa: PT011  caught by the reader, which names the clock
        sclk.seconds(text)


ROWS = {
    "drifting": "0 757382469.184 1  1280 757382474.3 1.001  3840 757382484.2 0.999",
    "a row twice": "0 757382469.184 1  1280 757382474.1 1.001  1280 757382474.1 1.001  3840 757382484.2 1",
    "a count twice": "0 757382469.184 1  1280 757382474.1 1.001  1280 757382474.2 0.99  3840 757382484.2 1",
    "counts that step back": "0 757382469 1  3840 757382484.2 1  1280 757382474.1 1.001  5000 757382489.0 1",
}


@pytest.mark.parametrize("rows", ROWS.values(), ids=ROWS)
def test_rows_of_a_clock_date_as_in_spice(rows, tmp_path):
    clock(tmp_path, rows)
    added(tmp_path / "a.bc", 3)
    (tmp_path / "a.bc").replace(tmp_path / "b.bc")
    read = sclk.clock_from((tmp_path / "a.tsc").read_text(), "a.tsc", INST, "a.bc")
    ticks = np.arange(0.0, 7680.0, 40.0)
    anchor, seconds, low = read.tt(ticks, "a.bc")
    for tick, t, rest in zip(ticks, seconds, low, strict=True):
        expected = spice.unitim(spice.sct2e(SC, tick), "ET", "TDT")
        assert abs((expected - anchor) - (t + rest)) < 1e-9 + 2 * np.spacing(expected)


def test_ticks_go_on_through_partitions(tmp_path):
    ends = f"{10 * TICKS_PER_SECOND} {1000 * TICKS_PER_SECOND}"
    clock(tmp_path, "0 757382469.184 1", starts="0 512", ends=ends)
    added(tmp_path / "a.bc", 3)
    assert_as_spice_reads(tmp_path / "a.bc", count=len(SECONDS))


def test_ticks_before_the_first_row_are_refused_as_in_spice(tmp_path):
    clock(tmp_path, "1280 757382474.184 1.001  3840 757382484.2 1")
    with pytest.raises(spice.utils.exceptions.SpiceyError):
        spice.sct2e(SC, 256.0)
    added(tmp_path / "a.bc", 3)
    with pytest.raises(FormatError, match="before the first calibration"):
        Ephemeris.read(tmp_path / "a.bc")


def test_ticks_beyond_the_last_partition_are_refused_as_in_spice(tmp_path):
    clock(tmp_path, ends=str(20 * TICKS_PER_SECOND))
    with pytest.raises(spice.utils.exceptions.SpiceyError):
        spice.sct2e(SC, 30.0 * TICKS_PER_SECOND)
    added(tmp_path / "a.bc", 3)
    with pytest.raises(FormatError, match=r"ticks 256\.0 to 7680\.0, of a clock from 0 to 5120\.0"):
        Ephemeris.read(tmp_path / "a.bc")


def test_frame_kernel_names_the_clock_of_a_structure(tmp_path):
    clock(tmp_path)
    (tmp_path / "f.tf").write_text(FIXED.replace("CK_-900000", "CK_-77"))
    handle = spice.ckopn(str(tmp_path / "a.bc"), "a", 0)
    ticks, q, _, av, _ = records(SECONDS)
    spice.ckw03(handle, ticks[0], ticks[-1], -77, "J2000", True, "A", len(ticks), ticks, q, av, 1, ticks[:1])
    spice.dafcls(handle)
    with pytest.raises(FormatError, match="does not tell its spacecraft"):
        Ephemeris.read(tmp_path / "a.bc")
    back = Ephemeris.read(tmp_path / "a.bc", fk=tmp_path / "f.tf")
    assert np.array_equal(back.elapsed, Ephemeris.read(tmp_path / "a.bc", clock_id=-900).elapsed)


# -- types 5 and 6, written ----------------------------------------------------------------------------


def dense_errors(path, ephemeris, scene_motion, count=7):
    """Greatest differences of CSPICE from the motion between the nodes: attitude, rad, and rate, rad/s."""
    spice.kclear()
    spice.furnsh([str(path.with_suffix(ending)) for ending in (".tls", ".tsc", ".bc")])
    t = np.concatenate(
        [ephemeris.elapsed[:-1] + k * np.diff(ephemeris.elapsed) / count for k in range(1, count)]
    )
    t.sort()
    motion = scene_motion.at(ephemeris.time[0] + TimeDelta(t - ephemeris.elapsed[0], format="sec"))
    ets = [spice.unitim(tt, "TDT", "ET") for tt in (motion.time.tt - J2000).sec]
    angles, rates = [], []
    for et, q, omega in zip(ets, motion.quaternion("wxyz"), motion.angular_velocity, strict=True):
        matrix, velocity, _ = spice.ckgpav(-999000, spice.sce2c(-999, et), 0.0, "ECLIPJ2000")
        angles.append(rotations.angle_between(rotations.from_matrix(np.asarray(matrix).T), q))
        rates.append(np.linalg.norm(matrix @ velocity - omega))
    return max(angles), max(rates)


@pytest.mark.parametrize(("kind", "degree", "most"), [(5, 3, 400), (5, 7, 130), (5, 15, 100), (6, 7, 130)])
def test_polynomials_keep_their_bound_as_spice_interpolates_with_few_nodes(kind, degree, most, tmp_path):
    scene = Scene.builtin("toutatis")
    path = tmp_path / "t.bc"
    written = scene.write(path, interpolation_error=1e-6, type=kind, degree=degree)
    assert written.nodes < most  # of type 3, 14,401
    back = Ephemeris.read(path)
    assert len(back) == written.nodes
    angle, rate = dense_errors(path, back, scene.motion())
    # instants are within a tick of 1/65536 s of those asked for; at 2e-5 rad/s that is 3e-10 rad
    assert 0.4 * written.interpolation_error < angle < written.interpolation_error + 1e-9
    assert rate < 1e-9  # of 2.1e-5 rad/s
    motion = scene.motion().at(back.time)
    assert rotations.angle_between(motion.quaternion("wxyz"), back.quaternion("wxyz")).max() < 1e-9
    assert np.abs(back.angular_velocity - motion.angular_velocity).max() < 1e-14


def arrays_in(path):
    """How many segments a file has, by CSPICE."""
    handle = spice.dafopr(str(path))
    spice.dafbfs(handle)
    count = 0
    while spice.daffna():
        count += 1
    spice.dafcls(handle)
    return count


@pytest.mark.parametrize("kind", [5, 6])
def test_polynomials_are_split_at_events_and_read_back(kind, tmp_path):
    document = Scene.builtin("toutatis").document()
    impulse = {"type": "impulse", "frame": "body", "time": {"value": 20, "unit": "d"}}
    impulse["angular_impulse"] = {"value": [1e-6, 0, 0], "unit": "N m s"}
    scene = Scene.model_validate({**document, "effects": [impulse]})
    path = tmp_path / "t.bc"
    written = scene.write(path, interpolation_error=1e-5, type=kind)
    back = Ephemeris.read(path)
    assert len(back) == written.nodes
    assert arrays_in(path) == {5: 2, 6: 1}[kind]
    before, after = (scene.run().resampled([20 * 86400.0 + d]) for d in (-3600.0, 3600.0))
    spice.furnsh([str(path.with_suffix(ending)) for ending in (".tls", ".tsc", ".bc")])
    for side in (before, after):
        tick = spice.sce2c(-999, spice.unitim((side.time[0].tt - J2000).sec, "TDT", "ET"))
        matrix, velocity, _ = spice.ckgpav(-999000, tick, 0.0, "ECLIPJ2000")
        assert np.abs(matrix @ velocity - side.angular_velocity[0]).max() < 1e-9
        q = rotations.from_matrix(np.asarray(matrix).T)
        assert rotations.angle_between(q, side.quaternion("wxyz")[0]) < 1e-5
    assert [event.seconds for event in back.events] == pytest.approx([20 * 86400.0], abs=1.0)
    assert {str(part.method) for part in back.interpolation.segments} == {"Hermite, degree 7"}


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"type": 5, "degree": 5}, "degree: 3, 7, 11, 15 for Hermite's interpolation; got 5"),
        ({"type": 5, "degree": True}, "degree: 3, 7, 11, 15"),
        ({"type": 4}, "type: 2, 3, 5 or 6; got 4"),
    ],
)
def test_what_polynomials_do_not_take_is_refused(options, message, tmp_path):
    with pytest.raises(InputError, match=message):
        MOTION.at(SECONDS).write(tmp_path / "a.bc", **options)


@pytest.mark.parametrize("kind", [5, 6])
def test_polynomials_need_rates_and_two_instants(kind, tmp_path):
    dated = TorqueFreeMotion(MOTION.body, (1.0, 0, 0, 0), (0.1, 0.2, 0.3), Time("2024-01-01"), order="wxyz")
    with pytest.raises(FormatError, match="a segment of one instant has none; type 3 holds it"):
        dated.at([0.0]).write(tmp_path / "a.bc", type=kind)
    dated.at([0.0, 1.0]).write(tmp_path / "a.aem", rates=False)
    with pytest.raises(FormatError, match=f"type {kind} is written with rates, and this ephemeris has none"):
        Ephemeris.read(tmp_path / "a.aem").write(tmp_path / "a.bc", type=kind)


# -- natural bodies, and frames of one's own ------------------------------------------------------------


@pytest.mark.parametrize("naif_id", [2004179, 20004179, 433])
def test_axes_of_a_natural_body_are_its_fixed_frame(naif_id, tmp_path):
    scene = Scene.builtin("toutatis")
    path = tmp_path / "t.bc"
    scene.write(path, naif_id=naif_id)
    spice.furnsh([str(path.with_suffix(ending)) for ending in (".tls", ".tsc", ".tf", ".bc")])
    number, name = spice.cidfrm(naif_id)
    ephemeris = scene.run()
    et = spice.unitim((ephemeris.time[7].tt - J2000).sec, "TDT", "ET")
    matrix = spice.pxform(name, "ECLIPJ2000", et)
    assert spice.namfrm(name) == number
    assert np.abs(np.asarray(matrix) - ephemeris.rotation[7].as_matrix()).max() < 1e-9
    back = Ephemeris.read(path, fk=path.with_suffix(".tf"))
    assert np.array_equal(back.quaternion("wxyz"), ephemeris.quaternion("wxyz"))


@pytest.mark.parametrize("reference", ["DE-118", "GALACTIC", "MARSIAU"])
def test_attitudes_in_a_frame_of_ones_own_are_written_relative_to_any_built_in_one(reference, tmp_path):
    dated = TorqueFreeMotion(
        MOTION.body, (1.0, 0, 0, 0), (0.1, 0.2, 0.3), Time("2024-01-01"), order="wxyz", frame="INERTIAL"
    )
    ephemeris = dated.at([0.0, 1.0, 2.0])
    ephemeris.write(tmp_path / "a.bc", reference=reference)
    spice.furnsh([str(tmp_path / f"a{ending}") for ending in (".tls", ".tsc", ".bc")])
    tick = spice.sce2c(-999, spice.unitim((ephemeris.time[1].tt - J2000).sec, "TDT", "ET"))
    matrix, _, _ = spice.ckgpav(-999000, tick, 0.0, reference)
    # an ET has a resolution of 1e-7 s and the clock one of 1/65536 s, in which the body turns by 6e-6 rad
    assert np.abs(np.asarray(matrix).T - ephemeris.rotation[1].as_matrix()).max() < 6e-6
    back = Ephemeris.read(tmp_path / "a.bc")
    expected = spice.pxform(reference, "J2000", 0.0) @ ephemeris.rotation[1].as_matrix()
    assert np.abs(back.rotation[1].as_matrix() - expected).max() < 1e-12
