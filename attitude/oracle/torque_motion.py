"""Attitude and rate of a rigid body under torques, by Taylor series to any number of digits.

All vectors are body components. With m the whole momentum, h that of the rotors, W the body's rate,

    w = I^-1 (m - h),    W = w + alpha m x w,    m' = m x W + torque,    q' = q W / 2,

and inertial vectors rotate the other way: an inertial torque T' = T x W, position and velocity on the orbit

    r' = r x W + v,    v' = v x W - mu r / |r|^3        (circular: mu / a^3 r, which is linear),

the axis d of the central body's dipole, turning at an inertial rate E, d' = d x W + E x d, E' = E x W. So the
attitude enters no torque; it is read off beside them, and q r conj(q) must still be the orbit's position.
Torques:

    constant body T, constant inertial T, eddy damping -C w,
    gravity gradient 3 mu / |r|^5  r x I r,
    magnetic dipole x B, with B = k (3 (d.r) r / |r|^5 - d / |r|^3).

It shares nothing with the library's solvers: no splitting, no free rotation, Kepler's equation only at t = 0.
"""

from collections import defaultdict
from math import ceil, log
from typing import NamedTuple

from mpmath import mp, mpf

from .exact import (
    conjugate,
    elapsed,
    fraction,
    half_turn,
    multiply,
    norm,
    normalised,
    real,
    reals,
    rotate,
    symmetric,
)
from .series import Tape, cross_rows, product_rows

# Working digits beyond the promised ones, for the errors of steps as they grow over 1e5 rad.
GUARD_DIGITS = 12
MAX_STEPS = 2_000_000


class KeplerianOrbit(NamedTuple):
    """A Keplerian orbit about a central body: m3/s2, m, and rad; the anomaly is the mean one at t = 0."""

    mu: float
    semi_major_axis: float
    eccentricity: float = 0
    inclination: float = 0
    node: float = 0
    pericentre: float = 0
    mean_anomaly: float = 0

    def start(self):
        """Position over a, and velocity over a times the mean motion, inertial, at t = 0."""
        e, E = self.eccentricity, _eccentric_anomaly(self.mean_anomaly, self.eccentricity)
        across = mp.sqrt(1 - e * e)
        position = (mp.cos(E) - e, across * mp.sin(E), mpf(0))
        slowness = 1 - e * mp.cos(E)
        velocity = (-mp.sin(E) / slowness, across * mp.cos(E) / slowness, mpf(0))
        x, z = (mpf(1), mpf(0), mpf(0)), (mpf(0), mpf(0), mpf(1))
        turn = half_turn(z, self.node / 2)
        turn = multiply(turn, half_turn(x, self.inclination / 2))
        turn = multiply(turn, half_turn(z, self.pericentre / 2))
        return rotate(turn, position), rotate(turn, velocity)


class State(NamedTuple):
    """State of a body; all numbers are mpf.

    Attributes
    ----------
    attitude : 4, wxyz, body to inertial, continuous in t; not normalised: its norm shows errors
    rate : 3, rad/s, body: w = I^-1 (m - h); under dissipation it differs from the rate W of the attitude
    momentum : 3, N m s, body: m, with that of the rotors
    position : 3, m, inertial: on the orbit, rotated from the body frame; None without an orbit
    """

    attitude: tuple
    rate: tuple
    momentum: tuple
    position: tuple | None


