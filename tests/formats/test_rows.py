"""Rows of text: digits against orjson's and Python's own, dates against astropy's, errors by their lines."""

import io
import random
import re
import subprocess
import sys
from datetime import date, timedelta

import numpy as np
import orjson
import pytest
from astropy.time import Time
from hypothesis import given
from hypothesis.strategies import floats, lists

from attitude import Ephemeris, FormatError, RigidBody, TorqueFreeMotion
from attitude.formats import FORMATS, date_text, encode, module_of, text_rows
from attitude.formats.ccsds import epochs
from attitude.formats.tables import ecsv, ndjson
from attitude.samples.chunks import Samples
from attitude.samples.translation import Translation
from attitude.times.instants import Instants
from tests.formats.damage import TEXT, originals, read

EPOCH = Time("2016-12-31T23:59:58", scale="utc")
EXTREMES = [
    0.0,
    -0.0,
    5e-324,
    2.2250738585072014e-308,
    1.7976931348623157e308,
    1e16,
    1e15,
    123456789012345680.0,
]
EXTREMES += [9.5367431640625e-07, 1e-5, 1e-4, 1e22, 1e23, 9007199254740993.0, 0.1 + 0.2, -1.5e-7, 5e-8]


def any_doubles(count):
    """Of all sizes, by their bits; and the powers of two and ten, whose neighbours are not equally near."""
    bits = np.random.default_rng(0).integers(-(2**63), 2**63, count, dtype=np.int64)
    values = bits.view(np.float64)
    powers = np.concatenate([2.0 ** np.arange(-1074, 1024), [float(f"1e{k}") for k in range(-323, 309)]])
    return np.concatenate([values[np.isfinite(values)], powers, -powers, EXTREMES])


def usual_doubles(count):
    generator = np.random.default_rng(1)
    kinds = [
        generator.uniform(-1, 1, count),
        generator.uniform(-400, 400, count),
        generator.integers(-(10**6), 10**6, count) / 1e3,
        generator.integers(0, 10**18, count).astype(float),
        generator.integers(0, 2**52, count).view(np.float64),  # subnormal
    ]
    return np.concatenate(kinds)


def text_of(values):
    return text_rows.texts(np.ascontiguousarray(values)[None, :], [b"", b"\n"])


# -- numbers ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("values", [any_doubles(1_000_000), usual_doubles(100_000)], ids=["any", "usual"])
def test_digits_are_the_shortest_and_read_back_to_the_same_bits(values):
    written = text_of(values)
    words = written.split(b"\n")[:-1]
    orjsons = orjson.dumps(values, option=orjson.OPT_SERIALIZE_NUMPY)[1:-1].split(b",")
    assert [digits(word) for word in words] == [digits(word) for word in orjsons]
    again = np.array(orjson.loads(b"[" + b",".join(words) + b"]"))
    assert np.array_equal(again.view("i8"), values.view("i8"))
    assert np.array_equal(text_rows.read(written, "n").columns[0].view("i8"), values.view("i8"))


def digits(word):
    """Those that count, and none of the zeros that place them."""
    return word.split(b"e")[0].replace(b".", b"").strip(b"-0")


@given(lists(floats(allow_nan=False, allow_infinity=False), min_size=1))
def test_every_double_has_a_point_and_comes_back(values):
    for word, value in zip(text_of(np.array(values)).split(b"\n"), values, strict=False):
        assert re.fullmatch(rb"-?\d+\.\d+(e[+-]\d+)?", word)
        assert float(word).hex() == value.hex()


@pytest.mark.parametrize("format", ["csv", "ndjson", "ecsv"])
def test_formats_give_back_every_bit_of_any_double(format):
    values = any_doubles(20_000)[-18_000:].reshape(6, -1)
    values[np.abs(values) > 1e300] = -0.0
    count = values.shape[1]
    moved = Translation(values[:3].T, values[3:].T)
    q = np.tile([0.5, -0.5, 0.5, -0.5], (count, 1))
    written = Ephemeris(q, Instants(np.arange(count) / 8, None, None), "ICRF", centre_of_mass=moved)
    content = b"".join(encode(Samples.of(written), FORMATS[format]).blocks)
    back = module_of(FORMATS[format]).parse(io.BytesIO(content), "given").translation
    for actual, true in ((back.position, moved.position), (back.velocity, moved.velocity)):
        assert np.array_equal(np.ascontiguousarray(actual).view("i8"), np.ascontiguousarray(true).view("i8"))


