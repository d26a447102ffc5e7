"""The vectors of an ephemeris as columns: what it holds, or what users choose, with units in the names."""

from __future__ import annotations

from collections.abc import Collection, Iterator

import numpy as np

from ..frames import rotations
from ..samples.ephemeris_data import EphemerisData
from .columns import UNCERTAINTY, VectorColumn, derived, layout
from .targets import orbit_state

QUATERNION = ("q_w", "q_x", "q_y", "q_z")
RATE = ("omega_x_rad_s", "omega_y_rad_s", "omega_z_rad_s")
POSITION = ("position_x_m", "position_y_m", "position_z_m")
VELOCITY = ("velocity_x_m_s", "velocity_y_m_s", "velocity_z_m_s")
MOMENTUM = ("momentum_x_N_m_s", "momentum_y_N_m_s", "momentum_z_N_m_s")
# Vectors by their labels: the names of the components, and the unit.
VECTORS = {
    "quaternion": (QUATERNION, ""),
    "angular_velocity": (RATE, "rad/s"),
    "angular_momentum": (MOMENTUM, "N m s"),
    "position": (POSITION, "m"),
    "velocity": (VELOCITY, "m/s"),
}

# The uncertainty belongs to the motion: its columns are known, and reading a file leaves them aside.
KNOWN_VECTORS = VECTORS | {
    label: (names, unit) for request in UNCERTAINTY for label, names, unit in layout(request)
}
NOT_READ = frozenset(name for label in KNOWN_VECTORS.keys() - VECTORS for name in KNOWN_VECTORS[label][0])


def vectors(ephemeris: EphemerisData, names: Collection[str] | None = None) -> Iterator[VectorColumn]:
    """Each vector that the ephemeris holds, not copied, or those that its `columns` ask for, in their order.

    The momentum only where it is not inertia times rate.  Of what has to be computed, only that of which some
    column is among the names, if any are given.

    Raises InputError or RegimeError where what is asked for is not known of this ephemeris.
    """
    held = {
        "quaternion": ephemeris.attitude,
        "angular_velocity": None if ephemeris.rate is None else ephemeris.computed_rate,
        "angular_momentum": ephemeris.momentum,
        **(ephemeris.centre_of_mass._asdict() if ephemeris.centre_of_mass is not None else {}),
    }
    own = {
        label: VectorColumn(label, *VECTORS[label], held[label])
        for label in VECTORS
        if held.get(label) is not None
    }
    if not ephemeris.columns:
        yield from own.values()
        is_uncertain = ephemeris.uncertainty is not None and ephemeris.frame not in rotations.TURNING_FRAMES
        for request in UNCERTAINTY if is_uncertain else ():
            yield from derived(ephemeris, request)
    for request in ephemeris.columns:
        described = (VECTORS[request],) if request in VECTORS else (each[1:] for each in layout(request))
        if request in own:
            yield own[request]
        elif names is not None and not any(name in names for columns, _ in described for name in columns):
            continue
        elif request in ("position", "velocity"):  # of its orbit
            vector = orbit_state(ephemeris)[request == "velocity"]
            vectors_of = np.broadcast_to(vector, (*ephemeris.shape, 3))
            yield VectorColumn(request, *VECTORS[request], vectors_of)
        elif request in VECTORS:  # of rate and inertia
            yield VectorColumn(request, *VECTORS[request], np.asarray(getattr(ephemeris, request)))
        else:
            yield from derived(ephemeris, request)
