"""
Axes, and what the quaternion turns
===================================

The attitude quaternion is the active rotation from body to inertial: it carries the components of a
vector along the body's axes to its components along the inertial axes, :math:`v_{inertial} =
q\\,v_{body}\\,\\bar q`.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.spatial.transform import Rotation

attitude = Rotation.from_euler("ZYX", [40.0, -20.0, 25.0], degrees=True)
v_body = np.array([0.6, 0.7, 0.5])  # fixed in the body
v_inertial = attitude.apply(v_body)  # the same arrow, along the inertial axes
axis, angle = attitude.as_rotvec() / attitude.magnitude(), attitude.magnitude()
turning = Rotation.from_rotvec(np.linspace(0.0, angle, 60)[:, None] * axis)

figure = plt.figure(figsize=(7.5, 5.0))
axes = figure.add_axes((0.0, 0.0, 1.0, 0.9), projection="3d", computed_zorder=False)


def arrow(start, stop, color, name=""):
    """From one point to another, with a name beyond its tip."""
    step = stop - start
    axes.quiver(*start, *step, color=color, arrow_length_ratio=0.07 / np.linalg.norm(step), clip_on=False)
    axes.text(*(stop + 0.1 * step), name, color=color, ha="center", va="center")


for k, name in enumerate("XYZ"):
    unit = np.eye(3)[k]
    arrow(np.zeros(3), 1.2 * unit, "0.35", f"inertial {name}")
    arrow(np.zeros(3), attitude.apply(unit), "#0072b2", f"body {name.lower()}")  # column k of the matrix
    path = turning.apply(0.8 * unit)  # q carries the inertial axis to the body's
    axes.plot(*path.T, color="#009e73", linewidth=1.2, clip_on=False)
    arrow(path[-6], path[-1], "#009e73")
arrow(np.zeros(3), v_inertial, "#d55e00", "v")
axes.plot(*np.outer([0.0, 1.1], axis).T, color="#009e73", linestyle="--")
axes.text(*(1.2 * axis), f"axis of q: {np.rad2deg(angle):.0f} deg", color="#009e73", ha="center")
axes.set(xlim=(-0.3, 1.0), ylim=(-0.3, 1.0), zlim=(-0.1, 1.2), xticks=[], yticks=[], zticks=[])
axes.set_axis_off()
axes.set_box_aspect(None, zoom=1.25)
axes.view_init(28, 32)
axes.set_title("q turns the inertial axes into the body's: v_inertial = q v_body conj(q)")
plt.show()
