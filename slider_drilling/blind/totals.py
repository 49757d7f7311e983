"""The totals of a blind check: counts with binomial intervals, quantiles, and which effect was taken for which."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.stats import binomtest

from slider_drilling.blind.cases import SIZE_TOLERANCE
from slider_drilling.blind.detection import DetectionLimit, detection_limit
from slider_drilling.blind.score import NO_EFFECT_VERDICTS, ScoredCase

REMAINING_GAP = 1.2
"""E from which calibration leaves something to name: a little above what the diagnosis takes for negligible."""
CLEAR_SIZE = 1.5
"""Size in noise floors from which an effect counts as clearly visible."""


@dataclass(frozen=True)
class Proportion:
    """A count out of a total, with the exact (Clopper-Pearson) 95 % interval of the proportion.

    Attributes:
        count: How many are true.
        total: How many there are.
        low: Lower bound; None for a total of zero.
        high: Upper bound; None for a total of zero.
    """

    count: int
    total: int
    low: float | None
    high: float | None

    def __str__(self) -> str:
        if self.low is None or self.high is None:
            return "-"
        percent = 100.0 * self.count / self.total
        return f"{self.count} of {self.total}, {percent:.0f} % [{100.0 * self.low:.0f}, {100.0 * self.high:.0f}]"


def proportion(answers: Iterable[bool | None]) -> Proportion:
    """Returns how many are true of those that are not None."""
    known = [bool(answer) for answer in answers if answer is not None]
    if not known:
        return Proportion(0, 0, None, None)
    interval = binomtest(sum(known), len(known)).proportion_ci(0.95, method="exact")
    return Proportion(sum(known), len(known), float(interval.low), float(interval.high))


@dataclass(frozen=True)
class Quantiles:
    """Median, 5 % and 95 % quantile of `total` finite values; None where there are none."""

    median: float | None
    low: float | None
    high: float | None
    total: int


def quantiles(values: Iterable[float]) -> Quantiles:
    """Returns the quantiles of the finite values."""
    finite = [value for value in values if np.isfinite(value)]
    if not finite:
        return Quantiles(None, None, None, 0)
    low, median, high = (float(value) for value in np.quantile(finite, (0.05, 0.5, 0.95)))
    return Quantiles(median, low, high, len(finite))


@dataclass(frozen=True)
class BlindTotals:
    """All figures of a blind check. "Named" includes effects that cannot be distinguished from a named one.

    Attributes:
        correct: Correct diagnoses by kind of case.
        named: One effect: named.
        named_from_size_1_5: The same, of effects that reach `CLEAR_SIZE`.
        named_where_gap_remains: The same, where calibration leaves E of `REMAINING_GAP` or more.
        named_where_identifiable: The same, where the oracle names the effect in most repeats of the run.
        named_or_masked: The same, of effects that reach `CLEAR_SIZE`: named, or reported as masked by calibration.
        both_named: Two effects: both named.
        both_from_size_1_5: The same, where each reaches `CLEAR_SIZE`.
        both_where_identifiable: The same, where the oracle names both.
        false_alarms: No effect, and a verdict other than ``none`` or ``parameters``.
        false_names: Law outside the catalogue that is given a name, without ``unknown``.
        site_correct: One or two effects: correct site, where one is given.
        outside_site_correct: Law outside the catalogue that is noticed: correct site.
        interval_coverage: Reported 95 % intervals that hold the oracle's share.
        closed_minus_oracle: Share closed by the named effects minus the oracle's.
        bed_end_errors: Absolute errors of the ends of cuttings beds, m.
        cpu_s: Processor time of a diagnosis.
        wall_s: Duration of a diagnosis.
        by_size: Effect -> size -> named. The size is the target nearest to the size that the log reaches.
        by_well: Named, one effect.
        by_manoeuvre: Named, one effect.
        by_log_defect: Named, one effect.
        false_alarms_by_log_defect: False alarms.
        detection_limits: By effect.
        confusion: What is in the log -> what is named, or the verdict -> count.
        outcomes: What is in the log -> outcome -> count.
    """

    correct: dict[str, Proportion]
    named: Proportion
    named_from_size_1_5: Proportion
    named_where_gap_remains: Proportion
    named_where_identifiable: Proportion
    named_or_masked: Proportion
    both_named: Proportion
    both_from_size_1_5: Proportion
    both_where_identifiable: Proportion
    false_alarms: Proportion
    false_names: Proportion
    site_correct: Proportion
    outside_site_correct: Proportion
    interval_coverage: Proportion
    closed_minus_oracle: Quantiles
    bed_end_errors: Quantiles
    cpu_s: Quantiles
    wall_s: Quantiles
    by_size: dict[str, dict[str, Proportion]]
    by_well: dict[str, Proportion]
    by_manoeuvre: dict[str, Proportion]
    by_log_defect: dict[str, Proportion]
    false_alarms_by_log_defect: dict[str, Proportion]
    detection_limits: dict[str, DetectionLimit]
    confusion: dict[str, dict[str, int]]
    outcomes: dict[str, dict[str, int]]


def count_totals(cases: Sequence[ScoredCase]) -> BlindTotals:
    """Returns the totals of a blind check's cases."""
    by_kind = {kind: [case for case in cases if case.kind == kind] for kind in ("single", "none", "outside", "two")}
    single, without, outside, double = by_kind.values()
    effects = sorted({case.true_effects[0] for case in single})
    of_effect = {name: [case for case in single if case.true_effects == (name,)] for name in effects}
    target_sizes = sorted({case.target_size for case in single})
    with_oracle = [case for case in cases if case.interval_holds_oracle is not None]
    defects = sorted({case.log_defect for case in without})
    return BlindTotals(
        correct={kind: proportion(case.correct for case in some) for kind, some in by_kind.items() if some},
        named=_named(single),
        named_from_size_1_5=_named(filter(is_clear, single)),
        named_where_gap_remains=_named(case for case in single if case.calibrated_gap >= REMAINING_GAP),
        named_where_identifiable=_named(case for case in single if case.identifiable),
        named_or_masked=proportion(
            case.truth_named or case.true_effects[0] in case.masked_effects for case in single if is_clear(case)
        ),
        both_named=_named(double),
        both_from_size_1_5=_named(filter(is_clear, double)),
        both_where_identifiable=_named(case for case in double if case.identifiable),
        false_alarms=proportion(case.verdict not in NO_EFFECT_VERDICTS for case in without),
        false_names=proportion(case.outcome == "false name" for case in outside),
        site_correct=proportion(case.site_correct for case in (*single, *double)),
        outside_site_correct=proportion(
            bool(case.site_correct) for case in outside if case.verdict not in NO_EFFECT_VERDICTS
        ),
        interval_coverage=proportion(case.interval_holds_oracle for case in with_oracle),
        closed_minus_oracle=quantiles(case.closed - case.oracle_closed for case in with_oracle),
        bed_end_errors=quantiles(abs(error) for case in cases for error in case.bed_end_errors or ()),
        cpu_s=quantiles(case.cpu_s for case in cases),
        wall_s=quantiles(case.wall_s for case in cases),
        by_size={
            name: _named_by(some, lambda case: f"{_nearest_target(case, target_sizes):g}")
            for name, some in of_effect.items()
        },
        by_well=_named_by(single, lambda case: case.well),
        by_manoeuvre=_named_by(single, lambda case: case.manoeuvre),
        by_log_defect=_named_by(single, lambda case: case.log_defect),
        false_alarms_by_log_defect={
            defect: proportion(case.verdict not in NO_EFFECT_VERDICTS for case in without if case.log_defect == defect)
            for defect in defects
        },
        detection_limits={
            name: detection_limit([case.sizes[0] for case in some], [case.truth_named for case in some])
            for name, some in of_effect.items()
        },
        confusion=_counts(cases, lambda case: " + ".join(case.named_effects) or case.verdict),
        outcomes=_counts(cases, lambda case: case.outcome),
    )


