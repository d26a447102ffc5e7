"""Frames that CKs are relative to: SPICE's built-in inertial frames, and those fixed to them.

Source: NAIF, frames required reading, and the definitions in CHGIRF of SPICELIB.  SPICE's J2000 is the ICRF.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ...errors import FormatError
from ...frames.earth_orientation import ARCSECOND
from ...frames.rotations import off_orthonormal

# By their numbers: name, frame that the axes are rotated from, and angles in arcseconds and axes; the matrix
# to the frame's components is the product of the rotations of axes in this order.
BUILT_IN = {
    1: ("J2000", 1, ()),
    2: ("B1950", 1, ((1152.84248596724, 3), (-1002.26108439117, 2), (1153.04066200330, 3))),
    3: ("FK4", 2, ((0.525, 3),)),
    4: ("DE-118", 2, ((0.53155, 3),)),
    5: ("DE-96", 2, ((0.4107, 3),)),
    6: ("DE-102", 2, ((0.1359, 3),)),
    7: ("DE-108", 2, ((0.4775, 3),)),
    8: ("DE-111", 2, ((0.5880, 3),)),
    9: ("DE-114", 2, ((0.5529, 3),)),
    10: ("DE-122", 2, ((0.5316, 3),)),
    11: ("DE-125", 2, ((0.5754, 3),)),
    12: ("DE-130", 2, ((0.5247, 3),)),
    13: ("GALACTIC", 3, ((1177200.0, 3), (225360.0, 1), (1016100.0, 3))),
    14: ("DE-200", 1, ((0.0, 3),)),
    15: ("DE-202", 1, ((0.0, 3),)),
    16: ("MARSIAU", 1, ((324000.0, 3), (133610.4, 2), (-152348.4, 3))),
    17: ("ECLIPJ2000", 1, ((84381.448, 1),)),
    18: ("ECLIPB1950", 2, ((84404.836, 1),)),
    19: ("DE-140", 1, ((1152.71013777252, 3), (-1002.25042010533, 2), (1153.75719544491, 3))),
    20: ("DE-142", 1, ((1152.72061453864, 3), (-1002.25052830351, 2), (1153.74663857521, 3))),
    21: ("DE-143", 1, ((1153.03919093833, 3), (-1002.24822382286, 2), (1153.42900222357, 3))),
}
NUMBERS = {name: number for number, (name, _, _) in BUILT_IN.items()}
CLASSES = {
    2: "turns with a planet (class 2)",
    3: "is that of another CK (class 3)",
    5: "is dynamic (class 5)",
}
MAX_DEPTH = 20  # frames that are fixed to each other, one after the other


def built_in_matrix(number: int) -> np.ndarray:
    """(3, 3): from components in the ICRF to components in one of SPICE's inertial frames."""
    _, base, steps = BUILT_IN[number]
    matrix = np.eye(3)
    for angle, axis in reversed(steps):
        matrix = _rotation_of_axes(angle * ARCSECOND, axis) @ matrix
    return matrix if base == number else matrix @ built_in_matrix(base)


def _rotation_of_axes(angle: float, axis: int) -> np.ndarray:
    """Matrix to components along axes that are rotated about one of them, 1 to 3: SPICE's [angle]_axis."""
    j, k = axis % 3, (axis + 1) % 3
    matrix = np.eye(3)
    matrix[[j, k], [j, k]] = np.cos(angle)
    matrix[j, k], matrix[k, j] = np.sin(angle), -np.sin(angle)
    return matrix


def matrix_from_icrf(number: int, kernel: dict[str, list[Any]], source: str) -> np.ndarray:
    """(3, 3): from components in the ICRF to components in a frame, built in or fixed in a frame kernel.

    kernel : variables of the frame kernel, or none

    Raises FormatError for a frame that neither has, or that is not fixed to an inertial one.
    """
    matrix = np.eye(3)
    for _ in range(MAX_DEPTH):
        if number in BUILT_IN:
            return matrix @ built_in_matrix(number)
        if not kernel.get(f"FRAME_{number}_NAME"):
            known = ", ".join(f"{n} ({entry[0]})" for n, entry in BUILT_IN.items())
            cure = f"a frame that a frame kernel defines needs fk=, and built in are {known}"
            raise FormatError(f"relative to SPICE's frame {number}; {cure}", source)
        name = str(kernel[f"FRAME_{number}_NAME"][0]).strip("'")
        stated = kernel.get(f"FRAME_{number}_CLASS", [0.0])[0]
        frame_class = int(stated) if isinstance(stated, float) else 0
        if frame_class != 4:
            reason = CLASSES.get(frame_class, f"is of class {frame_class}")
            raise FormatError(f"relative to SPICE's frame {number} ({name}), which {reason}", source)
        try:
            step, base = _fixed_to(number, name, kernel)
        except (KeyError, IndexError, TypeError, ValueError):
            raise FormatError(f"no complete definition of frame {number} ({name}) in fk=", source) from None
        matrix, number = matrix @ step.T, base
    raise FormatError(f"more than {MAX_DEPTH} frames, each fixed to the next, in fk=", source)


def _fixed_to(number: int, name: str, kernel: dict[str, list[Any]]) -> tuple[np.ndarray, int]:
    """Matrix from components in a frame to those in the one that it is fixed to, and that one's number."""

    def values(variable: str) -> list[Any]:
        return kernel.get(f"TKFRAME_{number}_{variable}") or kernel[f"TKFRAME_{name}_{variable}"]

    base = str(values("RELATIVE")[0]).strip("'")
    base_number = NUMBERS[base] if base in NUMBERS else int(kernel[f"FRAME_{base}"][0])
    kind = str(values("SPEC")[0]).strip("'").upper()
    if kind == "MATRIX":
        matrix = np.array(values("MATRIX"), dtype=float).reshape(3, 3).T
    elif kind == "QUATERNION":
        w, x, y, z = np.array(values("Q"), dtype=float) / np.linalg.norm(np.array(values("Q"), dtype=float))
        cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        matrix = np.eye(3) + 2.0 * (w * cross + cross @ cross)
    elif kind == "ANGLES":
        unit = {"DEGREES": np.pi / 180, "RADIANS": 1.0, "ARCSECONDS": ARCSECOND}
        factor = unit[str(values("UNITS")[0]).strip("'").upper()]
        matrix = np.eye(3)
        for angle, axis in zip(values("ANGLES"), values("AXES"), strict=True):
            matrix = matrix @ _rotation_of_axes(float(angle) * factor, int(axis))
    else:
        raise ValueError(kind)
    if not off_orthonormal(matrix) <= 1e-6:
        raise ValueError("no rotation")
    u, _, vh = np.linalg.svd(matrix)
    return u @ vh, base_number
