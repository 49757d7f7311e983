"""Diagnose logs of one rig: check them, build the model, run the engine, fill the result."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from slider_drilling.diagnosis.build_model import build_model, model_without_logs
from slider_drilling.diagnosis.build_result import with_engine_result
from slider_drilling.diagnosis.catalogue import check_names
from slider_drilling.diagnosis.drill_string import DrillString
from slider_drilling.diagnosis.earlier_answer import EarlierAnswer
from slider_drilling.diagnosis.nuisance import START_TWISTS
from slider_drilling.diagnosis.result import Diagnosis
from slider_drilling.diagnosis.rig_source import find_rig_source, rig_remarks
from slider_drilling.diagnosis.rig_values import rig_with
from slider_drilling.diagnosis.user_effects import UserEffect
from slider_drilling.diagnosis.warm_start import calibration_start, with_earlier_starts
from slider_drilling.effects import EFFECTS
from slider_drilling.errors import InputError
from slider_drilling.gap.explain import explain
from slider_drilling.gap.model import Effect, Values
from slider_drilling.gap.progress import Progress
from slider_drilling.gap.results.next_manoeuvre import recommend_first_run
from slider_drilling.gap.results.whole_runs import simulate_whole_runs
from slider_drilling.log import RigLog
from slider_drilling.log_checks import check_log
from slider_drilling.rig import Rig
from slider_drilling.units import Text, sentence

MIN_SAMPLES = 20  # of each log that is fitted
# Torque at the start, in standard deviations of it, beyond which the string may have been twisted.
_TWISTED = 0.1
_TEST_S = 240.0  # of a test that is asked for where no log tells anything
_CALIBRATED_TOO = "{} is calibrated too: {} explains what no known effect does"
_MISSING_CHANNELS = {
    "hook_load": "hook load (effort of draw_works/joint_states) would show axial friction, heave and weight on bit",
    "standpipe_pressure": "standpipe pressure would show bit torque, motor wear and formation changes",
    "tool_face": "MWD toolface would show how far the bit turns, and so compliance and friction at depth",
}


def diagnose(
    logs: Sequence[RigLog],
    rig: Rig,
    *,
    seed: int = 0,
    user_effects: Sequence[UserEffect] = (),
    only: Sequence[str] = (),
    until: float = 1.0,
    after: EarlierAnswer | None = None,
    progress: Progress = lambda stage, share: None,
) -> Diagnosis:
    """Diagnose logs of one rig.

    Args:
        logs: One or several logs; several are fitted together.
        rig: The rig file as given.
        seed: Of the bootstrap and the replicates.
        user_effects: Effects beside the catalogue.
        only: Names of the effects to consider; all that the logs can show if empty.
        until: First share of every log that is fitted. The rest only shows how well the result predicts.
        after: The answer to some of these logs, or to other logs of the rig, to start from.
        progress: Called with the stage and the share done.

    Returns:
        The diagnosis; ``inconclusive`` without a fit if no log allows a conclusion: the rig is excited too little, or
        the angle was integrated from a coarse speed.

    Raises:
        InputError: A log is unusable, no channel can be used, or a name in `only` is unknown, or the earlier
            answer is that of another rig file.
    """
    if not 0.0 < until <= 1.0:
        raise InputError(f"until {until:g}: must be above 0 and at most 1")
    if after is not None:
        after.check_rig(rig)
    check_names(only, (*EFFECTS, *(user.effect.name for user in user_effects)))
    checks = tuple(check_log(log, rig) for log in logs)
    for checked in checks:
        checked.raise_if_unusable()
    diagnosis = Diagnosis(tuple(log.source for log in logs), rig, find_rig_source(logs, rig), checks, "inconclusive")
    remarks = _remarks_before_fit(diagnosis)
    if all(checked.messages("uninformative") for checked in checks):
        return _inconclusive(diagnosis, remarks, seed)
    prepared = build_model([checked.log for checked in checks], rig, user_effects)
    whole = prepared.model
    model = whole if until == 1.0 else _first_share(whole, until, diagnosis.logs)
    candidates = _candidates(model, only)
    starts = _calibration_starts(model)
    if after is not None:
        candidates = with_earlier_starts(candidates, after)
        starts = [calibration_start(after, diagnosis.logs), *starts[1:]]
    answer = explain(model, seed=seed, starts=starts, effects=candidates, progress=progress)
    found = [each for each in model.conditional_nuisance if each.parameters[0].name in answer.parameters]
    whole = whole.with_nuisance([parameter for each in found for parameter in each.parameters])
    remarks = (*remarks, *(_CALIBRATED_TOO.format(each.name, each.law) for each in found))
    channels = {channel.name for run in model.runs for channel in run.channels}
    diagnosis = replace(
        diagnosis,
        remarks=(*remarks, *prepared.remarks),
        missing_channels=tuple(text for name, text in _MISSING_CHANNELS.items() if name not in channels),
    )
    errors = simulate_whole_runs(whole, answer.state, until, answer.free_runs)
    return with_engine_result(diagnosis, answer, whole, errors, candidates)


def _inconclusive(diagnosis: Diagnosis, remarks: Sequence[Text], seed: int) -> Diagnosis:
    """The answer where no log allows a conclusion: why, and the test to run first."""
    notes = [*remarks, *(text for checked in diagnosis.log_checks for text in checked.messages("uninformative"))]
    reason = f"the {'log allows' if len(diagnosis.logs) == 1 else 'logs allow'} no conclusion"
    try:
        asked = recommend_first_run(model_without_logs(diagnosis.rig, _TEST_S), reason, seed)
    except ValueError as error:
        asked = None
        notes.append(f"no test can be planned: {error}")
    return replace(diagnosis, remarks=tuple(notes), next_manoeuvre=asked)


def _remarks_before_fit(diagnosis: Diagnosis) -> tuple[Text, ...]:
    """What the rig file and the checks of the logs say."""
    logs = [checked.log for checked in diagnosis.log_checks]
    notes = [
        sentence(f"{checked.log.source}: ", issue.text)
        for checked in diagnosis.log_checks for issue in checked.issues if issue.severity == "note"
    ]  # fmt: skip
    return (*rig_remarks(diagnosis.rig_source, logs, diagnosis.rig), *notes)


def _first_share(whole: DrillString, until: float, sources: Sequence[str]) -> DrillString:
    model = whole.truncated(until)
    for run, source in zip(model.runs, sources, strict=True):
        if run.time.size < MIN_SAMPLES or not run.channels:
            raise InputError(f"until {until:g}: leaves {run.time.size} samples of {source}; give a larger share")
    return model


def _candidates(model: DrillString, only: Sequence[str]) -> list[Effect]:
    known = {effect.name: effect for effect in model.effects}
    check_names(only, tuple(known))
    return [known[name] for name in only] or list(known.values())


def _calibration_starts(model: DrillString) -> list[Values]:
    """Where calibration starts: nominal, and with another twist if the string may have been twisted at the start."""
    runs = range(len(model.runs))
    if not any(_may_be_twisted(model, run) for run in runs):
        return [{}]
    return [{}, {f"start_twist@{run}": START_TWISTS[1] for run in runs}]


def _may_be_twisted(model: DrillString, run: int) -> bool:
    """Whether the log starts with torque in the string, or has no torque channel to show it."""
    for channel in model.runs[run].channels:
        if channel.name == "surface_torque":
            first = channel.measured[: max(channel.measured.size // 200, 5)]
            return abs(float(np.median(first))) > _TWISTED * float(np.std(channel.measured))
    return True


def tuned_rig(diagnosis: Diagnosis) -> Rig:
    """The rig with the fitted nuisance parameters and effects, without what belongs to one run (start twist)."""
    fitted = diagnosis.tuned_parameters
    return rig_with(diagnosis.rig, {name: parameter.value for name, parameter in fitted.items() if "@" not in name})
