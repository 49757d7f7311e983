"""The table of a campaign of sealed slides: what the twin reaches, beside what it is to reach."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from slider_drilling.blind.slides.beginnings import NOTHING, SIX_CASES
from slider_drilling.blind.slides.score import ONSET_TOLERANCE_S, ScoredSlide
from slider_drilling.blind.slides.watched import NAMED_WITHIN_S, WatchedSlide
from slider_drilling.blind.totals import proportion

_LEVEL = 0.95


@dataclass(frozen=True)
class TableRow:
    """One row.

    Attributes:
        what: What is measured.
        value: What the campaign gives, with its 95 % interval where it has one.
        to_reach: What it is to reach.
    """

    what: str
    value: str
    to_reach: str = ""


def campaign_table(scored: Sequence[ScoredSlide], watched: Sequence[WatchedSlide]) -> list[TableRow]:
    """The rows of a campaign."""
    visible = [each for each in scored if each.visible]
    detected = [each for each in visible if each.detected]
    steps = [each for each in detected if each.step]
    answered = [each for each in detected if each.verdict]
    return [
        TableRow("slides", f"{len(scored)}, {sum(each.truth == NOTHING for each in scored)} without anything"),
        _false_alarms(scored),
        _share("detected, of 1.5 noise levels or more", [each.detected for each in visible], ">= 95 %"),
        *_delays([each.delay for each in detected if each.delay is not None]),
        _share(f"onset of steps within {ONSET_TOLERANCE_S:.0f} s",
               [abs(each.onset_error or 0.0) <= ONSET_TOLERANCE_S for each in steps], ">= 80 %"),
        _share(f"named (or its group) within {NAMED_WITHIN_S:.0f} s of detection",
               [each.right for each in detected], ">= 80 %"),
        _share("wrong names, of answers", [each.wrong for each in answered], "<= 2 %"),
        *(_case(name, scored) for name in SIX_CASES),
        *_costs(watched),
        *_forecasts(watched),
    ]  # fmt: skip


def _false_alarms(scored: Sequence[ScoredSlide]) -> TableRow:
    count, hours = sum(each.false_alarms for each in scored), sum(each.quiet_s for each in scored) / 3600.0
    if hours == 0.0:
        return TableRow("false alarms in 24 h", "-", "<= 1")
    per_day = 24.0 / hours
    low = chi2.ppf(0.5 - 0.5 * _LEVEL, 2 * count) / 2.0 if count else 0.0
    high = chi2.ppf(0.5 + 0.5 * _LEVEL, 2 * count + 2) / 2.0
    return TableRow(
        "false alarms in 24 h",
        f"{count * per_day:.1f} [{low * per_day:.1f}, {high * per_day:.1f}] ({count} in {hours:.1f} h)", "<= 1",
    )  # fmt: skip


def _share(what: str, hits: Sequence[bool], to_reach: str) -> TableRow:
    """A share with its exact interval."""
    found = proportion(hits)
    if found.low is None or found.high is None:
        return TableRow(what, "-", to_reach)
    interval = f"[{100.0 * found.low:.0f}, {100.0 * found.high:.0f}]"
    share = 100.0 * found.count / found.total
    return TableRow(what, f"{share:.0f} % {interval} ({found.count} of {found.total})", to_reach)


def _delays(delays: Sequence[float]) -> list[TableRow]:
    values = [f"{np.quantile(delays, share):.0f} s" if delays else "-" for share in (0.5, 0.9)]
    return [
        TableRow("delay after 1.5 noise levels, median", values[0], "<= 60 s"),
        TableRow("delay after 1.5 noise levels, nine in ten", values[1], "<= 180 s"),
    ]


def _case(name: str, scored: Sequence[ScoredSlide]) -> TableRow:
    own = [each for each in scored if each.case == name]
    both = [each.detected and each.right for each in own]
    row = _share(f"{name.replace('_', ' ')}: seen and named", both, ">= 9 of 10")
    seen = sum(each.detected for each in own)
    return TableRow(row.what, f"{row.value}; seen {seen}" if own else "-", row.to_reach)


def _costs(watched: Sequence[WatchedSlide]) -> list[TableRow]:
    if not watched:
        return []
    shares, memory = [each.cpu_share for each in watched], max(each.memory for each in watched)
    spent = [cpu for each in watched for cpu in each.diagnosis_cpu]
    rows = [
        TableRow("processor, of one core", f"{100.0 * np.mean(shares):.1f} %, at most {100.0 * max(shares):.1f} %",
                 "<= 10 %"),
        TableRow("memory of the twin", f"{memory / 1e6:.0f} MB", "<= 300 MB"),
    ]  # fmt: skip
    if spent:
        rows.append(TableRow("processor time of a diagnosis", f"{np.mean(spent):.0f} s, at most {max(spent):.0f} s"))
        peak = max(each.diagnosis_memory for each in watched)
        rows.append(TableRow("memory of a diagnosis, a process of its own", f"{peak / 1e6:.0f} MB"))
    return rows


def _forecasts(watched: Sequence[WatchedSlide]) -> list[TableRow]:
    def pooled(name: str, show: Callable[[float], str]) -> str:
        values = [getattr(each.forecasts, name) for each in watched]
        known = [value for value in values if value is not None]
        return show(float(np.sqrt(np.mean(np.square(known))))) if known else "-"

    def row(what: str, key: str, show: Callable[[float], str]) -> TableRow:
        twin, unchanged, given = (pooled(key + end, show) for end in ("", "_unchanged", "_uncalibrated"))
        return TableRow(
            what, f"{twin}; as it is: {unchanged}; uncalibrated, given the drives' motion: {given}", "below both"
        )

    return [
        row("toolface 60 s ahead, RMS error", "tool_face", lambda value: f"{np.degrees(value):.0f} deg"),
        row("torque 60 s ahead, RMS error", "torque", lambda value: f"{value:.0f} N m"),
    ]
