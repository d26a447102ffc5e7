"""Attitudes along tables of positions against those along the elements they were made of: a table for docs.

usage: python tests/benchmarks/orbit_tables.py
"""

import sys
import time
import warnings
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))

from tests.effects import test_orbit_tables as cases

# rows: (step, decimals of a metre, decimals of m/s or None)
ROWS = ((60.0, 3, None), (200.0, 3, None), (400.0, 3, None), (60.0, 0, None), (60.0, 3, 6), (400.0, 3, 6))


def measure(step, decimals, velocity_decimals):
    """(error, bound, seconds of reading the document and making the path, seconds of the run)."""
    document = cases.table(cases.steps(step), *cases.LOW, decimals, velocity_decimals)
    made = cases.scene(document, cases.DAY)
    made.run()
    begun = time.process_time()
    cases.scene(document, cases.DAY).initial_state()
    path, begun = time.process_time() - begun, time.perf_counter()
    ephemeris = made.run()
    run = time.perf_counter() - begun
    truth = cases.scene(cases.elements(*cases.LOW), cases.DAY).run()
    return cases.apart(ephemeris, truth), ephemeris.plan.error_bound, path, run


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    print("| rows each | rounded to | velocities | error, rad | bound, rad | path, ms | whole run, ms |")
    print("|---|---|---|---|---|---|---|")
    for step, decimals, velocity_decimals in ROWS:
        error, bound, path, run = measure(step, decimals, velocity_decimals)
        speeds = "" if velocity_decimals is None else f"to {10.0**-velocity_decimals:g} m/s"
        cells = f"{step:g} s", f"{10.0**-decimals:g} m", speeds, f"{error:.1e}", f"{bound:.1e}"
        print("|", " | ".join((*cells, f"{1e3 * path:.0f}", f"{1e3 * run:.0f}")), "|")
