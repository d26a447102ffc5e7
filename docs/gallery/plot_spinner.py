"""
A spinner's nutation, from the numbers of a CCSDS message
=========================================================

An attitude message may state a spinner by the direction of its spin axis, its rate and its nutation
(CCSDS 504.0-B-2, SPIN/NUTATION). The scene takes the same numbers; the track of the spin axis about the
momentum follows.
"""

import matplotlib.pyplot as plt
import numpy as np

from attitude import Scene

scene = Scene.model_validate(
    {
        "body": {"moments": [199, 201, 262], "unit": "kg m2"},
        "epoch": {"time": "2026-01-01T00:00:00", "scale": "utc"},
        "frame": "EME2000",
        "spin": {
            "momentum": {"ra": 75.0, "dec": -62.0, "unit": "deg"},
            "nutation": {"value": 1.5, "unit": "deg"},
            "rate": {"value": 5.0, "unit": "rpm"},
        },
        "times": {"start": 0, "stop": 60, "step": 0.05, "unit": "s"},
    }
)
ephemeris = scene.run()
spin = ephemeris.spin()
axis = ephemeris.direction("z")

# %%
# Offsets of the spin axis from the momentum, towards east and north.
ra, dec = np.deg2rad([75.0, -62.0])
east = np.array([-np.sin(ra), np.cos(ra), 0.0])
north = np.array([-np.sin(dec) * np.cos(ra), -np.sin(dec) * np.sin(ra), np.cos(dec)])

figure, (left, right) = plt.subplots(1, 2, figsize=(9.0, 4.2), layout="constrained")
left.plot(np.rad2deg(axis @ east), np.rad2deg(axis @ north), linewidth=0.8, color="#0072b2")
left.plot(0.0, 0.0, "k+")
left.set(xlabel="east of the momentum, deg", ylabel="north, deg", title="track of the spin axis, 1 min")
left.set_aspect("equal")
right.plot(ephemeris.elapsed, np.rad2deg(spin.nutation), color="#d55e00")
right.set(xlabel="time, s", ylabel="nutation angle, deg", title="moments 199 and 201 differ: it breathes")
plt.show()
