"""Files of every format, ways to damage them, and what a reader may make of what comes out.

originals(format)           whole files, of as many kinds of ephemeris as the format has
EDITS, random_edits         what is done to one, for hypothesis or by chance
edited(content, edits)      the damaged file
outcome(format, content)    "refused", or "kept": read, written again by the format's own writer, and read
"""

import atexit
import io
import random
import re
import warnings
import zipfile
from functools import cache
from pathlib import Path
from shutil import rmtree
from tempfile import TemporaryDirectory, mkdtemp
from typing import NamedTuple

import numpy as np
from astropy.time import Time
from hypothesis import strategies as st

from attitude import (
    AttitudeError,
    AttitudeWarning,
    Ephemeris,
    FormatError,
    RigidBody,
    Scene,
    TorqueFreeMotion,
)
from attitude.formats import encode, module_of
from attitude.formats.registry import FORMATS
from attitude.samples.chunks import Samples
from attitude.samples.event import Event

EXACT = ("ecsv", "csv", "json", "ndjson", "arrow", "arrows", "parquet", "fits", "npz")
TEXT = ("ecsv", "csv", "json", "ndjson", "aem", "aem-xml", "acm", "acm-xml", "stk", "czml")
LEAP = Time("2016-12-31T23:59:58.123456789", scale="utc")
T = np.arange(5) / 2
BODY = RigidBody((1.0, 1.6, 2.1))


def motion(epoch=LEAP, frame="GCRF", attitude=(0.1, -0.7, 0.5, 0.5)):
    return TorqueFreeMotion(BODY, attitude, (0.3, -0.5, 0.9), epoch, order="wxyz", frame=frame)


def in_segments(ephemeris):
    """The same attitudes, with a jump of the rate at the third."""
    event = Event(float(ephemeris.elapsed[2]), "impulse", "a jump")
    q, rate = np.array(ephemeris.quaternion("wxyz")), np.array(ephemeris.angular_velocity)
    return Ephemeris(q, ephemeris.instants, ephemeris.frame, None, rate, "x", events=(event,))


def ephemerides(format):
    """As many kinds as the format holds."""
    yield motion().at(T)
    if format not in EXACT:
        yield in_segments(motion(frame="ECLIPJ2000").at(T))
        return
    yield motion(None).at(T[:3])
    yield motion(LEAP.tai).at(Time(LEAP.tai.jd1, LEAP.tai.jd2 + np.arange(3.0), format="jd", scale="tai"))
    yield Scene.builtin("drop").run()[:4]
    if format in ("ecsv", "json", "fits", "npz"):
        yield motion(attitude=[(1.0, 0, 0, 0), (0, 1.0, 0, 0)]).at(T[:2])


def options_of(format, ephemeris):
    """With which the writer keeps all that the ephemeris holds."""
    return {"rates": ephemeris.has_rate} if format == "stk" else {}


AEM_1 = b"""CCSDS_AEM_VERS = 1.0
CREATION_DATE = 2016-12-01T00:00:00
ORIGINATOR = X
META_START
OBJECT_NAME = Y
OBJECT_ID = 2000-052A
REF_FRAME_A = EME2000
REF_FRAME_B = SC_BODY_1
ATTITUDE_DIR = %s
TIME_SYSTEM = UTC
START_TIME = 2016-366T00:00:00Z
STOP_TIME = 2016-12-31T23:59:60.5
%s
META_STOP
DATA_START
2016-366T00:00:00Z 1 0 0 0 %s
2016-12-31T23:59:60.25 0 0.6 .8 0 %s
DATA_STOP
"""
KINDS_OF_AEM_1 = (
    (b"A2B", b"ATTITUDE_TYPE = QUATERNION\nQUATERNION_TYPE = LAST", b""),
    (b"B2A", b"ATTITUDE_TYPE = QUATERNION/DERIVATIVE\nQUATERNION_TYPE = FIRST", b"0 1.5 -2e-3 +.25"),
)


@cache
def originals(format):
    """Bytes of whole files, each by the format's own writer; of AEM some of version 1 too."""
    files = [written(format, each) for each in ephemerides(format)]
    if format == "aem":
        files += [AEM_1 % (direction, kind, rate, rate) for direction, kind, rate in KINDS_OF_AEM_1]
    return tuple(files)


def written(format, ephemeris, **options):
    options = options_of(format, ephemeris) | options
    return b"".join(bytes(b) for b in encode(Samples.of(ephemeris), FORMATS[format], None, options).blocks)


