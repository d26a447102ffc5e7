"""Attitudes under gravity gradient along orbits of every form, against DOP853 along the same orbits.

    python -m tests.benchmarks.torque_orbits [BODIES [SEED]]          (astropy, sgp4; spiceypy for SPK)

Elements, a table of positions, an OEM, an STK ephemeris, an SPK (all of one ellipse, which the truth has
exactly), and two TLEs (which it has from sgp4 and astropy).  Random
bodies, spinning and at rest, tolerances from 1e-10 to 1e-4 rad, a revolution forwards or backwards.
A line for each form: scenes, refused, errors above the bound, the greatest error and the median bound.
"""

from __future__ import annotations

import sys
import tempfile
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from astropy import units as u
from astropy.coordinates import GCRS, TEME, CartesianRepresentation
from astropy.time import Time, TimeDelta
from numpy.polynomial import Chebyshev
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from attitude import AttitudeError, Scene
from tests.effects.test_orbit import TLES, satellite, start_of
from tests.formats import orbit_texts as texts

SPAN, ROWS = 5400.0, np.arange(-6000.0, 6001.0, 60.0)
TRUTH = 3e-12  # rad, of DOP853 itself
Position = Callable[[float], np.ndarray]


def spk(path: Path) -> str:
    """The rows as an SPK of type 9, of degree 9."""
    import spiceypy as spice

    seconds = (texts.EPOCH + ROWS * u.s).tdb
    et = (seconds.jd1 - 2451545.0) * 86400.0 + seconds.jd2 * 86400.0
    states = np.concatenate(texts.state(ROWS), axis=1) / 1e3
    handle = spice.spkopn(str(path), "x", 0)
    spice.spkw09(handle, -999, 399, "J2000", et[0], et[-1], "ours", 9, len(et), states, et)
    spice.spkcls(handle)
    return str(path)


def forms(folder: Path) -> dict[str, tuple[dict[str, Any], str, str, Position]]:
    """Orbit, epoch (UTC), frame and position in m at s since the epoch, by name."""
    table = {
        "times": {"value": ROWS.tolist(), "unit": "s"},
        "positions": {"value": texts.state(ROWS)[0].tolist(), "unit": "m"},
    }
    ellipse: dict[str, Any] = {
        "semi_major_axis": {"value": texts.A, "unit": "m"},
        "eccentricity": texts.E,
        "inclination": {"value": texts.TILT, "unit": "rad"},
    }
    mu = {"mu": {"value": texts.MU, "unit": "m3/s2"}}
    of_rows = {
        "elements": ellipse | mu | {"radius": {"value": 6378137.0, "unit": "m"}},
        "table": table | mu,
        "OEM": {"oem": texts.oem(texts.oem_segment(ROWS))} | mu,
        "STK": {"stk": texts.stk(ROWS)} | mu,
        "SPK": {"file": spk(folder / "x.bsp")} | mu,
    }
    made = {
        name: (orbit, texts.EPOCH.isot, "ICRF" if name == "SPK" else "EME2000", exact)
        for name, orbit in of_rows.items()
    }
    for name, lines in TLES.items():
        made[f"TLE, {name}"] = {"tle": list(lines)}, start_of(lines).isot, "GCRF", along(lines)
    return made


def exact(t: float) -> np.ndarray:
    return texts.state(np.array([t]))[0][0]


def along(lines: tuple[str, ...]) -> Position:
    """Positions of SGP4 in GCRS by astropy, on a polynomial between Chebyshev's nodes."""

    def nodes(t: np.ndarray) -> np.ndarray:
        made, epoch = satellite(lines), Time(start_of(lines).isot, scale="utc")
        since = t + (epoch.tai - start_of(lines).tai).sec
        _, teme, _ = made.sgp4_array(np.full(t.size, made.jdsatepoch), made.jdsatepochF + since / 86400.0)
        when = (epoch.tai + TimeDelta(t, format="sec")).utc
        there = TEME(CartesianRepresentation(teme.T * u.km), obstime=when).transform_to(GCRS(obstime=when))
        return np.asarray(there.cartesian.xyz.to_value(u.m)).T

    middle = np.linspace(-SPAN, SPAN, 301)
    fit = [Chebyshev.fit(middle, nodes(middle)[:, k], 90, domain=[-SPAN, SPAN]) for k in range(3)]
    return lambda t: np.array([polynomial(t) for polynomial in fit])


