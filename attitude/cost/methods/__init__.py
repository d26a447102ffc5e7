"""The methods that are compared, by the names that select them.

ours               the library itself
published          the closed form as its authors printed it
runge_kutta        fixed steps
scipy_integrators  DOP853 and LSODA
heyoka, orekit     peers, where they are installed

principal, euler   what they share: principal axes, units near one; the equations of motion, compiled
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

from ...errors import InputError
from ..method import Method
from . import heyoka, orekit, ours, published, runge_kutta, scipy_integrators

FAMILIES: dict[str, Callable[[], list[Method]]] = {
    "ours": ours.ladder,
    "plain": ours.plain,
    "published": published.ladder,
    "rk4": runge_kutta.ladder,
    "dop853": scipy_integrators.dop853,
    "lsoda": scipy_integrators.lsoda,
    "heyoka": heyoka.ladder,
    "orekit": orekit.ladder,
}


def ladder(names: Iterable[str] | None = None) -> list[Method]:
    """Every setting of the families named (keys of FAMILIES, in any case), or of all, in one fixed order.

    Raises InputError for a name that is none of them.
    """
    wanted = set(FAMILIES) if names is None else {_known(name) for name in names}
    return [method for name, family in FAMILIES.items() if name in wanted for method in family()]


def _known(name: str) -> str:
    if name.lower() not in FAMILIES:
        raise InputError("method", name, f"one of {', '.join(FAMILIES)}")
    return name.lower()
