"""Of several runs, a law has to explain the one that its fit has not seen."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from slider_drilling.gap.choice.state import Judged, State
from slider_drilling.gap.evidence.compare import closed_between, shrinks


def held_to_other_runs(state: State, one: Judged) -> Judged:
    """The same, but for an effect with which the gap of runs that its fit has not seen does not shrink: another
    excitation tells apart what more of the same does not, and a likeness of the cause goes wrong there.
    """
    if not one.passed or len(state.current.problem.model.runs) < 2:
        return one
    there = state.blocks, state.current.across_runs, one.explained.across_runs
    why = () if shrinks(*there) else ("in runs that its fit has not seen the gap does not shrink for certain",)
    return replace(one, in_other_runs=closed_between(*there), why_not=why)


def told_in_other_runs_first(judged: Sequence[Judged]) -> tuple[Judged, ...]:
    """The same in order: those that were held to other runs, who foretells most of them before the others, then the
    rest as they come.
    """
    asked = [one for one in judged if one.in_other_runs is not None]
    asked.sort(key=lambda one: one.explained.across_runs.surprise)
    return (*asked, *(one for one in judged if one.in_other_runs is None))
