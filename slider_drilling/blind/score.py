"""The seal opened: what was said of a log beside what is in it."""

from __future__ import annotations

import math
from dataclasses import dataclass

from slider_drilling.blind.label import Label
from slider_drilling.blind.log_defects import NO_DEFECT
from slider_drilling.blind.oracle import NO_ORACLE, OracleResult
from slider_drilling.blind.reported_diagnosis import ReportedDiagnosis

NO_EFFECT_VERDICTS = ("none", "parameters")
_UNSURE = ("unknown", "effect_and_unknown")


@dataclass(frozen=True)
class ScoredCase:
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
    true_effects: tuple[str, ...]
    target_size: float
    sizes: tuple[float, ...]
    well: str
    manoeuvre: str
    verdict: str
    named_effects: tuple[str, ...]
    indistinguishable: tuple[str, ...]
    site: str | None
    outcome: str
    truth_named: bool
    extra_names: int
    site_correct: bool | None
    calibrated_gap: float
    closed: float
    closed_interval: tuple[float, float]
    oracle_closed: float
    interval_holds_oracle: bool | None
    bed_end_errors: tuple[float, float] | None
    cpu_s: float
    wall_s: float
    suspected: tuple[str, ...] = ()
    identifiable: bool | None = None
    log_defect: str = NO_DEFECT

    @property
    def correct(self) -> bool:
        return self.outcome == "correct"


def score(
    label: Label,
    answer: ReportedDiagnosis | None,
    truth: OracleResult = NO_ORACLE,
    cpu: float = math.nan,
    wall: float = math.nan,
) -> ScoredCase:
    """Score one answer; None is a diagnosis that failed, which is never right."""
    if answer is None:
        answer = ReportedDiagnosis("failed", (), {}, (), None, math.nan, math.nan, (math.nan, math.nan), {})
    found = [name for name in label.effects if answer.covers(name)]
    extra = len(answer.named_effects) - len(_matched(label, answer))
    low, high = answer.closed_interval
    oracle = math.nan if truth.closed_share is None else truth.closed_share
    known = label.kind in ("single", "two") and math.isfinite(oracle) and math.isfinite(low) and math.isfinite(high)
    exact = len(found) == len(label.effects) and not extra
    return ScoredCase(
        log=label.log,
        kind=label.kind,
        true_effects=label.effects,
        target_size=label.size,
        sizes=label.sizes,
        well=label.well,
        manoeuvre=label.manoeuvre,
        verdict=answer.verdict,
        named_effects=answer.named_effects,
        indistinguishable=tuple(dict.fromkeys(name for group in answer.indistinguishable.values() for name in group)),
        site=answer.site,
        outcome=_outcome(label, answer, len(found), extra),
        truth_named=bool(label.effects) and len(found) == len(label.effects),
        extra_names=extra,
        site_correct=_site_right(label, answer),
        calibrated_gap=answer.calibrated_gap,
        closed=answer.closed,
        closed_interval=answer.closed_interval,
        oracle_closed=oracle,
        interval_holds_oracle=low <= oracle <= high if known and exact else None,
        bed_end_errors=_ends(label, answer),
        cpu_s=cpu,
        wall_s=wall,
        suspected=answer.suspected,
        identifiable=None if truth.named_share is None else truth.named_share > 0.5,
        log_defect=label.log_defect,
    )


def _matched(label: Label, answer: ReportedDiagnosis) -> list[str]:
    """Named effects that stand for a true one, each for one of its own."""
    left, matched = list(label.effects), []
    for name in sorted(answer.named_effects, key=lambda name: name not in label.effects):
        stands_for = next((true for true in left if true == name or true in answer.indistinguishable[name]), None)
        if stands_for is not None:
            left.remove(stands_for)
            matched.append(name)
    return matched


def _outcome(label: Label, answer: ReportedDiagnosis, found: int, extra: int) -> str:
    if answer.verdict in ("failed", "inconclusive"):
        return answer.verdict
    if label.kind == "none":
        return "correct" if answer.verdict in NO_EFFECT_VERDICTS else "false alarm"
    if answer.verdict in NO_EFFECT_VERDICTS:
        return "missed"
    if label.kind == "outside":
        if answer.verdict not in _UNSURE:
            return "false name"
        return "correct" if _site_right(label, answer) else "wrong site"
    if found == len(label.effects):
        return "extra name" if extra else "correct"
    if found:
        return "one of two, extra name" if extra else "one of two"
    return "wrong name" if answer.named_effects else "unknown"


def _site_right(label: Label, answer: ReportedDiagnosis) -> bool | None:
    if not label.sites or answer.site is None:
        return None
    return any(answer.site in sites for sites in label.sites)


def _ends(label: Label, answer: ReportedDiagnosis) -> tuple[float, float] | None:
    found = answer.parameters.get("cuttings_bed", {})
    if (
        label.depth_interval is None
        or "cuttings_bed" not in answer.named_effects
        or not {"top", "bottom"} <= set(found)
    ):
        return None
    return found["top"] - label.depth_interval[0], found["bottom"] - label.depth_interval[1]
