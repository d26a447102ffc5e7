"""
1I/'Oumuamua: a light curve without a single period
===================================================

The interstellar visitor did not repeat its brightness: it tumbled. Belton et al. (Astrophysical Journal
Letters 856 (2018) L21) give for the long-axis mode a precession of the long axis in 8.67 h and a
rotation about it in 54.48 h. Here is a triaxial body of that kind as a light curve: an ellipsoid that
shines in proportion to the area it shows. Shape and viewing direction are chosen for the picture; the
periods are the observed ones.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import brentq

from attitude import RigidBody, TorqueFreeMotion

semi_axes = np.array([5.0, 1.0, 0.9])  # x is the long axis
a, b, c = semi_axes**2
moments = np.array([b + c, a + c, a + b]) / 5.0


def tumbling(nutation, momentum=1.0):
    """Its motion with the long axis that far from the momentum, at the start."""
    direction = np.array([np.cos(nutation), np.sin(nutation), 0.0])
    return TorqueFreeMotion(RigidBody(moments), [1, 0, 0, 0], momentum * direction / moments, order="wxyz")


def ratio(nutation):
    """Period of the rotation about the long axis over that of its precession."""
    motion = tumbling(nutation)
    return motion.polhode_period * motion.mean_precession_rate / (2.0 * np.pi)


# %%
# The ratio of the two periods decides how far the long axis is from the momentum.
nutation = brentq(lambda angle: ratio(angle) - 54.48 / 8.67, np.deg2rad(10.0), np.deg2rad(89.9))
unit = tumbling(nutation)
hours = np.linspace(0.0, 72.0, 4000)
scale = 2.0 * np.pi / unit.mean_precession_rate / 8.67  # seconds of the unit body in an hour
ephemeris = unit.at(hours * scale)
print(f"{unit.regime}; long axis {np.rad2deg(nutation):.1f} deg from the momentum")

# %%
# An ellipsoid seen from the unit direction e (body axes) shows the area pi a b c sqrt(sum (e_k / a_k)^2).
observer = np.array([0.85, 0.35, 0.4])
observer /= np.linalg.norm(observer)
seen = ephemeris.rotation.inv().apply(observer)
area = np.pi * semi_axes.prod() * np.linalg.norm(seen / semi_axes, axis=1)
magnitude = -2.5 * np.log10(area / area.max())

figure, axes = plt.subplots(figsize=(8.0, 3.6), layout="constrained")
axes.plot(hours, magnitude, color="#000000")
for turn in np.arange(0.0, 72.0, 8.67):
    axes.axvline(turn, color="0.85", zorder=0)
axes.invert_yaxis()
axes.set(
    xlabel="hours (lines: 8.67 h apart)",
    ylabel="magnitude, relative",
    title="a long-axis tumbler, 5 : 1 : 0.9",
)
plt.show()
