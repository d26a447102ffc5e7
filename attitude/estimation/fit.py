"""Fitting the motion of a free body to observations of it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from astropy.time import Time

from ..errors import InputError, ToleranceError, emit_warning
from ..motion import TorqueFreeMotion
from ..rigid_body.body import RigidBody
from ..scene.scene import Scene
from ..times.instants import Instants
from . import starts
from .fit_result import Fit
from .least_squares import Loss
from .minimum import Minimum, fit_of, indistinct, minimum
from .observability import ALWAYS_UNSEEN
from .observations import ObservationSet, observation_sets
from .parameters import BodyState, check_groups


def fit(
    observations: Any,
    body: RigidBody | None = None,
    start: Any = None,
    estimate: Sequence[str] = ("attitude", "angular_velocity", "inertia"),
    loss: str | Loss = "linear",
    absolute_sigma: bool | None = None,
    epoch: Time | None = None,
    frame: str | None = None,
) -> Fit:
    """The free motion that fits observations best, in the sense of weighted least squares.

    Parameters
    ----------
    observations : `Attitudes`, `BodyRates`, `Directions`, `RangeOffsets`, or an Ephemeris (its attitudes), or
        a list of these
    body : its inertia, the start of what is estimated of it, and the scale; by default that of `start`
    start : a TorqueFreeMotion or a Scene near the answer; by default several starts are made from the
        observations: rates from differences of attitudes, and inertia on a grid where it is estimated
    estimate : "attitude" and "angular_velocity" at the epoch, "moments", "principal_axes", or "inertia": both
        of these of a body given by its tensor, "moments" of one given by moments
    loss : "linear", or "soft_l1", "huber", "cauchy", "arctan", by which observations beyond two sigma weigh
        less; or a `Loss` with another scale
    absolute_sigma : False to scale the covariance by the reduced chi-square, as where standard deviations
        are only relative; by default True where they are known
    epoch : of the answer; by default that of `start`, else the first instant of the observations
    frame : inertial, of the answer; by default that of `start`, else of the first observations

    Raises
    ------
    InputError : values that are not finite or of the wrong shape, standard deviations of some sets but not of
        others, or observations from which no start can be made.

    Warns (AttitudeWarning) of outliers, of a chi-square that the standard deviations do not explain, of
    directions that the data do not see, and of minima that cannot be told apart.
    """
    return prepare(observations, body, start, estimate, loss, absolute_sigma, epoch, frame).solve()


@dataclass(frozen=True, eq=False)
class FitInputs:
    """What `fit` is given, checked.

    sets : in the frame of the answer, with `Instants`; their standard deviations provisional where `known` is
        False
    template : epoch, frame, inertia of the answer, which is known where `has_body`; its state is a start
        where `has_start`
    groups : what is estimated; absolute : whether the covariance is that of the standard deviations
    """

    sets: tuple[ObservationSet, ...]
    template: BodyState
    has_start: bool
    has_body: bool
    groups: tuple[str, ...]
    loss: Loss
    known: bool
    absolute: bool

    def solve(self, progress: Callable[[float], None] | None = None) -> Fit:
        """The fit, with its warnings; `progress` is called with the fraction that is done."""
        report = progress or (lambda _: None)
        states, grid = [self.template], "moments" in self.groups
        searching = 0.6  # of the progress
        if not self.has_start:
            # least squares would follow a few attitudes that are half a turn off
            loss = Loss("cauchy") if self.loss.name == "linear" else self.loss
            search = partial(starts.search, self.sets, self.template, self.groups, grid, loss)
            candidates = search(lambda fraction: report(searching * fraction))[:4]
            states = [each.state for each in candidates]
            if self.known and max(each.met for each in candidates) < 0.5:
                _warn(
                    "no free motion was found that half of the observations agree with: torques, standard "
                    "deviations that are too small, attitudes that are not from body to frame, or another "
                    "order of their components"
                )
        minima: list[Minimum] = []
        for i, state in enumerate(states):
            report(searching + (1.0 - searching) * i / len(states))
            minima += self._minimum(state)
        if not minima:
            expected = "those of a free motion: least squares run off to rates or moments beyond any"
            raise InputError("observations", None, expected)
        best, *others = sorted(minima, key=lambda each: each.cost)
        is_certain = best.observability.is_seen.all() and not indistinct(best, others)
        if not self.has_start and not is_certain:
            # what is not seen of the inertia, or not for certain, stays that of `body`: a search over inertia
            # makes so much less chi-square of noise in one of three hundred sets
            limit = 18.0 if self.has_body else starts.INDISTINCT
            own = replace(best.state, moments=self.template.moments, axes=self.template.axes)
            for kept in self._minimum(own):
                if kept.cost - best.cost < limit * best.sigma_scale**2:
                    best, others = kept, [best, *others]
        others = indistinct(best, others)
        alternatives = tuple(fit_of(each, self.absolute) for each in others)
        result = replace(fit_of(best, self.absolute), alternatives=alternatives)
        _warn_of(result, self.absolute, self.loss)
        report(1.0)
        return result

    def _minimum(self, state: BodyState) -> list[Minimum]:
        """The minimum near a state; none where the search runs off, to rates or moments beyond any."""
        least = float(self.template.moments.min())
        try:
            with np.errstate(over="raise"):
                return [minimum(self.sets, state, self.groups, self.loss, self.absolute, least)]
        except (FloatingPointError, ToleranceError):
            return []


def prepare(
    observations: Any,
    body: RigidBody | None,
    start: Any,
    estimate: Sequence[str],
    loss: str | Loss,
    absolute_sigma: bool | None,
    epoch: Time | None,
    frame: str | None,
) -> FitInputs:
    """The inputs of a fit; parameters, errors and warnings are those of `fit`."""
    if body is not None and not isinstance(body, RigidBody):
        raise InputError("body", body, "a RigidBody")
    if body is not None and body.shape:
        raise InputError("body", f"{body.shape} bodies", "one body")
    given = observation_sets(observations)
    template, has_start = _template(body, start, epoch, frame, given)
    sets = _with_instants(given, template)
    groups = check_groups(estimate, template.body)
    known = sets[0].sigma is not None
    if any((each.sigma is not None) != known for each in sets):
        raise InputError("sigma", None, "standard deviations of all observations or of none")
    kind = loss if isinstance(loss, Loss) else Loss(loss)
    if kind.check().name != "linear" and not known:
        raise InputError("sigma", None, f"standard deviations beside the loss {kind.name!r}")
    absolute = known if absolute_sigma is None else absolute_sigma
    if absolute and not known:
        raise InputError("absolute_sigma", True, "standard deviations of the observations beside it")
    for group in () if has_start else ("attitude", "angular_velocity"):
        if group not in groups:
            raise InputError("start", None, f"a motion, whose {group} is kept where it is not estimated")
    if not has_start and body is None and "moments" not in groups:
        raise InputError("body", None, "the inertia, where it is not estimated")
    weighted = tuple(each if known else replace(each, sigma=each.unknown_sigma) for each in sets)
    return FitInputs(weighted, template, has_start, body is not None, groups, kind, known, absolute)


def _template(
    body: RigidBody | None,
    start: Any,
    epoch: Time | None,
    frame: str | None,
    sets: Sequence[ObservationSet],
) -> tuple[BodyState, bool]:
    """Epoch, frame and inertia of the answer, with the state of `start`; and whether there is one."""
    if isinstance(start, Scene):
        if start.effects:
            raise InputError("start.effects", start.effects, "none: the fit is of free rotation")
        start = start.motion()
    if start is not None and not isinstance(start, TorqueFreeMotion):
        raise InputError("start", start, "a TorqueFreeMotion or a Scene")
    first = sets[0]
    if start is None:
        if epoch is None and isinstance(first.times, Time):
            epoch = min(each.times.min() for each in sets if isinstance(each.times, Time))
        rest = RigidBody((1.0, 1.3, 2.0)) if body is None else body
        start = TorqueFreeMotion(rest, (1.0, 0.0, 0.0, 0.0), np.zeros(3), epoch, "wxyz", frame or first.frame)
        return BodyState.of(start).with_inertia(body), False
    at = start.at(0.0 if epoch is None else epoch)
    at = at if frame is None else at.in_frame(frame)
    state = BodyState.of(start)
    state = replace(state, attitude=at.quaternion("wxyz"), rate=at.angular_velocity, frame=at.frame)
    return replace(state, epoch=start.epoch if epoch is None else epoch).with_inertia(body), True


def _with_instants(given: Sequence[ObservationSet], template: BodyState) -> list[ObservationSet]:
    """The sets in the frame of the answer; what is odd about their instants is warned of."""
    sets = [each.in_frame(template.frame) for each in given]
    for i, each in enumerate(sets):
        instants = each.instants(template.epoch)
        sets[i] = replace(each, times=Instants(instants.seconds, instants.seconds_low, template.epoch))
        seconds = instants.seconds
        back = np.flatnonzero(np.diff(seconds) < 0.0)
        if back.size:
            _warn(f"{each.name}: instants go back at [{back[0] + 1}]; each is taken as it is")
        repeated = len(seconds) - len(np.unique(seconds))
        if repeated:
            _warn(f"{each.name}: {repeated} instants occur again; every observation counts")
    return sets


def _warn(text: str) -> None:
    emit_warning(text, 5)


def _warn_of(result: Fit, absolute: bool, loss: Loss) -> None:
    """Warn of what makes the answer doubtful."""
    from scipy.special import chdtrc

    if result.outliers:
        count = len(result.outliers)
        more = f" and {count - 1} more" if count > 1 else ""
        cure = "; a robust loss, such as 'cauchy', is not moved by them" if loss.name == "linear" else ""
        _warn(f"outliers: {result.outliers[0]}{more}{cure}")
    if absolute and result.degrees_of_freedom > 0:
        inliers = np.concatenate([each.sigmas[~each.is_outlier] for each in result.residuals])
        square = float((inliers**2).sum())
        if chdtrc(result.degrees_of_freedom, square) < 1e-6:
            excess = np.sqrt(square / result.degrees_of_freedom)
            _warn(
                f"residuals are {excess:.2g} times what the standard deviations say: "
                "torques, or standard deviations that are too small"
            )
    for text in result.observability.unseen[len(ALWAYS_UNSEEN) :]:
        _warn(f"not seen by these data, kept at the start's value: {text}")
    for other in result.alternatives:
        _warn(
            f"another motion fits as well and cannot be told apart: chi-square {other.chi_square:.6g}, not "
            f"{result.chi_square:.6g}, rate {other.motion.at(0.0).angular_velocity} rad/s, moments "
            f"{other.motion.body.moments} kg m2"
        )
