"""Ephemerides of files at other instants than theirs."""

from __future__ import annotations

import time
from collections.abc import Iterable
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from .. import stopping
from ..errors import RegimeError
from ..times.instants import Instants
from .chunks import CHUNK_INSTANTS
from .ephemeris_data import EphemerisData
from .interpolation import Interpolation, InterpolationMethod, InterpolationSegment, interpolate
from .provenance import BETWEEN_ATTITUDES_OF_A_FILE, Plan

# Events at which the rate jumps, or which a file marks as not to be interpolated across.
SEGMENT_EVENTS = ("impulse", "contact", "segment")


def with_interpolation(data: EphemerisData) -> EphemerisData:
    """An ephemeris of a file that can be resampled: by the method it states, else by slerp between events.

    Instants that do not increase, or are not a list, cannot be interpolated: the data are as they were.
    """
    if data.resample is not None or len(data.instants.shape) != 1 or not (np.diff(data.elapsed) > 0.0).all():
        return data
    interpolation = data.interpolation or Interpolation(segments_at_events(data, InterpolationMethod()))
    template = replace(data, centre_of_mass=None, momentum=None, interpolation=interpolation)
    return replace(data, interpolation=interpolation, resample=Interpolator(template, interpolation))


def in_own_frame(data: EphemerisData) -> Interpolation | None:
    """The interpolation of a file, of attitudes in the frame of the ephemeris, which may be another."""
    interpolation = data.interpolation
    if interpolation is None or isinstance(data.resample, Interpolator):
        return interpolation
    edges = np.cumsum([0, *(len(segment.attitude) for segment in interpolation.segments)])
    segments = tuple(
        segment._replace(attitude=data.attitude[first:last], rate=None)
        for segment, (first, last) in zip(interpolation.segments, pairwise(edges.tolist()), strict=True)
    )
    return replace(interpolation, segments=segments)


def with_method(data: EphemerisData, method: InterpolationMethod, sign_changes: int = 0) -> EphemerisData:
    """The ephemeris of a file that states this method; `sign_changes` as in `Interpolation`."""
    return replace(data, interpolation=Interpolation(segments_at_events(data, method), True, sign_changes))


def segments_at_events(data: EphemerisData, method: InterpolationMethod) -> tuple[InterpolationSegment, ...]:
    """The instants of an ephemeris, divided where an event says that nothing is interpolated across."""
    cuts = [event.seconds for event in data.events if event.kind in SEGMENT_EVENTS]
    count, seconds = len(data), data.elapsed
    edges = [0, *sorted({int(i) for i in np.searchsorted(seconds, cuts)} - {0, count}), count]
    rate = data.rate if isinstance(data.rate, np.ndarray) else None
    return tuple(
        InterpolationSegment(
            float(seconds[first]),
            float(seconds[last - 1]),
            data.instants[first:last],
            data.attitude[..., first:last, :],
            None if rate is None else rate[..., first:last, :],
            method,
        )
        for first, last in pairwise(edges)
    )


@dataclass(frozen=True)
class Interpolator:
    """The motion of a file as a function of instants: `EphemerisData.resample`.

    template : what all instants share
    """

    template: EphemerisData
    interpolation: Interpolation

    def __call__(self, instants: Instants) -> EphemerisData:
        """The ephemeris at other instants; RegimeError for those that no segment covers."""
        began = time.perf_counter()
        flat = instants.flattened()
        owners = self.interpolation.owners(flat.seconds)
        if (owners < 0).any():
            raise RegimeError(self._refusal(float(flat.seconds[np.argmax(owners < 0)])))
        shape = self.template.batch_shape
        attitude = np.empty((*shape, flat.seconds.size, 4))
        has_rate = all(segment.rate is not None for segment in self.interpolation.segments)
        rate = np.empty((*shape, flat.seconds.size, 3)) if has_rate else None
        for block in _blocks(owners):
            stopping.check()
            segment = self.interpolation.segments[owners[block[0]]]
            attitude[..., block, :], omega = interpolate(segment, flat[block])
            if rate is not None and omega is not None:
                rate[..., block, :] = omega
        plan = Plan(
            str(self.interpolation),
            attitude[..., 0].size,
            0.0,
            time.perf_counter() - began,
            None,
            BETWEEN_ATTITUDES_OF_A_FILE,
            notes=self.template.notes,
        )
        return replace(
            self.template,
            attitude=attitude.reshape(*shape, *instants.shape, 4),
            rate=None if rate is None else rate.reshape(*shape, *instants.shape, 3),
            instants=instants,
            plan=plan,
            interpolation=replace(self.interpolation, is_stated=False),
            resample=self,
        )

    def _refusal(self, seconds: float) -> str:
        starts, stops = ([float(t) for t in ends] for ends in self.interpolation.ends)
        if seconds < starts[0] or seconds > stops[-1]:
            return (
                f"resampled: {seconds!r} s is outside the file, which covers {starts[0]!r} to {stops[-1]!r} s"
            )
        k = int(np.searchsorted(starts, seconds))
        return f"resampled: {seconds!r} s is in the gap of the file from {stops[k - 1]!r} to {starts[k]!r} s"


def _blocks(owners: np.ndarray) -> Iterable[np.ndarray]:
    """Indices of instants of one segment each, as many as have their weights in memory at a time."""
    order = np.argsort(owners, kind="stable")
    edges = np.flatnonzero(np.diff(owners[order])) + 1
    for part in np.split(order, edges):
        for first in range(0, part.size, CHUNK_INSTANTS):
            yield part[first : first + CHUNK_INSTANTS]
