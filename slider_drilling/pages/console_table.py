"""A page's table for the terminal: the same cells in the same units."""

from __future__ import annotations

from rich.box import SIMPLE_HEAD
from rich.table import Table as ConsoleTable
from rich.text import Text as ConsoleText

from slider_drilling.pages.page import Table, converted_table
from slider_drilling.units import Units

NARROW = 9  # columns: more fit 80 characters only without a frame


def console_table(table: Table, units: Units) -> ConsoleTable:
    """The table as rich prints it: numbers to the right, units in the head."""
    content = converted_table(table, units)
    caption = units.convert_text(table.caption)
    shown = ConsoleTable(title=ConsoleText(caption) if caption else None, title_justify="left",
                         box=SIMPLE_HEAD if len(content["header"]) <= NARROW else None,
                         padding=(0, 1, 0, 0), pad_edge=False, show_header=any(content["header"]))  # fmt: skip
    for head, right in zip(content["header"], content["right"], strict=True):
        shown.add_column(ConsoleText(head), justify="right" if right else "left")
    for row in content["rows"]:
        shown.add_row(*(ConsoleText("\n".join(part["text"] for part in cell)) for cell in row))
    return shown
