"""
A box thrown up that meets the ground
=====================================

Gravity does not turn a free body: until a corner meets the ground, the simulated attitude is that of the
closed form. At the contact the momentum jumps, and the closed form goes on as if there were no ground.
`attitude plot drop` draws the same, with a fall without gravity beside it.
"""

import matplotlib.pyplot as plt

from attitude import Scene

scene = Scene.builtin("drop")
with_ground = scene.run()
free = scene.motion().at(with_ground.elapsed)
contact = next(event for event in with_ground.events if event.kind == "contact")

figure, axes = plt.subplots(figsize=(8.0, 4.2), layout="constrained")
for k, (name, colour) in enumerate(zip("wxyz", ("#000000", "#d55e00", "#009e73", "#0072b2"), strict=True)):
    axes.plot(with_ground.elapsed, with_ground.quaternion("wxyz")[:, k], color=colour, label=f"q_{name}")
    axes.plot(free.elapsed, free.quaternion("wxyz")[:, k], "--", color=colour, linewidth=0.8)
axes.axvline(contact.seconds, color="0.4", linestyle=":")
axes.text(contact.seconds, 1.02, f"contact, {contact.seconds:.3f} s", ha="center")
axes.set(xlabel="time, s", ylabel="attitude", ylim=(-1.05, 1.12))
axes.legend(ncols=4, loc="lower left")
axes.set_title("solid: gravity and ground; dashed: closed form", pad=12)
before = with_ground.elapsed < contact.seconds
apart = (with_ground.rotation[before] * free.rotation[before].inv()).magnitude().max()
print(f"largest difference before the contact: {apart:.1e} rad")
plt.show()
