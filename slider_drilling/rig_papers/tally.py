"""The string tally: from the items as run to the sections of a rig file."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from slider_drilling.errors import InputError
from slider_drilling.files.cells import read_cells
from slider_drilling.rig import StringSection
from slider_drilling.rig.parts import GRAVITY
from slider_drilling.rig_papers.inches import grade_in_text, pounds_in_text, size_in_text
from slider_drilling.rig_papers.tubulars import (
    CONNECTIONS,
    GRADES,
    SAME_CONNECTION,
    Connection,
    adjusted_weight,
    find_drill_pipe,
    find_heavy_weight_pipe,
    make_up_torque,
    premium_outer_diameter,
    torsional_yield,
)
from slider_drilling.schema.typed_table import Column, TableRow, read_typed_table
from slider_drilling.units import KINDS

_INCH, _POUND_FOOT, _FOOT_POUND = KINDS["length"]["in"], KINDS["force per length"]["lbf/ft"], KINDS["torque"]["ft lbf"]
_MIN_SECTION = 9.0  # m; shorter sections make the time step short, and no log shows them
_BORE = 0.42  # of the outer diameter, of collars and tools without a bore on paper
_STEEL = 7850.0  # kg/m3
_COLUMNS = (
    Column("description", ("description", "item description", "component", "bha component", "tool", "type", "name")),
    Column("length", ("length", "len", "total length", "joint length"), "m"),
    Column("outer_diameter", ("od", "outer diameter", "o d", "body od"), "m", required=False),
    Column("inner_diameter", ("id", "inner diameter", "i d", "bore"), "m", required=False),
    Column("weight", ("weight", "adj weight", "adjusted weight", "wt", "mass", "lin weight"), "N/m", required=False),
    Column("tool_joint_outer", ("tj od", "tool joint od", "tooljoint od"), "m", required=False),
    Column("tool_joint_inner", ("tj id", "tool joint id", "tooljoint id"), "m", required=False),
    Column("make_up_torque", ("make up", "makeup", "make-up", "mut"), "N m", required=False),
    Column("cumulative", ("cum", "total", "cumulative"), "m", required=False),
)


@dataclass(frozen=True)
class Tally:
    """A string from the surface down.

    Attributes:
        sections: As a rig file's `string.sections` holds them.
        bit_diameter: m; None without a bit among the items.
        bit_description: As the tally names the bit.
        notes: What was merged, looked up or taken as usual.
    """

    sections: tuple[StringSection, ...]
    bit_diameter: float | None
    bit_description: str
    notes: tuple[str, ...]


@dataclass(frozen=True)
class _Item:
    """One row: the section it makes, whether it is pipe (not bottom-hole assembly), and what was looked up."""

    section: StringSection
    is_pipe: bool
    notes: tuple[str, ...] = ()


def read_tally(path: Path, connection_torque: float | None = None) -> Tally:
    """Read a tally.

    Args:
        path: CSV or XLSX with description, length, outer diameter, and if known inner diameter, weight with tool
            joints, tool joint diameters and make-up torque, from the bit up or from the surface down.
        connection_torque: Make-up torque of the drill pipe's connection, N m, where a sheet gives it.

    Raises:
        InputError: Naming file, line and head of what cannot be used.
    """
    table = read_typed_table(read_cells(path, "tally", "tally"), _COLUMNS, path)
    rows = [row for row in table.rows if row.texts.get("description") and "length" in row.numbers]
    if not rows:
        raise InputError(f"{path}: no items with description and length; add the string as run")
    _check_lengths(rows, path)
    if not _begins_with_bit(rows, path):
        rows = rows[::-1]
    bits = [row for row in rows if _is_bit(row)]
    bit = bits[0] if bits else None
    items = [_item(row, path, connection_torque) for row in rows if row is not bit]
    if not items:
        raise InputError(f"{path}: holds the bit alone; add the string above it")
    items[0] = _lengthened(items[0], bit)
    items, joined = _joined(items)
    sections, merged = _merged(items)
    notes = (*(note for item in items for note in item.notes), *joined, *merged)
    diameter = None if bit is None else _outer(bit, path)
    return Tally(sections, diameter, "" if bit is None else bit.texts["description"], tuple(dict.fromkeys(notes)))


def _check_lengths(rows: Sequence[TableRow], path: Path) -> None:
    """Lengths are above zero and add up to the cumulative column, within 0.1 m an item."""
    total = 0.0
    for row in rows:
        length = row.numbers["length"]
        if length <= 0.0:
            raise InputError(f"{path}: line {row.line}: length = {length:g} m: must be above 0")
        total += length
        cumulative = row.numbers.get("cumulative")
        if cumulative is not None and abs(cumulative - total) > 0.1 * len(rows) and rows[0].numbers.get("cumulative"):
            raise InputError(f"{path}: line {row.line}: lengths add up to {total:.5g} m, the column says "
                             f"{cumulative:.5g} m; correct one")  # fmt: skip


def _is_bit(row: TableRow) -> bool:
    text = row.texts["description"].lower()
    return "sub" not in text and re.search(r"\bbit\b|\bpdc\b|\btricone\b|roller cone", text) is not None


def _begins_with_bit(rows: Sequence[TableRow], path: Path) -> bool:
    """Whether the first row is the lowest item. Raises InputError where neither end has the bit."""
    if _is_bit(rows[0]) or (len(rows) > 1 and _is_bit(rows[1])):
        return True
    if _is_bit(rows[-1]) or (len(rows) > 1 and _is_bit(rows[-2])):
        return False
    raise InputError(f"{path}: neither the first nor the last item is a bit; which end is down? name the bit so")


def _outer(row: TableRow, path: Path) -> float:
    given = row.numbers.get("outer_diameter")
    named = size_in_text(row.texts["description"])
    if given is not None:
        return given
    if named is None:
        raise InputError(f"{path}: line {row.line}: {row.texts['description'][:60]}: no outer diameter; add it")
    return named * _INCH


def _item(row: TableRow, path: Path, connection_torque: float | None) -> _Item:
    """One row as a section; tables fill in what it lacks."""
    text, numbers = row.texts["description"], row.numbers
    outer = _outer(row, path)
    plain = StringSection(
        text, numbers["length"], outer, numbers.get("inner_diameter", 0.0), numbers.get("weight"),
        numbers.get("tool_joint_outer"), numbers.get("tool_joint_inner"), make_up_torque=numbers.get("make_up_torque"),
    )  # fmt: skip
    where = f"{path}: line {row.line}: {text[:60]}"
    has_bore = "inner_diameter" in numbers
    if re.search(r"hwdp|hwt|heavy|hevi", text.lower()):
        return _heavy_weight(plain, has_bore, where)
    if re.search(r"\bdp\b|drill ?pipe|#", text.lower()) or grade_in_text(text) is not None:
        return _drill_pipe(plain, has_bore, connection_torque, where)
    return _assembly_item(plain, has_bore, where)


def _drill_pipe(section: StringSection, has_bore: bool, connection_torque: float | None, where: str) -> _Item:
    size, grade = section.outer_diameter / _INCH, grade_in_text(section.name)
    pipe, notes = find_drill_pipe(size, pounds_in_text(section.name)), []
    inner = section.inner_diameter / _INCH
    if not has_bore:
        if pipe is None:
            raise InputError(f"{where}: no inner diameter, and no such size in API Spec 5DP; add it")
        inner = pipe.inner_diameter
        notes.append(f"{section.name}: inner diameter {inner:g} in of API Spec 5DP")
    weight = section.weight_per_length
    if weight is None and pipe is not None:
        weight = adjusted_weight(pipe, grade or "G") * _POUND_FOOT
        notes.append(f"{section.name}: weight with tool joints {weight / _POUND_FOOT:.1f} lb/ft of API RP 7G")
    torque = section.make_up_torque or connection_torque
    joint = _tool_joint(section, grade)
    if torque is None and joint is not None:
        torque = make_up_torque(*joint) * _FOOT_POUND
        notes.append(f"{section.name}: make-up torque {torque / _FOOT_POUND:.0f} ft lbf of API RP 7G, new tool joints "
                     f"of {joint[1]:g} x {joint[2]:g} in")  # fmt: skip
    if joint is not None and section.tool_joint_outer_diameter is None:
        notes.append(f"{section.name}: friction turns on the pipe's body; tool joints of {joint[1]:g} in would add "
                     f"{joint[1] / size - 1.0:.0%} to the torque: a column TJ OD puts them in")  # fmt: skip
    strength = None
    if grade is not None:
        worn = premium_outer_diameter(size, inner) if "premium" in section.name.lower() else size
        strength = torsional_yield(worn, inner, GRADES[grade]) * _FOOT_POUND
    return _Item(replace(section, inner_diameter=inner * _INCH, weight_per_length=weight, make_up_torque=torque,
                         torsional_yield=strength), True, tuple(notes))  # fmt: skip


def _tool_joint(section: StringSection, grade: str | None) -> tuple[Connection, float, float] | None:
    """Connection, outer and inner diameter (in) of the tool joints, None where neither tally nor table has them."""
    pipe = find_drill_pipe(section.outer_diameter / _INCH, pounds_in_text(section.name))
    named = next((name for name in (*CONNECTIONS, *SAME_CONNECTION) if name.lower() in section.name.lower()), None)
    named = SAME_CONNECTION.get(named or "", named)
    if named is None:
        named = pipe.connection if pipe is not None else None
    if named is None:
        return None
    outer, inner = section.tool_joint_outer_diameter, section.tool_joint_inner_diameter
    if outer is not None and inner is not None:
        return CONNECTIONS[named], outer / _INCH, inner / _INCH
    if pipe is None or pipe.connection != named:
        return None
    return CONNECTIONS[named], *pipe.tool_joint(grade or "E")


def _heavy_weight(section: StringSection, has_bore: bool, where: str) -> _Item:
    pipe, notes = find_heavy_weight_pipe(section.outer_diameter / _INCH), []
    if pipe is None and not has_bore:
        raise InputError(f"{where}: no inner diameter, and no such heavy-weight drill pipe in the table; add it")
    inner, weight, torque = section.inner_diameter, section.weight_per_length, section.make_up_torque
    if pipe is not None:
        if not has_bore:
            inner = pipe.inner_diameter * _INCH
            notes.append(f"{section.name}: inner diameter {pipe.inner_diameter:g} in of the table")
        if weight is None:
            weight = pipe.weight * _POUND_FOOT
            notes.append(f"{section.name}: weight with tool joints {pipe.weight:g} lb/ft of the table")
        torque = torque or make_up_torque(CONNECTIONS[pipe.connection], *pipe.tool_joint) * _FOOT_POUND
    return _Item(replace(section, inner_diameter=inner, weight_per_length=weight, make_up_torque=torque), True,
                 tuple(notes))  # fmt: skip


def _assembly_item(section: StringSection, has_bore: bool, where: str) -> _Item:
    """A collar or tool; without a bore on paper, the weight gives it, else a usual one."""
    if has_bore:
        return _Item(section, False)
    outer, weight = section.outer_diameter, section.weight_per_length
    if weight is None:
        note = f"{section.name}: bore {_BORE:g} of its outer diameter, as tools of this size have"
        return _Item(replace(section, inner_diameter=_BORE * outer), False, (note,))
    square = outer**2 - 4.0 / math.pi * weight / (GRAVITY * _STEEL)
    if square < -0.05 * outer**2:
        raise InputError(f"{where}: weight = {weight / _POUND_FOOT:.4g} lb/ft: more than a solid steel bar of "
                         f"{outer / _INCH:.4g} in; check size and weight")  # fmt: skip
    note = f"{section.name}: bore that its weight leaves"
    return _Item(replace(section, inner_diameter=math.sqrt(max(square, 0.0))), False, (note,))


def _lengthened(item: _Item, bit: TableRow | None) -> _Item:
    """The lowest item with the bit's length added."""
    if bit is None:
        return item
    return replace(item, section=replace(item.section, length=item.section.length + bit.numbers["length"]))


