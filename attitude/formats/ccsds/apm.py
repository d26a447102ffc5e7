"""CCSDS attitude parameter message (APM), 504.0-B-2 and -1, KVN and XML: read as members of a document.

Products of inertia are those of the tensor, the negative integral (504.0-B-1, 3.2.5.2.5), as in this library.
"""

from __future__ import annotations

import re
from typing import Any, BinaryIO, NamedTuple

import numpy as np

from ...errors import AttitudeError, note, suggestion
from ...frames import rotations
from ...frames.inertial import from_gcrf
from .. import schema
from ..date_text import one_date
from .block_reader import Block, BlockReader, capitals
from .conventions import RowConvention
from .epochs import RowError
from .keywords import HEADER, Keywords, frame_named
from .ndm import NdmLine, Syntax, read_ndm

SYNTAX = Syntax(
    "apm",
    ("1.0", "2.0"),
    {
        "quaternionState": "QUAT",
        "eulerAngleState": "EULER",
        "eulerElementsThree": "EULER",
        "eulerElementsSpin": "SPIN",
        "spin": "SPIN",
        "angularVelocity": "ANGVEL",
        "inertia": "INERTIA",
        "spacecraftParameters": "INERTIA",
        "maneuverParameters": "MAN",
        "metadata": "META",
    },
    {},
)
METADATA = {*HEADER, "OBJECT_NAME", "OBJECT_ID", "CENTER_NAME", "TIME_SYSTEM", "EPOCH"}
KEYWORDS = {
    "QUAT": {"REF_FRAME_A", "REF_FRAME_B", *Keywords.Q, *Keywords.Q_DOT},
    "EULER": {"REF_FRAME_A", "REF_FRAME_B", "EULER_ROT_SEQ", *Keywords.ANGLES, *Keywords.ANGLES_DOT},
    "SPIN": {"REF_FRAME_A", "REF_FRAME_B", *Keywords.SPIN, *Keywords.NUTATION, *Keywords.MOMENTUM},
    "ANGVEL": {"REF_FRAME_A", "REF_FRAME_B", "ANGVEL_FRAME", *Keywords.ANGVEL},
    "INERTIA": {"INERTIA_REF_FRAME", *Keywords.INERTIA},
    "MAN": {"MAN_EPOCH_START", "MAN_DURATION", "MAN_REF_FRAME", *Keywords.TORQUE, "MAN_DELTA_MASS"},
}
# Of version 1: the block of a keyword, and its name in version 2.
FIRST_VERSION = {
    **{
        f"{prefix}_{old}": (block, name)
        for prefix, block in (("Q", "QUAT"), ("EULER", "EULER"), ("SPIN", "SPIN"))
        for old, name in (("FRAME_A", "REF_FRAME_A"), ("FRAME_B", "REF_FRAME_B"), ("DIR", "DIR"))
    },
    **{name: ("QUAT", name) for name in (*Keywords.Q, *Keywords.Q_DOT)},
    **{name: ("EULER", name) for name in ("EULER_ROT_SEQ", "RATE_FRAME")},
    **{name: ("SPIN", name) for name in (*Keywords.SPIN, *Keywords.NUTATION)},
    "INERTIA_REF_FRAME": ("INERTIA", "INERTIA_REF_FRAME"),
    **{
        f"I{axes}": ("INERTIA", name)
        for axes, name in zip((11, 22, 33, 12, 13, 23), Keywords.INERTIA, strict=True)
    },
    **{name: ("MAN", name) for name in ("MAN_EPOCH_START", "MAN_DURATION", "MAN_REF_FRAME")},
    **{f"MAN_TOR_{i}": ("MAN", name) for i, name in enumerate(Keywords.TORQUE, start=1)},
}
MAX_DISAGREEMENT = 1e-2  # rad, and of a rate: of blocks that state the same in few digits


class StatedAttitude(NamedTuple):
    """An attitude that a block states: wxyz, body to external frame, and the rate along the body's axes."""

    block: Block
    quaternion: np.ndarray
    rate: np.ndarray | None


