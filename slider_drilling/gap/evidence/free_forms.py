"""Free-form alternatives: at each site a flexible curve without a law, to compare the named effects with.

A curve is solved for once, linearised at a fit, and scored on stretches that it has not seen. One with few coefficients
that may go far is fitted. If a free form predicts held-out data better than the best effect, its shape is reported
instead of the effect.
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
from slider_drilling.plain_names import plain_name
from slider_drilling.process.parallel_map import parallel_map

# Coefficients of a curve over a sensor's reading.
_KNOTS = 8
# Weights on the curvature of a curve that are tried, in units of a typical coefficient's weight in the log: from free
# to straight.
_SMOOTHING = 10.0 ** np.arange(-4.0, 5.0)
# Starts of a coefficient that may go far, as shares of the way to its bounds.
_START_SHARES = np.array([1.0 / 32.0, 0.125, 0.25, 0.5, 0.75])
# Parameters of a sensor's drift: its error at the beginning and end of a run, noise units; and a bound never met.
_DRIFT_PARAMETERS, _NO_BOUND = ("drift.begin", "drift.end"), 1e6


@dataclass(frozen=True)
class FreeFormFit:
    """A free form, fitted and cross-validated.

    Attributes:
        site: Where it acts.
        description: What it would be, in words.
        free_form_of: Names of the effects of which it is the free form; None for any effect of its site.
        x: (m,) positions, in ``x_unit``.
        x_unit: Unit of ``x``.
        y: (m,) its shape, in ``y_unit``.
        y_unit: Unit of ``y``.
        score: Its held-out score.
        sensor_channel: The channel whose reading alone would be off; None if it acts in the model.
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
        """Whether it is the free form of the effect."""
        return effect.site == self.site if self.free_form_of is None else effect.name in self.free_form_of


@dataclass(frozen=True)
class _Drift:
    """An error of a sensor's reading that grows evenly over a run; its values at both ends are fitted."""

    site: str
    description: str
    piece: Piece

    @property
    def rows(self) -> Array:
        """(2, n) change of the reading by its value at the beginning and at the end."""
        time = self.piece.channel.time
        passed = (time - time[0]) / max(float(time[-1] - time[0]), 1e-9)
        return np.stack([1.0 - passed, passed])


@dataclass(frozen=True)
class _LinearForm:
    """A curve that is solved for; ``rows``: (m, N) change of the simulation per coefficient, noise units."""

    site: str
    description: str
    free_form_of: tuple[str, ...] | None
    x: Array
    x_unit: str
    y_unit: str
    rows: Array
    sensor_channel: str | None = None
    lower_bound: float = -np.inf


_AnyForm = _LinearForm | _Drift | FreeForm


def fit_free_forms(model: FittedModel, folds: Folds, gain_worth_finishing: float = 0.0) -> list[FreeFormFit]:
    """Every free form that the model and its sensors offer, best held-out prediction first.

    Args:
        model: The model whose residuals they explain.
        folds: Folds to score them by.
        gain_worth_finishing: Gain of ``-2 log p`` from which a form that is fitted is finished in fine simulations.
    """
    forms: list[_AnyForm] = [*_sensor_curves(model), *_sensor_drifts(model), *_model_forms(model)]
    return _fit_all(model, forms, folds, gain_worth_finishing)


def fit_free_forms_of_known(model: FittedModel, folds: Folds) -> list[FreeFormFit]:
    """The free forms of the effects in the model, best held-out prediction first."""
    names = set(model.names)
    return _fit_all(model, [form for form in _model_forms(model) if names & set(form.free_form_of)], folds, 0.0)


def _model_forms(model: FittedModel) -> Sequence[FreeForm]:
    simulated = model.problem.model
    return simulated.free_forms(model.fit.values) if isinstance(simulated, HasFreeForms) else ()


def _fit_all(
    model: FittedModel, forms: Sequence[_AnyForm], folds: Folds, gain_worth_finishing: float
) -> list[FreeFormFit]:
    def fitted(form: _AnyForm) -> FreeFormFit:
        if isinstance(form, _Drift):
            return _fit_drift(model, form, folds, gain_worth_finishing)
        if isinstance(form, FreeForm) and form.parameters:
            return _fit_coefficients(model, form, folds, gain_worth_finishing)
        return _solve(model, _linearised(model, form) if isinstance(form, FreeForm) else form, folds)

    # A form that stays at 0 would only be the nuisance, fitted once more.
    fits = [found for found in parallel_map(fitted, forms) if np.any(found.y)]
    return sorted(fits, key=lambda found: found.score.held_out_deviance)


