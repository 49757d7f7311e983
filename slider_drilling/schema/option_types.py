"""Checks that the fields of an options dataclass, or arguments of a function, are of the kinds that they declare."""

from __future__ import annotations

import dataclasses
import numbers
import types
import typing
from collections.abc import Collection, Mapping
from typing import Any

from slider_drilling.errors import InputError
from slider_drilling.schema.yaml_tree import shorten

_NUMBERS: dict[Any, tuple[type, str]] = {
    float: (numbers.Real, "a number"), int: (numbers.Integral, "a whole number"),
}  # fmt: skip


def check_option_types(options: Any, caller: str) -> None:
    """Check every field of a dataclass against its annotation; for its `__post_init__`.

    Args:
        options: The dataclass.
        caller: Name of the function that takes it, for the message.

    Raises:
        InputError: A field is of another kind.
    """
    hints = typing.get_type_hints(type(options))
    for field in dataclasses.fields(options):
        check_argument(getattr(options, field.name), hints[field.name], f"{caller}: {field.name}")


def check_argument(value: Any, hint: Any, where: str) -> None:
    """Check a value against a type hint: a class, a union, or a tuple of any length.

    Args:
        value: As given.
        hint: The annotation.
        where: Starts the message, such as "plan_test: minutes".

    Raises:
        InputError: It is of another kind. A bool is no number.
    """
    choices = typing.get_args(hint) if isinstance(hint, types.UnionType) else (hint,)
    if not any(_is_of(value, choice) for choice in choices):
        kinds = " or ".join(dict.fromkeys(_in_words(choice) for choice in choices))
        raise InputError(f"{where} = {shorten(value)}: expected {kinds}")


def _is_of(value: Any, hint: Any) -> bool:
    if hint in _NUMBERS:
        return isinstance(value, _NUMBERS[hint][0]) and not isinstance(value, bool)
    if typing.get_origin(hint) is tuple:
        kind = typing.get_args(hint)[0]
        return isinstance(value, Collection) and not isinstance(value, str) and all(_is_of(one, kind) for one in value)
    return isinstance(value, hint)


def _in_words(hint: Any) -> str:
    if hint in _NUMBERS:
        return _NUMBERS[hint][1]
    if typing.get_origin(hint) is tuple:
        return f"a tuple, each of it {_in_words(typing.get_args(hint)[0])}"
    words = {str: "a text", Mapping: "a mapping", bool: "True or False", type(None): "None"}
    return words.get(hint, f"a {hint.__name__}")
