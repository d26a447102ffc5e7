"""Peers on scenes with gravity gradient: how long they take, and how far off they end.

    python tests/benchmarks/torque_peers.py                  tables of the problems, about four minutes
    python tests/benchmarks/torque_peers.py "1 deg/s"        one of them
    python tests/benchmarks/torque_peers.py truth "1 deg/s"  its truth anew, by the oracle: half a minute
                                                             (an hour for 60 deg/s)

A cylinder, or a triaxial body, on a circular orbit turns for so many revolutions; asked for is its last
attitude. Answers of a peer at a ladder of tolerances are set against the truth, so that times compare at
equal measured error.
Preparation (deriving, compiling) is not timed. Peers get what suits them: constants compiled in, terms that
are zero dropped, and time in a unit that makes the rate of order one, because their tolerances are absolute.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from time import thread_time
from typing import Any, NamedTuple

import numpy as np
from astropy.constants import GM_earth, R_earth
from scipy.integrate import solve_ivp

sys.path.insert(0, str(Path(__file__).parents[2]))

from attitude.cost.machine import processor, versions

Attitude = tuple[float, float, float, float]


@dataclass(frozen=True)
class Problem:
    """A body on a circular orbit in the plane z = 0, which starts at x towards y.

    Attributes
    ----------
    moments : kg m2; omega : rad/s, body; attitude : wxyz, body to inertial; both at t = 0
    mu : m3/s2; radius : m
    seconds : s, when the attitude is asked for
    """

    name: str
    moments: tuple[float, float, float]
    omega: tuple[float, float, float]
    attitude: Attitude
    mu: float
    radius: float
    seconds: float

    @property
    def mean_motion(self) -> float:
        """rad/s."""
        return math.sqrt(self.mu / self.radius**3)

    @property
    def unit(self) -> float:
        """rad/s: a power of two that makes the rate of order one, so that times keep their bits."""
        return 2.0 ** math.frexp(math.hypot(*self.omega))[1]

    def inertial(self, relative: np.ndarray) -> Attitude:
        """Attitude at the end from that relative to the orbit's frame, which turns about z; normalised."""
        half = 0.5 * self.mean_motion * self.seconds
        c, s = math.cos(half), math.sin(half)
        w, x, y, z = (relative / np.linalg.norm(relative)).tolist()
        return c * w - s * z, c * x - s * y, c * y + s * x, c * z + s * w


CYLINDER, TRIAXIAL = (12250.0, 12250.0, 500.0), (6000.0, 9000.0, 12000.0)


def turning(name: str, moments: tuple[float, float, float], degrees: float, revolutions: float) -> Problem:
    rate = math.radians(degrees)
    return Problem(
        name,
        moments=moments,
        omega=(rate * 0.6, rate * 0.5, rate * 0.62449979983984),
        attitude=(1.0, 0.0, 0.0, 0.0),
        mu=GM_earth.value,
        radius=R_earth.value + 600e3,
        seconds=revolutions * 2 * math.pi / rate,
    )


PROBLEMS = {
    problem.name: problem
    for problem in (
        turning("1 deg/s", CYLINDER, 1.0, 1000.0),
        turning("60 deg/s", CYLINDER, 60.0, 100_000.0),
        turning("triaxial", TRIAXIAL, 1.0, 1000.0),
    )
}
# Two integrations of different equations by different programs: `truth`, and heyoka in quadruple precision
# (fp_type=real128, orbital frame) agree to 25 digits at 1 deg/s, and to 1e-15 or better at 60 deg/s.
TRUTH: dict[str, Attitude] = {
    "1 deg/s": (
        0.6681735330838284019881275,
        -0.1998672024517786045337911,
        -0.1311973843135615094379854,
        -0.7045455822156955806826308,
    ),
    "60 deg/s": (
        -0.9286203449532904602820568,
        -0.2858189806689998555813707,
        -0.2365623224283135088130826,
        0.003167465151877614537744254,
    ),
    "triaxial": (
        -0.7166744357688573,
        0.6948311271814726,
        -0.051505317627067136,
        -0.030572210768103392,
    ),
}


class Answer(NamedTuple):
    """The last attitude, wxyz, and the seconds of each repeat."""

    attitude: Attitude
    runs: tuple[float, ...]

    @property
    def seconds(self) -> float:
        return min(self.runs)


class Point(NamedTuple):
    """One rung: what was asked, least seconds, angle to the truth, rad."""

    tolerance: float
    seconds: float
    error: float


Peer = Callable[[Problem, float, int], Answer]


def repeated(solve: Callable[[], Attitude], repeats: int) -> Answer:
    """Processor time of this thread: with a processor for each thread it is that by the clock."""
    runs = []
    for _ in range(repeats):
        start = thread_time()
        attitude = solve()
        runs.append(thread_time() - start)
    return Answer(attitude, tuple(runs))


# -- heyoka -----------------------------------------------------------------------------------------


