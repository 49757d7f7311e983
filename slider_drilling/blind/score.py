"""Score one diagnosis against the label of its log."""

from __future__ import annotations

import math
from dataclasses import dataclass

from slider_drilling.blind.label import Label
from slider_drilling.blind.log_defects import NO_DEFECT
from slider_drilling.blind.oracle import NO_ORACLE, OracleResult
from slider_drilling.blind.reported_diagnosis import FAILED, ReportedDiagnosis

NO_EFFECT_VERDICTS = ("none", "parameters")
_VERDICTS_WITH_UNKNOWN = ("unknown", "effect_and_unknown")


@dataclass(frozen=True)
class ScoredCase:
    """One diagnosed log.

    Attributes:
        log: File name of the log.
        kind: ``none``, ``single``, ``outside`` or ``two``.
        true_effects: Empty where there is no effect.
        target_size: In noise floors.
        sizes: Size that each effect reaches alone, in noise floors.
        well: Name of the well.
        manoeuvre: Name of the manoeuvre.
        verdict: Of the diagnosis.
        named_effects: Effects that the diagnosis names.
        indistinguishable: Effects that it cannot distinguish from the named ones.
        site: Site that it gives.
        outcome: ``correct``, or what is wrong with the diagnosis.
        truth_named: Whether each true effect is named, or cannot be distinguished from a named one.
        extra_names: Number of effects that are named besides.
        site_correct: None where no site is expected or given.
        calibrated_gap: E after calibration of the nuisance parameters alone.
        closed: Share of the gap that the named effects close.
        closed_interval: Its reported 95 % interval.
        oracle_closed: Share of the gap that the true effects close.
        interval_holds_oracle: Whether the interval holds the oracle's share; None where one of the two is missing, or
            where the named effects are not exactly the true ones.
        bed_end_errors: Errors in m of the top and the bottom of a cuttings bed.
        cpu_s: Processor time of the diagnosis.
        wall_s: Duration of the diagnosis.
        masked_effects: Effects that calibration may stand for, by the diagnosis.
        identifiable: Whether the oracle names the true effects in most repeats of the run; None without an oracle.
        log_defect: What the log leaves out.
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
    masked_effects: tuple[str, ...] = ()
    identifiable: bool | None = None
    log_defect: str = NO_DEFECT

    @property
    def correct(self) -> bool:
        return self.outcome == "correct"


def score(
    label: Label,
    answer: ReportedDiagnosis | None,
    oracle: OracleResult = NO_ORACLE,
    cpu_s: float = math.nan,
    wall_s: float = math.nan,
) -> ScoredCase:
    """Returns the score of one diagnosis.

    Args:
        label: The truth.
        answer: The diagnosis; None for one that failed, which is never correct.
        oracle: What the true effects alone achieve.
        cpu_s: Processor time of the diagnosis.
        wall_s: Duration of the diagnosis.
    """
    answer = answer or FAILED
    covered = sum(answer.covers(name) for name in label.effects)
    extra = len(answer.named_effects) - len(_matched_names(label, answer))
    oracle_closed = math.nan if oracle.closed_share is None else oracle.closed_share
    exactly_named = label.kind in ("single", "two") and covered == len(label.effects) and not extra
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
        outcome=_outcome(label, answer, covered, extra),
        truth_named=bool(label.effects) and covered == len(label.effects),
        extra_names=extra,
        site_correct=_site_correct(label, answer),
        calibrated_gap=answer.calibrated_gap,
        closed=answer.closed,
        closed_interval=answer.closed_interval,
        oracle_closed=oracle_closed,
        interval_holds_oracle=_interval_holds(answer.closed_interval, oracle_closed) if exactly_named else None,
        bed_end_errors=_bed_end_errors(label, answer),
        cpu_s=cpu_s,
        wall_s=wall_s,
        masked_effects=answer.masked_effects,
        identifiable=None if oracle.named_share is None else oracle.named_share > 0.5,
        log_defect=label.log_defect,
    )


def _matched_names(label: Label, answer: ReportedDiagnosis) -> list[str]:
    """Returns the named effects that stand for a true one. Each true effect is matched once, exact names first."""
    unmatched, matched = list(label.effects), []
    for name in sorted(answer.named_effects, key=lambda name: name not in label.effects):
        stands_for = next((true for true in unmatched if true == name or true in answer.indistinguishable[name]), None)
        if stands_for is not None:
            unmatched.remove(stands_for)
            matched.append(name)
    return matched


def _outcome(label: Label, answer: ReportedDiagnosis, covered: int, extra: int) -> str:
    if answer.verdict in ("failed", "inconclusive"):
        return answer.verdict
    if label.kind == "none":
        return "correct" if answer.verdict in NO_EFFECT_VERDICTS else "false alarm"
    if answer.verdict in NO_EFFECT_VERDICTS:
        return "missed"
    if label.kind == "outside":
        if answer.verdict not in _VERDICTS_WITH_UNKNOWN:
            return "false name"
        return "correct" if _site_correct(label, answer) else "wrong site"
    if covered == len(label.effects):
        return "extra name" if extra else "correct"
    if covered:
        return "one of two, extra name" if extra else "one of two"
    return "wrong name" if answer.named_effects else "unknown"


def _site_correct(label: Label, answer: ReportedDiagnosis) -> bool | None:
    if not label.sites or answer.site is None:
        return None
    return any(answer.site in sites for sites in label.sites)


def _interval_holds(interval: tuple[float, float], value: float) -> bool | None:
    low, high = interval
    return low <= value <= high if all(map(math.isfinite, (low, high, value))) else None


def _bed_end_errors(label: Label, answer: ReportedDiagnosis) -> tuple[float, float] | None:
    fitted = answer.parameters.get("cuttings_bed", {})
    named = "cuttings_bed" in answer.named_effects
    if label.depth_interval is None or not named or not {"top", "bottom"} <= set(fitted):
        return None
    return fitted["top"] - label.depth_interval[0], fitted["bottom"] - label.depth_interval[1]
