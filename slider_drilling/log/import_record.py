"""What an import did to a table, kept in the log's metadata: a diagnosis must know which channels were not measured."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

RECORD = "slider_drilling_import"


@dataclass(frozen=True)
class IntegratedQuantity:
    """A quantity that was integrated from its recorded speed.

    Attributes:
        error: Standard error at the end, in the quantity's SI unit, without what happened in gaps.
        gaps: Number of gaps, in which it stands still.
        in_gaps: s in all gaps.
    """

    error: float
    gaps: int = 0
    in_gaps: float = 0.0


@dataclass(frozen=True)
class ImportRecord:
    """What an import found and did.

    Attributes:
        checks: Pairs of a check's name ("nulls", "clock", ...) and a sentence.
        integrated: Quantities that were integrated, by their columns in the registry of topics.
        units: Unit that each quantity was imported with, by the name of the channel in the mapping.
    """

    checks: tuple[tuple[str, str], ...] = ()
    integrated: dict[str, IntegratedQuantity] = field(default_factory=dict)
    units: dict[str, str] = field(default_factory=dict)

    def to_metadata(self) -> dict[str, str]:
        """The record as an MCAP metadata record holds it."""
        integrated = {name: vars(quantity) for name, quantity in self.integrated.items()}
        return {
            "checks": json.dumps(self.checks, ensure_ascii=False),
            "integrated": json.dumps(integrated),
            "units": json.dumps(self.units, ensure_ascii=False),
        }

    @classmethod
    def from_metadata(cls, values: Mapping[str, str]) -> ImportRecord | None:
        """The record of a log; None where it is damaged, or of another program."""
        try:
            checks = json.loads(values.get("checks", "[]"))
            integrated = json.loads(values.get("integrated", "{}"))
            units = json.loads(values.get("units", "{}"))
            return cls(
                tuple((str(name), str(text)) for name, text in checks),
                {str(name): _quantity(entry) for name, entry in integrated.items()},
                {str(name): str(unit) for name, unit in units.items()},
            )
        except (ValueError, TypeError, AttributeError, KeyError):
            return None


def _quantity(entry: Any) -> IntegratedQuantity:
    return IntegratedQuantity(float(entry["error"]), int(entry["gaps"]), float(entry["in_gaps"]))
