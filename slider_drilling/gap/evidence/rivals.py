"""Flexible rivals: at each site one disturbance with many coefficients and no law, to hold the named laws against.

Each is solved for once, linearised at a fit, without the stretch it is judged on; one of few coefficients that may go
far is fitted. Where one foretells more than the best named law, that law is at most a likeness of what is there, and
what is said is the disturbance's own shape.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from slider_drilling.gap.choice.state import Explained
from slider_drilling.gap.evidence.score import FOLDS, Folds, Score, held_out, score_of
from slider_drilling.gap.model import Array, Disturbance, Disturbed, Effect, Parameter, Values
from slider_drilling.gap.problem.problem import Piece, Problem
from slider_drilling.gap.search.at_once import at_once
from slider_drilling.gap.search.finish import finished
from slider_drilling.gap.search.least_squares import bounded_step, fit, pace, prior_weights, room

_KNOTS = 8
# Ridge on the coefficients, of a typical one: what the data do not ask for stays near zero.
_RIDGE = 0.3


@dataclass(frozen=True)
class Rival:
    """words: what it would be; like: names of the effects whose free form it is, None where it could be any of its
    site's; x, y: (m,) its shape, y in y_unit; score: held out."""

    site: str
    words: str
    like: tuple[str, ...] | None
    x: Array = field(repr=False)
    x_unit: str
    y: Array = field(repr=False)
    y_unit: str
    score: Score = field(repr=False)

    def frees(self, effect: Effect) -> bool:
        """Whether it is the free form of what the effect says in a law."""
        return effect.site == self.site if self.like is None else effect.name in self.like


@dataclass(frozen=True)
class _Columns:
    site: str
    words: str
    like: tuple[str, ...] | None
    x: Array
    x_unit: str
    y_unit: str
    rows: Array  # (m, N) change of the simulation per coefficient, noise units


def rivals(explained: Explained, folds: Folds, worth: float = 0.0) -> list[Rival]:
    """Every disturbance that the model and its channels offer, solved at a fit; the one that foretells most first.

    worth: gain of ``-2 log p`` from which one that is fitted is also finished.
    """
    model, values = explained.problem.model, explained.fit.values
    inside = model.disturbances(values) if isinstance(model, Disturbed) else ()
    asked: list[_Columns | Disturbance] = [*_readings(explained), *inside]

    def solved(one: _Columns | Disturbance) -> Rival:
        if isinstance(one, Disturbance):
            if one.parameters:
                return _fitted(explained, one, folds, worth)
            one = _columns(explained, one)
        return _solved(explained, one, folds)

    found = at_once(solved, asked)
    return sorted(found, key=lambda rival: float(np.sum(rival.score.density)))


def _readings(explained: Explained) -> list[_Columns]:
    """A reading that is off by a smooth function of time, of its own level, of the excitation, or of its rate."""
    problem, made = explained.problem, []
    model = problem.model
    for piece in problem.pieces:
        if piece.channel.time.size < 4 * _KNOTS:
            continue
        run = model.runs[piece.run]
        angle = np.interp(piece.channel.time, run.time, run.excitation)
        rate = np.interp(piece.channel.time, run.time, np.gradient(run.excitation, run.time))
        level = explained.fit.simulated[piece.rows] * piece.noise
        site = model.site_of(piece.name) if isinstance(model, Disturbed) else "sensor"
        for over, values, unit in (
            ("time", piece.channel.time, "s"), ("its own level", level, piece.channel.unit),
            ("the excitation", angle, "-"), ("the excitation's rate", rate, "1/s"),
        ):  # fmt: skip
            made.append(_reading(problem, piece, site, over, values, unit))
    return made


def _reading(problem: Problem, piece: Piece, site: str, over: str, values: Array, unit: str) -> _Columns:
    knots = np.linspace(float(values.min()), max(float(values.max()), float(values.min()) + 1e-9), _KNOTS)
    rows = np.zeros((_KNOTS, problem.size))
    for index in range(_KNOTS):
        rows[index, piece.rows] = np.interp(values, knots, np.eye(_KNOTS)[index])
    words = f"{piece.name} off by an amount that follows {over}"
    return _Columns(site, words, None, knots, unit, piece.channel.unit, rows)


