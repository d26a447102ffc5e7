"""A scene: its document, and the plan, the ephemeris and the windows of what it describes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..ephemeris import Ephemeris
from ..errors import InputError, whole_number
from ..formats.ccsds.apm_writer import ApmOptions
from ..orbit.ephemeris_orbit import EphemerisOrbit
from ..runtime import threads as thread_pool
from ..samples.chunks import Progress, Samples
from ..samples.html_table import html_table
from ..samples.transform import Data, in_frame
from ..samples.uncertainty import Uncertainty
from ..times.instants import lazy_instants
from .document import SceneDocument
from .parameter_message import message_of

if TYPE_CHECKING:
    from ..formats.interpolation_nodes import Written
    from ..windows.window_table import Windows
    from .planning import ScenePlan
    from .viewer_page import ViewerPage

MAX_SAMPLES_IN_FILE = 10_000_000_000  # in a file: a thousand gigabytes
MAX_SAMPLES_HELD = 1 << 16  # computed once, rather than again each time a writer reads them


class Scene(SceneDocument):
    """A body, its state at an epoch, instants, and the effects to simulate.

    With the member `scene`, the name of a built-in one, its members are laid over those of that scene, each
    as a whole: {"scene": "toutatis", "times": {...}}.

    `Scene.read(path)`, `Scene.builtin(name)`, `Scene.from_json(text)` and
    `Scene.model_validate(dict)` raise InputError with the field's path for whatever is wrong.
    """

    def _repr_html_(self) -> str:
        """A table, for notebooks."""
        start, stop = self.times.limits(self.epoch_time)
        rows = {
            "epoch": self.epoch and f"{self.epoch.time} {self.epoch.scale}",
            "frame": self.frame,
            "instants": f"{self.times.samples}, {start:.9g} to {stop:.9g} s",
            "effects": ", ".join(effect.type for effect in self.effects) or "none",
            "orbit": self.orbit and type(self.orbit).__name__,
        }
        return html_table(self.name or "Scene", rows)

    def to_apm(self, **options: Any) -> str:
        """The state at the epoch, inertia and torques as a CCSDS APM; options of `ApmOptions`.

        Raises FormatError for what no APM holds: no epoch, an impulse, a torque without start or stop.
        """
        return message_of(self, ApmOptions(**options))

    def view(self, columns: str = "") -> ViewerPage:
        """The viewer's page of this scene: shown by a notebook, written to a file by its `write(path)`.

        columns : that are plotted besides, as "angle:z:sun,euler:ZYX" (docs/pointing.md)

        Raises InputError and RegimeError for a column that there is not, or that the scene cannot have.
        """
        from .viewer_page import view

        return view(self, columns)

    def plan(self, drop_below: float | None = None) -> ScenePlan:
        """Which effects `run` would simulate and why, the solver, its predicted cost and error.

        drop_below : rad; torques whose influence over the span stays below are left out, and the plan says so
        """
        from . import neglect, simulation

        _check_drop(drop_below)
        return simulation.plan(neglect.resolve(self, drop_below))

    def run(
        self,
        max_samples: int | None = None,
        set_by: str = "",
        drop_below: float | None = None,
        check: Callable[[float], None] | None = None,
    ) -> Ephemeris:
        """Simulate the scene, without torques that matter less than `drop_below` (rad).

        Under torques `check` is called with the seconds that computing is predicted to take, before they are
        spent: what it raises stops the run.

        Raises InputError for an invalid value, or for more than
        `max_samples` instants (a limit `set_by` whatever the message is to name).
        """
        self._check_samples(max_samples, set_by)
        _check_drop(drop_below)
        if self.is_plain:
            motion = self.motion()
            ephemeris = motion.ephemeris(self.times.build(motion.epoch), rate=True, name=self.name)
        else:
            from . import neglect, perturbed_bodies, simulation

            inputs = neglect.resolve(self, drop_below)
            ephemeris = simulation.run(inputs, check)
            if ephemeris.sensitivity is None:
                ephemeris = replace(ephemeris, sensitivity=partial(perturbed_bodies.partials, inputs))
        return self._answer(ephemeris, self.ephemeris_orbit())

    def crossings(
        self,
        condition: Any,
        width: float | None = None,
        drop_below: float | None = None,
        check: Callable[[float], None] | None = None,
        progress: Progress | None = None,
    ) -> Windows:
        """The intervals in which a condition holds, from the first of the document's instants to the last.

        condition, width : as of `TorqueFreeMotion.crossings`; of an orbit too, such as `in_shadow()`
        drop_below, check : as in `run`; under torques the crossings are those of the solver's motion
        progress : called with the fraction that is done

        Raises InputError and RegimeError as `TorqueFreeMotion.crossings`.
        """
        from ..windows.condition import parse_condition
        from ..windows.window_table import find_windows

        parsed = parse_condition(condition)
        _check_drop(drop_below)
        start, stop = self.times.limits(self.epoch_time)
        if not stop > start:
            raise InputError("times", f"{start} to {stop} s", "instants that span a time, for windows in it")
        if self.is_plain:
            motion = self.motion().bounded(start, stop)
        else:
            from . import bounded_simulation, neglect

            motion = bounded_simulation.bounded(neglect.resolve(self, drop_below), (start, stop), check)
        orbit = self.ephemeris_orbit()
        surrounded = replace(motion, at=lambda instants: self.with_surroundings(motion.at(instants), orbit))
        return find_windows(surrounded, parsed, width, self.name, progress)

    def samples(
        self,
        progress: Progress | None = None,
        drop_below: float | None = None,
        frame: str | None = None,
        max_samples: int | None = None,
        set_by: str = "",
        check: Callable[[float], None] | None = None,
        columns: tuple[str, ...] = (),
    ) -> Samples:
        """What `run` returns, for writers; a long ephemeris without effects is computed chunk by chunk.

        columns : of tables, as `Ephemeris.with_columns` takes them
        """
        if self.is_plain and self.times.samples > MAX_SAMPLES_HELD:
            self._check_samples(max_samples, set_by)
            self._check_samples(MAX_SAMPLES_IN_FILE, "of a file")
            _check_drop(drop_below)
            samples = self._computed_on_demand(progress)
        else:
            samples = Samples.of(self.run(max_samples, set_by, drop_below, check), progress)
        if frame not in (None, self.frame):
            samples = samples.transformed(lambda piece: in_frame(piece, frame))
        return samples.transformed(lambda piece: replace(piece, columns=columns)) if columns else samples

    def _computed_on_demand(self, progress: Progress | None) -> Samples:
        motion, orbit = self.motion(), self.ephemeris_orbit()
        part, count = lazy_instants(self.times.lazily(motion.epoch), motion.epoch)

        def cut(first: int, last: int) -> Ephemeris:
            ephemeris = motion.ephemeris(part(first, last), rate=True, name=self.name)
            return self._answer(ephemeris, orbit)

        return Samples(count, cut, progress, part, in_memory=False)

    def _check_samples(self, limit: int | None, set_by: str) -> None:
        if limit is not None and self.times.samples > limit:
            expected = f"at most {limit} samples" + (f" ({set_by})" if set_by else "")
            raise InputError("times", f"{self.times.samples} samples", expected)

    def write(
        self,
        path: str | Path,
        format: str | None = None,  # noqa: A002 (public name)
        frame: str | None = None,
        interpolation_error: Any = None,
        drop_below: float | None = None,
        progress: Progress | None = None,
        **options: Any,
    ) -> Written:
        """Run, and write to a file as `Ephemeris.write` does; without effects at the memory of a piece.

        frame : another than the scene's, as in `Ephemeris.in_frame`
        drop_below : as in `run`
        """
        from .. import formats

        formats.find(path, format)
        samples = self.samples(progress, drop_below, frame)
        return formats.write(samples, path, format, None, interpolation_error, **options)

    def chunks(self, size: int, threads: int = 1) -> Iterator[Ephemeris]:
        """What `run` returns, in ephemerides of at most `size` instants each; see `TorqueFreeMotion.chunks`.

        A scene with effects is computed as a whole and cut.
        """
        if not self.is_plain:
            size = whole_number(size, "size")
            thread_pool.check(threads)
            ephemeris = self.run()
            return (ephemeris[first : first + size] for first in range(0, len(ephemeris), size))
        motion, orbit = self.motion(), self.ephemeris_orbit()
        chunks = motion.chunks(
            self.times.lazily(motion.epoch), size, rate=True, threads=threads, name=self.name
        )
        return (self._answer(chunk, orbit) for chunk in chunks)

    def _answer(self, ephemeris: Data, orbit: EphemerisOrbit | None) -> Data:
        """The ephemeris with its surroundings, relative to `frame`."""
        ephemeris = self.with_surroundings(ephemeris, orbit)
        return ephemeris if self.frame == self.inertial_frame else in_frame(ephemeris, self.frame)

    def with_surroundings(self, ephemeris: Data, orbit: EphemerisOrbit | None) -> Data:
        """The ephemeris with its orbit, the source of UT1, its uncertainty, and notes on the document."""
        uncertainty, plan = None if self.uncertainty is None else self.checked_uncertainty, ephemeris.plan
        if plan is not None:
            before = self.notes if self.is_plain else ()  # of effects, the plan has them
            after = () if uncertainty is None or uncertainty.note is None else (uncertainty.note,)
            plan = replace(plan, notes=(*before, *plan.notes, *after))
        return replace(ephemeris, orbit=orbit, ut1=self.ut1, plan=plan, uncertainty=uncertainty)

    @cached_property
    def checked_uncertainty(self) -> Uncertainty:
        """The uncertainty of body and state, with how far the first order in it holds; computed once."""
        from . import linearity, simulation

        assert self.uncertainty is not None
        return linearity.checked(simulation.resolve(self), self.uncertainty)


def _check_drop(drop_below: float | None) -> None:
    is_angle = isinstance(drop_below, (int, float)) and 0.0 < drop_below < np.inf
    if drop_below is not None and not is_angle:
        raise InputError("drop_below", drop_below, "an angle in rad, above 0")
