"""Two-part arithmetic and what is built on it, against exact fractions and mpmath at sixty digits."""

import math
import random
from fractions import Fraction

import numpy as np
import pytest
from mpmath import mp, mpf
from numba import njit

from attitude.kernels import doubledouble as dd
from attitude.kernels import elliptic, expansion
from attitude.kernels.layout import INVARIANTS, Regime, workspace
from attitude.runtime import compiled

# u^2 = 2^-106, 1.2e-32: the unit of Joldes, Muller & Popescu's theorems, whose bounds these are.
UNIT = 2.0**-106
BOUNDS = {"add": 3, "sub": 3, "mul": 5, "div": 10, "sqrt": 25 / 8}
# Of hypot, sine, cosine, K and R_F: four times the measured error; exp adds the rounding of its argument.
FEW_UNITS = 16


@pytest.fixture(autouse=True)
def sixty_digits():
    with mp.workdps(60):
        yield


def over_pairs(function, arguments):
    """The compiled function over rows of pairs: (n, arguments, 2) -> (n, 2).

    Routines have no Python wrapper: only compiled code can call them.
    """
    pair = dd.pair
    of_row = {
        1: lambda row: function(pair(row[0])),
        2: lambda row: function(pair(row[0]), pair(row[1])),
        3: lambda row: function(pair(row[0]), pair(row[1]), pair(row[2])),
    }
    one = njit(error_model="numpy")(of_row[arguments])

    @njit(error_model="numpy")
    def loop(x, out):
        for i in range(x.shape[0]):
            out[i, 0], out[i, 1] = one(x[i])

    def called(rows):
        out = np.empty((len(rows), 2))
        loop(np.array(rows, dtype=float).reshape(len(rows), arguments, 2), out)
        return out.tolist()

    return called


def two_part(x):
    """The pair nearest a Fraction or mpf."""
    hi = float(x)
    return hi, float(x - (Fraction(hi) if isinstance(x, Fraction) else mpf(hi)))


def value(pair):
    return Fraction(pair[0]) + Fraction(pair[1])


def real(pair):
    return mpf(pair[0]) + mpf(pair[1])


def relative(pair, expected):
    return float(abs(real(pair) / expected - 1)) if expected else abs(pair[0])


def is_a_pair(pair):
    return pair[0] + pair[1] == pair[0]


def random_pair(rng, decades=20.0):
    hi = rng.choice((1, -1)) * 10 ** rng.uniform(-decades, decades)
    return hi, rng.choice((0.0, rng.uniform(-0.5, 0.5))) * math.ulp(hi)


def random_pairs(seed, count=2000):
    """Pairs of pairs of all sizes; for a third of them the second nearly cancels the first."""
    rng = random.Random(seed)
    for k in range(count):
        first = random_pair(rng)
        near = first[0] * (1 + rng.choice((0, 1, 2, 1e3, 1e9)) * 2.0**-52)
        yield first, random_pair(rng) if k % 3 else (near, first[1] * rng.choice((1, 0, -1)))


EXACT = {
    "add": lambda a, b: a + b,
    "sub": lambda a, b: a - b,
    "mul": lambda a, b: a * b,
    "div": lambda a, b: a / b,
}


@pytest.mark.parametrize("name", EXACT)
def test_arithmetic_keeps_its_bounds_for_all_sizes_signs_and_cancellations(name):
    rows = list(random_pairs(name))
    for row, computed in zip(rows, over_pairs(getattr(dd, name), 2)(rows), strict=True):
        expected = EXACT[name](*map(value, row))
        assert abs(value(computed) - expected) <= Fraction(BOUNDS[name] * UNIT) * abs(expected), row
        assert is_a_pair(computed), row


def test_square_root_keeps_its_bound_and_takes_zero():
    rows = [((abs(hi), math.copysign(lo, lo * hi)),) for (hi, lo), _ in random_pairs("sqrt")]
    for row, computed in zip(rows, over_pairs(dd.sqrt, 1)(rows), strict=True):
        assert relative(computed, mp.sqrt(real(row[0]))) <= BOUNDS["sqrt"] * UNIT, row
        assert is_a_pair(computed)
    assert over_pairs(dd.sqrt, 1)([((0.0, 0.0),)]) == [[0.0, 0.0]]


