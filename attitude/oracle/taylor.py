"""Route 1: Taylor series of Euler's equations, continued to any horizon by the period map.

No elliptic or theta function appears. With gamma = Lb / L and a_i = 1/I_i,

    gamma1' = L (a3 - a2) gamma2 gamma3  (and cyclic),     q' = q omega / 2,     omega_i = L a_i gamma_i.

A rotation about the momentum at the rate L a_mid is taken out of q exactly,

    q = q0 exp(gamma(0) L a_mid t / 2) p,
    p' = p w / 2,    w_i = L (a_i - a_mid) gamma_i,    p(0) = 1,

so that a nearly spherical body needs no more steps than any other. gamma has a period T, after which
p(T) = exp(gamma(0) angle / 2); hence p(t + n T) = p(T)^n p(t), for any n, and its sign is the continuous one.

Numbers are the integers of `series`; time is in units of 1 / (L (a_max - a_min)): no rate exceeds one.
"""

from functools import lru_cache
from math import ceil, log
from typing import NamedTuple

from mpmath import mp, mpf

from .exact import (
    circulation,
    constant_rotation,
    decades,
    elapsed,
    fractions,
    half_turn,
    multiply,
    normalised,
    real,
    reals,
)
from .series import Tape, product_rows

GUARD_DIGITS = 28
MAX_STEP = 2.0
MAX_BYTES = 1 << 26  # of the steps that a motion keeps
# Beside the separatrix errors grow as exp(u), and u is less than the time in rate units.
SEPARATRIX_DIGITS = 60


def attitude_and_rate(moments, omega, q0, t, digits=50):
    """Attitude and body rate after time t; arguments and results as in `theta.attitude_and_rate`.

    Beyond one period the period map is used. On the separatrix plain Taylor steps reach t, or an
    ArithmeticError tells that it is too many time constants away. Rest, a sphere and pure spin have nothing
    to step: there q = q0 exp(omega t / 2).
    """
    return motion(fractions(moments), fractions(omega), digits).at(t, q0)


def integrate(moments, omega, q0, t, digits=50):
    """Attitude and rate, stepping all the way to t, over however many periods."""
    return motion(fractions(moments), fractions(omega), digits).at(t, q0, by_period=False)


@lru_cache(maxsize=4)
def motion(moments, omega, digits=50):
    """The `TaylorMotion` of a body, from Fractions; keeps the steps that it has made."""
    return TaylorMotion(moments, omega, digits)


class Step(NamedTuple):
    """Scaled Taylor coefficients of (gamma, p) over one step; argument (t - start) / scale in [0, length]."""

    start: object
    scale: object
    length: object
    series: list


