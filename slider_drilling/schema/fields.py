"""Frozen dataclasses from YAML mappings; every number is checked against the unit and range that its field declares."""

from __future__ import annotations

import dataclasses
import difflib
import math
import types
import typing
from collections.abc import Iterator, Mapping
from typing import Any, TypeVar

from slider_drilling.errors import InputError
from slider_drilling.schema.quantity_text import convert_quantity, split_quantity
from slider_drilling.schema.yaml_tree import shorten

T = TypeVar("T")
_MAX_ENTRIES = 10_000  # of a list; surveys have a thousand stations at most


@dataclasses.dataclass(frozen=True)
class Range:
    """Unit and limits of one number.

    Attributes:
        unit: "-" for a pure number.
        at_least, at_most: Limits that are allowed themselves.
        above, below: Limits that are not.
        why: Reason for the limits, shown when a value is refused.
        usual: Lowest and highest value in use. A number outside that would lie inside in one of the units of
            `mistaken_for` is not taken without its unit.
        mistaken_for: Units in which the number is often written by mistake.
    """

    unit: str = "-"
    at_least: float = -math.inf
    above: float = -math.inf
    at_most: float = math.inf
    below: float = math.inf
    why: str = ""
    usual: tuple[float, float] = (-math.inf, math.inf)
    mistaken_for: tuple[str, ...] = ()

    def question(self, value: float) -> str | None:
        """What to ask about a number without a unit that is likely to be in another one, or None."""
        low, high = self.usual
        if low <= value <= high:
            return None
        for unit in self.mistaken_for:
            meant = convert_quantity(value, unit, self.unit, "")
            if low <= meant <= high:
                return (f"is this {value:g} {unit}, which is {meant:.4g} {self.unit}? Write the unit beside it: "
                        f"'{value:g} {unit}', or '{value:g} {self.unit}' if it is that")  # fmt: skip
        return None

    def complaint(self, value: float) -> str | None:
        """Why ``value`` is out of range, or None."""
        if not math.isfinite(value):
            return "not a finite number"
        unit = "" if self.unit == "-" else f" {self.unit}"
        why = f" ({self.why})" if self.why else ""
        if value < self.at_least:
            return f"must be at least {self.at_least:g}{unit}{why}"
        if value <= self.above:
            return f"must be above {self.above:g}{unit}{why}"
        if value > self.at_most:
            return f"must be at most {self.at_most:g}{unit}{why}"
        if value >= self.below:
            return f"must be below {self.below:g}{unit}{why}"
        return None

    def __str__(self) -> str:
        """The limits in words, like ``above 0, at most 1``."""
        bounds = (("at least", self.at_least), ("above", self.above), ("at most", self.at_most), ("below", self.below))
        return ", ".join(f"{word} {bound:g}" for word, bound in bounds if math.isfinite(bound)) or "any"


def quantity(unit: str = "-", default: Any = dataclasses.MISSING, why: str = "", **limits: Any) -> Any:
    """A dataclass field for a number with this unit and these limits (see `Range`); one with None as default may be
    left out.
    """
    return dataclasses.field(default=default, metadata={"range": Range(unit, why=why, **limits)})


def table(**columns: Range) -> Any:
    """A dataclass field for rows of numbers, with a range for each column."""
    return dataclasses.field(metadata={"columns": columns})


def nested(**ranges: Range) -> Any:
    """A dataclass field for a nested dataclass; ``ranges`` replace those of its own fields, by name."""
    return dataclasses.field(metadata={"ranges": ranges})


def not_in_file(default: Any) -> Any:
    """A dataclass field that is no key of a file."""
    return dataclasses.field(default=default, metadata={"in_file": False})


@dataclasses.dataclass(frozen=True)
class NumberField:
    """One number of a schema.

    Attributes:
        key: From the top.
        range: Unit and limits.
        default: None where there is none.
        optional: Whether the number may be left out though it has no default.
    """

    key: str
    range: Range
    default: float | None
    optional: bool = False


