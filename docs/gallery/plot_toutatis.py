"""
4179 Toutatis, 34 years after its radar images
==============================================

Radar saw the asteroid tumble in 1992 (state and moments: Takahashi, Busch and Scheeres, Astronomical
Journal 146 (2013) 95). Free rotation is solved in closed form, so an instant in 2026 costs as much as
one in 1992. What the answer cannot know is said too: a deviation of 0.1 % of the moments turns the body
by more than a revolution meanwhile.
"""

import matplotlib.pyplot as plt
import numpy as np
from astropy import units as u
from astropy.time import Time

from attitude import Scene

motion = Scene.builtin("toutatis").motion()
figure, (left, right) = plt.subplots(1, 2, figsize=(9.0, 4.2), sharey=True, layout="constrained")
for axes, start in ((left, "1992-12-01"), (right, "2026-11-21")):
    days = np.linspace(0.0, 20.0, 2000)
    ephemeris = motion.at(Time(start, scale="tdb") + days * u.day)
    for axis, colour in zip("xyz", ("#d55e00", "#009e73", "#0072b2"), strict=True):
        axes.plot(days, ephemeris.direction(axis)[:, 2], color=colour, label=f"{axis} axis")
    axes.set(xlabel=f"days from {start}", ylim=(-1.05, 1.05))
left.set_ylabel("component along the ecliptic pole")
figure.legend(*left.get_legend_handles_labels(), loc="outside lower center", ncols=3)
figure.suptitle("where the axes of Toutatis point")
print(f"bound on the error of the arithmetic: {ephemeris.plan.error_bound:.1e} rad")
plt.show()
