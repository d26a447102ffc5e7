"""Malformed files of every format: refused by name, with a line where there are lines; nothing half-read."""

import io
import json
import os
import re
import subprocess
import sys
from functools import partial, reduce

import numpy as np
import pytest

from attitude import AttitudeError, Ephemeris, FormatError
from attitude.formats.registry import FORMATS
from attitude.times.instants import Instants
from tests.formats.damage import EXACT, T, clock, motion, originals, read, written
from tests.tables import GONE, table

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


# -- damage that is listed: tests/tables/malformed_files.json -----------------------------------------


def encoded(text):
    return text.encode("utf-8", "surrogateescape")


def substituted(content, pattern, replacement, count=1):
    changed = re.sub(encoded(pattern), encoded(replacement), content, count=count)
    assert changed != content
    return changed


def with_members(content, changes):
    """A document of JSON, its members, or by `columns__NAME` its columns, replaced or taken away."""
    document = json.loads(content)
    for name, value in changes.items():
        prefix, _, column = name.rpartition("__")
        part = document[prefix] if prefix else document
        part[column] = value
        if value == GONE:
            del part[column]
    return json.dumps(document).encode()


def with_samples(content, indices):
    """A CZML with other samples: numbers in fives."""
    document = json.loads(content)
    orientation = document[1]["orientation"]
    values = orientation["unitQuaternion"]
    orientation["unitQuaternion"] = [value for i in indices for value in values[5 * i : 5 * i + 5]]
    return json.dumps(document).encode()


def with_rows(format, content, change):
    rows = rows_of(format, content)
    assert len(rows) == len(T)
    texts = change([row[0] for row in rows])
    return content[: rows[0].start()] + b"".join(texts) + content[rows[-1].end() :]


def damaged(format, kind, *arguments):
    """What a row of the table does to the first of the originals, or to another that it names at its end."""
    if kind == "whole":
        return encoded(*arguments)
    if kind == "sub":
        pattern, replacement, *rest = arguments
        count, which = [*rest, *(1, 0)[len(rest) :]]
        return substituted(originals(format)[which], pattern, replacement, count)
    if kind == "subs":
        return reduce(lambda content, pair: substituted(content, *pair, 0), *arguments, original(format))
    if kind == "json":
        changes, which = (*arguments, 0)[:2]
        return with_members(originals(format)[which], changes)
    if kind == "samples":
        return with_samples(original(format), *arguments)
    if kind == "rows":
        return with_rows(format, original(format), lambda rows: [rows[i] for i in arguments[0]])
    i, pattern, replacement = arguments

    def change(rows):
        return [*rows[:i], substituted(rows[i], pattern, replacement), *rows[i + 1 :]]

    return with_rows(format, original(format), change)


def lines_of(format, content, position):
    """First and last line that an error may name: a line, a row of the samples, or where a text stands."""
    if isinstance(position, int):
        return position, position
    if isinstance(position, str):
        begin = end = content.index(encoded(position))
    elif position[0] < len(rows_of(format, content)):
        begin, end = rows_of(format, content)[position[0]].span()
    else:
        begin, end = re.search(rb"(?m)^.*DATA_STOP|^.*\Z", content).span()
    return content[:begin].count(b"\n") + 1, content[: max(begin, end - 1)].count(b"\n") + 1


def assert_refused(format, content, words, position=None):
    error = refusal(format, content)
    assert re.search(words, str(error)), str(error)
    if position is not None:
        first, last = lines_of(format, content, position)
        assert first <= error.line <= last


@pytest.mark.parametrize(
    ("format", "edit", "words", "position"),
    [pytest.param(*row, id=f"{row[0]}: {row[2]}") for row in table("malformed_files")],
)
def test_malformed_file_is_refused_by_file_and_line(format, edit, words, position):
    assert_refused(format, damaged(format, *edit), words, position)


