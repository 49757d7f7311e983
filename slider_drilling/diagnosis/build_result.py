"""Fill the result of a diagnosis from the engine's answer."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from slider_drilling.diagnosis.result import (
    STAGES,
    ChannelErrors,
    ChannelNoise,
    ChannelTrace,
    ClosedShare,
    Diagnosis,
    FittedParameter,
    Gap,
    Interval,
    RankedEffect,
    ResidualShape,
)
from slider_drilling.diagnosis.usual_error import counts_of
from slider_drilling.gap.evidence.adequacy import HARDLY_MORE_THAN_NOISE
from slider_drilling.gap.explain import GapDiagnosis
from slider_drilling.gap.model import Array, Effect, Model
from slider_drilling.gap.problem.noise import is_white
from slider_drilling.gap.problem.problem import Problem
from slider_drilling.gap.results.intervals import intervals_beside_all_nuisance, user_parameters, user_values
from slider_drilling.gap.results.whole_runs import WholeRunErrors
from slider_drilling.gap.search.least_squares import Fit
from slider_drilling.gap.selection.evidence_tests import Evidence
from slider_drilling.gap.selection.naming_criteria import Stage, criterion, failures
from slider_drilling.gap.selection.state import CandidateResult, FittedModel
from slider_drilling.plain_names import plain_name

SCREENED_OUT = "screened out: other effects fitted better after as many trials"
NOT_SEARCHED = "not searched for: calibration leaves no more than noise"
# An interval of a share that is wider than this says nothing: there is hardly a gap to be a share of.
_MAX_WIDTH = 2.0

# Share of a gap that is closed, its interval, and the effects that had left this gap.
_Closed = tuple[float | None, Interval | None, tuple[str, ...]]


def with_engine_result(
    diagnosis: Diagnosis, answer: GapDiagnosis, model: Model, whole_runs: WholeRunErrors, effects: Sequence[Effect]
) -> Diagnosis:
    """A diagnosis with what the engine concludes.

    Args:
        diagnosis: With logs, rig file, checks and the remarks so far.
        answer: The engine's answer.
        model: Of the whole runs.
        whole_runs: Errors of free simulations of them.
        effects: All candidates, also those that were not fitted.
    """
    state = answer.state
    return replace(
        diagnosis,
        verdict=answer.verdict,
        site=answer.site,
        effects=answer.effects,
        suspected=tuple(candidate.effect.name for candidate in answer.suspected),
        masked_effects=answer.masked_effects,
        small_cause=answer.small_cause,
        interrupted=state.interrupted,
        gap=_gap(answer, model),
        breakdown=answer.breakdown,
        residual_shape=_residual_shape(answer),
        ranking=rank_effects(answer, effects),
        next_manoeuvre=answer.next_manoeuvre,
        explanations=answer.explanations,
        tuned_parameters=fitted_parameters(answer.free_runs.best),
        whole_run_errors=whole_runs,
        fed_back=answer.fed_back,
        traces=_traces(whole_runs),
        simulations=answer.simulation_count,
        not_refitted=state.current.score.unrefitted_folds,
        remarks=(*diagnosis.remarks, *answer.remarks),
        runtime=answer.runtime,
    )


def _gap(answer: GapDiagnosis, model: Model) -> Gap:
    channels = {channel.name: channel for run in model.runs for channel in run.channels}
    floors = {name: floor for run in answer.state.floors for name, floor in run.items()}
    rms = _rms_by_stage(answer)
    smaller = bool(answer.effects) and answer.gap_with_effects < answer.gap_calibrated
    closed, interval = _share(answer.closed, answer.closed_interval, answer) if smaller else (None, None)
    return Gap(
        nominal=answer.gap_nominal,
        tuned=answer.gap_calibrated,
        with_effect=answer.gap_with_effects if answer.effects else None,
        closed=closed,
        closed_interval=interval,
        threshold=answer.null_threshold,
        noise_floor={
            name: ChannelNoise(
                floor.sigma,
                floor.declared,
                channels[name].unit,
                floor.method,
                _leaves_white(answer, name),
                floor.excess,
            )
            for name, floor in floors.items()
        },
        model_error={name: channel.model_error for name, channel in channels.items() if channel.model_error},
        rms={
            name: ChannelErrors(channel.unit, *(rms.get(stage, {}).get(name) for stage in STAGES))
            for name, channel in channels.items()
        },
        misfit_channels=answer.misfit_channels,
    )


def _leaves_white(answer: GapDiagnosis, channel: str) -> bool | None:
    """Whether the final model leaves white noise of a channel in every run; None if no run is long enough to say."""
    current = answer.state.current
    white = [is_white(current.fit.residual[p.rows]) for p in current.problem.pieces if p.name == channel]
    known = [run for run in white if run is not None]
    return all(known) if known else None


def _rms_by_stage(answer: GapDiagnosis) -> dict[str, dict[str, float]]:
    """RMS of each channel by stage; held out where parameters were fitted."""
    state = answer.state
    residuals = {"nominal": state.nominal_score.residual, "tuned": state.calibrated.score.residual}
    if answer.effects:
        residuals["with_effect"] = state.current.score.residual
    return {stage: rms_by_channel(state.calibrated.problem, residual) for stage, residual in residuals.items()}


def rms_by_channel(problem: Problem, residual: Array) -> dict[str, float]:
    """RMS of a residual (N,), noise units, by channel over all runs, in the channel's unit."""
    squares: dict[str, list[Array]] = {}
    for piece in problem.pieces:
        counts = counts_of(problem, piece)
        squares.setdefault(piece.name, []).append((residual[piece.rows][counts] * piece.noise) ** 2)
    together = {name: np.concatenate(values) for name, values in squares.items()}
    return {name: float(np.sqrt(np.mean(values))) for name, values in together.items() if values.size}


