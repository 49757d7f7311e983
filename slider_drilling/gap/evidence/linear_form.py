"""Curves without a law, linearised at a fit: solved for once, smooth, together with the nuisance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from slider_drilling.gap.evidence.free_form_fit import FreeFormFit
from slider_drilling.gap.evidence.score import FOLDS, Folds, score_residual
from slider_drilling.gap.model import Array, Parameter, Values
from slider_drilling.gap.problem.problem import Problem
from slider_drilling.gap.search.least_squares import bounded_step, distance_to_bounds, prior_weights, scaled_offsets
from slider_drilling.gap.selection.state import FittedModel

# Weights on the curvature of a curve that are tried, in units of a typical coefficient's weight in the log: from free
# to straight.
_SMOOTHING = 10.0 ** np.arange(-4.0, 5.0)


@dataclass(frozen=True)
class LinearForm:
    """A curve that is solved for once.

    Attributes:
        site: Where it acts.
        description: What it would be, in words.
        free_form_of: As of `FreeFormFit`.
        x: (m,) positions, in ``x_unit``.
        x_unit: Unit of ``x``.
        y_unit: Unit of the curve.
        rows: (m, N) change of the simulation per coefficient, noise units.
        sensor_channel: As of `FreeFormFit`.
        lower_bound: Of the coefficients.
    """

    site: str
    description: str
    free_form_of: tuple[str, ...] | None
    x: Array
    x_unit: str
    y_unit: str
    rows: Array
    sensor_channel: str | None = None
    lower_bound: float = -np.inf


@dataclass(frozen=True)
class LinearisedFit:
    """A residual, and what a step of the nuisance and of a curve's coefficients changes.

    Attributes:
        rows: (p, N) changes by the step: nuisance, then coefficients.
        white: (N,) the residual, whitened.
        through: (p, N) the changes, whitened.
        nuisance: The first of the p parameters.
        values: Parameter values before the step.
        lower_bound: Of the coefficients.
    """

    rows: Array
    white: Array
    through: Array
    nuisance: Sequence[Parameter]
    values: Values
    lower_bound: float = -np.inf

    def step(self, kept: NDArray[np.bool_] | None = None) -> Array:
        """(p,) the step that fits the samples (N,) that are kept; all by default."""
        if kept is None:
            return smooth_step(self.through, self.white, self.nuisance, self.values, self.lower_bound)
        return smooth_step(self.through[:, kept], self.white[kept], self.nuisance, self.values, self.lower_bound)

    def held_out_residual(self, residual: Array, folds: Folds) -> Array:
        """(N,) residual of each fold after a step that was solved for without it; residual: (N,) before the step."""
        held_out = np.empty(residual.size)
        for fold in range(FOLDS):
            kept = folds.fold != fold
            held_out[~kept] = (residual - self.step(kept) @ self.rows)[~kept]
        return held_out


def solve_linear_form(model: FittedModel, form: LinearForm, folds: Folds) -> FreeFormFit:
    """A curve, solved for once together with the nuisance.

    Args:
        model: The model whose residuals it explains.
        form: The curve.
        folds: To score it by.
    """
    problem, found = model.problem, model.fit
    own = [index for index, parameter in enumerate(found.parameters) if not parameter.per_run]
    power = np.sum(form.rows**2, axis=1)
    used = power > 1e-9 * max(float(power.max(initial=0.0)), 1e-12)
    rows = np.vstack([found.jacobian[own], form.rows[used]])
    nuisance = [found.parameters[index] for index in own]
    white, through = problem.whitened(found.residual, rows, found.discrepancy)
    rough = LinearisedFit(rows, white, through, nuisance, found.values, form.lower_bound)
    # As in a fit, what the curve explains is no discrepancy any more: whiten again with the discrepancy that is left.
    white, through = problem.whitened(found.residual, rows, problem.cost(found.residual - rough.step() @ rows)[1])
    linearised = replace(rough, white=white, through=through)
    residual = linearised.held_out_residual(found.residual, folds)
    shape = np.zeros(used.size)
    shape[used] = linearised.step()[len(own) :]
    _, discrepancies = problem.cost(residual)
    score = score_residual(problem, residual, replace(found, discrepancy=discrepancies))
    shape = _unit_of_coefficients(problem, form) * shape
    return FreeFormFit(
        form.site, form.description, form.free_form_of, form.x, form.x_unit, shape, form.y_unit, score,
        form.sensor_channel,
    )  # fmt: skip


def smooth_step(
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


def _unit_of_coefficients(problem: Problem, form: LinearForm) -> float:
    """Unit of the coefficients: noise units for a sensor's curve, their own for a free form of the model."""
    if form.sensor_channel is None:
        return 1.0
    touched = [piece for piece in problem.pieces if np.any(form.rows[:, piece.rows])]
    return touched[0].noise if touched else 1.0
