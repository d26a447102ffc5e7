"""
Polhodes: the regimes of free rotation
======================================

Seen from the body, the angular velocity of a free rotation runs along a closed curve, the polhode. So does
the direction of the angular momentum, which is drawn here. Two curves through the axis of intermediate
moment, the separatrix, divide the sphere: around the axis of greatest moment the motion is in short-axis
mode, around that of least moment in long-axis mode.
"""

import matplotlib.pyplot as plt
import numpy as np

from attitude import RigidBody, TorqueFreeMotion

# %%
# The regime of every motion is decided once, from the moments and the rate.
moments = np.array([1.0, 2.0, 3.0])
colours = {"short_axis": "#0072b2", "long_axis": "#d55e00", "separatrix": "#000000"}

elevation, azimuth = np.deg2rad([32.0, 40.0])
towards_us = np.array(
    [np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)]
)


def front(path):
    """The part of a curve on the sphere that faces us."""
    return np.where((path @ towards_us > 0.0)[:, None], path, np.nan)


figure = plt.figure(figsize=(6.5, 6.0))
axes = figure.add_subplot(projection="3d", computed_zorder=False)
seen = set()
for tilt in np.deg2rad([8, 18, 28, 34, 44, 54, 64, 74, 82]):
    for sign in (1, -1):
        momentum = np.array([np.sin(tilt), 0.0, sign * np.cos(tilt)])
        for direction in (momentum, momentum * [-1, 1, 1]):
            motion = TorqueFreeMotion(RigidBody(moments), [1, 0, 0, 0], direction / moments, order="wxyz")
            ephemeris = motion.at(np.linspace(0.0, motion.polhode_period, 400))
            path = ephemeris.angular_velocity * moments
            label = None if motion.regime in seen else motion.regime.replace("_", "-")
            seen.add(motion.regime)
            axes.plot(*front(path).T, color=colours[motion.regime], linewidth=1.0, label=label)

# the separatrix: both circles through the intermediate axis
angle = np.linspace(0.0, 2.0 * np.pi, 400)
for sign in (1, -1):
    normal = np.array([np.sqrt(1 / 1 - 1 / 2), 0.0, sign * np.sqrt(1 / 2 - 1 / 3)])
    normal /= np.linalg.norm(normal)
    across = np.cross(normal, [0.0, 1.0, 0.0])
    circle = np.outer(np.cos(angle), [0.0, 1.0, 0.0]) + np.outer(np.sin(angle), across)
    axes.plot(*front(circle).T, color="black", linestyle="--", label="separatrix" if sign > 0 else None)
for k, name in enumerate(("least", "intermediate", "greatest")):
    unit = np.eye(3)[k]
    axes.plot(*np.stack([unit, 1.15 * unit]).T, color="0.3")
    behind = {"facecolor": "white", "edgecolor": "none", "alpha": 0.85, "pad": 1.5}
    side = "left" if name == "intermediate" else "center"
    axes.text(*(1.3 * unit), f"{name}\nmoment", color="0.3", ha=side, va="center", bbox=behind)
axes.set_aspect("equal")
axes.set_axis_off()
axes.view_init(32, 40)
axes.set(xlim=(-0.75, 0.75), ylim=(-0.75, 0.75), zlim=(-0.75, 0.75))
axes.legend(loc="lower left")
axes.set_title("momentum direction in the body, moments 1 : 2 : 3")
plt.show()
