"""One effect fitted, and the tests it must pass before its name may be used."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from slider_drilling.gap.fit import Fit
from slider_drilling.gap.held_out import Bootstrap, HeldOut, score_held_out
from slider_drilling.gap.model import Effect, Parameter, Values
from slider_drilling.gap.predictability import foresee
from slider_drilling.gap.residuals import Problem
from slider_drilling.gap.screen import Candidate
from slider_drilling.gap.tune import GROWTH, first_part, fit_growing, roamed, scattered, settle, spread_out

ALPHA = 0.05
LEAST_GAIN = 0.05
# Of the amplitude's scale. A still smaller effect changes when a bit breaks free, no more, and so does any other.
LEAST_SIZE = 0.5
STARTS = 6
# Points with a nuisance somewhere else that are looked at for each candidate.
_ELSEWHERE = 32
# So many of the starts are followed further.
FAVOURITES = 2
# Interval reported for the gap closed: 95 %, two-sided.
_INTERVAL = (0.025, 0.975)
# A start's fit is another answer where it lacks less than this share of the best one's gain.
_ANOTHER = 0.05


End = tuple[Problem, Fit]
"""Where a search has ended: a fit, and the problem with its floors."""


@dataclass(frozen=True, eq=False)
class Contender:
    """An effect fitted jointly with the nuisance and the effects already accepted.

    problem: with the floors of its own fit. closed, interval: of the gap that the base left (NaN where there is none),
    both in these floors. gain, gain_bound: fall of the held-out surprise from the base's, and its lower bound at alpha
    over the number of candidates. others: where else its search has ended, with the floors of each.
    """

    effect: Effect
    problem: Problem
    fit: Fit
    score: HeldOut
    closed: float
    interval: tuple[float, float]
    gain: float
    gain_bound: float
    starts_agree: bool
    physical: bool
    reasons: tuple[str, ...]
    others: tuple[End, ...] = ()

    @property
    def accepted(self) -> bool:
        """Every test passed."""
        return not self.reasons

    @property
    def amplitude(self) -> float:
        """The effect's first parameter."""
        return self.fit.values[self.effect.parameters[0].name]

    def parameters(self) -> dict[str, float]:
        """The effect's own parameters."""
        return {parameter.name: self.fit.values[parameter.name] for parameter in self.effect.parameters}


@dataclass(frozen=True)
class Base:
    """What a contender is compared with: the fit without it, its score, and the problem with this fit's floors."""

    problem: Problem
    fit: Fit
    score: HeldOut


def make_base(problem: Problem, bootstrap: Bootstrap, best: Fit) -> Base:
    """Score a fit on held-out stretches."""
    return Base(problem, best, score_held_out(problem, best, bootstrap))


def fit_candidate(
    base: Base,
    candidate: Candidate,
    *,
    iterations: int = 5,
    scatter: int = 0,
    thorough: bool = True,
) -> tuple[list[End], bool]:
    """Where the starts lead to, best first, and whether all that come close to the best say the same.

    Every start is tried on the first part of the runs, the favourites for longer. thorough: the favourites go on to the
    whole, each with its own floors, else only the best of them does. Where none fits better than the base, growing has
    lost what that has found late in the runs, and the whole is fitted at once from the best projection. The model is
    left exact at the best.
    """
    problem = base.problem
    parameters: list[Parameter] = [*base.fit.parameters, *candidate.effect.parameters]
    tried = [*_starts(base, candidate), *scattered(problem, parameters, base.fit.values, scatter, STARTS)]

    first, longer, whole = GROWTH

    def best_of(starts: Sequence[Values], shares: Sequence[float]) -> list[Fit]:
        fits = [fit_growing(problem, parameters, start, iterations=iterations, shares=shares) for start in starts]
        return sorted(fits, key=lambda found: found.cost)

    fits = best_of(tried, (first,))
    if thorough:
        part = first_part(problem, first)
        fits = [roamed(part, found, iterations) for found in fits[:FAVOURITES]]
    fits = best_of([found.values for found in fits[:FAVOURITES]], (first, first))
    ends: list[End] = []
    for start in fits if thorough else fits[:1]:
        own, found = problem, start
        for share in (longer, whole):
            own = foresee(own, found)
            found = fit_growing(own, parameters, found.values, iterations=iterations, shares=(share,))
        ends.append((own, found))
    if min(found.cost for _, found in ends) >= base.fit.cost:
        found = fit_growing(problem, parameters, candidate.starts[0], iterations=iterations, shares=(whole,))
        ends.append(settle(problem, found))
    if not _one_answer(candidate.effect, base, ends):
        # They may only be still on their way.
        ends = [settle(own, found) for own, found in ends]
    ends.sort(key=lambda end: end[1].cost)
    own, best = ends[0]
    own.anchor(best.values)
    return ends, _one_answer(candidate.effect, base, ends)