def heyoka_inertial(problem: Problem, tolerance: float, repeats: int = 3, **options: Any) -> Answer:
    """Attitude relative to the inertial frame, the orbit's phase a function of time, as on any orbit."""
    return _heyoka(problem, tolerance, repeats, False, options)


def heyoka_orbital(problem: Problem, tolerance: float, repeats: int = 3, **options: Any) -> Answer:
    """Attitude relative to the orbit's frame: cheaper by sine and cosine, and for circular orbits only."""
    return _heyoka(problem, tolerance, repeats, True, options)


def _heyoka(problem: Problem, tolerance: float, repeats: int, orbital: bool, options: Any) -> Answer:
    import heyoka

    start = [*problem.attitude, *(component / problem.unit for component in problem.omega)]
    equations = _heyoka_equations(problem, orbital)
    integrator = heyoka.taylor_adaptive(equations, start, tol=tolerance, **options)

    def solve() -> Attitude:
        integrator.time = 0.0
        integrator.state[:] = start
        outcome = integrator.propagate_until(problem.seconds * problem.unit)[0]
        if outcome.name != "time_limit":  # heyoka's name for having come to the end
            raise ArithmeticError(f"heyoka: {outcome.name} at {integrator.time:.6g}")
        q = integrator.state[:4].copy()
        return problem.inertial(q) if orbital else tuple((q / np.linalg.norm(q)).tolist())

    return repeated(solve, repeats)


def _heyoka_equations(problem: Problem, orbital: bool) -> list[tuple[Any, Any]]:
    """In time times `problem.unit`."""
    import heyoka

    q0, q1, q2, q3, x, y, z = heyoka.make_vars("q0", "q1", "q2", "q3", "x", "y", "z")
    n = problem.mean_motion / problem.unit
    # conj(q) r q, first for r = (1, 0, 0), then for (0, 1, 0)
    r = [1 - 2 * (q2 * q2 + q3 * q3), 2 * (q1 * q2 - q0 * q3), 2 * (q1 * q3 + q0 * q2)]
    frame = [0.5 * n * q3, 0.5 * n * q2, -0.5 * n * q1, -0.5 * n * q0]
    if not orbital:
        c, s = heyoka.cos(n * heyoka.time), heyoka.sin(n * heyoka.time)
        across = [2 * (q1 * q2 + q0 * q3), 1 - 2 * (q1 * q1 + q3 * q3), 2 * (q2 * q3 - q0 * q1)]
        r = [c * a + s * b for a, b in zip(r, across, strict=True)]
        frame = [0.0] * 4
    I1, I2, I3 = problem.moments
    k = [(I2 - I3) / I1, (I3 - I1) / I2, (I1 - I2) / I3]
    pull = 3 * n * n
    return [
        (q0, -0.5 * (q1 * x + q2 * y + q3 * z) + frame[0]),
        (q1, 0.5 * (q0 * x + q2 * z - q3 * y) + frame[1]),
        (q2, 0.5 * (q0 * y + q3 * x - q1 * z) + frame[2]),
        (q3, 0.5 * (q0 * z + q1 * y - q2 * x) + frame[3]),
        (x, k[0] * (y * z) - pull * k[0] * (r[1] * r[2])),
        (y, k[1] * (z * x) - pull * k[1] * (r[2] * r[0])),
        (z, k[2] * (x * y) - pull * k[2] * (r[0] * r[1])),
    ]


# -- DOP853 -----------------------------------------------------------------------------------------


def dop853(problem: Problem, tolerance: float, repeats: int = 1) -> Answer:
    """SciPy's `solve_ivp`, relative to the orbit's frame, its right-hand side compiled by numba."""
    I1, I2, I3 = problem.moments
    k = np.array([(I2 - I3) / I1, (I3 - I1) / I2, (I1 - I2) / I3])
    start = np.array([*problem.attitude, *(component / problem.unit for component in problem.omega)])
    n, end, derivative = problem.mean_motion / problem.unit, problem.seconds * problem.unit, _derivative()
    derivative(0.0, start, k, n)

    def solve() -> Attitude:
        found = solve_ivp(
            derivative, (0.0, end), start, "DOP853", [end], args=(k, n), rtol=tolerance, atol=tolerance
        )
        if not found.success:
            raise ArithmeticError(found.message)
        return problem.inertial(found.y[:4, -1])

    return repeated(solve, repeats)


def _derivative() -> Callable[..., np.ndarray]:
    from numba import njit

    return njit(error_model="numpy")(orbital_derivative)


