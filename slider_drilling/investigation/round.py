"""One round of an investigation: what the logs so far say, and the test that was planned after them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from slider_drilling.diagnosis.earlier_answer import earlier_answer
from slider_drilling.diagnosis.programme_words import programme_in_words
from slider_drilling.gap.experiment_design.knowledge import Explanation
from slider_drilling.test_planning.drilling_plan import DrillingPlan
from slider_drilling.test_planning.effect_sizes import EffectRow, effect_rows


@dataclass(frozen=True)
class RoundAnswer:
    """What the diagnosis of a round says.

    Attributes:
        verdict: Its verdict.
        summary: In a driller's words.
        effects: Effects that it names.
        still_open: What it leaves open, in words; None where the answer stands.
        explanations: What may explain the logs, the answer first.
        why_not: By effect, why it is not in the answer.
    """

    verdict: str
    summary: str
    effects: tuple[str, ...]
    still_open: str | None
    explanations: tuple[Explanation, ...] = field(repr=False)
    why_not: Mapping[str, tuple[str, ...]] = field(default_factory=dict, repr=False)


@dataclass(frozen=True)
class PlannedTest:
    """The test that was planned after a round.

    Attributes:
        duration: s.
        effects: Effects that may still show, with the power of the logs so far and of the test.
    """

    duration: float
    effects: tuple[EffectRow, ...]


@dataclass(frozen=True)
class Round:
    """One round: what all logs so far say, and what to ask next.

    Attributes:
        number: From 1 on; also the number of logs.
        answer: What they say.
        test: The test after it; None after the last round.
        open_before: What is left to find out after the logs so far (`Prospect.loss`); None without a plan.
        open_after: The same after the planned run.
    """

    number: int
    answer: RoundAnswer
    test: PlannedTest | None = field(default=None, repr=False)
    open_before: float | None = None
    open_after: float | None = None


def round_answer(tree: Mapping[str, Any], source: str) -> RoundAnswer:
    """The answer in a tree of diagnosis.json; ``source`` names it in errors. Raises InputError."""
    answer, asked = earlier_answer(tree, source), tree["next_manoeuvre"]
    why_not = {row["effect"]: tuple(row["why_not"]) for row in tree["ranking"]}
    still_open = None if asked is None else str(asked["reason"])
    return RoundAnswer(answer.verdict, str(tree["summary"]), answer.effects, still_open, answer.explanations, why_not)


def planned_test(plan: DrillingPlan) -> PlannedTest:
    """What a round keeps of a plan."""
    last = programme_in_words(plan.programme, plan.rig)[-1]
    return PlannedTest(last.begin + last.duration, tuple(effect_rows(plan)))
