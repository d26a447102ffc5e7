"""A document with observations: body, epoch, frame, what is estimated; and the fit of it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

from astropy import units as u
from pydantic import BeforeValidator, Field, StrictBool, ValidationError, model_validator

from ..documents.fields import Number, Part, Text, exactly_one, field_within, input_error, parse_json
from ..ephemeris import Ephemeris
from ..errors import InputError
from ..formats import find_source
from ..frames import rotations
from ..rigid_body.body import RigidBody
from ..scene.builtin_scenes import builtin_text
from ..scene.document_parts import AngularVelocity, Attitude, Body, Epoch, Times
from ..scene.scene import Scene
from ..scene.spin_form import SpinForm
from .fit import prepare
from .fit_result import Fit, FitAnswer
from .observation_table import Table, read_table
from .observations import Attitudes, BodyRates, ObservationSet

Cells = list[Number | str | None]


def _few(columns: Any) -> Any:
    """Refuse too many before each is looked at."""
    if isinstance(columns, dict) and len(columns) > 100:
        raise ValueError("at most 100 columns")
    return columns


class Observations(Part):
    """Observations as columns, with the units in their names (docs/fit.md).

    A value instead of a list is that of every row; `bias`: whether a constant bias of rates and ranges is
    estimated.
    """

    columns: Annotated[dict[str, Cells | Number], BeforeValidator(_few)] = Field(min_length=1)
    label: Text = ""
    frame: str | None = Field(None, examples=["ECLIPJ2000"])
    bias: StrictBool = False

    def build(self, frame: str) -> list[ObservationSet]:
        """The sets, in the frame that is named here, else in that of the document."""
        name = rotations.check_frame(self.frame or frame, "frame")
        return Table(self.columns, name, self.label, self.bias).sets()


class FitDocument(Part):
    """What a fit starts from, and the observations.

    The members of a scene without effects, of which only `body` is needed, and not even it where the inertia
    is estimated; with attitude and angular velocity (or spin) the fit starts from them, without from the
    observations.  `uncertainty` is that of an earlier answer, and no prior.  With the member `scene`, the
    name of a built-in one, its members are taken where they are not given.
    """

    name: Text = ""
    description: Text = ""
    body: Body | None = None
    epoch: Epoch | None = None
    frame: str | None = None
    attitude: Attitude | None = None
    angular_velocity: AngularVelocity | None = None
    spin: SpinForm | None = None
    times: Times | None = None
    effects: list[Any] = Field(default_factory=list, max_length=0)
    relative_to: str | None = None
    orbit: Any = None
    tolerance: Any = None
    ut1: Any = None
    uncertainty: Any = None
    observations: list[Observations] = Field(default_factory=list)
    estimate: list[str] = Field(["attitude", "angular_velocity", "inertia"], min_length=1)
    loss: Literal["linear", "soft_l1", "huber", "cauchy", "arctan"] = "linear"
    absolute_sigma: StrictBool | None = None

    def __init__(self, **document: Any):
        if "scene" in document:
            name = document.pop("scene")
            document = parse_json(builtin_text(name), name) | document
        if document.get("effects"):
            raise InputError("effects", document["effects"], "none: the fit is of free rotation")
        try:
            super().__init__(**document)
        except ValidationError as error:
            raise input_error(error, type(self), document) from None

    @model_validator(mode="after")
    def _check(self) -> FitDocument:
        if self.frame is not None:
            rotations.check_frame(self.frame)
        if (self.attitude is None) != (self.angular_velocity is None):
            raise InputError("attitude", self.attitude, "both attitude and angular_velocity, or neither")
        if self.attitude is not None and self.spin is not None:
            exactly_one(self, ("attitude", "spin"))
        if self.body is None and (self.attitude is not None or self.spin is not None):
            raise InputError("body", None, "a body beside attitude or spin")
        return self

    @classmethod
    def from_json(cls, text: str | bytes, source: str = "document") -> FitDocument:
        """Make the document of JSON text; InputError with the field's path for whatever is wrong."""
        return cls.of(parse_json(text, source))

    @classmethod
    def of(cls, document: Any) -> FitDocument:
        """Make the document of plain data, as JSON text holds it."""
        if not isinstance(document, dict):
            raise InputError("document", document, "a JSON object", steps=())
        return cls(**document)

    def start(self) -> Scene | None:
        """The scene that the fit starts from, if the document has a state."""
        if self.attitude is None and self.spin is None:
            return None
        own = {"observations", "estimate", "loss", "absolute_sigma"}
        members = self.model_dump(exclude=own | {"uncertainty"}, exclude_unset=True, by_alias=True)
        return Scene.model_validate({"times": {"elapsed": [0.0], "unit": "s"}} | members)

    def fit(
        self, observations: Sequence[ObservationSet] = (), progress: Callable[[float], None] | None = None
    ) -> Fit:
        """The fit of the document's observations and of these; `progress` as of `FitInputs.solve`."""
        sets = list(observations)
        for i, each in enumerate(self.observations):
            with field_within(f"observations[{i}].columns"):
                sets += each.build(self.frame or "ICRF")
        if not sets:
            raise InputError("observations", None, "at least one observation")
        inputs = prepare(
            sets,
            None if self.body is None else self.body.build(),
            self.start(),
            self.estimate,
            self.loss,
            self.absolute_sigma,
            None if self.epoch is None else self.epoch.build(),
            self.frame,
        )
        return inputs.solve(progress)

    def answer(self, observations: Sequence[ObservationSet] = ()) -> FitAnswer:
        """The fit as plain data, with the scene of `scene`."""
        result = self.fit(observations)
        return {**result.to_dict(), "scene": self.scene(result).document()}

    def scene(self, result: Fit) -> Scene:
        """The fit's scene, with the name, mass and instants of this document."""
        document = result.scene.document()
        kept = {"name", "description", "times", "orbit", "tolerance", "ut1"}
        document |= self.model_dump(include=kept, exclude_unset=True)
        if self.body is not None and self.body.mass is not None:
            document["body"] |= self.body.model_dump(include={"mass"})
        return Scene.model_validate(document)


