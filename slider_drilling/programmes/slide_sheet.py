"""A slide sheet as a programme: depth from, depth to, rotate or slide, and toolface, from CSV or XLSX."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

from slider_drilling.errors import InputError
from slider_drilling.files.cells import read_cells
from slider_drilling.programmes.programme import Programme, Step, check_programme
from slider_drilling.programmes.steps import MakeConnection, Rotate, Slide
from slider_drilling.schema.typed_table import Column, TableRow, read_typed_table
from slider_drilling.schema.yaml_tree import shorten

_COLUMNS = (
    Column("from", ("from", "start", "depth from", "start depth", "md from", "top"), "m"),
    Column("to", ("to", "end", "depth to", "end depth", "md to", "bottom"), "m"),
    Column("mode", ("mode", "activity", "rotate", "slide", "rotate/slide", "r/s", "operation")),
    Column("toolface", ("toolface", "tool face", "tf", "gtf", "target"), "rad", "deg", required=False),
    Column("rotary_speed", ("rpm", "rotary speed", "rotary rpm", "surface rpm"), "rad/s", "rpm", required=False),
    Column("rate", ("rop", "rate of penetration", "block speed"), "m/s", "m/h", required=False),
)
_MODES = {
    "rotate": ("rotate", "rotating", "rotary", "rot", "r"), "slide": ("slide", "sliding", "sl", "s"),
    "connection": ("connection", "conn", "c"),
}  # fmt: skip
_ROTARY_SPEED, _ROTATING_RATE, _SLIDING_RATE = 8.4, 12.0 / 3600.0, 9.0 / 3600.0  # rad/s (80 rpm), m/s, m/s
_DEPTH_TOLERANCE = 0.05  # m, between the end of a row and the start of the next
_LONGEST = 60.0  # m, of one row


@dataclass(frozen=True)
class SlideSheet:
    """A programme from a slide sheet.

    Attributes:
        programme: Its steps.
        start: Measured depth at which it begins, m.
    """

    programme: Programme
    start: float


def read_slide_sheet(path: Path) -> SlideSheet:
    """Read a slide sheet.

    Columns by their heads: from and to (measured depth, with a unit in the head), mode (rotate, slide or connection),
    toolface (deg unless the head says otherwise; for slides), and, where they are known, rpm and ROP (m/h).

    Args:
        path: CSV file or XLSX book.

    Raises:
        InputError: Naming file, line and cell of what cannot be used.
    """
    rows = read_typed_table(read_cells(path, "slide sheet"), _COLUMNS, path).rows
    if not rows:
        raise InputError(f"{path}: no rows below the heads; give one for each interval")
    steps: list[Step] = []
    depth = _number(rows[0], "from", path)
    start = depth
    for row in rows:
        mode = _mode(row, path)
        if mode == "connection":
            _check_connection(row, depth, path)
            steps.append(Step(MakeConnection()))
            continue
        depth = _check_depths(row, depth, path)
        steps.append(_step(row, mode, path))
    return SlideSheet(check_programme(Programme(tuple(steps), name=path.stem), str(path)), start)


def _step(row: TableRow, mode: str, path: Path) -> Step:
    length = row.numbers["to"] - row.numbers["from"]
    note = f"{row.numbers['from']:.1f} to {row.numbers['to']:.1f} m"
    if mode == "rotate":
        speed, rate = row.numbers.get("rotary_speed", _ROTARY_SPEED), row.numbers.get("rate", _ROTATING_RATE)
        _check_positive(row, {"rpm": speed, "ROP": rate}, path)
        return Step(Rotate(speed, length=length, block_speed=rate), note=note)
    tool_face = _number(row, "toolface", path)
    if abs(tool_face) > 2.0 * math.pi:
        raise InputError(f"{path}: line {row.line}: toolface = {math.degrees(tool_face):.4g} deg: must be within -360 "
                         "to 360")  # fmt: skip
    rate = row.numbers.get("rate", _SLIDING_RATE)
    _check_positive(row, {"ROP": rate}, path)
    return Step(Slide(tool_face, length=length, rate_of_penetration=rate), note=note)


def _check_positive(row: TableRow, values: dict[str, float], path: Path) -> None:
    for name, value in values.items():
        if value <= 0.0:
            raise InputError(f"{path}: line {row.line}: {name} = {value:g}: must be above 0; leave the cell empty for "
                             "the usual value")  # fmt: skip


def _check_depths(row: TableRow, depth: float, path: Path) -> float:
    """Check that a row begins where the last one ended and is not too long; returns where it ends, m."""
    begin, end = _number(row, "from", path), _number(row, "to", path)
    if abs(begin - depth) > _DEPTH_TOLERANCE:
        raise InputError(f"{path}: line {row.line}: begins at {begin:.2f} m, the row above ends at {depth:.2f} m; rows "
                         "must follow each other")  # fmt: skip
    if not 0.0 < end - begin <= _LONGEST:
        raise InputError(f"{path}: line {row.line}: from {begin:.2f} to {end:.2f} m: must be above 0 and at most "
                         f"{_LONGEST:.0f} m; put connections between stands")  # fmt: skip
    return end


def _check_connection(row: TableRow, depth: float, path: Path) -> None:
    """Check that a connection, where its row gives depths, drills nothing."""
    for name in ("from", "to"):
        if abs(row.numbers.get(name, depth) - depth) > _DEPTH_TOLERANCE:
            raise InputError(f"{path}: line {row.line}: {name} = {row.numbers[name]:.2f} m: a connection drills "
                             f"nothing, and the row above ends at {depth:.2f} m")  # fmt: skip


def _number(row: TableRow, name: str, path: Path) -> float:
    if name not in row.numbers:
        raise InputError(f"{path}: line {row.line}: no {name}; give it")
    return row.numbers[name]


def _mode(row: TableRow, path: Path) -> str:
    text = row.texts.get("mode", "").strip()
    for mode, words in _MODES.items():
        if text.lower() in words:
            return mode
    raise InputError(f"{path}: line {row.line}: mode = {shorten(text)}: must be rotate, slide or connection")
