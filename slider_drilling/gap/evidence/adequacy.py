"""Whether what a model leaves is what it would leave if it were the truth.

Replicates are made with the model itself: parameters as well as the log tells them, its finest simulation, and the
channels' noise. What the cheaper simulation that was fitted leaves of such a replicate is its error of discretisation,
what cannot be foretold, and noise; a gap beyond that is structure.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import cast

import numpy as np
from scipy.stats import t as student

from slider_drilling.gap.evidence.score import Score, squares_of
from slider_drilling.gap.model import Array, Effect, Graded, How, Model, Pulled
from slider_drilling.gap.problem.problem import Problem
from slider_drilling.gap.search.least_squares import Fit

REPLICATES = 8
LEVEL = 0.01
# Relative standard deviation of a floor that comes from differences of few samples.
_FLOOR_SPREAD = 2.0
# What two free numbers (size and memory) gain on white noise hardly ever: -2 log p.
_FREE = 20.0
# E^2 - 1 that no engineer would act upon, of the whole and of one channel: other codes for the same equations,
# and noise with a colour, differ by as much.
NEGLIGIBLE, NEGLIGIBLE_ALONE = 0.4, 0.5


@dataclass(frozen=True)
class Adequacy:
    """threshold: E that the model would leave of its own replicates at the stated level, or that is negligible;
    by_channel: likewise; beyond: channels that are above theirs; structured: those that are not negligible and hold
    more structure (a discrepancy that pays) than replicates do; within: whether neither the whole nor a channel is
    above its threshold; hidden: whether an effect that was looked for stands out in what is left as in no replicate,
    however small the gap.
    """

    threshold: float
    by_channel: dict[str, float]
    beyond: tuple[str, ...]
    structured: tuple[str, ...]
    within: bool
    hidden: bool

    @property
    def adequate(self) -> bool:
        """Whether what is left is no more, and no other, than what replicates leave."""
        return self.within and not self.structured

    @property
    def done(self) -> bool:
        """Whether there is nothing to look for."""
        return self.adequate and not self.hidden


def adequacy(problem: Problem, found: Fit, score: Score, seed: int, effects: Sequence[Effect] = ()) -> Adequacy:
    """Compare what a fit leaves with what it leaves of its own replicates.

    effects: looked for in what is left (a score test).
    """
    generator = np.random.default_rng([seed, 7])
    residuals = _replicates(problem, found, generator)
    left = [squares_of(problem, residual) for residual in residuals]
    limits = _structure_limits(problem, residuals)
    names = dict.fromkeys(piece.name for piece in problem.pieces)
    whole = np.array([np.mean([np.mean(squares[piece.rows]) for piece in problem.pieces]) for squares in left])
    channels, least = {}, float(np.sqrt(1.0 + NEGLIGIBLE_ALONE))
    for name in names:
        own = [piece for piece in problem.pieces if piece.name == name]
        draws = np.array([np.mean([np.mean(squares[piece.rows]) for piece in own]) for squares in left])
        channels[name] = max(_upper(draws, LEVEL / len(names)), least)
    structured = {
        problem.pieces[i].name for i, pays in problem.structure(found.residual).items()
        if pays > limits[i] and score.by_channel[problem.pieces[i].name] > least
    }  # fmt: skip
    beyond = tuple(name for name, value in score.by_channel.items() if value > channels[name])
    threshold = max(_upper(whole, LEVEL), float(np.sqrt(1.0 + NEGLIGIBLE)))
    hidden = bool(effects) and _stands_out(problem, found, residuals, effects)
    within = score.gap <= threshold and not beyond
    return Adequacy(threshold, channels, beyond, tuple(sorted(structured)), within, hidden)


def _stands_out(problem: Problem, found: Fit, residuals: list[Array], effects: Sequence[Effect]) -> bool:
    """Whether some effect's change, beyond what the freed parameters can do, lies along what the fit leaves."""
    points = [effect.values(point) for effect in effects for point in effect.scan]
    changes = problem.simulate([found.values | values for values in points]) - found.simulated
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
        kept[:, piece.rows] *= 0.0 if piece.channel.accumulates else problem.gain(piece)
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


def _replicates(problem: Problem, found: Fit, generator: np.random.Generator) -> list[Array]:
    """Residuals (N,) that the problem leaves of replicates of its own fit."""
    finest = problem.model.finest if isinstance(problem.model, Graded) else 0
    sets = _nearby(problem, found, generator)
    truths = problem.simulate(sets, How(finest, 0.0))
    samples = [truth + _noise(problem, generator) for truth in truths]
    if problem.how.pull == 0.0 or not isinstance(problem.model, Pulled):
        return [_wrapped(problem, sample - found.simulated) for sample in samples]
    left = []
    for sample in samples:
        fed: Pulled = problem.model
        for piece in problem.pieces:
            if piece.name == fed.pulled:
                fed = fed.fed(piece.run, sample[piece.rows] * piece.noise)
        own = replace(problem, model=cast(Model, fed), correction=np.zeros(problem.size))
        left.append(_wrapped(problem, sample - own.simulate([found.values], replace(problem.how, fidelity=finest))[0]))
    return left


def _nearby(problem: Problem, found: Fit, generator: np.random.Generator) -> list[dict[str, float]]:
    """Parameter sets as likely as the fit's, by its curvature."""
    if not found.parameters:
        return [found.values] * REPLICATES
    _, rows = problem.whitened(found.residual, found.jacobian, found.discrepancy)
    normal = rows @ rows.T
    normal[np.diag_indices_from(normal)] += 1.0
    factor = np.linalg.cholesky(normal)
    sets = []
    for _ in range(REPLICATES):
        step = np.linalg.solve(factor.T, generator.normal(size=len(found.parameters)))
        moved = {
            p.name: float(np.clip(found.values[p.name] + p.scale * change, p.lower, p.upper))
            for p, change in zip(found.parameters, step, strict=True)
        }
        sets.append(found.values | moved)
    return sets


def _noise(problem: Problem, generator: np.random.Generator) -> Array:
    noise = np.empty(problem.size)
    for piece in problem.pieces:
        count = piece.channel.time.size
        off = 1.0 + generator.normal() * _FLOOR_SPREAD / np.sqrt(count)
        noise[piece.rows] = off * generator.normal(size=count)
    return noise


def _wrapped(problem: Problem, residual: Array) -> Array:
    for piece in problem.pieces:
        if piece.channel.period is not None:
            turn = piece.channel.period / piece.noise
            part = residual[piece.rows]
            residual[piece.rows] = part - turn * np.round(part / turn)
    return residual
