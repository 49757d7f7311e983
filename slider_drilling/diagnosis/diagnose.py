"""A diagnosis of logs: a first look, the engine, and what it found as an outcome and in sentences."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from slider_drilling.diagnosis import sentences
from slider_drilling.diagnosis.build_model import PreparedModel, build_model
from slider_drilling.diagnosis.drill_string import DrillString, rig_with
from slider_drilling.diagnosis.from_engine import outcome_of
from slider_drilling.diagnosis.result import Outcome
from slider_drilling.diagnosis.rig_source import RigSource, find_rig_source, rig_remarks
from slider_drilling.diagnosis.to_json import to_json
from slider_drilling.diagnosis.user_effects import UserEffect
from slider_drilling.errors import InputError
from slider_drilling.gap.explain import GapDiagnosis, explain
from slider_drilling.gap.model import Effect
from slider_drilling.gap.progress import Progress
from slider_drilling.gap.results.whole_runs import simulate_whole_runs
from slider_drilling.log import RigLog
from slider_drilling.log_checks import LogChecks, check_log
from slider_drilling.rig import Rig

__all__ = ["Diagnosis", "diagnose", "to_json", "tuned_rig"]

MIN_SAMPLES = 20  # of a log, for a fit to be of anything
_MORE = {
    "hook_load": "drawworks joint states (hook load) would show axial friction, heave and weight on bit",
    "standpipe_pressure": "standpipe pressure would show bit torque, motor wear and changes of formation",
    "tool_face": "MWD toolface would show how far the bit turns, and with it compliance and friction at depth",
}


@dataclass(frozen=True)
class Diagnosis:
    """What was found of logs, with what surrounds it: the rig file as given, what was noticed before any fit.

    prepared, answer: the model and the engine's own answer about it; None where the first look left nothing to fit.
    """

    logs: tuple[str, ...]
    rig: Rig
    rig_source: RigSource
    log_checks: tuple[LogChecks, ...]
    outcome: Outcome
    would_help: tuple[str, ...] = ()
    prepared: PreparedModel | None = field(default=None, repr=False)
    answer: GapDiagnosis | None = field(default=None, repr=False)

    @property
    def verdict(self) -> str:
        """none, parameters, effect, effect_and_unknown, unknown or inconclusive."""
        return self.outcome.verdict

    @property
    def driller(self) -> str:
        """The answer in the words of the rig floor."""
        return sentences.driller(self.outcome)

    @property
    def sentence(self) -> str:
        """The answer with code names and figures."""
        return sentences.sentence(self.outcome)

    @property
    def remarks(self) -> tuple[str, ...]:
        """Everything a reader should know besides: of the rig file, of the logs, of the fits."""
        noticed = [
            f"{look.log.source}: {f.text}" for look in self.log_checks for f in look.issues if f.severity == "note"
        ]
        of_rig = rig_remarks(self.rig_source, [look.log for look in self.log_checks], self.rig)
        of_model = self.prepared.remarks if self.prepared is not None else ()
        return (*of_rig, *noticed, *of_model, *self.outcome.remarks)


def diagnose(
    logs: Sequence[RigLog],
    rig: Rig,
    *,
    seed: int = 0,
    user_effects: Sequence[UserEffect] = (),
    only: Sequence[str] = (),
    until: float = 1.0,
    progress: Progress = lambda stage, share: None,
) -> Diagnosis:
    """Diagnose logs of one rig.

    only: names of the effects to consider, all that the log can show if empty. until: the first share of every log
    that is fitted; what follows is only looked at in the end. Raises InputError for a log that the first look refuses,
    where no channel can be used, and for an unknown name in ``only``. Logs that excite too little are `inconclusive`
    at once.
    """
    if not 0.0 < until <= 1.0:
        raise InputError(f"--until {until:g}: must be above 0 and at most 1")
    looks = tuple(check_log(log, rig) for log in logs)
    for look in looks:
        look.raise_if_unusable()
    sources, origin = tuple(log.source for log in logs), find_rig_source(logs, rig)
    idle = [why for look in looks for why in look.messages("uninformative")]
    if all(look.messages("uninformative") for look in looks):
        return Diagnosis(sources, rig, origin, looks, Outcome("inconclusive", remarks=tuple(idle)))
    prepared = build_model([look.log for look in looks], rig, user_effects)
    whole = prepared.model
    model = whole if until == 1.0 else _first_share(whole, until, sources)
    prepared = replace(prepared, model=model)
    seen = {channel.name for run in model.runs for channel in run.channels}
    candidates = _candidates(prepared, only)
    answer = explain(model, seed=seed, starts=_starts(prepared), effects=candidates, progress=progress)
    outcome = outcome_of(answer, whole, simulate_whole_runs(whole, answer.state, until), candidates)
    would_help = tuple(sentence for name, sentence in _MORE.items() if name not in seen)
    return Diagnosis(sources, rig, origin, looks, outcome, would_help, prepared, answer)


def _first_share(whole: DrillString, until: float, sources: Sequence[str]) -> DrillString:
    model = whole.truncated(until)
    for run, source in zip(model.runs, sources, strict=True):
        if run.time.size < MIN_SAMPLES or not run.channels:
            raise InputError(f"--until {until:g}: leaves {run.time.size} samples of {source}; give a larger share")
    return model


def _candidates(prepared: PreparedModel, only: Sequence[str]) -> list[Effect]:
    known = {effect.name: effect for effect in prepared.model.effects}
    for name in only:
        if name not in known:
            raise InputError(f"--only {name}: not an effect that this log can show: {', '.join(known)}")
    return [known[name] for name in only] or list(known.values())


def _starts(prepared: PreparedModel) -> list[dict[str, float]]:
    """Where tuning begins: nominal; and, where nothing shows how the string was wound at the start, other twists."""
    model = prepared.model
    wound = any(_start_torque(prepared, run) for run in range(len(model.runs)))
    return [{}, {f"start_twist@{run}": -4.0 for run in range(len(model.runs))}] if wound else [{}]


def _start_torque(prepared: PreparedModel, run: int) -> bool:
    """Whether the log starts with torque in the string, or with no torque channel to tell."""
    for channel in prepared.model.runs[run].channels:
        if channel.name == "surface_torque":
            first = channel.measured[: max(channel.measured.size // 200, 5)]
            return abs(float(np.median(first))) > 0.1 * float(np.std(channel.measured))
    return True


def tuned_rig(diagnosis: Diagnosis) -> Rig:
    """The rig with fitted nuisance and accepted effects; what belongs to one run only (start twist) is not in it."""
    fitted = diagnosis.outcome.tuned_parameters
    return rig_with(diagnosis.rig, {name: one.value for name, one in fitted.items() if "@" not in name})
