"""Rows of text: digits against orjson's and Python's own, dates against astropy's, whatever the threads."""

import random
from datetime import date, timedelta

import numpy as np
import orjson
import pytest
from astropy.time import Time
from scipy.interpolate import BarycentricInterpolator

from attitude import FormatError, orientation
from attitude.elapsed import Instants
from attitude.formats import aem_epochs, aem_rows, parts, rows
from attitude.formats.interpolant import lagrange

LINE = [b"", b"", b"\n"]
TINY = np.finfo(float).tiny
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
    return b"".join(rows.texts(np.ascontiguousarray(values)[None, :], LINE))


def read(lines, form=None):
    """Numbers of plain rows, and the lines that are not."""
    text = b"".join(line + b"\n" for line in lines) + bytes(rows.MARGIN)
    found, left = [], []

    def odd(place, stop, most):
        end = text.index(b"\n", place) + 1
        left.append(text[place : end - 1])
        return end, True

    end = rows.read(text, 0, len(text) - rows.MARGIN, form or rows.Form(1), found.append, odd)
    assert end == len(text) - rows.MARGIN
    return found, left


def numbers(lines):
    found, left = read(lines)
    return np.concatenate([part.columns[0] for part in found] or [np.zeros(0)]), left


# -- numbers ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("values", [any_doubles(600_000), usual_doubles(100_000)], ids=["any", "usual"])
def test_digits_are_the_shortest_and_read_back_to_the_same_bits(values):
    written = text_of(values)
    expected = orjson.dumps(values, option=orjson.OPT_SERIALIZE_NUMPY)[1:-1].split(b",")
    expected = [word if b"." in word else word.replace(b"e", b".0e") for word in expected]
    lines = written.split(b"\n")[:-1]
    assert lines == expected
    back, left = numbers(lines)
    odd = np.array([float(word) for word in left])
    assert (np.abs(odd) < TINY).all()  # what is no normal double is left to Python
    normal = np.abs(values) >= TINY
    normal |= values == 0.0
    assert np.array_equal(back[np.abs(back) != 0.0], values[normal & (values != 0.0)])
    assert np.array_equal(np.signbit(back), np.signbit(values[normal]))


def test_digits_are_those_of_repr():
    values = np.concatenate([any_doubles(20_000), usual_doubles(4_000)])
    for word, value in zip(text_of(values).split(b"\n")[:-1], values.tolist(), strict=True):
        assert float(word) == value
        digits = [w.lower().split("e")[0].replace(".", "").strip("-0") for w in (word.decode(), repr(value))]
        assert digits[0] == digits[1]


def many_forms():
    """Decimal numbers of up to 19 digits, in all forms that the grammar of an AEM has."""
    choose = random.Random(2)
    for _ in range(150_000):
        count = choose.randint(1, 19)
        digits, point = str(choose.randrange(10 ** (count - 1), 10**count)), choose.randint(0, count)
        body = choose.choice([f"{digits[:point]}.{digits[point:]}", digits, "000" + digits])
        power = choose.choice(["", f"e{choose.randint(-326, 308)}", f"E+{choose.randint(0, 30)}", "e-007"])
        yield choose.choice(["", "-", "+"]) + body + power


def halves():
    """Half-way between two doubles, and next to that."""
    choose = random.Random(3)
    for _ in range(30_000):
        half, fives = 2 * choose.randrange(2**52, 2**53) + 1, choose.randint(0, 4)
        shift = choose.randint(0, 8) if fives == 0 else 0
        exact = (half << shift) * 5**fives
        if exact < 10**19 - 1:
            yield from (f"{number}e-{fives}" for number in (exact - 1, exact, exact + 1))


@pytest.mark.parametrize("words", [many_forms, halves])
def test_numbers_are_rounded_as_python_rounds_them(words):
    words = list(words())
    back, left = numbers([word.encode() for word in words])
    values = np.array([float(word) for word in words])
    taken = np.isfinite(values) & (np.abs(values) > TINY)
    plain = {word.encode() for word in words} - set(left)
    kept = np.array([word.encode() in plain for word in words])
    assert np.array_equal(back.view(np.int64), values[kept].view(np.int64))
    assert not (kept & ~np.isfinite(values)).any()
    # Beyond the doubles, or what underflows though its digits do not: that is all that is left.
    assert (taken & ~kept).sum() == 0


