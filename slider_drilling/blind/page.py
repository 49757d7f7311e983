"""blind.html: the result of a blind check on one page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from slider_drilling.blind.log_defects import NO_DEFECT
from slider_drilling.blind.score import ScoredCase
from slider_drilling.blind.totals import (
    CLEAR_SIZE,
    REMAINING_GAP,
    BlindTotals,
    Proportion,
    Quantiles,
    count_totals,
    proportion,
)
from slider_drilling.pages import BulletList, Chart, Headline, Line, Page, Panel, Section, Table, Tag, write_page
from slider_drilling.units import SI, Quantity, Text, Units, sentence

_FACTS = ("code", "date")
_VISIBLE_CURVES = 4  # the legend switches the others on
_NOTES = (
    "A diagnosis is correct if it names exactly the effects in the log; without effect, if the verdict is none or "
    "parameters; for a law outside the catalogue, if the verdict is unknown or effect_and_unknown and the site is "
    "correct. A diagnosis that failed counts as wrong.",
    "An effect counts as named if the diagnosis names it, or cannot distinguish it from an effect that it names.",
    "Intervals are exact binomial 95 % intervals.",
    "Size is the change that the effect alone makes to the channel that it changes most: RMS in units of the declared "
    "noise, before calibration. What calibration compensates leaves nothing to name.",
)
_KINDS = {"single": "one effect", "two": "two effects", "none": "no effect", "outside": "law outside the catalogue"}


def write_blind_page(path: Path, cases: Sequence[ScoredCase], tree: dict[str, Any], units: Units = SI) -> None:
    """Writes the page.

    Args:
        path: Of the page.
        cases: The scored cases.
        tree: Of blind.json.
        units: Of the page.

    Raises:
        InputError: The page cannot be written.
    """
    totals = count_totals(cases)
    page = Page(
        kind="Blind check",
        title=f"{len(cases)} sealed logs",
        facts=tuple((name, str(tree[name])) for name in _FACTS)
        + tuple((name, str(value)) for name, value in tree["options"].items() if value != ""),
        headline=Headline(f"Effects named: {totals.named}. False alarms without effect: {totals.false_alarms}."),
        sections=(
            Section("Totals", (Table(("", "count, share, 95 % interval"), tuple(total_rows(totals))),
                               BulletList((*_NOTES, *_oracle_note(tree["options"]))))),
            Section("Detection by size", (_size_table(totals), _size_chart(totals))),
            Section("Confusion", (_confusion_table(totals),)),
            Section("Every case", (_case_table(cases),), collapsed=True),
        ),
    )  # fmt: skip
    write_page(path, page, units)


def _oracle_note(options: Mapping[str, Any]) -> tuple[str, ...]:
    """What the oracle was fitted to; nothing if it did not run."""
    if not options.get("oracle"):
        return ()
    repeats = int(options["repeats"])
    runs = "one repeat" if repeats == 1 else f"{repeats} repeats"
    return (f"The oracle fits the true effects, and no other candidates, to {runs} of the run. It shows what such a "
            "log can reveal at best.",)  # fmt: skip


def total_rows(totals: BlindTotals) -> list[tuple[str, Text]]:
    """Returns each figure with its name."""
    rows: list[tuple[str, Text]] = [(f"{_KINDS[kind]}: correct", str(count)) for kind, count in totals.correct.items()]
    rows += [
        ("one effect: named", str(totals.named)),
        (f"\u2003of {CLEAR_SIZE:g} noise floors or more", str(totals.named_from_size_1_5)),
        (f"\u2003where calibration leaves E of {REMAINING_GAP:g} or more", str(totals.named_where_gap_remains)),
        ("\u2003where the oracle names it", str(totals.named_where_identifiable)),
        (f"\u2003of {CLEAR_SIZE:g} noise floors or more: named, or reported as masked", str(totals.named_or_masked)),
        ("two effects: both named", str(totals.both_named)),
        (f"\u2003each of {CLEAR_SIZE:g} noise floors or more", str(totals.both_from_size_1_5)),
        ("\u2003where the oracle names both", str(totals.both_where_identifiable)),
        ("no effect: false alarms", str(totals.false_alarms)),
        ("law outside the catalogue: false name", str(totals.false_names)),
        ("law outside the catalogue, noticed: site correct", str(totals.outside_site_correct)),
        ("one or two effects: site correct", str(totals.site_correct)),
        ("95 % interval holds the oracle's share", str(totals.interval_coverage)),
        ("share closed minus the oracle's", _quantiles_text(totals.closed_minus_oracle)),
        ("errors of the ends of a cuttings bed", _quantiles_text(totals.bed_end_errors, "m")),
        ("processor time of a diagnosis", _quantiles_text(totals.cpu_s, " s")),
        ("duration of a diagnosis", _quantiles_text(totals.wall_s, " s")),
    ]
    rows += [(f"named, {name} well", str(count)) for name, count in totals.by_well.items()]
    rows += [(f"named, {name} manoeuvre", str(count)) for name, count in totals.by_manoeuvre.items()]
    if {*totals.by_log_defect, *totals.false_alarms_by_log_defect} - {NO_DEFECT}:
        rows += [(f"named, log defect {name}", str(count)) for name, count in totals.by_log_defect.items()]
        rows += [
            (f"false alarms, log defect {name}", str(count))
            for name, count in totals.false_alarms_by_log_defect.items()
        ]
    return rows


def _quantiles_text(values: Quantiles, unit: str = "") -> Text:
    if values.median is None:
        return "-"
    median, low, high = (Quantity(value, unit) for value in (values.median, values.low, values.high))
    return sentence("median ", median, ", 5 % ", low, ", 95 % ", high, f" ({values.total})")


def _size_table(totals: BlindTotals) -> Table:
    sizes = sorted({size for row in totals.by_size.values() for size in row}, key=float)
    rows = []
    for name, row in totals.by_size.items():
        limit = totals.detection_limits[name]
        low, high = (None if end is None else f"{end:.2g}" for end in limit.interval)
        rows.append((
            name, *(str(row.get(size, proportion(()))) for size in sizes),
            "-" if limit.size is None else f"{limit.size:.2g}",
            f"{low or 'below all sizes'} to {high or 'above all sizes'}",
        ))  # fmt: skip
    heads = ("effect", *(f"named at {size}" for size in sizes), "detection limit", "95 % interval")
    return Table(heads, tuple(rows), "Sizes in noise floors. At its detection limit an effect is named half the time.")


def _size_chart(totals: BlindTotals) -> Chart:
    lines: list[Line] = []
    for name, row in totals.by_size.items():
        sizes = sorted(row, key=float)
        counts: list[Proportion] = [row[size] for size in sizes]
        x, y = np.array([float(size) for size in sizes]), np.array([count.count / count.total for count in counts])
        low, high = (np.array([getattr(count, end) for count in counts], dtype=float) for end in ("low", "high"))
        lines.append(Line(name, x, y, "dots", low=low, high=high, hidden=len(lines) >= _VISIBLE_CURVES))
    named = Panel("share named", tuple(lines), limits=(-0.02, 1.02))
    return Chart("Share named by size", "size in noise floors", (named,), x_log=True)


def _confusion_table(totals: BlindTotals) -> Table:
    answers = sorted({answer for row in totals.confusion.values() for answer in row})
    rows = tuple(
        (truth, *(str(row.get(answer, "")) for answer in answers),
         "; ".join(f"{count} {outcome}" for outcome, count in outcomes.items()))
        for (truth, row), outcomes in zip(totals.confusion.items(), totals.outcomes.values(), strict=True)
    )  # fmt: skip
    return Table(("in the log", *answers, "outcome"), rows, "Columns: the effects that are named, or the verdict")


def _case_table(cases: Sequence[ScoredCase]) -> Table:
    heads = ("log", "outcome", "in the log", "size", "well, manoeuvre", "log defect", "verdict", "named",
             "indistinguishable", "site", "closes", "95 % interval", "oracle closes")  # fmt: skip
    return Table(heads, tuple(_case_row(case) for case in cases))


def _case_row(case: ScoredCase) -> tuple[str | float | Tag, ...]:
    low, high = case.closed_interval
    return (
        case.log,
        Tag(case.outcome, "good" if case.correct else "bad"),
        " + ".join(case.true_effects) or "none",
        ", ".join(f"{size:.2g}" for size in case.sizes),
        f"{case.well}, {case.manoeuvre}",
        case.log_defect,
        case.verdict,
        " + ".join(case.named_effects),
        ", ".join(case.indistinguishable),
        case.site or "",
        case.closed,
        f"{low:.2f} to {high:.2f}" if np.isfinite(low) else "",
        case.oracle_closed,
    )
