"""What the engine answers, as the outcome that is told."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from slider_drilling.diagnosis.outcome import (
    Candidate,
    Errors,
    Fitted,
    Floor,
    Gap,
    Interval,
    NextManoeuvre,
    Outcome,
    Trace,
    Where,
)
from slider_drilling.gap.beyond import Beyond
from slider_drilling.gap.explain import Answer, Ranked
from slider_drilling.gap.model import Effect, Model, Parameter

NOT_FITTED = "not fitted: its score test promised less than that of others"
# Widest interval of a share that still says something: beyond, what it is a share of is hardly there.
_WIDEST = 2.0


def outcome_of(answer: Answer, model: Model, beyond: Beyond, effects: Sequence[Effect]) -> Outcome:
    """The engine's answer about a model's runs; effects: every candidate, for the units of their parameters."""
    known = {parameter.name: parameter for parameter in model.nuisance}
    known |= {parameter.name: parameter for effect in effects for parameter in effect.parameters}
    manoeuvre, where = answer.manoeuvre, answer.where
    return Outcome(
        verdict=answer.verdict,
        site=answer.site,
        effects=answer.effects,
        partial=answer.partial,
        gap=_gap(answer, model),
        where=None if where is None else Where(
            where.channel, where.phase, where.band, tuple(where.time), tuple(where.depth)
        ),
        ranking=tuple(_candidate(entry, answer, known) for entry in answer.ranking),
        next_manoeuvre=None if manoeuvre is None else NextManoeuvre(
            manoeuvre.description, manoeuvre.settings, manoeuvre.separates, manoeuvre.distance, manoeuvre.now,
            manoeuvre.others,
        ),
        tuned_parameters=_fitted(answer.parameters, known),
        remarks=answer.remarks,
        simulated=beyond.figures(),
        traces=_traces(beyond),
        runtime=answer.runtime,
    )  # fmt: skip


def _gap(answer: Answer, model: Model) -> Gap:
    channels = {channel.name: channel for run in model.runs for channel in run.channels}
    floors = {name: floor for run in answer.floors for name, floor in run.items()}
    rms = _rms_by_stage(answer)
    shrinks = bool(answer.effects) and answer.with_effect < answer.tuned
    closed, interval = _share(answer.closed, answer.closed_interval, answer) if shrinks else (None, None)
    return Gap(
        nominal=_number(answer.nominal), tuned=_number(answer.tuned),
        with_effect=_number(answer.with_effect) if answer.effects else None,
        closed=closed, closed_interval=interval, threshold=_number(answer.threshold),
        noise_floor={
            name: Floor(floor.sigma, channels[name].declared_noise, channels[name].unit, floor.method)
            for name, floor in floors.items()
        },
        rms={
            name: Errors(channel.unit, *(rms.get(stage, {}).get(name) for stage in ("nominal", "tuned", "with_effect")))
            for name, channel in channels.items()
        },
    )  # fmt: skip


def _share(closed: float, interval: Interval, answer: Answer) -> tuple[float | None, Interval | None]:
    """A share of the gap where there is a gap to be a share of and the gap shrinks, None elsewhere."""
    if math.isnan(closed) or closed <= 0.0 or not answer.tuned > max(answer.threshold, 1.0):
        return None, None
    if math.isnan(interval[0]):
        return closed, None
    return (None, None) if interval[1] - interval[0] > _WIDEST else (closed, interval)


def _candidate(entry: Ranked, answer: Answer, known: dict[str, Parameter]) -> Candidate:
    in_answer = entry.effect in answer.effects
    # What a score test promises is no share that any fit has closed.
    closed, interval = _share(entry.closed, entry.interval, answer) if entry.fitted else (None, None)
    why_not = entry.reasons
    if not in_answer and not entry.fitted:
        why_not = (NOT_FITTED,)
    elif not in_answer and not why_not and answer.effects:
        why_not = (f"what it explains, {' and '.join(answer.effects)} explains better",)
    if in_answer:
        why_not = ()
    return Candidate(
        entry.effect, entry.site, entry.accepted, in_answer, why_not, closed, interval,
        _fitted(entry.parameters, known), entry.group,
    )  # fmt: skip


def _fitted(values: dict[str, float], known: dict[str, Parameter]) -> dict[str, Fitted]:
    found = {}
    for name, value in values.items():
        # What belongs to a run carries its number: start_twist@0.
        parameter = known.get(name) or known.get(name.partition("@")[0])
        unit, nominal = (parameter.unit, parameter.nominal) if parameter else ("-", math.nan)
        found[name] = Fitted(value, unit, nominal)
    return found


def _rms_by_stage(answer: Answer) -> dict[str, dict[str, float]]:
    """RMS of each channel at each stage; held out where parameters were fitted."""
    findings = answer.findings
    problem = findings.problem
    left = {"nominal": problem.floor * findings.nominal_residual}
    if findings.tuned is not None:
        left["tuned"] = findings.tuned.problem.floor * findings.tuned.score.residual
    if findings.current is not None and findings.accepted:
        left["with_effect"] = findings.current.problem.floor * findings.current.score.residual
    return {
        stage: {name: float(np.sqrt(square)) for name, square in problem.by_channel(residual**2).items()}
        for stage, residual in left.items()
    }


def _traces(beyond: Beyond) -> tuple[Trace, ...]:
    problem = beyond.problem
    found = []
    for index, run in enumerate(problem.model.runs):
        until = run.time[0] + beyond.share * run.duration if beyond.rest else None
        for channel in run.channels:
            part = problem.slices[index, channel.name]
            simulated = {stage: channel.measured - left[part] for stage, left in beyond.left.items()}
            found.append(Trace(index, channel.name, channel.unit, channel.time, channel.measured, simulated, until))
    return tuple(found)


def _number(value: float) -> float | None:
    return None if math.isnan(value) else value