@pytest.mark.parametrize(
    "word",
    [b"", b".", b"+", b"e5", b"1e", b"1e+", b"1e99999", b"1e400", b"nan", b"inf", b"-inf", b"0x1p3", b"1_0",
     b"1,5", b"--1", b"+-1", b"1.2.3", b"1e5.0", b"12345678901234567890", b"1\xb2", b"\xff", b"1\x00"],
)  # fmt: skip
def test_what_is_no_plain_number_is_left(word):
    found, left = read([b"1.5", word, b"2.5"], rows.Form(1, separator=b","))
    assert left == [word]
    assert np.concatenate([part.columns[0] for part in found]).tolist() == [1.5, 2.5]


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_what_is_not_finite_is_not_written(bad):
    with pytest.raises(FormatError, match=r"not finite, in row 9001,"):
        rows.texts(np.array([[*[1.0] * 9001, bad]]), LINE)


# -- rows -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("cores", [1, 2, 3])
def test_text_and_numbers_do_not_depend_on_threads(monkeypatch, cores):
    monkeypatch.setattr(rows, "WORTH_SHARING", 10)
    monkeypatch.setattr(rows, "WORTH_BYTES", 100)
    values = np.random.default_rng(4).uniform(-1, 1, (7, 1001))
    epochs = np.array([f"2026-01-01T00:{k // 60:02}:{k % 60:02}.000000000" for k in range(1001)], dtype="S29")
    pieces = [b"<row><e>", b"</e> ", *[b" "] * 6, b"</row> at the end\n"]
    expected = b"".join(
        b"<row><e>" + epoch + b"</e> " + b" ".join(repr(v).encode() for v in row) + b"</row> at the end\n"
        for epoch, row in zip(epochs.tolist(), values.T.tolist(), strict=True)
    )
    monkeypatch.setattr(rows, "cores", lambda: cores)
    texts = rows.texts(values, pieces, epochs)
    assert len(texts) == cores
    assert b"".join(texts).replace(b".0e-", b"e-") == expected
    lines = [
        line for line in b"".join(rows.texts(values, [b"", *[b" "] * 7, b"\n"], epochs)).split(b"\n") if line
    ]
    lines[500:500] = [b"", b"not a row", b" \t" + lines.pop(500).replace(b" ", b" \t ") + b" \r"]
    found, left = read(lines, rows.Form(7, rows.DATE))
    assert left == [b"not a row"]
    assert np.array_equal(np.concatenate([part.columns for part in found], axis=1), values)
    second = np.concatenate([part.second for part in found])
    assert np.array_equal(second - second[0], np.arange(1001))


def test_words_in_front_are_passed_over():
    found, left = read(
        [b"a b,1.0,2.0", b",3.0,4.0", b"x, 5.0,6.0", b"y,7.0", b"", b"z,8.0,9.0"],
        rows.Form(2, rows.WORD, b","),
    )
    assert np.concatenate([part.columns for part in found], axis=1).T.tolist() == [[1, 2], [3, 4], [8, 9]]
    assert left == [b"x, 5.0,6.0", b"y,7.0", b""]


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


def test_dates_are_read_as_the_careful_way_reads_them():
    texts = list(some_dates())
    found, left = read(texts, rows.Form(0, rows.DATE, zulu=True))
    expected = aem_epochs.each(texts, "UTC")
    assert left == []
    assert np.array_equal(np.concatenate([part.second for part in found]), expected.second)
    assert np.array_equal(np.concatenate([part.atto for part in found]), expected.atto)


