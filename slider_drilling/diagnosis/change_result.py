"""Fill the result of a diagnosis from what a search for a change found."""

from __future__ import annotations

from collections.abc import Sequence

from slider_drilling.diagnosis.baseline import Baseline
from slider_drilling.diagnosis.build_result import parameters_of_fit, rms_by_channel
from slider_drilling.diagnosis.change_answer import (
    SAME_AS_BEFORE,
    ChangeAnswer,
    changed_model,
    share_explained,
)
from slider_drilling.diagnosis.change_search import ChangeSearch, TriedChange, all_values
from slider_drilling.diagnosis.result import (
    STAGES,
    ChannelErrors,
    ChannelNoise,
    ChannelTrace,
    Diagnosis,
    FittedParameter,
    Gap,
    RankedEffect,
)
from slider_drilling.diagnosis.rig_source import find_rig_source
from slider_drilling.diagnosis.usual_error import usual_gaps
from slider_drilling.gap.model import Array
from slider_drilling.gap.results.intervals import parameter_intervals, user_values
from slider_drilling.log import RigLog
from slider_drilling.log_checks import LogChecks
from slider_drilling.plain_names import plain_name
from slider_drilling.rig import Rig
from slider_drilling.units import Text

_NOT_FITTED = "scanned only: other changes looked more promising"


def change_diagnosis(
    after: Sequence[RigLog], rig: Rig, checks: tuple[LogChecks, ...], search: ChangeSearch, answer: ChangeAnswer,
    baseline: Baseline, remarks: Sequence[Text],
) -> Diagnosis:  # fmt: skip
    """The diagnosis of later logs, without what it says of the baseline (`Diagnosis.change`)."""
    named = answer.named
    return Diagnosis(
        logs=tuple(log.source for log in after), rig=rig, rig_source=find_rig_source(after, rig), log_checks=checks,
        verdict=answer.verdict, site=answer.site, effects=() if named is None else (named.effect.name,),
        suspected=answer.suspected, gap=_gap(search, answer, baseline), ranking=_ranking(search, answer),
        tuned_parameters=_parameters(search, answer), traces=_traces(search, answer),
        simulations=search.problem.counter.count, remarks=tuple(remarks),
    )  # fmt: skip


def _stages(search: ChangeSearch, answer: ChangeAnswer) -> dict[str, Array]:
    """(N,) residual of each stage."""
    stages = {"nominal": search.unchanged.residual, "tuned": search.calibrated.residual}
    if answer.named is not None:
        stages["with_effect"] = answer.named.fit.residual
    return stages


def _gap(search: ChangeSearch, answer: ChangeAnswer, baseline: Baseline) -> Gap:
    closed = interval = None
    if answer.named is not None:
        closed, interval = share_explained(search.problem, search.calibrated.residual, answer.named.fit.residual)
    channels = {piece.name: piece.channel for piece in search.problem.pieces}
    rms = {stage: rms_by_channel(search.problem, residual) for stage, residual in _stages(search, answer).items()}
    final = _stages(search, answer)[list(_stages(search, answer))[-1]]
    return Gap(
        nominal=answer.gaps[0], tuned=answer.gaps[1], with_effect=answer.gaps[2], closed=closed,
        closed_interval=interval, threshold=SAME_AS_BEFORE,
        noise_floor={
            name: ChannelNoise(floor.sigma, floor.declared, channels[name].unit, floor.method)
            for name, floor in baseline.noise.items() if name in channels
        },
        rms={
            name: ChannelErrors(channel.unit, *(rms.get(stage, {}).get(name) for stage in STAGES))
            for name, channel in channels.items()
        },
        misfit_channels=tuple(
            name for name, gap in usual_gaps(search.problem, final).items() if gap > SAME_AS_BEFORE
        ),
    )  # fmt: skip


def _ranking(search: ChangeSearch, answer: ChangeAnswer) -> tuple[RankedEffect, ...]:
    """Fitted candidates, the named one first, then those that were scanned alone."""
    ranking = [_ranked(search, answer, tried) for tried in search.tried]
    ranking.sort(key=lambda each: not each.in_answer)
    fitted = {each.effect for each in ranking}
    sites = {effect.name: effect.site for effect in changed_model(search).effects}
    ranking += [
        RankedEffect(name, sites[name], False, False, (_NOT_FITTED,), None, None, {}, ())
        for name in search.scanned if name not in fitted
    ]  # fmt: skip
    return tuple(ranking)


def _ranked(search: ChangeSearch, answer: ChangeAnswer, tried: TriedChange) -> RankedEffect:
    named = answer.named is not None and tried.effect.name == answer.named.effect.name
    failed = answer.refused.get(tried.effect.name, "")
    closed, interval = share_explained(search.problem, search.calibrated.residual, tried.fit.residual)
    why_not = () if named else (failed or _why_not(tried, answer),)
    return RankedEffect(
        tried.effect.name, tried.effect.site, not failed, named, why_not, closed, interval, _effect_parameters(tried),
        answer.group if named else (), suspected=tried.effect.name in answer.suspected,
    )  # fmt: skip


def _why_not(tried: TriedChange, answer: ChangeAnswer) -> str:
    if answer.named is None:
        return "several changes explain the difference equally well"
    if tried.effect.name in answer.group:
        return f"this log cannot distinguish it from {plain_name(answer.named.effect.name)}"
    return f"{plain_name(answer.named.effect.name)} explains more"


def _effect_parameters(tried: TriedChange) -> dict[str, FittedParameter]:
    return parameters_of_fit(tried.problem, tried.fit, f"{tried.effect.name}.")


def _parameters(search: ChangeSearch, answer: ChangeAnswer) -> dict[str, FittedParameter]:
    """Everything that was fitted or shared, by the names that users know; nominal: the baseline's value."""
    found = search.calibrated if answer.named is None else answer.named.fit
    problem = search.problem if answer.named is None else answer.named.problem
    intervals = parameter_intervals(problem, found)
    values = user_values(problem, {**all_values(changed_model(search), found), **found.values})
    known = {parameter.name: parameter for parameter in found.parameters} | dict(changed_model(search).user_parameters)
    return {
        name: FittedParameter(value, known[name].unit, known[name].nominal, intervals.get(name))
        for name, value in values.items() if name in known
    }  # fmt: skip


def _traces(search: ChangeSearch, answer: ChangeAnswer) -> tuple[ChannelTrace, ...]:
    traces = []
    for piece in search.problem.pieces:
        channel = piece.channel
        simulated = {
            stage: channel.measured - residual[piece.rows] * piece.noise
            for stage, residual in _stages(search, answer).items()
        }
        traces.append(ChannelTrace(piece.run, channel.name, channel.unit, channel.time, channel.measured, simulated))
    return tuple(traces)
