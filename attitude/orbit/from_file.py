"""An orbit in a file: OEM, STK ephemeris, CSV or SPK, interpolated as the file states."""

from __future__ import annotations

import io
from itertools import pairwise
from typing import TYPE_CHECKING, Any, ClassVar, Literal

import numpy as np
from pydantic import Field, model_validator

from .. import stopping
from ..documents.fields import exactly_one
from ..documents.files import document_path
from ..errors import FormatError, InputError
from ..formats.orbits import OrbitCurve, OrbitRows, OrbitSegment, parse_orbit, read_orbit
from ..frames.rotations import INERTIAL_FRAMES, ORBITAL_FRAMES, TURNING_FRAMES, rotate
from ..problem.initial_state import CentralBody, OrbitPath
from ..samples.transform import rotation_between
from ..times.instants import Instants, as_instants
from ..times.julian_dates import DAY, J2000
from .orbit import AboutABody
from .piecewise_polynomial import VectorFunction
from .state_table import SLACK, Curves, StateTable, best_curves, check_table, curves_path

if TYPE_CHECKING:
    from astropy.time import Time

FORMS = ("file", "oem", "stk", "csv")  # how it is given
SPK_STEP = 60.0  # s, of rows to which the intervals of an SPK's polynomials are compared in length


class OrbitFile(AboutABody):
    """`{"file": "x.oem"}`; or its content, `{"oem": text}`, `{"stk": text}`, `{"csv": text}`.

    Files are OEM (KVN or XML), STK ephemerides (.e), tables (.csv) and, by SPICE, SPK (.bsp); `format` names
    another format than that of the ending.  A relative path is relative to the document's folder.  `object`
    is the one of several objects.  `frame` is that of a table which states none; by default the scene's.
    `ut1` is as that of a scene, for files in ITRF.
    """

    FORM: ClassVar[str] = "file of positions"

    file: str | None = Field(None, min_length=1, examples=["satellite.oem"])
    oem: str | None = None
    stk: str | None = None
    csv: str | None = None
    format: Literal["oem", "stk", "csv", "spk"] | None = None
    object: str | None = None
    frame: str | None = Field(None, examples=["ITRF"])
    ut1: Literal["tables", "utc"] = "tables"
    _content: OrbitRows | OrbitCurve

    @model_validator(mode="after")
    def _read(self) -> OrbitFile:
        form = self._form
        if self.format is not None and form != "file":
            raise InputError("format", self.format, f"no format beside {form}")
        try:
            if self.file is not None:
                self._content = read_orbit(self.file, self.format, self.object)
            else:
                text = getattr(self, form).encode("utf-8", "replace")
                self._content = parse_orbit(io.BytesIO(text), form, form, self.object)
        except FormatError as error:
            raise InputError(form, self.file or f"a text of {len(text)} bytes", str(error)) from None
        self._check_frame()
        self.central()
        return self

    def _check_frame(self) -> None:
        stated = self._content.frame if isinstance(self._content, OrbitRows) else "ICRF"
        if stated and self.frame not in (None, stated):
            raise InputError("frame", self.frame, f"no frame, since the file states {stated}")
        frame = stated or self.frame or "ICRF"
        known = (INERTIAL_FRAMES.keys() | TURNING_FRAMES.keys()) - set(ORBITAL_FRAMES)
        if frame not in known:
            expected = f"positions along one of {', '.join(sorted(known))}"
            raise InputError("frame" if self.frame else self._form, frame, expected)

    def central(self) -> CentralBody:
        """Return the central body: the Earth, or the centre of the file with the document's `mu`."""
        center = self._content.center
        if self.mu is None and center not in ("", "EARTH", "399"):
            raise InputError("mu", None, f"the gravitational parameter of {center}, the centre of the file")
        return super().central()

    def check_span(self, start: float, stop: float, epoch: Time | None) -> None:
        """Refuse a span, s since the epoch, that the file does not cover; the error names what it covers."""
        ends = self._covered(epoch)
        if start < ends[0][0] - SLACK or stop > ends[-1][1] + SLACK:
            self._refuse(ends[0][0], ends[-1][1], "covers", start, stop, epoch)
        for before, after in pairwise(ends):
            if after[0] > before[1] + SLACK and before[1] < stop and after[0] > start:
                self._refuse(before[1], after[0], "has a gap", start, stop, epoch)

    def _refuse(
        self, first: float, last: float, verb: str, start: float, stop: float, epoch: Time | None
    ) -> None:
        from astropy import units as u

        def text(seconds: float) -> str:
            date = "" if epoch is None else f" ({(epoch + seconds * u.s).isot} {epoch.scale.upper()})"
            return f"{seconds:.9g} s{date}"

        covered = f"it {verb} from {text(first)} to {text(last)}"
        expected = f"an orbit over the whole span, {text(start)} to {text(stop)}; {covered}"
        raise InputError(self._form, self.file or "a text", expected)

    @property
    def _form(self) -> str:
        return exactly_one(self, FORMS)

    def _covered(self, epoch: Time | None) -> list[tuple[float, float]]:
        """First and last second since the epoch of each segment, in order."""
        if isinstance(self._content, OrbitCurve):
            from astropy.time import Time as AstropyTime

            ends = np.ravel(self._content.intervals)
            dates = AstropyTime(J2000, ends / DAY, format="jd", scale="tdb")
            seconds = as_instants(dates, self._epoch(epoch), "epoch").seconds
            return [(float(a), float(b)) for a, b in seconds.reshape(-1, 2)]
        offsets = [self._offset(segment, epoch) for segment in self._content.segments]
        return [
            (segment.useable[0] + offset, segment.useable[1] + offset)
            for segment, offset in zip(self._content.segments, offsets, strict=True)
        ]

    def _epoch(self, epoch: Time | None) -> Time:
        if epoch is None:
            raise InputError("epoch", None, "an epoch; the times of the orbit's file are dates")
        return epoch

    def _offset(self, segment: OrbitSegment, epoch: Time | None) -> float:
        """Seconds from the scene's epoch to that of the segment's instants."""
        stopping.check()
        if segment.instants.epoch is None:
            return 0.0
        return float(as_instants(segment.instants.epoch, self._epoch(epoch), "epoch").seconds)

    def path(self, start: float, stop: float, epoch: Time | None, frame: str) -> OrbitPath:
        """Interpolate the file over the span, and a row beyond where it has one, in the scene's frame."""
        self.check_span(start, stop, epoch)
        content, central = self._content, self.central()
        if isinstance(content, OrbitCurve):
            curves, margin = self._spk_curves(content, epoch, stop - start), SPK_STEP
            covered, source = self._covered(epoch), "ICRF"
        else:
            source = content.frame or self.frame or frame
            tables = [self._table(segment, epoch, central) for segment in content.segments]
            spans = self._covered(epoch)
            used = [k for k, (a, b) in enumerate(spans) if b >= start - SLACK and a <= stop + SLACK]
            covered = [spans[k] for k in used]
            each = [self._curves(tables[k], content.segments[k], start, stop) for k in used]
            margin = max(float(np.diff(tables[k].seconds).max()) for k in used)
            curves = Curves.joined(each, [ends[0] for ends in covered[1:]])
        first, last = max(covered[0][0], start - margin), min(covered[-1][1], stop + margin)
        curves = self._turned(curves, source, frame, epoch)
        return curves_path(curves, (min(first, start), max(last, stop)), start, central, self._form)

    def _table(self, segment: OrbitSegment, epoch: Time | None, central: CentralBody) -> StateTable:
        seconds = np.asarray(segment.instants.seconds) + self._offset(segment, epoch)
        method = segment.method
        uses_velocities = method is None or method.kind == "hermite"
        table = StateTable(seconds, segment.positions, segment.velocities if uses_velocities else None)
        check_table(table, central, (self._form,) * 3)
        return table

    def _curves(self, table: StateTable, segment: OrbitSegment, start: float, stop: float) -> Curves:
        stopping.check()
        count = None if segment.method is None else segment.method.node_count
        step = float(np.diff(table.seconds).max())
        part = table.part(start - step, stop + step, max(14, count or 0))
        return best_curves(part, self._form, count)

    def _spk_curves(self, content: OrbitCurve, epoch: Time | None, span: float) -> Curves:
        """The curve of SPICE, which is what the file says: no other is nearer to the truth."""

        def curve(t: np.ndarray) -> np.ndarray:
            time = Instants(t, None, self._epoch(epoch)).time
            assert time is not None
            return content.position((time.tdb.jd1 - J2000) * DAY + time.tdb.jd2 * DAY)

        return Curves(curve, curve, 0.0, max(4, int(span / SPK_STEP)))

    def _turned(self, curves: Curves, source: str, frame: str, epoch: Time | None) -> Curves:
        """The curves along the axes of the scene's frame."""
        if source == frame:
            return curves

        def turned(curve: VectorFunction) -> VectorFunction:
            def along(t: np.ndarray) -> np.ndarray:
                turn = rotation_between(source, frame, Instants(t, None, epoch), self.ut1)
                return curve(t) if turn is None else rotate(turn.quaternion, curve(t))

            return along

        return curves.changed(turned)


def with_path(value: dict[str, Any]) -> dict[str, Any]:
    """The document of an orbit with the path of its file; InputError where documents may name none."""
    if not isinstance(value.get("file"), str) or not value["file"]:
        return value
    return {**value, "file": document_path(value["file"], 'the content of the file, as {"oem": "..."}')}