def many_forms():
    """Decimal numbers of up to 25 digits, in all forms that the grammar of an AEM has."""
    choose = random.Random(2)
    for _ in range(150_000):
        count = choose.randint(1, 25)
        digits, point = str(choose.randrange(10 ** (count - 1), 10**count)), choose.randint(0, count)
        body = choose.choice([f"{digits[:point]}.{digits[point:]}", digits, "000" + digits])
        power = choose.choice(["", f"e{choose.randint(-350, 280)}", f"E+{choose.randint(0, 30)}", "e-007"])
        yield choose.choice(["", "-"]) + body + power


def halves():
    """Half-way between two doubles, and next to that."""
    choose = random.Random(3)
    for _ in range(30_000):
        half, fives = 2 * choose.randrange(2**52, 2**53) + 1, choose.randint(0, 4)
        exact = (half << choose.randint(0, 8)) * 5**fives
        yield from (f"{number}e-{fives}" for number in (exact - 1, exact, exact + 1))


@pytest.mark.parametrize("words", [many_forms, halves])
def test_numbers_are_rounded_as_python_rounds_them(words):
    words = list(words())
    actual = text_rows.read("\n".join([*words, ""]).encode(), "n").columns[0]
    assert np.array_equal(actual.view("i8"), np.array([float(word) for word in words]).view("i8"))


NO_NUMBERS = b". + e5 1e 1e+ 1e400 nan inf -inf 0x1p3 1_0 1,5 --1 +-1 1.2.3 1e5.0 null NA".split()
NO_NUMBERS += [b"", b"1\xb2", b"\xff", b"1\x00", b'"1"', b"1\r2"]


@pytest.mark.parametrize("word", NO_NUMBERS)
def test_word_that_is_no_number_is_not_read(word):
    assert text_rows.read(b"a 1.5\n\xff 2.5\n", "tn").columns.tolist() == [[1.5, 2.5]]
    assert text_rows.read(b"a 1.5\nb %b\nc 2.5\n" % word, "tn") is None


@pytest.mark.parametrize("text", [b"1 2\n3\n", b"1 2\n\n3 4\n", b"1 2\n3 4 5\n", b"1  2\n", b" 1 2\n", b""])
def test_row_of_another_form_is_not_read(text):
    assert text_rows.read(text, "nn") is None


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_what_is_not_finite_is_not_written(bad):
    with pytest.raises(FormatError, match=r"not finite, in row 9001,"):
        text_rows.texts(np.array([[*[1.0] * 9001, bad]]), [b"", b"\n"])


# -- rows -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("most", [1, 10_000, 1 << 30])
def test_rows_are_pieces_a_date_and_numbers(monkeypatch, most):
    monkeypatch.setattr(text_rows, "MAX_TEXT_BYTES", most)
    values = np.random.default_rng(4).uniform(-1, 1, (7, 301))
    epochs = np.array([f"2026-01-01T00:{k // 60:02}:{k % 60:02}.000000000" for k in range(301)], dtype="S29")
    pieces = [b"<row><e>", b"</e> ", *[b" "] * 6, b"</row> at the end\n"]
    expected = b"".join(
        b"<row><e>" + epoch + b"</e> " + b" ".join(repr(v).encode() for v in row) + b"</row> at the end\n"
        for epoch, row in zip(epochs.tolist(), values.T.tolist(), strict=True)
    )
    assert text_rows.texts(values, pieces, epochs).replace(b".0e-", b"e-") == expected
    spaced = text_rows.texts(values, [b"", *[b" "] * 7, b"\n"], epochs)
    table = text_rows.read(spaced, "t" + "n" * 7)
    assert np.array_equal(table.columns, values)
    assert np.array_equal(text_rows.read(spaced, "-" + "n" * 7).columns, values)
    assert bytes(text_rows.contents(table.texts[0])) == b"".join(epochs.tolist())


