"""A diagnosis of logs on disk: diagnosis.json (schema slider_drilling/diagnosis/1), rig.tuned.yaml, report.html."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from slider_drilling import __version__
from slider_drilling.diagnosis.drill_string import rig_with
from slider_drilling.diagnosis.first_look import FirstLook, first_look
from slider_drilling.diagnosis.situation import Prepared, prepare
from slider_drilling.diagnosis.user_effects import UserEffect
from slider_drilling.errors import InputError
from slider_drilling.files import make_folder, write_whole
from slider_drilling.gap.beyond import Beyond, look_beyond
from slider_drilling.gap.explain import Answer, Ranked, explain
from slider_drilling.gap.model import Effect
from slider_drilling.gap.progress import Progress
from slider_drilling.log import RigLog
from slider_drilling.rig import Rig, dump_rig

SCATTER = 512
FILES = ("diagnosis.json", "rig.tuned.yaml", "report.html")
SCHEMA = "slider_drilling/diagnosis/1"
_MORE = {
    "hook_load": "draw-works joint states (hook load) would show axial friction, heave and weight on bit",
    "standpipe_pressure": "standpipe pressure would show bit torque, motor wear and changes of formation",
    "tool_face": "MWD tool-face would show how far the bit turns, and with it compliance and friction at depth",
}


@dataclass(frozen=True)
class Diagnosis:
    """An answer with what surrounds it: the logs, the rig file as given, what was noticed before any fit."""

    logs: tuple[str, ...]
    rig: Rig
    prepared: Prepared
    answer: Answer
    beyond: Beyond
    verdict: str
    sentence: str
    looks: tuple[FirstLook, ...]
    would_help: tuple[str, ...]

    @property
    def remarks(self) -> tuple[str, ...]:
        """What was noticed of the logs before any fit."""
        noticed = [f"{look.log.source}: {f.text}" for look in self.looks for f in look.findings if f.weight != "refuse"]
        return (*noticed, *self.prepared.remarks)


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
    """Diagnose logs of one rig. Raises InputError where no channel can be used, or for an unknown name in ``only``.

    only: names of the effects to consider, all that the log can show if empty. until: the first share of every log
    that is fitted; what follows is only looked at in the end (`Diagnosis.beyond`).
    What the first look refuses is an InputError before anything is fitted; logs that excite too little make the verdict
    ``inconclusive`` whatever the fits say.
    """
    if not 0.0 < until <= 1.0:
        raise InputError(f"--until {until:g}: must be above 0 and at most 1")
    looks = tuple(first_look(log, rig) for log in logs)
    for look in looks:
        look.refuse()
    logs = [look.log for look in looks]
    prepared = prepare(logs, rig, user_effects)
    whole = prepared.model
    model = whole if until == 1.0 else whole.shortened(until)
    prepared = replace(prepared, model=model)
    idle = [why for look in looks for why in look.texts("stop")]
    nothing = all(look.texts("stop") for look in looks)
    candidates = [] if nothing else _candidates(prepared, only)
    # A record of torque alone is short to simulate and often stick-slip: worth a search before the fits.
    alone = {channel.name for run in model.runs for channel in run.channels} == {"surface_torque"}
    scatter = SCATTER if alone else 0
    answer = explain(model, seed=seed, starts=_starts(prepared), effects=candidates, scatter=scatter, progress=progress)
    verdict, sentence = answer.verdict, answer.sentence
    if nothing:
        verdict = "inconclusive"
        sentence = f"No conclusion: {'; '.join(idle)}."
    seen = {channel.name for run in model.runs for channel in run.channels}
    would_help = tuple(sentence for name, sentence in _MORE.items() if name not in seen)
    return Diagnosis(
        tuple(log.source for log in logs), rig, prepared, answer, look_beyond(whole, answer.findings, until),
        verdict, sentence, looks, would_help,
    )  # fmt: skip


def _candidates(prepared: Prepared, only: Sequence[str]) -> list[Effect]:
    known = {effect.name: effect for effect in prepared.model.effects}
    for name in only:
        if name not in known:
            raise InputError(f"--only {name}: not an effect that this log can show: {', '.join(known)}")
    return [known[name] for name in only] or list(known.values())


def _starts(prepared: Prepared) -> list[dict[str, float]]:
    """Where tuning begins: nominal; and, where nothing shows how the string was wound at the start, other twists."""
    model = prepared.model
    wound = any(_start_torque(prepared, run) for run in range(len(model.runs)))
    return [{}, {f"start_twist@{run}": -4.0 for run in range(len(model.runs))}] if wound else [{}]


def _start_torque(prepared: Prepared, run: int) -> bool:
    """Whether the log starts with torque in the string, or with no torque channel to tell."""
    for channel in prepared.model.runs[run].channels:
        if channel.name == "surface_torque":
            first = channel.measured[: max(channel.measured.size // 200, 5)]
            return abs(float(np.median(first))) > 0.1 * float(np.std(channel.measured))
    return True


def tuned_rig(diagnosis: Diagnosis) -> Rig:
    """The rig with fitted nuisance and accepted effects; what belongs to one run only (start twist) is not in it."""
    values = {name: value for name, value in diagnosis.answer.parameters.items() if "@" not in name}
    return rig_with(diagnosis.rig, values)


def as_json(diagnosis: Diagnosis) -> dict[str, Any]:
    """The tree of diagnosis.json; numbers that do not exist are null."""
    answer = diagnosis.answer
    where = answer.where
    manoeuvre = answer.manoeuvre
    tree = {
        "schema": SCHEMA,
        "version": __version__,
        "log": diagnosis.logs[0] if len(diagnosis.logs) == 1 else list(diagnosis.logs),
        "verdict": diagnosis.verdict,
        "sentence": diagnosis.sentence,
        "site": answer.site,
        "site_shares": answer.site_shares,
        "effects": list(answer.effects),
        "partial": answer.partial,
        "gap": {
            "nominal": answer.nominal,
            "tuned": answer.tuned,
            "with_effect": answer.with_effect,
            "closed": answer.closed,
            "closed_interval": list(answer.closed_interval),
            "null_threshold": answer.threshold,
            "noise_floor": {name: floor.sigma for name, floor in answer.floors[0].items()},
            "noise_method": {name: floor.method for name, floor in answer.floors[0].items()},
            "rms": rms_by_stage(answer),
        },
        "simulated": diagnosis.beyond.figures(),
        "where": None if where is None else {
            "channel": where.channel, "phase": where.phase, "band": where.band, "time": where.time,
            "depth": where.depth,
        },
        "ranking": [_ranked(entry) for entry in answer.ranking],
        "next_manoeuvre": None if manoeuvre is None else {
            "description": manoeuvre.description, "settings": manoeuvre.settings,
            "separates": list(manoeuvre.separates), "distance": manoeuvre.distance, "distance_now": manoeuvre.now,
            "others": manoeuvre.others,
        },
        "tuned_parameters": answer.parameters,
        "remarks": [*diagnosis.remarks, *answer.remarks],
        "would_help": list(diagnosis.would_help),
        "runtime_s": answer.runtime,
    }  # fmt: skip
    plain: dict[str, Any] = _without_nan(tree)
    return plain


def rms_by_stage(answer: Answer) -> dict[str, dict[str, float]]:
    """RMS of each channel in engineering units (SI) at each stage; held out where parameters were fitted."""
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


def _ranked(entry: Ranked) -> dict[str, Any]:
    short = {name.rpartition(".")[2]: value for name, value in entry.parameters.items()}
    return {
        "effect": entry.effect, "site": entry.site, "closed": entry.closed, "interval": list(entry.interval),
        "parameters": short, "group": list(entry.group), "fitted": entry.fitted, "accepted": entry.accepted,
        "physical": entry.physical, "starts_agree": entry.starts_agree, "round": entry.round,
        "rejected_because": list(entry.reasons),
    }  # fmt: skip


def _without_nan(tree: Any) -> Any:
    if isinstance(tree, dict):
        return {str(key): _without_nan(value) for key, value in tree.items()}
    if isinstance(tree, (list, tuple)):
        return [_without_nan(value) for value in tree]
    if isinstance(tree, (bool, str, int)) or tree is None:
        return tree
    number = float(tree)
    return number if np.isfinite(number) else None


def write_diagnosis(diagnosis: Diagnosis, folder: Path) -> list[Path]:
    """Write diagnosis.json, rig.tuned.yaml and report.html into a folder, which is made; the three paths.

    Each is written under a temporary name and renamed. Raises InputError where the folder cannot be written.
    """
    from slider_drilling.diagnosis.page import report_page

    make_folder(folder)
    contents = {
        "diagnosis.json": json.dumps(as_json(diagnosis), indent=1, allow_nan=False) + "\n",
        "rig.tuned.yaml": dump_rig(tuned_rig(diagnosis)),
        "report.html": report_page(diagnosis),
    }
    for name, text in contents.items():
        write_whole(folder / name, text.encode("utf-8"))
    return [folder / name for name in contents]
