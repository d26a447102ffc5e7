"""Base classes of the forms in which an orbit is given."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..documents.fields import Part
from ..documents.quantities import GravitationalParameter, Length, check_positive
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


class AboutABody(OrbitDefinition):
    """About the Earth, or about a body by its `mu` and, where an effect needs it, its `radius`."""

    mu: GravitationalParameter | None = None
    radius: Length | None = None

    def central(self) -> CentralBody:
        """Return the central body; InputError where `mu` or `radius` is not positive."""
        check_positive(self, "mu", "radius")
        if self.mu is None and self.radius is None:
            return earth()
        mu = earth().mu if self.mu is None else self.mu.si
        return CentralBody(mu, None if self.radius is None else self.radius.si, is_earth=self.mu is None)


def earth() -> CentralBody:
    """Return the Earth of astropy.constants: nominal values of IAU 2015 resolution B3, equatorial radius."""
    from astropy.constants import GM_earth, R_earth

    return CentralBody(float(GM_earth.value), float(R_earth.value), is_earth=True)
