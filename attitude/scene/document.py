"""The scene document, one JSON for library, command and HTTP: its parts, its plan and its simulation."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator
from copy import copy
from dataclasses import replace
from functools import cached_property, lru_cache, partial
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from astropy.time import Time
from pydantic import Field, ValidationError, model_validator

from ..documents.fields import (
    Part,
    Text,
    field_within,
    input_error,
    parse_json,
)
from ..documents.files import files_in
from ..documents.quantities import GREATEST, LengthVector, SpeedVector
from ..effects import KNOWN_EFFECTS, AnyEffect, consistency
from ..ephemeris import Ephemeris
from ..errors import InputError, emit_warning, file_errors, noted, unknown_name, warn
from ..frames import rotations
from ..motion import TorqueFreeMotion
from ..orbit import AnyOrbit
from ..orbit.ephemeris_orbit import EphemerisOrbit
from ..orbit.orbit import OrbitDefinition
from ..problem.initial_state import InitialState, OrbitPath
from ..samples.chunks import Progress, Samples
from ..samples.html_table import html_table
from ..samples.transform import Data, in_frame, rotation_to
from ..samples.uncertainty import Uncertainty
from ..times import instants
from ..times.instants import Instants
from .document_parts import (
    BEST,
    MIN_TOLERANCE,
    AngularVelocity,
    AnyTolerance,
    Attitude,
    Body,
    Epoch,
    Times,
    Tolerance,
)
from .parameter_message import ApmOptions, message_of, with_message
from .spin_form import SpinForm
from .uncertainty_form import UncertaintyForm

if TYPE_CHECKING:
    from ..formats.interpolation_nodes import Written
    from ..windows.window_table import Windows
    from .planning import ScenePlan
    from .viewer_page import ViewerPage

MAX_SAMPLES_IN_FILE = 10_000_000_000  # in a file: a thousand gigabytes
# Fields that determine the motion; and those besides, where it is stated relative to a frame that turns.
STATE = {"body", "attitude", "angular_velocity", "spin", "frame"}
RELATIVE_STATE = {"relative_to", "epoch", "orbit", "ut1", "times"}
# Solvers that documents may still name.
SOLVERS_THAT_LEFT = ("splitting", "dop853")
DEFAULT_TOLERANCE = 1e-9  # rad
MAX_SAMPLES_HELD = 1 << 16  # computed once, rather than again each time a writer reads them


class Scene(Part):
    """A body, its state at an epoch, instants, and the effects to simulate.

    With the member `scene`, the name of a built-in one, its members are laid over those of that scene, each
    as a whole: {"scene": "toutatis", "times": {...}}.

    `Scene.read(path)`, `Scene.builtin(name)`, `Scene.from_json(text)` and
    `Scene.model_validate(dict)` raise InputError with the field's path for whatever is wrong.
    """

    name: Text = ""
    description: Text = ""
    body: Body
    epoch: Epoch | None = None
    frame: str = "ICRF"
    attitude: Attitude | None = None
    angular_velocity: AngularVelocity | None = None
    spin: SpinForm | None = None
    relative_to: str | None = Field(None, examples=["LVLH"])
    times: Times
    effects: list[AnyEffect] = Field(default_factory=list)
    orbit: AnyOrbit | None = None
    position: LengthVector | None = None
    velocity: SpeedVector | None = None
    tolerance: AnyTolerance | None = None
    solver: Literal["automatic", "splitting", "gauss", "dop853"] | None = None
    ut1: Literal["tables", "utc"] = "tables"
    uncertainty: UncertaintyForm | None = None
    _notes: tuple[str, ...] = ()

    @model_validator(mode="after")
    def _check(self) -> Scene:
        if self.solver in SOLVERS_THAT_LEFT:
            text = f"solver: {self.solver} is no longer offered; gauss, to the same tolerance, is used"
            emit_warning(text, 2, FutureWarning)
        rotations.check_frame(self.frame, also=("TEME",))
        if self.frame == "TEME" and self.epoch is None:
            raise InputError("epoch", None, "an epoch; the axes of TEME are those of a date")
        for name in ("attitude", "angular_velocity"):
            if getattr(self, name) is None and self.spin is None:
                raise InputError(name, None, "a value (the field is required)")
            if getattr(self, name) is not None and self.spin is not None:
                raise InputError(name, "a value", f"no {name} beside spin: it would be said twice")
        if self.relative_to is not None:
            _check_reference(self, self.relative_to)
        if self.orbit is not None:
            with field_within("orbit"):
                self.orbit.check_span(*self.times.span(self.epoch_time), self.epoch_time)
        if self.effects or self.position is not None or self.velocity is not None:
            consistency.check(self)
        return self

    def __init__(self, **document: Any):
        if "scene" in document:
            name = document.pop("scene")
            document = parse_json(builtin_text(name), name) | document
        try:
            with noted() as notes:
                if "apm" in document:
                    document = with_message(document, Times)
                super().__init__(**document)
            self._notes = tuple(notes)
        except ValidationError as error:
            raise input_error(error, type(self), document) from None

    @classmethod
    def __get_pydantic_json_schema__(cls, core: Any, handler: Any) -> dict[str, Any]:
        """With `scene`, the name of a built-in scene whose members a document need not repeat."""
        schema = handler.resolve_ref_schema(handler(core))
        named = {"enum": builtin_names(), "type": "string", "title": "Scene"}
        named["description"] = "a built-in scene, over whose members those of the document are laid"
        message = {"type": "string", "title": "Apm"}
        message["description"] = 'the text of a CCSDS APM, likewise; outside HTTP also {"file": path}'
        schema["properties"] = {"scene": named, **schema["properties"], "apm": message}
        schema["if"] = {"not": {"anyOf": [{"required": ["scene"]}, {"required": ["apm"]}]}}
        schema["then"] = {"required": schema.pop("required")}
        return schema

    @classmethod
    def model_validate(cls, document: Any) -> Scene:  # type: ignore[override]
        """Make a scene of plain data, as JSON text holds it."""
        if not isinstance(document, dict) or not set(map(type, document)) <= {str}:
            raise InputError("document", document, "a JSON object", steps=())
        return cls(**document)

    @classmethod
    def from_json(cls, text: str | bytes, source: str = "document") -> Scene:
        """Make a scene of JSON text.  Refuses NaN, Infinity, duplicate keys, which JSON readers let pass."""
        return cls.model_validate(parse_json(text, source))

    @classmethod
    def read(cls, path: str | Path, times: dict[str, Any] | None = None) -> Scene:
        """Read a scene from a JSON file, or from an APM (.apm) and the `times` of a document.

        times : in place of those of the document
        """
        if Path(path).suffix.lower() == ".apm":
            document = {"apm": {"file": str(path)}}
            return cls.model_validate(document if times is None else document | {"times": times})
        with file_errors(path):
            text = Path(path).read_bytes()
        with files_in(Path(path).parent):
            document = parse_json(text, str(path))
            if times is not None and isinstance(document, dict):
                document |= {"times": times}
            return cls.model_validate(document)

    @classmethod
    def load(cls, source: Any) -> Scene:
        """Make a scene of the path of a JSON file, the name of a built-in scene, or plain data.

        Raises FormatError for a path that cannot be read, InputError for a name that is none.
        """
        if isinstance(source, cls):
            return source
        if isinstance(source, dict):
            return cls.model_validate(source)
        if not isinstance(source, (str, os.PathLike)):
            raise InputError("source", source, "a path, the name of a built-in scene, or plain data")
        name = os.fspath(source)
        is_path = isinstance(source, os.PathLike) or os.sep in name or name.endswith(".json")
        if is_path or (os.path.isfile(name) and os.path.exists(name)):
            return cls.read(name)
        return cls.builtin(name)

    @classmethod
    def builtin(cls, name: str) -> Scene:
        """One of the scenes that come with the package."""
        return cls.from_json(builtin_text(name), name)

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

    def view(self, columns: str = "") -> ViewerPage:
        """The viewer's page of this scene: shown by a notebook, written to a file by its `write(path)`.

        columns : that are plotted besides, as "angle:z:sun,euler:ZYX" (docs/pointing.md)

        Raises InputError and RegimeError for a column that there is not, or that the scene cannot have.
        """
        from .viewer_page import view

        return view(self, columns)

    def to_json(self) -> str:
        """The document as JSON text; `from_json` of it is this scene."""
        return json.dumps(self.document(), indent=2, ensure_ascii=False)

    def to_apm(self, **options: Any) -> str:
        """The state at the epoch, inertia and torques as a CCSDS APM; options of `ApmOptions`.

        Raises FormatError for what no APM holds: no epoch, an impulse, a torque without start or stop.
        """
        return message_of(self, ApmOptions(**options))

    def document(self) -> dict[str, Any]:
        """The document as plain data, without what was left out.

        Raises InputError where an effect was made in Python, which no document can hold.
        """
        for i, effect in enumerate(self.effects):
            if effect.type not in KNOWN_EFFECTS:
                expected = (
                    f"effects that a document can hold ({', '.join(KNOWN_EFFECTS)}), none made in Python"
                )
                raise InputError(f"effects[{i}]", effect, expected)
        return self.model_dump(exclude_unset=True, by_alias=True)

    @property
    def epoch_time(self) -> Time | None:
        """The epoch, the caller's own copy."""
        return None if self.epoch is None else self.epoch.build()

    @property
    def notes(self) -> tuple[str, ...]:
        """How values were taken, when the document was read, that are not as they should be."""
        return self._notes

    @property
    def asked_tolerance(self) -> float:
        """rad: the document's `tolerance`, or the default; of the best answer, the least allowed."""
        if self.wants_best:
            return MIN_TOLERANCE
        return self.tolerance.si if isinstance(self.tolerance, Tolerance) else DEFAULT_TOLERANCE

    @property
    def wants_best(self) -> bool:
        """Whether the most exact answer is asked for, in place of a tolerance."""
        return self.tolerance == BEST

    def initial_state(self) -> InitialState:
        """The numbers that effects and solvers share, in SI, with every effect checked against them.

        Raises InputError with the field's path for what contradicts another part of the scene.
        """
        epoch = self.epoch_time
        start, stop = self.times.span(epoch)
        body = self.body.build()
        attitude, rate = self.state()
        if self.effects:
            _check_magnitudes(body.moments, rate)
        orbit_path = None
        if self.orbit is not None and any(effect.uses_orbit for effect in self.effects):
            orbit_path = _orbit_path(self.orbit, self.inertial_frame, epoch, start, stop)
        initial_state = InitialState(
            body,
            attitude,
            rate,
            start,
            stop,
            epoch,
            self.inertial_frame,
            None if self.body.mass is None else self.body.mass.si,
            None if self.position is None else self.position.si,
            None if self.velocity is None else self.velocity.si,
            orbit_path,
        )
        for i, effect in enumerate(self.effects):
            with field_within(f"effects[{i}]"):
                effect.check(initial_state)
        return initial_state

    def state(self) -> tuple[np.ndarray, np.ndarray]:
        """(4,) wxyz, body to `frame`, and (3,) rad/s at the epoch.

        Of `attitude` and `angular_velocity`, or of `spin`; where they are `relative_to` another frame, its
        orientation and its own rate are accounted for: q = conj(r) q_r, omega = omega_r + R(q_r)^T Omega,
        with r and Omega the rotation to that frame and its rate along its axes.
        """
        if self.spin is not None:
            with field_within("spin"):
                q, omega = self.spin.state(self.body.build().tensor)
        else:
            assert self.attitude is not None
            assert self.angular_velocity is not None
            q, omega = self.attitude.build(), self.angular_velocity.build()
        reference = self.relative_to or self.frame
        if reference == self.inertial_frame:
            return q, omega
        at_epoch = Instants(np.zeros(1), None, self.epoch_time)
        with field_within("relative_to"):
            turn = rotation_to(reference, self.inertial_frame, self.ephemeris_orbit(), at_epoch, self.ut1)
        if turn is None:
            return q, omega
        r, own_rate = turn.quaternion.reshape(-1, 4)[0], np.reshape(turn.rate, (-1, 3))[0]
        omega = omega + rotations.rotate(rotations.conjugate(q), own_rate)
        return rotations.product(rotations.conjugate(r), q), omega

    def motion(self) -> TorqueFreeMotion:
        """The motion at the document's epoch."""
        is_inertial = self.relative_to is None and self.frame == self.inertial_frame
        names = STATE if is_inertial else STATE | RELATIVE_STATE
        try:
            state = _State(self.__pydantic_serializer__.to_json(self, include=names))
        except ValueError:  # half a surrogate pair where a unit should be
            state = _State(ascii([getattr(self, name) for name in sorted(names)]).encode())
        state.scene = self
        motion = copy(_motion(state))
        if state.is_known:
            for text in motion.notes:
                warn(text)
        motion.epoch = self.epoch_time  # the cached one has none
        return motion

    @property
    def inertial_frame(self) -> str:
        """The frame that the motion is computed in: `frame`, or for TEME its axes at the epoch."""
        return rotations.TEME_AT_EPOCH if self.frame == "TEME" else self.frame

    @property
    def is_plain(self) -> bool:
        """Whether only the attitude of a free body is computed."""
        return not self.effects and self.position is None

    def plan(self, drop_below: float | None = None) -> ScenePlan:
        """Which effects `run` would simulate and why, the solver, its predicted cost and error.

        drop_below : rad; torques whose influence over the span stays below are left out, and the plan says so
        """
        from . import simulation

        if drop_below is not None:
            _check_drop(drop_below)
        return simulation.plan(simulation.resolve(self, drop_below))

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
        if max_samples is not None:
            self._check_samples(max_samples, set_by)
        if drop_below is not None:
            _check_drop(drop_below)
        if not self.is_plain:
            from . import perturbed_bodies, simulation

            inputs = simulation.resolve(self, drop_below)
            ephemeris = simulation.run(inputs, check)
            if ephemeris.sensitivity is None:
                ephemeris = replace(ephemeris, sensitivity=partial(perturbed_bodies.partials, inputs))
        else:
            motion = self.motion()
            ephemeris = motion.ephemeris(self.times.build(motion.epoch), rate=True, name=self.name)
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
        start, stop = self.times.limits(self.epoch_time)
        if not stop > start:
            raise InputError("times", f"{start} to {stop} s", "instants that span a time, for windows in it")
        if self.is_plain:
            motion = self.motion().bounded(start, stop)
        else:
            from . import bounded_simulation, simulation

            motion = bounded_simulation.bounded(simulation.resolve(self, drop_below), (start, stop), check)
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
            if max_samples is not None:
                self._check_samples(max_samples, set_by)
            self._check_samples(MAX_SAMPLES_IN_FILE, "of a file")
            if drop_below is not None:
                _check_drop(drop_below)
            samples = self._computed_on_demand(progress)
        else:
            samples = Samples.of(self.run(max_samples, set_by, drop_below, check), progress)
        if frame not in (None, self.frame):
            samples = samples.transformed(lambda piece: in_frame(piece, frame))
        return samples.transformed(lambda piece: replace(piece, columns=columns)) if columns else samples

    def _computed_on_demand(self, progress: Progress | None) -> Samples:
        motion, orbit = self.motion(), self.ephemeris_orbit()
        part, count = instants.lazy_instants(self.times.lazily(motion.epoch), motion.epoch)

        def cut(first: int, last: int) -> Ephemeris:
            ephemeris = motion.ephemeris(part(first, last), rate=True, name=self.name)
            return self._answer(ephemeris, orbit)

        return Samples(count, cut, progress, part, in_memory=False)

    def _check_samples(self, limit: int, set_by: str) -> None:
        if self.times.samples > limit:
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
        """The ephemeris with its orbit, the source of UT1, and its uncertainty."""
        if self.uncertainty is not None:
            uncertainty, plan = self.checked_uncertainty, ephemeris.plan
            if plan is not None and uncertainty.note is not None:
                plan = replace(plan, notes=(*plan.notes, uncertainty.note))
            ephemeris = replace(ephemeris, uncertainty=uncertainty, plan=plan)
        if orbit is None and self.ut1 == "tables":
            return ephemeris
        plan = ephemeris.plan
        if plan is not None and self.is_plain and self._notes:
            plan = replace(plan, notes=(*self._notes, *plan.notes))
        return replace(ephemeris, orbit=orbit, ut1=self.ut1, plan=plan)

    @cached_property
    def checked_uncertainty(self) -> Uncertainty:
        """The uncertainty of body and state, with how far the first order in it holds; computed once."""
        from . import perturbed_bodies, simulation
        from .linearity import instants_of, linear_until

        assert self.uncertainty is not None
        inputs = simulation.resolve(self)
        initial = self.uncertainty.build(inputs.initial_state.body)
        instants = instants_of(inputs)
        if not instants.seconds.size:
            return Uncertainty(initial, np.inf)
        if self.is_plain:
            partials = self.motion()._batch.partials(instants)
        else:
            partials = perturbed_bodies.partials(inputs, instants)
        return Uncertainty(initial, linear_until(inputs, partials, instants, initial))

    def ephemeris_orbit(self) -> EphemerisOrbit | None:
        """The orbit, for frames that follow it; computed when such a frame is requested."""
        if self.orbit is None:
            return None
        path = partial(_orbit_path, self.orbit, self.inertial_frame, self.epoch_time)
        return EphemerisOrbit(path, partial(self.times.span, self.epoch_time), self.inertial_frame)


