"""A diagnosis that was written to disk, as the start of the next: its logs, and what may explain them."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from slider_drilling.diagnosis.build_model import build_model
from slider_drilling.diagnosis.drill_string import DrillString
from slider_drilling.errors import InputError
from slider_drilling.files.output_files import read_text
from slider_drilling.gap.experiment_design.knowledge import Explanation, Knowledge, after_fit
from slider_drilling.log import RigLog
from slider_drilling.log_checks import check_log
from slider_drilling.rig import Rig, dump_rig, parse_rig
from slider_drilling.rig.rig_file import rig_tree

_FILE = "diagnosis.json"
_SCHEMA = "slider_drilling/diagnosis/"
_SHOWN_KEYS = 4


@dataclass(frozen=True)
class EarlierAnswer:
    """What a diagnosis said.

    Attributes:
        source: Where it was read.
        logs: Paths of its logs.
        verdict: Its verdict.
        effects: Effects that it named.
        explanations: What may explain its logs, the answer first; empty where nothing was fitted.
        rig_text: The rig file that it was made with; None where an older version wrote it.
    """

    source: str
    logs: tuple[str, ...]
    verdict: str
    effects: tuple[str, ...]
    explanations: tuple[Explanation, ...]
    rig_text: str | None = field(default=None, repr=False)

    def rig(self) -> Rig | None:
        """The rig file that it was made with; None where an older version wrote it. Raises InputError."""
        return None if self.rig_text is None else parse_rig(self.rig_text, f"{self.source}: rig_file")

    def check_rig(self, rig: Rig) -> None:
        """Check that a rig is the one that the diagnosis was made with. Raises InputError, saying what differs."""
        if self.rig_text is None or self.rig_text == dump_rig(rig):
            return
        own = self.rig()
        differs = [] if own is None else list(_differing_keys(rig_tree(own), rig_tree(rig)))
        if differs:
            more = ", ..." if len(differs) > _SHOWN_KEYS else ""
            raise InputError(f"{self.source}: was made with another rig file, which differs in "
                             f"{', '.join(differs[:_SHOWN_KEYS])}{more}; give that one, or leave this diagnosis out")


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
            _rig_text(tree),
        )  # fmt: skip
    except (KeyError, TypeError, ValueError):
        raise InputError(f"{source}: explanations: damaged; diagnose the logs again") from None


def _rig_text(tree: Mapping[str, Any]) -> str | None:
    """The rig file in a tree of diagnosis.json. Raises TypeError where it is no text."""
    text = tree.get("rig_file")
    if text is not None and not isinstance(text, str):
        raise TypeError
    return text


def _differing_keys(first: Any, second: Any, above: str = "") -> Iterator[str]:
    """Keys of two rig files that differ, such as ``string.length``."""
    if isinstance(first, Mapping) and isinstance(second, Mapping):
        for key in dict.fromkeys((*first, *second)):
            yield from _differing_keys(first.get(key), second.get(key), f"{above}.{key}" if above else str(key))
    elif first != second:
        yield above


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
