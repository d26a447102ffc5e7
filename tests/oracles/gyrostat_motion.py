"""Attitude and rate of a gyrostat at any instant, by Taylor series and the period of its momentum.

No elliptic or theta function occurs.  The momentum in the body returns after a period T; the attitude is then
turned by a constant rotation about the inertial momentum, M = q(T) conj(q(0)), so that q(t + n T) = M^n q(t).
"""

from mpmath import mp, mpf

from attitude.oracle.exact import conjugate, elapsed, multiply, normalised, real
from attitude.oracle.torque_motion import TorqueMotion

STEPS_PER_UNIT = 8  # instants, in a time unit of the fastest rate, at which the momentum may have returned
MAX_INSTANTS = 4_000


class GyrostatMotion:
    """The motion of a body with rotors of constant momentum, and no torque.

    Parameters
    ----------
    inertia : 3 principal moments or a symmetric (3, 3) tensor; omega : 3, rad/s, body
    q0 : 4, wxyz; rotors : 3, N m s, body; all exact as given
    digits : of the integration.  A start at a distance of 10^-n from an equilibrium loses 2 n of them
    """

    def __init__(self, inertia, omega, q0, rotors, digits=45):
        self.digits = digits
        self.motion = TorqueMotion(inertia, omega, q0, [("wheels", rotors)], digits=digits)
        self._period = None

    def at(self, t):
        """(attitude, wxyz; body rate) at an elapsed time, s; beyond a period of either sign."""
        t = elapsed(t)
        with mp.workprec(self.motion.bits + 64):
            if abs(real(t)) * self.motion.rate_unit < 2:
                return self.motion.at([t])[0]
            period, turn = self.period()
            if not period:
                return self.motion.at([t])[0]
            turns = mp.floor(real(t) / period)
            q, rate = self.motion.at([real(t) - turns * period])[0]
            return multiply(_power(turn, int(turns)), q), rate

    def period(self):
        """(s, rotation about the inertial momentum after it); (0, 1) for a rate that is constant.

        Raises ArithmeticError where the momentum does not return, as on a separatrix.
        """
        if self._period is None:
            with mp.workprec(self.motion.bits + 64):
                self._period = self._found_period()
        return self._period

    def _found_period(self):
        start = self.motion.states([0])[0]
        change = _cross(start.momentum, start.rate)
        speed = mp.sqrt(sum(x * x for x in change))
        size = mp.sqrt(sum(x * x for x in start.momentum))
        if not speed:
            return mpf(0), (mpf(1), mpf(0), mpf(0), mpf(0))
        along = [x / speed for x in change]
        step = mpf(1) / STEPS_PER_UNIT
        near = 4 * step * max(speed, size * mpf(10) ** -self.digits) / self.motion.rate_unit
        before = mpf(0)
        for n, state in enumerate(self.motion._integrate((n * step for n in range(MAX_INSTANTS)), 1)):
            away = [a - b for a, b in zip(state.momentum, start.momentum, strict=True)]
            now = _dot(away, along)
            if n > 1 and before < 0 <= now and mp.sqrt(_dot(away, away)) < near:
                period = self._refined(
                    (n - now / (now - before)) * step / self.motion.rate_unit, start, along
                )
                if period:
                    end = self.motion.states([period])[0]
                    return period, multiply(normalised(end.attitude), conjugate(normalised(start.attitude)))
            before = now
        raise ArithmeticError(f"the momentum does not return within {MAX_INSTANTS * step} units of time")

    def _refined(self, period, start, along):
        """Newton's method for the return; None where the momentum only passes nearby."""
        for _ in range(12):
            state = self.motion.states([period])[0]
            away = [a - b for a, b in zip(state.momentum, start.momentum, strict=True)]
            change = _dot(away, along) / _dot(_cross(state.momentum, state.rate), along)
            period -= change
            if abs(change) < period * mpf(10) ** (4 - self.digits):
                break
        close = mp.sqrt(_dot(away, away)) < mp.sqrt(_dot(start.momentum, start.momentum)) * mpf(10) ** (
            8 - self.digits
        )
        return period if close else None


def _power(q, n):
    """q^n of a unit quaternion."""
    if n < 0:
        return _power(conjugate(q), -n)
    power = (mpf(1), mpf(0), mpf(0), mpf(0))
    while n:
        if n & 1:
            power = multiply(power, q)
        q, n = multiply(q, q), n >> 1
    return power


def _dot(u, v):
    return sum(a * b for a, b in zip(u, v, strict=True))


def _cross(u, v):
    return (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
