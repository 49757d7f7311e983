"""The table of docs/reference/accuracy.md, from a blind check: `python -m site_build.accuracy_table blind.json`.

Keeps what is counted of each case in docs/reference/accuracy_cases.json, so that anyone can count again.
"""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from scipy.stats import binomtest

FOLDER = Path(__file__).resolve().parent.parent / "docs" / "reference"
PAGE, CASES = FOLDER / "accuracy.md", FOLDER / "accuracy_cases.json"
BEGIN, END = "<!-- counted from accuracy_cases.json -->\n", "<!-- end of what is counted -->"
QUIET = ("none", "parameters")
"""Verdicts that name nothing and raise no alarm."""

COLUMNS = (
    "log", "kind", "true_effects", "sizes", "well", "manoeuvre", "verdict", "outcome", "truth_named", "site_correct",
    "calibrated_gap", "identifiable", "interval_holds_oracle",
)  # fmt: skip
"""Keys of a case in blind.json that the copy keeps."""

Case = Mapping[str, Any]

# Row of the table -> whether a case counts for it: None if the row does not ask about the case.
ROWS: dict[str, Callable[[Case], bool | None]] = {
    "one effect: named": lambda case: case["truth_named"] if case["kind"] == "single" else None,
    "one effect, where calibration leaves E of 1.2 and more: named": lambda case: (
        case["truth_named"] if case["kind"] == "single" and case["calibrated_gap"] >= 1.2 else None
    ),
    "one effect that an oracle can name: named": lambda case: (
        case["truth_named"] if case["kind"] == "single" and case["identifiable"] else None
    ),
    "two effects: both named": lambda case: case["truth_named"] if case["kind"] == "two" else None,
    "no effect: false alarm": lambda case: case["verdict"] not in QUIET if case["kind"] == "none" else None,
    "law outside the catalogue: a wrong name and no doubt": lambda case: (
        case["outcome"] == "false name" if case["kind"] == "outside" else None
    ),
    "law outside the catalogue, noticed: site right": lambda case: (
        bool(case["site_correct"]) if case["kind"] == "outside" and case["verdict"] not in QUIET else None
    ),
    "95 % interval holds the true share": lambda case: case["interval_holds_oracle"],
}


def keep(tree: Mapping[str, Any], larger: Mapping[str, Any]) -> str:
    """accuracy_cases.json from a blind.json: a line a case, numbers with four digits.

    Args:
        tree: The content of blind.json.
        larger: Counts of larger samples, row name -> [count, of]; they are kept as they are.
    """
    head = {"options": tree["options"], "code": tree["code"], "date": tree["date"], "larger": larger}
    rows = (json.dumps([_short(case[key]) for key in COLUMNS], separators=(",", ":"))
            for case in tree["cases"])  # fmt: skip
    opening = json.dumps({**head, "columns": list(COLUMNS)})[:-1]
    return opening + ', "cases": [\n' + ",\n".join(rows) + "\n]}\n"


def _short(value: Any) -> Any:
    if isinstance(value, list):
        return [_short(item) for item in value]
    return float(f"{value:.4g}") if isinstance(value, float) else value


def table(tree: Mapping[str, Any]) -> str:
    """The table of accuracy.md: n of N, the share, and its exact binomial 95 % interval."""
    cases = [dict(zip(tree["columns"], row, strict=True)) for row in tree["cases"]]
    lines = ["| | mixed sample | larger sample of one kind |", "|---|---|---|"]
    for name, counts in ROWS.items():
        answers = [bool(answer) for answer in map(counts, cases) if answer is not None]
        lines.append(f"| {name} | {_share(sum(answers), len(answers))} | {_share(*tree['larger'].get(name, (0, 0)))} |")
    return "\n".join(lines) + "\n"


def _share(count: int, of: int) -> str:
    if of == 0:
        return ""
    interval = binomtest(count, of).proportion_ci(0.95, method="exact")
    return f"{count} of {of}, {100 * count / of:.0f} % [{100 * interval.low:.0f}, {100 * interval.high:.0f}]"


def fill(page: str, tree: Mapping[str, Any]) -> str:
    """The page with its table counted again."""
    pattern = re.compile(re.escape(BEGIN) + ".*?" + re.escape(END), re.DOTALL)
    return pattern.sub(lambda _: BEGIN + "\n" + table(tree) + "\n" + END, page)


if __name__ == "__main__":
    kept = json.loads(CASES.read_text(encoding="utf-8"))
    if len(sys.argv) > 1:
        CASES.write_text(keep(json.loads(Path(sys.argv[1]).read_text(encoding="utf-8")), kept["larger"]), "utf-8")
    PAGE.write_text(fill(PAGE.read_text(encoding="utf-8"), json.loads(CASES.read_text(encoding="utf-8"))), "utf-8")
