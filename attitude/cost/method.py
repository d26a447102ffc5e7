"""A method: how to compute attitude and body rate, with one setting of its accuracy."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np

from ..errors import AttitudeError
from .initial_value_problem import InitialValueProblem

Solve = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]
"""(n,) ascending instants from 0, s -> quaternions (n, 4), wxyz, and body rates (n, 3), rad/s."""


class AbsentError(AttitudeError):
    """A method is not available: its package is not installed, or it cannot take these torques.

    The message says which, and how to install it.
    """


def method_name(family: str, setting: str) -> str:
    """Family and setting in one line."""
    return f"{family}, {setting}" if setting else family


@dataclass(frozen=True)
class Method:
    """One setting of one family of methods.

    Attributes
    ----------
    family : name of the method, one line of the diagram: "DOP853 (SciPy)"
    setting : its accuracy, "rtol 1e-9"; empty for a method without one
    prepare : the set-up for one problem, timed as such; returns the function that evaluates the solution.
        Raises AbsentError; any other exception, then or later, is the method's failure on the problem.
    steps : whether it steps through the time between the samples, so that cost follows the horizon
    """

    family: str
    setting: str
    prepare: Callable[[InitialValueProblem], Solve]
    steps: bool

    @property
    def name(self) -> str:
        """Family and setting in one line."""
        return method_name(self.family, self.setting)


@contextmanager
def quiet() -> Iterator[None]:
    """Suppress warnings of a method: their causes show in its errors."""
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        yield
