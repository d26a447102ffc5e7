"""What a fit returns: motion, covariance, residuals, outliers; as text, plain data, scene and picture."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import GetPydanticSchema
from typing_extensions import TypedDict

from ..motion import TorqueFreeMotion
from ..runtime import output_paths
from ..samples.html_table import html_table
from ..scene.scene import Scene
from .observability import Observability
from .parameters import GROUPS
from .residuals import Residuals, ResidualsAnswer

MAX_OUTLIERS_SHOWN = 10


class ParameterAnswer(TypedDict):
    """An estimated number, and its standard deviation."""

    value: float
    sigma: float


class FitAnswer(TypedDict):
    """A `Fit` as plain data; SI units and radians in the names of parameters."""

    scene: Annotated[dict[str, Any], GetPydanticSchema(lambda _, handler: handler(Scene))]
    chi_square: float
    degrees_of_freedom: int
    sigma_scale: float
    parameters: dict[str, ParameterAnswer]
    covariance: list[list[float]]
    correlation: list[list[float]]
    residuals: list[ResidualsAnswer]
    outliers: list[str]
    not_seen: list[str]
    alternatives: list[FitAnswer]


@dataclass(frozen=True, eq=False)
class Fit:
    """An estimate of a free motion from observations.

    Attributes
    ----------
    motion : the estimated motion, from the epoch of the fit
    groups : what was estimated
    names : (p,) names of the estimated numbers: attitude (small rotation about body axes), angular velocity,
        turns of the principal axes about body axes, principal moments, biases
    values : (p,) SI; of attitude and turns of axes zero, since they are relative to `motion`
    covariance : (p, p) of these, SI; a moment whose value sets the scale of the inertia has none
    residuals : of every set
    chi_square, degrees_of_freedom : weighted sum of squares
    sigma_scale : by which the scatter of residuals says that the standard deviations of the data are to be
        multiplied; 1 where they are taken as they are
    observability : directions of the parameters, and those that are not seen
    alternatives : other minima whose chi-square is so near that these data cannot tell them apart, as fits
    """

    motion: TorqueFreeMotion
    groups: tuple[str, ...]
    names: tuple[str, ...]
    values: np.ndarray
    covariance: np.ndarray
    residuals: tuple[Residuals, ...]
    chi_square: float
    degrees_of_freedom: int
    sigma_scale: float
    observability: Observability
    alternatives: tuple[Fit, ...] = ()
    name: str = ""

    @property
    def sigma(self) -> np.ndarray:
        """(p,) standard deviations, SI."""
        return np.sqrt(np.diagonal(self.covariance))

    @property
    def correlation(self) -> np.ndarray:
        """(p, p); a number without uncertainty is correlated with none."""
        sigma = np.where(self.sigma > 0.0, self.sigma, 1.0)
        return np.where(np.eye(len(sigma)) > 0.0, 1.0, self.covariance / np.outer(sigma, sigma))

    @property
    def reduced_chi_square(self) -> float:
        """Chi-square over its degrees of freedom; infinite where there are none."""
        return self.chi_square / self.degrees_of_freedom if self.degrees_of_freedom > 0 else np.inf

    @property
    def outliers(self) -> tuple[str, ...]:
        """Observations that no Gaussian scatter explains, in words, the worst first."""
        far = [(-each.sigmas[i], n, i) for n, each in enumerate(self.residuals) for i in each.outlier_indices]
        lines = []
        for _, n, i in sorted(far):
            each = self.residuals[n]
            seconds, size = each.seconds[i], _shown(each.sizes[i], each.unit)
            has_epoch = self.motion.epoch is not None
            instant = self.motion.at([seconds]).time.isot[0] if has_epoch else f"{seconds:.9g} s"
            lines.append(f"{each.name}[{i}], {instant}: off by {size}, {each.sigmas[i]:.1f} sigma")
        return tuple(lines)

    @property
    def initial_covariance(self) -> np.ndarray:
        """(12, 12), SI, of small rotation, rate, moments and turns of the axes: `uncertainty` of scenes.

        Zero for what was not estimated, and along what the data do not see.
        """
        rows = [3 * GROUPS.index(group) + i for group in self.groups for i in range(3)]
        covariance = np.zeros((12, 12))
        covariance[np.ix_(rows, rows)] = self.covariance[: len(rows), : len(rows)]
        return covariance

    @cached_property
    def scene(self) -> Scene:
        """The estimated motion as a scene, over the span of the observations, with its uncertainty.

        Without it where a moment is less than four times its standard deviation.
        """
        motion = self.motion
        at_epoch, epoch = motion.at(0.0), motion.epoch
        body: dict[str, Any] = {"moments": motion.body.moments.tolist(), "unit": "kg m2"}
        if (motion.body.axes != np.eye(3)).any():
            body = {"tensor": motion.body.tensor.tolist(), "unit": "kg m2"}
        if not 2.0 * motion.body.moments.max() <= motion.body.moments.sum():
            body["physical"] = False
        seconds = np.concatenate([each.seconds for each in self.residuals])
        start, stop = float(seconds.min()), float(seconds.max())
        times: dict[str, Any] = {
            "start": start,
            "stop": stop,
            "count": 1001 if stop > start else 1,
            "unit": "s",
        }
        document = {
            "name": self.name,
            "body": body,
            "frame": motion.frame,
            "attitude": {"quaternion": at_epoch.quaternion("wxyz").tolist(), "order": "wxyz"},
            "angular_velocity": {"value": at_epoch.angular_velocity.tolist(), "unit": "rad/s"},
            "times": times,
        }
        covariance = self.initial_covariance
        sigma_of_moments = np.sqrt(np.diagonal(covariance)[6:9])
        if covariance.any() and (4.0 * sigma_of_moments <= motion.body.moments).all():
            document["uncertainty"] = {"covariance": covariance.tolist()}
        if epoch is not None:
            isot = epoch.copy()
            isot.precision = 9
            document["epoch"] = {"time": isot.isot, "scale": epoch.scale}
        return Scene.model_validate(document)

    def to_dict(self) -> FitAnswer:
        """Everything as plain data, SI units and radians in the names of parameters."""
        rows: dict[str, ParameterAnswer] = {
            name: {"value": value, "sigma": sigma} for name, value, sigma in self._rows()
        }
        return {
            "scene": self.scene.document(),
            "chi_square": self.chi_square,
            "degrees_of_freedom": self.degrees_of_freedom,
            "sigma_scale": self.sigma_scale,
            "parameters": rows,
            "covariance": self.covariance.tolist(),
            "correlation": self.correlation.tolist(),
            "residuals": [each.to_dict() for each in self.residuals],
            "outliers": list(self.outliers),
            "not_seen": list(self.observability.unseen),
            "alternatives": [other.to_dict() for other in self.alternatives],
        }

    def plot(self, path: str | Path) -> None:
        """Draw residuals and body rates in time to FILE.svg or FILE.png.

        Raises FormatError for another ending or an unwritable path, AttitudeError without matplotlib.
        """
        from . import plot

        output_paths.write(path, plot.picture(self.motion, self.residuals, output_paths.check_picture(path)))

    def __repr__(self) -> str:
        sets = ", ".join(f"{len(each.sizes)} {each.name}" for each in self.residuals)
        return f"<Fit: {', '.join(self.groups)} from {sets}; {self._scatter()}>"

    def _repr_html_(self) -> str:
        """A table, for notebooks."""
        rows: dict[str, Any] = {"scatter": self._scatter()}
        rows |= {name: f"{value:.9e} ± {sigma:.2e}" for name, value, sigma in self._rows()}
        rows |= dict(self._sets())
        rows["outliers"] = len(self.outliers) or None
        rows["not seen"] = ", ".join(self.observability.unseen) or None
        return html_table("Fit", rows)

    def __str__(self) -> str:
        lines = [
            self._scatter()
            + ("" if self.sigma_scale == 1.0 else f"; standard deviations times {self.sigma_scale:.3g}")
        ]
        lines += [f"{name:<22} {value: .9e} +- {sigma:.2e}" for name, value, sigma in self._rows()]
        lines += [f"{name}: {text}" for name, text in self._sets()]
        outliers = self.outliers
        lines += [f"outlier: {text}" for text in outliers[:MAX_OUTLIERS_SHOWN]]
        lines += [f"and {len(outliers) - MAX_OUTLIERS_SHOWN} outliers more"] * (
            len(outliers) > MAX_OUTLIERS_SHOWN
        )
        lines += [f"not seen: {text}" for text in self.observability.unseen]
        lines += [
            f"another minimum, chi-square {other.chi_square:.6g}, cannot be told apart"
            for other in self.alternatives
        ]
        return "\n".join(lines)

    def _sets(self) -> Iterable[tuple[str, str]]:
        for each in self.residuals:
            yield each.name, f"{len(each.sizes)}, rms {_shown(each.rms, each.unit)}"

    def _scatter(self) -> str:
        return f"chi-square {self.chi_square:.6g} of {self.degrees_of_freedom} degrees of freedom"

    def _rows(self) -> Iterable[tuple[str, float, float]]:
        return zip(self.names, self.values.tolist(), self.sigma.tolist(), strict=True)


def _shown(size: float, unit: str) -> str:
    return f"{np.degrees(size):.3g} deg{unit[3:]}" if unit.startswith("rad") else f"{size:.3g} {unit}"