def _joined(items: Sequence[_Item]) -> tuple[list[_Item], list[str]]:
    """Items with equal neighbours as one, such as the joints of a stretch of pipe, and a note on each such stretch."""
    groups = _grouped(items, lambda group, item: _is_equal(group[0], item))
    joined = [replace(group[0], section=replace(group[0].section, length=_length(group))) for group in groups]
    notes = [f"{len(group)} equal items are one section of {_length(group):.5g} m: {group[0].section.name}"
             for group in groups if len(group) > 1]  # fmt: skip
    return joined, notes


def _is_equal(first: _Item, other: _Item) -> bool:
    """Whether two items differ at most in name and length."""
    alike = replace(other.section, name=first.section.name, length=first.section.length)
    return first.is_pipe == other.is_pipe and first.section == alike


def _merged(items: Sequence[_Item]) -> tuple[tuple[StringSection, ...], list[str]]:
    """Sections from the surface down: the items of the bottom-hole assembly as one, short ones with a neighbour.

    Args:
        items: From the bit up.
    """
    sections, notes = [], []
    for group in _grouped(items, _belongs_to):
        if len(group) > 1:
            names = ", ".join(item.section.name for item in group)
            notes.append(f"one section of {_length(group):.4g} m with their weight and stiffness: {names}")
        sections.append(_combined([item.section for item in group]))
    return tuple(sections[::-1]), notes


