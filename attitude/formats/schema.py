"""The schema of all formats: metadata, and columns with their units in the names."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace
from itertools import chain
from typing import Any

import erfa
import numpy as np
from astropy.time import Time

from .. import units
from ..errors import AttitudeError, FormatError, InputError, note, shown, warn
from ..frames import rotations
from ..pointing.vector_columns import (
    MOMENTUM,
    NOT_READ,
    POSITION,
    QUATERNION,
    RATE,
    VELOCITY,
    vectors,
)
from ..rigid_body.body import RigidBody
from ..samples import event_records
from ..samples.chunks import Samples
from ..samples.ephemeris_data import EphemerisData, convention
from ..samples.translation import Translation
from ..times import leap_seconds
from ..times.instants import Instants, check_epoch
from .date_text import dates, iso_text, one_date
from .text_rows import texts

KIND = "attitude-ephemeris/1"
ELAPSED, REST, TIME = "elapsed_s", "elapsed_rest_s", "time"

MAX_OFF_UNIT_IN_FILES = 1e-2  # of quaternions in few digits
MAX_RATE = 1e306  # rad/s: in deg/s it is still a finite double


def metadata(samples: Samples) -> dict[str, Any]:
    """All metadata as plain data; events only where there were any."""
    first, instants = samples.first, samples.first.instants
    events = {"events": event_records.to_plain(first.events)} if first.events else {}
    chosen = {"chosen_columns": list(first.columns)} if first.columns else {}
    return {
        "kind": KIND,
        "name": first.name,
        "convention": convention(first.frame, first.ut1),
        "quaternion_order": "wxyz",
        "frame": first.frame,
        "epoch": None if instants.epoch is None else epoch_record(instants.epoch),
        "time_scale": instants.scale,
        "body": None if first.body is None else body_record(first.body),
        "shape": list(samples.shape),
        **events,
        **chosen,
        **({"ut1": first.ut1} if first.ut1 != "tables" else {}),
        **({"notes": list(first.notes)} if first.notes else {}),
    }


def refuse_unless_list(samples: Samples, name: str) -> None:
    """Raises FormatError where the samples are not one body at a list of instants."""
    if not samples.is_list:
        raise FormatError(
            f"{name} holds one body at a list of instants, not shape {samples.shape}; ecsv, json and npz do"
        )


def epoch_record(epoch: Time) -> dict[str, Any]:
    """The epoch as its two Julian dates, which are exact, and as text for people."""
    days = {"jd1": float(epoch.jd1), "jd2": float(epoch.jd2)}
    return {"time": one_date(epoch), "scale": epoch.scale, **days}


def body_record(body: RigidBody) -> dict[str, Any]:
    """The body as its principal moments, or as its tensor where its axes are others."""
    physical = {} if body.physical else {"physical": False}
    if body._tensor is None or (body.axes == np.eye(3)).all():
        return {"moments": body.moments.tolist(), "unit": "kg m2", **physical}
    return {"tensor": body.tensor.tolist(), "unit": "kg m2", **physical}


def names(samples: Samples) -> list[str]:
    """Names of the columns; the same for every chunk."""
    first = samples.first
    time = [TIME] if first.instants.epoch is not None else []
    elapsed = [ELAPSED, REST]
    if first.columns:
        time = time if "time" in first.columns else []
        elapsed = [ELAPSED] if "elapsed" in first.columns else []
    return [*time, *elapsed, *chain.from_iterable(column.names for column in vectors(first))]


def columns(ephemeris: EphemerisData, names: Collection[str]) -> dict[str, np.ndarray]:
    """The columns of these names, each of the ephemeris's shape (those of time: of the instants').

    They may be views of its arrays.
    """
    table: dict[str, np.ndarray] = {}
    if TIME in names:
        table[TIME] = dates(ephemeris.instants)
    if ELAPSED in names:
        table[ELAPSED] = ephemeris.instants.seconds
    if REST in names:
        table[REST] = ephemeris.instants.low
    for column in vectors(ephemeris, names):
        for i, name in enumerate(column.names):
            if name in names:
                table[name] = column.values[..., i]
    return table


def rows(table: Mapping[str, np.ndarray], names: list[str], pieces: list[bytes]) -> bytes:
    """Text of all columns, a row per instant (`text_rows.texts`), with the time, if any, as its lead."""
    columns = np.stack([table[name] for name in names if name != TIME])
    return texts(columns, pieces, table.get(TIME))


def ephemeris_from(
    meta: Any, table: Mapping[str, Any], source: str, first_line: int | None = None
) -> EphemerisData:
    """The ephemeris of these metadata and columns.

    first_line : the line of the first row, where each row is a line: errors then name the line of the value

    Raises FormatError for metadata and columns that `metadata` and `columns` would not have written.
    """
    _check_kind(meta, source)
    if meta.get("quaternion_order") != "wxyz":
        raise FormatError(f"quaternion_order is {shown(meta.get('quaternion_order'))}, not 'wxyz'", source)
    table = {name: values for name, values in table.items() if name not in NOT_READ}
    groups = (RATE, MOMENTUM, POSITION + VELOCITY)
    optional = [name for names in groups if any(name in table for name in names) for name in names]
    required = (ELAPSED, *QUATERNION, *optional)
    missing = [name for name in required if name not in table]
    if missing:
        raise FormatError(f"no column {missing[0]}", source)
    unknown = [name for name in table if name not in (*required, REST)]
    if unknown:
        raise FormatError(f"column {shown(unknown[0])} is unknown", source)
    try:
        finite = {name: units.finite_array(values, name) for name, values in table.items()}
        return _ephemeris(meta, finite, source)
    except InputError as error:
        row = error.steps[-1] if error.steps else None
        line = first_line + row if first_line is not None and isinstance(row, int) else None
        raise FormatError(str(error), source, line) from None
    except AttitudeError as error:
        raise FormatError(str(error), source) from None
    except (AttributeError, KeyError, TypeError, ValueError, OverflowError, RecursionError) as error:
        reason = " ".join(str(error).split())
        raise FormatError(f"inconsistent metadata or columns ({reason})", source) from None


def _check_kind(meta: Any, source: str) -> None:
    kind = meta.get("kind") if isinstance(meta, dict) else None
    if kind != KIND:
        raise FormatError(f"not an ephemeris of this library ({KIND}): kind is {shown(kind)}", source)


def stated_count(meta: Any, source: str, line: int | None = None) -> int:
    """The number of instants by the metadata, in formats that hold one list of them."""
    _check_kind(meta, source)
    shape = meta.get("shape")
    if not isinstance(shape, list) or len(shape) != 1 or type(shape[0]) is not int or shape[0] < 1:
        raise FormatError(f"shape is {shown(shape)}, not that of a list of instants", source, line)
    return shape[0]


def refuse_more(count: int, stated: int, source: str, line: int | None = None) -> None:
    """Raises FormatError where a file has more instants than its metadata state."""
    if count > stated:
        raise FormatError(f"more instants than the {stated} that its metadata state", source, line)


def _ephemeris(meta: Mapping[str, Any], table: Mapping[str, np.ndarray], source: str) -> EphemerisData:
    shape, instants = table[QUATERNION[0]].shape, table[ELAPSED].shape
    if list(shape) != list(meta["shape"]) or shape[len(shape) - len(instants) :] != instants:
        raise ValueError(f"shape {shape}, {instants} instants, {shown(meta['shape'])} stated")
    if not all(shape):
        raise ValueError("no instants")
    for name, values in table.items():
        if values.shape != (instants if name in (ELAPSED, REST) else shape):
            raise ValueError(f"column {name} of shape {values.shape}")
    quaternion = unit_rows(_vector(table, QUATERNION), source, rotations.UNIT_TOLERANCE)
    rate, momentum, position, velocity = (
        _vector(table, names) if names[0] in table else None for names in (RATE, MOMENTUM, POSITION, VELOCITY)
    )
    epoch = epoch_of_record(meta.get("epoch"))
    scale = None if epoch is None else _check_scale(meta["time_scale"])
    rest = table.get(REST)
    rest = rest if rest is not None and rest.any() else None
    if rest is not None:
        expected = f"the rounding error of {ELAPSED}: less than a unit of its last place, or a nanosecond"
        units.refuse_where(np.abs(rest) > 2.3e-16 * np.abs(table[ELAPSED]) + 1e-9, rest, REST, expected)
    times = check_dates(Instants(table[ELAPSED], rest, epoch, scale=scale))
    frame, body = rotations.check_any_frame(meta["frame"]), body_of_record(meta.get("body"))
    batch = shape[: len(shape) - len(instants)]
    if body is not None and np.broadcast_shapes(body.shape, batch) != batch:
        raise ValueError(f"bodies of shape {body.shape}, attitudes of {batch}")
    translation = None if position is None or velocity is None else Translation(position, velocity)
    events = event_records.from_plain(meta.get("events", []))
    name = meta.get("name", "")
    if not isinstance(name, str) or not is_utf8(name):
        raise ValueError(f"name {shown(name)}")
    notes = meta.get("notes", [])
    if not isinstance(notes, list) or not all(isinstance(text, str) and is_utf8(text) for text in notes):
        raise ValueError(f"notes {shown(notes)}")
    for text in notes:
        note(text)
    ut1 = rotations.check_ut1(meta.get("ut1", "tables"))
    read = EphemerisData(quaternion, times, frame, body, rate, name, None, translation, events, momentum)
    return read if ut1 == "tables" else replace(read, ut1=ut1)


def is_utf8(text: str) -> bool:
    """Whether the text can be encoded: escapes of JSON and YAML may be unpaired surrogates."""
    try:
        text.encode()
    except UnicodeEncodeError:
        return False
    return True


def check_dates(times: Instants) -> Instants:
    """The same instants; InputError where the least or the greatest, if dated, is in no calendar."""
    if times.epoch is None:
        return times
    seconds = np.ravel(times.seconds)
    ends = [int(np.argmin(seconds)), int(np.argmax(seconds))]
    low = None if times.seconds_low is None else np.ravel(times.seconds_low)[ends]
    try:
        if times.max_abs_seconds > 1e15:  # 30 million years
            raise ValueError(f"{times.max_abs_seconds:.3g} s from the epoch")
        with leap_seconds.dubious_years():
            iso_text(Instants(seconds[ends], low, times.epoch, scale=times.scale).time)
    except (erfa.ErfaError, ValueError) as error:
        expected = f"instants that a calendar has ({error})"
        raise InputError("instants", f"scale {times.scale!r}", expected) from None
    return times


def unit_rows(q: np.ndarray, source: str, tolerance: float = 1e-12, field: str = "quaternion") -> np.ndarray:
    """Quaternions (n, 4) of a file, each divided by its length where this is not within `tolerance` of 1.

    Warns where one is off by more than 1e-6, as of few digits; InputError beyond 1e-2, as of a wrong order.
    """
    length, off = rotations.off_unit(q, MAX_OFF_UNIT_IN_FILES)
    expected = f"a unit quaternion, within {MAX_OFF_UNIT_IN_FILES:g} of length 1"
    units.refuse_where(off, length, field, expected)
    rotations.warn_of_lengths(length, f"{source}: {field}")
    return rotations.of_unit_length(q, length, tolerance)


def nearest_rotations(matrices: np.ndarray, source: str) -> np.ndarray:
    """(n, 4) wxyz of the rotations nearest to matrices (n, 3, 3) of a file, v' = M v.

    Warns where one is off by more than 1e-6, as of few digits; InputError beyond 1e-2.
    """
    off = rotations.off_orthonormal(matrices)
    expected = f"a rotation matrix, orthonormal within {MAX_OFF_UNIT_IN_FILES:g}"
    units.refuse_where(~(off <= MAX_OFF_UNIT_IN_FILES), matrices, "matrix", expected)
    if off.max() > rotations.UNIT_TOLERANCE:
        text = f"matrices are orthonormal within {off.max():.2g}; the nearest rotations are taken"
        warn(f"{source}: {text}")
    u, _, vh = np.linalg.svd(matrices)
    return rotations.from_matrix(u @ vh)


def _vector(table: Mapping[str, np.ndarray], names: tuple[str, ...]) -> np.ndarray:
    """Columns stacked along a last dimension, stored by component."""
    return np.moveaxis(np.stack([table[name] for name in names]), 0, -1)


def _check_scale(scale: Any) -> str:
    if scale not in Time.SCALES or scale == "local":
        raise ValueError(f"time scale {shown(scale)}")
    return str(scale)


def epoch_of_record(epoch: Mapping[str, Any] | None) -> Time | None:
    """The epoch of what `epoch_record` returns."""
    if epoch is None:
        return None
    days = units.finite_array([epoch["jd1"], epoch["jd2"]], "epoch")
    time = Time(days[0], days[1], format="jd", scale=_check_scale(epoch["scale"]))
    time.format = "isot"
    try:
        iso_text(time)
    except erfa.ErfaError as error:
        raise ValueError(f"epoch beyond any calendar: {error}") from None
    return check_epoch(time)


def body_of_record(body: Mapping[str, Any] | None) -> RigidBody | None:
    """The body of what `body_record` returns."""
    if body is None:
        return None
    if body["unit"] != "kg m2":
        raise ValueError(f"body in {shown(body['unit'])}, not 'kg m2'")
    physical = body.get("physical", True)
    if not isinstance(physical, bool):
        raise ValueError(f"body.physical {shown(physical)}")
    if "moments" in body:
        return RigidBody.from_moments(body["moments"], physical)
    return RigidBody(body["tensor"], physical)


def degrees(ephemeris: EphemerisData) -> np.ndarray:
    """(n, 3), deg/s: the body rate.

    Raises FormatError where a finite rate is not finite in that unit.
    """
    with np.errstate(over="ignore"):
        rate = np.rad2deg(ephemeris.angular_velocity)
    if not np.isfinite(units.extremes(rate)).all():
        raise FormatError("a rate that overflows a double in deg/s")
    return rate