def number_fields(cls: type, path: str = "", ranges: Mapping[str, Range] | None = None) -> Iterator[NumberField]:
    """Every number that a dataclass and its nested ones declare, in order; ``[]`` marks items of a list."""
    hints = typing.get_type_hints(cls)
    for field in file_fields(cls):
        where, hint = _join(path, field.name), _without_none(hints[field.name])
        if typing.get_origin(hint) is tuple and dataclasses.is_dataclass(typing.get_args(hint)[0]):
            where, hint = f"{where}[]", typing.get_args(hint)[0]
        if dataclasses.is_dataclass(hint):
            yield from number_fields(typing.cast(type, hint), where, field.metadata.get("ranges"))
        for name, limits in field.metadata.get("columns", {}).items():
            yield NumberField(f"{where}[] {name}", limits, None)
        if hint in (float, int):
            limits = (ranges or {}).get(field.name) or field.metadata.get("range") or Range()
            default = None if field.default is dataclasses.MISSING else field.default
            yield NumberField(where, limits, default, field.default is None)


def file_fields(cls: Any) -> list[dataclasses.Field[Any]]:
    """The fields of a dataclass that are keys of its file."""
    return [field for field in dataclasses.fields(cls) if field.init and field.metadata.get("in_file", True)]


def _without_none(hint: Any) -> Any:
    """``float`` for ``float | None``; other types as they are."""
    if isinstance(hint, types.UnionType):
        (hint,) = (kind for kind in typing.get_args(hint) if kind is not type(None))
    return hint


def build_dataclass(
    cls: type[T], raw: Any, source: str, path: str = "", ranges: Mapping[str, Range] | None = None
) -> T:
    """Build a dataclass from a mapping as YAML gives it.

    Args:
        cls: The dataclass.
        raw: Keys and values.
        source: Names the file in errors.
        path: Key of ``raw`` from the top, for errors.
        ranges: Replace the ranges that fields declare, by name.

    Raises:
        InputError: Naming source, key and value, for an unknown or missing key, a value of the wrong type, or a number
            outside its range.
    """
    if not isinstance(raw, dict):
        raise InputError(f"{source}: {path or 'top level'} = {shorten(raw)}: expected keys and values")
    fields = {field.name: field for field in file_fields(cls)}
    for key in raw:
        if key not in fields:
            near = difflib.get_close_matches(str(key)[:100], fields, n=1)
            hint = f"did you mean {near[0]}?" if near else f"known keys: {', '.join(fields)}"
            raise InputError(f"{source}: {_join(path, str(key)[:100])}: unknown key; {hint}")
    hints = typing.get_type_hints(cls)
    values = {}
    for name, field in fields.items():
        where = _join(path, name)
        if name in raw:
            limits = (ranges or {}).get(name) or field.metadata.get("range")
            if raw[name] is not None or field.default is not None:
                values[name] = _convert(raw[name], _without_none(hints[name]), limits, field.metadata, source, where)
        elif field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING:
            raise InputError(f"{source}: {where}: missing; add it")
    return cls(**values)


def to_tree(value: Any) -> Any:
    """Dataclasses and tuples as dicts and lists for YAML; the inverse of `build_dataclass`.

    Numbers that are None are left out; a number that would be asked about has its unit beside it.
    """
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        items = {field: getattr(value, field.name) for field in file_fields(value)}
        return {field.name: _number_to_tree(item, field.metadata.get("range")) for field, item in items.items()
                if item is not None or field.default is not None}  # fmt: skip
    if isinstance(value, tuple):
        return [to_tree(item) for item in value]
    return value


def _number_to_tree(value: Any, limits: Range | None) -> Any:
    if limits is not None and isinstance(value, float) and limits.question(value) is not None:
        return f"{value!r} {limits.unit}"
    return to_tree(value)


def _join(path: str, key: str) -> str:
    return f"{path}.{key}" if path else key


