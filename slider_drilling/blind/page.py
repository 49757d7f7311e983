"""blind.html: what a blind check shows, on a page that stands alone."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from slider_drilling.blind.log_defects import NO_DEFECT
from slider_drilling.blind.score import ScoredCase
from slider_drilling.blind.totals import REMAINING_GAP, BlindTotals, Proportion, Quantiles, count_totals
from slider_drilling.pages import BulletList, Chart, Headline, Line, Page, Panel, Section, Table, Tag, write_page
from slider_drilling.units import SI, Units

_FACTS = ("code", "date")


def write_blind_page(path: Path, cases: Sequence[ScoredCase], tree: dict[str, Any], units: Units = SI) -> None:
    """Write the page. tree: of blind.json; units: of the page. Raises InputError."""
    found = count_totals(cases)
    page = Page(
        kind="Blind check",
        title=f"{len(cases)} sealed logs",
        facts=tuple((name, str(tree[name])) for name in _FACTS)
        + tuple((name, str(value)) for name, value in tree["options"].items() if value != ""),
        headline=Headline(
            f"Named, or in the top group: {found.named}. Effect-free logs with an alarm: {found.false_alarms}."
        ),
        sections=(
            Section(
                "In all", (Table(("", "count, share, 95 % interval"), tuple(total_rows(found))), BulletList(_READING))
            ),
            Section("How small", (_sizes(found), _curves(found))),
            Section("What was said", (_confusion(found),)),
            Section("Every case", (_cases(cases),), collapsed=True),
        ),
    )
    write_page(path, page, units)


_READING = (
    "Right: one effect, or two, named with no other beside; no effect: none or parameters; a law from outside: unknown "
    "or effect_and_unknown, and its site.",
    "Intervals are exact binomial ones. A diagnosis that failed counts as wrong.",
    "The oracle is a fit of its own of the true effect alone; coverage is of the reported 95 % intervals over its "
    "share, where exactly the true effects were named. What it names, with no other candidate, in most of three "
    "repeats of the run such a log can tell at all.",
    "Size is how far the effect alone moves the most moved channel, RMS in the declared noise, before anything is "
    "re-tuned: what re-tuning makes up for leaves nothing to name.",
)


def total_rows(found: BlindTotals) -> list[tuple[str, str]]:
    """Each figure with its name."""
    kinds = {
        "single": "one effect: right",
        "two": "two effects: right",
        "none": "no effect: right",
        "outside": "law from outside: right",
    }
    rows = [(kinds[kind], str(count)) for kind, count in found.correct.items()]
    rows += [
        ("one effect: named or in the top group", str(found.named)),
        ("  at 1.5 noise floors and above", str(found.named_from_size_1_5)),
        (f"  where re-tuning leaves E of {REMAINING_GAP:g} and above", str(found.named_where_gap_remains)),
        ("  of those that the oracle names, the truth being its only candidate", str(found.named_where_identifiable)),
        ("  at 1.5 and above: named, or told as what re-tuning may stand for", str(found.named_or_suspected)),
        ("two effects: both named or in the group", str(found.both_named)),
        ("  each of 1.5 noise floors and above", str(found.both_from_size_1_5)),
        ("  of those both of which the oracle names", str(found.both_where_identifiable)),
        ("no effect: false alarms", str(found.false_alarms)),
        ("law from outside: a bare name", str(found.false_names)),
        ("law from outside: site right", str(found.outside_site_correct)),
        ("catalogue: site right", str(found.site_correct)),
        ("interval holds the oracle's share", str(found.interval_coverage)),
        ("share closed minus the oracle's", _shown(found.closed_minus_oracle)),
        ("ends of a cuttings bed off by", _shown(found.bed_end_errors, " m")),
        ("processor time of a diagnosis", _shown(found.cpu_s, " s")),
        ("time of a diagnosis", _shown(found.wall_s, " s")),
    ]
    rows += [(f"named, {name} well", str(count)) for name, count in found.by_well.items()]
    rows += [(f"named, {name} manoeuvre", str(count)) for name, count in found.by_manoeuvre.items()]
    if {*found.by_log_defect, *found.false_alarms_by_log_defect} - {NO_DEFECT}:
        rows += [(f"named, {name} lacking", str(count)) for name, count in found.by_log_defect.items()]
        rows += [
            (f"false alarms, {name} lacking", str(count)) for name, count in found.false_alarms_by_log_defect.items()
        ]
    return rows


def _shown(of: Quantiles, unit: str = "") -> str:
    if of.median is None:
        return "-"
    return f"median {of.median:.3g}{unit}, 5 to 95 %: {of.low:.3g} to {of.high:.3g}{unit} ({of.total})"


def _sizes(found: BlindTotals) -> Table:
    sizes = sorted({size for row in found.by_size.values() for size in row}, key=float)
    rows = []
    for name, row in found.by_size.items():
        limit = found.detection_limits[name]
        low, high = (None if end is None else f"{end:.2g}" for end in limit.interval)
        at = "-" if limit.size is None else f"{limit.size:.2g}"
        rows.append(
            (
                name,
                *(str(row.get(size, Proportion(0, 0, None, None))) for size in sizes),
                at,
                f"{low or 'below all'} to {high or 'above all'}",
            )
        )
    return Table(
        ("effect", *(f"named at {size} floors" for size in sizes), "named half the time at", "95 %"),
        tuple(rows),
        "Named or in the top group, by size in noise floors",
    )


def _curves(found: BlindTotals) -> Chart:
    lines: list[Line] = []
    for name, row in found.by_size.items():
        sizes = sorted(row, key=float)
        counts = [row[size] for size in sizes]
        x, y = np.array([float(size) for size in sizes]), np.array([count.count / count.total for count in counts])
        low, high = (np.array([getattr(count, end) for count in counts], dtype=float) for end in ("low", "high"))
        lines.append(Line(name, x, y, "dots", low=low, high=high, hidden=len(lines) >= 4))
    named = Panel("named", tuple(lines), limits=(-0.02, 1.02))
    return Chart("Share named", "size in noise floors", (named,), x_log=True)


def _confusion(found: BlindTotals) -> Table:
    said = sorted({name for row in found.confusion.values() for name in row})
    rows = tuple(
        (truth, *(str(row.get(name, "")) for name in said), "; ".join(f"{n} {o}" for o, n in outcomes.items()))
        for (truth, row), outcomes in zip(found.confusion.items(), found.outcomes.values(), strict=True)
    )
    return Table(("sealed", *said, "outcome"), rows, "Rows: what was sealed. Columns: what was named, else the verdict")


def _cases(cases: Sequence[ScoredCase]) -> Table:
    rows = tuple(
        (
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
            f"{case.closed_interval[0]:.2f} to {case.closed_interval[1]:.2f}"
            if np.isfinite(case.closed_interval[0])
            else "",
            case.oracle_closed,
        )
        for case in cases
    )
    return Table(
        (
            "log",
            "outcome",
            "sealed",
            "size",
            "well, manoeuvre",
            "lacks",
            "verdict",
            "named",
            "not told from",
            "site",
            "closes",
            "95 %",
            "oracle",
        ),
        rows,
    )