def _columns(explained: Explained, one: Disturbance) -> _Columns:
    """What the model itself offers, each coefficient moved a little."""
    rows = (explained.problem.simulate(one.sets) - explained.fit.simulated) / np.array(one.steps)[:, None]
    return _Columns(one.site, one.words, one.like, np.array(one.x), one.x_unit, "-", rows)


def _fitted(explained: Explained, one: Disturbance, folds: Folds, worth: float) -> Rival:
    """A disturbance whose coefficients are fitted with the nuisance, and finished as a law is where it is worth it."""
    problem, known = explained.problem, explained.fit
    freed = [*known.parameters, *problem.free(one.parameters)]
    found = fit(
        problem, freed, known.values, tolerance=pace(worth), simulated=known.simulated, known=known.rows
    )  # fmt: skip
    if known.cost - found.cost > worth:
        problem, found = finished(problem, found)
    shape = np.array([found.values[parameter.name] - parameter.nominal for parameter in one.parameters])
    x = np.array(one.x)
    if one.period is not None:
        # What is the same all around is no matter of where: the nuisance has it.
        x, shape = np.append(x, x[0] + one.period), np.append(shape, shape[0]) - float(np.mean(shape))
    score = held_out(problem, found, folds)
    return Rival(one.site, one.words, one.like, x, one.x_unit, shape, "-", score)


def _solved(explained: Explained, columns: _Columns, folds: Folds) -> Rival:
    problem, fit = explained.problem, explained.fit
    own = [index for index, parameter in enumerate(fit.parameters) if not parameter.per_run]
    rows = np.vstack([fit.jacobian[own], columns.rows])
    white, through = problem.whitened(fit.residual, rows, fit.discrepancy)
    nuisance = [fit.parameters[index] for index in own]
    residual = np.empty(problem.size)
    for fold in range(FOLDS):
        kept = folds.of != fold
        step = _ridge(through[:, kept], white[kept], nuisance, fit.values)
        residual[~kept] = (fit.residual - step @ rows)[~kept]
    shape = _ridge(through, white, nuisance, fit.values)[len(own) :]
    _, found = problem.cost(residual)
    scale = _noise_of(problem, columns)
    score = score_of(problem, residual, replace(fit, discrepancy=found))
    return Rival(
        columns.site, columns.words, columns.like, columns.x, columns.x_unit, scale * shape, columns.y_unit, score
    )  # fmt: skip


def _ridge(rows: Array, target: Array, nuisance: Sequence[Parameter], values: Values) -> Array:
    """(p + knots,) step of the nuisance in scales, within its bounds, and the coefficients of the disturbance.

    A nuisance that were free to pass its bounds would explain by itself what an effect has to, beside any disturbance.
    """
    own, power = len(nuisance), np.sum(rows**2, axis=1)
    flexible = power[own:]
    used = flexible > 1e-9 * max(float(flexible.max(initial=0.0)), 1e-12)
    rows = rows[np.concatenate([np.ones(own, dtype=bool), used])]
    ridge = _RIDGE**2 * float(np.median(flexible[used])) / 100.0 if used.any() else 0.0
    extra = np.concatenate([prior_weights(nuisance) ** 2, np.full(len(rows) - own, ridge)])
    low, high = room(nuisance, values)
    free = np.full(len(rows) - own, np.inf)
    low, high = np.append(low, -free), np.append(high, free)
    normal = rows @ rows.T + np.diag(extra + 1e-9 * max(float(power.max(initial=0.0)), 1e-12))
    solved = np.linalg.solve(normal, rows @ target)
    if np.any(solved < low) or np.any(solved > high):
        solved = bounded_step(normal, rows @ target, 0.0, low, high)
    step = np.zeros(own + used.size)
    step[:own], step[own:][used] = solved[:own], solved[own:]
    return step


def _noise_of(problem: Problem, columns: _Columns) -> float:
    """A reading's coefficients are in noise units; the model's own are in theirs."""
    if columns.y_unit == "-":
        return 1.0
    touched = [piece for piece in problem.pieces if np.any(columns.rows[:, piece.rows])]
    return touched[0].noise if touched else 1.0
