"""The figures of docs/blind/README.md, from what a blind check wrote: `python -m site_build.blind_tables blind.json`.

Keeps a small copy of the cases beside the page, from which anyone can count again.
"""

from __future__ import annotations

import json
import math
import re
import sys
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from slider_drilling.blind.page import total_rows
from slider_drilling.blind.score import Scored
from slider_drilling.blind.tally import Share, Tally, sealed, tally

FOLDER = Path(__file__).resolve().parent.parent / "docs" / "blind"
PAGE, CASES = FOLDER / "README.md", FOLDER / "cases.json"
BEGIN, END = "<!-- counted from cases.json -->\n", "<!-- end of what is counted -->"
COLUMNS = tuple(Scored.__dataclass_fields__)


def small(tree: dict[str, Any]) -> str:
    """The cases of a blind.json, a line each, as JSON; numbers with four digits."""
    head = {name: tree[name] for name in ("schema", "date", "code", "options")} | {"columns": COLUMNS}
    rows = (json.dumps([_short(case[name]) for name in COLUMNS], separators=(",", ":")) for case in tree["cases"])
    opening = json.dumps(head)[:-1]
    return opening + ', "cases": [\n' + ",\n".join(rows) + "\n]}\n"


def _short(value: Any) -> Any:
    if isinstance(value, list):
        return [_short(one) for one in value]
    return float(f"{value:.4g}") if isinstance(value, float) else value


def cases_of(tree: dict[str, Any]) -> list[Scored]:
    """The scored cases of the small copy."""
    return [Scored(**{name: _full(name, value) for name, value in zip(tree["columns"], row, strict=True)})
            for row in tree["cases"]]  # fmt: skip


def _full(name: str, value: Any) -> Any:
    if name in ("tuned", "closed", "oracle", "cpu", "wall"):
        return math.nan if value is None else value
    if name == "interval":
        return tuple(math.nan if end is None else end for end in value)
    return tuple(value) if isinstance(value, list) else value


def markdown(tree: dict[str, Any]) -> str:
    """The tables of the small copy."""
    cases = cases_of(tree)
    found, options = tally(cases), tree["options"]
    asked = f" --repeats {options['repeats']}" if "repeats" in options else ""
    if not options.get("oracle", True):
        asked = " --no-oracle"
    made = (
        f"`slider-drilling blind-check --cases {options['cases']} --seed {options['seed']} --sizes {options['sizes']} "
        f"--duration {options['duration']:g}{asked}`, {tree['date']}, code {tree['code']}; each case is a line of "
        "[cases.json](cases.json)."
    )
    return "\n\n".join((made, _totals(found), _effects(found), _outcomes(found, cases))) + "\n\n"


def _totals(found: Tally) -> str:
    return "\n".join(("| | |", "|---|---|", *(f"| {name.strip()} | {value} |" for name, value in total_rows(found))))


def _effects(found: Tally) -> str:
    sizes = sorted({size for row in found.by_size.values() for size in row}, key=float)
    lines = [
        "Named or in the top group, of how many, by size in noise floors; the size that is named half the time:", "",
        "| effect | " + " | ".join(sizes) + " | half the time at |", "|---|" + "---|" * (len(sizes) + 1),
    ]  # fmt: skip
    for name, row in found.by_size.items():
        counts = (row.get(size, Share(0, 0, None, None)) for size in sizes)
        limit = found.limits[name].size
        shown = " | ".join(f"{one.count} of {one.of}" if one.of else "" for one in counts)
        lines.append(f"| `{name}` | {shown} | {'-' if limit is None else f'{limit:.2g}'} |")
    return "\n".join(lines)


def _outcomes(found: Tally, cases: list[Scored]) -> str:
    of_kind = {sealed(case): case.kind for case in cases}
    lines = ["What was said of the others:", "", "| in the log | outcomes | said |", "|---|---|---|"]
    pairs: Counter[str] = Counter()
    for truth, outcomes in found.outcomes.items():
        if of_kind[truth] == "two":
            pairs.update(outcomes)
        elif of_kind[truth] != "single":
            lines.append(f"| {truth} | {_counted(outcomes)} | {_counted(found.confusion[truth])} |")
    if pairs:
        lines.append(f"| two effects at once | {_counted(pairs)} | |")
    return "\n".join(lines)


def _counted(of: Mapping[str, int]) -> str:
    return ", ".join(f"{number} {name}" for name, number in sorted(of.items(), key=lambda one: -one[1]))


def written(page: str, tree: dict[str, Any]) -> str:
    """The page with its figures counted anew."""
    pattern = re.compile(re.escape(BEGIN) + ".*?" + re.escape(END), re.DOTALL)
    return pattern.sub(lambda _: BEGIN + "\n" + markdown(tree) + END, page)


if __name__ == "__main__":
    CASES.write_text(small(json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))), encoding="utf-8")
    kept = json.loads(CASES.read_text(encoding="utf-8"))
    PAGE.write_text(written(PAGE.read_text(encoding="utf-8"), kept), encoding="utf-8")
