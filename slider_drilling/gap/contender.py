"""One effect fitted, and the tests it must pass before its name may be used."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from slider_drilling.gap.held_out import Bootstrap, Folds, held_out_residual
from slider_drilling.gap.model import Array, Effect, Parameter
from slider_drilling.gap.residuals import Problem
from slider_drilling.gap.screen import Candidate
from slider_drilling.gap.tune import GROWTH, Fit, fit_growing, scattered

ALPHA = 0.05
LEAST_GAIN = 0.05
STARTS = 3
# Interval reported for the gap closed: 95 %, two-sided.
_INTERVAL = (0.025, 0.975)
# Starts agree when another one comes within this share of the best one's gain.
_AGREEMENT = 0.15


@dataclass(frozen=True)
class Contender:
    """An effect fitted jointly with the nuisance and the effects already accepted.

    held: (N,) held-out residual, gap_squared its E^2; closed, interval: of the gap that the base left (NaN where
    there is none). robust, gain, gain_bound: held-out score under the fit's own loss, its fall from the base's, and
    that fall's lower bound at alpha over the number of candidates: acceptance rests on these, because E^2 itself can
    hang on a single far-off angle.
    """

    effect: Effect
    fit: Fit
    held: Array
    gap_squared: float
    robust: float
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
    """What a contender is compared with: the fit without it, its held-out residual and how that resamples.

    resampled: (BOOTSTRAPS,) of gap_squared (E^2); robust_resampled: of robust, the score under the fit's loss.
    """

    fit: Fit
    held: Array
    resampled: Array
    gap_squared: float
    robust_resampled: Array
    robust: float


def make_base(problem: Problem, folds: Folds, bootstrap: Bootstrap, best: Fit) -> Base:
    """Score a fit on held-out stretches."""
    held = held_out_residual(problem, best, folds)
    mapped, _ = problem.robust(held)
    return Base(
        best, held, bootstrap.gaps_squared(held), problem.gap_squared(held),
        bootstrap.gaps_squared(mapped), problem.gap_squared(mapped),
    )  # fmt: skip


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
    tick: Callable[[], None] = lambda: None,
) -> tuple[Fit, bool]:
    """The best fit over the starts, and whether another start found it too.

    Every start is tried on the first part of the runs; the two best of them go on to the whole, the better one to
    the end, and the model is made exact again wherever a stage has arrived. It is left exact at the best fit.
    """
    parameters: list[Parameter] = [*base.fit.parameters, *candidate.effect.parameters]
    tried = [*_starts(problem, base, candidate), *scattered(problem, parameters, base.fit.values, scatter, STARTS)]
    firsts = []
    for start in tried:
        firsts.append(fit_growing(problem, parameters, start, iterations=iterations, shares=GROWTH[:1]))
        tick()
    firsts.sort(key=lambda result: result.cost)
    fits = []
    for first in firsts[:2]:
        fits.append(fit_growing(problem, parameters, first.values, iterations=iterations, shares=(*GROWTH[1:], 1.0)))
        tick()
    fits.sort(key=lambda result: result.cost)
    best = fits[0]
    gain = base.fit.cost - best.cost
    return best, fits[1].cost - best.cost <= _AGREEMENT * gain


def _starts(problem: Problem, base: Base, candidate: Candidate) -> list[dict[str, float]]:
    """The best projection, and the two best scan points with the nuisance where it was before it was tuned.

    A tuned nuisance has bent itself to do the effect's work; from there the way to the truth can be barred.
    """
    free = {parameter.name: parameter.nominal for parameter in problem.free(problem.model.nuisance)}
    starts = [candidate.starts[0]]
    for start in candidate.starts[: STARTS - 1]:
        own = {parameter.name: start[parameter.name] for parameter in candidate.effect.parameters}
        starts.append(base.fit.values | free | own)
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
    held = held_out_residual(problem, best, folds)
    resampled = bootstrap.gaps_squared(held)
    squared = problem.gap_squared(held)
    mapped, _ = problem.robust(held)
    robust = problem.gap_squared(mapped)
    gain = base.robust - robust
    bound = float(np.quantile(base.robust_resampled - bootstrap.gaps_squared(mapped), ALPHA / candidates))
    with np.errstate(divide="ignore", invalid="ignore"):
        shares = np.where(base.resampled > 1.0, 1.0 - (resampled - 1.0) / (base.resampled - 1.0), np.nan)
    interval = (float("nan"), float("nan"))
    if base.gap_squared > 1.0 and np.isfinite(shares).any():
        interval = (float(np.nanquantile(shares, _INTERVAL[0])), float(np.nanquantile(shares, _INTERVAL[1])))
    low, high = effect.physical
    amplitude = best.values[effect.parameters[0].name]
    physical = low <= amplitude <= high
    reasons = []
    if bound <= 0.0:
        reasons.append(f"gain not certain: its lower bound is {bound:.3g} at alpha = {ALPHA:g}/{candidates}")
    if gain < LEAST_GAIN * (base.robust - 1.0):
        reasons.append("closes less than 5 % of the held-out gap")
    if not physical:
        reasons.append(f"fit is not physical: it has the shape of {effect.nonphysical}")
    if not starts_agree:
        reasons.append("starts disagree")
    return Contender(
        effect, best, held, squared, robust, closed_share(base.gap_squared, squared), interval, gain, bound,
        starts_agree, physical, tuple(reasons),
    )  # fmt: skip


def indistinguishable(
    problem: Problem, bootstrap: Bootstrap, base: Base, winner: Contender, other: Contender
) -> str | None:
    """Why the data cannot tell two contenders apart, None when they can.

    Either the bootstrap interval of the difference of their held-out E^2 holds zero, or what they add to the
    simulation, with the nuisance directions projected out, points the same way (cosine above 0.95).
    """
    mapped = [problem.robust(contender.held)[0] for contender in (other, winner)]
    difference = bootstrap.gaps_squared(mapped[0]) - bootstrap.gaps_squared(mapped[1])
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
