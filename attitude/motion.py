"""Torque-free motion in closed form: attitudes, body rates and constants of one body or many."""

from __future__ import annotations

from collections.abc import Iterator
from copy import copy
from functools import partial
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np
from astropy.time import Time

from . import units
from .ephemeris import Ephemeris
from .errors import InputError, RegimeError, noted, whole_number
from .frames import rotations
from .kernels.layout import INVARIANTS, REGIMES, Regime
from .pointing.targets import angle_between, unit_vectors
from .rigid_body.body import RigidBody
from .rigid_body.constants_of_motion import Batch, check_rates
from .rigid_body.paper_constants import PaperConstants
from .rigid_body.partials import Partials
from .runtime.threads import check
from .samples.html_table import html_table
from .samples.provenance import Plan
from .times import instants
from .times.instants import as_instants

if TYPE_CHECKING:
    from .windows.bounded_functions import BoundedMotion
    from .windows.tumble_average import MeanAreas
    from .windows.window_table import Windows


class TorqueFreeMotion:
    """The exact motion of a rigid body, or of many, under no torque.

    Parameters
    ----------
    body : RigidBody, batch shape (...)
    attitude : scipy Rotation, or array_like (..., 4) with `order`
        Attitude at the epoch: the active rotation from body to inertial.
    angular_velocity : array_like or Quantity, (..., 3), rad/s
        At the epoch, of the body relative to the inertial frame, components in the body frame.
    epoch : astropy Time, datetime or ISO 8601 text (UTC), optional
        Required only where instants are passed or returned as Time.
    order : "wxyz" or "xyzw"
        Order of the four numbers of a bare array; no default.
    frame : str
        Name of the inertial frame, which travels with the data.

    Leading dimensions of the first three broadcast to the batch shape.

    Raises
    ------
    InputError : an invalid value; names the field.

    Notes
    -----
    v_inertial = q(t) v_body conj(q(t)), dq/dt = q omega/2, I domega/dt = (I omega) x omega.
    The closed form in two theta functions, docs/theory.md; set-up decides the regime once, every
    sample then runs the same path.  Accuracy: 4e-15 rad for abs(omega t) up to 1e12 rad in every
    regime (tests/test_against_truth.py).
    """

    def __init__(
        self,
        body: RigidBody,
        attitude: Any,
        angular_velocity: Any,
        epoch: Time | None = None,
        order: str | None = None,
        frame: str = "ICRF",
    ):
        if not isinstance(body, RigidBody):
            raise InputError("body", body, "a RigidBody")
        self.body = body
        self.epoch = instants.check_epoch(epoch)
        self.frame = rotations.check_frame(frame, also=(rotations.TEME_AT_EPOCH,))
        with noted() as notes:
            attitudes = rotations.attitude_quaternion(attitude, order)
        self.notes = tuple(notes)
        rates = check_rates(units.si_array(angular_velocity, units.RATE, "angular_velocity"))
        shapes = body.shape, attitudes.shape[:-1], rates.shape[:-1]
        try:
            self.shape = np.broadcast_shapes(*shapes)
        except ValueError:
            received = "bodies {}, attitudes {}, angular velocities {}".format(*shapes)
            expected = "leading dimensions that broadcast together"
            raise InputError("angular_velocity", received, expected) from None
        self._batch = Batch(body, attitudes, rates, self.shape)

    # -- the motion in time ---------------------------------------------------------------

    def at(self, t: Any, threads: int = 1, out: np.ndarray | None = None) -> Ephemeris:
        """Attitude at instants t; the body rate is computed when it is first accessed.

        Parameters
        ----------
        t : float array (s since the epoch), Quantity, TimeDelta; or, with an epoch, Time, datetime or ISO
            8601 text in the epoch's time scale.  Any shape, either sign, any order.  Or a `Grid`.
        threads : int
            Share the samples among so many threads; the bits do not depend on it.
        out : float64 array (batch..., t..., 4), optional
            The attitudes are written there, wxyz, and the ephemeris is a view of it: valid until `out` is
            written again.  Without a copy where each component is stored in one piece, as in
            ``np.moveaxis(np.empty((4, *shape)), 0, -1)``.

        Returns
        -------
        Ephemeris of shape batch + t.shape.

        Raises
        ------
        InputError : t is not one of these, not finite, or a Time where there is no epoch; or `out` has
            another shape or type.
        ToleranceError : t is so far off that two-part phases would not give 4e-15 rad.
        """
        check(threads)
        return self.ephemeris(as_instants(t, self.epoch, threads=threads), threads=threads, out=out)

    def ephemeris(
        self,
        instants: instants.Instants,
        rate: bool = False,
        name: str = "",
        threads: int = 1,
        out: np.ndarray | None = None,
    ) -> Ephemeris:
        """`at`, for instants already in two-part seconds; with `rate`, both in one pass."""
        begun = perf_counter()
        quaternion, computed = self._batch.sample(instants, True, rate, threads, out)
        solver, bound = self._batch.solution
        samples = self._batch.size * instants.seconds.size
        seconds = perf_counter() - begun
        plan = Plan(solver, samples, self._batch.seconds, seconds, bound, notes=self.notes)
        source = computed if rate else partial(self._rates, threads=threads)
        again = partial(self.ephemeris, rate=True, name=name, threads=threads)
        return Ephemeris(
            quaternion,
            instants,
            self.frame,
            self.body,
            source,
            name,
            plan,
            resample=again,
            sensitivity=partial(self._batch.partials, threads=threads),
        )

    def crossings(self, condition: Any, start: Any, stop: Any, width: float | None = None) -> Windows:
        """The intervals between two instants in which a condition holds, found on the exact motion.

        Parameters
        ----------
        condition : of `attitude.windows`, such as `angle("z", to="sun") < 10 * u.deg`, or a document
        start, stop : as `at` takes them
        width : s; windows, and gaps between them, that are narrower may be missed, wider ones never; by
            default 1e-6 of a turn at the greatest rate of the body

        Returns
        -------
        Windows, whose ends are off by less than 1e-9 s of this motion's crossings.

        Raises
        ------
        InputError : an invalid value; several bodies, of which `motion[i]` is one; no dates for the Sun.
        RegimeError : a condition that needs an orbit, which a scene may have; one whose value stays at its
            threshold.
        """
        from .windows.condition import parse_condition
        from .windows.window_table import find_windows, span_of

        parsed = parse_condition(condition)
        return find_windows(self.bounded(*span_of(start, stop, self.epoch)), parsed, width)

    def mean_areas(self, normals: Any, areas: Any, direction: Any) -> MeanAreas:
        """Areas of plates averaged over the tumble, projected on a direction and facing it.

        Parameters
        ----------
        normals : (k, 3), outward, along the body axes; areas : (k,), m2
        direction : (..., 3), along the axes of `frame`, of the flow or of the light's source

        Returns
        -------
        MeanAreas, (...) m2 each: over the polhode and all angles of precession, to 1e-12 of the whole area.
        No plate shades another.

        Raises
        ------
        InputError : an invalid value; several bodies, of which `motion[i]` is one.
        RegimeError : on the separatrix, whose polhode has no period; at rest.
        ToleranceError : so close to the separatrix that the mean does not converge.
        """
        from .windows.tumble_average import MeanAreas, mean_of_plate

        if self.shape:
            raise InputError("motion", f"{self.shape} bodies", "one body, such as motion[0]")
        vectors = units.finite_array(normals, "normals")
        sizes = units.si_array(areas, units.AREA, "areas")
        if vectors.ndim != 2 or vectors.shape[1] != 3 or sizes.shape != vectors.shape[:1]:
            raise InputError(
                "areas", f"shape {sizes.shape}", "an area for each normal, normals of shape (k, 3)"
            )
        towards = units.finite_array(direction, "direction")
        if towards.shape[-1:] != (3,) or not (towards != 0.0).any(axis=-1).all():
            raise InputError("direction", direction, "vectors of shape (..., 3), not zero")
        period = 1.0 if self.regime == "constant_rate" else float(self.polhode_period)
        if not np.isfinite(period):
            raise RegimeError("mean_areas: a polhode on the separatrix has no period to average over")
        motion = self.bounded(0.0, period)
        momentum = unit_vectors(self.angular_momentum, "the angular momentum")
        angles = angle_between(unit_vectors(towards, "direction"), momentum)
        plates = unit_vectors(vectors, "a normal")
        means = np.zeros((2, angles.size))
        for k, angle in enumerate(angles.reshape(-1)):
            parts = [mean_of_plate(motion, normal, float(angle)) for normal in plates]
            means[:, k] = sizes @ np.array(parts)
        return MeanAreas(*means.reshape(2, *angles.shape))

    def bounded(self, start: float, stop: float) -> BoundedMotion:
        """The motion of one body from start to stop, s since the epoch, with the bound on its rate."""
        from .problem.spin_bound import greatest_free_rate
        from .windows.bounded_functions import BoundedMotion

        if self.shape:
            raise InputError("motion", f"{self.shape} bodies", "one body, such as motion[0]")
        rate = greatest_free_rate(np.asarray(self.body.moments), self.body.axes @ self._batch.rates)
        return BoundedMotion(self.epoch, start, stop, self.ephemeris, lambda data: np.full(data.shape, rate))

    def chunks(
        self,
        times: Any,
        size: int,
        rate: bool = False,
        threads: int = 1,
        name: str = "",
        out: np.ndarray | None = None,
    ) -> Iterator[Ephemeris]:
        """Ephemerides of at most `size` instants each, one after the other, in the memory of one.

        Parameters
        ----------
        times : what `at` takes, one-dimensional; or a `Grid`, whose instants are made chunk by chunk
        size : instants in a chunk; the last chunk may have fewer
        rate : whether the body rate is computed in the same pass
        threads, name : as in `at` and of the ephemerides
        out : float64 array (batch..., size, 4), optional
            The attitudes of every chunk are written there, as in `at`: a chunk is valid until the next.

        Raises
        ------
        InputError : size is not a whole number of at least 1, or times has not one dimension; and
            what `at` raises, when the chunk in question is reached.
        """
        size = whole_number(size, "size")
        part, count = instants.lazy_instants(times, self.epoch)
        chunks = (part(first, min(first + size, count)) for first in range(0, count, size))
        return (
            self.ephemeris(
                chunk, rate, name, threads, None if out is None else out[..., : chunk.seconds.size, :]
            )
            for chunk in chunks
        )

    def partials(self, t: Any, inertia: str = "moments", threads: int = 1) -> Partials:
        """Partial derivatives of attitude and body rate by initial state and inertia, at instants t.

        Parameters
        ----------
        t : what `at` takes
        inertia : "moments": three principal moments and three angles of their axes; "tensor": six elements
        threads : as in `at`

        Returns
        -------
        Partials : of shape batch + t.shape, rad, rad/s and kg m2; its docstring has rows and columns

        Raises
        ------
        InputError, ToleranceError : as `at`, and for another `inertia`.
        RegimeError : derivatives beyond the range of a double, on the separatrix and beside it.

        Notes
        -----
        Closed form (docs/partial-derivatives.md).
        """
        check(threads)
        return self._batch.partials(as_instants(t, self.epoch, threads=threads), inertia, threads)

    def _rates(self, instants: instants.Instants, threads: int) -> Any:
        return self._batch.sample(instants, quaternion=False, rate=True, threads=threads)[1]

    # -- constants of the motion ----------------------------------------------------------

    @property
    def regime(self) -> Any:
        """Which motion this is; a str, or an array of them for a batch.

        "short_axis" (the momentum circles the axis of greatest moment), "long_axis" (of the least),
        "separatrix" (neither, ever) or "constant_rate" (the body rate stays as it is).
        """
        names = np.array(REGIMES)[self._batch.fields("regime")["regime"]]
        return str(names) if names.ndim == 0 else names

    @property
    def angular_momentum(self) -> np.ndarray:
        """(..., 3), kg m2 rad/s, inertial components; constant."""
        with np.errstate(over="ignore", invalid="ignore"):
            momentum = np.einsum("...ij,...j->...i", self.body.tensor, self._batch.rates)
            return _representable(rotations.rotate(self._batch.attitudes, momentum), "angular_momentum")

    @property
    def kinetic_energy(self) -> np.ndarray:
        """(...), J; constant."""
        rates = self._batch.rates
        with np.errstate(over="ignore", invalid="ignore"):
            twice = np.einsum("...i,...ij,...j->...", rates, self.body.tensor, rates)[()]
        return 0.5 * _representable(twice, "kinetic_energy")

    @property
    def polhode_period(self) -> np.ndarray:
        """(...), s: time after which the body rate returns, 4K/u' (theory, eq. 13).

        Infinite on the separatrix and for a constant rate.
        """
        bodies = self._batch.fields("u_rate", "K")
        moving = (bodies["u_rate"] > 0.0) & np.isfinite(bodies["K"])
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            period = 4.0 * bodies["K"] / bodies["u_rate"]
        return np.where(moving, period, np.inf)[()]

    @property
    def mean_precession_rate(self) -> np.ndarray:
        """(...), rad/s: mean rate at which the long axis (least moment) turns about the momentum.

        The period of precession quoted for tumbling asteroids and debris is 2 pi over this.
        For a constant rate, that rate.  Theory, eqs. (28) and (29).
        """
        twice, circling, is_long_axis = self._mean_rates()
        return np.where(is_long_axis, twice - circling, twice)[()]

    @property
    def spin_axis_precession_rate(self) -> np.ndarray:
        """(...), rad/s: mean rate at which axis 3, which the momentum circles, turns about the momentum.

        For a symmetric body spinning about its axis of symmetry this is the textbook's L / I_transverse.
        """
        twice, circling, is_long_axis = self._mean_rates()
        return np.where(is_long_axis, twice - circling, twice + circling)[()]

    def _mean_rates(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """2 lambda, and v' (half the polhode's angular rate times two), rad/s; whether by the long axis."""
        bodies, turn = self._batch.fields("precession", "regime"), 2.0 * np.pi
        twice = 2.0 * turn * (bodies["precession"][..., 0] + bodies["precession"][..., 1])
        return twice, turn / self.polhode_period, bodies["regime"] == Regime.LONG_AXIS

    @property
    def nutation_range(self) -> np.ndarray:
        """(..., 2), rad: least and greatest angle between the momentum and axis 3, which it circles.

        Axis 3 is the axis of greatest moment in the short-axis regime and on the separatrix, of
        the least in the long-axis regime, on the side where the momentum is.  Zero for a constant rate.
        """
        bodies = self._batch.fields("amplitude", "complementary_modulus")
        A1, A2, A3 = np.moveaxis(bodies["amplitude"], -1, 0)
        least = np.arctan2(A1, A3)
        greatest = np.arctan2(A2, A3 * bodies["complementary_modulus"])
        return np.stack([least, greatest], axis=-1)

    @property
    def constants(self) -> PaperConstants:
        """m, K, K', q, omega_p, epsilon, eta, A1, A2 and psi(t) as van Zon and Schofield define them."""
        if (self._batch.fields("regime")["regime"] == Regime.CONSTANT_RATE).any():
            raise RegimeError(
                "constants: this motion has a constant body rate, for which the paper defines none"
            )
        return PaperConstants.from_invariants(self._batch.fields(*(INVARIANTS.names or ())))

    def __getitem__(self, key: Any) -> TorqueFreeMotion:
        """The motion of bodies of a batch, by index or slice of the batch dimensions."""
        part = copy(self)
        part._batch = self._batch[key]
        part.body, part.shape = part._batch.body, part._batch.shape
        return part

    def _repr_html_(self) -> str:
        """A table, for notebooks."""
        rows: dict[str, Any] = {"frame": self.frame, "epoch": self.epoch}
        if self.shape:
            return html_table("Torque-free motion", {"bodies": self.shape} | rows)
        least, greatest = np.rad2deg(self.nutation_range)
        rows |= {
            "regime": str(self.regime).replace("_", " "),
            "polhode period, s": float(self.polhode_period),
            "angular momentum, N m s": float(np.sqrt((self.angular_momentum**2).sum())),
            "kinetic energy, J": float(self.kinetic_energy),
            "nutation, deg": f"{least:.6g} to {greatest:.6g}",
        }
        return html_table("Torque-free motion", rows)

    def __repr__(self) -> str:
        if self.shape:
            return f"<TorqueFreeMotion: {self.shape} bodies in {self.frame}>"
        return f"<TorqueFreeMotion: {self.regime}, polhode period {self.polhode_period:.9g} s, {self.frame}>"


def _representable(value: np.ndarray, name: str) -> np.ndarray:
    if not np.isfinite(value).all():
        raise RegimeError(f"{name}: beyond the range of a double for this body; its attitude is not")
    return value
