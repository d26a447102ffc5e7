"""A torque computed by a function of the user, compiled or plain Python."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable
from threading import get_ident
from typing import Any

import numpy as np
from pydantic import PrivateAttr

from ..errors import InputError
from ..kernels.layout import EffectCode
from ..problem.initial_state import InitialState
from .effect import Torque, row

DOUBLES = ctypes.POINTER(ctypes.c_double)
# C signature of a compiled function: void(double t, const double *q, const double *w, double *torque).
SIGNATURE = ctypes.CFUNCTYPE(None, ctypes.c_double, DOUBLES, DOUBLES, DOUBLES)
FUNCTION_POINTER: Any = SIGNATURE.__base__  # of every ctypes function, whatever its signature
Function = Callable[[float, np.ndarray, np.ndarray], Any]


class UserTorque(Torque):
    """A torque computed by a function, for a Scene's `effects`; it cannot be written to a document.

    Parameters
    ----------
    name : str
        Name of the effect in plans.
    function : (t, attitude, angular_velocity) -> (3,) N m, along the body's axes
        In plain Python: t s since the epoch, attitude (4,) wxyz, angular_velocity (3,) rad/s, body frame.
        Both arrays belong to the solver: copy what is kept.
    compiled : numba cfunc, ctypes function, or int address; in place of `function`
        Of the C signature ``void(double t, const double *attitude, const double *angular_velocity,
        double *torque)``.  It is called without the interpreter's lock, and may write nan to stop.
    size : float, N m
        Approximate maximum of the torque, from which solver and step are chosen.

    Raises
    ------
    InputError : none or both of function and compiled, one that cannot be called, or a negative size.

    Notes
    -----
    An exception in `function`, or a result that is not three finite numbers, stops the solver, which
    sees a torque of nan; `failure` holds the exception then, and `raise_failure` raises it.
    """

    type: str = "user"
    _name: str = PrivateAttr(default="")
    _size: float = PrivateAttr(default=0.0)
    _function: Function | None = PrivateAttr(default=None)
    _callback: Any = PrivateAttr(default=None)
    _address: int = PrivateAttr(default=0)
    _failures: dict[int, BaseException] = PrivateAttr(default_factory=dict)  # by thread

    def __init__(self, name: str, function: Function | None = None, *, compiled: Any = None, size: float):
        if (function is None) == (compiled is None):
            raise InputError("function", function, "one of function and compiled")
        if not isinstance(size, (int, float)) or not math.isfinite(size) or size < 0.0:
            raise InputError("size", size, "a finite number of N m, not below 0")
        super().__init__(type="user")
        self._name, self._size = name, float(size)
        if function is not None and not callable(function):
            raise InputError("function", function, "a function of t, attitude and angular velocity")
        self._function = function
        self._callback = SIGNATURE(self._call) if function is not None else compiled
        self._address = _address_of(self._callback)

    def rows(self, initial_state: InitialState) -> np.ndarray:
        """One row: the address of the function."""
        return row(EffectCode.USER, np.int64(self._address).view(np.float64))[None]

    def size(self, initial_state: InitialState) -> float:
        """Return the size that the user gave, N m."""
        return self._size

    @property
    def label(self) -> str:
        """Name of the effect in plans."""
        return self._name

    @property
    def is_compiled(self) -> bool:
        """Whether the function is called without the interpreter."""
        return self._function is None

    @property
    def failure(self) -> BaseException | None:
        """Exception of the function in this thread, not raised yet."""
        return self._failures.get(get_ident())

    def raise_failure(self) -> None:
        """Raise the exception of the function in this thread, once; return if there is none."""
        failure = self._failures.pop(get_ident(), None)
        if failure is not None:
            raise failure

    def _call(self, t: float, attitude: Any, rate: Any, torque: Any) -> None:
        """Write the torque, or nan after a failure: compiled code, which calls this, takes no exceptions."""
        out, q = np.ctypeslib.as_array(torque, (3,)), np.ctypeslib.as_array(attitude, (4,))
        w = np.ctypeslib.as_array(rate, (3,))
        if not (np.isfinite(q).all() and np.isfinite(w).all()):  # a step too long, which the solver halves
            out[:] = math.nan
            return
        assert self._function is not None
        try:
            result = self._function(t, q, w)
            try:
                value = np.asarray(result, dtype=float)
            except (TypeError, ValueError):
                value = np.zeros(0)
            if value.shape != (3,) or not np.isfinite(value).all():
                expected = "a torque of three finite numbers"
                raise InputError(f"effect {self._name!r}", result, expected, steps=())
            out[:] = value
        except BaseException as error:
            self._failures[get_ident()] = error
            out[:] = math.nan


def _address_of(code: Any) -> int:
    """Address of a numba cfunc or ctypes function, or the number itself."""
    address = getattr(code, "address", code)
    if isinstance(address, FUNCTION_POINTER):
        address = ctypes.cast(address, ctypes.c_void_p).value
    if isinstance(address, bool) or not isinstance(address, int) or address <= 0:
        raise InputError("compiled", code, "a numba cfunc, a ctypes function or an address")
    return address