DEEP, VERY_DEEP = "[" * 900 + "]" * 900, "[" * 100_000 + "]" * 100_000
LAUGHS = "".join(f"# - l{i}: &l{i} [{','.join([f'*l{i - 1}' if i else 'x'] * 10)}]\n" for i in range(30))
KIND, COLUMN = '"kind":"[^"]*"', r'"q_w":\['
LARGE = [
    *((format, KIND, '"kind":' + DEEP, "kind is|not JSON") for format in ("json", "ndjson", "csv")),
    *((format, KIND, '"kind":' + VERY_DEEP, "not JSON") for format in ("json", "ndjson", "csv")),
    ("json", COLUMN, '"q_w":[' + DEEP + ",", "q_w: numbers|too many levels"),
    ("json", r"(?s).*", "[" * 100_000, "not JSON"),
    ("czml", '"version":"1.0"', '"version":' + DEEP, "version"),
    ("ecsv", r"# - \{name: ''\}\n", LAUGHS, "aliases expand to more"),
    ("aem-xml", "<data>", "<data>" + "<a>" * 10**5, "no element 'a' belongs in 'data'"),
    ("aem-xml", "<segment>", "<segment>" + "<a>" * 10**5, "no element 'a' belongs in 'segment'"),
    ("aem-xml", "<body>", "<" + "a" * 5_000_000, "more than 1048576 bytes without an element"),
    ("aem-xml", "<OBJECT_ID>", "<OBJECT_ID>" + "a " * 1_000_000, "a text of more than"),
    ("aem", "= ATTITUDE", "= " + "A" * 231, "1 to 230 printable"),
]


@pytest.mark.parametrize(("format", "pattern", "replacement", "words"), LARGE, ids=range(len(LARGE)))
def test_deep_and_long_parts_are_refused(format, pattern, replacement, words):
    position = "AAA" if format == "aem" else "<a>" if "<a>" in replacement else None
    assert_refused(format, damaged(format, "sub", pattern, replacement), words, position)


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


@pytest.mark.parametrize("rest", [1e-6, 1e10, -1e300])
@pytest.mark.parametrize("format", EXACT)
def test_second_part_of_an_instant_is_only_its_rounding_error(format, rest):
    low = np.array([0.0, 1e-18, rest, 0.0, 0.0])
    split = Ephemeris(motion().at(T).quaternion("wxyz"), Instants(T, low, None), "GCRF")
    error = refusal(format, written(format, split))
    assert re.search(r"elapsed_rest_s\[2\]: the rounding error of elapsed_s", str(error)), str(error)


@each_format
def test_truncated_file_is_refused(format):
    content = original(format)
    for length in range(0, len(content), 1 + len(content) // 60):
        part = content[:length]
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
    for content in (b"", b"\n", b" \n" * 1000, bytes(100), b"\xff\xfe" * 100):
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
        if {format, other} in ({"aem", "aem-xml"}, {"acm", "acm-xml"}):  # the syntaxes know each other
            assert not refused_or_the_same(format, original(other))
        elif (format, other) in (("aem", "acm-xml"), ("aem-xml", "acm-xml")):  # the usual ending is .xml
            assert read(format, original(other)).name == read(other, original(other)).name
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
    "acm": [b"COMMENT more\n", b"\n", b"             \n"],
    "aem-xml": [b"<COMMENT>more</COMMENT>\n", b"\n", b"<!-- -->"],
    "acm-xml": [b"<COMMENT>more</COMMENT>\n", b"\n", b"<!-- -->"],
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
        self.left, self.unit, self.byte_count = beginning, unit * (1 + (1 << 16) // len(unit)), 0

    def readable(self):
        return True

    def read(self, size=-1):
        assert size >= 0, "read without measure"
        while len(self.left) < size:
            self.left += self.unit * (1 + size // len(self.unit))
        block, self.left = self.left[:size], self.left[size:]
        self.byte_count += size
        return block


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
            before, begun, result = most(), time.perf_counter(), "whole"
            try:
                act()
            except AttitudeError as error:
                result = str(error)
            spent = time.perf_counter() - begun, most() - before
            print(json.dumps([known.name, name, *spent, result]), flush=True)


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
    cases = [json.loads(line) for line in run.stdout.splitlines()]
    assert {format for format, *_ in cases} == set(FORMATS)
    assert [case for case in cases if case[2] > SECONDS or case[3] > MEBIBYTES] == []
    # a CK may be filled up with zeros
    assert {case[0] for case in cases if case[4] == "whole"} <= {"ck"}