class TaylorMotion:
    """Solution of Euler's equations and of the attitude relative to the start, as stored Taylor steps."""

    def __init__(self, moments, omega, digits):
        self.moments, self.omega, self.digits = moments, omega, digits
        self.regime, self.mid_axis, self.polar_axis, self.polar_sign, lost = _character(moments, omega)
        self.bits = ceil((digits + GUARD_DIGITS + lost) * 3.3219281) + 8
        self.order = ceil(self.bits * log(2) / 2)
        self.steps = {1: [], -1: []}
        self.max_steps = MAX_BYTES // (7 * (self.order + 1) * (self.bits // 8 + 80))
        self.period_map = None
        if self.regime != "constant_rate":
            with mp.workprec(self.bits + 64):
                a = [1 / moment for moment in moments]
                spread = max(a) - min(a)
                momentum = [moment * rate for moment, rate in zip(moments, omega, strict=True)]
                self.L = mp.sqrt(real(sum(component * component for component in momentum)))
                self.gamma0 = [real(component) / self.L for component in momentum]
                self.rate_unit = self.L * real(spread)
                self.mean_rate = self.L * real(a[self.mid_axis])
                self.inverse = [real(component) for component in a]
                self.gamma_rates = [real((a[(k + 2) % 3] - a[(k + 1) % 3]) / spread) for k in range(3)]
                self.p_rates = [real((component - a[self.mid_axis]) / spread) for component in a]
                self.tape = Tape(self.bits, self.order)
                self._record_equations()

    def _record_equations(self):
        tape = self.tape
        gamma = [tape.state(component) for component in self.gamma0]
        p = [tape.state(component) for component in (1, 0, 0, 0)]
        for k in range(3):
            (product,) = tape.bilinear([gamma[(k + 1) % 3]], [[gamma[(k + 2) % 3]]])
            tape.rate(gamma[k], tape.combination([(self.gamma_rates[k], product)]))
        w = [tape.combination([(rate / 2, g)]) for rate, g in zip(self.p_rates, gamma, strict=True)]
        for component, product in zip(p, tape.bilinear(w, product_rows(p)), strict=True):
            tape.rate(component, product)

    # Steps

    def next_step(self, direction):
        """Append a step forward (1) or backward (-1), as long as its own coefficients allow."""
        steps = self.steps[direction]
        if len(steps) >= self.max_steps:
            raise ArithmeticError(f"{self.max_steps} Taylor steps do not reach the time asked for")
        if steps:
            last = steps[-1]
            start, state = last.start + last.scale * last.length, self.evaluate(last, last.length)
            trial = 1.5 * abs(last.scale) * last.length
        else:
            start, state, trial = mpf(0), self.tape.start, mpf(1)
        series, scale = self.tape.expand(state, direction * min(trial, self.longest_step(state)))
        series = [list(component) for component in series]  # the tape's own, which it fills again
        steps.append(Step(start, scale, self.tape.step_length(), series))

    def longest_step(self, state):
        """A time in which neither gamma_mid has two zeros nor alpha makes half a turn.

        No rate exceeds one, so a motion that starts at sine rho from the middle axis stays log(1/rho).
        """
        off = [self.tape.real(abs(state[k])) for k in range(3) if k != self.mid_axis]
        return MAX_STEP - mp.log(max(*off, mpf(2) ** -self.bits))

    def evaluate(self, step, argument):
        """(gamma, p) as integers, at (t - start) / scale = argument in [0, 1]."""
        return [self.horner(component, argument) for component in step.series]

    def horner(self, series, argument):
        """The sum of a series, as an integer."""
        x, value = self.tape.fixed(argument), 0
        for coefficient in reversed(series):
            value = (value * x >> self.bits) + coefficient
        return value

    def state(self, time):
        """(gamma, p) as integers at a time in rate units, stepping until it is reached."""
        steps = self.steps[1 if time >= 0 else -1]
        while not steps or abs(steps[-1].start + steps[-1].scale * steps[-1].length) < abs(time):
            self.next_step(1 if time >= 0 else -1)
        low, high = 0, len(steps) - 1
        while low < high:
            middle = (low + high + 1) // 2
            low, high = (middle, high) if abs(steps[middle].start) <= abs(time) else (low, middle - 1)
        step = steps[low]
        return self.evaluate(step, (time - step.start) / step.scale)

    # Period map

    def period(self):
        """(T in rate units, angle): p(T) = exp(gamma(0) angle / 2), the angle continuous from 0."""
        if self.period_map is None:
            with mp.workprec(self.bits + 64):
                first, second = self._crossings()
                period = 2 * (second - first)
                gamma = [self.tape.real(component) for component in self.state(period)[:3]]
                closure = max(abs(now - then) for now, then in zip(gamma, self.gamma0, strict=True))
                if closure > mpf(10) ** -(self.digits + 10):
                    raise ArithmeticError(f"the momentum misses its start by {mp.nstr(closure, 5)}")
                self.period_map = period, self._angle(period)
        return self.period_map

    def _crossings(self):
        """Times of two successive zeros of gamma_mid, which are half a period apart."""
        times, number = [], 0
        while len(times) < 2:
            if number == len(self.steps[1]):
                self.next_step(1)
            step = self.steps[1][number]
            number += 1
            before = step.series[self.mid_axis][0]
            after = self.evaluate(step, step.length)[self.mid_axis]
            if before == 0 or ((before < 0) != (after < 0) and after != 0):
                times.append(step.start + step.scale * self._root(step))
        return times

    def _root(self, step):
        """Newton's method for gamma_mid = 0 within a step, from a bisected start."""
        series = step.series[self.mid_axis]
        if series[0] == 0:
            return mpf(0)
        slope = [n * coefficient for n, coefficient in enumerate(series)][1:]
        low, high = mpf(0), step.length
        for _ in range(12):
            middle = (low + high) / 2
            before = (self.horner(series, middle) < 0) == (series[0] < 0)
            low, high = (middle, high) if before else (low, middle)
        root = (low + high) / 2
        for _ in range(ceil(log(self.bits) / log(2))):
            root -= mpf(int(self.horner(series, root))) / int(self.horner(slope, root))
        return root

    def _angle(self, period):
        """Twice the continuous growth of arg alpha over a period.

        alpha = r0 + i r_polar for r(t) = r(0) p(t), where r(0) turns gamma(0) into the axis circulated about:
        |alpha|^2 = (1 + |gamma_polar|) / 2 never vanishes, and no step turns it by half a turn.
        """
        axis = [mpf(self.polar_sign * int(k == self.polar_axis)) for k in range(3)]
        g, e = self.gamma0, axis
        cross = (g[1] * e[2] - g[2] * e[1], g[2] * e[0] - g[0] * e[2], g[0] * e[1] - g[1] * e[0])
        start = (1 + sum(a * b for a, b in zip(g, e, strict=True)), *cross)
        times = [step.start for step in self.steps[1] if step.start < period] + [period]
        total, previous = mpf(0), None
        for time in times:
            r = multiply(start, [self.tape.real(component) for component in self.state(time)[3:]])
            argument = mp.atan2(sum(a * b for a, b in zip(r[1:], axis, strict=True)), r[0])
            if previous is not None:
                total += (argument - previous + mp.pi) % (2 * mp.pi) - mp.pi
            previous = argument
        return 2 * total

    # What callers ask

    def at(self, t, q0, by_period=True):
        """Attitude (wxyz, continuous, q(0) = q0) and body rate at time t."""
        t = elapsed(t)
        with mp.workprec(self.bits + 64):
            if self.regime == "constant_rate":
                rate = tuple(reals(self.omega))
                return multiply(normalised(q0), constant_rotation(rate, real(t))), rate
            time = real(t) * self.rate_unit
            turn = self.mean_rate * real(t)
            if by_period and self.regime != "separatrix":
                period, angle = self.period()
                cycles = mp.floor(time / period)
                time, turn = time - cycles * period, turn + cycles * angle
            elif self.regime == "separatrix" and abs(time) > SEPARATRIX_DIGITS * mp.ln10:
                raise ArithmeticError(f"on the separatrix {mp.nstr(time, 5)} rate units are too many")
            state = [self.tape.real(component) for component in self.state(time)]
            attitude = multiply(half_turn(self.gamma0, turn / 2), state[3:])
            rate = tuple(self.L * a * gamma for a, gamma in zip(self.inverse, state[:3], strict=True))
            return multiply(normalised(q0), attitude), rate

    def polhode_period(self):
        """Period of the body-frame momentum, s."""
        with mp.workprec(self.bits + 64):
            return self.period()[0] / self.rate_unit

    def turn_per_period(self):
        """Continuous angle about the momentum by which q(t + T) is turned from q(t), rad."""
        with mp.workprec(self.bits + 64):
            return self.period()[1] + self.mean_rate * self.polhode_period()

    def precession_period(self, axis=None):
        """Mean time in which a body axis goes once round the momentum, s; negative if against it.

        By default the axis of least moment: the long axis of an asteroid, in either mode. In a polhode
        period the axis circulated about goes a turn more, or less, than `turn_per_period`; the others that.
        """
        if axis is None:
            axis = self.moments.index(min(self.moments))
        with mp.workprec(self.bits + 64):
            further = 0
            if axis == self.polar_axis:
                # gamma goes round the axis of least moment positively, so the body spins about it negatively
                further = 1 if self.moments[axis] == max(self.moments) else -1
            return 2 * mp.pi * self.polhode_period() / (self.turn_per_period() + further * 2 * mp.pi)


def _character(moments, omega):
    """Regime, middle axis, axis circulated about with its sign, and decimal digits that the motion loses."""
    invariants = circulation(moments, omega)
    if invariants.regime == "constant_rate":
        return invariants.regime, 1, 2, 1, 0
    lost = decades(min(invariants.amplitude_squared[:2])) // 2 + 1
    if invariants.regime == "separatrix":
        lost += SEPARATRIX_DIGITS
    elif invariants.regime != "symmetric":
        lost += decades(invariants.m1)
    return invariants.regime, invariants.axes[1], invariants.axes[2], invariants.signs[2], lost
