"""One measured figure and what it is held against."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class BenchmarkResult:
    """A figure, or why there is none.

    reference: another figure in the same unit from the same run, named by ``reference_is``, so that a busy or slow
    machine can be told from slow code. value and reference are None where `note` says why they cannot be measured.
    """

    name: str
    value: float | None
    unit: str
    reference: float | None = None
    reference_is: str = ""
    note: str = ""

    @property
    def ratio(self) -> float | None:
        """value / reference."""
        if self.value is None or not self.reference:
            return None
        return self.value / self.reference

    def as_json(self) -> dict[str, object]:
        """As `slider-drilling bench --json` prints it."""
        return {
            "name": self.name,
            "value": self.value,
            "unit": self.unit,
            "reference": self.reference,
            "ratio": self.ratio,
            "reference_is": self.reference_is,
            "note": self.note,
        }
