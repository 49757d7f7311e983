"""A nuisance that went far: re-tuning was enough, and may have stood in for a law."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from slider_drilling.gap.evidence.compare import chi2_critical
from slider_drilling.gap.model import Effect, Parameter
from slider_drilling.gap.selection.calibration import NUISANCE_LIMIT, fit_from_starts, plausible_range
from slider_drilling.gap.selection.refit import check_adequacy, finish_and_cross_validate
from slider_drilling.gap.selection.state import CandidateResult, FittedModel, SearchState


def outside_prior(explained: FittedModel) -> list[tuple[Parameter, float, float]]:
    """What of the nuisance had to go farther than rigs are commonly off: parameter, its value, how many spreads."""
    found = []
    for parameter in explained.problem.model.nuisance:
        value = explained.fit.values.get(parameter.name, parameter.nominal)
        spreads = abs(value - parameter.nominal) / parameter.spread
        if not parameter.per_run and spreads > NUISANCE_LIMIT:
            found.append((parameter, value, spreads))
    return found


def calibrate_within_limits(state: SearchState, effects: Sequence[Effect], seed: int) -> SearchState:
    """The state with its re-tuning held to where rigs commonly are; what it was before stays known as ``far``. effects:
    looked for in what that leaves.
    """
    far = {parameter.name for parameter, _, _ in outside_prior(state.current)}
    freed = [_within(parameter) if parameter.name in far else parameter for parameter in state.current.fit.parameters]
    known = {name: value for name, value in state.current.fit.values.items() if "@" in name}
    near = finish_and_cross_validate(
        state.current_mode,
        (),
        fit_from_starts(state.current_mode, (state.current.fit.values, known), freed),
        state.bootstrap.folds,
    )
    enough = check_adequacy(near, seed, effects)
    return replace(
        state, calibrated=near, current=near, adequacy=enough, calibrated_adequacy=enough, unrestricted=state
    )


def supported_without_prior(known: FittedModel, judged: CandidateResult, rivals: int) -> bool:
    """Whether the log alone, whatever rigs commonly are, is likelier with an effect than its added parameters make it
    by chance, at the level shared among all; and foretells as much of what was held out.
    """
    there, here = (one.problem.cost(one.fit.residual)[0] for one in (known, judged.fitted))
    added = len(judged.fitted.fit.parameters) - len(known.fit.parameters)
    foretold = judged.fitted.score.held_out_deviance <= known.score.held_out_deviance
    return foretold and there - here > chi2_critical(added, rivals)


def _within(parameter: Parameter) -> Parameter:
    low, high = plausible_range(parameter)
    return replace(parameter, lower=low, upper=high)