def _one_answer(effect: Effect, base: Base, ends: Sequence[End]) -> bool:
    fits = sorted((found for _, found in ends), key=lambda found: found.cost)
    return agree(effect, base.fit.cost - fits[0].cost, fits)


def agree(effect: Effect, gain: float, fits: Sequence[Fit]) -> bool:
    """Whether the fits that come close to the best one have an amplitude of its sign and half to twice its size.

    A start that ended in a clearly worse place has found another minimum, not another answer.
    """
    amplitude = effect.parameters[0]
    size = fits[0].values[amplitude.name] - amplitude.nominal
    for other in fits[1:]:
        close = other.cost - fits[0].cost <= _ANOTHER * gain
        ratio = (other.values[amplitude.name] - amplitude.nominal) / size if size != 0.0 else float("inf")
        if close and not 0.5 <= (abs(ratio) if effect.either_sign else ratio) <= 2.0:
            return False
    return True


def _starts(base: Base, candidate: Candidate) -> list[dict[str, float]]:
    """The best projection, and scan points with the nuisance where it was before it was tuned.

    Half of these are those that cost least as they are, with a nuisance somewhere else; half those whose projection is
    best: a tuned nuisance that has bent itself around a bed of cuttings projects it to another depth.
    """
    points, costs = untuned(base, base.problem, candidate)
    cheapest = [int(index) for index in np.argsort(costs)[: STARTS // 2]]
    others = [index for index in range(len(candidate.points)) if index not in cheapest]
    return [candidate.starts[0], *(points[index] for index in [*cheapest, *others][: STARTS - 1])]


def untuned(base: Base, problem: Problem, candidate: Candidate) -> tuple[list[dict[str, float]], list[float]]:
    """Where to begin without the tuned nuisance, and what each place costs.

    First the scan points with a nominal nuisance, best projection first, then scan points with one that is off as rigs
    are. problem: the base's, or the first part of it; left exact at the base's fit.

    A tuned nuisance has bent itself to do the effect's work; from there the way to the truth can be barred.
    """
    nuisance = problem.free(problem.model.nuisance)
    nominal = {parameter.name: parameter.nominal for parameter in nuisance}
    elsewhere = spread_out([parameter for parameter in nuisance if not parameter.per_run], _ELSEWHERE, 1.0)
    turns = itertools.cycle(candidate.points)
    points = [base.fit.values | nominal | point for point in candidate.points]
    points += [base.fit.values | nominal | off | point for off, point in zip(elsewhere, turns, strict=False)]
    problem.anchor(base.fit.values)
    return points, [problem.robust_gap(residual) for residual in problem.residuals(points)]


def judge(
    problem: Problem,
    bootstrap: Bootstrap,
    base: Base,
    effect: Effect,
    best: Fit,
    starts_agree: bool,
    candidates: int,
) -> Contender:
    """Score a fitted effect on held-out stretches and apply the tests of spec gap.md; problem: in the fit's floors."""
    score = score_held_out(problem, best, bootstrap)
    gain = base.score.surprise - score.surprise
    bound = float(np.quantile(base.score.surprise_resampled - score.surprise_resampled, ALPHA / candidates))
    closed, interval = share_closed(bootstrap, base, problem, score)
    low, high = effect.physical
    free = effect.parameters[0]
    amplitude = best.values[free.name]
    physical = low <= amplitude <= high
    reasons = []
    if bound <= 0.0:
        reasons.append(f"gain not certain: its lower bound is {bound:.3g} at alpha = {ALPHA:g}/{candidates}")
    if gain < LEAST_GAIN * (base.score.surprise - 1.0):
        reasons.append("closes less than 5 % of the held-out gap")
    if not _shrinks(base, problem, score):
        reasons.append("the gap itself does not shrink")
    if abs(amplitude - free.nominal) < LEAST_SIZE * free.scale:
        unit = "" if free.unit == "-" else f" {free.unit}"
        reasons.append(f"vanishing size: less than half of {free.scale:g}{unit}")
    if not physical:
        reasons.append(f"fit is not physical: it has the shape of {effect.nonphysical}")
    if not starts_agree:
        reasons.append("starts disagree")
    return Contender(
        effect, problem, best, score, closed, interval, gain, bound, starts_agree, physical, tuple(reasons)
    )


def _shrinks(base: Base, problem: Problem, score: HeldOut) -> bool:
    """Whether the surprise shrinks too with every channel alike, each model in its own floors."""
    return _alike(problem, score) < _alike(base.problem, base.score)


def _alike(problem: Problem, score: HeldOut) -> float:
    return float(problem.score @ (problem.robust(score.residual)[0] ** 2 + problem.price))


def share_closed(
    bootstrap: Bootstrap, base: Base, problem: Problem, score: HeldOut
) -> tuple[float, tuple[float, float]]:
    """``1 - (E_fit^2 - 1) / (E_base^2 - 1)``, the share of the base's gap that a fit closes, with its interval.

    In the floors of the fit's problem. NaN where the base leaves nothing to close.
    """
    residual = base.problem.in_floors_of(problem, base.score.residual)
    gap_squared = problem.gap_squared(residual)
    before, after = bootstrap.means(residual**2, problem.score), score.resampled
    left = before > 1.0
    if gap_squared <= 1.0 or not left.any():
        return float("nan"), (float("nan"), float("nan"))
    shares = 1.0 - (after[left] - 1.0) / (before[left] - 1.0)
    low, high = (float(np.quantile(shares, level)) for level in _INTERVAL)
    return 1.0 - (score.gap_squared - 1.0) / (gap_squared - 1.0), (low, high)


def indistinguishable(base: Base, winner: Contender, other: Contender) -> str | None:
    """Why the data cannot tell two contenders apart, None when they can.

    Either the bootstrap interval of the difference of their held-out scores holds zero, or what they add to the
    simulation, with the nuisance directions projected out, points the same way (cosine above 0.95).
    """
    difference = other.score.surprise_resampled - winner.score.surprise_resampled
    if float(np.quantile(difference, ALPHA)) <= 0.0:
        return "held-out errors do not differ"
    cosine = projected_cosine(base, winner, other)
    return f"projected cosine {cosine:.3f}" if cosine > 0.95 else None


def projected_cosine(base: Base, first: Contender, second: Contender) -> float:
    """Cosine between what two fits add beyond the nuisance."""
    problem = base.problem
    rows = problem.weight[:, None] * base.fit.jacobian
    basis, _ = np.linalg.qr(rows)
    added = []
    for contender in (first, second):
        residual = contender.problem.in_floors_of(problem, contender.fit.residual)
        change = problem.weight * (residual - base.fit.residual)
        added.append(change - basis @ (basis.T @ change))
    norm = np.linalg.norm(added[0]) * np.linalg.norm(added[1])
    return float(added[0] @ added[1] / norm) if norm > 0.0 else 0.0
