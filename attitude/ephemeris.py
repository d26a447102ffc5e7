"""What an answer is: attitudes at instants, with everything needed to read them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from astropy.time import Time

from .errors import InputError, RegimeError
from .frames import rotations
from .rigid_body.body import RigidBody
from .samples.event import Event
from .samples.provenance import Plan
from .samples.translation import Translation
from .times.instants import Instants, as_instants

if TYPE_CHECKING:
    import pandas
    import xarray
    from astropy.table import QTable
    from scipy.spatial.transform import Rotation

    from .formats.interpolation_nodes import Written
    from .frames.inertial import Turn

CONVENTION = (
    "q rotates body to inertial: v_inertial = q * v_body * conj(q), Hamilton product, unit, "
    "continuous in time; angular velocity is that of the body relative to the inertial frame, "
    "components in the body frame"
)
TURNING_CONVENTION = (
    "q rotates body to {frame}, a frame that turns ({meaning}): v_frame = q * v_body * conj(q), Hamilton "
    "product, unit, continuous in time; angular velocity is that of the body relative to this frame, "
    "components in the body frame; position and velocity are relative to this frame, along its axes; "
    "angular momentum is relative to inertial space, along the axes of this frame"
)


def convention(frame: str) -> str:
    """What the numbers of an ephemeris in this frame mean, for files and people."""
    if not rotations.is_turning(frame):
        return CONVENTION
    return TURNING_CONVENTION.format(frame=frame, meaning=rotations.TURNING_FRAMES[frame])


class Along(Protocol):
    """The orbit that an ephemeris's scene has; nothing of it is computed before something is asked for."""

    @property
    def frame(self) -> str:
        """The inertial frame of its course."""

    @property
    def is_about_the_earth(self) -> bool: ...

    def state(self, instants: Instants) -> tuple[np.ndarray, np.ndarray]:
        """Position and velocity, (n, 3), m and m/s, from the central body along the axes of `frame`."""

    def axes(self, instants: Instants) -> Turn:
        """From `frame` to QSW, at (n,) instants."""


