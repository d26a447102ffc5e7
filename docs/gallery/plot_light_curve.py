"""
Light curve of a tumbling box
=============================

A box of flat faces that scatter as Lambert's law says, lit by the Sun and seen at a phase angle of 50
degrees: each face gives its area times the cosine of the light's incidence times that of the view, where
both are positive. (No shadows of one face on another, which a box does not have, no specular glints, no
limb; real surfaces differ.)
"""

import matplotlib.pyplot as plt
import numpy as np

from attitude import RigidBody, TorqueFreeMotion

size = np.array([4.0, 2.0, 1.0])  # m
moments = (
    np.array([size[1] ** 2 + size[2] ** 2, size[0] ** 2 + size[2] ** 2, size[0] ** 2 + size[1] ** 2]) / 12.0
)
normals = np.concatenate([np.eye(3), -np.eye(3)])
areas = np.tile([size[1] * size[2], size[0] * size[2], size[0] * size[1]], 2)

motion = TorqueFreeMotion(RigidBody(moments), [1, 0, 0, 0], np.deg2rad([1.0, 0.6, 0.3]), order="wxyz")
ephemeris = motion.at(np.linspace(0.0, 1800.0, 6001))
minutes = ephemeris.elapsed / 60.0

# %%
# Sun and observer stand still in space; along the body's axes they turn.
phase = np.deg2rad(50.0)
to_sun = np.array([1.0, 0.0, 0.0])
to_observer = np.array([np.cos(phase), np.sin(phase), 0.0])
into_body = ephemeris.rotation.inv()
incidence = into_body.apply(to_sun) @ normals.T
emission = into_body.apply(to_observer) @ normals.T
flux = (areas * np.clip(incidence, 0.0, None) * np.clip(emission, 0.0, None)).sum(axis=1)

figure, axes = plt.subplots(figsize=(8.0, 3.6), layout="constrained")
axes.plot(minutes, flux / flux.max(), color="#000000")
axes.set(
    xlabel="minutes", ylabel="light, of the greatest", title="a tumbling box, 4 : 2 : 1, phase angle 50 deg"
)
precession = 2.0 * np.pi / motion.mean_precession_rate
print(f"polhode period {motion.polhode_period / 60:.2f} min, precession {precession / 60:.2f} min")
plt.show()