def test_hypot_keeps_its_digits_where_squares_leave_the_range():
    rng = random.Random("hypot")
    rows = [
        [random_pair(rng, decades) for _ in range(2)] for decades in (1, 20, 140, 270) for _ in range(200)
    ]
    rows += [[(1e300, 0.0), (-1e300, 0.0)], [(1e-300, 0.0), (0.0, 0.0)]]
    for row, computed in zip(rows, over_pairs(dd.hypot, 2)(rows), strict=True):
        assert relative(computed, mp.hypot(*map(real, row))) <= FEW_UNITS * UNIT, row
    assert over_pairs(dd.hypot, 2)([((0.0, 0.0), (0.0, 0.0))]) == [[0.0, 0.0]]


def test_exp_is_good_to_thirty_digits_down_to_the_least_double():
    rng = random.Random("exp")
    rows = [(two_part(mpf(rng.uniform(-600, 2)) * (1 + mpf(rng.random()) / 2**53)),) for _ in range(500)]
    rows += [((-x, 0.0),) for x in (0.0, 1e-300, 1e-20, 1e-3, 0.5 * math.log(2), 650.0)]
    for row, computed in zip(rows, over_pairs(dd.exp, 1)(rows), strict=True):
        assert relative(computed, mp.exp(real(row[0]))) <= (FEW_UNITS + abs(row[0][0])) * UNIT, row
    for argument in (-746.0, -1e6, -math.inf):
        assert over_pairs(dd.exp, 1)([((argument, 0.0),)]) == [[0.0, 0.0]]


@pytest.mark.parametrize("part", [0, 1], ids=["sine", "cosine"])
def test_sine_and_cosine_are_good_to_thirty_digits_within_two_radians(part):
    @njit(error_model="numpy")
    def one_of(x):
        both = dd.sin_cos(x)
        return both[part]

    rng = random.Random("sin_cos")
    rows = [(two_part(mpf(rng.uniform(-2, 2)) * (1 + mpf(rng.random()) / 2**53)),) for _ in range(500)]
    rows += [((x, 0.0),) for x in (0.0, 1e-300, -1e-20, 1e-3, -2.0, 2.0)]
    for row, computed in zip(rows, over_pairs(one_of, 1)(rows), strict=True):
        expected = (mp.sin, mp.cos)[part](real(row[0]))
        assert abs(real(computed) - expected) <= FEW_UNITS * UNIT * min(
            1, abs(real(row[0])) if part == 0 else 1
        ), row


@pytest.mark.parametrize(
    ("pair", "expected"),
    [
        (dd.PI, lambda: mp.pi),
        (dd.LN2, lambda: mp.log(2)),
        (dd.TURN, lambda: 2 * mp.pi),
        (dd.PER_TURN, lambda: 1 / (2 * mp.pi)),
    ],
    ids=["pi", "ln 2", "turn", "per turn"],
)
def test_constants_are_the_nearest_pairs(pair, expected):
    assert pair == two_part(expected())


# Elliptic integrals

MODULI = (1.0, 0.999, 0.5, 0.1, 1e-3, 1e-8, 1e-15, 1e-77, 1e-150, 1e-280)


def test_quarter_period_keeps_its_digits_down_to_the_least_modulus():
    rng = random.Random("K")
    rows = [(two_part(mpf(k1)),) for k1 in (*MODULI, *(10 ** rng.uniform(-20, 0) for _ in range(100)))]
    for row, computed in zip(rows, over_pairs(elliptic.quarter_period, 1)(rows), strict=True):
        assert relative(computed, mp.pi / 2 / mp.agm(1, real(row[0]))) <= FEW_UNITS * UNIT, row
    assert over_pairs(elliptic.quarter_period, 1)([((0.0, 0.0),)])[0][0] == math.inf


def test_carlson_integral_keeps_its_digits_for_all_moduli():
    """R_F(x^2, y^2, 1); with x = 0 it is the complete integral."""
    rng = random.Random("RF")
    sizes = [0.0, *MODULI, *(10 ** rng.uniform(-20, 0) for _ in range(10))]
    rows = [(two_part(mpf(x)), two_part(mpf(y)), (1.0, 0.0)) for x in sizes for y in sizes if x or y]
    for row, computed in zip(rows, over_pairs(elliptic.carlson_rf, 3)(rows), strict=True):
        assert relative(computed, mp.elliprf(*(real(root) ** 2 for root in row))) <= FEW_UNITS * UNIT, row


