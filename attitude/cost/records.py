"""Results as JSON without NaN, and as CSV with the circumstances in comment lines."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from ..errors import InputError

if TYPE_CHECKING:
    from _typeshed import DataclassInstance


def check_budget(budget: float, seed: int) -> None:
    """InputError for a budget, s, that is none, or a negative seed."""
    if not 0.0 < budget < math.inf:
        raise InputError("budget", budget, "a number of seconds greater than zero")
    if seed < 0:
        raise InputError("seed", seed, "a whole number, not negative")


@dataclass(frozen=True)
class Records:
    """Results of a measurement, and its circumstances.

    Attributes
    ----------
    budget_s, seed : as requested
    machine, versions : of processor and system; of Python and packages
    """

    budget_s: float
    seed: int
    machine: dict[str, str | int]
    versions: dict[str, str]

    @property
    def records(self) -> Sequence[DataclassInstance]:
        """The results, one object each; a number is None where nothing was measured."""
        raise NotImplementedError

    def header(self) -> list[str]:
        """The circumstances of the measurement, one line each."""
        raise NotImplementedError

    def document(self) -> Mapping[str, Any]:
        """Plain data; what was not measured is None."""
        raise NotImplementedError

    @property
    def processor(self) -> str:
        """Processor, cores and system in one line."""
        return f"{self.machine['processor']}, {self.machine['cores']} cores, {self.machine['system']}"

    @property
    def packages(self) -> str:
        """Versions in one line."""
        return ", ".join(f"{name} {version}" for name, version in self.versions.items())

    def to_json(self) -> str:
        """`document` as JSON text; ValueError for NaN or infinity."""
        return json.dumps(self.document(), indent=1, ensure_ascii=False, allow_nan=False) + "\n"

    def to_csv(self) -> str:
        """Circumstances in comment lines, then one line for each cell; empty where nothing was measured."""
        text = io.StringIO()
        text.writelines(f"# {line}\n" for line in self.header())
        rows = [asdict(record) for record in self.records]
        writer = csv.DictWriter(text, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
        return text.getvalue()
