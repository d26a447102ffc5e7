"""The data of an ephemeris: attitudes of one or many bodies at given instants, with metadata."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from functools import cached_property
from types import EllipsisType
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, Self

import numpy as np
from astropy.time import Time

from ..errors import InputError, RegimeError
from ..frames import rotations
from ..rigid_body.body import RigidBody
from ..rigid_body.partials import Partials
from ..times.instants import Instants, as_instants
from .event import Event
from .interpolation import Interpolation, InterpolationMethod
from .provenance import Plan
from .translation import Translation
from .uncertainty import Uncertainty, ellipse

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

    from ..frames.inertial import FrameRotation

CONVENTION = (
    "q rotates body to inertial: v_inertial = q * v_body * conj(q), Hamilton product, unit, "
    "continuous in time; angular velocity is that of the body relative to the inertial frame, "
    "components in the body frame"
)


def convention(frame: str, ut1: str = "tables") -> str:
    """The conventions of an ephemeris in this frame, as files state them."""
    if frame not in rotations.TURNING_FRAMES:
        return CONVENTION
    text = (
        f"q rotates body to {frame}, a frame that turns ({rotations.TURNING_FRAMES[frame]}): "
        "v_frame = q * v_body * conj(q), Hamilton product, unit, continuous in time; angular velocity is "
        "that of the body relative to this frame, components in the body frame; position and velocity are "
        "relative to this frame, along its axes; angular momentum is relative to inertial space, along the "
        "axes of this frame"
    )
    return f"{text}; UTC is taken for UT1" if (frame, ut1) == ("ITRF", "utc") else text


class OrbitLimits(NamedTuple):
    """Bounds on a motion along an orbit over a span.

    Attributes
    ----------
    speed : m/s; acceleration : m/s2; distance : m, from below
    moment : m2/s2, of the acceleration about the central body: 0 where the orbit is Keplerian
    """

    speed: float
    acceleration: float
    distance: float
    moment: float


class OrbitStates(Protocol):
    """The orbit of an ephemeris's scene, evaluated on demand."""

    @property
    def frame(self) -> str:
        """The inertial frame of its path."""

    @property
    def is_about_the_earth(self) -> bool:
        """Whether the central body is the Earth."""

    @property
    def central_radius(self) -> float | None:
        """Radius of the central body, m; None where it is not known."""

    def limits(self, start: float, stop: float) -> OrbitLimits:
        """Bounds over a span, s since the epoch."""

    def state(self, instants: Instants) -> tuple[np.ndarray, np.ndarray]:
        """Position and velocity, (n, 3), m and m/s, from the central body along the axes of `frame`."""

    def axes(self, instants: Instants) -> FrameRotation:
        """Rotations from `frame` to QSW, at (n,) instants."""