class TorqueMotion:
    """The motion of one body from t = 0.

    Parameters
    ----------
    inertia : 3 principal moments along x, y, z, or a symmetric (3, 3) tensor, kg m2
    omega : 3, rad/s, body: w at t = 0
    q0 : 4, wxyz, body to inertial; normalised at the working precision
    torques : tuples, each a name and its numbers, any of them any number of times:
        ("constant_body", T), ("constant_inertial", T): N m
        ("gravity_gradient", mu): m3/s2 of the central body
        ("eddy", C): (3, 3), N m s
        ("dissipation", alpha): 1/(N m s)
        ("wheels", h): N m s, body
        ("magnetic", dipole, k, d, E): A m2, body; T m3; unit vector at t = 0 and rad/s, both inertial
    orbit : KeplerianOrbit, which gravity gradient and magnetic dipole need
    digits : correct ones of q, in motion that is not chaotic and over no more than some 1e5 rad

    Numbers are taken as the exact binary fractions (or Fractions, or mpf) they are.

    Raises
    ------
    ValueError : an unknown torque, or one that needs an orbit where there is none.
    """

    def __init__(self, inertia, omega, q0, torques=(), orbit=None, digits=30):
        self.digits = digits
        self.bits = ceil((digits + GUARD_DIGITS) * log(10, 2))
        self.order = ceil(self.bits * log(2) / 2)  # least work: order^2 / exp(-bits log 2 / order)
        self.torques = defaultdict(list)  # numbers by the name of the torque
        for name, *numbers in torques:
            if name not in TORQUES:
                raise ValueError(f"torque {name!r} is not one of {', '.join(sorted(TORQUES))}")
            if orbit is None and name in ("gravity_gradient", "magnetic"):
                raise ValueError(f"{name} needs an orbit")
            self.torques[name].append(numbers)
        with mp.workprec(self.bits + 64):
            self.orbit = None if orbit is None else KeplerianOrbit(*reals(orbit))
            rotors = [reals(h) for (h,) in self.torques["wheels"]]
            self.wheels = [sum(components, mpf(0)) for components in zip((mpf(0),) * 3, *rotors, strict=True)]
            diagonal = not hasattr(inertia[0], "__len__")
            rows = (
                [[inertia[i] if i == j else 0 for j in range(3)] for i in range(3)] if diagonal else inertia
            )
            self._set_units([[real(entry) for entry in row] for row in symmetric(rows)], reals(omega))
            self.q0 = normalised(q0)
            self._record_equations(reals(omega))

    def at(self, times):
        """(attitude, rate) at each of some elapsed times, s: numbers, or tuples (hi, lo); in any order."""
        return [(state.attitude, state.rate) for state in self.states(times)]

    def states(self, times):
        """The `State` at each of some times; integration runs from 0 outward, in both directions."""
        states = {}
        with mp.workprec(self.bits + 64):
            exact = [real(elapsed(t)) * self.rate_unit for t in times]
            for direction in (1, -1):
                ahead = sorted({t for t in exact if t * direction >= 0}, key=abs)
                states.update(zip(ahead, self._integrate(ahead, direction), strict=True))
            return [states[t] for t in exact]

    # Units: the greatest entry of the tensor, and the fastest of the rates

    def _set_units(self, tensor, omega):
        self.moment_unit = max(abs(component) for row in tensor for component in row)
        rates = [norm(omega), norm(self.wheels) / self.moment_unit]
        if self.orbit:
            rates.append(mp.sqrt(self.orbit.mu / self.orbit.semi_major_axis**3))
        constant = self.torques["constant_body"] + self.torques["constant_inertial"]
        rates += [mp.sqrt(norm(reals(torque)) / self.moment_unit) for (torque,) in constant]
        self.rate_unit = max(rates) or mpf(1)
        self.momentum_unit = self.moment_unit * self.rate_unit
        self.torque_unit = self.momentum_unit * self.rate_unit
        self.tensor = [[entry / self.moment_unit for entry in row] for row in tensor]
        self.inverse = mp.inverse(mp.matrix(self.tensor)).tolist()

    # Equations

    def _record_equations(self, omega):
        tape = self.tape = Tape(self.bits, self.order)
        rotors = [component / self.momentum_unit for component in self.wheels]
        own = _times(self.tensor, [component / self.rate_unit for component in omega])
        momentum = [a + b for a, b in zip(own, rotors, strict=True)]
        self.q = [tape.state(component) for component in self.q0]
        self.m = [tape.state(component) for component in momentum]
        offset = [-component for component in _times(self.inverse, rotors)]
        self.w = self._linear(self.inverse, self.m, offset)
        self.W = self.w
        alpha = sum((real(fraction(number)) for (number,) in self.torques["dissipation"]), mpf(0))
        if alpha:
            terms = zip(self.w, tape.bilinear(self.w, cross_rows(self.m)), strict=True)
            self.W = [tape.combination([(mpf(1), w), (alpha * self.momentum_unit, x)]) for w, x in terms]
        self.rotating = [self.m]
        self._record_orbit()
        for name in self.torques:
            for numbers in self.torques[name]:
                if name not in ("dissipation", "wheels"):
                    self._change(self.m, getattr(self, name)(*numbers))
        # q' = q W / 2, and u' = u x W of the momentum and of all inertial vectors, in one product
        rows = product_rows([tape.combination([(mpf("0.5"), component)]) for component in self.q])
        rows += [row for vector in self.rotating for row in cross_rows(vector)]
        states = [*self.q, *(component for vector in self.rotating for component in vector)]
        self._change(states, tape.bilinear(self.W, rows))

    def _record_orbit(self):
        """Record position (unit: semi-major axis), and |r|^-5 and |r|^-3, which are None on a circle."""
        if self.orbit is None:
            self.r = None
            return
        tape, gravity = self.tape, self._per_second2(self.orbit.mu)
        position, velocity = self.orbit.start()
        self.r = self._inertial(position)
        v = self._inertial([component * mp.sqrt(gravity) for component in velocity])
        self.inverse5 = self.inverse3 = None
        pull = self.r
        if self.orbit.eccentricity:
            (square,) = tape.bilinear(self.r, [self.r])
            self.inverse3, self.inverse5 = tape.power(square, -3), tape.power(square, -5)
            pull = self._scaled(self.inverse3, self.r)
        self._change(self.r, v)
        self._change(v, [tape.combination([(-gravity, component)]) for component in pull])

    # Torques, in units of `torque_unit`

    def constant_body(self, torque):
        """T, along body axes."""
        return [self.tape.combination([], T / self.torque_unit) for T in reals(torque)]

    def constant_inertial(self, torque):
        """T, along inertial axes."""
        return self._inertial([T / self.torque_unit for T in reals(torque)])

    def eddy(self, damping):
        """-C w."""
        rows = [[-c * self.rate_unit / self.torque_unit for c in reals(row)] for row in damping]
        return self._linear(rows, self.w)

    def gravity_gradient(self, mu):
        """3 mu / |r|^5  r x I r."""
        factor = 3 * self._per_second2(real(fraction(mu)))
        rows = [[factor * entry for entry in row] for row in self.tensor]
        return self._scaled(self.inverse5, self.tape.bilinear(self._linear(rows, self.r), cross_rows(self.r)))

    def magnetic(self, dipole, k, axis, rotation):
        """Dipole x B, B of the central body's dipole."""
        tape, d = self.tape, self._inertial(reals(axis))
        rotation = reals(rotation)
        if any(rotation):
            E = self._inertial([component / self.rate_unit for component in rotation])
            self._change(d, tape.bilinear(d, cross_rows(E)))
        (along,) = tape.bilinear(d, [self.r])
        first = self._scaled(self.inverse5, self._scaled(along, self.r))
        second = self._scaled(self.inverse3, d)
        field = [tape.combination([(mpf(3), a), (mpf(-1), b)]) for a, b in zip(first, second, strict=True)]
        factor = real(fraction(k)) / self.orbit.semi_major_axis**3 / self.torque_unit
        x, y, z = (factor * component for component in reals(dipole))
        return self._linear([[0, -z, y], [z, 0, -x], [-y, x, 0]], field)

    # Vectors

    def _per_second2(self, mu):
        """mu / a^3, in units of `rate_unit` squared."""
        return mu / self.orbit.semi_major_axis**3 / self.rate_unit**2

    def _inertial(self, vector):
        """Body components of an inertial vector, u' = u x W; its own motion is added by `_change`."""
        seen = [self.tape.state(u) for u in rotate(conjugate(self.q0), vector)]
        self.rotating.append(seen)
        return seen

    def _change(self, states, terms):
        for state, term in zip(states, terms, strict=True):
            self.tape.rate(state, term)

    def _linear(self, rows, vector, offset=(0, 0, 0)):
        columns = [list(zip(row, vector, strict=True)) for row in rows]
        return [self.tape.combination(terms, u) for terms, u in zip(columns, offset, strict=True)]

    def _scaled(self, factor, vector):
        """factor times vector, where there is a factor."""
        if factor is None:
            return vector
        return self.tape.bilinear([factor], [[component] for component in vector])

    # Steps

    def _integrate(self, times, direction):
        """States at times in units of 1 / rate_unit, ascending in absolute value, of one direction."""
        tape, start, scale, values = self.tape, mpf(0), mpf(direction), list(self.tape.start)
        pending, steps = iter(times), 0
        t = next(pending, None)
        while t is not None:
            steps += 1
            if steps > MAX_STEPS:
                raise ArithmeticError(f"{MAX_STEPS} Taylor steps do not reach the time asked for")
            _, scale = tape.expand(values, scale)
            length = tape.step_length()
            while t is not None and abs(t - start) <= abs(scale) * length:
                yield self._state(tape.evaluate((t - start) / scale))
                t = next(pending, None)
            values = tape.evaluate(length)
            start, scale = start + scale * length, 1.5 * scale * length

    def _state(self, values):
        values = [self.tape.real(value) for value in values]
        q, m = tuple(values[:4]), values[4:7]
        own = [a - b / self.momentum_unit for a, b in zip(m, self.wheels, strict=True)]
        momentum = tuple(component * self.momentum_unit for component in m)
        rate = tuple(component * self.rate_unit for component in _times(self.inverse, own))
        position = None
        if self.orbit:
            position = rotate(q, [component * self.orbit.semi_major_axis for component in values[7:10]])
        return State(q, rate, momentum, position)


TORQUES = frozenset(
    ("constant_body", "constant_inertial", "gravity_gradient", "eddy", "dissipation", "wheels", "magnetic")
)


def _eccentric_anomaly(M, e):
    """E - e sin E = M, by Newton's method from pi or M, whichever converges from one side."""
    M = M - 2 * mp.pi * mp.nint(M / (2 * mp.pi))
    E = mp.pi * mp.sign(M) if e > mpf("0.5") else M
    for _ in range(200):
        step = (E - e * mp.sin(E) - M) / (1 - e * mp.cos(E))
        E -= step
        if abs(step) <= mp.eps * 4:
            return E
    raise ArithmeticError(f"Kepler's equation: no root for e = {mp.nstr(e, 6)}, M = {mp.nstr(M, 6)}")


def _times(rows, vector):
    return [sum(a * b for a, b in zip(row, vector, strict=True)) for row in rows]