def _share(closed: float, interval: Interval, answer: GapDiagnosis) -> tuple[float | None, Interval | None]:
    """A share of the gap and its interval; None without a gap above noise, or if the gap does not shrink."""
    if math.isnan(closed) or closed <= 0.0 or not answer.gap_calibrated > HARDLY_MORE_THAN_NOISE:
        return None, None
    if math.isnan(interval[0]):
        return closed, None
    return (None, None) if interval[1] - interval[0] > _MAX_WIDTH else (closed, interval)


def rank_effects(answer: GapDiagnosis, effects: Sequence[Effect]) -> tuple[RankedEffect, ...]:
    """Fitted effects, those in the answer first, then those that were not fitted, most promising first."""
    ranking: list[RankedEffect] = []
    for candidate in answer.candidates:
        new = _new_effects(candidate, answer, {ranked.effect for ranked in ranking})
        kept = [effect.name for effect in new if effect.name in answer.effects]
        ranking += [_ranked(candidate, effect, answer, kept) for effect in new]
    names = {ranked.effect for ranked in ranking}
    gain = answer.state.steps[0].predicted_gain if answer.state.steps else {}
    others = sorted((e for e in effects if e.name not in names), key=lambda e: -gain.get(e.name, 0.0))
    why_not = SCREENED_OUT if answer.state.steps else NOT_SEARCHED
    ranking += [RankedEffect(e.name, e.site, False, False, (why_not,), None, None, {}, ()) for e in others]
    return tuple(ranking)


def _new_effects(candidate: CandidateResult, answer: GapDiagnosis, ranked: set[str]) -> list[Effect]:
    """The effects that a candidate adds to the ranking: its own, and those accepted with it that are in the answer."""
    kept = answer.effects if _accepted(candidate, answer) else ()
    return [
        e for e in candidate.fitted.effects
        if e.name not in ranked and (e.name == candidate.effect.name or e.name in kept)
    ]  # fmt: skip


def _accepted(candidate: CandidateResult, answer: GapDiagnosis) -> bool:
    return any(candidate is step.accepted for step in answer.state.steps)


def _ranked(candidate: CandidateResult, effect: Effect, answer: GapDiagnosis, kept: Sequence[str]) -> RankedEffect:
    """The ranking's entry of an effect; kept: effects of the answer that the candidate brought.

    An effect in the answer has the final model's parameters. It has no share of its own if it was found together with
    others: alone it would close another share.
    """
    name = effect.name
    in_answer = name in answer.effects
    closed, interval, known_before = _closed_in_answer(candidate, answer) if in_answer else _closed(candidate, answer)
    why_not = candidate.failures
    if not in_answer and not why_not:
        why_not = (why_not_in_answer(candidate, answer),)
    return RankedEffect(
        name, effect.site, candidate.passed, in_answer, () if in_answer else why_not, closed, interval,
        fitted_parameters(answer.free_runs.final if in_answer else candidate.fitted, f"{name}."),
        answer.indistinguishable.get(name, ()), _in_other_runs(candidate, answer),
        tuple(other for other in kept if in_answer and other != name), known_before,
        name in {each.effect.name for each in answer.suspected},
    )  # fmt: skip


