"""
Dzhanibekov's flip
==================

A body that spins almost about its axis of intermediate moment turns over, again and again, at instants
that are known exactly: half periods of the elliptic functions.
"""

import matplotlib.pyplot as plt
import numpy as np

from attitude import Scene

scene = Scene.builtin("dzhanibekov")
motion = scene.motion()
ephemeris = motion.at(np.linspace(0.0, 240.0, 4001))
print(f"{motion.regime}, period of the flips {motion.polhode_period / 2:.3f} s")

figure, (top, bottom) = plt.subplots(2, 1, figsize=(8.0, 5.0), sharex=True, layout="constrained")
for k, colour in enumerate(("#d55e00", "#009e73", "#0072b2")):
    top.plot(ephemeris.elapsed, ephemeris.angular_velocity[:, k], color=colour, label="xyz"[k])
top.set_ylabel("body rate, rad/s")
top.legend(title="axis", loc="upper left", bbox_to_anchor=(1.0, 1.0))
bottom.plot(ephemeris.elapsed, ephemeris.angle("y", "momentum", "deg"), color="#d55e00")
bottom.set(xlabel="time, s", ylabel="y axis to momentum, deg", yticks=[0, 45, 90, 135, 180])
top.set_title("spin beside the axis of intermediate moment")
plt.show()
