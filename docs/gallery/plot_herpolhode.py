"""
Herpolhode: the angular velocity in space
=========================================

The tip of the angular velocity stays in a plane normal to the angular momentum (Poinsot). Its path
there, the herpolhode, is closed only where the two periods of the motion are commensurate. Body: NASA's
tumbling brick, check case 2 of NASA/TM-2015-218675.
"""

import matplotlib.pyplot as plt
import numpy as np

from attitude import Scene

motion = Scene.builtin("nasa-brick").motion()
ephemeris = motion.at(np.linspace(0.0, 12.0 * motion.polhode_period, 6000))
rate = ephemeris.rotation.apply(ephemeris.angular_velocity)  # along the inertial axes

momentum = ephemeris.rotation.apply(ephemeris.angular_momentum)[0]
third = momentum / np.linalg.norm(momentum)
first = np.cross(third, [0.0, 0.0, 1.0])
first /= np.linalg.norm(first)
x, y = rate @ first, rate @ np.cross(third, first)

# %%
# The component along the momentum is constant, 2 E / L; that is the plane.
along = rate @ third
print(f"spread of the component along the momentum: {np.ptp(along) / along[0]:.1e}")

figure, axes = plt.subplots(figsize=(6.0, 6.0), layout="constrained")
axes.plot(np.rad2deg(x), np.rad2deg(y), linewidth=0.7, color="#0072b2")
axes.plot(0.0, 0.0, "k+")
axes.set(
    xlabel="across the momentum, deg/s",
    ylabel="across the momentum, deg/s",
    title="herpolhode, 12 polhode periods",
)
axes.set_aspect("equal")
plt.show()
