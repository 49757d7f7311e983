"""Adequacy of a fitted model: does it leave what it would leave if it were the truth?

The model is fitted in a cheaper simulation than its finest. On its own replicates it leaves discretisation error, what
cannot be predicted, and noise. A gap beyond that, and beyond the budget for the model's own error, is structure.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2
from scipy.stats import t as student

from slider_drilling.gap.evidence.replicates import replicate_residuals
from slider_drilling.gap.evidence.score import HeldOutScore, squared_residuals
from slider_drilling.gap.model import Array, Effect
from slider_drilling.gap.problem.model_error import wander_budget
from slider_drilling.gap.problem.problem import Problem
from slider_drilling.gap.search.least_squares import Fit
from slider_drilling.gap.search.screen import scan_changes

ADEQUACY_LEVEL = 0.01
# -2 log p that two free numbers (size and memory of a discrepancy) gain on white noise at that level.
_TWO_PARAMETER_GAIN = float(chi2.isf(ADEQUACY_LEVEL, 2))
# E^2 - 1 that no engineer would act upon, of all channels as of one. Other codes for the same equations, and coloured
# noise, differ by as much.
NEGLIGIBLE = 0.5
HARDLY_MORE_THAN_NOISE = float(np.sqrt(1.0 + NEGLIGIBLE))
"""E below which no share of a gap is stated."""


@dataclass(frozen=True)
class Adequacy:
    """Residuals of a fit, compared with those of its replicates.

    Attributes:
        threshold: E up to which nothing counts as a gap: that the model leaves on its own replicates, exceeded at
            `ADEQUACY_LEVEL`, or a negligible E.
        channel_thresholds: The same for each channel.
        channels_above: Channels above theirs.
        channels_structured: Channels whose gap is not negligible and that hold more structure than replicates do.
        within_thresholds: Whether neither the whole nor a channel is above its threshold.
        negligible: Whether the whole gap is negligible.
        effect_visible: Whether an effect that was looked for shows in the residuals as in no replicate, however small
            the gap. Looked for only where nothing else shows.
    """

    threshold: float
    channel_thresholds: dict[str, float]
    channels_above: tuple[str, ...]
    channels_structured: tuple[str, ...]
    within_thresholds: bool
    negligible: bool
    effect_visible: bool

    @property
    def adequate(self) -> bool:
        """Whether the residuals are no larger than those of replicates, and have no other structure."""
        return self.within_thresholds and not self.channels_structured

    @property
    def complete(self) -> bool:
        """Whether there is nothing left to find.

        Where little decides between sticking and slipping, replicates differ much from each other. That excuses a gap,
        but does not show that it has no cause.
        """
        return self.adequate and self.negligible and not self.effect_visible


def adequacy_of_fit(
    problem: Problem,
    found: Fit,
    score: HeldOutScore,
    seed: int,
    effects: Sequence[Effect] = (),
    known: Sequence[Effect] = (),
) -> Adequacy:
    """Compare the residuals of a fit with those of its replicates.

    Args:
        problem: The problem of the fit.
        found: The fit.
        score: Its held-out score.
        seed: Seed of the replicates.
        effects: Effects to look for in the residuals (score test).
        known: Effects in the fit.
    """
    generator = np.random.default_rng([seed, 7])
    residuals = replicate_residuals(problem, found, generator)
    replicate_squares = [squared_residuals(problem, residual) for residual in residuals]
    least, negligible_gap = negligible_gaps(problem, found), _negligible_gap(problem, found)
    thresholds = _channel_thresholds(problem, replicate_squares, least)
    structured = _structured_channels(problem, found, residuals, score, least)
    above = tuple(name for name, value in score.by_channel.items() if value > thresholds[name])
    whole = np.array([np.mean(squares) for squares in replicate_squares])
    threshold = max(_upper_bound(whole, ADEQUACY_LEVEL), negligible_gap)
    within, negligible = score.gap <= threshold and not above, score.gap <= negligible_gap
    looked_for = bool(effects) and within and negligible and not structured
    visible = looked_for and _effect_is_visible(problem, found, residuals, effects, known)
    return Adequacy(threshold, thresholds, above, structured, within, negligible, visible)


def negligible_gaps(problem: Problem, found: Fit) -> dict[str, float]:
    """By channel, E that nobody would act upon: of noise, the model's own error, slow wander and the tolerance."""
    tolerated = {piece.name: piece.channel.tolerance / piece.noise for piece in problem.pieces}
    budget = wander_budget(problem, found)
    return {name: float(np.sqrt(1.0 + NEGLIGIBLE + share**2 + budget[name])) for name, share in tolerated.items()}


