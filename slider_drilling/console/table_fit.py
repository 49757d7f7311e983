"""Fits rich tables to their console without breaking or cutting a word, as rich itself would do.

Columns are narrowed between words only. A table that is still too wide is printed row by row.
"""

from __future__ import annotations

from rich.console import Console, Group, RenderableType
from rich.measure import Measurement
from rich.padding import Padding
from rich.table import Column, Table
from rich.text import Text


def fit_table(table: Table, console: Console) -> RenderableType:
    """The table with column widths that break no word; if none fit, its rows as lines."""
    return table if _arrange(table, console, console.width) else _as_lines(table, console)


def _arrange(table: Table, console: Console, width: int) -> bool:
    """Set column widths if the table is too wide; False if that would break words."""
    wide = console.options.update(width=10_000)
    spans = [_span(column, console) for column in table.columns]
    frame = Measurement.get(console, wide, table).maximum - sum(span.maximum for span in spans)
    room = width - frame
    if sum(span.minimum for span in spans) > room:
        return False
    if sum(span.maximum for span in spans) > room:
        for column, share in zip(table.columns, _shared(spans, room), strict=True):
            column.width = share
    return True


def _span(column: Column, console: Console) -> Measurement:
    """Longest word and longest line of a column; both are the line if the column must not be wrapped."""
    wide = console.options.update(width=10_000)
    cells = [Measurement.get(console, wide, cell) for cell in (column.header, *column.cells, column.footer)]
    longest = max(cell.maximum for cell in cells)
    return Measurement(longest if column.no_wrap else max(cell.minimum for cell in cells), longest)


def _shared(spans: list[Measurement], room: int) -> list[int]:
    """Widths that fill the room, none below its minimum: the widest columns are narrowed first."""
    widths = [span.maximum for span in spans]
    while sum(widths) > room:
        reducible = [width if width > span.minimum else 0 for width, span in zip(widths, spans, strict=True)]
        widths[reducible.index(max(reducible))] -= 1
    return widths


def _as_lines(table: Table, console: Console) -> RenderableType:
    """Each row as its first cell and, below it, every other cell beside (or below) its column's header."""
    heads = [column.header for column in table.columns]
    parts: list[RenderableType] = [Text(str(table.title), style="italic")] if table.title else []
    for first, *cells in zip(*(column.cells for column in table.columns), strict=True):
        pairs = [(head, cell) for head, cell in zip(heads[1:], cells, strict=True) if cell != ""]
        rows = Table.grid(padding=(0, 2, 0, 0))
        for pair in pairs:
            rows.add_row(*pair)
        fits = _arrange(rows, console, console.width - 2)
        lines = [Group(head, Padding(cell, (0, 0, 0, 2))) for head, cell in pairs]
        below: RenderableType = rows if fits else Group(*lines)
        parts += [first, Padding(below, (0, 0, 0, 2))]
    return Group(*parts)
