"""Ephemeris: attitudes at instants as users hold them, read from files and written to them."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from dataclasses import fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from . import units
from .frames import rotations
from .samples.ephemeris_data import EphemerisData, OrbitStates

if TYPE_CHECKING:
    import pandas
    import xarray
    from astropy.coordinates import SkyCoord
    from astropy.table import QTable
    from matplotlib.animation import FuncAnimation
    from matplotlib.figure import Figure

    from .formats.interpolation_nodes import Written
    from .pointing.spin_state import SpinState
    from .pointing.surface_points import GroundPoints


class Ephemeris(EphemerisData):  # noqa: D101 (of EphemerisData)
    __doc__ = EphemerisData.__doc__

    @classmethod
    def of(cls, data: EphemerisData) -> Ephemeris:
        """The same data, with methods for other frames, formats and tables."""
        return cls(**{field.name: getattr(data, field.name) for field in fields(data)})

    @property
    def along(self) -> OrbitStates | None:
        """Deprecated name of `orbit`."""
        warnings.warn("Ephemeris.along is called orbit", DeprecationWarning, stacklevel=2)
        return self.orbit

    def in_frame(self, frame: str, ut1: str | None = None) -> Ephemeris:
        """The same motion relative to another frame.

        Parameters
        ----------
        frame : "ICRF", "GCRF", "EME2000", "ECLIPJ2000"; or one that turns: "TEME", "ITRF" and, of a scene
            with an orbit, "QSW" (x radial outward, z along the orbital momentum) and "LVLH" (z to the nadir,
            y against the orbital momentum)
        ut1 : for ITRF, "tables" (those that come with astropy) or "utc", to take UTC for UT1 (within 0.9 s)
            beyond them; by default that of the ephemeris

        Returns
        -------
        Ephemeris : attitudes, rates and the centre of mass relative to that frame, with the turning of frames
            that turn; those are asked for neither momentum nor energy.  Signs remain continuous in time.  Of
            events only what does not depend on the axes is kept where they turn, and along an orbit no centre
            of mass.  It can be resampled where this one can.

        Raises
        ------
        InputError : an unknown frame, or INERTIAL, whose axes only its user knows; TEME or ITRF without an
            epoch, or ITRF beyond the tables of the Earth's rotation that come with astropy without ut1="utc".
        RegimeError : axes along an orbit where there is none; from such axes to others.
        """
        from .samples.transform import in_frame

        return in_frame(self, frame, ut1)

    # -- pointing ---------------------------------------------------------------------------------

    def euler(self, sequence: str = "ZYX", unit: Any = "rad") -> np.ndarray:
        """(..., 3) angles of intrinsic rotations about the axes of a sequence, q = q_1 q_2 q_3.

        unit : of angles, its name or an astropy unit

        Raises InputError for a sequence that is none, and for a unit of something else.
        """
        angles = rotations.euler_angles(self.attitude, rotations.check_sequence(sequence, "sequence"))
        return angles / units.parse_unit(unit, units.ANGLE, "unit")

    def spin(self, axis: Any = "z") -> SpinState:
        """The spin about a body axis: direction of the angular momentum, nutation, phases, rate.

        Raises RegimeError where there are no rates or no inertia, and in a frame that turns.
        """
        from .pointing.spin_state import spin_state

        return spin_state(self, axis)

    def direction(self, body_axis: Any) -> np.ndarray:
        """(..., 3) unit vectors of a body axis ("x", "-z", three numbers) along the axes of `frame`."""
        from .pointing import targets

        return targets.direction(self, body_axis)

    def sky_coord(self, body_axis: Any) -> SkyCoord:
        """The direction of a body axis on the sky, an astropy SkyCoord in ICRS.

        Raises InputError in frame INERTIAL, whose axes only its user knows.
        """
        from astropy.coordinates import SkyCoord

        from .pointing import targets

        return SkyCoord(*targets.radec(self, body_axis), unit="rad", frame="icrs")

    def angle(self, body_axis: Any, to: Any, unit: Any = "rad") -> np.ndarray:
        """(...,) angles between a body axis and a target.

        Parameters
        ----------
        body_axis : "x", "-z", or three numbers along the body axes
        to : "sun" (its geometric direction, from the body where the scene has an orbit), "nadir" or "earth",
            "velocity" (inertial), "orbit_normal", "momentum", "magnetic_field" (of the Earth's dipole); a
            direction of three numbers along the axes of `frame`; {"body_axis": axis}; {"position": (3,) m,
            from the centre}
        unit : of angles, its name or an astropy unit

        Raises
        ------
        InputError : an axis, target or unit that is none; a target that needs dates where there are none.
        RegimeError : a target that needs an orbit, a momentum or a frame that this ephemeris has not.
        """
        from .pointing import targets

        return targets.angle(self, body_axis, to) / units.parse_unit(unit, units.ANGLE, "unit")

    @property
    def position(self) -> np.ndarray:
        """(instants, 3) m of the scene's orbit along the axes of `frame`; RegimeError without an orbit."""
        from .pointing import targets

        return targets.position(self)

    @property
    def velocity(self) -> np.ndarray:
        """(instants, 3) m/s of the scene's orbit, inertial, along the axes of `frame`."""
        from .pointing import targets

        return targets.orbit_state(self)[1]

    def ground_points(self, body_axis: Any) -> GroundPoints:
        """Where a body axis meets the Earth: geodetic longitude and latitude, rad, and distance, m."""
        from .pointing import surface_points

        return surface_points.ground_points(self, body_axis)

    def sub_point(self, to: Any) -> tuple[np.ndarray, np.ndarray]:
        """Longitude and latitude, rad, of a target (see `angle`) in the body axes: of the Sun, sub-solar."""
        from .pointing import surface_points

        return surface_points.sub_point(self, to)

    def with_columns(self, columns: str | Sequence[str]) -> Ephemeris:
        """The same ephemeris, of which tables and files of columns hold what is named here, in this order.

        columns : of "time", "elapsed", "quaternion", "angular_velocity", "angular_momentum", "position",
            "velocity", "euler:ZYX", "direction:z", "angle:z:sun", "spin" and their likes (docs/formats.md),
            as a list or with commas between them

        Raises InputError for what is none of these.
        """
        from .pointing.columns import parse

        return replace(self, columns=parse(columns))

    # -- leaving and coming back ----------------------------------------------------------------

    def _repr_html_(self) -> str:
        """A table, and a picture of one body's attitude where matplotlib is installed, for notebooks."""
        from importlib.util import find_spec

        from .samples.html_table import html_table

        elapsed = self.instants.seconds
        rows = {
            "name": self.name or None,
            "shape": self.shape,
            "frame": f"body to {self.frame}",
            "epoch": self.epoch,
            "span, s": f"{elapsed.min():.9g} to {elapsed.max():.9g}" if elapsed.size else None,
            "solver": self.plan and self.plan.solver,
            "error, rad": self.plan and self.plan.error_text,
            "events": len(self.events) or None,
        }
        drawable = len(self.shape) == 1 and len(self) > 1 and find_spec("matplotlib") is not None
        if not drawable:
            return html_table("Ephemeris", rows)
        from .plot import timeline

        drawn = self[:: -(-len(self) // 2000)]
        return html_table("Ephemeris", rows, timeline.picture(drawn, "png"))

    def plot(self, what: str | Sequence[str] = ()) -> Figure:
        """A figure of matplotlib: attitude, rate and what else is known in time, or what is named.

        Parameters
        ----------
        what : names, or one text with commas
            Columns as of `with_columns` ("euler:ZYX", "angle:z:sun" ...), "rates", "euler", "angles",
            "momentum", "energy", and "polhode", "momentum-sphere", "ground-track".

        Raises
        ------
        InputError : an unknown name, several bodies, or fewer than two instants.
        RegimeError : what the ephemeris does not know.
        """
        from .plot import choices, timeline

        return timeline.figure(self, choices.parse(what) if what else ())

    def animate(self, path: str | Path | None = None, seconds: float = 10.0) -> FuncAnimation | None:
        """A film of the body with its axes and its polhode, so many seconds long.

        Written to a path that ends in .gif, .mp4 (needs ffmpeg) or .html; without one, an animation of
        matplotlib, which a notebook shows.

        Raises
        ------
        InputError : several bodies, fewer than two instants, or a length that is not above zero.
        FormatError : another ending, or a file that cannot be written.
        """
        from .plot import animation

        if path is None:
            return animation.film(self, seconds)
        animation.write(self, path, seconds)
        return None

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
        axis) where the rate is known, angular_momentum [N m s], position [m], velocity [m/s], covariances and
        columns of choice (their elements along element, euler_angle) as in
        `to_table`.  Coordinates elapsed [s], elapsed_rest [s], its rounding error, and time,
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
        format: str | None = None,  # noqa: A002 (public name)
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
    def read(
        cls,
        path: str | Path | Sequence[str | Path],
        format: str | None = None,  # noqa: A002 (public name)
        **options: Any,
    ) -> Ephemeris:
        """Read a file, in the format of its ending or the one that is named.

        Several files, of one body and of spans of time that follow each other, are joined to one ephemeris,
        in which each further one begins a segment.

        From a file in a format of this library (docs/formats.md) the bits of quaternions, rates and times
        come back; from one in a format of other tools what it holds, in the conventions of this library.

        Raises FormatError, with file and line, for anything else.
        """
        from . import formats

        return cls.of(formats.read(path, format, **options))
