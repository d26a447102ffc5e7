"""Plates and sources of torques as the march between edges reads them (`kernels.solvers.plate_layout`)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from ..kernels.gauss_legendre import gauss_scheme
from ..kernels.layout import BodyRow, EffectCode, EffectRow, SolarRow
from ..kernels.solvers.plate_layout import ARC_NODES, ArcRow, FormRow, Light, PlateRow
from ..problem.initial_state import InitialState, Spin
from ..problem.torque_model import CachedTorque
from .momentum import nutation_rates

PLATES = (EffectCode.SOLAR_PLATE, EffectCode.DRAG_PLATE)


@dataclass(frozen=True)
class PlateArguments:
    """What the march reads of n bodies.

    Attributes
    ----------
    constant : (n, 3) N m, torques that are constant in the body
    squared_rates : (n,) 1/s2, square of the rate at which torques and losses change the motion
    plates : (n, P, PlateRow.WIDTH); base : (n, S, FormRow.WIDTH); sources : (n, S, EffectRow.WIDTH)
    user_rows : (n, U, EffectRow.WIDTH)
    cuts : (c,) s, where arcs end besides at edges; lights : (c + 1, S), of the sources between them
    air : (m, AirPiece.WIDTH), pieces of the density, to which sources refer
    """

    constant: np.ndarray
    squared_rates: np.ndarray
    plates: np.ndarray
    base: np.ndarray
    sources: np.ndarray
    user_rows: np.ndarray
    cuts: np.ndarray
    lights: np.ndarray
    air: np.ndarray


def plate_arguments(
    template: InitialState,
    torques: Sequence[CachedTorque],
    body: np.ndarray,
    rows: np.ndarray,
    air: np.ndarray,
) -> PlateArguments:
    """Sort the rows of the effects (n, k, EffectRow.WIDTH) into sources, their forms, and plates.

    body : (n, BodyRow.WIDTH); air : as of PlateArguments
    """
    n = len(body)
    codes = rows[0, :, 0].astype(int)
    sources: list[np.ndarray] = []
    forms: list[np.ndarray] = []
    plates: list[np.ndarray] = []
    keys: dict[bytes, int] = {}
    for k, code in enumerate(codes):
        if code in (EffectCode.CONSTANT_BODY, EffectCode.USER):
            continue
        row = rows[:, k]
        if code in PLATES:
            source = row.copy()
            source[:, 1 : 8 if code == EffectCode.DRAG_PLATE else 10] = 0.0
            key = source[0].tobytes()
            if key not in keys:
                keys[key] = len(sources)
                sources.append(source)
                forms.append(np.zeros((n, FormRow.WIDTH)))
            plates.append(_plate(row, keys[key]))
        else:
            sources.append(row)
            forms.append(_form(row, body))
    cuts, lights = _lights(template, torques, [source[0] for source in sources])
    return PlateArguments(
        rows[:, codes == EffectCode.CONSTANT_BODY, 1:4].sum(axis=1),
        _squared_rates(torques, body),
        np.stack(plates, axis=1) if plates else np.zeros((n, 0, PlateRow.WIDTH)),
        np.stack(forms, axis=1) if forms else np.zeros((n, 0, FormRow.WIDTH)),
        np.stack(sources, axis=1) if sources else np.zeros((n, 0, EffectRow.WIDTH)),
        np.ascontiguousarray(rows[:, codes == EffectCode.USER]),
        cuts,
        lights,
        air,
    )


def edges_per_turn(torques: Sequence[CachedTorque]) -> int:
    """About how often in a turn of the body plates turn their edges to wind or Sun, opposite ones as one."""
    rows = [row.round(12) for torque in torques for row in torque.own_rows if row[0] in PLATES]
    planes = set()
    for row in rows:
        sign = 1.0 if tuple(row[1:4]) > (0.0, 0.0, 0.0) else -1.0
        planes.add((row[0], *(sign * row[1:4] + 0.0)))
    return 2 * len(planes)


def _squared_rates(torques: Sequence[CachedTorque], body: np.ndarray) -> np.ndarray:
    """(n,) 1/s2: torques that depend on no spin, over the least moment; eddies and nutation, squared."""
    moments = body[:, BodyRow.MOMENTS : BodyRow.MOMENTS + 3]
    still = Spin(np.zeros(len(body)), np.zeros(len(body)))
    size = sum((torque.sizes(moments, still) for torque in torques), np.zeros(len(body)))
    least = moments.min(axis=1)
    eddies = np.abs(body[:, BodyRow.EDDIES : BodyRow.EDDIES + 9]).max(axis=1)
    nutation = nutation_rates(moments, body[:, BodyRow.ROTORS : BodyRow.ROTORS + 3])
    return np.asarray(size / least + (eddies / least) ** 2 + nutation**2)


def _plate(row: np.ndarray, source: int) -> np.ndarray:
    """(n, PlateRow.WIDTH), of rows (n, EffectRow.WIDTH)."""
    plate = np.zeros((len(row), PlateRow.WIDTH))
    plate[:, PlateRow.SOURCE] = source
    plate[:, PlateRow.NORMAL : PlateRow.NORMAL + 3] = row[:, 1:4]
    plate[:, PlateRow.CENTRE : PlateRow.CENTRE + 3] = row[:, 4:7]
    plate[:, PlateRow.ALONG] = row[:, 7]
    if row[0, 0] == EffectCode.SOLAR_PLATE:
        area, specular, diffuse = row[:, 7:10].T
        plate[:, PlateRow.ALONG] = area * (1.0 - specular)
        plate[:, PlateRow.SCATTERED] = 2.0 / 3.0 * area * diffuse
        plate[:, PlateRow.MIRRORED] = 2.0 * area * specular
    return plate


def _form(row: np.ndarray, body: np.ndarray) -> np.ndarray:
    """(n, FormRow.WIDTH): torque of a source without plates for a strength of 1."""
    form, code = np.zeros((len(row), FormRow.WIDTH)), row[0, 0]
    if code == EffectCode.GRAVITY_GRADIENT:  # e x I e
        I1, I2, I3 = body[:, BodyRow.MOMENTS : BodyRow.MOMENTS + 3].T
        quadratic = form[:, FormRow.QUADRATIC :].reshape(-1, 3, 6)
        quadratic[:, 0, 5], quadratic[:, 1, 4], quadratic[:, 2, 3] = I3 - I2, I1 - I3, I2 - I1
    elif code == EffectCode.CONSTANT_INERTIAL:
        form[:, 0] = form[:, 4] = form[:, 8] = 1.0
    else:  # the body's dipole x field
        x, y, z = row[:, 1:4].T
        form[:, 1], form[:, 2], form[:, 3] = -z, y, z
        form[:, 5], form[:, 6], form[:, 7] = -x, -y, x
    return form


def _lights(
    template: InitialState, torques: Sequence[CachedTorque], sources: Sequence[np.ndarray]
) -> tuple[np.ndarray, np.ndarray]:
    """Cuts of the span, and which light each source has between them."""
    each = [torque.passages(template) for torque in torques]
    passages = {one.shadow: one for one in each if one is not None}
    air = [profile for torque in torques if (profile := torque.air(template)) is not None]
    cuts_of = [*(one.cuts for one in passages.values()), *(profile.cuts for profile in air)]
    cuts = np.unique(np.concatenate([np.zeros(0), *cuts_of]))
    ends = np.concatenate([cuts[:1] - 2.0, cuts, cuts[-1:] + 2.0]) if cuts.size else np.zeros(2)
    between = 0.5 * (ends[1:] + ends[:-1])
    lights = np.full((between.size, len(sources)), float(Light.FULL))
    for k, source in enumerate(sources):
        if source[0] == EffectCode.SOLAR_PLATE and source[SolarRow.SHADOW] in passages:
            passage = passages[int(source[SolarRow.SHADOW])]
            lights[:, k] = passage.kinds[np.searchsorted(passage.edges, between)]
    return cuts, lights


@cache
def scheme() -> np.ndarray:
    """(ArcRow.SOURCES * ARC_NODES,): the workspace with Gauss's scheme of eight nodes, order 16, in its rows.

    As the solver's (`solver.scheme`); a sum of Legendre polynomials becomes one of powers by whole numbers.
    """
    n = ARC_NODES
    gauss = gauss_scheme(n)
    powers = np.zeros((n, n), np.longdouble)
    for i in range(n):
        powers[i, : i + 1] = np.polynomial.legendre.leg2poly(np.eye(n)[i])[: i + 1]
    work = np.zeros((ArcRow.SOURCES, n))
    work[ArcRow.NODE], work[ArcRow.WEIGHT] = 0.5 * (1.0 + gauss.nodes), gauss.weights
    work[ArcRow.MATRIX : ArcRow.MATRIX + n] = gauss.to_coefficients @ gauss.integrals
    work[ArcRow.TO_POWERS : ArcRow.TO_POWERS + n] = gauss.to_coefficients @ powers
    work[ArcRow.AT_END] = gauss.to_coefficients.sum(axis=1)
    work.flags.writeable = False
    return work.reshape(-1)
