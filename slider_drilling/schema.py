"""Frozen dataclasses from YAML mappings, each value checked against the unit and range it declares."""

from __future__ import annotations

import dataclasses
import difflib
import math
import types
import typing
from typing import Any, TypeVar

from slider_drilling.errors import InputError

T = TypeVar("T")


@dataclasses.dataclass(frozen=True)
class Range:
    """Unit and limits of one number: at_least and at_most are allowed themselves, above and below are not."""

    unit: str = "-"
    at_least: float = -math.inf
    above: float = -math.inf
    at_most: float = math.inf
    below: float = math.inf

    def complaint(self, value: float) -> str | None:
        """Why ``value`` is out of range, or None."""
        unit = "" if self.unit == "-" else f" {self.unit}"
        if not math.isfinite(value):
            return "not a finite number"
        if value < self.at_least:
            return f"must be at least {self.at_least:g}{unit}"
        if value <= self.above:
            return f"must be above {self.above:g}{unit}"
        if value > self.at_most:
            return f"must be at most {self.at_most:g}{unit}"
        if value >= self.below:
            return f"must be below {self.below:g}{unit}"
        return None


def quantity(unit: str = "-", default: Any = dataclasses.MISSING, **limits: float) -> Any:
    """A dataclass field that holds a number of this unit within these limits (see `Range`)."""
    return dataclasses.field(default=default, metadata={"range": Range(unit, **limits)})


def build(cls: type[T], raw: Any, source: str, path: str = "") -> T:
    """Make the dataclass ``cls`` from a mapping as YAML gives it.

    Raises InputError, naming source, key and value, for a key that is unknown or missing, a value of the wrong
    type, or a number outside its declared range.
    """
    if not isinstance(raw, dict):
        raise InputError(f"{source}: {path or 'top level'} = {raw!r}: expected keys and values, found none")
    fields = {f.name: f for f in dataclasses.fields(cls) if f.init}  # type: ignore[arg-type]
    for key in raw:
        if key not in fields:
            near = difflib.get_close_matches(str(key), fields, n=1)
            hint = f"did you mean {near[0]}?" if near else f"known keys: {', '.join(fields)}"
            raise InputError(f"{source}: {_join(path, key)}: unknown key; {hint}")
    hints = typing.get_type_hints(cls)
    values = {}
    for name, field in fields.items():
        where = _join(path, name)
        if name in raw:
            values[name] = _convert(raw[name], hints[name], field.metadata.get("range"), source, where)
        elif field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING:
            raise InputError(f"{source}: {where}: missing; add it")
    return cls(**values)


def plain(value: Any) -> Any:
    """Dataclasses and tuples as the dicts and lists that YAML writes; the inverse of `build`."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {f.name: plain(getattr(value, f.name)) for f in dataclasses.fields(value) if f.init}
    if isinstance(value, tuple):
        return [plain(item) for item in value]
    return value


def _join(path: str, key: Any) -> str:
    return f"{path}.{key}" if path else str(key)


def _convert(raw: Any, hint: Any, limits: Range | None, source: str, where: str) -> Any:
    if dataclasses.is_dataclass(hint):
        return build(hint, raw, source, where)  # type: ignore[arg-type]
    if typing.get_origin(hint) is tuple:
        return _convert_list(raw, hint, limits, source, where)
    if hint is float:
        return _convert_number(raw, limits or Range(), source, where)
    if hint is bool and isinstance(raw, bool):
        return raw
    if hint is int and isinstance(raw, int) and not isinstance(raw, bool):
        return raw
    if hint is str and isinstance(raw, str):
        return raw
    name = hint.__name__ if isinstance(hint, (type, types.GenericAlias)) else str(hint)
    raise InputError(f"{source}: {where} = {raw!r}: expected {name}")


def _convert_list(raw: Any, hint: Any, limits: Range | None, source: str, where: str) -> tuple[Any, ...]:
    kinds = typing.get_args(hint)
    if not isinstance(raw, list):
        raise InputError(f"{source}: {where} = {raw!r}: expected a list")
    if kinds[-1] is Ellipsis:
        kinds = (kinds[0],) * len(raw)
    if len(kinds) != len(raw):
        raise InputError(f"{source}: {where} = {raw!r}: expected {len(kinds)} numbers, found {len(raw)}")
    pairs = enumerate(zip(raw, kinds, strict=True))
    return tuple(_convert(item, kind, limits, source, f"{where}[{index}]") for index, (item, kind) in pairs)


def _convert_number(raw: Any, limits: Range, source: str, where: str) -> float:
    if isinstance(raw, str):
        try:
            float(raw)
        except ValueError:
            raise InputError(f"{source}: {where} = {raw!r}: expected a number in {limits.unit}") from None
        raise InputError(
            f"{source}: {where} = {raw!r}: YAML reads this as text; write it unquoted, an exponent as 1.0e+5"
        )
    if isinstance(raw, bool) or not isinstance(raw, (int, float)):
        raise InputError(f"{source}: {where} = {raw!r}: expected a number in {limits.unit}")
    complaint = limits.complaint(float(raw))
    if complaint:
        raise InputError(f"{source}: {where} = {raw}: {complaint}")
    return float(raw)