def orbital_derivative(t, y, k, n):
    """y' of y = (q relative to the orbit's frame, w), with k = (I2 - I3) / I1 and cyclic, orbital rate n."""
    q0, q1, q2, q3, w1, w2, w3 = y
    r1 = 1 - 2 * (q2 * q2 + q3 * q3)
    r2 = 2 * (q1 * q2 - q0 * q3)
    r3 = 2 * (q1 * q3 + q0 * q2)
    pull = 3 * n * n
    return np.array(
        [
            0.5 * (n * q3 - q1 * w1 - q2 * w2 - q3 * w3),
            0.5 * (n * q2 + q0 * w1 + q2 * w3 - q3 * w2),
            0.5 * (-n * q1 + q0 * w2 + q3 * w1 - q1 * w3),
            0.5 * (-n * q0 + q0 * w3 + q1 * w2 - q2 * w1),
            k[0] * (w2 * w3 - pull * r2 * r3),
            k[1] * (w3 * w1 - pull * r3 * r1),
            k[2] * (w1 * w2 - pull * r1 * r2),
        ]
    )


# -- ladders ----------------------------------------------------------------------------------------

PEERS: dict[str, tuple[Peer, tuple[float, ...], int]] = {
    "heyoka, orbital frame": (
        heyoka_orbital,
        (1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13, 1e-14, 1e-15, 2.0**-52),
        15,
    ),
    "heyoka, inertial frame": (heyoka_inertial, (1e-8, 1e-10, 1e-12, 1e-13, 1e-14, 1e-15, 2.0**-52), 15),
    "DOP853": (dop853, (1e-6, 1e-8, 1e-10, 1e-11, 1e-12, 1e-13, 2.3e-14), 1),
}
LONG = 1e5  # rad, from where on DOP853 takes minutes and heyoka is run once


def error(attitude: Attitude, truth: Attitude) -> float:
    """2 asin |vec(conj(truth) attitude)|, rad."""
    (a, b, c, d), (w, x, y, z) = truth, attitude
    v = a * x - b * w - c * z + d * y, a * y - c * w - d * x + b * z, a * z - d * w - b * y + c * x
    return 2 * math.asin(min(1.0, math.hypot(*v)))


def ladder(peer: Peer, problem: Problem, tolerances: tuple[float, ...], repeats: int) -> list[Point]:
    """A peer's answers from loose to tight, against the truth."""
    points = []
    for tolerance in tolerances:
        answer = peer(problem, tolerance, repeats)
        off = error(answer.attitude, TRUTH[problem.name])
        points.append(Point(tolerance, answer.seconds, off))
    return points


def seconds_at(points: list[Point], wanted: float) -> float:
    """Seconds in which a peer comes within so many rad, between rungs by the logarithms of both.

    Rungs that others beat in time and error are left out. Infinite if no rung comes so near; that of the
    quickest rung if all do.
    """
    front: list[Point] = []
    for point in sorted(points, key=lambda point: (point.seconds, point.error)):
        if not front or point.error < front[-1].error:
            front.append(point)
    if front[-1].error > wanted:
        return math.inf
    log_error, log_seconds = np.log([[point.error, point.seconds] for point in reversed(front)]).T
    return float(np.exp(np.interp(np.log(wanted), log_error, log_seconds)))


def table(problem: Problem) -> None:
    radians = math.hypot(*problem.omega) * problem.seconds
    print(
        f"\n{problem.name}: {radians:.0f} rad, {problem.seconds:.0f} s, orbit {problem.radius / 1e3:.1f} km"
    )
    for name, (peer, tolerances, repeats) in PEERS.items():
        if radians > LONG and peer is dop853:
            continue
        points = ladder(peer, problem, tolerances, 1 if radians > LONG else repeats)
        for point in points:
            print(
                f"{name:<24} tol {point.tolerance:7.1e} {point.seconds * 1e3:10.2f} ms   "
                f"{point.error:.2e} rad",
                flush=True,
            )
        wanted = (1e-6, 1e-8, 1e-9, 1e-10, 1e-11)
        print(f"{name:<24}", *(f"{w:.0e}: {seconds_at(points, w) * 1e3:.4g} ms" for w in wanted))


def truth(problem: Problem) -> None:
    """The last attitude by the oracle at two precisions, as it stands in TRUTH."""
    from attitude.oracle import truth as measure
    from attitude.oracle.torque_motion import KeplerianOrbit, TorqueMotion

    torques, orbit = [("gravity_gradient", problem.mu)], KeplerianOrbit(problem.mu, problem.radius)
    (rough,), (fine,) = (
        TorqueMotion(problem.moments, problem.omega, problem.attitude, torques, orbit, d).at(
            [problem.seconds]
        )
        for d in (14, 20)
    )
    assert measure.component_error(rough[0], fine[0]) < 1e-16
    print(problem.name, *(f"{float(component)!r}," for component in fine[0]), sep="\n")


def main(arguments: list[str]) -> None:
    action = table
    if arguments and arguments[0] == "truth":
        action, arguments = truth, arguments[1:]
    print(f"{processor()}, {', '.join(' '.join(pair) for pair in versions().items())}")
    for name in arguments or PROBLEMS:
        action(PROBLEMS[name])


if __name__ == "__main__":
    main(sys.argv[1:])
