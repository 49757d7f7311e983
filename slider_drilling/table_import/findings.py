"""What an import finds and does on the way: for the record of the import and the log's notes."""

from __future__ import annotations

from dataclasses import dataclass, field

from slider_drilling.log.import_record import IntegratedQuantity


@dataclass
class Findings:
    """What was found and done so far.

    Attributes:
        checks: A check's name and a sentence each.
        notes: Of the log.
        integrated: Quantities that were integrated, by their columns in the registry of topics.
    """

    checks: list[tuple[str, str]] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    integrated: dict[str, IntegratedQuantity] = field(default_factory=dict)

    def add(self, check: str, text: str) -> None:
        """A sentence for the log checks, which is a note of the log as well."""
        if (check, text) not in self.checks:
            self.checks.append((check, text))
            self.notes.append(text)
