"""What every format says: metadata, and columns with their units in the names."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, Any

import erfa
import numpy as np
import orjson
from astropy.time import Time

from .. import orientation, units
from ..body import RigidBody
from ..dynamics.translation import Translation
from ..elapsed import Instants, check_epoch
from ..ephemeris import Ephemeris, convention
from ..errors import AttitudeError, FormatError, InputError
from . import events

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator, Mapping

    from .samples import Samples

KIND = "attitude-ephemeris/1"
QUATERNION = ("q_w", "q_x", "q_y", "q_z")
RATE = ("omega_x_rad_s", "omega_y_rad_s", "omega_z_rad_s")
POSITION = ("position_x_m", "position_y_m", "position_z_m")
VELOCITY = ("velocity_x_m_s", "velocity_y_m_s", "velocity_z_m_s")
MOMENTUM = ("momentum_x_N_m_s", "momentum_y_N_m_s", "momentum_z_N_m_s")
ELAPSED, REST, TIME = "elapsed_s", "elapsed_rest_s", "time"
FEW = 64  # dates
ROWS = 1 << 13  # of text, written together


def metadata(samples: Samples) -> dict[str, Any]:
    """Everything but the columns, as plain data; events where there were any."""
    head = samples.head
    happened = {"events": events.to_plain(head.events)} if head.events else {}
    return {
        "kind": KIND,
        "name": head.name,
        "convention": convention(head.frame),
        "quaternion_order": "wxyz",
        "frame": head.frame,
        "epoch": None if head.epoch is None else _epoch(head.epoch),
        "time_scale": head.instants.scale,
        "body": None if head.body is None else _body(head.body),
        "shape": list(samples.shape),
        **happened,
    }


def _epoch(epoch: Time) -> dict[str, Any]:
    """The two Julian dates are the epoch exactly; the text is for people."""
    days = float(epoch.jd1), float(epoch.jd2)
    text = _epoch_text(*days, epoch.scale)
    return {"time": text, "scale": epoch.scale, "jd1": days[0], "jd2": days[1]}


@lru_cache(maxsize=256)
def _epoch_text(jd1: float, jd2: float, scale: str) -> str:
    text: bytes = _iso_text(np.float64(jd1), np.float64(jd2), scale).item()
    return text.decode()


def _body(body: RigidBody) -> dict[str, Any]:
    if (body.axes == np.eye(3)).all():
        return {"moments": body.moments.tolist(), "unit": "kg m2"}
    return {"tensor": body.tensor.tolist(), "unit": "kg m2"}


def names(samples: Samples) -> list[str]:
    """Of the columns: the same for every piece."""
    head = samples.head
    time = [TIME] if head.epoch is not None else []
    rest = [REST] if samples.has_rest else []
    return [*time, ELAPSED, *rest, *(name for group, _ in vectors(head) for name in group)]


def columns(ephemeris: Ephemeris, wanted: Collection[str]) -> dict[str, np.ndarray]:
    """Those asked for by name, each of the ephemeris's shape (those of time: of the instants')."""
    table: dict[str, np.ndarray] = {}
    if TIME in wanted:
        table[TIME] = iso_dates(ephemeris)
    if ELAPSED in wanted:
        table[ELAPSED] = ephemeris.elapsed
    if REST in wanted:
        rest = ephemeris.instants.rest
        table[REST] = np.zeros(ephemeris.instants.shape) if rest is None else rest
    for group, vector in vectors(ephemeris):
        table.update((name, vector[..., i]) for i, name in enumerate(group) if name in wanted)
    return table


def tables(ephemeris: Ephemeris, wanted: Collection[str]) -> Iterator[dict[str, np.ndarray]]:
    """`columns`, some rows at a time: as texts, numbers take many times their room."""
    table = columns(ephemeris, wanted)
    for first in range(0, len(ephemeris), ROWS):
        yield {name: values[first : first + ROWS] for name, values in table.items()}


def digits(table: Mapping[str, np.ndarray], names: list[str], between: bytes) -> list[bytes]:
    """One text a row, of all columns but the time's.

    The digits are orjson's: shortest form that reads back to the same bits, at 20 ns a number.
    """
    matrix = np.stack([table[name] for name in names if name != TIME], axis=1)
    text = orjson.dumps(matrix, option=orjson.OPT_SERIALIZE_NUMPY)[2:-2]
    rows = text.split(b"],[")
    return rows if between == b"," else [row.replace(b",", between) for row in rows]


def vectors(ephemeris: Ephemeris) -> Iterator[tuple[tuple[str, ...], np.ndarray]]:
    """The names of a vector's columns, and the vector; of all that the ephemeris holds.

    The momentum only where it is more than inertia times rate.
    """
    yield QUATERNION, ephemeris.quaternion("wxyz")
    if ephemeris.has_rate:
        yield RATE, ephemeris.angular_velocity
    momentum = ephemeris.own_momentum
    if momentum is not None:
        yield MOMENTUM, momentum
    if ephemeris.translation is not None:
        yield POSITION, ephemeris.translation.position
        yield VELOCITY, ephemeris.translation.velocity


def ephemeris_from(
    meta: Any, table: Mapping[str, Any], source: str, first_line: int | None = None
) -> Ephemeris:
    """The ephemeris that these metadata and columns describe; refuses what `columns` would not have made.

    `first_line` is the line of the first row, where a row is a line: a bad value is then named by its own.
    """
    kind = meta.get("kind") if isinstance(meta, dict) else None
    if kind != KIND:
        raise FormatError(f"not an ephemeris of this library ({KIND}): kind is {kind!r}", source)
    if meta.get("quaternion_order") != "wxyz":
        raise FormatError(f"quaternion_order is {meta.get('quaternion_order')!r}, not 'wxyz'", source)
    groups = (RATE, MOMENTUM, POSITION + VELOCITY)
    whole = [name for names in groups if any(name in table for name in names) for name in names]
    needed = (ELAPSED, *QUATERNION, *whole)
    missing = [name for name in needed if name not in table]
    if missing:
        raise FormatError(f"no column {missing[0]}", source)
    try:
        return _ephemeris(meta, {name: units.finite_array(values, name) for name, values in table.items()})
    except InputError as error:
        row = error.steps[-1] if error.steps else None
        line = first_line + row if first_line is not None and isinstance(row, int) else None
        raise FormatError(str(error), source, line) from None
    except AttitudeError as error:
        raise FormatError(str(error), source) from None
    except (AttributeError, KeyError, TypeError, ValueError, OverflowError) as error:
        reason = " ".join(str(error).split())
        raise FormatError(f"metadata or columns that do not fit together ({reason})", source) from None


def _ephemeris(meta: Mapping[str, Any], table: Mapping[str, np.ndarray]) -> Ephemeris:
    shape, instants = table[QUATERNION[0]].shape, table[ELAPSED].shape
    if list(shape) != list(meta["shape"]) or shape[len(shape) - len(instants) :] != instants:
        raise ValueError(f"shape {shape}, {instants} instants, {meta['shape']} stated")
    for name, values in table.items():
        if values.shape != (instants if name in (ELAPSED, REST) else shape):
            raise ValueError(f"column {name} of shape {values.shape}")
    quaternion = _vector(table, QUATERNION)
    orientation.attitude_quaternion(quaternion, "wxyz", "quaternion")
    rate, momentum, position, velocity = (
        _vector(table, names) if names[0] in table else None for names in (RATE, MOMENTUM, POSITION, VELOCITY)
    )
    epoch = _read_epoch(meta.get("epoch"))
    scale = None if epoch is None else _check_scale(meta["time_scale"])
    times = Instants(table[ELAPSED], table.get(REST), epoch, scale=scale)
    frame, body = orientation.check_any_frame(meta["frame"]), _read_body(meta.get("body"))
    batch = shape[: len(shape) - len(instants)]
    if body is not None and np.broadcast_shapes(body.shape, batch) != batch:
        raise ValueError(f"bodies of shape {body.shape}, attitudes of {batch}")
    moved = None if position is None or velocity is None else Translation(position, velocity)
    happened = events.from_plain(meta.get("events", []))
    name = str(meta.get("name", ""))
    return Ephemeris(quaternion, times, frame, body, rate, name, None, moved, happened, momentum)


def _vector(table: Mapping[str, np.ndarray], names: tuple[str, ...]) -> np.ndarray:
    """Columns side by side along a last dimension, stored by component."""
    return np.moveaxis(np.stack([table[name] for name in names]), 0, -1)


def _check_scale(scale: Any) -> str:
    if scale not in Time.SCALES or scale == "local":
        raise ValueError(f"time scale {scale!r}")
    return str(scale)


def _read_epoch(epoch: Mapping[str, Any] | None) -> Time | None:
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


def _read_body(body: Mapping[str, Any] | None) -> RigidBody | None:
    if body is None:
        return None
    if body["unit"] != "kg m2":
        raise ValueError(f"body in {body['unit']!r}, not 'kg m2'")
    if "moments" in body:
        return RigidBody.from_moments(body["moments"])
    return RigidBody(body["tensor"])


def _few_texts(year: Any, month: Any, day: Any, clock: Any) -> np.ndarray:
    """Row by row, where the calls for all rows together would take longer."""
    parts = (year, month, day, *(clock[name] for name in "hmsf"))
    rows = zip(*(np.reshape(part, -1).tolist() for part in parts), strict=True)
    texts = [b"%04d-%02d-%02dT%02d:%02d:%02d.%09d" % row for row in rows]
    return np.array(texts, dtype="S29").reshape(np.shape(year))


def iso_text(time: Time) -> np.ndarray:
    """ISO 8601 text to the nanosecond, leap seconds as second 60; bytes of shape time.shape.

    astropy's own formatting takes 6 us an instant, more than everything else in an answer.
    """
    return _iso_text(time.jd1, time.jd2, time.scale)


# From TAI, by these alone; for other scales astropy knows what they need (tables, the observer's place).
_FROM_TAI = {"tai": lambda *days: days, "utc": erfa.taiutc, "tt": erfa.taitt}


def iso_dates(ephemeris: Ephemeris) -> np.ndarray:
    """`iso_text` of its time, which is not built for it: that takes longer than all else of few instants.

    Raises what `Ephemeris.time` does.
    """
    instants = ephemeris.instants
    if instants.is_given or instants.epoch is None or instants.scale not in _FROM_TAI:
        return iso_text(ephemeris.time)
    try:
        days = _FROM_TAI[instants.scale](*instants.tai)
        return _iso_text(days[0], days[1], instants.scale).reshape(instants.shape)
    except (erfa.ErfaError, ValueError):
        return iso_text(ephemeris.time)  # which says what is wrong


def _iso_text(jd1: Any, jd2: Any, scale: str) -> np.ndarray:
    year, month, day, clock = erfa.d2dtf(scale.upper(), 9, jd1, jd2)
    if np.min(year, initial=0) < 0 or np.max(year, initial=0) > 9999:
        named = Time(jd1, jd2, format="jd", scale=scale).copy(format="isot")
        named.precision = 9
        return np.asarray(named.value).astype("S")
    if np.size(year) <= FEW:
        return _few_texts(year, month, day, clock)
    text = np.empty((*np.shape(year), 29), dtype=np.uint8)
    text[..., :] = np.frombuffer(b"0000-00-00T00:00:00.000000000", dtype=np.uint8)
    fields = ((year, 0, 4), (month, 5, 2), (day, 8, 2), (clock["h"], 11, 2), (clock["m"], 14, 2))
    for value, start, width in (*fields, (clock["s"], 17, 2), (clock["f"], 20, 9)):
        for place in range(width):
            text[..., start + place] += (value // 10 ** (width - 1 - place) % 10).astype(np.uint8)
    return text.view("S29")[..., 0]
