"""The first state of the search: noise floors, the calibrated model, and whether that is enough."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from slider_drilling.gap.evidence.adequacy import Adequacy
from slider_drilling.gap.evidence.block_bootstrap import BlockBootstrap, make_bootstrap
from slider_drilling.gap.evidence.replicates import replicate_noise_factors
from slider_drilling.gap.evidence.score import make_folds
from slider_drilling.gap.model import Effect, HasObserver, Model, SimulationOptions, Values
from slider_drilling.gap.problem.noise import NoiseFloor, lower_floor, raise_floor, sigmas
from slider_drilling.gap.problem.problem import Problem, SimulationCounter, build_problem
from slider_drilling.gap.progress import Progress
from slider_drilling.gap.search.fine_fit import refit_in_fine_simulation, refit_with_correction
from slider_drilling.gap.search.least_squares import Fit, fit
from slider_drilling.gap.search.multi_start import fit_from_starts, scattered_starts
from slider_drilling.gap.selection.nuisance_limits import outside_prior
from slider_drilling.gap.selection.refit import (
    check_adequacy,
    cross_validate,
    finish_and_cross_validate,
    fitted_gap,
    least_gap,
    no_worse_than,
    score_nominal,
)
from slider_drilling.gap.selection.state import FittedModel, SearchState

# Gain of the weak observer (see `slider_drilling.gap.model.HasObserver`).
OBSERVER_GAIN = 0.3


def calibrate(
    model: Model,
    effects: Sequence[Effect],
    floors: Sequence[dict[str, NoiseFloor]],
    starts: Sequence[Values],
    seed: int,
    report: Progress,
    counter: SimulationCounter | None = None,
) -> SearchState:
    """Fit the nuisance alone and see whether that is enough.

    Args:
        model: The model with its logs.
        effects: Effects to look for in the residuals.
        floors: Noise floors by run and channel, from the log alone.
        starts: Nuisance values to start from.
        seed: Seed of resamples and replicates.
        report: Called with the stage and the share done.
        counter: Of an earlier search, to go on counting.

    Returns:
        The first state of the search; it is done if nothing is left to find.
    """
    report("calibrating", 0.02)
    problem = build_problem(model, [sigmas(own) for own in floors], counter=counter)
    given = [{}, *(dict(values) for values in starts if values)]
    result = _calibrated(problem, effects, floors, starts, seed, report)
    if fitted_gap(result.fitted) > least_gap(result.free_run, given):
        # The likelihood lets slow errors pass that are larger than the gap before: they must count like all others.
        report("calibrating without slow errors", 0.08)
        result = _calibrated(replace(problem, white_discrepancy=True), effects, floors, starts, seed, report)
    nominal = score_nominal(result.free_run, result.fitted)
    fitted, adequacy = no_worse_than(result.fitted, given), result.adequacy
    if fitted is not result.fitted:
        adequacy = check_adequacy(fitted, seed, effects)
    within = all(nominal.by_channel[name] <= limit for name, limit in adequacy.channel_thresholds.items())
    modes: tuple[Problem, ...] = (result.free_run,)
    if _can_be_observed(model):
        modes = (result.free_run, result.free_run.with_options(SimulationOptions(0, OBSERVER_GAIN)))
    return SearchState(
        floors=result.floors,
        modes=modes,
        nominal_score=nominal,
        calibrated=fitted,
        current=fitted,
        adequacy=adequacy,
        calibrated_adequacy=adequacy,
        nominal_adequate=nominal.gap <= adequacy.threshold and within,
        bootstrap=result.bootstrap,
        done=adequacy.complete and not outside_prior(fitted),
    )


@dataclass(frozen=True)
class _Calibration:
    """A calibration in one problem.

    Attributes:
        free_run: The problem, with the noise floors that the calibrated model shows.
        floors: These floors, by run and channel.
        bootstrap: Resamples of the log.
        fitted: The calibrated model.
        adequacy: Whether it is enough.
    """

    free_run: Problem
    floors: tuple[dict[str, NoiseFloor], ...]
    bootstrap: BlockBootstrap
    fitted: FittedModel
    adequacy: Adequacy


def _calibrated(
    free_run: Problem,
    effects: Sequence[Effect],
    floors: Sequence[dict[str, NoiseFloor]],
    starts: Sequence[Values],
    seed: int,
    report: Progress,
) -> _Calibration:
    """The likeliest calibration in a problem. Arguments: as `calibrate`."""
    rough = fit_from_starts(free_run, starts)
    # A calibrated model follows the signal's kinks, which differences of the log alone take for noise.
    floors = lower_floors(free_run, rough, floors)
    free_run = free_run.with_noise([sigmas(own) for own in floors])
    bootstrap = make_bootstrap(make_folds(free_run), seed)
    calibrated = fit(free_run, rough.parameters, rough.values, iterations=2)
    corrected, fine = refit_with_correction(free_run, calibrated)
    raised = raise_floors(corrected, fine, floors, seed)
    if raised != floors:
        floors = raised
        free_run = free_run.with_noise([sigmas(own) for own in floors])
        start = fit(free_run, calibrated.parameters, fine.values, iterations=1)
        corrected, fine = refit_with_correction(free_run, start)
    fitted = cross_validate(*refit_in_fine_simulation(corrected, fine), (), bootstrap.folds)
    adequacy = check_adequacy(fitted, seed, effects)
    if not adequacy.complete:
        report("calibrating from other starts", 0.06)
        other = fit_from_starts(free_run, scattered_starts(free_run, calibrated))
        if other.cost < calibrated.cost:
            fitted = finish_and_cross_validate(free_run, (), other, bootstrap.folds)
            adequacy = check_adequacy(fitted, seed, effects)
    return _Calibration(free_run, tuple(floors), bootstrap, fitted, adequacy)


def _can_be_observed(model: Model) -> bool:
    return isinstance(model, HasObserver) and any(
        channel.name == model.observed_channel for run in model.runs for channel in run.channels
    )


def lower_floors(
    problem: Problem, calibrated: Fit, floors: Sequence[dict[str, NoiseFloor]]
) -> tuple[dict[str, NoiseFloor], ...]:
    """Noise floors from the residuals of a fit, which no longer hold the signal's own kinks."""
    lowered = [dict(own) for own in floors]
    for piece in problem.pieces:
        residual = calibrated.residual[piece.rows] * piece.noise
        lowered[piece.run][piece.name] = lower_floor(lowered[piece.run][piece.name], residual)
    return tuple(lowered)


def raise_floors(
    problem: Problem, calibrated: Fit, floors: Sequence[dict[str, NoiseFloor]], seed: int
) -> tuple[dict[str, NoiseFloor], ...]:
    """Noise floors of channels that the model could not predict more closely even if it were the truth."""
    raised = [dict(own) for own in floors]
    for index, factor in replicate_noise_factors(problem, calibrated, seed).items():
        piece = problem.pieces[index]
        raised[piece.run][piece.name] = raise_floor(raised[piece.run][piece.name], factor)
    return tuple(raised)
