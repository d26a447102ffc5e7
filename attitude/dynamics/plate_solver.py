"""The solver of scenes with plates: arcs that end at the plates' edges (docs/torques.md, section 5)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .. import stopping
from ..kernels.solvers.plate_layout import ARC_NODES, MARCHED, ArcRow, FormRow, SourceRow
from ..problem.torque_model import CachedTorque
from ..runtime import compiled
from .plate_arguments import scheme
from .solver import SolverTask, SolverWork, workspace

NAME = "gauss, order 16, in arcs between the edges of plates"
STRIDE = 1.5  # arcs of the coarser solution over those of the answer


def take_arcs(task: SolverTask, torques: Sequence[CachedTorque]) -> SolverWork:
    """Step the bodies of a task, in arcs of no more than `setting.step` rad; else as `solver.take_steps`."""
    arguments, which, setting = task.arguments, task.which, task.setting
    plates = arguments.plates
    assert plates is not None
    records = np.zeros(len(which), MARCHED)
    records["index"], records["state"], records["body"] = which, task.states[which], arguments.body[which]
    records["constant"], records["squared_rates"] = plates.constant[which], plates.squared_rates[which]
    records["theta"] = setting.step[which] * (STRIDE if setting.coarsely else 1.0)
    sources = plates.sources.shape[1]
    rows = ArcRow.SOURCES + SourceRow.ROWS * sources
    work = workspace(rows * ARC_NODES, scheme())
    try:
        compiled.march(
            *(records, np.array([task.start, task.stop]), task.instants, task.out),
            *(work, stopping.current().flag),
            *(plates.plates, plates.base, plates.sources, plates.user_rows),
            np.zeros((plates.plates.shape[1], 2)),
            np.zeros((sources, FormRow.WIDTH)),
            *(plates.cuts, plates.lights, *arguments.surroundings, plates.air),
        )
        stopping.current().check()
    finally:
        for torque in torques:
            torque.raise_failure()
    task.states[which] = records["state"]
    arcs, sweeps, _, failed = records["counts"].T
    return SolverWork(arcs, sweeps, failed, records["edges"])