WRONG_DATES = [
    "2026-02-29T00:00:00", "2026-13-01T00:00:00", "2026-00-01T00:00:00", "2026-01-00T00:00:00",
    "2026-04-31T00:00:00", "2026-366T00:00:00", "2026-000T00:00:00", "0000-01-01T00:00:00",
    "2026-01-01T24:00:00", "2026-01-01T00:60:00", "2026-01-01T00:00:61", "2026-01-01 00:00:00",
    "2026-1-01T00:00:00", "2026-01-01T00:00:00.", "2026-01-01T0:00:00", "2o26-01-01T00:00:00",
    "1900-02-29T00:00:00", "2026-01-01T00:00:00ZZ", "2026-01-01T00:00", "-026-01-01T00:00:00",
]  # fmt: skip


@pytest.mark.parametrize("text", WRONG_DATES)
def test_no_date_is_left_to_the_careful_way_which_refuses_it(text):
    found, left = read([text.encode()], rows.Form(0, rows.DATE, zulu=True))
    assert found == []
    assert left == [text.encode()]
    with pytest.raises(aem_epochs.EpochError):
        aem_epochs.each(left, "UTC")


def test_a_zone_or_a_leap_second_is_left_to_the_careful_way():
    lines = [b"2016-12-31T23:59:59.5 1.0", b"2016-12-31T23:59:60.5 2.0", b"2017-01-01T00:00:00.5Z 3.0"]
    assert read(lines, rows.Form(1, rows.DATE))[1] == lines[1:]
    assert aem_rows.careful(lines[1:], ("A",), "UTC").numbers.tolist() == [[2.0, 3.0]]


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
        written = parts.dates(Instants(seconds, None, start)).astype("U")
        time = Instants(seconds, None, start).time
        assert np.array_equal(written, plainly(time))
    assert (
        scale != "utc"
        or epoch[:4] != "2016"
        or "2016-12-31T23:59:60.250000000" in parts.dates(Instants(np.array([2.5]), None, start)).astype("U")
    )


def test_dates_use_both_parts_and_are_rounded_once():
    start = Time("2026-01-01", scale="tai")
    seconds, rest = np.array([1e8, 1e8, -1e8, 86399.9999999996]), np.array([4.9e-10, 5.1e-10, -5.1e-10, 0.0])
    assert parts.dates(Instants(seconds, rest, start)).tolist() == [
        b"2029-03-03T09:46:40.000000000",
        b"2029-03-03T09:46:40.000000001",
        b"2022-10-31T14:13:19.999999999",
        b"2026-01-02T00:00:00.000000000",
    ]


@pytest.mark.filterwarnings("ignore:ERFA")
@pytest.mark.parametrize("far", [4e11, -1e11])
def test_dates_beyond_four_digits_are_left_to_astropy(far):
    instants = Instants(np.array([0.0, far]), None, Time("2026-01-01", scale="tai"))
    assert parts.dates(instants).tolist() == parts.iso_text(instants.time).tolist()


# -- interpolation ----------------------------------------------------------------------------------


@pytest.mark.parametrize("degree", [1, 2, 7, 8, 15])
def test_errors_are_those_of_the_polynomials(degree):
    generator = np.random.default_rng(degree)
    t = np.cumsum(generator.uniform(0.5, 1.5, 40))
    nodes, true = generator.normal(size=(40, 4)), generator.normal(size=(60, 4))
    places = np.array([0.3, 0.9])
    nodes /= np.linalg.norm(nodes, axis=1)[:, None]
    true /= np.linalg.norm(true, axis=1)[:, None]
    found = lagrange(degree, "degree").errors(t, nodes, np.arange(5, 35), places, true)
    for i, error in enumerate(found):
        begin = min(max(5 + i - (degree - 1) // 2, 0), 39 - degree)
        window = slice(begin, begin + degree + 1)
        q = BarycentricInterpolator(t[window], nodes[window])(t[5 + i] + places * (t[6 + i] - t[5 + i]))
        q /= np.linalg.norm(q, axis=1)[:, None]
        expected = orientation.angle_between(q, true[2 * i : 2 * i + 2]).max()
        assert error == pytest.approx(float(expected), abs=1e-7 if expected > 3.1 else 1e-9)
