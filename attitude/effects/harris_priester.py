"""The static model of Harris and Priester with its diurnal bulge, for mean solar activity."""

from __future__ import annotations

import math
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from ..documents.fields import Number
from ..frames.celestial import sun_at
from ..problem.initial_state import InitialState
from ..times.instants import Instants
from .earth_atmosphere import EarthAtmosphere, along_pole, celestial_positions, geodetic

LAG = math.radians(30.0)  # of the bulge behind the Sun, about the Earth's axis

# Altitude, km, and the least and greatest density there, g/km3 (1e-12 kg/m3), at mean solar activity.
# Source: Montenbruck & Gill, Satellite Orbits (2000), table 3.8, after Harris & Priester (1962).
TABLE = """
100 497400 497400; 120 24900 24900; 130 8377 8710; 140 3899 4059; 150 2122 2215; 160 1263 1344;
170 800.8 875.8; 180 528.3 601.0; 190 361.7 429.7; 200 255.7 316.2; 210 183.9 239.6; 220 134.1 185.3;
230 99.49 145.5; 240 74.88 115.7; 250 57.09 93.08; 260 44.03 75.55; 270 34.30 61.82; 280 26.97 50.95;
290 21.39 42.26; 300 17.08 35.26; 320 10.99 25.11; 340 7.214 18.19; 360 4.824 13.37; 380 3.274 9.955;
400 2.249 7.492; 420 1.558 5.684; 440 1.091 4.355; 460 0.7701 3.362; 480 0.5474 2.612; 500 0.3916 2.042;
520 0.2819 1.605; 540 0.2042 1.267; 560 0.1488 1.005; 580 0.1092 0.7997; 600 0.08070 0.6390;
620 0.06012 0.5123; 640 0.04519 0.4121; 660 0.03430 0.3325; 680 0.02632 0.2691; 700 0.02043 0.2185;
720 0.01607 0.1779; 740 0.01281 0.1452; 760 0.01036 0.1190; 780 0.008496 0.09776; 800 0.007069 0.08059;
840 0.004680 0.05741; 880 0.003200 0.04210; 920 0.002210 0.03130; 960 0.001560 0.02360; 1000 0.001150 0.01810
"""
# m, kg/m3
ALTITUDES, LEAST, GREATEST = np.transpose([row.split() for row in TABLE.split(";")]).astype(float) * [
    [1e3],
    [1e-12],
    [1e-12],
]


class HarrisPriester(EarthAtmosphere):
    """`{"model": "harris_priester", "exponent": 4}`: a density that bulges 30 degrees behind the Sun.

    The least density of an altitude, and the greatest at the bulge's apex; between these the power `exponent`
    of the cosine of half the angle from it: about 2 for equatorial orbits, 6 for polar ones.
    """

    model: Literal["harris_priester"]
    exponent: Annotated[Number, Field(ge=2.0, le=6.0)] = 4.0

    def levels(self) -> np.ndarray:
        """The altitudes of the table, m."""
        return ALTITUDES

    def log_densities(self, initial_state: InitialState, t: np.ndarray) -> np.ndarray:
        """(n,) on the orbit at instants (n,), s since the epoch."""
        r = along_pole(initial_state, t, celestial_positions(initial_state, t))
        to_sun = along_pole(initial_state, t, sun_at(Instants(t, None, initial_state.epoch)))
        return log_density(r, to_sun, self.exponent)

    def name(self) -> str:
        """The model and its exponent, for plans."""
        return f"harris_priester (mean solar activity, exponent {self.exponent:g})"


def log_density(r: np.ndarray, to_sun: np.ndarray, exponent: float) -> np.ndarray:
    """(n,), of kg/m3, at positions r, (n, 3) m, the Sun at (n, 3); axes whose third is the pole.

    rho = least + (greatest - least) cos^exponent(psi / 2), psi the angle from the apex, which is LAG behind
    the Sun; both are exponential between altitudes of the table.
    Source: Montenbruck & Gill, Satellite Orbits (2000), section 3.5.2.
    """
    altitude = geodetic(r)[2]
    least, greatest = (np.exp(np.interp(altitude, ALTITUDES, np.log(rho))) for rho in (LEAST, GREATEST))
    x, y, z = to_sun.T
    c, s = math.cos(LAG), math.sin(LAG)
    apex = np.stack([c * x - s * y, s * x + c * y, z], axis=1)
    lengths = np.sqrt((apex**2).sum(axis=1) * (r**2).sum(axis=1))
    bulge = np.maximum(0.0, 0.5 + 0.5 * (r * apex).sum(axis=1) / lengths) ** (0.5 * exponent)
    return np.asarray(np.log(least + (greatest - least) * bulge))