class Ephemeris:
    """Attitude and body rate of one body, or of many, at instants.

    Shape is batch + instants, as in `TorqueFreeMotion.at`; `len`, indexing and slicing go along
    the (first) dimension of the instants.  Nothing here changes: arrays that are asked for are the caller's
    own copies, but for `quaternion("wxyz")`, a read-only view (scipy's `Rotation.from_quat` takes it).

    Attributes
    ----------
    frame : str, that the attitudes are relative to: an inertial one, or what `in_frame` was asked for
    body : RigidBody or None (an ephemeris read from a file that holds no inertia)
    epoch : Time or None
    instants : Instants, two-part seconds since the epoch
    name : str
    plan : Plan or None (read from a file): solver, samples, time taken, bound on the error
    events : what happened at an instant: impulses, contacts, the end where a body comes to rest
    along : the orbit of its scene, or None
    """

    def __init__(
        self,
        quaternion: np.ndarray,
        instants: Instants,
        frame: str,
        body: RigidBody | None = None,
        rate: np.ndarray | Callable[[Instants], np.ndarray] | None = None,
        name: str = "",
        plan: Plan | None = None,
        translation: Translation | None = None,
        events: tuple[Event, ...] = (),
        momentum: np.ndarray | None = None,
        resample: Callable[[Any], Ephemeris] | None = None,
        along: Along | None = None,
    ):
        self._quaternion = quaternion
        self._rate = rate
        self.instants = instants
        self.frame = frame
        self.body = body
        self.name = name
        self.plan = plan
        self._translation = translation
        self.events = events
        self._momentum = momentum
        self._resample = resample
        self.along = along
        quaternion.flags.writeable = False

    @property
    def shape(self) -> tuple[int, ...]:
        """Batch dimensions, then those of the instants."""
        return self._quaternion.shape[:-1]

    @property
    def batch_shape(self) -> tuple[int, ...]:
        return self.shape[: len(self.shape) - len(self.instants.shape)]

    # -- time -------------------------------------------------------------------------------

    @property
    def epoch(self) -> Time | None:
        return self.instants.epoch

    @property
    def elapsed(self) -> np.ndarray:
        """(instants), s: SI seconds since the epoch, rounded to one double (`instants.rest` has the rest)."""
        return _own(self.instants.seconds)

    @property
    def time(self) -> Time:
        """The instants as a Time, built when first asked for.

        Raises InputError where no epoch was given.
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
        return rotations.in_order(self._quaternion, order)

    @property
    def rotation(self) -> Rotation:
        """scipy Rotation of the same shape: rotation.apply(v_body) is v along the axes of `frame`."""
        from scipy.spatial.transform import Rotation

        return Rotation.from_quat(self.quaternion("xyzw"))

    @property
    def has_rate(self) -> bool:
        """Whether there is a body rate to ask for (a file may hold attitudes only)."""
        return self._rate is not None

    @property
    def angular_velocity(self) -> np.ndarray:
        """(..., 3), rad/s, relative to `frame`, body components; computed when first asked for."""
        rate = self._rate  # read once: another thread may put the rates in place of the function
        if callable(rate):
            rate = self._rate = rate(self.instants)
        if rate is None:
            raise RegimeError(
                "angular_velocity: this ephemeris was read from a file that holds attitudes only"
            )
        return _own(rate)

    @property
    def angular_momentum(self) -> np.ndarray:
        """(..., 3), kg m2 rad/s, inertial components, from the sampled attitude and rate.

        With rotors, or a sink of energy, inside: of the whole, as the solver carries it.

        Raises RegimeError in a frame that turns, as the kinetic energy does.
        """
        self._refuse_turning("angular_momentum")
        if self._momentum is not None:
            return _own(self._momentum)
        return rotations.rotate(self._quaternion, self._body_momentum())

    @property
    def has_own_momentum(self) -> bool:
        """Whether rotors or a sink inside have a part in it, so that it does not follow from the rate."""
        return self._momentum is not None

    @property
    def kinetic_energy(self) -> np.ndarray:
        """(...), J, from the sampled rate."""
        self._refuse_turning("kinetic_energy")
        return 0.5 * (self.angular_velocity * self._body_momentum()).sum(axis=-1)

    @property
    def own_momentum(self) -> np.ndarray | None:
        """(..., 3), kg m2 rad/s, inertial, along the axes of `frame`; None unless it `has_own_momentum`."""
        return None if self._momentum is None else _own(self._momentum)

    @property
    def translation(self) -> Translation | None:
        """Position (..., 3), m, and velocity, m/s, of the centre of mass; None where it was not followed."""
        return self._translation and Translation(*map(_own, self._translation))

    def _refuse_turning(self, what: str) -> None:
        if rotations.is_turning(self.frame):
            raise RegimeError(f"{what}: {self.frame} turns; ask it of the ephemeris in an inertial frame")

    def _body_momentum(self) -> np.ndarray:
        if self.body is None:
            raise RegimeError("body: this ephemeris holds no inertia, so neither momentum nor energy")
        added = (1,) * len(self.instants.shape)
        tensor = self.body.tensor.reshape(*self.body.shape, *added, 3, 3)
        return (tensor @ self.angular_velocity[..., None])[..., 0]

    # -- elsewhere ----------------------------------------------------------------------------

    @property
    def can_be_resampled(self) -> bool:
        """Whether the motion is known, not only these samples of it."""
        return self._resample is not None

    def resampled(self, t: Any) -> Ephemeris:
        """The same motion at other instants.

        t : what `TorqueFreeMotion.at` takes; of a scene with effects, instants within its span

        Raises RegimeError where the motion is not known: of an ephemeris that was read from a file.
        """
        if self._resample is None:
            raise RegimeError("resampled: only these samples are known, not the motion they are of")
        found = self._resample(t if isinstance(t, Instants) else as_instants(t, self.epoch))
        found.along = self.along
        return found

    def in_frame(self, frame: str) -> Ephemeris:
        """The same motion relative to another frame.

        Parameters
        ----------
        frame : "ICRF", "GCRF", "EME2000", "ECLIPJ2000"; or one that turns: "TEME", "ITRF" and, of a scene
            with an orbit, "QSW" (x radial outward, z along the orbital momentum) and "LVLH" (z to the nadir,
            y against the orbital momentum)

        Returns
        -------
        Ephemeris : attitudes, rates and the centre of mass relative to that frame, with the turning of frames
            that turn; those are asked for neither momentum nor energy.  Signs remain continuous in time.  Of
            events only what does not depend on the axes is kept where they turn, and along an orbit no centre
            of mass.  It can be resampled where this one can.

        Raises
        ------
        InputError : an unknown frame, or INERTIAL, whose axes only its user knows; TEME or ITRF without an
            epoch, or ITRF beyond the tables of the Earth's rotation that come with astropy.
        RegimeError : axes along an orbit where there is none; from such axes to others.
        """
        from .samples.transform import in_frame

        return in_frame(self, frame)

    # -- parts --------------------------------------------------------------------------------

    def __len__(self) -> int:
        if not self.instants.shape:
            raise TypeError("an ephemeris of one instant has no length")
        return self.instants.shape[0]

    def __getitem__(self, key: Any) -> Ephemeris:
        """The same for some of the instants: an index, slice, mask or array along their dimensions."""
        if not self.instants.shape:
            raise TypeError("an ephemeris of one instant cannot be indexed")
        key = key if isinstance(key, tuple) else (key,)
        of_samples = (*(slice(None),) * len(self.batch_shape), *key, *_rest_of(key))
        rate = self._rate
        rate = rate if callable(rate) or rate is None else rate[of_samples]
        quaternion = self._quaternion[of_samples]
        plan = self.plan and replace(self.plan, samples=quaternion[..., 0].size)
        momentum = None if self._momentum is None else self._momentum[of_samples]
        translation = self._translation and self._translation.part(of_samples)
        return Ephemeris(
            quaternion,
            self.instants[key],
            self.frame,
            self.body,
            rate,
            self.name,
            plan,
            translation,
            self.events,
            momentum,
            self._resample,
            self.along,
        )

    def __repr__(self) -> str:
        epoch = f" from {self.epoch.isot} {self.epoch.scale}" if self.epoch is not None else ""
        return f"<Ephemeris: shape {self.shape}, body to {self.frame}{epoch}>"

    # -- leaving and coming back ----------------------------------------------------------------

    def to_table(self) -> QTable:
        """An astropy QTable, one row an instant.

        Columns time (with an epoch), elapsed [s], quaternion (w, x, y, z) and angular_velocity
        [rad/s]; angular_momentum [N m s] where rotors or a sink inside have a part in it, position [m] and
        velocity [m/s] where the centre of mass was followed.  A batch's dimensions follow the row.  meta
        names frame, order and convention, and has the events where there were any.
        """
        from .formats.tables.qtable import to_table

        return to_table(self)

    def to_xarray(self) -> xarray.Dataset:
        """An xarray Dataset, any shape; needs xarray (pip install 'attitude[tables]').

        Variables quaternion (body..., time, quaternion_component), angular_velocity [rad/s] (body..., time,
        axis) where the rate is known, angular_momentum [N m s], position [m] and velocity [m/s] as in
        `to_table`.  Coordinates elapsed [s], elapsed_rest [s] where a second part is needed, and time,
        datetime64[ns]: TAI, since a datetime64 cannot be at a leap second; there with an epoch, for dates
        that 64-bit nanoseconds hold (1678 to 2261).  Dimensions of a batch are body, body_1, ...; of instants
        time, or time_0, time_1, ...  attrs are the metadata, frame, order, convention and epoch; body and
        events as JSON, so that netCDF and Zarr hold them too.

        Raises FormatError where xarray is not installed.
        """
        from .formats.tables.xarray_pandas import to_xarray

        return to_xarray(self)

    def to_pandas(self) -> pandas.DataFrame:
        """A pandas DataFrame, one row an instant; needs pandas (pip install 'attitude[tables]').

        Columns with their units in the names, as in the files of this library: elapsed_s, q_w, q_x, ...,
        omega_x_rad_s, ...  The index is time_tai, to the nanosecond (TAI, since it has no leap seconds), or
        elapsed_s where `to_xarray` has no time.  attrs are the metadata.

        Raises InputError for more than one body at a list of instants, FormatError where pandas is not
        installed.
        """
        from .formats.tables.xarray_pandas import to_pandas

        return to_pandas(self)

    def write(
        self,
        path: str | Path,
        format: str | None = None,
        progress: Callable[[float], None] | None = None,
        interpolation_error: float | None = None,
        **options: Any,
    ) -> Written:
        """Write to a file, in the format of its ending or the one that is named.

        Parameters
        ----------
        path : the file appears whole or not at all
        format : one of `attitude.formats.FORMATS`; docs/formats.md has their conventions
        progress : called with the fraction done
        interpolation_error : rad, for formats whose readers interpolate: instants are chosen so that their
            own interpolation stays within it, instead of those of this ephemeris
        options : of the format (docs/formats.md)

        Returns
        -------
        Written : how many instants, and a bound on the error of interpolation between them

        Raises
        ------
        FormatError : an unknown format, one that cannot hold this ephemeris, or an unwritable path.
        InputError : an option the format has not, or a value it cannot take.
        """
        from . import formats

        return formats.write(self, path, format, progress, interpolation_error, **options)

    @classmethod
    def read(cls, path: str | Path, format: str | None = None, **options: Any) -> Ephemeris:
        """Read a file, in the format of its ending or the one that is named.

        From a file in a format of this library (docs/formats.md) the bits of quaternions, rates and times
        come back; from one in a format of other tools what it holds, in the conventions of this library.

        Raises FormatError, with file and line, for anything else.
        """
        from . import formats

        return formats.read(path, format, **options)


def _rest_of(key: tuple[Any, ...]) -> tuple[slice, ...]:
    """An ellipsis stands for dimensions of the instants, not for that of the components."""
    return (slice(None),) if any(part is Ellipsis for part in key) else ()


def _own(array: np.ndarray) -> np.ndarray:
    """The caller's own: SciPy refuses vectors that it must not write into (its issue 24751)."""
    return array.copy(order="K")
