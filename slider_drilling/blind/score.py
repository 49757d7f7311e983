"""The seal opened: what was said of a log beside what is in it."""

from __future__ import annotations

import math
from dataclasses import dataclass

from slider_drilling.blind.answer import Answer
from slider_drilling.blind.label import Label
from slider_drilling.blind.lack import NOTHING
from slider_drilling.blind.oracle import UNKNOWN, Truth

QUIET = ("none", "parameters")
_UNSURE = ("unknown", "effect_and_unknown")


@dataclass(frozen=True)
class Scored:
    """One case.

    truth: the effects, none at all where there is no effect; sizes: noise floors reached by each; group: all that the
    answer could not tell from what it named; outcome: ``right``, or what is wrong with the answer; named_truth: every
    true effect is named, or in the group of a named one, whatever is named besides; extra: how many are named
    besides; site_right: None where no site was asked for or given; tuned: E that re-tuning leaves; covered: the
    reported interval holds the oracle's share, None where one of them is missing; nameable: whether the oracle, with no
    other candidate, names the truth in most repeats of the run, None without an oracle; ends: errors m at the top and
    the bottom of a cuttings bed; cpu, wall: s; instead: what it said re-tuning may stand for; lacking: what the log
    lacks.
    """

    log: str
    kind: str
    truth: tuple[str, ...]
    size: float
    sizes: tuple[float, ...]
    well: str
    manoeuvre: str
    verdict: str
    named: tuple[str, ...]
    group: tuple[str, ...]
    site: str | None
    outcome: str
    named_truth: bool
    extra: int
    site_right: bool | None
    tuned: float
    closed: float
    interval: tuple[float, float]
    oracle: float
    covered: bool | None
    ends: tuple[float, float] | None
    cpu: float
    wall: float
    instead: tuple[str, ...] = ()
    nameable: bool | None = None
    lacking: str = NOTHING

    @property
    def right(self) -> bool:
        return self.outcome == "right"


def score(
    label: Label, answer: Answer | None, truth: Truth = UNKNOWN, cpu: float = math.nan, wall: float = math.nan
) -> Scored:
    """Score one answer; None is a diagnosis that failed, which is never right."""
    if answer is None:
        answer = Answer("failed", (), {}, (), None, math.nan, math.nan, (math.nan, math.nan), {})
    found = [name for name in label.effects if answer.covers(name)]
    extra = len(answer.named) - len(_matched(label, answer))
    low, high = answer.interval
    oracle = math.nan if truth.closed is None else truth.closed
    known = label.kind in ("single", "two") and math.isfinite(oracle) and math.isfinite(low) and math.isfinite(high)
    exact = len(found) == len(label.effects) and not extra
    return Scored(
        log=label.log, kind=label.kind, truth=label.effects, size=label.size, sizes=label.sizes, well=label.well,
        manoeuvre=label.manoeuvre, verdict=answer.verdict, named=answer.named,
        group=tuple(dict.fromkeys(name for group in answer.groups.values() for name in group)),
        site=answer.site,
        outcome=_outcome(label, answer, len(found), extra),
        named_truth=bool(label.effects) and len(found) == len(label.effects), extra=extra,
        site_right=_site_right(label, answer), tuned=answer.tuned, closed=answer.closed,
        interval=answer.interval, oracle=oracle,
        covered=low <= oracle <= high if known and exact else None, ends=_ends(label, answer), cpu=cpu, wall=wall,
        instead=answer.instead, nameable=None if truth.named is None else truth.named > 0.5,
        lacking=label.lacking,
    )  # fmt: skip


def _matched(label: Label, answer: Answer) -> list[str]:
    """Named effects that stand for a true one, each for one of its own."""
    left, matched = list(label.effects), []
    for name in sorted(answer.named, key=lambda name: name not in label.effects):
        stands_for = next((true for true in left if true == name or true in answer.groups[name]), None)
        if stands_for is not None:
            left.remove(stands_for)
            matched.append(name)
    return matched


def _outcome(label: Label, answer: Answer, found: int, extra: int) -> str:
    if answer.verdict in ("failed", "inconclusive"):
        return answer.verdict
    if label.kind == "none":
        return "right" if answer.verdict in QUIET else "alarm"
    if answer.verdict in QUIET:
        return "missed"
    if label.kind == "outside":
        if answer.verdict not in _UNSURE:
            return "bare name"
        return "right" if _site_right(label, answer) else "wrong site"
    if found == len(label.effects):
        return "extra name" if extra else "right"
    if found:
        return "one of two, extra name" if extra else "one of two"
    return "wrong name" if answer.named else "unknown"


def _site_right(label: Label, answer: Answer) -> bool | None:
    if not label.sites or answer.site is None:
        return None
    return any(answer.site in sites for sites in label.sites)


def _ends(label: Label, answer: Answer) -> tuple[float, float] | None:
    found = answer.parameters.get("cuttings_bed", {})
    if label.interval is None or "cuttings_bed" not in answer.named or not {"top", "bottom"} <= set(found):
        return None
    return found["top"] - label.interval[0], found["bottom"] - label.interval[1]
