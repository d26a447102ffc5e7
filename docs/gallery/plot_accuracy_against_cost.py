"""
What accuracy costs in time
===========================

The same question of the same body, to the closed form and to integrators: error against a 50-digit
truth, and time, measured while this page was built. `attitude cost toutatis --plot FILE` prints and
draws the whole table, beside heyoka and Orekit where they are installed.
"""

import matplotlib.pyplot as plt

from attitude import Scene
from attitude.cost import measure

report = measure(
    Scene.builtin("toutatis"),
    budget=10.0,
    samples=2000,
    horizons=(1.0, 100.0),
    methods=["ours", "rk4", "dop853", "lsoda"],
)

figure, axes = plt.subplots(figsize=(8.0, 5.0), layout="constrained")
colours = ("#000000", "#cc79a7", "#d55e00", "#0072b2")
families = dict.fromkeys(cell.family for cell in report.cells)
for family, colour in zip(families, colours, strict=True):
    for horizon, marker in ((1.0, "o"), (100.0, "^")):
        cells = [cell for cell in report.at(horizon) if cell.family == family and cell.status == "measured"]
        if cells:
            axes.loglog(
                [cell.ns_per_sample for cell in cells],
                [cell.attitude_error_rad for cell in cells],
                marker,
                color=colour,
                linestyle="-",
                label=f"{family}, {horizon:g} polhode period{'s' if horizon > 1 else ''}",
            )
axes.set(
    xlabel="time a sample, ns", ylabel="largest attitude error, rad", title="4179 Toutatis, 2000 samples"
)
figure.legend(fontsize=8, ncols=2, loc="outside lower center")
plt.show()
