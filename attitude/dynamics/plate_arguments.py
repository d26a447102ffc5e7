"""Plates and sources of torques as the march between edges reads them (`kernels.solvers.plate_layout`)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from ..kernels import layout
from ..kernels.gauss_legendre import gauss_scheme
from ..kernels.solvers import plate_layout
from ..kernels.solvers.plate_layout import ARC_NODES
from ..problem.initial_state import InitialState, Spin
from ..problem.torque_model import CachedTorque
from .momentum import nutation_rates

PLATES = (layout.SOLAR_PLATE, layout.DRAG_PLATE)


@dataclass(frozen=True)
class PlateArguments:
    """What the march reads of n bodies.

    Attributes
    ----------
    constant : (n, 3) N m, torques that are constant in the body
    pace : (n,) 1/s2, square of the rate at which torques and losses change the motion
    plates : (n, P, PLATE_WIDTH); base : (n, S, FORM_WIDTH); sources : (n, S, SOURCE_WIDTH)
    user_rows : (n, U, EFFECT_WIDTH)
    cuts : (c,) s, where arcs end besides at edges; lights : (c + 1, S), of the sources between them
    air : (m, AIR_WIDTH), pieces of the density, to which sources refer
    """

    constant: np.ndarray
    pace: np.ndarray
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
    """Sort the rows of the effects (n, k, EFFECT_WIDTH) into sources, their forms, and plates.

    body : (n, STEPPED_BODY); air : as of PlateArguments
    """
    n = len(body)
    codes = rows[0, :, 0].astype(int)
    sources: list[np.ndarray] = []
    forms: list[np.ndarray] = []
    plates: list[np.ndarray] = []
    keys: dict[bytes, int] = {}
    for k, code in enumerate(codes):
        if code in (layout.CONSTANT_BODY, layout.USER):
            continue
        row = rows[:, k]
        if code in PLATES:
            source = row.copy()
            source[:, 1 : 8 if code == layout.DRAG_PLATE else 10] = 0.0
            key = source[0].tobytes()
            if key not in keys:
                keys[key] = len(sources)
                sources.append(source)
                forms.append(np.zeros((n, plate_layout.FORM_WIDTH)))
            plates.append(_plate(row, keys[key]))
        else:
            sources.append(row)
            forms.append(_form(row, body))
    cuts, lights = _lights(template, torques, [source[0] for source in sources])
    return PlateArguments(
        rows[:, codes == layout.CONSTANT_BODY, 1:4].sum(axis=1),
        _pace(torques, body),
        np.stack(plates, axis=1) if plates else np.zeros((n, 0, plate_layout.PLATE_WIDTH)),
        np.stack(forms, axis=1) if forms else np.zeros((n, 0, plate_layout.FORM_WIDTH)),
        np.stack(sources, axis=1) if sources else np.zeros((n, 0, plate_layout.SOURCE_WIDTH)),
        np.ascontiguousarray(rows[:, codes == layout.USER]),
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


def _pace(torques: Sequence[CachedTorque], body: np.ndarray) -> np.ndarray:
    """(n,) 1/s2: torques that depend on no spin, over the least moment; eddies and nutation, squared."""
    moments = body[:, layout.MOMENTS : layout.MOMENTS + 3]
    still = Spin(np.zeros(len(body)), np.zeros(len(body)))
    size = sum((torque.sizes(moments, still) for torque in torques), np.zeros(len(body)))
    least = moments.min(axis=1)
    eddies = np.abs(body[:, layout.EDDIES : layout.EDDIES + 9]).max(axis=1)
    nutation = nutation_rates(moments, body[:, layout.ROTORS : layout.ROTORS + 3])
    return np.asarray(size / least + (eddies / least) ** 2 + nutation**2)


def _plate(row: np.ndarray, source: int) -> np.ndarray:
    """(n, PLATE_WIDTH), of rows (n, EFFECT_WIDTH)."""
    plate = np.zeros((len(row), plate_layout.PLATE_WIDTH))
    plate[:, plate_layout.SOURCE] = source
    plate[:, plate_layout.NORMAL : plate_layout.NORMAL + 3] = row[:, 1:4]
    plate[:, plate_layout.CENTRE : plate_layout.CENTRE + 3] = row[:, 4:7]
    plate[:, plate_layout.ALONG] = row[:, 7]
    if row[0, 0] == layout.SOLAR_PLATE:
        area, specular, diffuse = row[:, 7:10].T
        plate[:, plate_layout.ALONG] = area * (1.0 - specular)
        plate[:, plate_layout.SCATTERED] = 2.0 / 3.0 * area * diffuse
        plate[:, plate_layout.MIRRORED] = 2.0 * area * specular
    return plate


def _form(row: np.ndarray, body: np.ndarray) -> np.ndarray:
    """(n, FORM_WIDTH): torque of a source without plates for a strength of 1."""
    form, code = np.zeros((len(row), plate_layout.FORM_WIDTH)), row[0, 0]
    if code == layout.GRAVITY_GRADIENT:  # e x I e
        I1, I2, I3 = body[:, layout.MOMENTS : layout.MOMENTS + 3].T
        quadratic = form[:, plate_layout.QUADRATIC :].reshape(-1, 3, 6)
        quadratic[:, 0, 5], quadratic[:, 1, 4], quadratic[:, 2, 3] = I3 - I2, I1 - I3, I2 - I1
    elif code == layout.CONSTANT_INERTIAL:
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
    lights = np.full((between.size, len(sources)), float(plate_layout.FULL_STRENGTH))
    for k, source in enumerate(sources):
        if source[0] == layout.SOLAR_PLATE and source[plate_layout.SHADOW] in passages:
            passage = passages[int(source[plate_layout.SHADOW])]
            lights[:, k] = passage.kinds[np.searchsorted(passage.edges, between)]
    return cuts, lights


@cache
def scheme() -> np.ndarray:
    """(SCHEME_ROWS * ARC_NODES,): the workspace with Gauss's scheme of eight nodes, order 16, in its layout.

    As the solver's (`solver.scheme`); a sum of Legendre polynomials becomes one of powers by whole numbers.
    """
    n = ARC_NODES
    gauss = gauss_scheme(n)
    powers = np.zeros((n, n), np.longdouble)
    for i in range(n):
        powers[i, : i + 1] = np.polynomial.legendre.leg2poly(np.eye(n)[i])[: i + 1]
    work = np.zeros((plate_layout.SCHEME_ROWS, n))
    work[plate_layout.AT], work[plate_layout.WEIGHTS] = 0.5 * (1.0 + gauss.nodes), gauss.weights
    work[plate_layout.MATRIX : plate_layout.MATRIX + n] = gauss.to_coefficients @ gauss.integrals
    work[plate_layout.TO_POWERS : plate_layout.TO_POWERS + n] = gauss.to_coefficients @ powers
    work[plate_layout.AT_END] = gauss.to_coefficients.sum(axis=1)
    work.flags.writeable = False
    return work.reshape(-1)
