"""Which candidates are worth a full fit: those that the score test promises much of, or a short fit does."""

from __future__ import annotations

from collections.abc import Sequence

from slider_drilling.gap.contender import Base, untuned
from slider_drilling.gap.screen import Candidate
from slider_drilling.gap.tune import GROWTH, SMOOTH, fit_growing

SURVIVORS = 4
# A candidate whose best scan point promises less than this share of the gap is not worth a fit for that.
_PROMISE = 0.04


def chosen(base: Base, candidates: Sequence[Candidate]) -> list[Candidate]:
    """SURVIVORS of the candidates: first, in their order, those that promise enough.

    A nuisance that has bent itself to do an effect's work leaves the score test nothing to see; the rest are therefore
    those whose fit of the first part of the runs, from an untuned nuisance, costs least.
    """
    enough = [c for c in candidates if _promise(base, c) >= _PROMISE * max(base.fit.cost - 1.0, 0.0)][:SURVIVORS]
    others = [candidate for candidate in candidates if candidate not in enough]
    if len(enough) < SURVIVORS:
        costs = {candidate.effect.name: _short(base, candidate) for candidate in others}
        others.sort(key=lambda candidate: costs[candidate.effect.name])
    return enough + others[: SURVIVORS - len(enough)]


def favoured(base: Base, survivors: Sequence[Candidate]) -> list[Candidate]:
    """The candidates that promise at least half of what the best one does, worth a thorough search."""
    if base.fit.cost <= SMOOTH:
        return []
    most = max((_promise(base, candidate) for candidate in survivors), default=0.0)
    return [candidate for candidate in survivors if _promise(base, candidate) >= 0.5 * most]


def _promise(base: Base, candidate: Candidate) -> float:
    """By how much the score test says that the cost would fall."""
    return base.fit.cost - candidate.predicted


def _short(base: Base, candidate: Candidate) -> float:
    """Cost of a fit of the first part of the runs."""
    parameters = [*base.fit.parameters, *candidate.effect.parameters]
    start = untuned(base, candidate.points[0])
    return fit_growing(base.problem, parameters, start, iterations=4, shares=GROWTH[:1]).cost