@cache
def clock():
    """The clock kernel of the CKs among the originals; those of their own anchor are read with it too."""
    folder = mkdtemp()
    atexit.register(rmtree, folder)
    path = Path(folder) / "a.tsc"
    whole = encode(Samples.of(motion().at(T)), FORMATS["ck"])
    path.write_bytes(whole.companions("a.bc")[".tsc"])
    return path


def read(format, content, stream=io.BytesIO, **options):
    if format == "ck":
        options = {"sclk": clock()} | options
    return module_of(FORMATS[format]).parse(stream(content), f"damaged.{format}", **options)


# -- damage ---------------------------------------------------------------------------------------


class Edit(NamedTuple):
    """What is done: `kind`, at a `position` of the file (0 to 1), with another, offset, length and word."""

    kind: str
    position: float
    other: float
    offset: int
    length: int
    word: bytes


KINDS = ("word", "number", "word", "number", "swap", "double", "drop", "move", "flip", "byte", "cut")
OFFSETS, LENGTHS = (0, 0, 0, 1, 2), (0, 0, 1, 1, 2, 7, 60)
JUNK = (
    b'0 9 . - + e9 e400 1e308 -1e-320 NaN null true , : " [ ] { } [] {} 2016 \xff \xc3\xa9 '
    b"# ~ x 60 366 T Z = < > </ & DATA_STOP META_START COMMENT Q1 TDB ut1 tcb "
    b"9999-12-31T23:59:59 0000-01-01T00:00:00 1e16 "
    b'"\\ud800" \x00 \x85 \xe2\x80\xa8 &a *a !!python/object:os.system'
).split(b" ")
WORDS = (*JUNK, b"", b"\n", b" ", b"\t", b"\r")
NUMBERS = tuple(
    b"0 1 -1 0.5 2 1e300 1.7976931348623157e308 -1e308 5e-324 1e-17 nan inf -0.0 1e999 12345678901234567890 "
    b"1.0000001 0.9999999 1e20 1e10 86400 -1e12 2.5e11 00 9999 1e-9 1_0 0x1 1d0".split()
)
WORD = re.compile(rb"[\w.+-]+")
NUMBER = re.compile(rb"[-+]?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?")

PLACE = st.floats(0, 1, exclude_max=True)
EDITS = st.lists(
    st.builds(
        Edit,
        st.sampled_from(KINDS),
        PLACE,
        PLACE,
        st.sampled_from(OFFSETS),
        st.sampled_from(LENGTHS),
        st.sampled_from(WORDS + NUMBERS),
    ),
    min_size=1,
    max_size=3,
)


def random_edits(chance: random.Random):
    return [
        Edit(
            chance.choice(KINDS),
            chance.random(),
            chance.random(),
            chance.choice(OFFSETS),
            chance.choice(LENGTHS),
            chance.choice(WORDS + NUMBERS),
        )
        for _ in range(chance.choice([1, 1, 1, 2, 3]))
    ]


def edited(content, edits):
    """The file with all of it done; of a zip of arrays, to what is in one of them."""
    if content[:4] == b"PK\x03\x04" and edits[0].offset < 2:
        return _zipped(content, edits)
    for edit in edits:
        content = _DONE[edit.kind](content, edit)
    return content


def _zipped(content, edits):
    archive, sink = zipfile.ZipFile(io.BytesIO(content)), io.BytesIO()
    members = archive.namelist()
    chosen = members[int(edits[0].position * len(members))]
    with zipfile.ZipFile(sink, "w") as changed:
        for name in members:
            data = archive.read(name)
            changed.writestr(name, edited(data, edits) if name == chosen else data)
    return sink.getvalue()


def _word(content, edit):
    """Takes some bytes away at a word, and puts others there."""
    starts = [match.start() for match in WORD.finditer(content)] or [0]
    at = starts[int(edit.position * len(starts))] + edit.offset
    return content[:at] + edit.word + content[at + edit.length :]


def _number(content, edit):
    """Another number for one."""
    matches = list(NUMBER.finditer(content))
    if not matches:
        return edit.word
    match = matches[int(edit.position * len(matches))]
    other = NUMBERS[int(edit.other * len(NUMBERS))]
    return content[: match.start()] + other + content[match.end() :]


def _parts(content):
    """Lines; of a file that has hardly any, its words of eight bytes."""
    lines = content.splitlines(keepends=True)
    if b"\0" in content or len(lines) < 3:
        return [content[i : i + 8] for i in range(0, len(content), 8)] or [b""]
    return lines


