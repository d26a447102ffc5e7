"""Base classes of the forms in which an orbit is given."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, ClassVar, Literal

from ..documents.fields import Part
from ..documents.quantities import ABOVE_ZERO, GravitationalParameter, Length
from ..problem.initial_state import CentralBody, OrbitPath

if TYPE_CHECKING:
    from astropy.time import Time


class OrbitDefinition(Part):
    """The document's `orbit`."""

    def check_span(self, start: float, stop: float, epoch: Time | None) -> None:
        """Refuse a span, s since the epoch, over which the orbit is not known."""

    def path(self, start: float, stop: float, epoch: Time | None, frame: str) -> OrbitPath:
        """Orbit of the centre of mass as kernels take it, over a span from start to stop, s since the epoch.

        Raises InputError with the field relative to the orbit.
        """
        raise NotImplementedError

    def central(self) -> CentralBody:
        """Return the central body; InputError where `mu` or `radius` is not positive."""
        raise NotImplementedError

    def summary(self) -> str:
        """The form of the orbit and its gravitational parameter, for people."""
        return type(self).__name__


class AboutABody(OrbitDefinition):
    """About the Earth, or about a body by its `mu` and, where an effect needs it, its `radius`.

    `central_body: "earth"` keeps the Earth's rotation, field and Sun beside another `mu`.
    """

    FORM: ClassVar[str]

    mu: Annotated[GravitationalParameter, ABOVE_ZERO] | None = None
    radius: Annotated[Length, ABOVE_ZERO] | None = None
    central_body: Literal["earth"] | None = None

    def central(self) -> CentralBody:
        """Return the central body."""
        is_earth = self.mu is None or self.central_body == "earth"
        nominal = earth()
        mu = nominal.mu if self.mu is None else self.mu.si
        radius = None if self.radius is None else self.radius.si
        if radius is None and (self.central_body == "earth" or self.mu is None):
            radius = nominal.radius
        return CentralBody(mu, radius, is_earth)

    def summary(self) -> str:
        """The form of the orbit and its gravitational parameter, for people."""
        central = self.central()
        body = "about the Earth, " if central.is_earth else ""
        return f"{self.FORM}, {body}GM {parameter_text(central, self.mu)}"


def parameter_text(central: CentralBody, stated: GravitationalParameter | None) -> str:
    """The gravitational parameter, and where it comes from, for people."""
    source = " (nominal, IAU 2015 resolution B3: none is in the document)" if stated is None else ""
    return f"{central.mu:.10g} m3/s2{source}"


def earth() -> CentralBody:
    """Return the Earth of astropy.constants: nominal values of IAU 2015 resolution B3, equatorial radius."""
    from astropy.constants import GM_earth, R_earth

    return CentralBody(float(GM_earth.value), float(R_earth.value), is_earth=True)