def _sensor_curves(model: FittedModel) -> list[_LinearForm]:
    """Readings that are off by a smooth function of time, of their level, of the excitation, or of its rate."""
    problem, forms = model.problem, []
    for piece in _often_sampled(problem):
        run = problem.model.runs[piece.run]
        command = np.interp(piece.channel.time, run.time, run.excitation)
        rate = np.interp(piece.channel.time, run.time, np.gradient(run.excitation, run.time))
        per_second = "1/s" if run.command_unit == "-" else f"{run.command_unit}/s"
        level = model.fit.simulated[piece.rows] * piece.noise
        site = _sensor_site(problem, piece)
        for over, values, unit in (
            ("time", piece.channel.time, "s"), ("its own level", level, piece.channel.unit),
            (run.command, command, run.command_unit), (f"the rate of {run.command}", rate, per_second),
        ):  # fmt: skip
            forms.append(_sensor_curve(problem, piece, site, over, values, unit))
    return forms


def _sensor_drifts(model: FittedModel) -> list[_Drift]:
    """Readings that drift. A drift biases the nuisance, so it is fitted with it, not solved for around its values."""
    problem, off = model.problem, "off by an amount that drifts with time"
    return [
        _Drift(_sensor_site(problem, piece), f"{_name_of(problem, piece)} {off}", piece)
        for piece in _often_sampled(problem)
    ]


def _often_sampled(problem: Problem) -> list[Piece]:
    """Pieces with enough samples for a curve."""
    return [piece for piece in problem.pieces if piece.channel.time.size >= 4 * _KNOTS]


def _sensor_site(problem: Problem, piece: Piece) -> str:
    model = problem.model
    return model.sensor_site(piece.name) if isinstance(model, HasFreeForms) else "sensor"


def _name_of(problem: Problem, piece: Piece) -> str:
    of_run = f" in run {piece.run + 1}" if len(problem.model.runs) > 1 else ""
    return f"{plain_name(piece.name)}{of_run}"


def _sensor_curve(problem: Problem, piece: Piece, site: str, over: str, values: Array, unit: str) -> _LinearForm:
    """A reading that is off by a piecewise linear function of given values (n,)."""
    knots = np.linspace(float(values.min()), max(float(values.max()), float(values.min()) + 1e-9), _KNOTS)
    rows = np.zeros((_KNOTS, problem.size))
    for index in range(_KNOTS):
        rows[index, piece.rows] = np.interp(values, knots, np.eye(_KNOTS)[index])
    description = f"{_name_of(problem, piece)} off by an amount that follows {over}"
    return _LinearForm(site, description, None, knots, unit, piece.channel.unit, rows, piece.name)


def _linearised(model: FittedModel, form: FreeForm) -> _LinearForm:
    """A free form of the model by finite differences: the change per coefficient, or per value of the curve."""
    rows = (model.problem.simulate(form.parameter_sets) - model.fit.simulated) / np.array(form.steps)[:, None]
    if form.basis:
        rows = np.linalg.solve(np.array(form.basis).T, rows)
    return _LinearForm(
        form.site, form.description, form.free_form_of, np.array(form.x), form.x_unit, form.y_unit, rows,
        lower_bound=form.lower_bound,
    )  # fmt: skip


def _fit_coefficients(model: FittedModel, form: FreeForm, folds: Folds, gain_worth_finishing: float) -> FreeFormFit:
    """A free form whose coefficients are fitted with the nuisance."""
    start = _likeliest_start(model, form.parameters[0]) if len(form.parameters) == 1 else None
    rows = model.fit.jacobian_rows
    found, score = _fit_with_nuisance(model, model.problem, form.parameters, rows, folds, gain_worth_finishing, start)
    shape = np.array([found.values[parameter.name] - parameter.nominal for parameter in form.parameters])
    x = np.array(form.x)
    if form.period is not None:
        # The mean around a period is no function of position: the nuisance has it.
        x, shape = np.append(x, x[0] + form.period), np.append(shape, shape[0]) - float(np.mean(shape))
    return FreeFormFit(form.site, form.description, form.free_form_of, x, form.x_unit, shape, form.y_unit, score)


