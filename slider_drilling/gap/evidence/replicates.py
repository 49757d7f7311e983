"""Logs as a fitted model would have given them if it were the truth, and what the fit leaves of them.

Replicates are made with the model itself: parameters as well as noise alone would tell them, its finest simulation, and
the channels' noise.
"""

from __future__ import annotations

from dataclasses import replace
from typing import cast

import numpy as np
from scipy.optimize import brentq

from slider_drilling.gap.evidence.score import squares_of
from slider_drilling.gap.model import Array, Graded, How, Model, Pulled
from slider_drilling.gap.problem.missed_steps import missed_steps
from slider_drilling.gap.problem.noise import DIFFERENCE_SPREAD
from slider_drilling.gap.problem.problem import STEP_SIZE, Problem
from slider_drilling.gap.search.at_once import at_once
from slider_drilling.gap.search.least_squares import Fit

_NUMBER = 8
_WIDEST = 1e3


def unforeseen(problem: Problem, found: Fit, seed: int) -> dict[int, float]:
    """By piece that accumulates, the factor (1 or more) on its noise under which replicates of a fit leave just that.

    What such a channel has missed once it keeps: where parameters hardly told from each other lead it elsewhere, its
    sensor's noise is no measure of what the truth would leave of it.
    """
    draws = replicates(problem, found, np.random.default_rng([seed, 11]))
    return {
        index: _factor([problem.unwrapped(piece, residual[piece.rows]) for residual in draws])
        for index, piece in enumerate(problem.pieces)
        if piece.channel.accumulates
    }


def _factor(parts: list[Array]) -> float:
    def left(logarithm: float) -> float:
        losses = [missed_steps(part / np.exp(logarithm), STEP_SIZE)[0] for part in parts]
        return float(np.mean(losses)) - 1.0

    return float(np.exp(brentq(left, 0.0, np.log(_WIDEST), xtol=1e-2))) if left(0.0) > 0.0 else 1.0


def replicates(problem: Problem, found: Fit, generator: np.random.Generator) -> list[Array]:
    """Residuals (N,) that the problem leaves of replicates of its own fit."""
    finest = problem.model.finest if isinstance(problem.model, Graded) else 0
    sets = _nearby(problem, found, generator)
    truths = problem.simulate(sets, How(finest, 0.0))
    samples = [truth + _noise(problem, generator) for truth in truths]
    if problem.how.pull == 0.0 or not isinstance(problem.model, Pulled):
        fits = np.vstack([found.simulated[None], problem.simulate(sets)])
        return [_least(problem, sample, np.delete(fits, index + 1, axis=0)) for index, sample in enumerate(samples)]
    model, how = problem.model, replace(problem.how, fidelity=finest)

    def left(sample: Array) -> Array:
        fed: Pulled = model
        for piece in problem.pieces:
            if piece.name == fed.pulled:
                fed = fed.fed(piece.run, sample[piece.rows] * piece.noise)
        own = replace(problem, model=cast(Model, fed), correction=np.zeros(problem.size))
        return _wrapped(problem, sample - own.simulate([found.values], how)[0])

    return at_once(left, samples)


def _least(problem: Problem, sample: Array, fits: Array) -> Array:
    """What the best of fits (M, N) leaves of a replicate (N,): tuned to it, the model would find which way it went
    where next to nothing decides, as between sticking and not.
    """
    left = [_wrapped(problem, sample - fit) for fit in fits]
    return min(left, key=lambda residual: float(np.mean(squares_of(problem, residual))))


def _nearby(problem: Problem, found: Fit, generator: np.random.Generator) -> list[dict[str, float]]:
    """Parameter sets as likely as the fit's were it the truth: by its curvature beside noise alone, since a discrepancy
    that it leaves now would not be there.
    """
    if not found.parameters:
        return [found.values] * _NUMBER
    none = {index: replace(one, size=0.0) for index, one in found.discrepancy.items()}
    _, rows = problem.whitened(found.residual, found.jacobian, none)
    normal = rows @ rows.T
    normal[np.diag_indices_from(normal)] += 1.0
    factor = np.linalg.cholesky(normal)
    sets = []
    for _ in range(_NUMBER):
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
        off = 1.0 + generator.normal() * DIFFERENCE_SPREAD / np.sqrt(count)
        noise[piece.rows] = off * generator.normal(size=count)
    return noise


def _wrapped(problem: Problem, residual: Array) -> Array:
    for piece in problem.pieces:
        if piece.channel.period is not None:
            turn = piece.channel.period / piece.noise
            part = residual[piece.rows]
            residual[piece.rows] = part - turn * np.round(part / turn)
    return residual
