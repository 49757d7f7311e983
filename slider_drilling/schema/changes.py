"""Nested changes to a tree of keys and values, as `parse_yaml` gives it and `build_dataclass` takes it."""

from __future__ import annotations

import copy
import difflib
import re
from collections.abc import Iterator, Mapping
from typing import Any

from slider_drilling.errors import InputError
from slider_drilling.schema.fields import to_tree
from slider_drilling.schema.quantity_text import convert_quantity, split_quantity

_STEP = re.compile(r"([^.\[\]]+)|\[(\d+)\]")
_PATH = re.compile(r"[^.\[\]]+(?:\[\d+\])*(?:\.[^.\[\]]+(?:\[\d+\])*)*")


def apply_changes(tree: Mapping[str, Any], changes: Mapping[str, Any], source: str) -> dict[str, Any]:
    """A copy of a tree with some values changed; neither argument is modified.

    `build_dataclass` checks the values afterwards.

    Args:
        tree: Keys and values.
        changes: By key or path (``mud.density``, ``string.sections[0].length``). A mapping changes keys below it;
            anything else (lists too) replaces what was there.
        source: Names the tree in errors.

    Raises:
        InputError: For a path that does not exist.
    """
    result: dict[str, Any] = copy.deepcopy(dict(tree))
    for path, value in _leaves(changes, ""):
        *parents, last = _steps(path, source)
        here: Any = result
        for step in parents:
            here = _below(here, step, path, source)
        if isinstance(last, int) or not isinstance(here, dict):
            _below(here, last, path, source)
        here[last] = value
    return result


def _leaves(changes: Mapping[str, Any], above: str) -> Iterator[tuple[str, Any]]:
    """(path, value) of each value that is not a mapping."""
    for key, value in changes.items():
        path = f"{above}{key}"
        if isinstance(value, Mapping):
            yield from _leaves(value, f"{path}.")
        else:
            yield path, _as_yaml(value)


def _as_yaml(value: Any) -> Any:
    """Dataclasses, tuples, arrays and their numbers as YAML types."""
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, Mapping):
        return {str(key): _as_yaml(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_as_yaml(item) for item in value]
    return to_tree(value)


def _steps(path: str, source: str) -> list[str | int]:
    if not _PATH.fullmatch(path):
        raise InputError(f"{source}: {path!r}: not a key; write keys like mud.density or string.sections[0].length")
    return key_steps(path)


def key_steps(key: str) -> list[str | int]:
    """Names and indices of a key: ``string.sections[0].length``."""
    return [name or int(index) for name, index in _STEP.findall(key)]


def _below(here: Any, step: str | int, path: str, source: str) -> Any:
    if isinstance(step, int):
        if not isinstance(here, list):
            raise InputError(f"{source}: {path}: [{step}] needs a list there")
        if step >= len(here):
            raise InputError(f"{source}: {path}: the list has {len(here)} entries, the first is [0]")
        return here[step]
    if not isinstance(here, dict):
        raise InputError(f"{source}: {path}: {step!r} needs keys and values there")
    if step not in here:
        near = difflib.get_close_matches(step, [str(key) for key in here], n=1)
        hint = f"did you mean {near[0]}?" if near else f"known keys: {', '.join(map(str, here))}"
        raise InputError(f"{source}: {path}: unknown key {step}; {hint}")
    return here[step]


def parse_number(text: str, what: str, unit: str | None = None) -> float:
    """A number typed on a command line.

    Args:
        text: The number, with its unit beside it if `unit` is given.
        what: Names it in errors.
        unit: Unit of the result.

    Raises:
        InputError: The text is not a number, or its unit is of another kind.
    """
    try:
        return float(text)
    except ValueError:
        pass
    found = split_quantity(text)
    if unit is None or found is None:
        raise InputError(f"{what} = {text!r}: expected a number")
    return convert_quantity(*found, unit, f"{what} = {text!r}")
