"""Which candidates are worth a full fit: those that the score test promises much of, or a short fit does."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from slider_drilling.gap.contender import Base, untuned
from slider_drilling.gap.fit import Fit
from slider_drilling.gap.predictability import glimpse
from slider_drilling.gap.residuals import Problem
from slider_drilling.gap.screen import Candidate
from slider_drilling.gap.tune import GROWTH, SMOOTH, first_part, fit_exactly

SURVIVORS = 5
# So many of them by the score test, where it promises at least this share of the gap; the rest by short fits.
_PROMISED, _PROMISE = 2, 0.04
# A short fit that leaves more than this share of what the model without the effect leaves is one parameter's luck.
_BETTER = 0.98


@dataclass(frozen=True)
class Survivor:
    """A candidate to be fitted; thorough: it is one of the likeliest, worth a search that takes longer."""

    candidate: Candidate
    thorough: bool


def survivors(base: Base, candidates: Sequence[Candidate], further: bool = False) -> list[Survivor]:
    """What the log bears a mark of, and SURVIVORS of the other candidates.

    further: an effect has been accepted already; one beside it must promise something, or foretell the first part
    clearly better than the model without it.

    Of these first the most promising by the score test, then those that a short fit leaves least surprised. The score
    test sees what shows late, and what bends nothing else; but a nuisance that has bent itself to do an effect's work
    leaves it nothing to see. A fit of the first part of the runs from an untuned nuisance does see that. Thorough are
    the marked, those that promise at least half of what the best one does, and the first of the short fits.
    """
    marked = [candidate for candidate in candidates if candidate.effect.marked]
    rest = [candidate for candidate in candidates if not candidate.effect.marked]
    promising = [c for c in rest if c.promise >= _PROMISE * max(base.fit.cost - 1.0, 0.0)]
    part = first_part(base.problem, GROWTH[0])
    surprise = {candidate.effect.name: _short(base, part, candidate) for candidate in rest}
    short = sorted(rest, key=lambda candidate: surprise[candidate.effect.name])
    first = promising[:_PROMISED]
    if further:
        here = _surprise(part, base.fit)
        short = [candidate for candidate in short if surprise[candidate.effect.name] < _BETTER * here]
    chosen = marked + first + [c for c in short if c not in first][: SURVIVORS - len(first)]
    most = max((candidate.promise for candidate in chosen), default=0.0)
    likely = [c for c in chosen if c.effect.marked or c.promise >= 0.5 * most or c in short[:1]]
    return [Survivor(c, base.fit.cost > SMOOTH and c in likely) for c in chosen]


def _short(base: Base, part: Problem, candidate: Candidate) -> float:
    """Surprise that a fit of the first part leaves, from the scan point that costs least or that projects best."""
    starts, costs = untuned(base, part, candidate)
    parameters = [*base.fit.parameters, *candidate.effect.parameters]
    least = []
    for index in {0, int(np.argmin(costs))}:
        least.append(_surprise(part, fit_exactly(part, parameters, starts[index], 4)))
    return min(least)


def _surprise(part: Problem, found: Fit) -> float:
    """What a fit leaves of the first part, in its own floors."""
    part.anchor(found.values)
    own = glimpse(part, found)
    return own.robust_gap(own.residuals([found.values])[0])
