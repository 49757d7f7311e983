"""Whether what a model leaves is what it would leave if it were the truth.

What a cheaper simulation that was fitted leaves of a replicate is its error of discretisation, what cannot be
foretold, and noise; a gap beyond that is structure.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2
from scipy.stats import t as student

from slider_drilling.gap.evidence.replicates import replicate_residuals
from slider_drilling.gap.evidence.score import HeldOutScore, squared_residuals
from slider_drilling.gap.model import Array, Effect
from slider_drilling.gap.problem.problem import Problem
from slider_drilling.gap.search.least_squares import Fit
from slider_drilling.gap.search.screen import scan_changes

LEVEL = 0.01
# What two free numbers (size and memory) gain on white noise at that level: -2 log p.
_FREE = float(chi2.isf(LEVEL, 2))
# E^2 - 1 that no engineer would act upon, of the whole as of one channel: other codes for the same equations, and noise
# with a colour, differ by as much.
NEGLIGIBLE = 0.5


@dataclass(frozen=True)
class Adequacy:
    """threshold: E that the model would leave of its own replicates at the stated level, or that is negligible;
    by_channel: likewise; beyond: channels that are above theirs; structured: those that are not negligible and hold
    more structure (a discrepancy that pays) than replicates do; within: whether neither the whole nor a channel is
    above its threshold; small: whether the whole is negligible; hidden: where it is adequate, whether an effect that
    was looked for stands out in what is left as in no replicate, however small the gap.
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
        """Whether what is left is no more, and no other, than what replicates leave."""
        return self.within_thresholds and not self.channels_structured

    @property
    def complete(self) -> bool:
        """Whether there is nothing to look for. Replicates that go ways of their own, as where little decides between
        sticking and not, excuse a gap but do not say that it has no cause.
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
    """Compare what a fit leaves with what it leaves of its own replicates.

    effects: looked for in what is left (a score test); known: those in the fit.
    """
    generator = np.random.default_rng([seed, 7])
    residuals = replicate_residuals(problem, found, generator)
    left = [squared_residuals(problem, residual) for residual in residuals]
    limits = _structure_limits(problem, residuals)
    names = dict.fromkeys(piece.name for piece in problem.pieces)
    whole = np.array([np.mean(squares) for squares in left])
    channels, least = {}, float(np.sqrt(1.0 + NEGLIGIBLE))
    for name in names:
        own = [piece for piece in problem.pieces if piece.name == name]
        draws = np.array([np.mean([np.mean(squares[piece.rows]) for piece in own]) for squares in left])
        channels[name] = max(_upper(draws, LEVEL / len(names)), least)
    structured = {
        problem.pieces[i].name for i, pays in problem.structure(found.residual).items()
        if pays > limits[i] and score.by_channel[problem.pieces[i].name] > least
    }  # fmt: skip
    beyond = tuple(name for name, value in score.by_channel.items() if value > channels[name])
    threshold = max(_upper(whole, LEVEL), least)
    within, small = score.gap <= threshold and not beyond, score.gap <= least
    # Scanned for only where nothing else says that there is something.
    looked = bool(effects) and within and small and not structured
    hidden = looked and _stands_out(problem, found, residuals, effects, known)
    return Adequacy(threshold, channels, beyond, tuple(sorted(structured)), within, small, hidden)


def _stands_out(
    problem: Problem, found: Fit, residuals: list[Array], effects: Sequence[Effect], known: Sequence[Effect]
) -> bool:
    """Whether some effect's change, beyond what the freed parameters can do, lies along what the fit leaves."""
    points = [(effect, point) for effect in effects for point in effect.scan]
    shown = max((effect.fidelity for effect in known), default=0)
    changes = scan_changes(problem, found.values, found.simulated, points, shown)
    basis, _ = np.linalg.qr(_plain(problem, found.jacobian).T)
    rows = _plain(problem, changes)
    rows -= (rows @ basis) @ basis.T
    length = np.linalg.norm(rows, axis=1)
    rows = rows[length > 1e-6] / length[length > 1e-6, None]

    def most(residual: Array) -> float:
        white = _plain(problem, residual[None])[0]
        white -= basis @ (basis.T @ white)
        return float(np.max((rows @ white) ** 2, initial=0.0))

    draws = np.array([most(residual) for residual in residuals])
    return most(found.residual) > _upper(draws + _FREE, LEVEL) ** 2 - _FREE


def _plain(problem: Problem, rows: Array) -> Array:
    """Rows (M, N) without the channels that accumulate: one missed step there looks like any effect."""
    kept = rows.copy()
    for piece in problem.pieces:
        kept[:, piece.rows] *= 0.0 if piece.channel.accumulates else problem.observer_factor(piece)
    return kept


def _structure_limits(problem: Problem, residuals: list[Array]) -> dict[int, float]:
    """By piece, what a discrepancy may pay in replicates of the model at the level shared among the pieces."""
    draws = [problem.structure(residual) for residual in residuals]
    limits = {}
    for index in draws[0]:
        values = np.array([draw[index] for draw in draws]) + _FREE
        limits[index] = _upper(values, LEVEL / len(draws[0])) ** 2 - _FREE
    return limits


def _upper(squares: Array, level: float) -> float:
    """E that a further draw exceeds at the level, by the logarithms of the draws."""
    logs = np.log(squares)
    spread = float(np.std(logs, ddof=1)) * np.sqrt(1.0 + 1.0 / logs.size)
    return float(np.exp(0.5 * (np.mean(logs) + student.ppf(1.0 - level, logs.size - 1) * spread)))
