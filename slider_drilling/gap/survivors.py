"""Which candidates are worth a full fit: those that the score test promises much of, or a short fit does."""

from __future__ import annotations

from collections.abc import Sequence

from slider_drilling.gap.contender import Base, untuned
from slider_drilling.gap.screen import Candidate
from slider_drilling.gap.tune import GROWTH, SMOOTH, fit_growing

SURVIVORS = 4
# So many of them by the score test, where it promises at least this share of the gap; the rest by short fits.
_PROMISED, _PROMISE = 2, 0.04


def chosen(base: Base, candidates: Sequence[Candidate]) -> list[Candidate]:
    """What the log bears a mark of, and SURVIVORS of the other candidates.

    Of these first the most promising by the score test, then those whose short fits cost least. The score test sees
    what shows late, and what bends nothing else; but a nuisance that has bent itself to do an effect's work leaves it
    nothing to see. A fit of the first part of the runs from an untuned nuisance does see that.
    """
    marked = [candidate for candidate in candidates if candidate.effect.marked]
    rest = [candidate for candidate in candidates if not candidate.effect.marked]
    enough = [c for c in rest if _promise(base, c) >= _PROMISE * max(base.fit.cost - 1.0, 0.0)][:_PROMISED]
    short = [(_short(base, candidate), place) for place, candidate in enumerate(rest) if candidate not in enough]
    best = [rest[place] for _, place in sorted(short)]
    return marked + enough + best[: SURVIVORS - len(enough)]


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