def why_not_in_answer(candidate: CandidateResult, answer: GapDiagnosis) -> str:
    """Why an effect that passes its own criteria is not in the answer."""
    if candidate.effect.name in answer.withdrawn:
        return "explains the log only while a measured channel is fed back: a free run is hardly better with it"
    alike = [name for name in answer.effects if candidate.effect.name in answer.indistinguishable.get(name, ())]
    if alike:
        return f"this log cannot distinguish it from {_listed(alike)}"
    accepted = next((step.accepted for step in answer.state.steps if step.accepted is not None), None)
    if answer.verdict == "unknown" and candidate is accepted:
        failed = failures(Stage.VERDICT, Evidence(answer.state, answer.state.calibrated, candidate.fitted))
        if failed:
            return f"after calibration, {failed[0]}"
    better = _listed(answer.effects) or (answer.alternative.description if answer.alternative is not None else "")
    if better:
        return f"{better} {'explain' if len(answer.effects) > 1 else 'explains'} the same part of the gap better"
    if answer.verdict != "unknown":
        return "what remains is within the noise"
    if accepted is not None and accepted is not candidate:
        return f"{plain_name(accepted.effect.name)} fits better but was not confirmed"
    return criterion("no free form predicts better").message


def _listed(names: Sequence[str]) -> str:
    return " and ".join(plain_name(name) for name in names)


def _in_other_runs(candidate: CandidateResult, answer: GapDiagnosis) -> ClosedShare | None:
    if candidate.closed_in_other_runs is None:
        return None
    closed, interval = _share(*candidate.closed_in_other_runs, answer)
    return None if closed is None else ClosedShare(closed, interval)


def _closed_in_answer(candidate: CandidateResult, answer: GapDiagnosis) -> _Closed:
    """What an accepted candidate closes; what the whole answer closes if an effect was removed again since."""
    if not _accepted(candidate, answer):
        return None, None, ()
    names = candidate.fitted.names
    if names == answer.effects[: len(names)]:
        return _closed(candidate, answer)
    brought_all = set(answer.effects) <= set(names)
    return (*_share(answer.closed, answer.closed_interval, answer), ()) if brought_all else (None, None, ())


def _closed(candidate: CandidateResult, answer: GapDiagnosis) -> _Closed:
    """What a candidate closes of the gap that the effects known before it leave."""
    return (*_share(candidate.closed, candidate.interval, answer), candidate.beside)


def fitted_parameters(model: FittedModel, prefix: str = "") -> Mapping[str, FittedParameter]:
    """The fitted parameters under the names that users know; prefix: only those that begin with it."""
    return _named_parameters(model.problem, model.fit, model.intervals, prefix)


def parameters_of_fit(problem: Problem, found: Fit, prefix: str = "") -> dict[str, FittedParameter]:
    """The parameters of a fit under the names that users know; prefix: only those that begin with it."""
    return _named_parameters(problem, found, intervals_beside_all_nuisance(problem, found), prefix)


def _named_parameters(
    problem: Problem, found: Fit, intervals: Mapping[str, tuple[float, float]], prefix: str
) -> dict[str, FittedParameter]:
    values = user_values(problem, found.values)
    return {
        name: FittedParameter(values[name], parameter.unit, parameter.nominal, intervals.get(name))
        for name, parameter in user_parameters(problem, found).items() if name.startswith(prefix)
    }  # fmt: skip


def _residual_shape(answer: GapDiagnosis) -> ResidualShape | None:
    """What explains as much as the named effects, else what remains beside them, else what the unknown looks like."""
    form = answer.alternative or answer.remainder
    if form is None:
        return None
    of = "rest" if answer.alternative is None else "alternative" if answer.effects else "unknown"
    return ResidualShape(of, form.description, form.x, form.y, form.x_unit, form.y_unit)  # type: ignore[arg-type]


def _traces(whole_runs: WholeRunErrors) -> tuple[ChannelTrace, ...]:
    traces = []
    for piece in whole_runs.problem.pieces:
        run, channel = whole_runs.problem.model.runs[piece.run], piece.channel
        until = run.time[0] + whole_runs.share * run.duration if whole_runs.rest else None
        simulated = {stage: channel.measured - rows[piece.rows] for stage, rows in whole_runs.residuals.items()}
        traces.append(
            ChannelTrace(piece.run, channel.name, channel.unit, channel.time, channel.measured, simulated, until)
        )
    return tuple(traces)
