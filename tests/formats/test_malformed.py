"""Malformed files of every format: refused by name, with a line where there are lines; nothing half-read."""

import io
import json
import os
import re
import subprocess
import sys
from functools import partial

import numpy as np
import pytest

from attitude import AttitudeError, Ephemeris, FormatError
from attitude.formats.registry import FORMATS
from attitude.times.instants import Instants
from tests.formats.damage import EXACT, T, clock, motion, originals, read, written

each_format = pytest.mark.parametrize("format", FORMATS)

# One attitude in the text of a format that has one after the other.
ROWS = {
    "csv": rb"(?m)^2016-.*\n",
    "ndjson": rb'(?m)^\{"time.*\n',
    "ecsv": rb"(?m)^2457754\..*\n",
    "aem": rb"(?m)^2016-.*\n",
    "aem-xml": rb"(?s)<attitudeState>.*?</attitudeState>\n",
    "stk": rb"(?m)^\d\.\d+ .*\n",
}


def original(format):
    return originals(format)[0]


def refusal(format, content):
    with pytest.raises(FormatError) as caught:
        read(format, content)
    assert caught.value.source == f"damaged.{format}"
    assert str(caught.value).startswith(f"damaged.{format}")
    assert "\n" not in str(caught.value)
    return caught.value


def rows_of(format, content):
    return list(re.finditer(ROWS[format], content))


def with_rows(format, change):
    """The file with other rows: `change` is given the list of them."""
    content = original(format)
    rows = rows_of(format, content)
    assert len(rows) == len(T)
    texts = change([row[0] for row in rows])
    return content[: rows[0].start()] + b"".join(texts) + content[rows[-1].end() :]


def in_row(i, old, new):
    """Replaces the first match in row i."""

    def change(rows):
        changed = re.sub(old, new, rows[i], count=1)
        assert changed != rows[i]
        return [*rows[:i], changed, *rows[i + 1 :]]

    return change


def order(*places):
    return lambda rows: [rows[i] for i in places]


SWAPPED, TWICE = order(0, 2, 1, 3, 4), order(0, 1, 1, 2, 3)
NOT_AFTER = "not after the one before"
# format, what it is called, what is done to the rows, words of the message, the row whose line is named.
BY_ROW = [
    ("aem", "wrong order", SWAPPED, NOT_AFTER, 2),
    ("aem-xml", "wrong order", SWAPPED, NOT_AFTER, 2),
    ("stk", "wrong order", SWAPPED, "is not after", 2),
    ("aem", "instant twice", TWICE, NOT_AFTER, 2),
    ("aem-xml", "instant twice", TWICE, NOT_AFTER, 2),
    ("stk", "instant twice", TWICE, "is not after", 2),
    ("aem", "no QC", in_row(1, rb"0\.098\S+ ", b""), "6 numbers where Q1 Q2 Q3 QC", 1),
    ("aem-xml", "no QC", in_row(1, rb"<QC>.*</QC>\n", b""), "no QC in an attitudeState", 1),
    ("stk", "no component", in_row(1, rb"0\.098\S+ ", b""), "7 numbers where 8 belong", 1),
    ("csv", "no component", in_row(1, rb"0\.098\d+,", b""), "8 values where 9 belong", 1),
    ("ndjson", "no component", in_row(1, rb'"q_w":[^,]*,', b""), "other names than in the line before", 1),
    ("aem", "not unit", in_row(3, rb"0\.0208\d+", b"0.3"), "unit quaternion, within 0.01", 3),
    ("aem-xml", "not unit", in_row(3, rb"0\.0208\d+", b"0.3"), "unit quaternion, within 0.01", 3),
    ("stk", "not unit", in_row(3, rb"0\.0208\d+", b"0.3"), "unit quaternion, within 0.01", 3),
    ("csv", "not unit", in_row(3, rb"0\.0208\d+", b"0.3"), "unit quaternion, within 0.01", 3),
    ("ndjson", "not unit", in_row(3, rb"0\.0208\d+", b"0.3"), "unit quaternion, within 0.01", 3),
    ("ecsv", "not unit", in_row(3, rb"0\.0208\d+", b"0.3"), "unit quaternion, within 0.01", None),
    *(
        (format, name, in_row(2, rb"0\.0769\d+", word), words, None if format == "ecsv" else 2)
        for name, word in (("NaN", b"NaN"), ("Infinity", b"Infinity"), ("beyond a double", b"1e400"))
        for format, words in {
            "csv": "finite numbers",
            "ndjson": "not JSON|a number",
            "ecsv": "finite numbers|not ECSV",
            "aem": "QC is .*, not a finite number",
            "aem-xml": "QC is .*, not a finite number",
            "stk": "finite numbers",
        }.items()
    ),
    ("aem", "a word", in_row(4, rb"0\.29\d+", b"north"), "Q3 is 'north', not a finite number", 4),
    ("stk", "a word", in_row(4, rb"0\.29\d+", b"north"), "north", 4),
    ("csv", "a word", in_row(4, rb"0\.29\d+", b"north"), "could not convert string 'north'", 4),
    ("ndjson", "a word", in_row(4, rb"0\.29\d+", b'"north"'), "q_z: a number; got 'north'", 4),
    ("aem-xml", "a word", in_row(4, rb"0\.29\d+", b"north"), "Q3 is 'north', not a finite number", 4),
    ("aem", "date in another system", in_row(1, rb"(?<=456789) ", b"Z 1 "), "8 numbers where", 1),
    ("csv", "a row more", order(0, 1, 2, 3, 4, 4), "more instants than the 5", 5),
    ("ndjson", "a row more", order(0, 1, 2, 3, 4, 4), "more instants than the 5", 5),
    ("ecsv", "a row more", order(0, 1, 2, 3, 4, 4), r"\(6,\).* \[5\] stated", None),
    ("stk", "a row less", order(0, 1, 2, 3), "4 attitudes, and NumberOfAttitudePoints is 5", None),
    ("csv", "a row less", order(0, 1, 2, 3), r"\(4,\).* \[5\] stated", None),
    ("ndjson", "a row less", order(0, 1, 2, 3), r"\(4,\).* \[5\] stated", None),
]


