"""Flexible rivals: at each site one disturbance with many coefficients and no law, to hold the named laws against.

Each is solved for once, linearised at a fit, without the stretch it is judged on; one of few coefficients that may go
far is fitted. Where one foretells more than the best named law, that law is at most a likeness of what is there, and
what is said is the disturbance's own shape.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from slider_drilling.gap.evidence.score import FOLDS, Folds, HeldOutScore, score_held_out, score_residual
from slider_drilling.gap.model import Array, Effect, FreeForm, HasFreeForms, Parameter, Values
from slider_drilling.gap.problem.problem import Piece, Problem
from slider_drilling.gap.search.fine_fit import refit_in_fine_simulation, refit_with_correction
from slider_drilling.gap.search.least_squares import (
    Fit,
    bounded_step,
    distance_to_bounds,
    fit,
    min_gain_to_catch_up,
    penalized_cost,
    prior_weights,
    scaled_offsets,
)
from slider_drilling.gap.selection.state import FittedModel
from slider_drilling.process.parallel_map import parallel_map

_KNOTS = 8
# Weights on the bends of a curve that are tried, of a typical coefficient's own in the log: from free to straight.
_WEIGHTS = 10.0 ** np.arange(-4.0, 5.0)
# Shares of the way to a bound at which a disturbance that may go far is looked for.
_PLACES = np.array([1.0 / 32.0, 0.125, 0.25, 0.5, 0.75])
# What a reading is off by at the beginning and at the end of a run, in noise units; where no bound is met.
_DRIFTED, _NOWHERE = ("drift.begin", "drift.end"), 1e6


@dataclass(frozen=True)
class FreeFormFit:
    """words: what it would be; like: names of the effects whose free form it is, None where it could be any of its
    site's; x, y: (m,) its shape, y in y_unit; score: held out; reading: the channel whose reading alone would be off,
    None where it is the model.
    """

    site: str
    description: str
    free_form_of: tuple[str, ...] | None
    x: Array = field(repr=False)
    x_unit: str
    y: Array = field(repr=False)
    y_unit: str
    score: HeldOutScore = field(repr=False)
    sensor_channel: str | None = None

    def covers(self, effect: Effect) -> bool:
        """Whether it is the free form of what the effect says in a law."""
        return effect.site == self.site if self.free_form_of is None else effect.name in self.free_form_of


@dataclass(frozen=True)
class _Drift:
    """A reading that is off by an amount which grows evenly: what it is at the ends of its run is fitted."""

    site: str
    words: str
    piece: Piece

    @property
    def shares(self) -> Array:
        """(2, n) of what it is off by at the beginning and at the end."""
        time = self.piece.channel.time
        passed = (time - time[0]) / max(float(time[-1] - time[0]), 1e-9)
        return np.stack([1.0 - passed, passed])


@dataclass(frozen=True)
class _Columns:
    site: str
    words: str
    like: tuple[str, ...] | None
    x: Array
    x_unit: str
    y_unit: str
    rows: Array  # (m, N) change of the simulation per coefficient, noise units
    reading: str | None = None
    least: float = -np.inf


def fit_free_forms(explained: FittedModel, folds: Folds, worth: float = 0.0) -> list[FreeFormFit]:
    """Every disturbance that the model and its channels offer, solved at a fit; the one that foretells most first.

    worth: gain of ``-2 log p`` from which one that is fitted is also finished.
    """
    asked: list[_Columns | _Drift | FreeForm] = [*_readings(explained), *_drifts(explained), *_inside(explained)]
    return _all_solved(explained, asked, folds, worth)


def fit_free_forms_of_known(explained: FittedModel, folds: Folds) -> list[FreeFormFit]:
    """The free forms of the laws that a model has already, solved at its fit; the one that foretells most first."""
    names = set(explained.names)
    return _all_solved(explained, [one for one in _inside(explained) if names & set(one.free_form_of)], folds, 0.0)


def _inside(explained: FittedModel) -> Sequence[FreeForm]:
    model = explained.problem.model
    return model.free_forms(explained.fit.values) if isinstance(model, HasFreeForms) else ()


def _all_solved(
    explained: FittedModel, asked: Sequence[_Columns | _Drift | FreeForm], folds: Folds, worth: float
) -> list[FreeFormFit]:

    def solved(one: _Columns | _Drift | FreeForm) -> FreeFormFit:
        if isinstance(one, _Drift):
            return _drifting(explained, one, folds, worth)
        if isinstance(one, FreeForm):
            if one.parameters:
                return _fitted(explained, one, folds, worth)
            one = _columns(explained, one)
        return _solved(explained, one, folds)

    # One that stays at nothing is the nuisance, fitted once more.
    found = [rival for rival in parallel_map(solved, asked) if np.any(rival.y)]
    return sorted(found, key=lambda rival: rival.score.held_out_deviance)


def _readings(explained: FittedModel) -> list[_Columns]:
    """A reading that is off by a smooth function of time, of its own level, of the excitation, or of its rate."""
    problem, made = explained.problem, []
    for piece in _read_often(problem):
        run = problem.model.runs[piece.run]
        command = np.interp(piece.channel.time, run.time, run.excitation)
        rate = np.interp(piece.channel.time, run.time, np.gradient(run.excitation, run.time))
        per_second = "1/s" if run.command_unit == "-" else f"{run.command_unit}/s"
        level = explained.fit.simulated[piece.rows] * piece.noise
        site = _site_of(problem, piece)
        for over, values, unit in (
            ("time", piece.channel.time, "s"), ("its own level", level, piece.channel.unit),
            (run.command, command, run.command_unit), (f"the rate of {run.command}", rate, per_second),
        ):  # fmt: skip
            made.append(_reading(problem, piece, site, over, values, unit))
    return made


def _drifts(explained: FittedModel) -> list[_Drift]:
    """A drift pulls at what is tuned, and bends it: it is fitted beside that, not solved for around where that went."""
    problem = explained.problem
    return [
        _Drift(_site_of(problem, piece), f"{_named(problem, piece)} off by an amount that drifts with time", piece)
        for piece in _read_often(problem)
    ]


def _read_often(problem: Problem) -> list[Piece]:
    return [piece for piece in problem.pieces if piece.channel.time.size >= 4 * _KNOTS]


def _site_of(problem: Problem, piece: Piece) -> str:
    model = problem.model
    return model.sensor_site(piece.name) if isinstance(model, HasFreeForms) else "sensor"


def _named(problem: Problem, piece: Piece) -> str:
    of_run = f" in run {piece.run + 1}" if len(problem.model.runs) > 1 else ""
    return f"{piece.name.replace('_', ' ')}{of_run}"


def _reading(problem: Problem, piece: Piece, site: str, over: str, values: Array, unit: str) -> _Columns:
    knots = np.linspace(float(values.min()), max(float(values.max()), float(values.min()) + 1e-9), _KNOTS)
    rows = np.zeros((_KNOTS, problem.size))
    for index in range(_KNOTS):
        rows[index, piece.rows] = np.interp(values, knots, np.eye(_KNOTS)[index])
    words = f"{_named(problem, piece)} off by an amount that follows {over}"
    return _Columns(site, words, None, knots, unit, piece.channel.unit, rows, piece.name)


def _columns(explained: FittedModel, one: FreeForm) -> _Columns:
    """What the model itself offers, each coefficient moved a little; where these are not what is off at each x, by what
    is off there.
    """
    rows = (explained.problem.simulate(one.parameter_sets) - explained.fit.simulated) / np.array(one.steps)[:, None]
    if one.basis:
        rows = np.linalg.solve(np.array(one.basis).T, rows)
    return _Columns(
        one.site,
        one.description,
        one.free_form_of,
        np.array(one.x),
        one.x_unit,
        one.y_unit,
        rows,
        least=one.lower_bound,
    )


def _fitted(explained: FittedModel, one: FreeForm, folds: Folds, worth: float) -> FreeFormFit:
    """A disturbance whose coefficients are fitted with the nuisance, and finished as a law is where it is worth it."""
    start = _likeliest_start(explained, one.parameters[0]) if len(one.parameters) == 1 else None
    found, score = _beside(
        explained, explained.problem, one.parameters, explained.fit.jacobian_rows, folds, worth, start
    )
    shape = np.array([found.values[parameter.name] - parameter.nominal for parameter in one.parameters])
    x = np.array(one.x)
    if one.period is not None:
        # What is the same all around is no matter of where: the nuisance has it.
        x, shape = np.append(x, x[0] + one.period), np.append(shape, shape[0]) - float(np.mean(shape))
    return FreeFormFit(one.site, one.description, one.free_form_of, x, one.x_unit, shape, one.y_unit, score)


def _likeliest_start(explained: FittedModel, far: Parameter) -> tuple[dict[str, float], Array] | None:
    """Where the log is likeliest of places all over one parameter's range, beside what is tuned and beside what is
    nominal, and its simulation (N,), None where it is so at the parameter's own nominal value: who begins there, beside
    a nuisance that others have bent, may never see the place.
    """
    known, tuned = explained.fit, explained.fit.values
    own = {parameter.name for parameter in known.parameters if not parameter.per_run}
    given = {name: value for name, value in tuned.items() if name not in own}
    shares = np.concatenate([_PLACES * (bound - far.nominal) for bound in (far.lower, far.upper)])
    places = [{**base, far.name: float(far.nominal + share)} for base in (tuned, given) for share in shares]
    begun = zip(places, explained.problem.simulate(places), strict=True)
    costs = [(penalized_cost(explained.problem, known.parameters, *one), one) for one in begun]
    least, best = min(costs, key=lambda entry: entry[0])
    return best if least < known.cost else None


def _drifting(explained: FittedModel, one: _Drift, folds: Folds, worth: float) -> FreeFormFit:
    rows = np.zeros((2, explained.problem.size))
    rows[:, one.piece.rows] = one.shares
    added = dict(zip(_DRIFTED, rows, strict=True))
    free = tuple(Parameter(name, 0.0, -_NOWHERE, _NOWHERE, 1.0) for name in _DRIFTED)
    found, score = _beside(
        explained, explained.problem.with_added_rows(added), free, explained.fit.jacobian_rows | added, folds, worth
    )
    shape = one.piece.noise * np.array([found.values[name] for name in _DRIFTED])
    x = one.piece.channel.time[[0, -1]]
    unit = one.piece.channel.unit
    return FreeFormFit(one.site, one.words, None, x, "s", shape, unit, score, one.piece.name)


def _beside(
    explained: FittedModel, problem: Problem, parameters: Sequence[Parameter], first: Mapping[str, Array],
    folds: Folds, worth: float, start: tuple[Values, Array] | None = None,
) -> tuple[Fit, HeldOutScore]:  # fmt: skip
    """Fitted beside the nuisance, and held out: finished and refitted without each stretch where it gains more than it
    is worth finishing for, else solved for without it. first: (N,) rows of the first Jacobian; start: values and
    simulation (N,) where else than at the explanation's fit.
    """
    known = explained.fit
    freed, least = [*known.parameters, *problem.expand_per_run(parameters)], min_gain_to_catch_up(worth)
    values, simulated = start or (known.values, known.simulated)
    found = fit(problem, freed, values, tolerance=least, simulated=simulated, jacobian_rows={} if start else first)
    if known.cost - found.cost > worth:
        exact, ended = refit_in_fine_simulation(*refit_with_correction(problem, found))
        return ended, score_held_out(exact, ended, folds)
    own = [index for index, parameter in enumerate(found.parameters) if not parameter.per_run]
    rows, of_rig = found.jacobian[own], [found.parameters[index] for index in own]
    white, through = problem.whitened(found.residual, rows, found.discrepancy)
    # What a step of the whole log would still promise has not been simulated, and is not counted.
    there = found.residual + _bent_least(through, white, of_rig, found.values) @ rows
    residual = _left_out(there, rows, white, through, of_rig, found.values, folds)
    return found, score_residual(problem, residual, found)


def _solved(explained: FittedModel, columns: _Columns, folds: Folds) -> FreeFormFit:
    problem, fit = explained.problem, explained.fit
    own = [index for index, parameter in enumerate(fit.parameters) if not parameter.per_run]
    power = np.sum(columns.rows**2, axis=1)
    used = power > 1e-9 * max(float(power.max(initial=0.0)), 1e-12)
    rows = np.vstack([fit.jacobian[own], columns.rows[used]])
    nuisance = [fit.parameters[index] for index in own]
    white, through = problem.whitened(fit.residual, rows, fit.discrepancy)
    # As a fit does: what the disturbance explains is no discrepancy any more, and counts for more then.
    left = fit.residual - _bent_least(through, white, nuisance, fit.values, columns.least) @ rows
    white, through = problem.whitened(fit.residual, rows, problem.cost(left)[1])
    residual = _left_out(fit.residual, rows, white, through, nuisance, fit.values, folds, columns.least)
    shape = np.zeros(used.size)
    shape[used] = _bent_least(through, white, nuisance, fit.values, columns.least)[len(own) :]
    _, found = problem.cost(residual)
    scale = _noise_of(problem, columns)
    score = score_residual(problem, residual, replace(fit, discrepancy=found))
    return FreeFormFit(
        columns.site, columns.words, columns.like, columns.x, columns.x_unit, scale * shape, columns.y_unit, score,
        columns.reading,
    )  # fmt: skip


def _left_out(
    left: Array, rows: Array, white: Array, through: Array, nuisance: Sequence[Parameter], values: Values, folds: Folds,
    least: float = -np.inf,
) -> Array:  # fmt: skip
    """(N,) what is left of each stretch by a step that was solved for without it; left (N,), rows (p, N): residual and
    changes; white, through: the same, whitened; least: of the disturbance's coefficients.
    """
    residual = np.empty(left.size)
    for fold in range(FOLDS):
        kept = folds.fold != fold
        step = _bent_least(through[:, kept], white[kept], nuisance, values, least)
        residual[~kept] = (left - step @ rows)[~kept]
    return residual


def _bent_least(
    rows: Array, target: Array, nuisance: Sequence[Parameter], values: Values, least: float = -np.inf
) -> Array:
    """(p + knots,) step of the nuisance in scales, within its bounds, and the coefficients of the disturbance, none
    below the least that it can be: a line as straight as the data say, so that a stretch left out at an end is
    foretold.

    How straight is the weight on its bends under which the data are likeliest (empirical Bayes; MacKay, Neural
    Computation 4, 1992). A nuisance that were free to pass its bounds would explain by itself what an effect has to,
    beside any disturbance.
    """
    own, knots = len(nuisance), len(rows) - len(nuisance)
    power = np.sum(rows**2, axis=1)
    normal, gradient = rows @ rows.T, rows @ target
    prior = prior_weights(nuisance) ** 2
    normal[np.diag_indices(own)] += prior
    gradient[:own] -= prior * scaled_offsets(nuisance, values)
    normal[np.diag_indices(len(rows))] += 1e-9 * max(float(power.max(initial=0.0)), 1e-12)
    if knots > 2:
        bends = np.zeros_like(normal)
        bend = np.diff(np.eye(knots), n=2, axis=0)
        bends[own:, own:] = float(np.median(power[own:])) * (bend.T @ bend)

        def unlikely(weight: float) -> float:
            bent = normal + weight * bends
            _, size = np.linalg.slogdet(bent)
            return float(size - (knots - 2) * np.log(weight) - gradient @ np.linalg.solve(bent, gradient))

        normal = normal + min(_WEIGHTS, key=unlikely) * bends
    low, high = distance_to_bounds(nuisance, values)
    low, high = np.append(low, np.full(knots, least)), np.append(high, np.full(knots, np.inf))
    step = np.linalg.solve(normal, gradient)
    if np.any(step < low) or np.any(step > high):
        step = np.clip(bounded_step(normal, gradient, 0.0, low, high), low, high)
    return np.asarray(step, dtype=np.float64)


def _noise_of(problem: Problem, columns: _Columns) -> float:
    """A reading's coefficients are in noise units; the model's own are in theirs."""
    if columns.reading is None:
        return 1.0
    touched = [piece for piece in problem.pieces if np.any(columns.rows[:, piece.rows])]
    return touched[0].noise if touched else 1.0
