"""A programme: its YAML file, read, checked and written. Nothing else parses programmes."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import yaml

from slider_drilling.errors import InputError
from slider_drilling.files.output_files import read_text
from slider_drilling.programmes.limits import StepLimits, check_bit
from slider_drilling.programmes.steps import ACTIONS, Action, Rock, Rotate, Slide, key_of
from slider_drilling.schema.fields import NumberField, build_dataclass, number_fields, quantity, to_tree
from slider_drilling.schema.yaml_tree import parse_yaml, shorten

SCHEMA = "slider_drilling/programme/1"
MAX_BYTES = 1_000_000
MAX_STEPS = 2000
_BESIDE_ACTION = ("limits", "note")


@dataclass(frozen=True)
class Step:
    """One step.

    Attributes:
        action: What is done.
        limits: That differ from the programme's.
        note: For the crew.
    """

    action: Action
    limits: StepLimits = StepLimits()
    note: str = ""

    @property
    def key(self) -> str:
        """Its key in the file, such as ``rock``."""
        return key_of(self.action)


@dataclass(frozen=True)
class _Header:
    """The keys of the file beside its steps."""

    schema: str = SCHEMA
    name: str = ""
    about: str = ""
    limits: StepLimits = StepLimits()
    drive_acceleration: float = quantity("rad/s2", 4.0, at_least=0.05, at_most=100.0, why="at starts and reversals")
    bit_height: float = quantity("m", 0.0, at_least=0.0, at_most=60.0, why="of the bit above bottom at the start")


@dataclass(frozen=True)
class Programme:
    """Steps in their order.

    Attributes:
        steps: At least one.
        name: For pages and logs.
        about: One line.
        limits: Of every step that does not give its own.
        drive_acceleration: Of the top drive at starts and reversals, rad/s2.
        bit_height: Of the bit above bottom at the start, m; 0: it just touches, without weight.
    """

    steps: tuple[Step, ...]
    name: str = ""
    about: str = ""
    limits: StepLimits = StepLimits()
    drive_acceleration: float = 4.0
    bit_height: float = 0.0


def load_programme(path: str | os.PathLike[str]) -> Programme:
    """Read a programme's file. Raises InputError naming file, key and value of what cannot be used."""
    return parse_programme(read_text(path, "programme", MAX_BYTES), str(path))


def parse_programme(text: str, source: str = "programme") -> Programme:
    """A programme from YAML text; ``source`` names the text in errors. Raises InputError."""
    tree = parse_yaml(text, source)
    if not isinstance(tree, dict):
        raise InputError(f"{source}: top level = {shorten(tree)}: expected keys and values")
    rest = {key: value for key, value in tree.items() if key != "steps"}
    header = build_dataclass(_Header, rest, source)
    if header.schema != SCHEMA:
        raise InputError(f"{source}: schema = {header.schema[:60]!r}: this version reads {SCHEMA!r}")
    if "steps" not in tree:
        raise InputError(f"{source}: steps: missing; add a list of steps, such as '- rest: {{time: 10 s}}'")
    steps = tree["steps"]
    if not isinstance(steps, list) or not 1 <= len(steps) <= MAX_STEPS:
        raise InputError(f"{source}: steps = {shorten(steps)}: expected a list of 1 to {MAX_STEPS} steps")
    check_bit(header.limits, source, "limits")
    built = tuple(_step(raw, source, f"steps[{index}]") for index, raw in enumerate(steps))
    programme = Programme(built, header.name, header.about, header.limits, header.drive_acceleration, header.bit_height)
    return check_programme(programme, source)


def dump_programme(programme: Programme) -> str:
    """The programme as YAML that `parse_programme` reads back unchanged."""
    steps = []
    for step in programme.steps:
        tree: dict[str, Any] = {step.key: to_tree(step.action)}
        if step.limits != StepLimits():
            tree["limits"] = to_tree(step.limits)
        if step.note:
            tree["note"] = step.note
        steps.append(tree)
    head = _Header(SCHEMA, programme.name, programme.about, programme.limits, programme.drive_acceleration,
                   programme.bit_height)  # fmt: skip
    header = to_tree(head)
    kept = {key: value for key, value in header.items() if value not in ("", {})}
    return yaml.safe_dump({**kept, "steps": steps}, sort_keys=False, width=120, default_flow_style=None)


def check_programme(programme: Programme, source: str = "programme") -> Programme:
    """Check relations between the numbers of each step, and return the programme.

    Raises:
        InputError: Naming source, step and key.
    """
    if not programme.steps:
        raise InputError(f"{source}: steps: empty; give at least one")
    for index, step in enumerate(programme.steps):
        where, action = f"steps[{index}].{step.key}", step.action
        check_bit(step.limits, source, f"steps[{index}].limits")
        if isinstance(action, (Rotate, Slide)):
            _check_one_of(action.time, action.length, f"{source}: {where}", "time and length")
        if isinstance(action, Rock):
            _check_one_of(action.cycles, action.time, f"{source}: {where}", "cycles and time")
            if action.right + action.left <= 0.0:
                raise InputError(f"{source}: {where}: right and left are both 0; give the wraps of one side at least")
    return programme


def _check_one_of(first: object, second: object, where: str, names: str) -> None:
    if (first is None) == (second is None):
        raise InputError(f"{where}: give one of {names}, not {'both' if first is not None else 'neither'}")


def _step(raw: Any, source: str, where: str) -> Step:
    known = f"known steps: {', '.join(ACTIONS)}"
    if not isinstance(raw, dict):
        raise InputError(f"{source}: {where} = {shorten(raw)}: expected a step such as 'rest: {{time: 10 s}}'; {known}")
    keys = [str(key) for key in raw if key not in _BESIDE_ACTION]
    if len(keys) != 1:
        found = ", ".join(keys)[:100] or "nothing"
        raise InputError(f"{source}: {where}: expected one step, found {found}; {known}")
    (key,) = keys
    if key not in ACTIONS:
        raise InputError(f"{source}: {where}.{key[:60]}: unknown step; {known}")
    limits = build_dataclass(StepLimits, raw.get("limits", {}), source, f"{where}.limits")
    note = raw.get("note", "")
    if not isinstance(note, str):
        raise InputError(f"{source}: {where}.note = {shorten(note)}: expected text (put it in quotes)")
    return Step(build_dataclass(ACTIONS[key], raw[key], source, f"{where}.{key}"), limits, note)


def programme_numbers() -> Iterator[NumberField]:
    """Every number of the file with its unit and range, in order."""
    yield from number_fields(_Header)
    for key, kind in ACTIONS.items():
        yield from number_fields(kind, f"steps[].{key}")
