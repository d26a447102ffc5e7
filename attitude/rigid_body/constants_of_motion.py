"""Constants of the motion of one or many bodies, as records that the kernels evaluate.

A record takes 790 bytes.  A batch computes its records once and caches them; those of more bodies than
`MAX_CACHED_BODIES` are computed again whenever they are used, a block of bodies at a time, so that memory
does not grow with the number of bodies.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from copy import copy
from functools import cache, cached_property
from time import perf_counter
from typing import Any, ClassVar

import numpy as np

from .. import units
from ..errors import InputError, RegimeError
from ..kernels.gauss_legendre import gauss_scheme
from ..kernels.layout import INVARIANTS, LANE_PITCH, PARTIALS, LaneRow, workspace
from ..runtime import compiled
from ..runtime.threads import check, ranges, run
from ..times.instants import Instants
from .body import RigidBody
from .error_bounds import THETA_FORM, form_of, max_phase_rate, refuse_too_far, solution
from .partials import Partials, check_inertia

MAX_CACHED_BODIES = 2**17  # whose records, 100 MiB, are cached
BODIES_PER_BLOCK = 2**12  # whose records, 3 MiB, stay in a processor's cache until their samples are made

# Between these the two parts of every phase rate are normal doubles, for all but absurd needles.
MIN_RATE, MAX_RATE = 1e-200, 1e200
RATES = f"zero, or a rate from {MIN_RATE} to {MAX_RATE} rad/s"

# Of n bodies: tensors (n, 3, 3); moments (n, 3, 2) and axes (n, 3, 3, 2) in two parts; rates; attitudes.
# Tensors and axes are None where principal moments were given.
BodyStates = tuple[np.ndarray | None, np.ndarray, np.ndarray | None, np.ndarray, np.ndarray]


def with_tensors(states: Sequence[Any]) -> tuple[np.ndarray, ...]:
    """BodyStates, with tensors and axes also where principal moments were given."""
    tensors, moments, axes, rates, attitudes = states
    if tensors is None or axes is None:
        tensors = moments[:, :, :1] * np.eye(3)
        axes = np.zeros((*tensors.shape, 2))
        axes[..., 0] = np.eye(3)
    return tensors, moments, axes, rates, attitudes


class Batch:
    """Bodies with their states at the epoch, and the records of their motion.

    Parameters
    ----------
    body : RigidBody, whose shape broadcasts to `shape`
    attitudes : (..., 4) wxyz; rates : (..., 3) rad/s; both broadcast to `shape`
    shape : batch shape

    Attributes
    ----------
    seconds : wall-clock time in which cached records were computed (of the whole, for a part of a batch)

    Raises
    ------
    InputError : a rate that no body so thin can have; for a batch whose records are not cached, when
        they are computed.
    """

    arrays: ClassVar[tuple[str, ...]] = ("attitudes", "rates")  # attributes with something of each body
    sample_kernel: ClassVar = compiled.sample  # writes quaternions and rates of records

    def __init__(self, body: RigidBody, attitudes: np.ndarray, rates: np.ndarray, shape: tuple[int, ...]):
        self.body = body
        self.attitudes = (
            attitudes if attitudes.shape == (*shape, 4) else np.broadcast_to(attitudes, (*shape, 4))
        )
        self.rates = rates if rates.shape == (*shape, 3) else np.broadcast_to(rates, (*shape, 3))
        self.shape = shape
        self.size = int(np.prod(shape))
        self._forms = np.zeros(self.size, np.int8)
        begun = perf_counter()
        self._cached = self._records(0, self.size) if self.size <= MAX_CACHED_BODIES else None
        self.seconds = perf_counter() - begun

    @cached_property
    def solution(self) -> tuple[str, float]:
        """Closed forms of these bodies, and the bound on their error, rad; once all records were computed."""
        return solution(self._forms)

    def blocks(self, first: int, last: int) -> Iterator[tuple[int, np.ndarray]]:
        """Yield (index of the first body, records) for the bodies from first to last, in blocks."""
        if self._cached is not None:
            yield first, self._cached[first:last]
            return
        for start in range(first, last, BODIES_PER_BLOCK):
            yield start, self._records(start, min(start + BODIES_PER_BLOCK, last))

    @cached_property
    def _max_phase_rate(self) -> float | None:
        """Turns/s of the fastest phase of all bodies; None where their records are not cached."""
        return None if self._cached is None else max_phase_rate(self._cached)

    def _refuse_too_far(self, records: np.ndarray, instants: Instants) -> None:
        """Raise ToleranceError for an instant too far from the epoch for one of these bodies."""
        fastest = max_phase_rate(records) if self._max_phase_rate is None else self._max_phase_rate
        refuse_too_far(fastest, instants.max_abs_seconds)

    def fields(self, *names: str) -> np.ndarray:
        """The named fields of all records, as a structured array of the batch's shape."""
        if self._cached is not None:
            return self._cached[list(names)].reshape(self.shape)
        out = np.empty(self.size, [(name, INVARIANTS[name]) for name in names])
        for start, records in self.blocks(0, self.size):
            for name in names:
                out[name][start : start + len(records)] = records[name]
        return out.reshape(self.shape)

    def sample(
        self,
        instants: Instants,
        quaternion: bool,
        rate: bool,
        threads: int = 1,
        out: np.ndarray | None = None,
    ) -> tuple[Any, Any]:
        """(quaternions (..., 4) wxyz, rates (..., 3) rad/s, body frame), None for what was not requested.

        The shape is that of the batch, then that of the instants.  Arrays are stored by component and viewed
        transposed, since the compiled loop writes whole vectors: so quaternions are written straight into an
        `out` that is stored like that, and copied into any other.

        Raises
        ------
        ToleranceError : an instant is too far from the epoch (`refuse_too_far`).
        InputError : `out` is no writable float64 array of the quaternions' shape.
        """
        flat = instants.flattened()
        seconds, low = flat.seconds, flat.seconds_low
        shape = self.shape + instants.shape
        components = None if out is None else _components(out, (*shape, 4))
        q: np.ndarray | None = None
        if components is not None and components.flags.c_contiguous:
            q = components.reshape(4, self.size, seconds.size)
        elif quaternion:
            q = np.empty((4, self.size, seconds.size))
        w = np.empty((3, self.size, seconds.size)) if rate else None

        def sample_share(share: tuple[int, int, int, int]) -> None:
            first_body, last_body, first, last = share
            for index, records in self.blocks(first_body, last_body):
                self._refuse_too_far(records, instants)
                self.sample_kernel(records, seconds, low, q, w, index, first, last)

        run(sample_share, self._shares(seconds.size, threads))
        axes = (*range(1, len(shape) + 1), 0)
        rates = None if w is None else w.reshape(3, *shape).transpose(axes)
        quaternions = None if q is None else q.reshape(4, *shape).transpose(axes)
        if out is None or np.may_share_memory(out, quaternions):
            return quaternions, rates
        out[...] = quaternions
        return out.view(), rates

    def _shares(self, instants: int, threads: int) -> list[tuple[int, int, int, int]]:
        """(first body, last body, first instant, last instant) for each thread, along whichever is longer.

        Records that are not cached are computed by each thread for bodies of its own.
        """
        if threads != 1:
            threads = min(check(threads), self.size * instants // 20_000 + 1)  # each has samples enough
        if threads == 1:
            return [(0, self.size, 0, instants)]
        if self.size > instants or self._cached is None:
            return [(a, b, 0, instants) for a, b in ranges(self.size, threads)]
        return [(0, self.size, a, b) for a, b in ranges(instants, threads)]

    def __getitem__(self, key: Any) -> Batch:
        """The batch of these bodies, by index or slice of the batch dimensions."""
        part = copy(self)
        for name in ("solution", "_max_phase_rate"):
            part.__dict__.pop(name, None)
        part.body = self.body.broadcast_to(self.shape)[key]
        part.shape = part.body.shape
        for name in self.arrays:
            setattr(part, name, getattr(self, name)[key])
        part.size = int(np.prod(part.shape))
        part._cached, part.seconds = None, self.seconds
        part._forms = np.ascontiguousarray(self._forms.reshape(self.shape)[key]).reshape(-1)
        if self._cached is not None:
            part._cached = np.ascontiguousarray(self._cached.reshape(self.shape)[key]).reshape(-1)
        elif part.size <= MAX_CACHED_BODIES:
            part._cached = part._records(0, part.size)
        return part

    def partials(self, instants: Instants, inertia: str = "moments", threads: int = 1) -> Partials:
        """Partial derivatives at instants, of shape batch + instants.

        Raises
        ------
        ToleranceError : an instant is too far from the epoch.
        RegimeError : derivatives beyond the range of a double, which grow exponentially on the separatrix.
        """
        check_inertia(inertia)
        flat = instants.flattened()
        seconds, low = flat.seconds, flat.seconds_low
        out = np.empty((self.size, 6, 12, seconds.size))
        columns, scheme = (3 if inertia == "moments" else 6), quadrature()

        def compute_share(share: tuple[int, int, int, int]) -> None:
            first_body, last_body, first, last = share
            of_partials = np.empty(1, PARTIALS)
            numbers = of_partials.view(np.float64).reshape(1, -1)
            space = of_partials, numbers, scheme, np.empty((9, 8)), np.zeros((9, 9)), np.zeros(72 * 64)
            for index, records in self.blocks(first_body, last_body):
                self._refuse_too_far(records, instants)
                states = self._states(index, index + len(records))
                _tensors, moments, axes, rates, _attitudes = with_tensors(states)
                window = np.array([index, first, last, columns, 0])
                compiled.partials(records, seconds, low, out, window, moments, axes, rates, *space)
                if window[4]:
                    raise RegimeError(
                        "partials: beyond the range of a double: they grow exponentially on the separatrix, "
                        "and within 1e-147 of the axis of the middle moment"
                    )

        run(compute_share, self._shares(seconds.size, threads))
        matrix = out.reshape(*self.shape, 6, 12, *instants.shape)
        bodies = len(self.shape)
        return Partials(np.moveaxis(matrix, (bodies, bodies + 1), (-2, -1)), inertia)

    def _states(self, first: int, last: int) -> BodyStates:
        """Tensors, two-part moments and axes, rates and attitudes of bodies by their flat index."""
        body = self.body if self.body.shape == self.shape else self.body.broadcast_to(self.shape)
        tensors, axes = None, None
        if body._tensor is not None:
            tensors = _flat(body._tensor, self.shape, first, last)
            axes = _flat(body._two_part_axes, self.shape, first, last)
        moments, rates, attitudes = (
            _flat(array, self.shape, first, last)
            for array in (body._two_part_moments, self.rates, self.attitudes)
        )
        return tensors, moments, axes, rates, attitudes

    def _records(self, first: int, last: int) -> np.ndarray:
        """Compute the records of bodies by their flat index, and note their forms.

        In vector lanes but for those that need more care: the kernel of lanes lists them.
        """
        states = self._states(first, last)
        _tensors, moments, axes, rates, attitudes = states
        count = len(rates)
        out, others = np.empty(count, INVARIANTS), np.empty(count + 1, np.int64)
        space = np.empty(LaneRow.ROWS * LANE_PITCH)
        numbers = out.view(np.float64).reshape(count, LaneRow.SERVED)
        compiled.theta_invariants(moments, axes, rates, attitudes, numbers, others, space)
        forms = self._forms[first : first + count]
        forms[:] = THETA_FORM
        if others[0]:
            index = others[1 : 1 + others[0]]
            records = np.zeros(len(index), INVARIANTS)
            some = [None if array is None else array[index] for array in states]
            compiled.invariants(*with_tensors(some), records, *workspace())
            self._refuse_out_of_range(records, first + index)
            out[index], forms[index] = records, form_of(records["regime"], records["route"])
        return out

    def _refuse_out_of_range(self, records: np.ndarray, indices: np.ndarray) -> None:
        """Raise InputError for the first of these records, by flat indices, that is not finite."""
        finite = np.isfinite(records["rate"]).all(axis=(-1, -2))
        finite &= np.isfinite(records["frame"]).all(axis=(-1, -2))
        if finite.all():
            return
        beyond = np.zeros(self.shape, dtype=np.bool_)
        beyond[np.unravel_index(indices[np.argmin(finite)], self.shape)] = True
        expected = "a rate that a body so thin can have without leaving the range of a double"
        units.refuse_where(beyond, self.rates, "angular_velocity", expected)


def _components(out: Any, shape: tuple[int, ...]) -> np.ndarray:
    """The array `out`, checked, with its last axis first."""
    is_array = isinstance(out, np.ndarray) and out.dtype == np.float64
    if not is_array or out.shape != shape or not out.flags.writeable:
        value = f"{out.dtype} of shape {out.shape}" if isinstance(out, np.ndarray) else out
        raise InputError("out", value, f"a writable float64 array of shape {shape}")
    return np.moveaxis(out, -1, 0)


def _flat(array: np.ndarray, shape: tuple[int, ...], first: int, last: int) -> np.ndarray:
    """Elements first to last over the leading dimensions `shape`, flattened; in C order, no others copied."""
    if len(shape) == 1:
        part = array[first:last]
    elif array.flags.c_contiguous:
        part = array.reshape(-1, *array.shape[len(shape) :])[first:last]
    else:
        part = array[np.unravel_index(np.arange(first, last), shape)] if shape else array[None]
    return np.ascontiguousarray(part)


@cache
def quadrature() -> np.ndarray:
    """(10, 8): nodes and weights of an interval of length 1, and of the integrals up to each node."""
    gauss = gauss_scheme(8)
    integrals = gauss.to_coefficients @ gauss.integrals
    return np.concatenate([[0.5 * (gauss.nodes + 1.0), gauss.weights], integrals.T]).astype(float)


def check_rates(rates: np.ndarray) -> np.ndarray:
    """These rates, (..., 3) rad/s; InputError for another shape, or a rate that is out of range."""
    if rates.ndim < 1 or rates.shape[-1] != 3:
        raise InputError("angular_velocity", f"shape {rates.shape}", "shape (..., 3)")
    units.refuse_where(beyond_rates(rates), rates, "angular_velocity", RATES)
    return rates


def beyond_rates(rates: np.ndarray) -> np.ndarray:
    """Mask (...) of the rates (..., 3) that are too fast or too slow."""
    size = np.abs(rates).max(axis=-1)
    return (size > MAX_RATE) | ((size > 0.0) & (size < MIN_RATE))
