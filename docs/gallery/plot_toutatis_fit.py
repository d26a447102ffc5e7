"""
Toutatis fitted from its radar images
=====================================

Radar saw 4179 Toutatis on seventeen days of December 1992 (attitudes and rates: Takahashi, Busch and
Scheeres, Astronomical Journal 146 (2013) 95). A free rotation is fitted to the attitudes alone: eight
numbers, by least squares with exact partial derivatives. The rates that radar measured were not used, and
are a check: two of them, of 12-07 and 12-14, are off by 44 and 46 deg/d.
"""

import warnings

import matplotlib.pyplot as plt
import numpy as np
from astropy.time import Time

from attitude import AttitudeWarning, fit
from attitude.estimation.fit_document import read_observations

epoch = Time("1992-12-10T17:20:00", scale="utc")
attitudes, rates = read_observations("../examples/toutatis-radar.csv")
with warnings.catch_warnings():
    warnings.simplefilter("ignore", AttitudeWarning)  # the radar's own standard deviations are not known
    result = fit(attitudes, absolute_sigma=False, epoch=epoch)
for name, value, sigma in zip(result.names[6:8], result.values[6:8], result.sigma[6:8], strict=True):
    print(f"{name} {value:.3f} +- {sigma:.3f} of the least")

# %%
# Residuals of the attitudes, and the angular velocity that the fit foretells beside the measured one.
days = result.residuals[0].seconds / 86400.0
dense = np.linspace(days.min(), days.max(), 2000)
foretold = np.rad2deg(result.motion.at(dense * 86400.0).angular_velocity) * 86400.0
apart = np.rad2deg(result.residuals[0].sizes)

figure, (top, bottom) = plt.subplots(2, 1, figsize=(8.0, 6.0), sharex=True, layout="constrained")
top.bar(days, apart, width=0.25, color="0.4")
top.set(ylabel="residual of the attitude, deg", title=f"rms {np.sqrt(np.mean(apart**2)):.2f} deg")
for k, colour in enumerate(("#d55e00", "#009e73", "#0072b2")):
    bottom.plot(dense, foretold[:, k], color=colour, linewidth=1.0, label="xyz"[k])
    bottom.plot(days, np.rad2deg(np.asarray(rates.rate)[:, k]) * 86400.0, "o", color=colour, markersize=4)
bottom.set(xlabel="days from 1992-12-10T17:20 UTC", ylabel="rate, deg/d (dots: radar)")
figure.legend(*bottom.get_legend_handles_labels(), loc="outside lower center", ncols=3)
plt.show()
