"""What a method is: a way to come by the attitude, with one setting of its accuracy."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..errors import AttitudeError
from .problem import Problem

Solve = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]
"""(n,) ascending instants from 0, s -> quaternions (n, 4), wxyz, and body rates (n, 3), rad/s."""


class AbsentError(AttitudeError):
    """A method that is not there: its package is not installed, or it is none for these torques.

    The message says which, and what would install it.
    """


@dataclass(frozen=True)
class Method:
    """One setting of one family of methods.

    Attributes
    ----------
    family : what it is, a line of the diagram: "DOP853 (SciPy)"
    setting : its accuracy: "rtol 1e-9"; empty where there is none to choose
    prepare : the set-up for one problem, timed as such; gives the function that answers instants.
        Raises AbsentError; any other exception, then or later, is the method's failure on the problem.
    steps : whether it steps through the time between the samples, so that cost follows the horizon
    """

    family: str
    setting: str
    prepare: Callable[[Problem], Solve]
    steps: bool

    @property
    def name(self) -> str:
        return f"{self.family}, {self.setting}" if self.setting else self.family
