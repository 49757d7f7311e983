"""One round of an investigation: what the logs so far say, and the test that was planned after them."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from slider_drilling.diagnosis.earlier_answer import earlier_answer
from slider_drilling.diagnosis.programme_words import programme_in_words
from slider_drilling.errors import InputError
from slider_drilling.files.output_files import read_text
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


def read_round_answer(path: Path) -> RoundAnswer:
    """The answer in a diagnosis.json of an investigation. Raises InputError where that is damaged."""
    try:
        tree = json.loads(read_text(path, "diagnosis"))
    except ValueError:
        raise InputError(_damaged(str(path))) from None
    return round_answer(tree, str(path))


def round_answer(tree: Mapping[str, Any], source: str) -> RoundAnswer:
    """The answer in a tree of diagnosis.json; ``source`` names it in errors. Raises InputError."""
    answer = earlier_answer(tree, source)
    try:
        asked, summary = tree["next_manoeuvre"], str(tree["summary"])
        why_not = {row["effect"]: tuple(row["why_not"]) for row in tree["ranking"]}
        still_open = None if asked is None else str(asked["reason"])
    except (KeyError, TypeError):
        raise InputError(_damaged(source)) from None
    return RoundAnswer(answer.verdict, summary, answer.effects, still_open, answer.explanations, why_not)


def _damaged(source: str) -> str:
    return f"{source}: damaged; delete its folder and run the same command again"


def planned_test(plan: DrillingPlan) -> PlannedTest:
    """What a round keeps of a plan."""
    last = programme_in_words(plan.programme, plan.rig)[-1]
    return PlannedTest(last.begin + last.duration, tuple(effect_rows(plan)))
