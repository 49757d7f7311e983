"""One effect fitted, and the tests it must pass before its name may be used."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from slider_drilling.gap.fit import Fit
from slider_drilling.gap.held_out import Bootstrap, Folds, HeldOut, score_held_out
from slider_drilling.gap.model import Effect, Parameter, Values
from slider_drilling.gap.residuals import Problem
from slider_drilling.gap.screen import Candidate
from slider_drilling.gap.tune import GROWTH, fit_growing, scattered

ALPHA = 0.05
LEAST_GAIN = 0.05
STARTS = 5
# So many of the starts are followed further.
FAVOURITES = 2
# Interval reported for the gap closed: 95 %, two-sided.
_INTERVAL = (0.025, 0.975)
# A start's fit is another answer where it lacks less than this share of the best one's gain.
_ANOTHER = 0.15


@dataclass(frozen=True)
class Contender:
    """An effect fitted jointly with the nuisance and the effects already accepted.

    closed, interval: of the gap that the base left (NaN where there is none). gain, gain_bound: fall of the held-out
    robust score from the base's, and its lower bound at alpha over the number of candidates.
    """

    effect: Effect
    fit: Fit
    score: HeldOut
    closed: float
    interval: tuple[float, float]
    gain: float
    gain_bound: float
    starts_agree: bool
    physical: bool
    reasons: tuple[str, ...]

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
    """What a contender is compared with: the fit without it, and its score."""

    fit: Fit
    score: HeldOut


def make_base(problem: Problem, folds: Folds, bootstrap: Bootstrap, best: Fit) -> Base:
    """Score a fit on held-out stretches."""
    return Base(best, score_held_out(problem, best, folds, bootstrap))


def closed_share(base: float, with_effect: float) -> float:
    """``1 - (E_with^2 - 1) / (E_base^2 - 1)``; NaN where the base leaves nothing to close."""
    return 1.0 - (with_effect - 1.0) / (base - 1.0) if base > 1.0 else float("nan")


def fit_candidate(
    problem: Problem,
    base: Base,
    candidate: Candidate,
    *,
    iterations: int = 5,
    scatter: int = 0,
    thorough: bool = True,
) -> tuple[Fit, bool]:
    """The best fit over the starts, and whether no other start says something else as well.

    Every start is tried on the first part of the runs, the favourites for longer. thorough: the favourites go on to the
    longer part with a search besides least squares, else only the best of them does, without. The best of those is
    taken to the whole, where the model is left exact.
    """
    parameters: list[Parameter] = [*base.fit.parameters, *candidate.effect.parameters]
    tried = [*_starts(problem, base, candidate), *scattered(problem, parameters, base.fit.values, scatter, STARTS)]

    def best_of(starts: Sequence[Values], shares: Sequence[float], shaken: Sequence[float] = ()) -> list[Fit]:
        fits = [
            fit_growing(problem, parameters, start, iterations=iterations, shares=shares, shaken=shaken)
            for start in starts
        ]
        return sorted(fits, key=lambda found: found.cost)

    first, longer, whole = GROWTH
    fits = best_of(tried, (first,))
    fits = best_of([found.values for found in fits[:FAVOURITES]], (first, first))
    favourites = fits if thorough else fits[:1]
    shaken = (longer, whole) if thorough else ()
    fits = best_of([found.values for found in favourites], (longer,), shaken)
    best = best_of([fits[0].values], (whole,), shaken)[0]
    gain = problem.robust_gap(base.fit.residual) - best.cost
    return best, _agree(candidate.effect.parameters[0], gain, fits)


def _agree(amplitude: Parameter, gain: float, fits: Sequence[Fit]) -> bool:
    """Whether the fits that come close to the best one have an amplitude of its sign and half to twice its size.

    A start that ended in a clearly worse place has found another minimum, not another answer.
    """
    size = fits[0].values[amplitude.name] - amplitude.nominal
    for other in fits[1:]:
        close = other.cost - fits[0].cost <= _ANOTHER * gain
        ratio = (other.values[amplitude.name] - amplitude.nominal) / size if size != 0.0 else float("inf")
        if close and not 0.5 <= ratio <= 2.0:
            return False
    return True


def _starts(problem: Problem, base: Base, candidate: Candidate) -> list[dict[str, float]]:
    """The best projection, and the best scan points with the nuisance where it was before it was tuned.

    A tuned nuisance has bent itself to do the effect's work; from there the way to the truth can be barred.
    """
    free = {parameter.name: parameter.nominal for parameter in problem.free(problem.model.nuisance)}
    starts = [candidate.starts[0]]
    for point in candidate.points[: STARTS - 1]:
        starts.append(base.fit.values | free | point)
    return starts


def judge(
    problem: Problem,
    folds: Folds,
    bootstrap: Bootstrap,
    base: Base,
    effect: Effect,
    best: Fit,
    starts_agree: bool,
    candidates: int,
) -> Contender:
    """Score a fitted effect on held-out stretches and apply the tests of spec gap.md."""
    score = score_held_out(problem, best, folds, bootstrap)
    gain = base.score.robust - score.robust
    bound = float(np.quantile(base.score.robust_resampled - score.robust_resampled, ALPHA / candidates))
    before, after = base.score.resampled, score.resampled
    with np.errstate(divide="ignore", invalid="ignore"):
        shares = np.where(before > 1.0, 1.0 - (after - 1.0) / (before - 1.0), np.nan)
    interval = (float("nan"), float("nan"))
    if base.score.gap_squared > 1.0 and np.isfinite(shares).any():
        interval = (float(np.nanquantile(shares, _INTERVAL[0])), float(np.nanquantile(shares, _INTERVAL[1])))
    low, high = effect.physical
    amplitude = best.values[effect.parameters[0].name]
    physical = low <= amplitude <= high
    reasons = []
    if bound <= 0.0:
        reasons.append(f"gain not certain: its lower bound is {bound:.3g} at alpha = {ALPHA:g}/{candidates}")
    if gain < LEAST_GAIN * (base.score.robust - 1.0):
        reasons.append("closes less than 5 % of the held-out gap")
    closed = closed_share(base.score.gap_squared, score.gap_squared)
    if closed <= 0.0:
        reasons.append("the gap itself does not shrink")
    if not physical:
        reasons.append(f"fit is not physical: it has the shape of {effect.nonphysical}")
    if not starts_agree:
        reasons.append("starts disagree")
    return Contender(effect, best, score, closed, interval, gain, bound, starts_agree, physical, tuple(reasons))


def indistinguishable(problem: Problem, base: Base, winner: Contender, other: Contender) -> str | None:
    """Why the data cannot tell two contenders apart, None when they can.

    Either the bootstrap interval of the difference of their held-out scores holds zero, or what they add to the
    simulation, with the nuisance directions projected out, points the same way (cosine above 0.95).
    """
    difference = other.score.robust_resampled - winner.score.robust_resampled
    if float(np.quantile(difference, ALPHA)) <= 0.0:
        return "held-out errors do not differ"
    cosine = projected_cosine(problem, base, winner, other)
    return f"projected cosine {cosine:.3f}" if cosine > 0.95 else None


def projected_cosine(problem: Problem, base: Base, first: Contender, second: Contender) -> float:
    """Cosine between what two fits add beyond the nuisance."""
    rows = problem.weight[:, None] * base.fit.jacobian
    basis, _ = np.linalg.qr(rows)
    added = []
    for contender in (first, second):
        change = problem.weight * (contender.fit.residual - base.fit.residual)
        added.append(change - basis @ (basis.T @ change))
    norm = np.linalg.norm(added[0]) * np.linalg.norm(added[1])
    return float(added[0] @ added[1] / norm) if norm > 0.0 else 0.0