def _negligible_gap(problem: Problem, found: Fit) -> float:
    """The same of all channels, without their tolerances."""
    budget, samples = wander_budget(problem, found), sum(piece.channel.time.size for piece in problem.pieces)
    held = sum(budget[piece.name] * piece.channel.time.size for piece in problem.pieces) / samples
    return float(np.sqrt(1.0 + NEGLIGIBLE + held))


def _channel_thresholds(
    problem: Problem, replicate_squares: list[Array], least: Mapping[str, float]
) -> dict[str, float]:
    """By channel, E that a further replicate exceeds at the level shared among the channels, or a negligible E."""
    names = dict.fromkeys(piece.name for piece in problem.pieces)
    thresholds = {}
    for name in names:
        own = [piece for piece in problem.pieces if piece.name == name]
        draws = np.array([np.mean([np.mean(squares[piece.rows]) for piece in own]) for squares in replicate_squares])
        thresholds[name] = max(_upper_bound(draws, ADEQUACY_LEVEL / len(names)), least[name])
    return thresholds


def _structured_channels(
    problem: Problem, found: Fit, residuals: list[Array], score: HeldOutScore, negligible: Mapping[str, float]
) -> tuple[str, ...]:
    """Channels in which a discrepancy gains more than in replicates, and whose gap is not negligible."""
    draws = [problem.structure(residual) for residual in residuals]
    limits = {}
    for index in draws[0]:
        values = np.array([draw[index] for draw in draws]) + _TWO_PARAMETER_GAIN
        limits[index] = _upper_bound(values, ADEQUACY_LEVEL / len(draws[0])) ** 2 - _TWO_PARAMETER_GAIN
    structured = {
        problem.pieces[index].name for index, gain in problem.structure(found.residual).items() if gain > limits[index]
    }  # fmt: skip
    return tuple(sorted(name for name in structured if score.by_channel[name] > negligible[name]))


def _effect_is_visible(
    problem: Problem, found: Fit, residuals: list[Array], effects: Sequence[Effect], known: Sequence[Effect]
) -> bool:
    """Whether some effect's change correlates with the residual, more than with any replicate's (score test).

    Of each change only the part counts that the freed parameters cannot make.
    """
    points = [(effect, point) for effect in effects for point in effect.scan]
    needed = max((effect.fidelity for effect in known), default=0)
    changes = scan_changes(problem, found.values, found.simulated, points, needed)
    basis, _ = np.linalg.qr(_without_accumulating(problem, found.jacobian).T)
    rows = _without_accumulating(problem, changes)
    rows -= (rows @ basis) @ basis.T
    length = np.linalg.norm(rows, axis=1)
    rows = rows[length > 1e-6] / length[length > 1e-6, None]

    def largest_gain(residual: Array) -> float:
        white = _without_accumulating(problem, residual[None])[0]
        white -= basis @ (basis.T @ white)
        return float(np.max((rows @ white) ** 2, initial=0.0))

    draws = np.array([largest_gain(residual) for residual in residuals])
    limit = _upper_bound(draws + _TWO_PARAMETER_GAIN, ADEQUACY_LEVEL) ** 2 - _TWO_PARAMETER_GAIN
    return largest_gain(found.residual) > limit


def _without_accumulating(problem: Problem, rows: Array) -> Array:
    """Rows (M, N) with channels that accumulate set to 0: one missed step there looks like any effect."""
    kept = rows.copy()
    for piece in problem.pieces:
        kept[:, piece.rows] *= 0.0 if piece.channel.accumulates else problem.observer_factor(piece)
    return kept


def _upper_bound(squares: Array, level: float) -> float:
    """Root of what a further draw exceeds at the level: a prediction bound of the logarithms (Student's t)."""
    logs = np.log(squares)
    spread = float(np.std(logs, ddof=1)) * np.sqrt(1.0 + 1.0 / logs.size)
    return float(np.exp(0.5 * (np.mean(logs) + student.ppf(1.0 - level, logs.size - 1) * spread)))