def _convert(raw: Any, hint: Any, limits: Range | None, metadata: Mapping[str, Any], source: str, where: str) -> Any:
    if dataclasses.is_dataclass(hint):
        return build_dataclass(typing.cast(type, hint), raw, source, where, metadata.get("ranges"))
    if typing.get_origin(hint) is tuple:
        return _convert_list(raw, hint, limits, metadata, source, where)
    if hint is float:
        return _convert_number(raw, limits or Range(), source, where)
    if hint is bool and isinstance(raw, bool):
        return raw
    if hint is int and isinstance(raw, int) and not isinstance(raw, bool):
        _convert_number(raw, limits or Range(), source, where)
        return raw
    if hint is str and isinstance(raw, str):
        return raw
    raise InputError(f"{source}: {where} = {shorten(raw)}: expected {_KINDS.get(hint, hint)}")


_KINDS = {bool: "true or false", int: "a whole number", str: "text (put it in quotes)"}


def _convert_list(
    raw: Any, hint: Any, limits: Range | None, metadata: Mapping[str, Any], source: str, where: str
) -> tuple[Any, ...]:
    kinds = typing.get_args(hint)
    if not isinstance(raw, list):
        raise InputError(f"{source}: {where} = {shorten(raw)}: expected a list")
    if len(raw) > _MAX_ENTRIES:
        raise InputError(f"{source}: {where}: {len(raw)} entries; at most {_MAX_ENTRIES} are read")
    columns = metadata.get("columns")
    if columns is not None and kinds[-1] is Ellipsis:
        names = [f"{where}[{index}]" for index in range(len(raw))]
        return tuple(_convert_columns(item, columns, source, name) for item, name in zip(raw, names, strict=True))
    if kinds[-1] is Ellipsis:
        kinds = (kinds[0],) * len(raw)
    if len(kinds) != len(raw):
        raise InputError(f"{source}: {where} = {shorten(raw)}: expected {len(kinds)} numbers, found {len(raw)}")
    pairs = enumerate(zip(raw, kinds, strict=True))
    return tuple(_convert(item, kind, limits, metadata, source, f"{where}[{index}]") for index, (item, kind) in pairs)


def _convert_columns(raw: Any, columns: Mapping[str, Range], source: str, where: str) -> tuple[float, ...]:
    if not isinstance(raw, list) or len(raw) != len(columns):
        raise InputError(f"{source}: {where} = {shorten(raw)}: expected {len(columns)} numbers: {', '.join(columns)}")
    pairs = zip(raw, columns.items(), strict=True)
    return tuple(_convert_number(item, limits, source, f"{where} {name}") for item, (name, limits) in pairs)


def _convert_number(raw: Any, limits: Range, source: str, where: str) -> float:
    shown = f"{source}: {where} = {shorten(raw)}"
    if isinstance(raw, str):
        number = _convert_text(raw, limits, shown)
    elif isinstance(raw, bool) or not isinstance(raw, (int, float)):
        raise InputError(f"{shown}: expected a number in {limits.unit}")
    else:
        number = _to_float(raw)
        question = limits.question(number)
        if question:
            raise InputError(f"{shown}: {question}")
    complaint = limits.complaint(number)
    if complaint:
        raise InputError(f"{shown}: {complaint}")
    return number


def _to_float(raw: float) -> float:
    try:
        return float(raw)
    except OverflowError:
        return math.inf


def _convert_text(raw: str, limits: Range, shown: str) -> float:
    """A number with its unit, in the unit of its range."""
    try:
        float(raw)
    except ValueError:
        found = split_quantity(raw)
        if found is None:
            raise InputError(f"{shown}: expected a number in {limits.unit}, or with its unit beside it") from None
        return convert_quantity(*found, limits.unit, shown)
    raise InputError(
        f"{shown}: YAML reads this as text; write it unquoted, without leading zeros or underscores, an exponent as "
        "1.0e+5"
    )