@pytest.mark.parametrize(
    ("format", "change", "words", "row"),
    [pytest.param(format, *given, id=f"{format}: {name}") for format, name, *given in BY_ROW],
)
def test_malformed_row_is_refused_with_its_line(format, change, words, row):
    content = with_rows(format, change)
    error = refusal(format, content)
    assert re.search(words, str(error)), str(error)
    if row is not None:
        found = rows_of(format, content)
        begin, end = (
            (found[row].start(), found[row].end())
            if row < len(found)
            else re.search(rb"(?m)^.*DATA_STOP|\Z", content).span()
        )
        lines = content[:begin].count(b"\n") + 1, content[: end - 1].count(b"\n") + 1
        assert lines[0] <= error.line <= lines[1]


def swap(old, new, which=0, count=1):
    """The file (of which kind, among the originals) with old replaced by new."""

    def changed(format):
        content = originals(format)[which]
        damaged = re.sub(old, new, content, count=count)
        assert damaged != content
        return damaged

    return changed


def in_json(change):
    """A document of JSON, changed in place."""

    def changed(format):
        document = json.loads(original(format))
        change(document)
        return json.dumps(document).encode()

    return changed


def samples(change):
    """The samples of a CZML, as a list of rows."""

    def changed(document):
        values = document[1]["orientation"]["unitQuaternion"]
        rows = change([values[i : i + 5] for i in range(0, len(values), 5)])
        document[1]["orientation"]["unitQuaternion"] = [value for row in rows for value in row]

    return in_json(changed)


def column(name, values):
    return in_json(lambda document: document["columns"].__setitem__(name, values))


