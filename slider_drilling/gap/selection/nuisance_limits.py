"""Calibration that needs implausible values: it may hide an effect that acts alike."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from slider_drilling.gap.model import Effect, Parameter
from slider_drilling.gap.search.multi_start import NUISANCE_LIMIT, fit_from_starts, plausible_range
from slider_drilling.gap.selection.refit import check_adequacy, finish_and_cross_validate, no_worse_than
from slider_drilling.gap.selection.state import FittedModel, SearchState


def outside_prior(model: FittedModel) -> list[tuple[Parameter, float, float]]:
    """Nuisance parameters outside their prior: parameter, fitted value, distance from nominal in standard deviations.

    Parameters that belong to one run are left out.
    """
    outside = []
    for parameter in model.problem.model.nuisance:
        value = model.fit.values.get(parameter.name, parameter.nominal)
        deviations = abs(value - parameter.nominal) / parameter.spread
        if not parameter.per_run and deviations > NUISANCE_LIMIT:
            outside.append((parameter, value, deviations))
    return outside


def calibrate_within_limits(state: SearchState, effects: Sequence[Effect], seed: int) -> SearchState:
    """The state with a calibration that keeps implausible parameters within their limits.

    Args:
        state: State whose calibration is implausible; it is kept as ``unrestricted``.
        effects: Effects to look for in what the restricted calibration leaves.
        seed: Seed of the replicates.
    """
    outside = {parameter.name for parameter, _, _ in outside_prior(state.current)}
    values = state.current.fit.values
    freed = [_limited(each) if each.name in outside else each for each in state.current.fit.parameters]
    of_runs = {name: value for name, value in values.items() if "@" in name}
    mode = state.current_mode
    best = fit_from_starts(mode, (values, of_runs), freed)
    near = no_worse_than(finish_and_cross_validate(mode, (), best, state.bootstrap.folds), [{}])
    adequacy = check_adequacy(near, seed, effects)
    return replace(
        state, calibrated=near, current=near, adequacy=adequacy, calibrated_adequacy=adequacy, unrestricted=state
    )


def _limited(parameter: Parameter) -> Parameter:
    low, high = plausible_range(parameter)
    return replace(parameter, lower=low, upper=high)
