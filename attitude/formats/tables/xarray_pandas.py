"""Ephemerides as labelled arrays: xarray Dataset, pandas DataFrame."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import orjson

from ... import units
from ...errors import InputError
from ...pointing import vector_columns
from ...pointing.columns import COVARIANCES, ELEMENTS, VectorColumn
from ...runtime.optional_imports import needed
from ...samples.chunks import Samples
from ...samples.ephemeris_data import EphemerisData
from .. import columnar, schema

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

# Axes along which the components of a Dataset's variables are; the frame's where they are not named.
AXES = {"quaternion": "body to inertial"} | dict.fromkeys(("angular_velocity", *COVARIANCES), "body axes")


def to_xarray(ephemeris: EphemerisData) -> xr.Dataset:
    """See `Ephemeris.to_xarray`."""
    xarray = needed("xarray", "to_xarray", "tables")
    # dimensions, numbered where there are several
    bodies = ["body" if i == 0 else f"body_{i}" for i in range(len(ephemeris.batch_shape))]
    count = len(ephemeris.instants.shape)
    times = ["time"] if count == 1 else [f"time_{i}" for i in range(count)]
    variables: dict[str, Any] = {}
    components: dict[str, list[Any]] = {}
    for column in vector_columns.vectors(ephemeris):
        attributes, values = {"units": column.unit or "1"}, column.values.copy(order="K")
        dimension = _of_components(column)
        components |= dimension
        if not dimension:
            values = values[..., 0]
        elif "euler_angle" not in dimension:
            attributes["axes"] = AXES.get(column.label, "inertial axes")
        variables[column.label] = ((*bodies, *times, *dimension), values, attributes)
    return xarray.Dataset(variables, {**_times(ephemeris, times), **components}, _attributes(ephemeris))


def _of_components(column: VectorColumn) -> dict[str, list[Any]]:
    """The dimension of a variable's components and their labels; none of one number an instant."""
    if len(column.names) == 1:
        return {}
    if column.names is vector_columns.QUATERNION:
        return {"quaternion_component": list("wxyz")}
    if len(column.names) == len(ELEMENTS):
        return {"element": list(ELEMENTS)}
    return {"euler_angle": [1, 2, 3]} if column.label.startswith("euler") else {"axis": list("xyz")}


def _attributes(ephemeris: EphemerisData) -> dict[str, Any]:
    """The metadata as netCDF attributes, nested ones as JSON, without None."""
    meta = schema.metadata(Samples.of(ephemeris))
    del meta["shape"]
    epoch = meta.pop("epoch")
    if epoch is not None:
        days = [epoch["jd1"], epoch["jd2"]]
        meta |= {"epoch": epoch["time"], "epoch_scale": epoch["scale"], "epoch_jd": days}
    nested = {name: orjson.dumps(meta[name]).decode() for name in ("body", "events") if meta.get(name)}
    return {name: value for name, value in (meta | nested).items() if value is not None}


def _times(ephemeris: EphemerisData, dimensions: list[str]) -> dict[str, Any]:
    """Coordinates: seconds since the epoch, in one part or two; dates, if 64 bits can hold them."""
    attributes = {"units": "s", "long_name": "SI seconds since the epoch"}
    coordinates: dict[str, Any] = {"elapsed": (dimensions, ephemeris.elapsed, attributes)}
    attributes = {"units": "s", "long_name": "rounding error of elapsed, which is one double"}
    coordinates["elapsed_rest"] = (dimensions, ephemeris.instants.low, attributes)
    dates = _dates(ephemeris)
    if dates is not None:
        coordinates["time"] = (dimensions, dates, {"long_name": columnar.MEANING, "scale": "tai"})
    return coordinates


def _dates(ephemeris: EphemerisData) -> np.ndarray | None:
    """TAI, datetime64[ns]; None of an ephemeris without dates, or with some that 64 bits cannot hold."""
    if ephemeris.epoch is None:
        return None
    if ephemeris.elapsed.size and not columnar.can_hold(ephemeris.epoch, *units.extremes(ephemeris.elapsed)):
        return None
    return columnar.nanoseconds(ephemeris.instants, ephemeris.epoch)


def to_pandas(ephemeris: EphemerisData) -> pd.DataFrame:
    """See `Ephemeris.to_pandas`."""
    pandas = needed("pandas", "to_pandas", "tables")
    if ephemeris.batch_shape or len(ephemeris.instants.shape) != 1:
        expected = "one body at a list of instants, for the rows of a frame; to_xarray takes any"
        raise InputError("ephemeris", f"shape {ephemeris.shape}", expected)
    names = [name for name in schema.names(Samples.of(ephemeris)) if name != schema.TIME]
    table = schema.columns(ephemeris, names)
    dates = _dates(ephemeris)
    if dates is not None:
        index = pandas.DatetimeIndex(dates, name=columnar.TIME_TAI)
    else:
        index = pandas.Index(table.pop(schema.ELAPSED).copy(), name=schema.ELAPSED)
    frame = pandas.DataFrame(table, index)
    frame.attrs = schema.metadata(Samples.of(ephemeris))
    return frame
