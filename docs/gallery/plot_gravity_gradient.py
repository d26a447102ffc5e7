"""
Captured by gravity
===================

A long cylinder tumbles slowly in its orbit; a damper brakes it until gravity's gradient holds its long
axis along the vertical (body of the textbook case of pitch libration, Hughes, Spacecraft Attitude
Dynamics, 2004, chapter 9).
"""

import matplotlib.pyplot as plt

from attitude import Scene

ephemeris = Scene.builtin("gravity-gradient-capture").run()
figure, axes = plt.subplots(figsize=(8.0, 3.8), layout="constrained")
axes.plot(ephemeris.elapsed / 3600.0, ephemeris.angle("z", "nadir", "deg"), color="#0072b2", linewidth=0.8)
axes.set(xlabel="hours", ylabel="long axis off nadir, deg", yticks=[0, 45, 90, 135, 180])
axes.set_title("a cylinder of 10 m in an orbit at 600 km, with a damper of 0.25 N m s")
plt.show()