@dataclass(frozen=True, eq=False, repr=False)
class EphemerisData:
    """Attitude and body rate of one body, or of many, at instants.

    Shape is batch + instants, as in `TorqueFreeMotion.at`; `len`, indexing and slicing go along
    the (first) dimension of the instants.  The data are immutable: properties return writeable copies of the
    arrays (SciPy refuses read-only vectors, its issue 24751), and `quaternion("wxyz")` a read-only view.

    Attributes
    ----------
    attitude : (..., 4) unit quaternions wxyz, body to `frame`; `quaternion(order)` returns them
    instants : Instants, two-part seconds since the epoch
    frame : str, that the attitudes are relative to
    body : RigidBody or None (an ephemeris read from a file that holds no inertia)
    rate : (..., 3) rad/s, body components; or the function of the instants that computes it; or None
    name : str
    plan : Plan or None: solver (or the file it was read from), samples, time taken, bound on the error
    centre_of_mass : Translation or None; `translation` returns copies
    events : impulses, contacts, the end where a body comes to rest ...
    momentum : (..., 3) N m s, along the axes of `frame`, where it does not follow from the rate; or None
    resample : attitudes as a function of instants: of the motion itself, or interpolated; or None
    orbit : the orbit of its scene, or None
    interpolation : how `resample` interpolates between attitudes of a file; None where the motion is known
    columns : what tables of it hold (`Ephemeris.with_columns`), where this was chosen
    ut1 : "tables", or "utc" where UTC is taken for UT1 in ITRF
    sensitivity : partial derivatives as a function of instants and inertia ("moments", "tensor"); or None
    uncertainty : of the initial state and the inertia, or None
    """

    attitude: np.ndarray
    instants: Instants
    frame: str
    body: RigidBody | None = None
    rate: np.ndarray | Callable[[Instants], np.ndarray] | None = None
    name: str = ""
    plan: Plan | None = None
    centre_of_mass: Translation | None = None
    events: tuple[Event, ...] = ()
    momentum: np.ndarray | None = None
    resample: Callable[[Any], EphemerisData] | None = None
    orbit: OrbitStates | None = None
    interpolation: Interpolation | None = None
    columns: tuple[str, ...] = ()
    ut1: str = "tables"
    sensitivity: Callable[[Instants, str], Partials] | None = None
    uncertainty: Uncertainty | None = None

    def __post_init__(self) -> None:
        self.attitude.flags.writeable = False

    @cached_property
    def shape(self) -> tuple[int, ...]:
        """Batch dimensions, then those of the instants."""
        return self.attitude.shape[:-1]

    @cached_property
    def batch_shape(self) -> tuple[int, ...]:
        """Batch dimensions."""
        return self.shape[: len(self.shape) - len(self.instants.shape)]

    @property
    def notes(self) -> tuple[str, ...]:
        """How input was taken that is not as it should be: those of `plan`."""
        return () if self.plan is None else self.plan.notes

    # -- time -------------------------------------------------------------------------------

    @property
    def epoch(self) -> Time | None:
        """The instant that elapsed seconds count from; None without one."""
        return self.instants.epoch

    @property
    def elapsed(self) -> np.ndarray:
        """(instants), s: SI seconds since the epoch, rounded to one double (see `Instants.seconds_low`)."""
        return self.instants.seconds.copy(order="K")

    @property
    def time(self) -> Time:
        """The instants as a Time, built on first use.

        Raises InputError without an epoch.
        """
        time = self.instants.time
        if time is None:
            raise InputError(
                "epoch", None, "a Time, for instants to be dated; this ephemeris has elapsed seconds"
            )
        return time

    # -- attitude and rate --------------------------------------------------------------------

    def quaternion(self, order: str) -> np.ndarray:
        """(..., 4) unit quaternions, body to `frame`, in the named order: "wxyz" or "xyzw"."""
        return rotations.in_order(self.attitude, order)

    @property
    def rotation(self) -> Rotation:
        """scipy Rotation of the same shape: rotation.apply(v_body) is v along the axes of `frame`."""
        from scipy.spatial.transform import Rotation

        return Rotation.from_quat(self.quaternion("xyzw"))

    @property
    def has_rate(self) -> bool:
        """Whether there is a body rate (a file may hold attitudes only)."""
        return self.rate is not None

    @property
    def angular_velocity(self) -> np.ndarray:
        """(..., 3), rad/s, relative to `frame`, body components; computed on first use."""
        return self.computed_rate.copy(order="K")

    @cached_property
    def computed_rate(self) -> np.ndarray:
        """`angular_velocity` without a copy, not to be written to."""
        rate = self.rate(self.instants) if callable(self.rate) else self.rate
        if rate is None:
            raise RegimeError(
                "angular_velocity: this ephemeris was read from a file that holds attitudes only"
            )
        return rate

    @property
    def angular_momentum(self) -> np.ndarray:
        """(..., 3), kg m2 rad/s, inertial components, from the sampled attitude and rate.

        With rotors or a dissipative slug inside: that of the whole, as the solver integrates it.

        Raises RegimeError in a rotating frame.
        """
        self._refuse_rotating("angular_momentum")
        if self.momentum is not None:
            return self.momentum.copy(order="K")
        return rotations.rotate(self.attitude, self._body_momentum())

    @property
    def has_own_momentum(self) -> bool:
        """Whether the momentum includes rotors or a slug inside, so that it does not follow from the rate."""
        return self.momentum is not None

    @property
    def own_momentum(self) -> np.ndarray | None:
        """(..., 3), kg m2 rad/s, inertial, along the axes of `frame`; None unless it `has_own_momentum`."""
        return None if self.momentum is None else self.momentum.copy(order="K")

    @property
    def kinetic_energy(self) -> np.ndarray:
        """(...), J, from the sampled rate; RegimeError in a rotating frame."""
        self._refuse_rotating("kinetic_energy")
        return 0.5 * (self.angular_velocity * self._body_momentum()).sum(axis=-1)

    @property
    def translation(self) -> Translation | None:
        """Position (..., 3), m, and velocity, m/s, of the centre of mass; None where it was not computed."""
        return self.centre_of_mass and Translation(*(part.copy(order="K") for part in self.centre_of_mass))

    def _refuse_rotating(self, quantity: str) -> None:
        if self.frame in rotations.TURNING_FRAMES:
            raise RegimeError(f"{quantity}: {self.frame} is a rotating frame; use an inertial frame")

    def _body_momentum(self) -> np.ndarray:
        if self.body is None:
            raise RegimeError("body: this ephemeris holds no inertia, so neither momentum nor energy")
        tensor = self.body.tensor.reshape(*self.body.shape, *(1,) * len(self.instants.shape), 3, 3)
        return (tensor @ self.angular_velocity[..., None])[..., 0]

    def partials(self, inertia: str = "moments") -> Partials:
        """Partial derivatives of attitude and body rate, at the instants, by initial state and inertia.

        inertia : as of `TorqueFreeMotion.partials`

        Raises RegimeError where the motion is not known (read from a file), and in a rotating frame.
        """
        self._refuse_rotating("partials")
        if self.sensitivity is None:
            raise RegimeError("partials: the motion of this ephemeris is not known, only its attitudes are")
        return self.sensitivity(self.instants, inertia)

    # -- uncertainty --------------------------------------------------------------------------

    @cached_property
    def covariance(self) -> np.ndarray:
        """(..., 6, 6): covariance of the small rotation, rad, and the body rate, rad/s, along the body axes.

        To first order in the uncertainty of the initial state and inertia: `uncertainty` says how far that
        holds.  The attitude's small rotation theta is that of `partials`: q_true = q exp(theta/2).

        Raises RegimeError without an uncertainty, and as `partials`.
        """
        if self.uncertainty is None:
            raise RegimeError("uncertainty: none is given for this ephemeris (docs/uncertainty.md)")
        return self.partials().covariance(self.uncertainty.covariance)

    @property
    def attitude_covariance(self) -> np.ndarray:
        """(..., 3, 3), rad2: of the small rotation about the body axes."""
        return self.covariance[..., :3, :3]

    @property
    def rate_covariance(self) -> np.ndarray:
        """(..., 3, 3), rad2/s2: of the body rate, body axes."""
        return self.covariance[..., 3:, 3:]

    def direction_sigma(self, body_axis: np.ndarray) -> np.ndarray:
        """(...,), rad: 1 sigma of the direction of a body axis (3,), along the major axis of its ellipse."""
        return ellipse(self.attitude_covariance, body_axis)[0][..., 0]

    # -- resampling ---------------------------------------------------------------------------

    @property
    def stated_method(self) -> InterpolationMethod | None:
        """How the file that it was read from is to be interpolated at its first instant, if it was read."""
        if self.interpolation is None:
            return None
        return self.interpolation.method_at(float(self.elapsed[0]))

    @property
    def can_be_resampled(self) -> bool:
        """Whether attitudes at other instants are available: of the motion, or interpolated (of a file)."""
        return self.resample is not None

    @property
    def has_known_motion(self) -> bool:
        """Whether the motion can be evaluated at other instants; not of an ephemeris read from a file."""
        return self.resample is not None and self.interpolation is None

    @property
    def is_simulated(self) -> bool:
        """Whether effects are simulated: then any instants cost a run from the beginning of the scene."""
        return self.plan is not None and bool(self.plan.simulated)

    def resampled(self, t: Any) -> Self:
        """The same motion at other instants.

        An ephemeris that was read from a file is interpolated as the file states, by slerp where it states
        nothing, within its segments and never across: `plan` says how, and that no error bound is known.

        t : as for `TorqueFreeMotion.at`; of a scene with effects, instants within its span

        Raises RegimeError for instants outside a file's segments, and for a file in no order of time.
        """
        if self.resample is None:
            raise RegimeError(
                "resampled: the instants of this ephemeris do not increase, so nothing lies between them"
            )
        motion = self.resample(t if isinstance(t, Instants) else as_instants(t, self.epoch))
        parts = {field.name: getattr(motion, field.name) for field in fields(motion)}
        kept = ("orbit", "ut1", "sensitivity", "uncertainty", "columns")
        return replace(self, **(parts | {name: getattr(self, name) for name in kept}))

    # -- indexing -----------------------------------------------------------------------------

    def __len__(self) -> int:
        if not self.instants.shape:
            raise TypeError("an ephemeris of one instant has no length")
        return self.instants.shape[0]

    def __getitem__(self, key: Any) -> Self:
        """The ephemeris at some of the instants: an index, slice, mask or array along their dimensions."""
        if not self.instants.shape:
            raise TypeError("an ephemeris of one instant cannot be indexed")
        key = key if isinstance(key, tuple) else (key,)
        # an ellipsis stands for dimensions of the instants, not for that of the components
        last = (slice(None),) if EllipsisType in map(type, key) else ()
        samples = (*(slice(None),) * len(self.batch_shape), *key, *last)
        attitude = self.attitude[samples]
        return replace(
            self,
            attitude=attitude,
            instants=self.instants[key],
            rate=self.rate[samples] if isinstance(self.rate, np.ndarray) else self.rate,
            plan=self.plan and replace(self.plan, samples=attitude[..., 0].size),
            centre_of_mass=self.centre_of_mass and self.centre_of_mass.part(samples),
            momentum=None if self.momentum is None else self.momentum[samples],
        )

    def __repr__(self) -> str:
        epoch = f" from {self.epoch.isot} {self.epoch.scale}" if self.epoch is not None else ""
        return f"<Ephemeris: shape {self.shape}, body to {self.frame}{epoch}>"