def truth(document: dict[str, Any], mu: float, position: Position, seconds: np.ndarray) -> np.ndarray:
    """(n, 4) wxyz at seconds from the epoch outwards, by DOP853."""
    moments = np.array(document["body"]["moments"])

    def slope(t: float, y: np.ndarray) -> np.ndarray:
        w, v, rate = y[0], y[1:4], y[4:]
        r = position(t)
        twice = -2.0 * np.cross(v, r)
        e = (r + w * twice - np.cross(v, twice)) / np.linalg.norm(r)
        torque = 3.0 * mu / np.linalg.norm(r) ** 3 * np.cross(e, moments * e)
        spun = (torque - np.cross(rate, moments * rate)) / moments
        return np.concatenate([[-0.5 * v @ rate], 0.5 * (w * rate + np.cross(v, rate)), spun])

    start = [*document["attitude"]["quaternion"], *document["angular_velocity"]["value"]]
    found = solve_ivp(slope, (0.0, seconds[-1]), start, "DOP853", seconds, rtol=3e-14, atol=1e-15)
    q = found.y[:4].T
    return np.asarray(q / np.linalg.norm(q, axis=1)[:, None])


def drawn(rng: np.random.Generator, orbit: dict[str, Any], epoch: str, frame: str) -> dict[str, Any]:
    moments = 1.0 + rng.uniform(0.0, 0.9, 3)
    if rng.integers(3) == 0:
        moments[1] = moments[0]
    rate = rng.normal(size=3) * (0.0 if rng.integers(4) == 0 else 10.0 ** rng.uniform(-3.5, -2.0))
    seconds = np.linspace(0.0, SPAN if rng.integers(2) else -SPAN, 6)
    return {
        "body": {"moments": moments.tolist(), "unit": "kg m2"},
        "epoch": {"time": epoch, "scale": "utc"},
        "frame": frame,
        "attitude": {
            "quaternion": Rotation.random(rng=rng).as_quat(scalar_first=True).tolist(),
            "order": "wxyz",
        },
        "angular_velocity": {"value": rate.tolist(), "unit": "rad/s"},
        "times": {"elapsed": seconds.tolist(), "unit": "s"},
        "effects": [{"type": "gravity_gradient"}],
        "orbit": orbit,
        "tolerance": {"value": 10.0 ** rng.uniform(-10, -4), "unit": "rad"},
    }


def main(count: int = 12, seed: int = 7) -> None:
    warnings.simplefilter("ignore")
    print("| | scenes | refused | above | greatest error, rad | median bound, rad |\n" + "|---" * 6 + "|")
    with tempfile.TemporaryDirectory() as folder:
        for name, (orbit, epoch, frame, position) in forms(Path(folder)).items():
            rng, told, refused, above = np.random.default_rng(seed), list[tuple[float, float]](), 0, 0
            floor = TRUTH if not name.startswith("TLE") else 3e-11  # what astropy's way to GCRS leaves
            for _ in range(count):
                document = drawn(rng, orbit, epoch, frame)
                scene = Scene.model_validate(document)
                try:
                    run = scene.run()
                except AttitudeError as error:
                    print(name, error)
                    refused += 1
                    continue
                path = scene.initial_state().orbit_path
                assert path is not None
                seconds = np.array(document["times"]["elapsed"])
                q, p = truth(document, path.central.mu, position, seconds), run.quaternion("wxyz")
                cross = p[:, :1] * q[:, 1:] - q[:, :1] * p[:, 1:] - np.cross(p[:, 1:], q[:, 1:])
                error = 2.0 * np.arcsin(np.minimum(1.0, np.linalg.norm(cross, axis=1))).max()
                assert run.plan is not None
                bound = run.plan.error_bound or 0.0
                if error > bound + floor:
                    above += 1
                    print(f"{name}: {error:.1e} > {bound:.1e}: {document}")
                told.append((error, bound))
            errors, bounds = np.transpose(told)
            figures = f"{refused} | {above} | {errors.max():.1e} | {np.median(bounds):.1e}"
            print(f"| {name} | {count} | {figures} |", flush=True)


if __name__ == "__main__":
    main(*(int(argument) for argument in sys.argv[1:]))
