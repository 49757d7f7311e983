"""Of several runs, a law has to explain the one that its fit has not seen."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from slider_drilling.gap.evidence.compare import gap_closed, shrinks
from slider_drilling.gap.selection.state import CandidateResult, SearchState


def check_other_runs(state: SearchState, one: CandidateResult) -> CandidateResult:
    """The same, but for an effect with which the gap of runs that its fit has not seen does not shrink: another
    excitation tells apart what more of the same does not, and a likeness of the cause goes wrong there.
    """
    if not one.passed or len(state.current.problem.model.runs) < 2:
        return one
    there = state.bootstrap, state.current.cross_run_score, one.fitted.cross_run_score
    why = () if shrinks(*there) else ("in runs that its fit has not seen the gap does not shrink for certain",)
    return replace(one, closed_in_other_runs=gap_closed(*there), failures=why)


def order_by_other_runs(judged: Sequence[CandidateResult]) -> tuple[CandidateResult, ...]:
    """The same in order: those that were held to other runs, who foretells most of them before the others, then the
    rest as they come.
    """
    asked = [one for one in judged if one.closed_in_other_runs is not None]
    asked.sort(key=lambda one: one.fitted.cross_run_score.held_out_deviance)
    return (*asked, *(one for one in judged if one.closed_in_other_runs is None))
