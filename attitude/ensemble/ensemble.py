"""Ensemble: many bodies, drawn about a scene's or read from a table, their statistics and stores."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import closing
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np
from astropy.table import QTable
from astropy.time import Time

from ..errors import InputError, RegimeError, suggestion, whole_number
from ..kernels.layout import BODIES_PER_BLOCK, REGIMES, ROW_STRIDE
from ..samples.html_table import html_table
from ..scene.scene import Scene
from ..times import instants
from ..times.instants import Instants
from . import engine
from .accumulation import MomentAccumulation, MomentSums, Range, ranges
from .block_motion import free_motion, is_free, motion_of, solver_choice
from .density import COLUMNS, ROWS, AxisDensity, CellCounter, axis_of
from .flips import flips, flips_of_gyrostats
from .redraws import BODIES_PER_TASK, Redraws, note, redraws_of
from .sources.dispersion import Sampled
from .sources.states import States, StateSource, check_range
from .sources.table import LeftOut, Tabled
from .statistics import Population, Statistics

if TYPE_CHECKING:
    from .execution import RunSummary, StoreOptions

Progress = Callable[[float], None]

LOST_BODIES = ("stop", "leave out")
TASKS_PER_THREAD = 16  # so that no thread waits long for the last task
# Blocks of bodies in a task: from 1024 free bodies, which take ten times as long as to submit a task, to
# 65536, beyond which nothing is gained.  Simulated bodies take longer: a task of one block is long enough.
MIN_FREE_BLOCKS, MAX_BLOCKS = 4, 256
# Instants in one pass over all bodies.  The constants of closed forms take 4 % of its time then; simulated
# bodies are integrated again in each pass.
FREE_INSTANTS, SIMULATED_INSTANTS = 16 * ROW_STRIDE, 128 * ROW_STRIDE


class Ensemble:
    """Many bodies: `Ensemble.sample(...)` draws them about a scene, `Ensemble.from_table(...)` reads them.

    Attributes
    ----------
    source : of the states of bodies, by index
    scene : Scene of which the effects act on each body, or None where bodies are free
    size : number of bodies
    left_out : bad rows of the table
    """

    def __init__(self, source: StateSource, scene: Scene | None = None):
        self.source = source
        self.scene = scene

    @classmethod
    def sample(
        cls,
        scene: Scene,
        n: int,
        seed: int,
        moments: Any = None,
        angular_velocity: Any = None,
        attitude: Any = None,
    ) -> Ensemble:
        """Bodies drawn about the one of a scene, normally distributed.

        Parameters
        ----------
        scene : Scene
        n : number of bodies
        seed : 0 to 2**128 - 1; the same body of the same seed has the same bits
        moments : relative standard deviation of the principal moments, such as "2 %"
        angular_velocity : of its components along the body's axes, such as "0.1 deg/s"
        attitude : of the components of a small rotation along the body's axes, such as "1 deg"

        A spread is a text, a Quantity, a number in SI (a ratio, rad/s, rad), or three of them, one an axis;
        None is no spread.  A ratio without "%" is below 1: 2 % is "2 %" or 0.02.  Moments that no rigid body
        can have are drawn again, which shifts their mean: see `redraws`.

        Warns
        -----
        AttitudeWarning : moments are spread by more than 50 %.

        Raises
        ------
        InputError : a value is not accepted; names the field.
        """
        return cls(Sampled(scene, n, seed, moments, angular_velocity, attitude), scene)

    @classmethod
    def from_table(
        cls,
        table: Any,
        scene: Scene | None = None,
        bad_rows: str = "stop",
        units: dict[str, str] | None = None,
    ) -> Ensemble:
        """Read a body from each row of a table.

        Parameters
        ----------
        table : astropy QTable or Table, pandas or dask DataFrame, or the path of a Parquet file or of a
            directory of them
        scene : of which these bodies have epoch, frame and effects; None for free bodies in ICRF
        bad_rows : "stop" at rows that are not accepted, or "leave out": then they are listed in `left_out`
        units : of columns that have none of their own; by default SI

        Columns (docs/ensembles.md): moments or tensor, quaternion (wxyz), angular_velocity, each as one
        column of vectors or as scalars (moments_1, tensor_xx, q_w, angular_velocity_x, ...).  Others are
        ignored.

        Raises
        ------
        InputError : a column or value is not accepted, or rows are bad, the first of them named.
        FormatError : a file cannot be read, or needs a package that is not installed.
        """
        if scene is not None and not isinstance(scene, Scene):
            raise InputError("scene", scene, "a Scene, or None")
        return cls(Tabled(table, bad_rows, units), scene)

    # -- bodies -------------------------------------------------------------------------------

    @property
    def size(self) -> int:
        """Number of bodies."""
        return self.source.size

    def __len__(self) -> int:
        return self.size

    @property
    def left_out(self) -> LeftOut:
        """Bad rows of the table, which are no bodies."""
        return self.source.left_out if isinstance(self.source, Tabled) else LeftOut()

    @property
    def frame(self) -> str:
        """The inertial frame of attitudes."""
        return "ICRF" if self.scene is None else self.scene.inertial_frame

    @property
    def epoch(self) -> Time | None:
        """Epoch of the scene, at which the states are; None where it has none."""
        return None if self.scene is None or self.scene.epoch is None else self.scene.epoch.build()

    def states(self, first: int = 0, last: int | None = None) -> States:
        """States at the epoch of the bodies from first to last, the last one excluded."""
        return self.source.part(*check_range(first, self.size if last is None else last, self.size))

    def redraws(
        self,
        first: int = 0,
        last: int | None = None,
        scheduler: str | None = None,
        workers: int | None = None,
    ) -> Redraws | None:
        """Numbers of bodies from first to last whose moments were drawn again, and the mean of the moments.

        None where moments are not spread, or bodies are of a table.  Scheduler and workers, as for
        `statistics`, are used for more than a million bodies.

        Raises InputError for indices that no body has, and where no moments are physical.
        """
        first, last = check_range(first, self.size if last is None else last, self.size)
        return redraws_of(self.source, first, last, scheduler, workers)

    def to_table(self, first: int = 0, last: int | None = None) -> QTable:
        """Return the states of these bodies, as a table that `from_table` reads."""
        table = self.states(first, last).to_table()
        table.meta["frame"] = self.frame
        if self.epoch is not None:
            table.meta["epoch"] = {"time": self.epoch.isot, "scale": self.epoch.scale}
        return table

    def instants(self, times: Any = None) -> Instants:
        """Instants (m,) of times in any form that `TorqueFreeMotion.chunks` accepts; None for the scene's.

        Raises InputError for times that are not accepted, and where there are none.
        """
        if times is None:
            if self.scene is None:
                raise InputError("times", None, "instants, for an ensemble without a scene")
            times = self.scene.times.lazily(self.epoch)
        part, count = instants.lazy_instants(times, self.epoch)
        if count < 1:
            raise InputError("times", f"{count} instants", "at least one")
        return part(0, count)

    # -- results ------------------------------------------------------------------------------

    def run(
        self,
        times: Any,
        to: str | Path,
        overwrite: bool = False,
        scheduler: str | None = None,
        workers: int | None = None,
        progress: Progress | None = None,
        **options: Unpack[StoreOptions],
    ) -> RunSummary:
        """Compute attitudes and rates of all bodies, and store them.

        Parameters
        ----------
        times : what `TorqueFreeMotion.chunks` accepts; None for those of the scene
        to : "NAME.zarr" or "NAME.parquet", a directory that is made in one that exists
        overwrite : replace a store of an ensemble (never anything else)
        scheduler : address of a running Dask cluster, whose workers see the same file system; None for
            threads of this machine
        workers : threads of this machine; by default as many as it has processors
        progress : called with the fraction that is done
        rate : whether rates are stored too; by default True
        chunk : bodies in a chunk; by default 4096, or fewer where there are many instants

        Returns
        -------
        RunSummary.  A run that was interrupted resumes when it is called again: only chunks that are not
        stored are computed.  The numbers do not depend on chunks, workers or engine.

        Raises
        ------
        InputError : a value is not accepted.
        FormatError : the store exists, or is another file, or cannot be written; or the extra `ensemble`,
            which Zarr and clusters need, is not installed.
        """
        from .execution import run

        return run(self, times, to, overwrite, scheduler, workers, progress, **options)

    def statistics(
        self,
        times: Any = None,
        scheduler: str | None = None,
        workers: int | None = None,
        progress: Progress | None = None,
        lost_bodies: str = "stop",
    ) -> Statistics:
        """Mean attitude, covariance, spread of the body axes and fractions by regime; nothing is stored.

        Parameters
        ----------
        times : what `TorqueFreeMotion.chunks` accepts; None for those of the scene
        scheduler : address of a running Dask cluster; None for threads of this machine
        workers : threads of this machine; by default as many as it has processors
        progress : called with the fraction that is done
        lost_bodies : "stop" at bodies that cannot be integrated to the scene's tolerance, or that come to
            rest on the ground before the last instant, or "leave out": then they are listed in
            `Statistics.lost`

        Returns
        -------
        Statistics, of which no bit depends on workers, tasks or engine.

        Raises
        ------
        InputError : a value is not accepted; an error about one body names it as bodies[i].
        ToleranceError : an instant is too far off for a body's phases.
        """
        instants, leave_out = self.instants(times), _leaves_out(lost_bodies)
        choice = solver_choice(self.scene, self.source, instants)
        passes = ranges(len(instants.seconds), FREE_INSTANTS if is_free(self.scene) else SIMULATED_INSTANTS)
        products, references, lost = [], [], set[int]()
        for number, (a, b) in enumerate(passes):
            low = None if instants.seconds_low is None else np.ascontiguousarray(instants.seconds_low[a:b])
            part = Instants(np.ascontiguousarray(instants.seconds[a:b]), low, None)
            reference = self._reference(part, choice, leave_out)
            work = MomentAccumulation(self.source, self.scene, choice, part, reference, leave_out)
            sums, report = MomentSums(b - a), None
            if progress is not None:
                report = partial(lambda before, done: progress((before + done) / len(passes)), number)
            for others in self._mapped(work, scheduler, workers, report):
                sums.add(others)
            if sums.regimes.sum() == len(sums.lost):
                raise RegimeError(f"statistics: none of the {self.size} bodies can be integrated")
            products.append(sums.products())
            references.append(reference)
            lost.update(sums.lost)
        regimes = {name: int(n) / self.size for name, n in zip(REGIMES, sums.regimes, strict=True)}
        redraws = self.redraws(scheduler=scheduler, workers=workers)
        population = Population(self.size - len(lost), regimes, tuple(lost), redraws)
        frame = self.frame
        return Statistics(np.concatenate(products), np.concatenate(references), instants, frame, population)

    def density(
        self,
        times: Any = None,
        axis: Any = "z",
        scheduler: str | None = None,
        workers: int | None = None,
        progress: Progress | None = None,
        lost_bodies: str = "stop",
    ) -> AxisDensity:
        """Density of a body axis on the sphere: numbers of bodies in cells; nothing is stored.

        Parameters
        ----------
        times : as for `statistics`
        axis : "x", "y", "z", the principal axis of "least", "middle" or "greatest" moment of the scene's
            body, or a vector (3,) in the body frame
        scheduler, workers, progress, lost_bodies : as for `statistics`

        Raises
        ------
        What `statistics` raises, and InputError for an axis that is none of these.
        """
        instants, direction = self.instants(times), axis_of(axis, self.scene)
        choice = solver_choice(self.scene, self.source, instants)
        work = CellCounter(self.source, self.scene, choice, instants, direction, _leaves_out(lost_bodies))
        counts, lost = np.zeros((instants.seconds.size, ROWS * COLUMNS), np.int64), list[int]()
        for task_counts, task_lost in self._mapped(work, scheduler, workers, progress):
            counts += task_counts
            lost += task_lost
        frame = self.frame
        redraws = self.redraws(scheduler=scheduler, workers=workers)
        return AxisDensity(direction, instants, frame, counts.reshape(-1, ROWS, COLUMNS), lost, redraws)

    def flips(self, count: int = 1, first: int = 0, last: int | None = None) -> np.ndarray:
        """(n, count), s: the first instants after the epoch at which the bodies from first to last flip.

        A body flips when its rate about its intermediate axis changes sign; infinite where it does not.

        Raises InputError where the bodies are neither free nor turned by rotors alone, and for indices that
        no body has; RegimeError for rotors that lead to where equilibria merge.
        """
        count = whole_number(count, "count")
        states = self.states(first, last)
        if self.scene is None or is_free(self.scene):
            return flips(free_motion(states, first), count)
        from .effects_simulation import gyrostats  # late: free bodies need no solvers

        return flips_of_gyrostats(gyrostats(self.scene, states, first), count)

    def _mapped(
        self,
        work: Callable[[Range], Any],
        scheduler: str | None,
        workers: int | None,
        progress: Progress | None,
    ) -> Iterator[Any]:
        """Results of `work` for all bodies, in tasks of whole blocks."""
        least = MIN_FREE_BLOCKS if is_free(self.scene) else 1
        share = self.size // (BODIES_PER_BLOCK * TASKS_PER_THREAD * engine.threads(scheduler, workers))
        tasks = ranges(self.size, BODIES_PER_BLOCK * min(max(share, least), MAX_BLOCKS))
        with closing(engine.mapped(work, tasks, scheduler, workers, progress)) as results:
            yield from results

    def _reference(self, instants: Instants, choice: Any, leave_out: bool) -> np.ndarray:
        """(m, 4): attitudes of the first body; the identity where it cannot be integrated."""
        first = self.source.part(0, 1)
        motion = motion_of(self.scene, first, instants, rate=False, choice=choice, leave_out=leave_out)
        if motion.lost:
            return np.tile([1.0, 0.0, 0.0, 0.0], (instants.seconds.size, 1))
        return np.ascontiguousarray(motion.quaternion[0])

    def _repr_html_(self) -> str:
        """A table, for notebooks."""
        rows = {
            "bodies": self.size,
            "motion": self._motion(),
            "frame": self.frame,
            "epoch": self.epoch,
            "note": self._note().removeprefix("; ") or None,
        }
        return html_table("Ensemble", rows)

    def __repr__(self) -> str:
        return f"<Ensemble: {self.size} bodies, {self._motion()}, {self.frame}{self._note()}>"

    def _motion(self) -> str:
        count = len(self.scene.effects) if self.scene else 0
        return "free" if is_free(self.scene) else f"with {count} effects"

    def _note(self) -> str:
        """Redraws, of at most a million bodies, so that it takes no time; or why there are none."""
        try:
            text = note(self.redraws(0, min(self.size, BODIES_PER_TASK)))
        except InputError as error:
            return f"; {error}"
        return f"; of the first {BODIES_PER_TASK}{text}" if text and self.size > BODIES_PER_TASK else text


def _leaves_out(lost_bodies: Any) -> bool:
    if lost_bodies not in LOST_BODIES:
        expected = f"one of {', '.join(LOST_BODIES)}{suggestion(lost_bodies, LOST_BODIES)}"
        raise InputError("lost_bodies", lost_bodies, expected)
    return bool(lost_bodies == LOST_BODIES[1])
