"""Motions under torques, and where they end: what solvers are held against.

Inputs are the exact binary numbers they are; expected values are decimal strings, good to the last of their
digits, by `attitude.oracle.torque_motion`, in tests/tables/torque_states.json: rows of case, s, quaternion
wxyz and rate, rad/s. Printed anew, once two precisions of it agree, by

    python -m tests.oracles.torque_cases
"""

import json
from typing import Any, NamedTuple

from mpmath import mp

from attitude.oracle import truth
from attitude.oracle.torque_motion import KeplerianOrbit, TorqueMotion
from tests.tables import table

MU = 3.986004e14  # m3/s2, nominal Earth
FIELD = 7.8e15  # T m3, the Earth's dipole: 3.0e-5 T at its equator
ATTITUDE = (0.1, -0.7, 0.5, 0.5)
DIGITS = 24


class Case(NamedTuple):
    """What `TorqueMotion` takes, and the times, s, of the expected states."""

    inertia: tuple[Any, ...]
    omega: tuple[float, ...]
    attitude: tuple[float, ...]
    torques: tuple[tuple[Any, ...], ...]
    orbit: KeplerianOrbit | None
    times: tuple[float, ...]

    def oracle(self, digits: int) -> TorqueMotion:
        return TorqueMotion(self.inertia, self.omega, self.attitude, self.torques, self.orbit, digits)


class State(NamedTuple):
    """Seconds, quaternion wxyz body to inertial, rate w = I^-1 (m - h), rad/s, body components."""

    seconds: float
    attitude: tuple[str, ...]
    rate: tuple[str, ...]


# Axes in no special order, a tensor of three unequal moments (about 10, 14, 17), orbits in general position.
TRIAXIAL = (1750.0, 1200.0, 2300.0)
CYLINDER = (12250.0, 12250.0, 500.0)
TENSOR = ((10.0, 0.5, -0.3), (0.5, 14.0, 0.25), (-0.3, 0.25, 17.0))
ECCENTRIC = KeplerianOrbit(MU, 8.2e6, 0.125, 0.9, 0.4, 1.1, 0.3)
CIRCULAR = KeplerianOrbit(MU, 6978100.0, 0, 0.9, 0.4, 0, 0.3)
EQUATOR = KeplerianOrbit(MU, 6978100.0)
DAMPING = ((0.05, 0.01, 0.005), (0.01, 0.04, 0.002), (0.005, 0.002, 0.03))
# tilted by 0.1 against z, about which it turns once a day
DIPOLE = ("magnetic", (10.0, 3.0, -4.0), FIELD, (0.0995, 0.01, -0.995), (0.0, 0.0, 7.292115e-5))
GRAVITY = ("gravity_gradient", MU)

CASES = {
    "gravity gradient, eccentric orbit": Case(
        TRIAXIAL, (0.006, -0.009, 0.012), ATTITUDE, (GRAVITY,), ECCENTRIC, (-600.0, 1500.0, 6000.0)
    ),
    "gravity gradient, tensor, eccentric orbit": Case(
        TENSOR, (0.002, -0.003, 0.002), ATTITUDE, (GRAVITY,), ECCENTRIC, (1500.0, 6000.0)
    ),
    "capture of a cylinder": Case(
        CYLINDER, (5e-4, -11e-4, 3e-4), ATTITUDE, (GRAVITY,), CIRCULAR, (-2000.0, 6000.0, 20000.0)
    ),
    "cylinder at 1 deg/s": Case(
        CYLINDER,
        (0.01047197551196598, 0.00872664625997165, 0.010899577685766625),
        (1.0, 0.0, 0.0, 0.0),
        (GRAVITY,),
        EQUATOR,
        (360.0, 7200.0),
    ),
    "constant torque of the body": Case(
        TENSOR,
        (0.3, -0.5, 0.4),
        ATTITUDE,
        (("constant_body", (0.02, -0.01, 0.015)),),
        None,
        (-20.0, 30.0, 90.0),
    ),
    "constant inertial torque": Case(
        TENSOR,
        (0.3, -0.5, 0.4),
        ATTITUDE,
        (("constant_inertial", (0.02, -0.01, 0.015)),),
        None,
        (-20.0, 90.0),
    ),
    "gyrostat": Case(
        TENSOR, (0.3, -0.5, 0.4), ATTITUDE, (("wheels", (1.5, -2.5, 3.5)),), None, (-20.0, 30.0, 90.0)
    ),
    "gyrostat from rest, principal axes": Case(
        TRIAXIAL, (0.0, 1e-3, 0.0), ATTITUDE, (("wheels", (20.0, -5.0, 10.0)),), None, (500.0, 5000.0)
    ),
    "eddy damping": Case(
        TENSOR, (0.3, -0.5, 0.4), ATTITUDE, (("eddy", DAMPING),), None, (-20.0, 30.0, 300.0)
    ),
    "dissipation": Case(
        TRIAXIAL, (0.03, 0.4, -0.02), ATTITUDE, (("dissipation", 2e-5),), None, (-20.0, 30.0, 150.0)
    ),
    "magnetic dipole": Case(
        TENSOR, (0.01, -0.015, 0.012), ATTITUDE, (DIPOLE,), ECCENTRIC, (-500.0, 1000.0, 4000.0)
    ),
    "all together": Case(
        TENSOR,
        (0.01, -0.015, 0.012),
        ATTITUDE,
        (
            ("constant_body", (1e-4, 2e-4, -1e-4)),
            ("constant_inertial", (1e-4, -2e-4, 1e-4)),
            GRAVITY,
            ("eddy", DAMPING),
            ("dissipation", 0.01),
            ("wheels", (0.1, -0.2, 0.3)),
            DIPOLE,
        ),
        ECCENTRIC,
        (-30.0, 500.0, 2000.0),
    ),
}


def expected(case: Case) -> list[State]:
    """By the oracle, after its answers at two precisions have been found equal."""
    states = case.oracle(DIGITS + 2).at(case.times)
    for (q, rate), (finer, finer_rate) in zip(states, case.oracle(DIGITS + 14).at(case.times), strict=True):
        assert truth.component_error(q, finer) < 10.0**-DIGITS / 2
        assert truth.rate_error(rate, finer_rate) < 10.0**-DIGITS / 2
    return [State(t, _text(q), _text(rate)) for t, (q, rate) in zip(case.times, states, strict=True)]


def _text(vector: tuple[Any, ...]) -> tuple[str, ...]:
    """Decimals down to 1e-24 of the vector's length."""
    with mp.workdps(60):
        last = DIGITS - int(mp.floor(mp.log10(mp.norm(vector)))) - 1
        scaled = [int(mp.nint(component * mp.mpf(10) ** last)) for component in vector]
        return tuple(_decimal(digits, last) for digits in scaled)


def _decimal(digits: int, last: int) -> str:
    text = f"{abs(digits):0{last + 1}d}"
    return f"{'-' if digits < 0 else ''}{text[:-last]}.{text[-last:]}"


def main() -> None:
    rows = [[name, *state] for name, case in CASES.items() for state in expected(case)]
    print("[\n" + ",\n".join(map(json.dumps, rows)) + "\n]")


EXPECTED = {
    name: tuple(State(t, tuple(q), tuple(rate)) for row, t, q, rate in table("torque_states") if row == name)
    for name in CASES
}

if __name__ == "__main__":
    main()
