"""
A CubeSat in low orbit: drag, sunlight and gravity
==================================================

A 3U CubeSat of six flat plates at 400 km, slowly tumbling. Each edge that a plate turns to the wind or
to the Sun, and each passage through the shadow, is found as a root; between them the torque is smooth.
The scene names the effects that it calls for, and nothing else is simulated: here is what each of them
is worth.
"""

import matplotlib.pyplot as plt
import numpy as np

from attitude import Scene

size = np.array([0.1, 0.1, 0.34])  # m
offset = np.array([0.003, 0.0, 0.02])  # of the centre of mass from the middle, m


def plates(**surface):
    """The six faces, each an area with its normal and its centre from the centre of mass."""
    for k in range(3):
        for sign in (1.0, -1.0):
            normal = sign * np.eye(3)[k]
            centre = 0.5 * size * normal - offset
            area = np.delete(size, k).prod()
            yield {
                "normal": normal.tolist(),
                "centre": {"value": centre.tolist(), "unit": "m"},
                "area": {"value": area, "unit": "m2"},
                **surface,
            }


gravity = {"type": "gravity_gradient"}
drag = {
    "type": "drag",
    "plates": list(plates(coefficient=2.2)),
    "density": {"value": 3e-12, "unit": "kg/m3"},
    "reference_altitude": {"value": 400, "unit": "km"},
    "scale_height": {"value": 58, "unit": "km"},
}
sunlight = {
    "type": "solar_pressure",
    "plates": list(plates(specular=0.1, diffuse=0.2)),
    "sun": "astropy",
    "shadow": True,
}
document = {
    "body": {"moments": [0.0333, 0.034, 0.0067], "unit": "kg m2"},
    "epoch": {"time": "2026-06-01T00:00:00", "scale": "utc"},
    "frame": "GCRF",
    "attitude": {"quaternion": [1, 0, 0, 0], "order": "wxyz"},
    "angular_velocity": {"value": [0.5, 0.3, -0.2], "unit": "deg/s"},
    "times": {"start": 0, "stop": 6, "step": 0.01, "unit": "h"},
    "orbit": {"altitude": {"value": 400, "unit": "km"}, "inclination": {"value": 51.6, "unit": "deg"}},
}


def momentum_of(effects):
    ephemeris = Scene.model_validate(document | {"effects": effects}).run()
    print(f"{len(effects)} effects: {ephemeris.plan.solver}, error {ephemeris.plan.error_bound:.1e} rad")
    return ephemeris.elapsed / 3600.0, np.linalg.norm(ephemeris.angular_momentum, axis=1)


figure, axes = plt.subplots(figsize=(8.0, 4.0), layout="constrained")
cases = {
    "gravity gradient": [gravity],
    "and drag": [gravity, drag],
    "and sunlight": [gravity, drag, sunlight],
}
for (name, effects), colour in zip(cases.items(), ("#000000", "#d55e00", "#0072b2"), strict=True):
    hours, momentum = momentum_of(effects)
    style = "--" if name == "and sunlight" else "-"
    axes.plot(hours, 100.0 * (momentum / momentum[0] - 1.0), style, color=colour, label=name)
axes.set(xlabel="hours", ylabel="angular momentum, change in %", title="3U CubeSat at 400 km")
axes.legend()
plt.show()