def test_any_blanks_separate_values_and_empty_lines_are_passed_over():
    text = b"1 2\n\n \t 3\t  4\r\n5 6 \n"
    table, numbers = text_rows.read_spaced(text, 7, "nn")
    assert table.columns.T.tolist() == [[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]]
    assert list(numbers) == [7, 9, 10]
    lines, numbers = text_rows.read_spaced(text + b"\n x  7\n", 7, "nn")
    assert lines == [b"1 2", b"3 4", b"5 6", b"x 7"]
    assert list(numbers) == [7, 9, 10, 12]


def ephemeris(count, format):
    motion = TorqueFreeMotion(RigidBody((1, 2, 3)), (1, 0, 0, 0), (0.3, 0.4, 0.5), EPOCH, order="wxyz")
    return b"".join(encode(Samples.of(motion.at(np.arange(count) / 8)), FORMATS[format]).blocks)


WRONG = {
    "aem": [(b"0.", b"0,"), (b"T", b" "), (b" 0.", b" nan."), (b" 0.", b" "), (b"2017", b"2016")],
    "aem-xml": [(b">0.", b">0,"), (b">-0.", b">inf"), (b">2017", b">2016")],
    "stk": [(b" 0.", b" 0,"), (b" 0.", b" nan"), (b" 0.", b" 1 0.")],
    "csv": [(b",0.", b",0x"), (b",0.0,0.", b",0.0,"), (b",0.", b",1,0."), (b",0.", b",nan#")],
    "ndjson": [(b":0.", b":x"), (b":0.", b':"0.'), (b"}", b"]"), (b'"q_w"', b'"q_v"'), (b"q_w", b"q_x")],
}