def scene_members(stream: BinaryIO, source: str) -> dict[str, Any]:
    """The members of a scene's document that an APM states: all but `times`, and what it leaves out.

    Manoeuvres are effects `constant_torque`.  Blocks that state one thing twice must agree within 1e-2.
    """
    message = read_ndm(stream, source, SYNTAX)
    return _Message(message.version, message.lines, source).members()


class _Message(BlockReader):
    """The blocks of an APM."""

    def __init__(self, version: str, lines: list[NdmLine], source: str):
        super().__init__(source)
        self.version = version
        self.fields: dict[str, NdmLine] = {}
        self.blocks: list[Block] = []
        self.open: Block | None = None
        self.angles = 0  # of a version 1 block, which names them by their axes
        for line in lines:
            if line.keyword.endswith(("_START", "_STOP")) and not line.value:
                self._mark(line)
            elif not line.keyword:
                raise self.error(f"{line.value[:40]!r} where KEYWORD = value belongs", line.number)
            elif version == "1.0":
                self._add_first_version(line)
            else:
                self._add(line)
        if self.open is not None:
            raise self.error(f"no {self.open.name}_STOP", self.open.number)
        self.external = self.body = ""

    def _mark(self, line: NdmLine) -> None:
        """Begin or end a block; in version 1, keywords do."""
        name, _, mark = line.keyword.rpartition("_")
        if name == "META" or self.version == "1.0":
            return
        is_start = mark == "START"
        belongs = not self.open and name in KEYWORDS if is_start else self.open and self.open.name == name
        if not belongs:
            raise self.error(f"{line.keyword[:40]} does not belong here", line.number)
        self.open = Block(name, line.number, {}, []) if is_start else None
        if self.open:
            self.blocks.append(self.open)

    def _add(self, line: NdmLine) -> None:
        known = KEYWORDS[self.open.name] if self.open else METADATA
        fields = self.open.fields if self.open else self.fields
        if line.keyword not in known:
            where = f"a block {self.open.name}" if self.open else "the header and metadata"
            raise self.error(
                f"{line.keyword[:40]!r} is no keyword of {where}{suggestion(line.keyword, known)}",
                line.number,
            )
        if line.keyword in fields:
            raise self.error(f"{line.keyword} twice", line.number)
        fields[line.keyword] = line

    def _add_first_version(self, line: NdmLine) -> None:
        """Version 1 has no delimiters in KVN: a keyword tells its block, and MAN_EPOCH_START a new one."""
        if line.keyword in METADATA:
            self.fields.setdefault(line.keyword, line)
            return
        block, name = FIRST_VERSION.get(line.keyword, ("", ""))
        turn = re.fullmatch(r"[XYZ]_(ANGLE|RATE)|rotation[123]", line.keyword)
        if turn:
            block, names = "EULER", (*Keywords.ANGLES, *Keywords.ANGLES_DOT)
            self.angles = 3 if turn[1] == "RATE" and self.angles < 3 else self.angles
            if self.angles > 5:
                raise self.error("more than three angles and rates", line.number)
            name, self.angles = names[self.angles], self.angles + 1
        if not block:
            raise self.error(f"{line.keyword[:40]!r} is no keyword of version 1", line.number)
        is_new = line.keyword == "MAN_EPOCH_START" or not any(b.name == block for b in self.blocks)
        if is_new:
            self.blocks.append(Block(block, line.number, {}, []))
        lines = next(b for b in reversed(self.blocks) if b.name == block).fields
        if name in lines:
            raise self.error(f"{line.keyword} twice", line.number)
        lines[name] = line._replace(keyword=name)

    # -- what it states ---------------------------------------------------------------------------

    def members(self) -> dict[str, Any]:
        """Members of a scene's document."""
        for name in ("OBJECT_NAME", "TIME_SYSTEM", "EPOCH"):
            if name not in self.fields:
                raise self.error(f"no {name}")
        epoch = self.instants(self.fields["TIME_SYSTEM"], [self.fields["EPOCH"]]).epoch
        assert epoch is not None
        document: dict[str, Any] = {
            "name": self.fields["OBJECT_NAME"].value,
            "epoch": {"time": one_date(epoch), "scale": epoch.scale},
        }
        if "CENTER_NAME" in self.fields and self.fields["CENTER_NAME"].value.upper() != "EARTH":
            note(
                f"{self.source}: CENTER_NAME {self.fields['CENTER_NAME'].value} is not used without an orbit"
            )
        document |= self._state() | self._inertia() | self._manoeuvres()
        return document

    def _frames_agreed(self, block: Block) -> tuple[str, bool]:
        """External frame of a block, and whether it is frame A; all blocks must have the same two frames."""
        external, body, is_a = self.frames(block)
        for own, name in (("external", external), ("body", body)):
            if getattr(self, own) not in ("", name):
                reason = f"{own} frame {name}, and {getattr(self, own)} in a block before"
                raise self.error(reason, block.number)
            setattr(self, own, name)
        return external, is_a

    def _state(self) -> dict[str, Any]:
        """Attitude and rate, relative to the frame that blocks state."""
        states = [self._attitude(block) for block in self.blocks if block.name in ("QUAT", "EULER", "SPIN")]
        if not states:
            raise self.error("no attitude: none of the blocks QUAT, EULER and SPIN")
        first = min(states, key=lambda state: ("QUAT", "EULER", "SPIN").index(state.block.name))
        for other in states:
            apart = float(rotations.angle_between(first.quaternion, other.quaternion))
            if apart > MAX_DISAGREEMENT:
                reason = (
                    f"the attitudes of {first.block.name} and {other.block.name} are {apart:.3g} rad apart"
                )
                raise self.error(reason, other.block.number)
        rates = [
            (block.number, self._angular_velocity(block, first))
            for block in self.blocks
            if block.name == "ANGVEL"
        ]
        rates += [(state.block.number, state.rate) for state in states if state.rate is not None]
        members: dict[str, Any] = {
            "attitude": {"quaternion": first.quaternion.tolist(), "order": "wxyz"},
        }
        is_turning = self.external in rotations.TURNING_FRAMES
        members["frame"] = "GCRF" if is_turning else self.external
        members |= {"relative_to": self.external} if is_turning else {}
        if rates:
            rate = rates[0][1]
            for number, other_rate in rates[1:]:
                apart, size = (float(np.sqrt((v**2).sum())) for v in (rate - other_rate, rate))
                if apart > MAX_DISAGREEMENT * size:
                    raise self.error(f"angular velocities of two blocks are {apart:.3g} rad/s apart", number)
            members["angular_velocity"] = {"value": rate.tolist(), "unit": "rad/s"}
        return members

    def _attitude(self, block: Block) -> StatedAttitude:
        """The attitude of a block, and its rate where it states one."""
        frame, is_a = self._frames_agreed(block)
        direction = block.fields["DIR"].value.upper() if "DIR" in block.fields else "A2B"
        if direction not in ("A2B", "B2A"):
            raise self.error(f"{direction[:20]!r} is neither A2B nor B2A", block.fields["DIR"].number)
        is_to_body = is_a == (direction == "A2B")
        attitude, *rates = {
            "QUAT": (Keywords.Q, Keywords.Q_DOT),
            "EULER": (Keywords.ANGLES, Keywords.ANGLES_DOT),
            "SPIN": (Keywords.SPIN, Keywords.MOMENTUM, Keywords.NUTATION),
        }[block.name]
        stated = (names for names in rates if any(name in block.fields for name in names))
        columns = attitude + next(stated, ())
        axes = self.euler_axes(block) if block.name == "EULER" else ""
        if block.name == "SPIN" and not is_to_body:
            raise self.error("a spin is relative to frame A, and frame B is the body's", block.number)
        values = np.array([[self.number(block, name)] for name in columns])
        try:
            q, rate = RowConvention(columns, frame, is_to_body, True, axes).convert(values)
            q = schema.unit_rows(q.T, self.source)[0]
        except (RowError, AttitudeError) as error:
            raise self.error(getattr(error, "reason", str(error)), block.number) from None
        return StatedAttitude(block, q, None if rate is None else rate[:, 0])

    def _angular_velocity(self, block: Block, state: StatedAttitude) -> np.ndarray:
        """(3,) rad/s of the body relative to the external frame, along the body's axes."""
        _, is_a = self._frames_agreed(block)
        rate = np.deg2rad([self.number(block, name) for name in Keywords.ANGVEL])
        line = block.fields.get("ANGVEL_FRAME")
        name = "" if line is None else capitals(line)
        if name not in (self.body, "REF_FRAME_A", "REF_FRAME_B") and frame_named(name) != self.external:
            raise self.error(f"ANGVEL_FRAME {name[:40]!r} is none of both frames", block.number)
        is_body = name in (self.body, "REF_FRAME_B" if is_a else "REF_FRAME_A")
        rate = rate if is_a else -rate
        return rate if is_body else rotations.rotate(rotations.conjugate(state.quaternion), rate)

    def _inertia(self) -> dict[str, Any]:
        """The body; several blocks must agree."""
        tensors, physical = [], True
        for block in self.blocks:
            if block.name != "INERTIA":
                continue
            line = block.fields.get("INERTIA_REF_FRAME")
            if line is not None and capitals(line) != self.body:
                reason = f"INERTIA_REF_FRAME = {line.value[:40]}, and attitudes are those of {self.body}"
                raise self.error(reason, line.number)
            tensors.append(self.tensor(block))
            physical = self.rigid_body(block).physical
            if tensors[-1] != tensors[0]:
                raise self.error("two blocks INERTIA that differ", block.number)
        body = {"body": {"tensor": tensors[0], "unit": "kg m2"}} if tensors else {}
        return body if physical else {"body": {**body["body"], "physical": False}}

    def _manoeuvres(self) -> dict[str, Any]:
        """Torques between their start and stop, in the order of the message."""
        effects = []
        for block in self.blocks:
            if block.name != "MAN":
                continue
            line = self.needed(block, "MAN_EPOCH_START")
            epochs = self.fields["EPOCH"], line
            start = float(self.instants(self.fields["TIME_SYSTEM"], epochs).seconds[1])
            duration = self.number(block, "MAN_DURATION")
            torque = np.array([self.number(block, name) for name in Keywords.TORQUE])
            if duration < 0.0:
                raise self.error(f"MAN_DURATION is {duration!r} s", block.fields["MAN_DURATION"].number)
            if "MAN_DELTA_MASS" in block.fields:
                self.number(block, "MAN_DELTA_MASS")
                note(f"{self.source}: MAN_DELTA_MASS is not used")
            if duration == 0.0 or not torque.any():
                text = f"the manoeuvre at {line.value} has no duration or no torque, and no effect"
                note(f"{self.source}: {text}")
                continue
            axes, torque = self._torque_axes(block, torque)
            effects.append(
                {
                    "type": "constant_torque",
                    "torque": {"value": torque.tolist(), "unit": "N m"},
                    "frame": axes,
                    "start": {"value": start, "unit": "s"},
                    "stop": {"value": start + duration, "unit": "s"},
                }
            )
        return {"effects": effects} if effects else {}

    def _torque_axes(self, block: Block, torque: np.ndarray) -> tuple[str, np.ndarray]:
        """Axes of a torque's components, the body's or those of the scene's frame, and the components."""
        line = self.needed(block, "MAN_REF_FRAME")
        name = capitals(line)
        frame = frame_named(name)
        if name == self.body:
            return "body", torque
        scene = "GCRF" if self.external in rotations.TURNING_FRAMES else self.external
        if frame == scene:
            return "inertial", torque
        if frame not in rotations.INERTIAL_FRAMES or "INERTIAL" in (frame, scene):
            reason = (
                f"MAN_REF_FRAME = {line.value[:40]}: the frame of the body, {self.body}, or an inertial one"
            )
            raise self.error(reason, line.number)
        to_scene = from_gcrf(scene, "a manoeuvre") @ from_gcrf(frame, "a manoeuvre").T
        return "inertial", to_scene @ torque