def _belongs_to(group: Sequence[_Item], item: _Item) -> bool:
    """Whether both are of the bottom-hole assembly, or one is too short for a section."""
    same_kind = not group[-1].is_pipe and not item.is_pipe
    return same_kind or item.section.length < _MIN_SECTION or _length(group) < _MIN_SECTION


def _grouped(items: Sequence[_Item], joins: Callable[[Sequence[_Item], _Item], bool]) -> list[list[_Item]]:
    """Neighbours in groups; an item joins the group before it, or begins another."""
    groups: list[list[_Item]] = []
    for item in items:
        if groups and joins(groups[-1], item):
            groups[-1].append(item)
        else:
            groups.append([item])
    return groups


def _length(group: Sequence[_Item]) -> float:
    return math.fsum(item.section.length for item in group)


def _combined(parts: Sequence[StringSection]) -> StringSection:
    """One section for several: their weight, their torsional stiffness in series, their mean outer diameter."""
    if len(parts) == 1:
        return parts[0]
    length = math.fsum(part.length for part in parts)

    def mean(values: Sequence[float]) -> float:
        return math.fsum(part.length * value for part, value in zip(parts, values, strict=True)) / length

    outer = mean([part.outer_diameter for part in parts])
    quartic = 1.0 / mean([1.0 / (part.outer_diameter**4 - part.inner_diameter**4) for part in parts])
    weight = mean([part.weight_per_length or _plain_weight(part) for part in parts])
    limits = [part.make_up_torque for part in parts if part.make_up_torque is not None]
    return StringSection(
        "bottom-hole assembly", length, outer, max(outer**4 - quartic, 0.0) ** 0.25, weight,
        make_up_torque=min(limits, default=None),
    )  # fmt: skip


def _plain_weight(part: StringSection) -> float:
    return GRAVITY * _STEEL * math.pi / 4.0 * (part.outer_diameter**2 - part.inner_diameter**2)
