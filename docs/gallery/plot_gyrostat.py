"""
A wheel keeps a satellite from flipping
=======================================

Rotation about the axis of middle moment is unstable; a wheel along that axis with enough momentum makes
it stable (Hughes, Spacecraft Attitude Dynamics, 2004, chapter 6: here more than 4 N m s). The motion of
a body with constant rotors has a closed form too, so both are exact.
"""

import matplotlib.pyplot as plt
import numpy as np

from attitude import Scene

document = Scene.builtin("gyrostat").document()
figure, axes = plt.subplots(figsize=(8.0, 4.0), layout="constrained")
for momentum, colour in ((0.0, "#d55e00"), (3.5, "#000000"), (4.5, "#009e73"), (8.0, "#0072b2")):
    wheels = {"type": "wheels", "momentum": {"value": [0, momentum, 0], "unit": "N m s"}}
    ephemeris = Scene.model_validate(document | {"effects": [wheels] if momentum else []}).run()
    tilt = np.rad2deg(np.arccos(np.clip(ephemeris.direction("y") @ [0.0, 1.0, 0.0], -1.0, 1.0)))
    axes.plot(ephemeris.elapsed, tilt, color=colour, label=f"{momentum:g} N m s")
    print(f"{momentum:g} N m s: {ephemeris.plan.solver}")
axes.set(
    xlabel="time, s",
    ylabel="y axis from its first direction, deg",
    title="wheel along the axis of middle moment",
)
axes.legend(title="wheel")
plt.show()