@pytest.mark.parametrize(
    ("format", "old", "new"), [(format, *pair) for format, pairs in WRONG.items() for pair in pairs]
)
@pytest.mark.parametrize("block", [5000, 1 << 22])
def test_error_late_in_a_file_names_its_line(monkeypatch, format, old, new, block):
    monkeypatch.setattr("attitude.formats.line_blocks.BLOCK_BYTES", block)
    monkeypatch.setattr("attitude.formats.ccsds.xml_reader.CHUNK_BYTES", block)
    text = ephemeris(400, format).split(b"\n")
    wrong = next(i for i in range(len(text) * 3 // 4, len(text)) if old in text[i])
    text[wrong] = text[wrong].replace(old, new, 1)
    with pytest.raises(FormatError) as caught:
        module_of(FORMATS[format]).parse(io.BytesIO(b"\n".join(text)), "given")
    epoch = max(i for i in range(wrong + 1) if b"<EPOCH>" in text[i]) if format == "aem-xml" else wrong
    assert caught.value.line == epoch + 1


@pytest.mark.parametrize("change", [b"plain", b"order", b"blanks", b"whole numbers"])
def test_other_writers_objects_are_read_as_well(change):
    """What is punctuated otherwise than the first object is read by orjson, to the same bits."""
    expected = ndjson.parse(io.BytesIO(ephemeris(9, "ndjson")), "given")
    lines = ephemeris(9, "ndjson").splitlines(keepends=True)
    if change == b"order":
        lines[5] = orjson.dumps(dict(reversed(orjson.loads(lines[5]).items()))) + b"\n"
    if change == b"blanks":
        lines[5] = lines[5].replace(b":", b" : ").replace(b",", b" ,\t")
    if change == b"whole numbers":
        lines[9] = lines[9].replace(b'"elapsed_s":1.0', b'"elapsed_s":1')
    actual = ndjson.parse(io.BytesIO(b"".join(lines)), "given")
    assert np.array_equal(actual.quaternion("wxyz"), expected.quaternion("wxyz"))
    assert np.array_equal(actual.elapsed, expected.elapsed)


def test_a_name_for_another_is_seen_though_the_marks_are_the_same():
    lines = ephemeris(9, "ndjson").splitlines(keepends=True)
    lines[5] = lines[5].replace(b"q_x", b"Q").replace(b"q_y", b"q_x").replace(b"Q", b"q_y")
    actual = ndjson.parse(io.BytesIO(b"".join(lines)), "given").quaternion("wxyz")
    expected = ndjson.parse(io.BytesIO(ephemeris(9, "ndjson")), "given").quaternion("wxyz")
    assert actual[4].tolist() == expected[4][[0, 2, 1, 3]].tolist()
    assert np.array_equal(np.delete(actual, 4, axis=0), np.delete(expected, 4, axis=0))


@pytest.mark.parametrize("old", [b"] [", b" [", b"]\n", b",", b"[0."])
def test_ecsv_of_another_form_is_left_to_astropy_or_refused(old):
    content = ephemeris(9, "ecsv")
    begin = content.index(b"angular_velocity\n") + 17
    for new in (b" ", b"", b"[", b",", b"]", b"\n", b"[0.5]"):
        changed = content[:begin] + content[begin:].replace(old, new, 1)
        try:
            actual = ecsv.parse(io.BytesIO(changed), "given").quaternion("wxyz")
        except FormatError:
            continue
        assert np.array_equal(actual, ecsv.parse(io.BytesIO(content), "given").quaternion("wxyz"))


GROWTH = """
import resource
from attitude.formats import write
from tests.benchmarks.formats_memory import lazy
for pieces in (2, 8):
    for format in ("csv", "aem"):
        write(lazy(pieces << 16), "/dev/null", format)
    print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
"""


def test_text_takes_the_memory_of_a_piece_however_long_it_is():
    run = subprocess.run([sys.executable, "-c", GROWTH], capture_output=True, text=True, check=True)
    before, after = map(int, run.stdout.split())
    assert after - before < 32 * 1024  # KiB; the text itself grows by 70 MB


# -- dates ------------------------------------------------------------------------------------------


def some_dates():
    choose = random.Random(5)
    first = date(1, 1, 1)
    for _ in range(4000):
        day = first + timedelta(days=choose.randrange(3652058))
        clock = f"{choose.randrange(24):02}:{choose.randrange(60):02}:{choose.randrange(60):02}"
        decimals = "." + "".join(choose.choices("0123456789", k=choose.randint(1, 18)))
        form = f"{day.year:04}-{day.month:02}-{day.day:02}"
        form = choose.choice([form, f"{day.year:04}-{day.timetuple().tm_yday:03}"])
        yield f"{form}T{clock}{choose.choice(['', decimals])}{choose.choice(['', 'Z'])}".encode()


def arrow(texts):
    return text_rows.read(b"".join(text + b"\n" for text in texts), "t", b"|").texts[0]


def test_dates_of_one_width_are_read_as_each_is():
    groups = {}
    for text in some_dates():
        groups.setdefault(len(text), []).append(text)
    assert len(groups) > 20
    for texts in groups.values():
        alone = [list(epochs.parse_epoch(text, "UTC")) for text in texts]
        assert np.stack(epochs.parse_epochs(arrow(texts), "UTC"), axis=1).tolist() == alone


WRONG_DATES = [
    "2026-02-29T00:00:00", "2026-13-01T00:00:00", "2026-00-01T00:00:00", "2026-01-00T00:00:00",
    "2026-04-31T00:00:00", "2026-366T00:00:00", "2026-000T00:00:00", "0000-01-01T00:00:00",
    "2026-01-01T24:00:00", "2026-01-01T00:60:00", "2026-01-01T00:00:61", "2026-01-01 00:00:00",
    "2026-1-01T00:00:00", "2026-01-01T00:00:00.", "2026-01-01T0:00:00", "2o26-01-01T00:00:00",
    "1900-02-29T00:00:00", "2026-01-01T00:00:00ZZ", "2026-01-01T00:00", "-026-01-01T00:00:00",
]  # fmt: skip


@pytest.mark.parametrize("text", WRONG_DATES)
@pytest.mark.parametrize("beside", [[], [b"2026-01-01T00:00:00"], [b"2026-01-01T00:00:00.5"] * 3])
def test_no_date_is_refused_by_its_place(text, beside):
    with pytest.raises(epochs.RowError) as caught:
        epochs.parse_epochs(arrow([*beside, text.encode(), *beside]), "UTC")
    assert caught.value.index == len(beside)


def test_a_zone_and_a_leap_second_are_read():
    texts = [b"2016-12-31T23:59:59.5", b"2016-12-31T23:59:60.5", b"2017-01-01T00:00:00.5"]
    second, atto = epochs.parse_epochs(arrow(texts), "UTC")
    assert np.diff(second).tolist() == [1, 1]
    assert set(atto.tolist()) == {5 * 10**17}
    zoned = epochs.parse_epochs(arrow([text + b"Z" for text in texts]), "UTC")
    assert np.array_equal(zoned.second, second)
    mixed = epochs.parse_epochs(arrow([texts[0], texts[1] + b"Z", b"2017-001T00:00:00.5"]), "UTC")
    assert np.array_equal(mixed.second, second)


def plainly(time):
    time.format, time.precision = "isot", 9
    return time.value


@pytest.mark.filterwarnings("ignore:ERFA")
@pytest.mark.parametrize("scale", ["utc", "tai", "tt", "tdb"])
@pytest.mark.parametrize("epoch", ["1971-12-31T23:59:58.25", "1999-12-31T12:00:00", "2016-12-31T23:59:57.75"])
def test_dates_are_written_as_astropy_writes_them(scale, epoch):
    start = Time(epoch, scale=scale)
    for seconds in (
        np.arange(-8, 8, 0.125),
        np.random.default_rng(6).integers(-(10**11), 10**11, 2000) / 128,
    ):
        instants = Instants(seconds, None, start)
        assert np.array_equal(date_text.dates(instants).astype("U"), plainly(instants.time))


def test_date_in_a_leap_second_is_written_with_second_60():
    start = Time("2016-12-31T23:59:57.75", scale="utc")
    assert date_text.dates(Instants(np.array([2.5]), None, start)).tolist() == [
        b"2016-12-31T23:59:60.250000000"
    ]


def test_dates_use_both_parts_and_are_rounded_once():
    start = Time("2026-01-01", scale="tai")
    seconds, rest = np.array([1e8, 1e8, -1e8, 86399.9999999996]), np.array([4.9e-10, 5.1e-10, -5.1e-10, 0.0])
    assert date_text.dates(Instants(seconds, rest, start)).tolist() == [
        b"2029-03-03T09:46:40.000000000",
        b"2029-03-03T09:46:40.000000001",
        b"2022-10-31T14:13:19.999999999",
        b"2026-01-02T00:00:00.000000000",
    ]


@pytest.mark.filterwarnings("ignore:ERFA")
@pytest.mark.parametrize("far", [4e11, -1e11])
def test_dates_beyond_four_digits_are_left_to_astropy(far):
    instants = Instants(np.array([0.0, far]), None, Time("2026-01-01", scale="tai"))
    assert date_text.dates(instants).tolist() == date_text.iso_text(instants.time).tolist()


# -- interpolation ----------------------------------------------------------------------------------


@pytest.mark.parametrize("mark", [b"", b"\xef\xbb\xbf"], ids=["", "mark"])
@pytest.mark.parametrize("end", [b"\r\n", b"\r", b"\n\r"], ids=["CRLF", "CR", "LFCR"])
@pytest.mark.parametrize("format", TEXT)
def test_line_ends_and_a_byte_order_mark_have_no_meaning(format, end, mark):
    original = originals(format)[0]
    back, whole = read(format, mark + original.replace(b"\n", end)), read(format, original)
    np.testing.assert_array_equal(back.quaternion("wxyz"), whole.quaternion("wxyz"))
    np.testing.assert_array_equal(back.elapsed, whole.elapsed)
