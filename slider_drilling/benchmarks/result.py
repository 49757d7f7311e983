"""A measured figure with its reference."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class BenchmarkResult:
    """A measured figure.

    Its reference is measured in the same run, so that slow code can be distinguished from a slow or busy machine.

    Attributes:
        name: Name of the figure.
        value: None if it cannot be measured; ``note`` says why.
        unit: Of value and reference.
        reference: None if there is none.
        reference_name: What the reference is.
        note: How it was measured.
    """

    name: str
    value: float | None
    unit: str
    reference: float | None = None
    reference_name: str = ""
    note: str = ""

    @property
    def ratio(self) -> float | None:
        """value / reference."""
        if self.value is None or not self.reference:
            return None
        return self.value / self.reference

    def to_json(self) -> dict[str, object]:
        """An entry of `slider-drilling bench --json`."""
        return {
            "name": self.name,
            "value": self.value,
            "unit": self.unit,
            "reference": self.reference,
            "ratio": self.ratio,
            "reference_name": self.reference_name,
            "note": self.note,
        }
