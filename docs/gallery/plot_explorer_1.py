"""
Explorer 1 goes into a flat spin
================================

Spun about its long axis, the axis of least moment, the first American satellite lost energy in its
flexible antennas and after one orbit tumbled end over end (Bracewell and Garriott, Nature 182 (1958)
760): rotation about the axis of greatest moment has the least energy for a given momentum.
"""

import matplotlib.pyplot as plt
import numpy as np

from attitude import Scene

ephemeris = Scene.builtin("explorer-1").run()
minutes = ephemeris.elapsed / 60.0
energy = ephemeris.kinetic_energy

figure, (top, bottom) = plt.subplots(2, 1, figsize=(8.0, 5.0), sharex=True, layout="constrained")
top.plot(minutes, ephemeris.angle("z", "momentum", "deg"), color="#0072b2")
top.set(ylabel="long axis to momentum, deg", yticks=[0, 30, 60, 90])
bottom.semilogy(minutes, energy, color="#d55e00")
bottom.set(xlabel="minutes after the spin-up", ylabel="kinetic energy, J")
top.set_title("Explorer 1: nutation grows as energy is lost, the momentum stays")
momentum = np.linalg.norm(ephemeris.angular_momentum, axis=1)
print(f"momentum: {momentum[0]:.6f} ... {momentum[-1]:.6f} N m s")
plt.show()
