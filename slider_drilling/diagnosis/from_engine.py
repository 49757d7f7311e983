"""What the engine answers, as the outcome that is told."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from slider_drilling.diagnosis.describe_curve import describe_curve
from slider_drilling.diagnosis.result import (
    ChannelErrors,
    ChannelNoise,
    ChannelTrace,
    ClosedShare,
    FittedParameter,
    Gap,
    Interval,
    NextManoeuvre,
    Outcome,
    RankedEffect,
    ResidualShape,
    ShapeOf,
    Where,
)
from slider_drilling.gap.evidence.compare import shrinks
from slider_drilling.gap.evidence.free_forms import FreeFormFit
from slider_drilling.gap.explain import GapDiagnosis
from slider_drilling.gap.model import Effect, Model
from slider_drilling.gap.problem.noise import is_white
from slider_drilling.gap.results.intervals import parameter_intervals, user_parameters, user_values
from slider_drilling.gap.results.whole_runs import WholeRunErrors
from slider_drilling.gap.selection.state import CandidateResult, FittedModel

STAGES = ("nominal", "tuned", "with_effect")
NOT_FITTED = "fell behind in the race: others explained more with as many trials"
# Widest interval of a share that still says something: beyond, what it is a share of is hardly there.
_WIDEST = 2.0


def outcome_of(answer: GapDiagnosis, model: Model, beyond: WholeRunErrors, effects: Sequence[Effect]) -> Outcome:
    """The engine's answer about a model's runs; effects: every candidate, for those that were not followed."""
    manoeuvre, where, state = answer.next_manoeuvre, answer.breakdown, answer.state
    return Outcome(
        verdict=answer.verdict,
        site=answer.site,
        effects=answer.effects,
        instead=answer.masked_effects,
        partial=state.interrupted,
        gap=_gap(answer, model),
        where=None if where is None else Where(
            where.channel, where.phase, where.band, tuple(where.time), tuple(where.depth)
        ),
        shape=_shape(answer),
        ranking=_ranking(answer, effects),
        next_manoeuvre=None if manoeuvre is None else NextManoeuvre(
            manoeuvre.description, manoeuvre.settings, manoeuvre.separates, manoeuvre.distance,
            manoeuvre.distance_in_log, manoeuvre.all_distances,
        ),
        tuned_parameters=_fitted(state.current),
        horizon=beyond.horizon,
        foretold=beyond.predictable_to_end,
        counts={"simulations": answer.simulation_count, "not_refitted": state.current.score.unrefitted_folds},
        remarks=answer.remarks,
        simulated=beyond.figures(),
        traces=_traces(beyond),
        runtime=answer.runtime,
    )  # fmt: skip


def _gap(answer: GapDiagnosis, model: Model) -> Gap:
    channels = {channel.name: channel for run in model.runs for channel in run.channels}
    floors = {name: floor for run in answer.state.floors for name, floor in run.items()}
    rms = _rms_by_stage(answer)
    shrinks = bool(answer.effects) and answer.gap_with_effects < answer.gap_calibrated
    closed, interval = _share(answer.closed, answer.closed_interval, answer) if shrinks else (None, None)
    return Gap(
        nominal=answer.gap_nominal, tuned=answer.gap_calibrated,
        with_effect=answer.gap_with_effects if answer.effects else None,
        closed=closed, closed_interval=interval, threshold=answer.null_threshold,
        stand_out=answer.misfit_channels,
        noise_floor={
            name: ChannelNoise(
                floor.sigma, floor.declared, channels[name].unit, floor.method, _white(answer, name), floor.excess
            )
            for name, floor in floors.items()
        },
        rms={
            name: ChannelErrors(channel.unit, *(rms.get(stage, {}).get(name) for stage in STAGES))
            for name, channel in channels.items()
        },
    )  # fmt: skip


def _white(answer: GapDiagnosis, channel: str) -> bool | None:
    """Whether the final model leaves white noise of a channel in every run, None where no run can tell."""
    known = answer.state.current
    told = [is_white(known.fit.residual[p.rows]) for p in known.problem.pieces if p.name == channel]
    sure = [one for one in told if one is not None]
    return all(sure) if sure else None


def _share(closed: float, interval: Interval, answer: GapDiagnosis) -> tuple[float | None, Interval | None]:
    """A share of the gap where there is a gap to be a share of and the gap shrinks, None elsewhere."""
    if math.isnan(closed) or closed <= 0.0 or not answer.gap_calibrated > max(answer.null_threshold, 1.0):
        return None, None
    if math.isnan(interval[0]):
        return closed, None
    return (None, None) if interval[1] - interval[0] > _WIDEST else (closed, interval)


def _ranking(answer: GapDiagnosis, effects: Sequence[Effect]) -> tuple[RankedEffect, ...]:
    """Who was fitted to the end, accepted ones first, then who fell behind, most promising first."""
    groups = answer.indistinguishable
    found: list[RankedEffect] = []
    for one in answer.candidates:
        new = _new(one, answer, {c.effect for c in found})
        stayed = [effect.name for effect in new if effect.name in answer.effects]
        found += [_candidate(one, effect, answer, groups, stayed) for effect in new]
    named = {one.effect for one in found}
    promised = answer.state.steps[0].predicted_gain if answer.state.steps else {}
    rest = sorted((e for e in effects if e.name not in named), key=lambda e: -promised.get(e.name, 0.0))
    nothing = "not looked for: what re-tuning leaves is no more than noise leaves"
    why = NOT_FITTED if answer.state.steps else nothing
    found += [RankedEffect(e.name, e.site, False, False, (why,), None, None, {}, ()) for e in rest]
    return tuple(found)


def _new(one: CandidateResult, answer: GapDiagnosis, told: set[str]) -> list[Effect]:
    """The effects that a finalist stands for: of those that were accepted together all that stayed in the answer."""
    stayed = answer.effects if _accepted(one, answer) else ()
    return [e for e in one.fitted.effects if e.name not in told and (e.name == one.effect.name or e.name in stayed)]


def _accepted(one: CandidateResult, answer: GapDiagnosis) -> bool:
    return any(one is taken.accepted for taken in answer.state.steps)


def _candidate(
    one: CandidateResult, effect: Effect, answer: GapDiagnosis, groups: Mapping[str, tuple[str, ...]],
    stayed: Sequence[str],
) -> RankedEffect:  # fmt: skip
    """What is told of an effect: of one in the answer the final model's parameters, and no share where it was found
    beside others only, for alone it closes another. stayed: those in the answer that the finalist brought.
    """
    name = effect.name
    in_answer = name in answer.effects
    closed, interval, beside = _closes(one, answer) if in_answer else _closed_beside(one, answer)
    why_not = one.failures
    if not in_answer and not why_not:
        why_not = (_outdone(one, answer),)
    return RankedEffect(
        name, effect.site, one.passed, in_answer, () if in_answer else why_not, closed, interval,
        _fitted(answer.state.current if in_answer else one.fitted, f"{name}."), groups.get(name, ()),
        _in_other_runs(one, answer), tuple(other for other in stayed if in_answer and other != name),
        beside,
    )  # fmt: skip


def _outdone(one: CandidateResult, answer: GapDiagnosis) -> str:
    """Why an effect that passes its own tests is not in the answer."""
    like = [name for name in answer.effects if one.effect.name in answer.indistinguishable.get(name, ())]
    if like:
        return f"this log does not tell it from {' and '.join(like)}"
    better = " and ".join(answer.effects) or (answer.alternative.description if answer.alternative is not None else "")
    if better:
        return f"what it explains, {better} {'explain' if len(answer.effects) > 1 else 'explains'} better"
    if answer.verdict != "unknown":
        return "what remains is no more than noise"
    accepted = next((taken.accepted for taken in answer.state.steps if taken.accepted is not None), None)
    if accepted is not None and accepted is not one:
        return f"{accepted.effect.name} explains more, and is no cause for certain either"
    tuned = answer.state.calibrated.score
    if not shrinks(answer.state.bootstrap, tuned, one.fitted.score):
        return "of what re-tuning leaves the gap does not shrink for certain"
    return "something that no law describes foretells more"


def _in_other_runs(one: CandidateResult, answer: GapDiagnosis) -> ClosedShare | None:
    if one.closed_in_other_runs is None:
        return None
    closed, interval = _share(*one.closed_in_other_runs, answer)
    return None if closed is None else ClosedShare(closed, interval)


# The share of a gap that is closed, its interval, and the effects that left this gap.
_Closed = tuple[float | None, Interval | None, tuple[str, ...]]


def _closes(one: CandidateResult, answer: GapDiagnosis) -> _Closed:
    """What an accepted finalist closed; what the whole answer does where what it began with was left out."""
    if not _accepted(one, answer):
        return None, None, ()
    names = one.fitted.names
    if names == answer.effects[: len(names)]:
        return _closed_beside(one, answer)
    whole = set(answer.effects) <= set(names)
    return (*_share(answer.closed, answer.closed_interval, answer), ()) if whole else (None, None, ())


def _closed_beside(one: CandidateResult, answer: GapDiagnosis) -> _Closed:
    """What a finalist closed beside what was known before it."""
    return (*_share(one.closed, one.interval, answer), one.beside)


def _fitted(explained: FittedModel, prefix: str = "") -> dict[str, FittedParameter]:
    """What was fitted, by the names that a user knows; prefix: of those to tell."""
    spans = parameter_intervals(explained.problem, explained.fit)
    values = user_values(explained.problem, explained.fit.values)
    return {
        name: FittedParameter(values[name], parameter.unit, parameter.nominal, spans.get(name))
        for name, parameter in user_parameters(explained.problem, explained.fit).items() if name.startswith(prefix)
    }  # fmt: skip


def _shape(answer: GapDiagnosis) -> ResidualShape | None:
    """What explains as much as the names, else what remains beside them, else what the unknown looks like."""
    if answer.alternative is not None:
        return _drawn("alternative" if answer.effects else "unknown", answer.alternative)
    return None if answer.remainder is None else _drawn("rest", answer.remainder)


def _drawn(of: ShapeOf, found: FreeFormFit) -> ResidualShape:
    told = describe_curve(found.description, found.x, found.x_unit, found.y, found.y_unit)
    x, y = _axes(found.description)
    return ResidualShape(of, told, f"{x}, {found.x_unit}", _y_label(y, found.y_unit), found.x, found.y)


def _y_label(off: str, unit: str) -> str:
    """What is off with its unit; a share is of what the model has there, whose name it has."""
    if unit != "-":
        return f"{off}, {unit}"
    return f"{off}, share" if off.endswith(" off") else f"change of {off}, share"


def _axes(words: str) -> tuple[str, str]:
    """What a disturbance is over, and what is off, from its words."""
    for between in (" over ", " by an amount that follows ", " by an amount that drifts with "):
        y, found, x = words.partition(between)
        if found:
            return x, y
    return "all of it", words


def _rms_by_stage(answer: GapDiagnosis) -> dict[str, dict[str, float]]:
    """RMS of each channel at each stage; held out where parameters were fitted."""
    state = answer.state
    left = {"nominal": state.nominal_score.residual, "tuned": state.calibrated.score.residual}
    if answer.effects:
        left["with_effect"] = state.current.score.residual
    found: dict[str, dict[str, float]] = {}
    for stage, residual in left.items():
        squares: dict[str, list[float]] = {}
        for piece in state.calibrated.problem.pieces:
            squares.setdefault(piece.name, []).extend((residual[piece.rows] * piece.noise) ** 2)
        found[stage] = {name: float(np.sqrt(np.mean(values))) for name, values in squares.items()}
    return found


def _traces(beyond: WholeRunErrors) -> tuple[ChannelTrace, ...]:
    found = []
    for piece in beyond.problem.pieces:
        run, channel = beyond.problem.model.runs[piece.run], piece.channel
        until = run.time[0] + beyond.share * run.duration if beyond.rest else None
        simulated = {stage: channel.measured - left[piece.rows] for stage, left in beyond.residuals.items()}
        found.append(
            ChannelTrace(piece.run, channel.name, channel.unit, channel.time, channel.measured, simulated, until)
        )
    return tuple(found)
