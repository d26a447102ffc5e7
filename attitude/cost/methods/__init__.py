"""The methods that are compared, by the names that select them.

ours               the library itself: the closed form
stepping           the library itself: its solvers under torques
published          the closed form as its authors printed it
runge_kutta        fixed steps
scipy_integrators  DOP853 and LSODA
heyoka, orekit     peers, where they are installed
heyoka_torques     what heyoka is told of torques

principal, euler   what they share: principal axes, units near one; the equations of motion, compiled
torques            the equations under torques, compiled, and their integration to the last digits
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

from ...errors import InputError
from ..method import Method
from . import heyoka, orekit, ours, published, runge_kutta, scipy_integrators, stepping

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

UNDER_TORQUES: dict[str, Callable[[], list[Method]]] = {
    "automatic": stepping.automatic,
    "splitting": stepping.splitting,
    "gauss": stepping.gauss,
    "compiled": stepping.compiled,
    "dop853": scipy_integrators.dop853,
    "heyoka": heyoka.ladder,
}


def ladder(
    names: Iterable[str] | None = None, families: dict[str, Callable[[], list[Method]]] = FAMILIES
) -> list[Method]:
    """Every setting of the families named (keys, in any case), or of all, in one fixed order.

    Raises InputError for a name that is none of them.
    """
    wanted = set(families) if names is None else {_known(name, families) for name in names}
    return [method for name, family in families.items() if name in wanted for method in family()]


def _known(name: str, families: dict[str, Callable[[], list[Method]]]) -> str:
    if name.lower() not in families:
        raise InputError("method", name, f"one of {', '.join(families)}")
    return name.lower()
