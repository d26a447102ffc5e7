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

attitude = Rotation.from_euler("ZYX", [75.0, -15.0, 25.0], degrees=True)
v_body = np.array([0.9, 0.3, 0.5])  # fixed in the body
v_inertial = attitude.apply(v_body)  # the same arrow, along the inertial axes

figure = plt.figure(figsize=(7.5, 6.0))
axes = figure.add_subplot(projection="3d", computed_zorder=False)
for k, name in enumerate("XYZ"):
    unit = np.eye(3)[k]
    axes.quiver(0, 0, 0, *(1.2 * unit), color="0.35", arrow_length_ratio=0.08)
    axes.text(*(1.3 * unit), f"inertial {name}", color="0.35")
    turned = attitude.apply(unit)  # column k of the rotation matrix
    axes.quiver(0, 0, 0, *turned, color="#0072b2", arrow_length_ratio=0.08)
    axes.text(*(1.08 * turned), f"body {name.lower()}", color="#0072b2")
axes.quiver(0, 0, 0, *v_inertial, color="#d55e00", arrow_length_ratio=0.08)
axes.text(*(1.05 * v_inertial), "v", color="#d55e00", fontsize=13)

# the rotation itself: about its axis, by its angle
axis, angle = attitude.as_rotvec() / attitude.magnitude(), attitude.magnitude()
start = np.cross(axis, [0.0, 0.0, 1.0])
turns = Rotation.from_rotvec(np.linspace(0.0, angle, 60)[:, None] * axis)
arc = turns.apply(0.45 * start / np.linalg.norm(start)) + 0.6 * axis
axes.plot(*arc.T, color="#009e73")
axes.quiver(*arc[-2], *(6.0 * (arc[-1] - arc[-2])), color="#009e73", arrow_length_ratio=1.5)
axes.plot(*np.outer([0.0, 1.1], axis).T, color="#009e73", linestyle="--")
axes.text(*(1.15 * axis), f"q: {np.rad2deg(angle):.0f} deg about this axis", color="#009e73")
axes.set(xlim=(-0.4, 1.1), ylim=(-0.4, 1.1), zlim=(-0.2, 1.2), xticks=[], yticks=[], zticks=[])
axes.set_axis_off()
axes.view_init(28, 40)
axes.set_title("attitude q: from the body's axes to the inertial axes")
plt.show()
