"""
Sun windows of a tumbler
========================

When does a face of a dead satellite look at the Sun? Envisat tumbled as laser ranging saw it in September
2013 (Kucharski et al., IEEE Trans. Geosci. Remote Sens. 52 (2014) 7651). Over 110 minutes, a little more
than an orbit, the windows are the intervals in which the body's x axis is within 45 degrees of the Sun
and the satellite is outside the Earth's penumbra. They are found on the motion itself, not between
samples, so that none is missed.
"""

import matplotlib.pyplot as plt
import numpy as np
from astropy import units as u

from attitude import Scene
from attitude.windows import angle, in_shadow

document = Scene.builtin("envisat").document()
document["times"] = {"start": 0, "stop": 110, "step": 0.05, "unit": "min"}
document["tolerance"] = {"value": 1e-6, "unit": "rad"}
scene = Scene.model_validate(document)
ephemeris = scene.run()
near_sun = angle("x", to="sun") < 45 * u.deg
sunlit = ~in_shadow("penumbra")
rows = {"both": near_sun & sunlit, "x near the Sun": near_sun, "in sunlight": sunlit}
windows = {name: scene.crossings(condition) for name, condition in rows.items()}
print(f"both: {windows['both']}")

# %%
# The curve is the angle; each bar below it is a window.
figure, (curve, timeline) = plt.subplots(
    2, 1, figsize=(8.0, 5.0), sharex=True, height_ratios=(3, 2), layout="constrained"
)
curve.plot(ephemeris.elapsed / 60.0, ephemeris.angle("x", "sun", "deg"), color="#0072b2", linewidth=0.9)
curve.axhline(45.0, color="#000000", linestyle="--", linewidth=0.9)
curve.set(ylabel="x axis to the Sun, deg", title="Envisat: when its x axis sees the Sun")
for row, found in enumerate(windows.values()):
    bars = np.stack([found.start.seconds, found.duration], axis=1) / 60.0
    timeline.broken_barh(bars, (row - 0.35, 0.7), color=("#009e73", "#0072b2", "#e69f00")[row])
timeline.set(xlabel=f"minutes since {ephemeris.epoch.isot}", yticks=range(len(rows)), yticklabels=list(rows))
timeline.grid(visible=False, axis="y")
plt.show()
