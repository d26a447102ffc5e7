"""
Envisat slows down
==================

The largest dead satellite in a low orbit, as laser ranging saw it in September 2013 (Kucharski et al.,
IEEE Trans. Geosci. Remote Sens. 52 (2014) 7651). Currents that the Earth's field induces brake it; the
growth of its period is that of Lin and Zhao (Adv. Space Res. 61 (2018) 182). Gravity's gradient turns
the momentum meanwhile.
"""

import matplotlib.pyplot as plt
import numpy as np

from attitude import Scene

document = Scene.builtin("envisat").model_dump(mode="json", exclude_unset=True)
document["times"] = {"start": 0.0, "stop": 7.0, "step": 0.01, "unit": "d"}
document["tolerance"] = {"value": 1e-8, "unit": "rad"}
ephemeris = Scene.model_validate(document).run()
days = ephemeris.elapsed / 86400.0
print(f"{ephemeris.plan.solver}; estimated error {ephemeris.plan.error_bound:.1e} rad")

momentum = np.linalg.norm(ephemeris.angular_momentum, axis=1)
spin = ephemeris.spin()
figure, (top, middle, bottom) = plt.subplots(3, 1, figsize=(8.0, 6.5), sharex=True, layout="constrained")
top.plot(days, 100.0 * (momentum / momentum[0] - 1.0), color="#000000")
top.set_ylabel("momentum, change in %")
middle.plot(days, np.rad2deg(spin.dec), color="#0072b2")
middle.set_ylabel("declination\nof the momentum, deg")
bottom.plot(days, ephemeris.angle("z", "nadir", "deg"), color="#d55e00", linewidth=0.4)
bottom.set(xlabel=f"days since {ephemeris.epoch.isot}", ylabel="z axis off nadir, deg")
top.set_title("Envisat, a week under eddy currents and gravity gradient")
plt.show()
