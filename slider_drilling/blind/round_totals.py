"""Totals of the rounds of a blind check, arm by arm, and the planned programme against the others on the same cases."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

from scipy.stats import binomtest

from slider_drilling.blind.rounds import ArmResult
from slider_drilling.blind.score import ScoredCase
from slider_drilling.blind.totals import Proportion, is_clear, proportion


@dataclass(frozen=True)
class ArmTotals:
    """One arm.

    Attributes:
        arm: Its name.
        cases: Number of cases.
        single_named: One effect of `CLEAR_SIZE` or more: named.
        both_named: Two effects: both named.
        extra_names: Diagnosed cases with a name of an effect that is not there.
        false_alarms: No effect, and a verdict other than ``none`` or ``parameters``.
        correct: Correct diagnoses.
        over_limit: Runs that exceeded a limit in truth.
        largest_limit_use: Of any run; None for the routine log.
    """

    arm: str
    cases: int
    single_named: Proportion
    both_named: Proportion
    extra_names: Proportion
    false_alarms: Proportion
    correct: Proportion
    over_limit: Proportion
    largest_limit_use: float | None


@dataclass(frozen=True)
class Paired:
    """Two arms on the same cases with effects.

    Attributes:
        first, second: The arms.
        cases: Number of cases that both came to an end with.
        first_missed, second_missed: Cases in which an arm missed an effect.
        only_first_missed, only_second_missed: Cases in which only one of them did.
        p_value: Of no difference, by the exact test of McNemar; 1 where both missed the same.
    """

    first: str
    second: str
    cases: int
    first_missed: int
    second_missed: int
    only_first_missed: int
    only_second_missed: int
    p_value: float


def arm_totals(results: Sequence[ArmResult]) -> list[ArmTotals]:
    """The totals of every arm, in the order in which they were run."""
    return [
        _totals(arm, [each for each in results if each.arm == arm]) for arm in dict.fromkeys(r.arm for r in results)
    ]


def _totals(arm: str, own: Sequence[ArmResult]) -> ArmTotals:
    cases = [each.case for each in own]
    single = [case for case in cases if case.kind == "single" and is_clear(case)]
    used = [each.limit_use for each in own if each.limit_use is not None]
    return ArmTotals(
        arm, len(cases), proportion(case.truth_named for case in single),
        proportion(case.truth_named for case in cases if case.kind == "two"),
        proportion(each.case.extra_names > 0 for each in own if not each.gains),
        proportion(case.outcome == "false alarm" for case in cases if case.kind == "none"),
        proportion(case.correct for case in cases), proportion(share > 1.0 for share in used),
        max(used, default=None),
    )  # fmt: skip


def compare_arms(results: Sequence[ArmResult], first: str, second: str) -> Paired:
    """Two arms on the cases with effects that both came to an end with."""
    mine, other = (_with_effects(results, arm) for arm in (first, second))
    common = sorted(mine.keys() & other.keys())
    missed = [(not mine[log].truth_named, not other[log].truth_named) for log in common]
    only_first, only_second = (sum(a and not b for a, b in pairs) for pairs in (missed, [(b, a) for a, b in missed]))
    differ = only_first + only_second
    p_value = float(binomtest(only_first, differ, 0.5).pvalue) if differ else 1.0
    return Paired(first, second, len(common), sum(a for a, _ in missed), sum(b for _, b in missed), only_first,
                  only_second, p_value)  # fmt: skip


def _with_effects(results: Sequence[ArmResult], arm: str) -> dict[str, ScoredCase]:
    return {each.case.log: each.case for each in results if each.arm == arm and each.case.kind in ("single", "two")}


def rounds_json(results: Sequence[ArmResult], options: dict[str, Any]) -> dict[str, Any]:
    """The tree of rounds.json."""
    arms = arm_totals(results)
    planned = [each.arm for each in arms if each.arm.startswith("planned")][:1]
    others = [each.arm for each in arms if not each.arm.startswith("planned")]
    return {
        "schema": "slider_drilling/rounds/1",
        "options": options,
        "arms": [asdict(each) for each in arms],
        "paired": [asdict(compare_arms(results, first, other)) for first in planned for other in others],
        "cases": [
            {"arm": each.arm, "log": each.case.log, "effects": list(each.case.true_effects),
             "sizes": list(each.case.sizes), "verdict": each.case.verdict, "named": list(each.case.named_effects),
             "outcome": each.case.outcome, "limit_use": each.limit_use, "gains": dict(each.gains)}
            for each in results
        ],
    }  # fmt: skip