def _with_parts(change):
    def done(content, edit):
        parts = _parts(content)
        return b"".join(change(parts, int(edit.position * len(parts)), int(edit.other * len(parts))))

    return done


def _swap(parts, i, j):
    parts[i], parts[j] = parts[j], parts[i]
    return parts


def _used(content, position):
    """The byte at a place, counting those that are neither zero nor blank."""
    used = np.flatnonzero(~np.isin(np.frombuffer(content, np.uint8), (0, 32)))
    return int(used[int(position * used.size)]) if used.size else 0


def _byte(change):
    def done(content, edit):
        if not content:
            return edit.word
        at = _used(content, edit.position)
        return content[:at] + bytes([change(content[at], edit)]) + content[at + 1 :]

    return done


_DONE = {
    "word": _word,
    "number": _number,
    "swap": _with_parts(_swap),
    "double": _with_parts(lambda parts, i, j: [*parts[: i + 1], *parts[i:]]),
    "drop": _with_parts(lambda parts, i, j: parts[:i] + parts[i + 1 :]),
    "move": _with_parts(lambda parts, i, j: [*parts[:j], parts[i], *parts[j:]]),
    "flip": _byte(lambda value, edit: value ^ 1 << int(edit.other * 8)),
    "byte": _byte(lambda value, edit: int(edit.other * 256)),
    "cut": lambda content, edit: content[: int(edit.position * len(content))],
}


# -- what readers may do with it -------------------------------------------------------------------


def outcome(format, content):
    """ "refused", or "kept"; anything but an AttitudeError of the reader, or another ephemeris, is raised.

    What is read leniently is read with an AttitudeWarning.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", AttitudeWarning)
        return _outcome(format, content)


def _outcome(format, content):
    options = {"frame": "ITRF"} if format == "czml" else {}  # the numbers as they stand in the file
    try:
        back = read(format, content, **options)
    except AttitudeError as error:
        if not (isinstance(error, FormatError) and error.source.startswith("damaged.") and _is_line(error)):
            raise ValueError(f"no clear refusal: {error!r}") from error
        return "refused"
    if format == "ck":
        check_same_ck(back)
    else:
        check_same(format, back, read(format, written(format, back), **options))
    return "kept"


def _is_line(error):
    return str(error).isprintable() or not any(c in str(error) for c in "\n\r")


def check_same_ck(back):
    """A CK has its clock beside it."""
    with TemporaryDirectory() as folder:
        Ephemeris.of(back).write(Path(folder) / "a.bc")
        check_same("ck", back, Ephemeris.read(Path(folder) / "a.bc"))


def check_same(format, back, again):
    """Bits, but for what a format writes in other units, along other axes, or to the nanosecond."""
    q, p = back.quaternion("wxyz"), again.quaternion("wxyz")
    assert np.abs(np.sqrt((q * q).sum(axis=-1)) - 1.0).max() <= 1.0000001e-6
    assert np.array_equal(q, p), "another attitude"
    assert (back.shape, back.frame) == (again.shape, again.frame)
    check_same_instants(format, back.instants, again.instants)
    if back.has_rate and format != "czml":
        one, other = back.angular_velocity, again.angular_velocity
        assert np.isfinite(one).all()
        size = np.sqrt((one / max(1.0, np.abs(one).max())) ** 2).sum(axis=-1, keepdims=True)
        allowed = {"ck": 1e-14 * size * max(1.0, np.abs(one).max())}.get(format, 1e-15 * np.abs(one) + 1e-323)
        assert (np.abs(one - other) <= (0.0 if format in EXACT else allowed)).all(), "another rate"
    if format in EXACT:
        assert back.name == again.name
        assert (back.body is None) == (again.body is None)
        assert [event.seconds for event in back.events] == [event.seconds for event in again.events]


def check_same_instants(format, one, other):
    if format in EXACT:
        rests = [0.0 if each.seconds_low is None else each.seconds_low for each in (one, other)]
        assert np.array_equal(one.seconds, other.seconds)
        assert np.array_equal(*np.broadcast_arrays(*rests))
        assert (one.epoch is None) == (other.epoch is None)
        if one.epoch is not None:
            assert (one.epoch.jd1, one.epoch.jd2) == (other.epoch.jd1, other.epoch.jd2)
        return
    off = np.abs((one.time - other.time).sec)
    assert (off <= 2e-9 + 4e-16 * np.abs(one.seconds)).all(), f"instants {off.max()} s off"
