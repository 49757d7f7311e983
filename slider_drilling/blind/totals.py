"""What a blind check shows in all: counts with their binomial intervals, and what was confused with what."""

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
"""E from which re-tuning has left something to name: a little above what the diagnosis takes for negligible."""


@dataclass(frozen=True)
class Proportion:
    """count of all; low, high: the exact (Clopper and Pearson) 95 % interval of the chance, None where there is none
    to count."""

    count: int
    total: int
    low: float | None
    high: float | None

    def __str__(self) -> str:
        if self.low is None or self.high is None:
            return "-"
        percent = 100.0 * self.count / self.total
        return f"{self.count} of {self.total}, {percent:.0f} % [{100.0 * self.low:.0f}, {100.0 * self.high:.0f}]"


def proportion(of: Iterable[bool | None]) -> Proportion:
    """How many are true, of those that are not None."""
    known = [bool(one) for one in of if one is not None]
    if not known:
        return Proportion(0, 0, None, None)
    interval = binomtest(sum(known), len(known)).proportion_ci(0.95, method="exact")
    return Proportion(sum(known), len(known), float(interval.low), float(interval.high))


@dataclass(frozen=True)
class Quantiles:
    """Median, 5 % and 95 % of what is finite, None where nothing is."""

    median: float | None
    low: float | None
    high: float | None
    total: int


def quantiles(values: Iterable[float]) -> Quantiles:
    finite = [value for value in values if np.isfinite(value)]
    if not finite:
        return Quantiles(None, None, None, 0)
    low, median, high = (float(value) for value in np.quantile(finite, (0.05, 0.5, 0.95)))
    return Quantiles(median, low, high, len(finite))


@dataclass(frozen=True)
class BlindTotals:
    """All figures of a blind check.

    right: by kind; named: of the catalogue's effects alone, named or in the top group; named_from_1_5: of those that
    reached 1.5 noise floors, as near as logs are sealed; named_of_left: of those of which re-tuning leaves E of `LEFT`
    and above; named_of_nameable, both_of_nameable: of those, one effect and two, that the oracle names in most repeats;
    told: of those that reached 1.5, named or told as what re-tuning may stand for; both_named,
    both_from_1_5: of two effects both, of all logs and of those where each reached 1.5; false_alarms: effect-free logs
    that were called anything but ``none`` or ``parameters``; bare_names: laws from outside that got a name and nothing
    else; sites: right where one was given; coverage: of the reported 95 % intervals over the oracle's share;
    against_oracle: share closed minus the oracle's; ends: absolute errors m of a bed's ends; by_size (the asked-for
    size nearest to the one reached), by_well, by_manoeuvre, by_lacking: named; alarms_by_lacking: of effect-free logs;
    limits: by effect; confusion: what was said, by truth.
    """

    correct: dict[str, Proportion]
    named: Proportion
    named_from_size_1_5: Proportion
    named_where_gap_remains: Proportion
    named_where_identifiable: Proportion
    named_or_suspected: Proportion
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
    """Count a blind check's cases."""
    single = [case for case in cases if case.kind == "single"]
    outside = [case for case in cases if case.kind == "outside"]
    free = [case for case in cases if case.kind == "none"]
    double = [case for case in cases if case.kind == "two"]
    effects = sorted({case.true_effects[0] for case in single})
    asked = sorted({case.target_size for case in single})
    alone = {name: [case for case in single if case.true_effects == (name,)] for name in effects}
    kinds = {"single": single, "none": free, "outside": outside, "two": double}
    exact = [case for case in cases if case.interval_holds_oracle is not None]
    return BlindTotals(
        correct={kind: proportion(case.correct for case in of) for kind, of in kinds.items() if of},
        named=proportion(case.truth_named for case in single),
        named_from_size_1_5=proportion(case.truth_named for case in single if _plain(case)),
        named_where_gap_remains=proportion(case.truth_named for case in single if case.calibrated_gap >= REMAINING_GAP),
        named_where_identifiable=proportion(case.truth_named for case in single if case.identifiable),
        named_or_suspected=proportion(
            case.truth_named or case.true_effects[0] in case.suspected for case in single if _plain(case)
        ),
        both_named=proportion(case.truth_named for case in double),
        both_from_size_1_5=proportion(case.truth_named for case in double if _plain(case)),
        both_where_identifiable=proportion(case.truth_named for case in double if case.identifiable),
        false_alarms=proportion(case.verdict not in NO_EFFECT_VERDICTS for case in free),
        false_names=proportion(case.outcome == "false name" for case in outside),
        site_correct=proportion(case.site_correct for case in (*single, *double)),
        outside_site_correct=proportion(
            bool(case.site_correct) for case in outside if case.verdict not in NO_EFFECT_VERDICTS
        ),
        interval_coverage=proportion(case.interval_holds_oracle for case in exact),
        closed_minus_oracle=quantiles(case.closed - case.oracle_closed for case in exact),
        bed_end_errors=quantiles(abs(end) for case in cases for end in case.bed_end_errors or ()),
        cpu_s=quantiles(case.cpu_s for case in cases),
        wall_s=quantiles(case.wall_s for case in cases),
        by_size={name: _by(of, lambda case: f"{_size(case, asked):g}") for name, of in alone.items()},
        by_well=_by(single, lambda case: case.well),
        by_manoeuvre=_by(single, lambda case: case.manoeuvre),
        by_log_defect=_by(single, lambda case: case.log_defect),
        false_alarms_by_log_defect={
            name: proportion(case.verdict not in NO_EFFECT_VERDICTS for case in free if case.log_defect == name)
            for name in sorted({case.log_defect for case in free})
        },
        detection_limits={
            name: detection_limit([case.sizes[0] for case in of], [case.truth_named for case in of])
            for name, of in alone.items()
        },
        confusion=_counts(cases, lambda case: " + ".join(case.named_effects) or case.verdict),
        outcomes=_counts(cases, lambda case: case.outcome),
    )


def _plain(case: ScoredCase) -> bool:
    """Whether each effect in the log reached 1.5 noise floors: some move next to nothing however large they are."""
    return min(case.sizes) >= 1.5 / SIZE_TOLERANCE


def _size(case: ScoredCase, asked: Sequence[float]) -> float:
    """The asked-for size that is nearest to what the log reached: no law can be made as large as one likes."""
    return min(asked, key=lambda size: abs(np.log(size / max(case.sizes[0], 1e-6))))


def case_name(case: ScoredCase) -> str:
    """What is in a case's log, as `Tally.confusion` and `Tally.outcomes` call it."""
    return " + ".join(sorted(case.true_effects)) or "none"


def _by(cases: Sequence[ScoredCase], what: Callable[[ScoredCase], str]) -> dict[str, Proportion]:
    return {
        key: proportion(case.truth_named for case in cases if what(case) == key)
        for key in sorted({what(case) for case in cases})
    }


def _counts(cases: Sequence[ScoredCase], what: Callable[[ScoredCase], str]) -> dict[str, dict[str, int]]:
    found: dict[str, dict[str, int]] = {}
    for case in cases:
        row = found.setdefault(case_name(case), {})
        row[what(case)] = row.get(what(case), 0) + 1
    return {truth: dict(sorted(row.items())) for truth, row in sorted(found.items())}


def without_nan(tree: Any) -> Any:
    """A tree of dataclasses' dictionaries as JSON has it: a number that does not exist is null."""
    if isinstance(tree, dict):
        return {key: without_nan(value) for key, value in tree.items()}
    if isinstance(tree, (list, tuple)):
        return [without_nan(value) for value in tree]
    return None if isinstance(tree, float) and not np.isfinite(tree) else tree
