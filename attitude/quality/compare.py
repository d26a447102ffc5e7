"""Comparing two ephemerides: the rotation and the difference of rates between them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NotRequired

import numpy as np
from typing_extensions import TypedDict

from ..errors import InputError, RegimeError
from ..frames import rotations
from ..samples.ephemeris_data import EphemerisData
from ..samples.transform import in_frame
from ..times.instants import Instants, as_instants


class DifferenceAnswer(TypedDict):
    """Sizes of differences: the greatest, when, and the root of the mean square; and along body axes."""

    greatest: float
    at_s: float
    rms: float
    rms_axes: list[float]
    greatest_axes: list[float]


class ComparisonAnswer(TypedDict):
    """An `EphemerisComparison` as plain data; without rates where one ephemeris has none."""

    instants: int
    left_out: int
    frame: str
    note: str
    angle_rad: DifferenceAnswer
    rate_rad_s: NotRequired[DifferenceAnswer]


@dataclass(frozen=True, eq=False)
class EphemerisComparison:
    """How the second of two ephemerides differs from the first, at instants of the first.

    instants : (n,) those that both cover
    frame : of both
    rotation : (n, 3) rad, rotation vectors from the first attitude to the second, along the first's body axes
    rate_difference : (n, 3) rad/s, second less first, along each one's body axes; None where one has no rates
    left_out : how many instants of the first the second does not cover
    note : how the second was brought to these instants
    """

    instants: Instants
    frame: str
    rotation: np.ndarray
    rate_difference: np.ndarray | None
    left_out: int
    note: str

    @property
    def angle(self) -> np.ndarray:
        """(n,) rad between the attitudes."""
        return np.asarray(np.linalg.norm(self.rotation, axis=-1))

    def to_dict(self) -> ComparisonAnswer:
        """Greatest and rms differences, where they are, and per axis, as plain data."""
        table: ComparisonAnswer = {
            "instants": len(self.rotation),
            "left_out": self.left_out,
            "frame": self.frame,
            "note": self.note,
            "angle_rad": _summary(self.rotation, self.instants),
        }
        if self.rate_difference is not None:
            table["rate_rad_s"] = _summary(self.rate_difference, self.instants)
        return table

    def __str__(self) -> str:
        table = self.to_dict()
        first_line = f"{table['instants']} instants, in {self.frame} ({self.note})"
        if self.left_out:
            first_line += f"; {self.left_out} instants of the first are not covered by the second"
        lines = [first_line]
        entries = {("angle", "rad"): table["angle_rad"], ("rate", "rad/s"): table.get("rate_rad_s")}
        for (name, unit), entry in entries.items():
            if entry is not None:
                axes = ", ".join(
                    f"{axis} {value:.3e}" for axis, value in zip("xyz", entry["rms_axes"], strict=True)
                )
                worst = f"at most {entry['greatest']:.3e} {unit}, at {entry['at_s']:.9g} s"
                lines.append(f"{name}: {worst}; rms {entry['rms']:.3e} {unit} (body axes: {axes})")
        return "\n".join(lines)


def _summary(vectors: np.ndarray, instants: Instants) -> DifferenceAnswer:
    size = np.linalg.norm(vectors, axis=-1)
    worst = int(np.argmax(size))
    return {
        "greatest": float(size[worst]),
        "at_s": float(instants.seconds[worst]),
        "rms": float(np.sqrt((size**2).mean())),
        "rms_axes": np.sqrt((vectors**2).mean(axis=0)).tolist(),
        "greatest_axes": np.abs(vectors).max(axis=0).tolist(),
    }


def compare(first: EphemerisData, second: EphemerisData, frame: str | None = None) -> EphemerisComparison:
    """Compare two ephemerides of one body, in the frame of the first or another one.

    The second is brought to those instants of the first that it covers: by its motion where that is known,
    else interpolated as its file states.

    Raises
    ------
    InputError : no instant in common, or one ephemeris with dates and one without.
    RegimeError : several bodies, or frames between which there is no rotation.
    """
    for data in (first, second):
        if len(data.shape) != 1 or not len(data):
            raise RegimeError(
                f"compare: one body at a list of instants can be compared, not shape {data.shape}"
            )
    if (first.epoch is None) != (second.epoch is None):
        raise InputError("epoch", None, "dates in both ephemerides or in neither")
    if frame is not None:
        first = in_frame(first, frame)
    second = in_frame(second, first.frame)
    instants = first.instants if second.epoch is None else as_instants(first.time, second.epoch)
    index, same = _nearest(second, instants.seconds)  # of those that it has up to rounding, its own
    own = second.instants[index]
    seconds, low = np.where(same, own.seconds, instants.seconds), np.where(same, own.low, instants.low)
    instants = Instants(seconds, low, instants.epoch, scale=instants.scale)
    covered, note = _covered(second, instants)
    if not covered.any():
        raise InputError("instants", "none in common", "ephemerides that overlap in time")
    first, instants = first[covered], instants[covered]
    index, same = _nearest(second, instants.seconds)
    second = second[index] if same.all() else second.resampled(instants)
    rates = (first.angular_velocity, second.angular_velocity) if first.has_rate and second.has_rate else None
    return EphemerisComparison(
        first.instants,
        first.frame,
        rotations.rotation_vectors(first.quaternion("wxyz"), second.quaternion("wxyz")),
        None if rates is None else rates[1] - rates[0],
        int((~covered).sum()),
        note,
    )


def _covered(data: EphemerisData, instants: Instants) -> tuple[np.ndarray, str]:
    """(n,) bool: instants at which the ephemeris is available, and how."""
    seconds = instants.seconds
    if data.has_known_motion and not data.is_simulated:
        return np.ones(seconds.size, dtype=bool), "the second by its own motion"
    if _nearest(data, seconds)[1].all():
        return np.ones(seconds.size, dtype=bool), "both have these instants"
    if data.interpolation is not None:
        return data.interpolation.owners(seconds) >= 0, str(data.interpolation)
    if data.has_known_motion:
        inside = (seconds >= data.elapsed.min()) & (seconds <= data.elapsed.max())
        return inside, "the second by its own motion"
    return _nearest(data, seconds)[1], "at the instants that both have"


def _nearest(data: EphemerisData, seconds: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(n,) index of the nearest instant of the ephemeris, and whether it is the same."""
    own = data.elapsed
    order = np.argsort(own, kind="stable")
    after = np.clip(np.searchsorted(own[order], seconds), 0, own.size - 1)
    before = np.maximum(after - 1, 0)
    closer = np.abs(own[order[before]] - seconds) < np.abs(own[order[after]] - seconds)
    index = order[np.where(closer, before, after)]
    return index, np.abs(own[index] - seconds) <= 1e-9  # s, the rounding of dates