def body_in_words(text: str, read: Callable[[str], FitDocument]) -> RigidBody:
    """The body of three moments by commas ("10,13,17": their ratios matter), or of the document read."""
    try:
        moments = [float(word) for word in text.split(",")]
    except ValueError:
        document = read(text)
        if document.body is None:
            raise InputError("inertia", text, "three moments by commas, or a document with a body") from None
        return document.body.build()
    return RigidBody.from_moments(moments)


def read_observations(
    path: str | Path,
    sigma: u.Quantity | float | None = None,
    rate_sigma: u.Quantity | float | None = None,
    frame: str = "ICRF",
) -> list[ObservationSet]:
    """The observations of a file: a CSV table (docs/fit.md), or attitudes in any format that is read.

    sigma : rad, of the attitudes of an ephemeris; rate_sigma : rad/s, with which its rates are used too
    frame : of a table that names none

    Raises FormatError, InputError for what is wrong in it.
    """
    label = Path(path).name
    if Path(path).suffix.lower() in (".csv", ".txt", "") and not _is_ephemeris(path):
        if sigma is not None or rate_sigma is not None:
            raise InputError(
                "sigma",
                sigma if rate_sigma is None else rate_sigma,
                "none beside a table, which has columns for it",
            )
        return read_table(path, frame)
    find_source(path, None)
    data = Ephemeris.read(path)
    sets: list[ObservationSet] = [Attitudes.of(data, sigma, label)]
    if rate_sigma is not None:
        attitudes = sets[0]
        sets.append(
            BodyRates(attitudes.times, rate_sigma, f"{label} rates", data.frame, data.angular_velocity)
        )
    return sets


def _is_ephemeris(path: str | Path) -> bool:
    """Whether a CSV file is an ephemeris of this library."""
    try:
        with open(path, "rb") as stream:
            return b"# metadata: " in stream.read(4096)
    except (OSError, ValueError):
        return False
