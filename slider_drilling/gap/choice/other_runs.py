"""Of several runs, a law has to explain the one that its fit has not seen."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from slider_drilling.gap.choice.state import Judged, State
from slider_drilling.gap.evidence.compare import Blocks, closed_between, shrinks
from slider_drilling.gap.evidence.score import Score, held_out_runs
from slider_drilling.gap.search.at_once import at_once


def held_to_other_runs(state: State, judged: Sequence[Judged]) -> tuple[Judged, ...]:
    """The same, but for effects with which the gap of runs that a fit has not seen does not shrink.

    Those that pass come first, who foretells most of such runs before the others: another excitation tells apart what
    more of the same does not, and a likeness of the cause goes wrong there.
    """
    asked = [one for one in judged if one.passed]
    if len(state.current.problem.model.runs) < 2 or not asked:
        return tuple(judged)
    known = held_out_runs(state.current.problem, state.current.fit)
    scores = at_once(lambda one: held_out_runs(one.explained.problem, one.explained.fit), asked)
    order = sorted(range(len(asked)), key=lambda index: scores[index].surprise)
    held = [_held(state.blocks, asked[index], known, scores[index]) for index in order]
    return (*held, *(one for one in judged if not one.passed))


def _held(blocks: Blocks, one: Judged, known: Score, score: Score) -> Judged:
    there = closed_between(blocks, known, score)
    why = () if shrinks(*there) else ("in runs that its fit has not seen the gap does not shrink for certain",)
    return replace(one, in_other_runs=there, why_not=why)
