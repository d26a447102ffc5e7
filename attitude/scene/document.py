"""The scene document, one JSON for library, command and HTTP: its members, checked, and its state in SI."""

from __future__ import annotations

import json
import os
from functools import partial
from pathlib import Path
from typing import Any, Literal, Self

import numpy as np
from astropy.time import Time
from pydantic import Field, ValidationError, model_validator

from ..documents.fields import Part, Text, field_within, input_error, parse_json
from ..documents.files import files_in
from ..documents.quantities import LengthVector, SpeedVector
from ..effects import KNOWN_EFFECTS, AnyEffect
from ..errors import InputError, emit_warning, file_errors, noted
from ..frames import rotations
from ..motion import TorqueFreeMotion
from ..orbit import AnyOrbit
from ..orbit.ephemeris_orbit import EphemerisOrbit
from ..orbit.orbit import OrbitDefinition
from ..problem.initial_state import InitialState, OrbitPath
from ..samples.transform import rotation_to
from ..times.instants import Instants
from . import consistency
from .builtin_scenes import builtin_names, builtin_text
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
from .message_members import with_message
from .spin_form import SpinForm
from .uncertainty_form import UncertaintyForm


class SceneDocument(Part):
    """The members of a scene; `attitude.scene.scene.Scene` computes what they describe."""

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
    def _check(self) -> Self:
        if self.solver in ("splitting", "dop853"):  # which documents may still name
            text = f"solver: {self.solver} is no longer offered; gauss, to the same tolerance, is used"
            emit_warning(text, 2, FutureWarning)
        consistency.check(self)
        return self

    def __init__(self, **document: Any):
        if "scene" in document:
            name = document.pop("scene")
            document = parse_json(builtin_text(name), name) | document
        try:
            with noted() as notes:
                if "apm" in document:
                    document = with_message(document)
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
    def model_validate(cls, document: Any) -> Self:  # type: ignore[override]
        """Make a scene of plain data, as JSON text holds it."""
        if not isinstance(document, dict) or not set(map(type, document)) <= {str}:
            raise InputError("document", document, "a JSON object", steps=())
        return cls(**document)

    @classmethod
    def from_json(cls, text: str | bytes, source: str = "document") -> Self:
        """Make a scene of JSON text.  Refuses NaN, Infinity, duplicate keys, which JSON readers let pass."""
        return cls.model_validate(parse_json(text, source))

    @classmethod
    def read(cls, path: str | Path, times: dict[str, Any] | None = None) -> Self:
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
    def load(cls, source: Any) -> Self:
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
        if is_path or os.path.isfile(name):
            return cls.read(name)
        return cls.builtin(name)

    @classmethod
    def builtin(cls, name: str) -> Self:
        """One of the scenes that come with the package."""
        return cls.from_json(builtin_text(name), name)

    def to_json(self) -> str:
        """The document as JSON text; `from_json` of it is this scene."""
        return json.dumps(self.document(), indent=2, ensure_ascii=False)

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
        """rad: the document's `tolerance`, or 1e-9 without; of the best answer, the least allowed."""
        if self.wants_best:
            return MIN_TOLERANCE
        return self.tolerance.si if isinstance(self.tolerance, Tolerance) else 1e-9

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
            consistency.check_magnitudes(body.moments, rate)
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
        with noted() as notes:
            motion = TorqueFreeMotion(
                self.body.build(), *self.state(), order="wxyz", frame=self.inertial_frame
            )
        motion.notes, motion.epoch = tuple(notes), self.epoch_time  # which is checked already
        return motion

    @property
    def inertial_frame(self) -> str:
        """The frame that the motion is computed in: `frame`, or for TEME its axes at the epoch."""
        return rotations.TEME_AT_EPOCH if self.frame == "TEME" else self.frame

    @property
    def is_plain(self) -> bool:
        """Whether only the attitude of a free body is computed."""
        return not self.effects and self.position is None

    def ephemeris_orbit(self) -> EphemerisOrbit | None:
        """The orbit, for frames that follow it; computed when such a frame is requested."""
        if self.orbit is None:
            return None
        path = partial(_orbit_path, self.orbit, self.inertial_frame, self.epoch_time)
        return EphemerisOrbit(path, partial(self.times.span, self.epoch_time), self.inertial_frame)


def _orbit_path(
    orbit: OrbitDefinition, frame: str, epoch: Time | None, start: float, stop: float
) -> OrbitPath:
    with field_within("orbit"):
        return orbit.path(start, stop, epoch, frame)