ZEROS = b"".ljust(100, b"\0")
BOMB = b'<!DOCTYPE aem [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;&a;&a;">]>\n<aem '
OUTSIDE = b'<!DOCTYPE aem [<!ENTITY a SYSTEM "file:///etc/passwd">]>\n<aem '
LAUGHS = b"".join(
    b"# - l%d: %s\n" % (i, b"&l%d [%s]" % (i, b",".join([b"*l%d" % (i - 1) if i else b"x"] * 10)))
    for i in range(30)
)
NO_KEYWORD = "no keyword of the metadata"
# format, what it is called, what is done to the file, words of the message, what stands in the line it names.
BY_FILE = [
    ("czml", "wrong order", samples(SWAPPED), r"0\.5 s is not after 1\.0 s", None),
    ("czml", "instant twice", samples(TWICE), r"0\.5 s is not after 0\.5 s", None),
    ("czml", "no component", samples(lambda rows: [rows[0][:4], *rows[1:]]), "24 numbers, where each", None),
    ("czml", "not unit", samples(lambda rows: [[*rows[0][:4], 0.9], *rows[1:]]), "unit quaternion", None),
    ("czml", "NaN", swap(rb"0\.0626\d+", b"NaN"), "not JSON", b"NaN"),
    ("json", "NaN", swap(rb"0\.0769\d+", b"NaN"), "not JSON", b"NaN"),
    ("json", "not unit", swap(rb"0\.0769\d+", b"0.3"), "unit quaternion, within 0.01", None),
    ("json", "no component", in_json(lambda d: d["columns"].pop("q_z")), "no column q_z", None),
    ("json", "an instant less", column("elapsed_s", [0, 1, 2, 3]), "instants", None),
    ("ecsv", "no component", swap(rb"\[(0\.0984\d+),", b"["), "not ECSV", None),
    ("aem", "two systems", swap(rb"M = UTC", b"M = TT", 1), "segment before has TT", b"M = UTC"),
    ("aem-xml", "two systems", swap(rb"M>UTC</", b"M>TT</", 1), "segment before has TT", b"M>UTC</"),
    (
        "aem",
        "system twice",
        swap(rb"TIME_SYSTEM = UTC\n", b"TIME_SYSTEM = UTC\nTIME_SYSTEM = TT\n"),
        "TIME_SYSTEM twice",
        b"= TT",
    ),
    (
        "aem-xml",
        "system twice",
        swap(rb"(<TIME_SYSTEM>)(.*)\n", rb"\1\2\n\1TT</TIME_SYSTEM>\n"),
        "TIME_SYSTEM twice",
        b">TT<",
    ),
    ("aem", "Z in TT", swap(rb"UTC((?s:.*?))456789\n", rb"TT\g<1>456789Z\n"), "Z states UTC", b"789Z"),
    ("csv", "scale", swap(rb'"time_scale":"utc"', b'"time_scale":"gps"'), "time scale 'gps'", None),
    ("json", "scale", swap(rb'"time_scale":"utc"', b'"time_scale":"gps"'), "time scale 'gps'", None),
    ("ndjson", "scale", swap(rb'"scale":"utc"', b'"scale":"gps"'), "time scale 'gps'", None),
    ("ecsv", "scale", swap(rb"time_scale: utc", b"time_scale: gps"), "time scale 'gps'", None),
    ("stk", "epoch", swap(rb"31 Dec", b"31 Nov"), "ScenarioEpoch '31 Nov", b"31 Nov"),
    ("czml", "epoch", swap(rb'"epoch":"2016-12-31', b'"epoch":"2016-13-31'), "2016-13-31", None),
    ("aem", "unknown keyword", swap(rb"(?m)^OBJECT_ID", b"COLOUR = red\nOBJECT_ID"), NO_KEYWORD, b"COLOUR"),
    ("aem-xml", "unknown keyword", swap(rb"<OBJECT_ID>", b"<X>r</X>\n<OBJECT_ID>"), NO_KEYWORD, b"<X>"),
    ("stk", "unknown keyword", swap(rb"(?m)^CentralB", b"Colour red\nCentralB"), "not known here", b"Colour"),
    ("czml", "unknown keyword", swap(rb'"epoch":', b'"colour":1,"epoch":'), "'colour' is not read", None),
    ("json", "unknown column", column("mass_kg", [1.0] * 5), "column 'mass_kg' is unknown", None),
    (
        "csv",
        "unknown column",
        swap(rb"elapsed_s,", b"mass_kg,elapsed_s,"),
        "values where 10 belong",
        b",0.0,0.0999",
    ),
    ("csv", "no instants", swap(rb"(?m)^2016-.*\n", b"", count=5), "no instants", None),
    ("json", "shape of nothing", in_json(lambda d: d.update(shape=[0])), "shape", None),
    ("aem-xml", "entities within entities", swap(rb"<aem ", BOMB), "a document type or entity", b"DOCTYPE"),
    ("aem-xml", "entity of a file", swap(rb"<aem ", OUTSIDE), "a document type or entity", b"DOCTYPE"),
    ("aem-xml", "unknown entity", swap(rb">ATTITUDE<", b">&a;<"), "not XML: undefined entity", b"&a;"),
    ("aem-xml", "deep", swap(rb"<data>", b"<data>" + b"<a>" * 10**5), "no element 'a' belongs", b"<a>"),
    ("aem-xml", "line within a value", swap(rb">LAGRANGE<", b">LAG\nRANGE<"), "one line of", b"RANGE<"),
    ("aem-xml", "character of no AEM", swap(b">ATTITUDE<", ">Å<".encode()), "printable ASCII", "Å".encode()),
    ("aem", "control character", swap(rb"= ATTITUDE", b"= A\x07T"), "printable ASCII", b"\x07"),
    ("aem", "long value", swap(rb"= ATTITUDE", b"= " + b"A" * 231), "1 to 230 printable", b"AAA"),
    ("ecsv", "laughs", swap(rb"# - \{name: ''\}\n", LAUGHS), "aliases expand to more", None),
    (
        "ecsv",
        "alias of itself",
        swap(rb"# - \{name: ''\}\n", b"# - {name: &a [*a]}\n"),
        "aliases expand to more",
        None,
    ),
    ("ecsv", "name of half a character", swap(rb"name: ''", rb'name: "\\ud800"'), "name .*ud800", None),
    ("ecsv", "name that is none", swap(rb"\{name: ''\}", b"{name: [1]}"), r"name \[1\]", None),
    *(
        (
            format,
            f"{depth} deep",
            swap(rb'"kind":"[^"]*"', b'"kind":' + b"[" * depth + b"]" * depth),
            words,
            None,
        )
        for depth, words in ((900, "kind is|not JSON"), (100_000, "not JSON"))
        for format in ("json", "ndjson", "csv")
    ),
    (
        "json",
        "deep column",
        swap(rb'"q_w":\[', b'"q_w":[' + b"[" * 900 + b"]" * 900 + b","),
        "q_w: numbers|too many levels",
        None,
    ),
    ("czml", "deep", swap(rb'"version":"1.0"', b'"version":' + b"[" * 900 + b"]" * 900), "version", None),
]


