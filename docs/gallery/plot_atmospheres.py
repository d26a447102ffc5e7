"""
Densities of the air side by side
=================================

Drag takes its density from a constant, an exponential, a table over the altitude, or one of two models of
the Earth's thermosphere: Harris-Priester, whose bulge follows the Sun, and NRLMSISE-00, which also depends on
latitude, season and solar activity. Here are all of them on the same orbits, and what they make of the same
CubeSat: the choice of the model matters far more than any error of the integration.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.spatial.transform import Rotation

from attitude import Scene
from attitude.effects import density_profile
from attitude.orbit.path_states import position

RADIUS = 6378.1  # km
altitudes = np.array([150, 200, 250, 300, 350, 400, 450, 500, 600, 700, 800, 900, 1000])  # km
# U.S. Standard Atmosphere, 1976, table I
standard = [
    *(2.076e-9, 2.541e-10, 6.073e-11, 1.916e-11, 7.014e-12, 2.803e-12, 1.184e-12, 5.215e-13),
    *(1.137e-13, 3.070e-14, 1.136e-14, 5.759e-15, 3.561e-15),
]


def quantity(value, unit):
    return {"value": value, "unit": unit}


exponential = {
    "density": quantity(2.803e-12, "kg/m3"),
    "reference_altitude": quantity(400, "km"),
    "scale_height": quantity(58.5, "km"),
}
models = {
    "exponential": exponential,
    "table (US 1976)": {
        "density": {
            "altitudes": quantity(altitudes.tolist(), "km"),
            "densities": quantity(standard, "kg/m3"),
        }
    },
    "harris_priester": {"density": {"model": "harris_priester", "exponent": 4}},
    "nrlmsise00": {"density": {"model": "nrlmsise00", "f107": 150, "f107_average": 150, "ap": 12}},
}
# %%
# The same body everywhere: one plate that is not before the centre of mass.
plate = {"area": quantity(0.034, "m2"), "normal": [1, 0, 0], "centre": quantity([0.05, 0, -0.02], "m")}
document = {
    "body": {"moments": [0.0067, 0.0333, 0.0340], "unit": "kg m2"},
    "epoch": {"time": "2026-03-20T12:00:00", "scale": "utc"},
    "frame": "GCRF",
    "attitude": {"quaternion": [1, 0, 0, 0], "order": "wxyz"},
    "angular_velocity": quantity([1.0, 0.7, -0.4], "deg/s"),
    "times": {"start": 0, "stop": 184, "step": 1, "unit": "min"},
    "tolerance": "best",
}
circle = {"altitude": quantity(400, "km"), "inclination": quantity(51.6, "deg")}
ellipse = {
    "semi_major_axis": quantity(RADIUS + 500, "km"),
    "eccentricity": 300 / (RADIUS + 500),
    "inclination": quantity(51.6, "deg"),
}


def density(name, orbit, t):
    """Altitude above a sphere, km, and density, kg/m3, at seconds t on an orbit."""
    drag = {"type": "drag", "plates": [plate], **models[name]}
    scene = Scene.model_validate(document | {"orbit": orbit, "effects": [drag]})
    state = scene.initial_state()
    altitude = 1e-3 * np.linalg.norm(position(state.orbit_path, t), axis=1) - RADIUS
    profile = scene.effects[0].air(state)
    if profile is None:
        return altitude, 2.803e-12 * np.exp(-(altitude - 400) / 58.5)
    return altitude, density_profile.evaluate(profile, t)


# %%
# Along a circle at 400 km, and along an ellipse from 200 to 800 km.
figure, (left, right) = plt.subplots(1, 2, figsize=(9.0, 4.2), layout="constrained")
t = np.arange(0.0, 11000.0, 20.0)
print(f"{'model':18}{'least':>12}{'mean':>12}{'greatest, kg/m3, at 400 km':>28}")
for name, colour in zip(models, ("#000000", "#e69f00", "#0072b2", "#d55e00"), strict=True):
    _, rho = density(name, circle, t)
    print(f"{name:18}{rho.min():12.3g}{rho.mean():12.3g}{rho.max():28.3g}")
    left.plot(t / 60.0, 1e12 * rho, color=colour, label=name)
    altitude, rho = density(name, ellipse, np.arange(0.0, 5677.0, 10.0))
    right.semilogx(rho, altitude, color=colour, label=name)
left.set(xlabel="minutes", ylabel="density, 1e-12 kg/m3", title="Circle at 400 km", ylim=(0, None))
right.set(xlabel="density, kg/m3", ylabel="altitude, km", title="Ellipse from 200 to 800 km")
left.legend()
plt.show()

# %%
# What the models make of the attitude after three hours: the angle from the answer under the exponential, and
# the bound on the error of each integration.
attitudes = {}
for name, air in models.items():
    drag = {"type": "drag", "plates": [plate], **air}
    run = Scene.model_validate(document | {"orbit": circle, "effects": [drag]}).run()
    attitudes[name] = Rotation.from_quat(run.quaternion("wxyz")[-1], scalar_first=True)
    angle = (attitudes["exponential"].inv() * attitudes[name]).magnitude()
    print(f"{name:18} {np.degrees(angle):6.1f} deg, error bound {run.plan.error_bound:.1e} rad")