def _likeliest_start(model: FittedModel, far: Parameter) -> tuple[dict[str, float], Array] | None:
    """The likeliest value all over one parameter's range, beside the calibrated and beside the nominal nuisance.

    A fit that starts at nominal, beside a nuisance that has moved to make up for it, may never get there.

    Returns:
        Parameter values and their simulation (N,); None where none is likelier than the parameter's nominal value.
    """
    known, calibrated = model.fit, model.fit.values
    own = {parameter.name for parameter in known.parameters if not parameter.per_run}
    nominal = {name: value for name, value in calibrated.items() if name not in own}
    shares = np.concatenate([_START_SHARES * (bound - far.nominal) for bound in (far.lower, far.upper)])
    starts = [{**base, far.name: float(far.nominal + share)} for base in (calibrated, nominal) for share in shares]
    simulated = zip(starts, model.problem.simulate(starts), strict=True)
    costs = [(penalized_cost(model.problem, known.parameters, *start), start) for start in simulated]
    least, best = min(costs, key=lambda entry: entry[0])
    return best if least < known.cost else None


def _fit_drift(model: FittedModel, drift: _Drift, folds: Folds, gain_worth_finishing: float) -> FreeFormFit:
    """A sensor's drift, fitted with the nuisance."""
    rows = np.zeros((2, model.problem.size))
    rows[:, drift.piece.rows] = drift.rows
    added = dict(zip(_DRIFT_PARAMETERS, rows, strict=True))
    free = tuple(Parameter(name, 0.0, -_NO_BOUND, _NO_BOUND, 1.0) for name in _DRIFT_PARAMETERS)
    problem, known_rows = model.problem.with_added_rows(added), model.fit.jacobian_rows | added
    found, score = _fit_with_nuisance(model, problem, free, known_rows, folds, gain_worth_finishing)
    shape = drift.piece.noise * np.array([found.values[name] for name in _DRIFT_PARAMETERS])
    x = drift.piece.channel.time[[0, -1]]
    unit = drift.piece.channel.unit
    return FreeFormFit(drift.site, drift.description, None, x, "s", shape, unit, score, drift.piece.name)


def _fit_with_nuisance(
    model: FittedModel,
    problem: Problem,
    parameters: Sequence[Parameter],
    rows: Mapping[str, Array],
    folds: Folds,
    gain_worth_finishing: float,
    start: tuple[Values, Array] | None = None,
) -> tuple[Fit, HeldOutScore]:
    """Fit parameters together with the nuisance, and score them.

    Where the fit gains more than ``gain_worth_finishing``, it is finished in fine simulations and refitted without each
    fold; else each fold is scored by a linear solution without it.

    Args:
        model: The model with the nuisance.
        problem: The problem with the parameters.
        parameters: The parameters.
        rows: Rows (N,) of the first Jacobian.
        folds: The folds.
        gain_worth_finishing: Gain of ``-2 log p``.
        start: Values and simulation (N,) to start from; those of the model by default.
    """
    known = model.fit
    freed = [*known.parameters, *problem.expand_per_run(parameters)]
    values, simulated = start or (known.values, known.simulated)
    found = fit(
        problem, freed, values, tolerance=min_gain_to_catch_up(gain_worth_finishing), simulated=simulated,
        jacobian_rows={} if start else rows,
    )  # fmt: skip
    if known.cost - found.cost > gain_worth_finishing:
        exact, fine = refit_in_fine_simulation(*refit_with_correction(problem, found))
        return fine, score_held_out(exact, fine, folds)
    own = [index for index, parameter in enumerate(found.parameters) if not parameter.per_run]
    own_rows, of_rig = found.jacobian[own], [found.parameters[index] for index in own]
    white, through = problem.whitened(found.residual, own_rows, found.discrepancy)
    # The gain that one more step of the whole log would predict is not counted: it has not been simulated.
    unstepped = found.residual + _smooth_step(through, white, of_rig, found.values) @ own_rows
    residual = _held_out_residual(unstepped, own_rows, white, through, of_rig, found.values, folds)
    return found, score_residual(problem, residual, found)