class _State(bytes):
    """Text of the fields that determine a motion, by which it is cached, and these fields.

    is_known : False where the motion was built for this document; what was warned of then is said again
    """

    scene: Scene
    is_known = True


@lru_cache(maxsize=256)
def _motion(state: _State) -> TorqueFreeMotion:
    """Cached with its constants: the same body is often queried again."""
    scene, state.is_known = state.scene, False
    with noted() as notes:
        motion = TorqueFreeMotion(
            scene.body.build(), *scene.state(), order="wxyz", frame=scene.inertial_frame
        )
    motion.notes = tuple(notes)
    return motion


def _orbit_path(
    orbit: OrbitDefinition, frame: str, epoch: Time | None, start: float, stop: float
) -> OrbitPath:
    with field_within("orbit"):
        return orbit.path(start, stop, epoch, frame)


def _check_magnitudes(moments: np.ndarray, rate: np.ndarray) -> None:
    """Refuse moments and rates whose products with those of effects would not be finite."""
    if not (moments.min() >= 1.0 / GREATEST and moments.max() <= GREATEST):
        expected = f"moments from {1.0 / GREATEST:g} to {GREATEST:g} kg m2 in a scene with effects"
        raise InputError("body", moments.tolist(), expected)
    if not np.abs(rate).max() <= GREATEST:
        expected = f"a rate of at most {GREATEST:g} rad/s in a scene with effects"
        raise InputError("angular_velocity", rate.tolist(), expected)


