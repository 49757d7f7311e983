"""Tables that fit their console: columns give way between words only, and what is wider still is told row by row."""

from __future__ import annotations

from rich.console import Console, Group, RenderableType
from rich.measure import Measurement
from rich.padding import Padding
from rich.table import Column, Table
from rich.text import Text


def fitted(table: Table, console: Console) -> RenderableType:
    """The table, its columns set so that no word of it is broken or cut; its rows as lines where that is impossible."""
    wide = console.options.update(width=10_000)
    spans = [_span(column, console) for column in table.columns]
    frame = Measurement.get(console, wide, table).maximum - sum(span.maximum for span in spans)
    room = console.width - frame
    if sum(span.maximum for span in spans) <= room:
        return table
    if sum(span.minimum for span in spans) > room:
        return _told(table)
    for column, width in zip(table.columns, _shared(spans, room), strict=True):
        column.width = width
    return table


def _span(column: Column, console: Console) -> Measurement:
    """Longest word and longest line of a column; of one that must not be wrapped both are the line."""
    wide = console.options.update(width=10_000)
    cells = [Measurement.get(console, wide, cell) for cell in (column.header, *column.cells, column.footer)]
    longest = max(cell.maximum for cell in cells)
    return Measurement(longest if column.no_wrap else max(cell.minimum for cell in cells), longest)


def _shared(spans: list[Measurement], room: int) -> list[int]:
    """Widths that fill the room, none below its minimum: the least that must be taken is taken from the widest."""
    widths = [span.maximum for span in spans]
    while sum(widths) > room:
        give = [width if width > span.minimum else 0 for width, span in zip(widths, spans, strict=True)]
        widths[give.index(max(give))] -= 1
    return widths


def _told(table: Table) -> RenderableType:
    """Each row as its first cell and, below it, a line for every other cell with the column's head."""
    heads = [column.header for column in table.columns]
    parts: list[RenderableType] = [Text(str(table.title), style="italic")] if table.title else []
    for cells in zip(*(column.cells for column in table.columns), strict=True):
        rows = Table.grid(padding=(0, 2, 0, 0))
        rows.add_column(no_wrap=True)
        rows.add_column(overflow="fold")
        for head, cell in zip(heads[1:], cells[1:], strict=True):
            if not isinstance(cell, str) or cell:
                rows.add_row(head, cell)
        parts += [cells[0], Padding(rows, (0, 0, 0, 2))]
    return Group(*parts)
