"""Free-form alternatives: at each site a flexible curve without a law, to compare the named effects with.

A curve is solved for once, linearised at a fit, and scored on stretches that it has not seen. One with few coefficients
that may go far is fitted. If a free form predicts held-out data better than the best effect, its shape is reported
instead of the effect.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from slider_drilling.gap.evidence.free_form_fit import FreeFormFit
from slider_drilling.gap.evidence.linear_form import LinearForm, LinearisedFit, solve_linear_form
from slider_drilling.gap.evidence.score import Folds, HeldOutScore, score_held_out, score_residual
from slider_drilling.gap.evidence.sensor_forms import Drift, sensor_curves, sensor_drifts
from slider_drilling.gap.model import Array, FreeForm, HasFreeForms, Parameter, Values
from slider_drilling.gap.problem.problem import Problem
from slider_drilling.gap.search.fine_fit import refit_in_fine_simulation, refit_with_correction
from slider_drilling.gap.search.least_squares import Fit, KnownStart, fit, min_gain_to_catch_up, penalized_cost
from slider_drilling.gap.selection.state import FittedModel
from slider_drilling.process.parallel_map import parallel_map

# Starts of a coefficient that may go far, as shares of the way to its bounds.
_START_SHARES = np.array([1.0 / 32.0, 0.125, 0.25, 0.5, 0.75])
# Parameters of a sensor's drift: its error at the beginning and end of a run, noise units; and a bound never met.
_DRIFT_PARAMETERS, _NO_BOUND = ("drift.begin", "drift.end"), 1e6


_AnyForm = LinearForm | Drift | FreeForm


def fit_free_forms(model: FittedModel, folds: Folds, gain_worth_finishing: float = 0.0) -> list[FreeFormFit]:
    """Every free form that the model and its sensors offer, best held-out prediction first.

    Args:
        model: The model whose residuals they explain.
        folds: Folds to score them by.
        gain_worth_finishing: Gain of ``-2 log p`` from which a form that is fitted is finished in fine simulations.
    """
    forms: list[_AnyForm] = [*sensor_curves(model), *sensor_drifts(model), *_model_forms(model)]
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
        if isinstance(form, Drift):
            return _fit_drift(model, form, folds, gain_worth_finishing)
        if isinstance(form, FreeForm) and form.parameters:
            return _fit_coefficients(model, form, folds, gain_worth_finishing)
        return solve_linear_form(model, _linearised(model, form) if isinstance(form, FreeForm) else form, folds)

    # A form that stays at 0 would only be the nuisance, fitted once more.
    fits = [found for found in parallel_map(fitted, forms) if np.any(found.y)]
    return sorted(fits, key=lambda found: found.score.held_out_deviance)


def _linearised(model: FittedModel, form: FreeForm) -> LinearForm:
    """A free form of the model by finite differences: the change per coefficient, or per value of the curve."""
    rows = (model.problem.simulate(form.parameter_sets) - model.fit.simulated) / np.array(form.steps)[:, None]
    if form.basis:
        rows = np.linalg.solve(np.array(form.basis).T, rows)
    return LinearForm(
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


def _fit_drift(model: FittedModel, drift: Drift, folds: Folds, gain_worth_finishing: float) -> FreeFormFit:
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
        problem, freed, values, tolerance=min_gain_to_catch_up(gain_worth_finishing),
        known=KnownStart(simulated, {} if start else rows),
    )  # fmt: skip
    if known.cost - found.cost > gain_worth_finishing:
        exact, fine = refit_in_fine_simulation(*refit_with_correction(problem, found))
        return fine, score_held_out(exact, fine, folds)
    own = [index for index, parameter in enumerate(found.parameters) if not parameter.per_run]
    own_rows, shared = found.jacobian[own], [found.parameters[index] for index in own]
    white, through = problem.whitened(found.residual, own_rows, found.discrepancy)
    linearised = LinearisedFit(own_rows, white, through, shared, found.values)
    # The gain that one more step of the whole log would predict is not counted: it has not been simulated.
    residual = linearised.held_out_residual(found.residual + linearised.step() @ own_rows, folds)
    return found, score_residual(problem, residual, found)