@pytest.mark.parametrize(
    ("format", "change", "words", "fragment"),
    [pytest.param(format, *given, id=f"{format}: {name}") for format, name, *given in BY_FILE],
)
def test_malformed_file_is_refused(format, change, words, fragment):
    content = change(format)
    error = refusal(format, content)
    assert re.search(words, str(error)), str(error)
    if fragment is not None:
        assert error.line == content[: content.index(fragment)].count(b"\n") + 1


# -- what no writer of text can be brought to --------------------------------------------------------


def with_values(quaternion=None, seconds=None):
    whole = motion(None).at(T)
    q, t = np.array(whole.quaternion("wxyz")), np.array(whole.elapsed)
    if quaternion is not None:
        q[3, 2] = quaternion
    if seconds is not None:
        t[3] = seconds
    return Ephemeris(q, Instants(t, None, None), "GCRF")


@pytest.mark.parametrize("format", EXACT)
@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"quaternion": 0.5}, r"quaternion\[3\]: a unit quaternion, within 0.01"),
        ({"quaternion": np.nan}, "finite numbers|numbers; got|a number; got|could not convert|without"),
        ({"seconds": np.inf}, "finite numbers|numbers; got|a number; got|could not convert|not ECSV|without"),
    ],
    ids=["not unit", "NaN", "Infinity"],
)
def test_numbers_of_no_attitude_are_refused(format, values, words):
    """By the reader, if not by the writer already."""
    try:
        content = written(format, with_values(**values))
    except FormatError as error:
        assert "a number that is not finite, in row 3" in str(error)  # noqa: PT017
        return
    error = refusal(format, content)
    assert re.search(words, str(error)), str(error)


# -- any file ---------------------------------------------------------------------------------------


def refused_or_the_same(format, content):
    """Whether it was refused."""
    try:
        back = read(format, content)
    except FormatError:
        return True
    whole = read(format, original(format))
    assert np.array_equal(back.quaternion("wxyz"), whole.quaternion("wxyz"))
    assert np.array_equal(back.elapsed, whole.elapsed)
    return False