def _named(cases: Iterable[ScoredCase]) -> Proportion:
    return proportion(case.truth_named for case in cases)


def is_clear(case: ScoredCase) -> bool:
    """Returns whether each effect in the log reaches `CLEAR_SIZE`. Some change next to nothing at any amount."""
    return min(case.sizes) >= CLEAR_SIZE / SIZE_TOLERANCE


def _nearest_target(case: ScoredCase, target_sizes: Sequence[float]) -> float:
    """Returns the target size nearest to the size that the log reaches: some laws cannot reach their target."""
    return min(target_sizes, key=lambda size: abs(np.log(size / max(case.sizes[0], 1e-6))))


def _named_by(cases: Sequence[ScoredCase], key_of: Callable[[ScoredCase], str]) -> dict[str, Proportion]:
    keys = sorted({key_of(case) for case in cases})
    return {key: _named(case for case in cases if key_of(case) == key) for key in keys}


def _counts(cases: Sequence[ScoredCase], key_of: Callable[[ScoredCase], str]) -> dict[str, dict[str, int]]:
    counts: dict[str, dict[str, int]] = {}
    for case in cases:
        row = counts.setdefault(" + ".join(sorted(case.true_effects)) or "none", {})
        row[key_of(case)] = row.get(key_of(case), 0) + 1
    return {truth: dict(sorted(row.items())) for truth, row in sorted(counts.items())}


def without_nan(tree: Any) -> Any:
    """Returns a tree as JSON holds it: lists for tuples, null for numbers that are not finite."""
    if isinstance(tree, dict):
        return {key: without_nan(value) for key, value in tree.items()}
    if isinstance(tree, (list, tuple)):
        return [without_nan(value) for value in tree]
    return None if isinstance(tree, float) and not np.isfinite(tree) else tree
