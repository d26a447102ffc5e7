"""Ensemble: what users hold."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from astropy.table import QTable
from astropy.time import Time

from ..errors import InputError, RegimeError
from ..frames import rotations
from ..kernels.layout import LEAF, PITCH, REGIMES
from ..scene.document import Scene
from ..times import instants
from ..times.instants import Instants
from . import engine
from .accumulation import Gathering, Sums, cuts
from .density import COLUMNS, ROWS, Counting, Density, axis_of
from .flips import flips
from .motion import choice_of, free_motion, is_free, motion_of
from .redraws import PART, Redraws, note, redraws_of
from .sources.dispersion import Sampled
from .sources.states import Source, States, check_part
from .sources.table import LeftOut, Tabled
from .statistics import Statistics

if TYPE_CHECKING:
    from .execution import Run

Progress = Callable[[float], None]

LOST_BODIES = ("stop", "leave out")
TASKS = 16  # for each thread, of many bodies: none waits long for the last
# Of a task of free bodies, at least and at most: 1024, which take ten times as long as to hand out a task,
# to 65536, after which nothing is gained by more.  Simulated bodies take longer: then one is enough.
FEW_LEAVES, MOST_LEAVES = 4, 256
# Instants of one pass over all bodies: of closed forms set-up is 4 % then; simulated again in each pass.
FREE_PASS, SIMULATED_PASS = 16 * PITCH, 128 * PITCH


class Ensemble:
    """Many bodies: `Ensemble.sample(...)` draws them about a scene, `Ensemble.from_table(...)` reads them.

    Attributes
    ----------
    source : gives the states of bodies by their index
    scene : Scene of which the effects act on each body, or None where bodies are free
    size : number of bodies
    left_out : bad rows of the table that are no bodies
    """

    def __init__(self, source: Source, scene: Scene | None = None):
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
        None is none.  A ratio without "%" is below 1: 2 % is "2 %" or 0.02.  Moments that no body has are
        drawn again, which moves their mean: see `redraws`.

        Warns
        -----
        AttitudeWarning : moments are spread by more than 50 %.

        Raises
        ------
        InputError : a value that cannot be taken; names the field.
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
        """A body for each row of a table.

        Parameters
        ----------
        table : astropy QTable or Table, pandas or dask DataFrame, or the path of a Parquet file or of a
            directory of them
        scene : whose epoch, frame and effects these bodies have; None for free bodies in ICRF
        bad_rows : "stop" at rows that cannot be taken, or "leave out": then they are listed in `left_out`
        units : of columns that do not say theirs; otherwise those are in SI

        Columns (docs/ensembles.md): moments or tensor, quaternion (wxyz), angular_velocity, each as one
        column of vectors or as scalars (moments_1, tensor_xx, q_w, angular_velocity_x, ...).  Others are
        ignored.

        Raises
        ------
        InputError : a column or value that cannot be taken, or bad rows, the first of them named.
        FormatError : a file that cannot be read, or needs a package that is not installed.
        """
        if scene is not None and not isinstance(scene, Scene):
            raise InputError("scene", scene, "a Scene, or None")
        return cls(Tabled(table, bad_rows, units), scene)

    # -- what there is ------------------------------------------------------------------------

    @property
    def size(self) -> int:
        return self.source.size

    def __len__(self) -> int:
        return self.size

    @property
    def left_out(self) -> LeftOut:
        return self.source.left_out if isinstance(self.source, Tabled) else LeftOut()

    @property
    def frame(self) -> str:
        return "ICRF" if self.scene is None else self.scene.frame

    @property
    def epoch(self) -> Time | None:
        return None if self.scene is None or self.scene.epoch is None else self.scene.epoch.build()

    def states(self, first: int = 0, last: int | None = None) -> States:
        """Of the bodies from first to last, the last one excluded."""
        return self.source.part(*check_part(first, self.size if last is None else last, self.size))

    def redraws(
        self,
        first: int = 0,
        last: int | None = None,
        scheduler: str | None = None,
        workers: int | None = None,
    ) -> Redraws | None:
        """Of the bodies from first to last: whose moments were drawn again, and where their mean lies.

        None where moments are not spread, or bodies are of a table.  Scheduler and workers, as for
        `statistics`, count more than a million bodies.

        Raises InputError for bodies that there are not, or whose moments find no value.
        """
        first, last = check_part(first, self.size if last is None else last, self.size)
        return redraws_of(self.source, first, last, scheduler, workers)

    def to_table(self, first: int = 0, last: int | None = None) -> QTable:
        """The states of these bodies, as `from_table` takes them."""
        table = self.states(first, last).to_table()
        table.meta["frame"] = self.frame
        if self.epoch is not None:
            table.meta["epoch"] = {"time": self.epoch.isot, "scale": self.epoch.scale}
        return table

    def instants(self, times: Any = None) -> Instants:
        """(m,), of what `TorqueFreeMotion.chunks` takes; None for those of the scene.

        Raises InputError for what they cannot be, and where there are none.
        """
        if times is None:
            if self.scene is None:
                raise InputError("times", None, "instants, for an ensemble without a scene")
            times = self.scene.times.lazily(self.epoch)
        part, count = instants.lazy_instants(times, self.epoch)
        if count < 1:
            raise InputError("times", f"{count} instants", "at least one")
        return part(0, count)

    # -- what they do -------------------------------------------------------------------------

    def run(
        self,
        times: Any,
        to: str | Path,
        overwrite: bool = False,
        scheduler: str | None = None,
        workers: int | None = None,
        progress: Progress | None = None,
        rate: bool = True,
        chunk: int | None = None,
    ) -> Run:
        """Compute attitudes and rates of all bodies, and store them; see `running.run`."""
        from .execution import run

        return run(self, times, to, overwrite, scheduler, workers, progress, rate, chunk)

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
        times : what `TorqueFreeMotion.chunks` takes; None for those of the scene
        scheduler : address of a running Dask cluster; None for threads of this machine
        workers : threads of this machine; by default as many as it has processors
        progress : called with the fraction that is done
        lost_bodies : "stop" at bodies that cannot be followed to the scene's tolerance, or that come to rest
            on the ground before the last instant, or "leave out": then they are listed in `Statistics.lost`

        Returns
        -------
        Statistics, of which no bit depends on workers, tasks or engine.

        Raises
        ------
        InputError : a value that cannot be taken; an error about one body names it as bodies[i].
        ToleranceError : an instant is too far off for a body's phases.
        """
        instants, leave_out = self.instants(times), _leaves_out(lost_bodies)
        choice = choice_of(self.scene, self.source, instants)
        passes = cuts(len(instants.seconds), FREE_PASS if is_free(self.scene) else SIMULATED_PASS)
        products, references, lost = [], [], set[int]()
        for number, (a, b) in enumerate(passes):
            told = None if progress is None else _within(progress, number, len(passes))
            some = Instants(
                instants.seconds[a:b],
                None if instants.seconds_low is None else instants.seconds_low[a:b],
                None,
            )
            reference = self._reference(some, choice, leave_out)
            work = self._gathering(some, choice, reference, leave_out)
            sums = self._gathered(work, scheduler, workers, told)
            if sums.regimes.sum() == len(sums.lost):
                raise RegimeError(f"statistics: none of the {self.size} bodies can be followed")
            products.append(sums.products())
            references.append(reference)
            lost.update(sums.lost)
        regimes = {name: int(n) / self.size for name, n in zip(REGIMES, sums.regimes, strict=True)}
        found = np.concatenate(products), np.concatenate(references)
        count, frame = self.size - len(lost), rotations.check_frame(self.frame)
        redraws = self.redraws(scheduler=scheduler, workers=workers)
        return Statistics(*found, instants, count, regimes, frame, tuple(lost), redraws)

    def density(
        self,
        times: Any = None,
        axis: Any = "z",
        scheduler: str | None = None,
        workers: int | None = None,
        progress: Progress | None = None,
        lost_bodies: str = "stop",
    ) -> Density:
        """Where a body axis points: bodies counted in cells of the sphere; nothing else is kept.

        Parameters
        ----------
        times : as for `statistics`
        axis : "x", "y", "z", the principal axis of "least", "middle" or "greatest" moment of the scene's
            body, or a vector (3,) in the body frame
        scheduler, workers, progress, lost_bodies : as for `statistics`

        Raises
        ------
        What `statistics` raises, and InputError for what is no axis.
        """
        instants, along = self.instants(times), axis_of(axis, self.scene)
        choice = choice_of(self.scene, self.source, instants)
        work = Counting(self.source, self.scene, choice, instants, along, _leaves_out(lost_bodies))
        counts, lost = np.zeros((instants.seconds.size, ROWS * COLUMNS), np.int64), list[int]()
        with closing(
            engine.mapped(work, self._tasks(scheduler, workers), scheduler, workers, progress)
        ) as parts:
            for found, left_out in parts:
                counts += found
                lost += left_out
        frame = rotations.check_frame(self.frame)
        redraws = self.redraws(scheduler=scheduler, workers=workers)
        return Density(along, instants, frame, counts.reshape(-1, ROWS, COLUMNS), lost, redraws)

    def flips(self, count: int = 1, first: int = 0, last: int | None = None) -> np.ndarray:
        """(n, count), s: when the bodies from first to last flip, the first times after the epoch.

        A body flips when its rate about its intermediate axis changes sign; infinite where it does not.

        Raises InputError where the bodies are not free, or for bodies that there are not.
        """
        if not is_free(self.scene):
            raise InputError("scene.effects", "effects that turn the body", "none, for flips in closed form")
        if isinstance(count, bool) or not isinstance(count, int) or count < 1:
            raise InputError("count", count, "a whole number, at least 1")
        return flips(free_motion(self.states(first, last), first), count)

    def _tasks(self, scheduler: str | None, workers: int | None) -> list[tuple[int, int]]:
        """Bodies of each task: whole leaves, many enough that none waits long for the last."""
        least = FEW_LEAVES if is_free(self.scene) else 1
        tasks = TASKS * engine.threads(scheduler, workers)
        return cuts(self.size, LEAF * min(max(self.size // (LEAF * tasks), least), MOST_LEAVES))

    def _reference(self, instants: Instants, choice: Any, leave_out: bool) -> np.ndarray:
        """(m, 4): attitudes of the first body; none in particular where it cannot be followed."""
        first = self.source.part(0, 1)
        block = motion_of(self.scene, first, instants, rate=False, choice=choice, leave_out=leave_out)
        if block.lost:
            return np.tile([1.0, 0.0, 0.0, 0.0], (instants.seconds.size, 1))
        return np.ascontiguousarray(block.quaternion[0])

    def _gathering(
        self, instants: Instants, choice: Any, reference: np.ndarray, leave_out: bool
    ) -> Gathering:
        rest = None if instants.seconds_low is None else np.ascontiguousarray(instants.seconds_low)
        seconds = np.ascontiguousarray(instants.seconds)
        return Gathering(self.source, self.scene, choice, seconds, rest, reference, leave_out)

    def _gathered(
        self, work: Gathering, scheduler: str | None, workers: int | None, progress: Progress | None
    ) -> Sums:
        """The sums over all bodies at the instants of one pass."""
        total = Sums(len(work.seconds))
        with closing(
            engine.mapped(work, self._tasks(scheduler, workers), scheduler, workers, progress)
        ) as parts:
            for sums in parts:
                total.add(sums)
        return total

    def __repr__(self) -> str:
        where = (
            "free" if is_free(self.scene) else f"with {len(self.scene.effects if self.scene else ())} effects"
        )
        return f"<Ensemble: {self.size} bodies, {where}, {self.frame}{self._redraws_text()}>"

    def _redraws_text(self) -> str:
        """Of the first million bodies, where there are more: nobody waits for a name."""
        try:
            found = note(self.redraws(0, min(self.size, PART)))
        except InputError as error:
            return f"; {error}"
        return f"; of the first {PART}{found}" if found and self.size > PART else found


def _within(progress: Progress, number: int, passes: int) -> Progress:
    return lambda done: progress((number + done) / passes)


def _leaves_out(lost_bodies: Any) -> bool:
    if lost_bodies not in LOST_BODIES:
        raise InputError("lost_bodies", lost_bodies, f"one of {', '.join(LOST_BODIES)}")
    return bool(lost_bodies == LOST_BODIES[1])
