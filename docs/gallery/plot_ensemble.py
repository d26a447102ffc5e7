"""
How fast a prediction spreads
=============================

Toutatis again, with moments known to 2 %, the rate to 0.1 deg/d and the attitude to a degree: ten
thousand bodies that agree with that, and how far they are from their mean. Each of them is exact;
nothing is linearised.
"""

import matplotlib.pyplot as plt
import numpy as np

from attitude import Scene
from attitude.ensemble import Ensemble

bodies = Ensemble.sample(
    Scene.builtin("toutatis"), n=10_000, seed=7, moments="2 %", angular_velocity="0.1 deg/d", attitude="1 deg"
)
days = np.linspace(0.0, 40.0, 401)
statistics = bodies.statistics(days * 86400.0)

figure, axes = plt.subplots(figsize=(8.0, 4.0), layout="constrained")
for k, colour in enumerate(("#d55e00", "#009e73", "#0072b2")):
    axes.plot(days, np.rad2deg(statistics.deviation[:, k]), color=colour, label=f"{'xyz'[k]} axis")
axes.set(xlabel="days", ylabel="standard deviation, deg", title="spread of the direction of each body axis")
axes.legend()
plt.show()