def _check_reference(scene: Scene, reference: str) -> None:
    """Refuse a frame of the state without the orbit, the date or the axes that it needs."""
    rotations.check_any_frame(reference, "relative_to")
    if reference in rotations.ORBITAL_FRAMES:
        if scene.orbit is None:
            raise InputError("orbit", None, f"an orbit, which {reference} lies along")
    elif reference != scene.frame:
        if "INERTIAL" in (reference, scene.frame):
            expected = f"a frame whose axes relative to {scene.frame} are defined; INERTIAL is the user's own"
            raise InputError("relative_to", reference, expected)
        if reference in rotations.TURNING_FRAMES and scene.epoch is None:
            raise InputError("epoch", None, f"an epoch; the axes of {reference} are those of a date")


def _check_drop(drop_below: float) -> None:
    if not (isinstance(drop_below, (int, float)) and 0.0 < drop_below < np.inf):
        raise InputError("drop_below", drop_below, "an angle in rad, above 0")


def builtin_names() -> list[str]:
    """Names of the scenes that come with the package, sorted."""
    entries = resources.files("attitude.scene").joinpath("scenes").iterdir()
    return sorted([entry.name.removesuffix(".json") for entry in entries if entry.name.endswith(".json")])


def builtin_text(name: str) -> bytes:
    """The document of a scene that comes with the package; InputError for any other name."""
    if name not in builtin_names():
        raise unknown_name("scene", "scene", name, builtin_names())
    return resources.files("attitude.scene").joinpath("scenes", f"{name}.json").read_bytes()