# Expansions


@njit(error_model="numpy")
def sum_of_products(factors, parts, work):
    """Exact sum of the products of rows of two-part numbers: number of parts, and value as a pair."""
    count = 0
    for row in range(factors.shape[0]):
        count = expansion.add_product(parts, count, factors[row], work)
    return count, expansion.two_part_value(parts, count)


def expand(products):
    parts, work = np.empty(256), np.empty((2, 256))
    count, pair = sum_of_products(np.array(products, dtype=float), parts, work)
    return parts[:count].tolist(), pair


def test_expansions_hold_sums_of_products_exactly_and_tell_their_sign():
    rng = random.Random("expansion")
    for _ in range(300):
        row = [random_pair(rng, 5) for _ in range(4)]
        minus = [(-row[0][0], -row[0][1]), *row[1:]]
        rng.shuffle(minus)
        nearly = [(minus[0][0] * (1 + rng.choice((0, 2.0**-52))), minus[0][1]), *minus[1:]]
        products = [row, nearly, [random_pair(rng, 5) for _ in range(4)] if rng.random() < 0.5 else row]
        for terms in (products, products[:2]):
            parts, pair = expand(terms)
            expected = sum(math.prod(map(value, row)) for row in terms)
            assert sum(map(Fraction, parts)) == expected
            assert (pair[0] > 0) - (pair[0] < 0) == (expected > 0) - (expected < 0)
            assert abs(value(pair) - expected) <= Fraction(UNIT) * abs(expected)


def test_expansions_know_zero():
    """3 (3 - 4) 2^2 + 6 (6 - 4) 1^2: the separatrix."""
    products = [
        [(3.0, 0.0), (-1.0, 0.0), (2.0, 0.0), (2.0, 0.0)],
        [(6.0, 0.0), (2.0, 0.0), (1.0, 0.0), (1.0, 0.0)],
    ]
    assert expand(products)[1] == (0.0, 0.0)
    products[0][2] = products[0][3] = (2.0, 1e-25)
    assert expand(products)[1][0] < 0


# Principal axes


TURNED = ((6.0, 2.0, 0.0), (2.0, 3.0, 0.0), (0.0, 0.0, 8.0))  # moments 2, 7, 8 about (1, -2, 0), (2, 1, 0), z
CONSTANT = {
    "rest": (TURNED, (0.0, 0.0, 0.0), True),
    "principal axis of a tensor": (TURNED, (0.3 * 2, 0.3, 0.0), True),
    "its other axis": (TURNED, (1e-3, -2e-3, 0.0), True),
    "an ulp off it": (TURNED, (math.nextafter(0.6, 1), 0.3, 0.0), False),
    "a hair out of its plane": (TURNED, (0.6, 0.3, 1e-150), False),
    "sphere": (np.diag([2.0, 2.0, 2.0]), (0.1, 0.2, 0.3), True),
    "sphere but for an ulp": (np.diag([2.0, 2.0, 2.0 + 2**-51]), (0.1, 0.2, 0.3), False),
    "degenerate plane": (np.diag([2.0, 2.0, 3.0]), (0.1, 0.7, 0.0), True),
    "a hair out of it": (np.diag([2.0, 2.0, 3.0]), (0.1, 0.7, 1e-150), False),
}


@pytest.mark.parametrize(("tensor", "rate", "expected"), CONSTANT.values(), ids=CONSTANT)
@pytest.mark.parametrize("scale", [1.0, 2.0**-500, 2.0**500])
def test_constant_rate_is_decided_without_rounding(tensor, rate, expected, scale):
    moments, axes = np.empty((1, 3, 2)), np.empty((1, 3, 3, 2))
    tensors, attitudes = np.array([tensor]) * scale, np.array([[1.0, 0.0, 0.0, 0.0]])
    compiled.principal_axes(tensors, moments, axes, np.empty((3, 3, 2)))
    record = np.zeros(1, INVARIANTS)
    compiled.invariants(tensors, moments, axes, np.array([rate]), attitudes, record, *workspace())
    assert (record["regime"][0] == Regime.CONSTANT_RATE) is np.bool_(expected)
