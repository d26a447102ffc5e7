"""The methods that the cost compares, by the names that select them.

ours               the library's closed form
library_solvers    the library's solver for motion under torques, and the closed form of rotors alone
published          the closed form as van Zon & Schofield published it
fixed_step         Runge-Kutta, order 4, fixed steps
scipy_integrators  DOP853 and LSODA
heyoka, orekit     peers, where they are installed
heyoka_torques     torques as heyoka's expressions

principal_frame, euler   shared: principal axes, powers of two as units; Euler's equations, compiled
torques                  the equations of motion under torques, compiled, and their extrapolation
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

from ...errors import InputError, suggestion
from ..method import Method
from . import fixed_step, heyoka, library_solvers, orekit, ours, published, scipy_integrators

FAMILIES: dict[str, Callable[[], list[Method]]] = {
    "ours": ours.methods,
    "published": published.methods,
    "rk4": fixed_step.methods,
    "dop853": scipy_integrators.dop853,
    "lsoda": scipy_integrators.lsoda,
    "heyoka": heyoka.methods,
    "orekit": orekit.methods,
}

UNDER_TORQUES: dict[str, Callable[[], list[Method]]] = {
    "automatic": library_solvers.automatic,
    "gauss": library_solvers.gauss,
    "dop853": scipy_integrators.dop853,
    "heyoka": heyoka.methods,
    "exact": library_solvers.exact,
}


def select_methods(
    names: Iterable[str] | None = None, families: dict[str, Callable[[], list[Method]]] = FAMILIES
) -> list[Method]:
    """Every setting of the named families, or of all, in the order of `families`.

    Parameters
    ----------
    names : keys of `families`, in any case

    Raises
    ------
    InputError : a name that is not a key of `families`.
    """
    selected = set(families) if names is None else {name.lower() for name in names}
    for name in selected - set(families):
        raise InputError("method", name, f"one of {', '.join(families)}{suggestion(name, families)}")
    return [method for name, family in families.items() if name in selected for method in family()]
