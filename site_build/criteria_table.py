"""The naming criteria in the documents, from the engine: `python -m site_build.criteria_table`."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from slider_drilling.gap import criteria_table

DOCS = Path(__file__).resolve().parent.parent / "docs"
SUMMARY, FULL = DOCS / "explanation" / "decision.md", DOCS / "reference" / "criteria.md"
EVERY_CANDIDATE = "every candidate"
"""Words of the test column of criteria that apply to every candidate."""
BEGIN, END = "<!-- naming criteria -->\n", "<!-- end of naming criteria -->"


def summary() -> str:
    """The criteria that every candidate must pass: name, threshold, reason."""
    rows = [(row.name, row.threshold, row.reason) for row in criteria_table() if EVERY_CANDIDATE in row.test]
    return _markdown(("criterion", "threshold", "reason"), rows)


def full() -> str:
    """All criteria with all columns."""
    return _markdown(("criterion", "test", "threshold", "message if it fails", "reason"), criteria_table())


def _markdown(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = [header, ["---"] * len(header), *([cell.replace("|", "\\|") for cell in row] for row in rows)]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def fill(page: str, table: str) -> str:
    """The page with its table written again."""
    pattern = re.compile(re.escape(BEGIN) + ".*?" + re.escape(END), re.DOTALL)
    return pattern.sub(lambda _: f"{BEGIN}\n{table}\n{END}", page)


if __name__ == "__main__":
    for path, table in ((SUMMARY, summary()), (FULL, full())):
        path.write_text(fill(path.read_text(encoding="utf-8"), table), encoding="utf-8")
