"""A diagnosis that was written to disk, as the start of the next: its logs, and what may explain them."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from slider_drilling.diagnosis.build_model import build_model
from slider_drilling.diagnosis.drill_string import DrillString
from slider_drilling.errors import InputError
from slider_drilling.files.output_files import read_text
from slider_drilling.gap.experiment_design.knowledge import Explanation, Knowledge, after_fit
from slider_drilling.log import RigLog
from slider_drilling.log_checks import check_log
from slider_drilling.rig import Rig

_FILE = "diagnosis.json"
_SCHEMA = "slider_drilling/diagnosis/"


@dataclass(frozen=True)
class EarlierAnswer:
    """What a diagnosis said.

    Attributes:
        source: Where it was read.
        logs: Paths of its logs.
        verdict: Its verdict.
        effects: Effects that it named.
        explanations: What may explain its logs, the answer first; empty where nothing was fitted.
    """

    source: str
    logs: tuple[str, ...]
    verdict: str
    effects: tuple[str, ...]
    explanations: tuple[Explanation, ...]


def read_earlier_answer(path: Path) -> EarlierAnswer:
    """Read a diagnosis.

    Args:
        path: diagnosis.json, or its folder.

    Raises:
        InputError: It is no diagnosis, or one of a version without explanations.
    """
    file = path / _FILE if path.is_dir() else path
    try:
        tree = json.loads(read_text(file, "diagnosis"))
    except ValueError:
        raise InputError(f"{file}: not a diagnosis: give a diagnosis.json, its folder, or a log") from None
    return earlier_answer(tree, str(file))


def read_result_tree(path: Path) -> dict[str, Any]:
    """The tree that a job of a campaign returned, from the file of its result. Raises InputError."""
    try:
        tree: dict[str, Any] = json.loads(read_text(path, "result"))["result"]
    except (ValueError, KeyError, TypeError):
        raise InputError(f"{path}: not a result; delete it and run again") from None
    return tree


def earlier_answer(tree: Mapping[str, Any], source: str) -> EarlierAnswer:
    """The answer in a tree of diagnosis.json; ``source`` names it in errors. Raises InputError."""
    if not isinstance(tree, Mapping) or not str(tree.get("schema", "")).startswith(_SCHEMA):
        raise InputError(f"{source}: not a diagnosis: give a diagnosis.json, its folder, or a log")
    if "explanations" not in tree:
        raise InputError(f"{source}: holds no explanations: an older version wrote it; diagnose the logs again")
    log = tree["log"]
    try:
        return EarlierAnswer(
            source, tuple([log] if isinstance(log, str) else log), str(tree["verdict"]), tuple(tree["effects"]),
            tuple(
                Explanation(tuple(each["effects"]), float(each["weight"]), _numbers(each["parameters"]),
                            int(each["fidelity"]))
                for each in tree["explanations"]
            ),
        )  # fmt: skip
    except (KeyError, TypeError, ValueError):
        raise InputError(f"{source}: explanations: damaged; diagnose the logs again") from None


def _numbers(tree: Mapping[str, Any]) -> dict[str, float]:
    return {str(name): float(value) for name, value in tree.items()}


def knowledge_of(answer: EarlierAnswer, logs: Sequence[RigLog], rig: Rig) -> tuple[DrillString, Knowledge]:
    """The model of an answer's logs, and what they tell.

    Args:
        answer: An answer with explanations.
        logs: Its logs, in its order.
        rig: Its rig file.

    Raises:
        InputError: A log cannot be used.
    """
    checks = [check_log(log, rig) for log in logs]
    for checked in checks:
        checked.raise_if_unusable()
    model = build_model([checked.log for checked in checks], rig).model
    known = {effect.name for effect in model.effects}
    explanations = [each for each in answer.explanations if set(each.effects) <= known]
    if not explanations:
        raise InputError(f"{answer.source}: explanations: none of effects that this version knows")
    return model, after_fit(model, explanations)