@each_format
def test_truncated_file_is_refused(format):
    content = original(format)
    for tenth in range(10):
        part = content[: len(content) * tenth // 10]
        refused = refused_or_the_same(format, part)
        assert refused or (format == "ck" and not any(content[len(part) :]))  # it is filled up with zeros
    for missing in range(1, 9):
        refused_or_the_same(format, content[:-missing])


@each_format
@pytest.mark.parametrize(
    "garbage", [b"garbage\n", b"1 2 3\n", b"\xff" * 5000], ids=["word", "numbers", "bytes"]
)
def test_garbage_after_the_end_is_refused(format, garbage):
    refusal(format, original(format) + garbage)


@each_format
def test_file_twice_is_refused_or_read_from_its_end(format):
    refused = refused_or_the_same(format, original(format) * 2)
    assert refused or format in ("arrow", "parquet", "npz")  # which say there where all of them is


@each_format
def test_empty_file_blanks_and_zeros_are_refused(format):
    for content in (b"", b"\n", b" \n" * 1000, ZEROS, b"\xff\xfe" * 100):
        refusal(format, content)


@each_format
def test_directory_is_refused(format, tmp_path):
    path = tmp_path / f"a{FORMATS[format].endings[0]}"
    path.mkdir()
    with pytest.raises(FormatError, match=r"cannot be read \(Is a directory\)") as caught:
        Ephemeris.read(path)
    assert caught.value.source == str(path)


@each_format
def test_files_of_other_formats_are_refused(format):
    for other in FORMATS:
        if {format, other} == {"aem", "aem-xml"}:  # the two syntaxes know each other
            assert not refused_or_the_same(format, original(other))
        elif other != format:
            refusal(format, original(other))


# -- files without measure ----------------------------------------------------------------------------

MEBIBYTES, SECONDS = 300, 20
# What may follow without an end, after so much of a whole file.
ENDLESS = {
    "csv": [b"# more\n", b"\n"],
    "ndjson": [b"{}\n", b"\n"],
    "json": [b"0.5,", b" "],
    "ecsv": [b"# more\n", b"\n"],
    "aem": [b"COMMENT more\n", b"\n", b"             \n"],
    "aem-xml": [b"<COMMENT>more</COMMENT>\n", b"\n", b"<!-- -->"],
    "stk": [b"# more\n", b"\n", b"               \n"],
    "czml": [b"0.5,", b" "],
    "arrow": [b"x"],
    "parquet": [b"x"],
    "npz": [b"x"],
    "ck": [b"x"],
    "arrows": [],
    "fits": [],
}


class Endless(io.RawIOBase):
    """A beginning, and then the same again and again; it cannot be sought in, as a pipe."""

    def __init__(self, beginning, unit):
        self.left, self.unit = beginning, unit * (1 + (1 << 16) // len(unit))

    def readable(self):
        return True

    def read(self, size=-1):
        assert size >= 0, "read without measure"
        while len(self.left) < size:
            self.left += self.unit * (1 + size // len(self.unit))
        taken, self.left = self.left[:size], self.left[size:]
        return taken


def endless_files(format):
    content = original(format)
    yield "zeros", b"", b"\0"
    for unit in ENDLESS[format]:
        yield "from the beginning", b"", unit
        yield "after a half", content[: len(content) // 2], unit
    if format in ROWS:
        first, last = rows_of(format, content)[0], rows_of(format, content)[-1]
        yield "rows", content[: first.start()], last[0]
        for unit in ENDLESS[format]:
            yield "between rows", content[: first.end()], unit
    if format == "arrows":
        one = original(format)
        yield "batches", one[:-8], one[-8 - len(batch_of(one)) : -8]


def batch_of(content):
    """The bytes of the only record batch of a stream."""
    import pyarrow as pa

    reader = pa.ipc.open_stream(content)
    return reader.read_next_batch().serialize()


def sparse_files(format):
    """Of a GiB, which takes no room on a disk: zeros; and a whole file, then zeros."""
    for beginning in (b"", original(format)):
        for size in (1 << 30, (1 << 30) + 2**20):
            yield beginning, size


def measure(folder):
    """Of each file without measure: the format, what it is, seconds, MiB by which memory grew."""
    import resource
    import time

    def most():
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024

    for known in FORMATS.values():
        for content in originals(known.name):
            read(known.name, content)
    clock()
    for known in FORMATS.values():
        for name, act in [*endless_cases(known.name), *sparse_cases(known, folder)]:
            before, begun, said = most(), time.perf_counter(), "whole"
            try:
                act()
            except AttitudeError as error:
                said = str(error)
            taken = time.perf_counter() - begun, most() - before
            print(json.dumps([known.name, name, *taken, said]), flush=True)


def endless_cases(format):
    for name, beginning, unit in endless_files(format):
        yield name, partial(read, format, None, lambda _, a=beginning, b=unit: Endless(a, b))


def sparse_cases(known, folder):
    options = {"sclk": clock()} if known.name == "ck" else {}
    for k, (beginning, size) in enumerate(sparse_files(known.name)):
        path = os.path.join(folder, f"{k}" + known.endings[0])
        with open(path, "wb") as file:
            file.write(beginning)
            file.truncate(size)
        yield f"sparse after {len(beginning)} bytes", partial(Ephemeris.read, path, **options)


def test_files_without_measure_are_refused_within_seconds_and_in_little_memory(tmp_path):
    command = [sys.executable, "-c", f"from {__name__} import measure; measure({str(tmp_path)!r})"]
    run = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert run.returncode == 0, run.stderr
    found = [json.loads(line) for line in run.stdout.splitlines()]
    assert {format for format, *_ in found} == set(FORMATS)
    assert [case for case in found if case[2] > SECONDS or case[3] > MEBIBYTES] == []
    # a CK may be filled up with zeros
    assert {case[0] for case in found if case[4] == "whole"} <= {"ck"}
