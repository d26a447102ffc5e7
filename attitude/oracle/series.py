"""Taylor series of a system of differential equations, coefficient by coefficient, to any number of digits.

A `Tape` records the equations once, as sums, products and powers; then it expands the solution about any
state. With tau = (t - start) / scale a series is a list of its coefficients in powers of tau, integers scaled
by 2^bits, and for state' = rhs: state[n + 1] = scale rhs[n] / (n + 1), rhs[n] from the coefficients up to n.
Products are rounded to nearest: rounded down, their errors would add up to a drift of the momentum, and of
the attitude with the square of time.
Equations must be in units in which no value is much greater than one.
"""

from operator import mul

from mpmath import mp, mpf

try:
    from gmpy2 import mpz
except ImportError:
    mpz = int


def cross_rows(u):
    """u x v as rows over the components of v, for `Tape.bilinear`."""
    x, y, z = u
    return [[None, (-1, z), y], [z, None, (-1, x)], [(-1, y), x, None]]


def product_rows(q):
    """Hamilton product q * (0, v) as rows over the components of v, for `Tape.bilinear`."""
    w, x, y, z = q
    return [[(-1, x), (-1, y), (-1, z)], [w, (-1, z), y], [z, w, (-1, x)], [(-1, y), x, w]]


class Tape:
    """Equations as rules that append to each series its next coefficient, in the order of recording."""

    def __init__(self, bits, order):
        self.bits, self.order = bits, order
        self.half = mpz(1) << (bits - 1)  # of a unit of the last place, before a product is shifted
        self.largest = bits + order  # bits of a coefficient, in series that grow less than twofold
        self.slot = 2 * self.largest + 16
        self.rules, self.series, self.packed = [], [], []
        self.states, self.start, self.rates = [], [], []

    # Numbers

    def fixed(self, value):
        """mpf to integer scaled by 2^bits."""
        return mpz(int(mp.nint(mp.ldexp(mpf(value), self.bits))))

    def real(self, integer):
        """Integer scaled by 2^bits to mpf."""
        return mp.ldexp(mpf(int(integer)), -self.bits)

    # Equations

    def state(self, value):
        """A series that begins with a value (mpf); `rate` adds to its derivative."""
        self.states.append(self._new())
        self.start.append(self.fixed(value))
        self.rates.append([])
        return self.states[-1]

    def rate(self, state, *terms):
        """Add series to the derivative of a state."""
        index = next(k for k, series in enumerate(self.states) if series is state)
        self.rates[index].extend(terms)

    def combination(self, terms, offset=0):
        """Sum of constant times series, over pairs (mpf, series), and of a constant."""
        out, bits, half, offset = self._new(), self.bits, self.half, self.fixed(offset)
        pairs = [(self.fixed(factor), series) for factor, series in terms if factor]

        def rule(n):
            total = sum((factor * series[n] for factor, series in pairs), half) >> bits
            out.append(total if n else total + offset)

        self.rules.append(rule)
        return out

    def bilinear(self, factors, rows):
        """Sum, for each row, products of the factors with its entries: a series, (-1, series), or None.

        The entries that one factor multiplies are packed in one long integer, so that Python multiplies and
        adds once for all rows.
        """
        outs = [self._new() for _ in rows]
        packed = [self._side_by_side([row[i] for row in rows]) for i in range(len(factors))]
        shifts = [(out, self.slot * j) for j, out in enumerate(outs)]
        # slots hold numbers of either sign, raised by half a slot so that none borrows from the next
        half, mask = mpz(1) << (self.slot - 1), (mpz(1) << self.slot) - 1
        bias, bits = sum((half + self.half) << at for _, at in shifts), self.bits

        def rule(_n):
            total = bias
            for factor, column in zip(factors, packed, strict=True):
                total += sum(map(mul, factor, reversed(column)))
            for out, at in shifts:
                out.append(((total >> at & mask) - half) >> bits)

        self.rules.append(rule)
        return outs

    def _side_by_side(self, entries):
        """Integers that hold a coefficient of each entry, a slot apart."""
        out = self._new(packed=True)
        signed = [entry if isinstance(entry, tuple) else (1, entry) for entry in entries]
        parts = [
            (sign, series, self.slot * j) for j, (sign, series) in enumerate(signed) if series is not None
        ]
        self.rules.append(lambda n: out.append(sum((sign * series[n]) << at for sign, series, at in parts)))
        return out

    def power(self, base, halves):
        """base^(halves / 2) for base > 0, by s base' halves / 2 = s' base.

        n base[0] s[n] = sum over k = 1..n of (halves k / 2 - (n - k)) base[k] s[n - k].
        """
        out, weighted = self._new(), self._new(packed=True)

        def rule(n):
            weighted.append(n * base[n])
            if not n:
                out.append(self.fixed(mp.power(self.real(base[0]), mpf(halves) / 2)))
                return
            # the term k = 0 is missing because out has no coefficient n yet
            first = sum(map(mul, weighted[1:], reversed(out)))
            second = sum(map(mul, base[1:], reversed(out)))
            whole = n * base[0]
            out.append(((halves + 2) * first - 2 * n * second + whole) // (2 * whole))

        self.rules.append(rule)
        return out

    def _new(self, packed=False):
        kind = self.packed if packed else self.series
        kind.append([])
        return kind[-1]

    # Solution

    def expand(self, start, scale):
        """Coefficients of the states about `start`, in (t - start) / scale, and that scale.

        The scale is halved until no coefficient overflows its slot.
        """
        while True:
            self._expand(start, self.fixed(scale))
            room = mpz(1) << self.largest
            if all(max(series) < room and min(series) > -room for series in self.series if series):
                return self.states, scale
            scale = scale / 2

    def _expand(self, start, scale):
        for series in (*self.series, *self.packed):
            series.clear()
        for series, value in zip(self.states, start, strict=True):
            series.append(value)
        bits, changes = self.bits, list(zip(self.states, self.rates, strict=True))
        for n in range(self.order):
            for rule in self.rules:
                rule(n)
            for series, terms in changes:
                change = sum(term[n] for term in terms)
                series.append((change * scale + (n + 1) * self.half) // ((n + 1) << bits))

    def step_length(self):
        """Length of a step, in the scale: |c_N| length^N stays below one unit of the last place."""
        tail = max(abs(coefficient) for series in self.states for coefficient in series[-2:])
        return min(mpf(1), mpf(2) ** (-mpf(int(tail).bit_length()) / self.order))

    def evaluate(self, argument):
        """The states at tau = argument, from the last expansion."""
        x, bits, values = self.fixed(argument), self.bits, []
        for series in self.states:
            value = mpz(0)
            for coefficient in reversed(series):
                value = (value * x + self.half >> bits) + coefficient
            values.append(value)
        return values