def _solve(model: FittedModel, form: _LinearForm, folds: Folds) -> FreeFormFit:
    """A curve, solved for once together with the nuisance."""
    problem, found = model.problem, model.fit
    own = [index for index, parameter in enumerate(found.parameters) if not parameter.per_run]
    power = np.sum(form.rows**2, axis=1)
    used = power > 1e-9 * max(float(power.max(initial=0.0)), 1e-12)
    rows = np.vstack([found.jacobian[own], form.rows[used]])
    nuisance = [found.parameters[index] for index in own]
    white, through = problem.whitened(found.residual, rows, found.discrepancy)
    # As in a fit, what the curve explains is no discrepancy any more: whiten again with the discrepancy that is left.
    left = found.residual - _smooth_step(through, white, nuisance, found.values, form.lower_bound) @ rows
    white, through = problem.whitened(found.residual, rows, problem.cost(left)[1])
    residual = _held_out_residual(
        found.residual, rows, white, through, nuisance, found.values, folds, form.lower_bound
    )
    shape = np.zeros(used.size)
    shape[used] = _smooth_step(through, white, nuisance, found.values, form.lower_bound)[len(own) :]
    _, discrepancies = problem.cost(residual)
    score = score_residual(problem, residual, replace(found, discrepancy=discrepancies))
    shape = _unit_of_coefficients(problem, form) * shape
    return FreeFormFit(
        form.site, form.description, form.free_form_of, form.x, form.x_unit, shape, form.y_unit, score,
        form.sensor_channel,
    )  # fmt: skip


def _held_out_residual(
    residual: Array,
    rows: Array,
    white: Array,
    through: Array,
    nuisance: Sequence[Parameter],
    values: Values,
    folds: Folds,
    lower_bound: float = -np.inf,
) -> Array:
    """(N,) residual of each fold after a step that was solved for without it.

    Args:
        residual: (N,) before the step.
        rows: (p, N) changes by the step.
        white: (N,) the residual, whitened.
        through: (p, N) the changes, whitened.
        nuisance: The first of the p parameters; the others are coefficients of a curve.
        values: Parameter values before the step.
        folds: The folds.
        lower_bound: Of the coefficients.
    """
    held_out = np.empty(residual.size)
    for fold in range(FOLDS):
        kept = folds.fold != fold
        step = _smooth_step(through[:, kept], white[kept], nuisance, values, lower_bound)
        held_out[~kept] = (residual - step @ rows)[~kept]
    return held_out


def _smooth_step(
    rows: Array, target: Array, nuisance: Sequence[Parameter], values: Values, lower_bound: float = -np.inf
) -> Array:
    """(p,) bounded step of the nuisance, in scales, and of the coefficients of a smooth curve.

    The weight on the curve's second differences is the one under which the data are likeliest (empirical Bayes; MacKay,
    Neural Computation 4, 1992), so that the curve extrapolates over a stretch that is left out at an end. The nuisance
    stays within its bounds: beyond them it could explain by itself what an effect has to.

    Args:
        rows: (p, n) whitened changes: nuisance, then coefficients.
        target: (n,) whitened residual.
        nuisance: The nuisance parameters.
        values: Their values before the step.
        lower_bound: Of the coefficients.
    """
    own, knots = len(nuisance), len(rows) - len(nuisance)
    power = np.sum(rows**2, axis=1)
    normal, gradient = rows @ rows.T, rows @ target
    prior = prior_weights(nuisance) ** 2
    normal[np.diag_indices(own)] += prior
    gradient[:own] -= prior * scaled_offsets(nuisance, values)
    normal[np.diag_indices(len(rows))] += 1e-9 * max(float(power.max(initial=0.0)), 1e-12)
    if knots > 2:
        curvature = np.zeros_like(normal)
        second_difference = np.diff(np.eye(knots), n=2, axis=0)
        curvature[own:, own:] = float(np.median(power[own:])) * (second_difference.T @ second_difference)

        def minus_log_evidence(weight: float) -> float:
            smooth = normal + weight * curvature
            _, log_determinant = np.linalg.slogdet(smooth)
            explained = gradient @ np.linalg.solve(smooth, gradient)
            return float(log_determinant - (knots - 2) * np.log(weight) - explained)

        normal = normal + min(_SMOOTHING, key=minus_log_evidence) * curvature
    low, high = distance_to_bounds(nuisance, values)
    low, high = np.append(low, np.full(knots, lower_bound)), np.append(high, np.full(knots, np.inf))
    step = np.linalg.solve(normal, gradient)
    if np.any(step < low) or np.any(step > high):
        step = np.clip(bounded_step(normal, gradient, 0.0, low, high), low, high)
    return np.asarray(step, dtype=np.float64)


def _unit_of_coefficients(problem: Problem, form: _LinearForm) -> float:
    """Unit of the coefficients: noise units for a sensor's curve, their own for a free form of the model."""
    if form.sensor_channel is None:
        return 1.0
    touched = [piece for piece in problem.pieces if np.any(form.rows[:, piece.rows])]
    return touched[0].noise if touched else 1.0
