"""A rocking plan on one sheet of paper: PDF, landscape."""

from __future__ import annotations

import io
import textwrap
from typing import Any

from slider_drilling import __version__
from slider_drilling.pages.png import without_windows
from slider_drilling.process.shutdown import defer_signals
from slider_drilling.rocking_design.plan import Plan
from slider_drilling.rocking_design.plan_table import cell, columns, facts, head, notes, title
from slider_drilling.units import Units

MAX_ROWS = 24
"""Depths that fit on the sheet; of more, evenly chosen ones are printed."""
_WIDTH, _HEIGHT = 11.0, 8.5  # in
_LEFT, _RIGHT = 0.45, 10.55  # in
_ROW = 0.215  # in
_NOTE_WIDTH = 165  # characters
_INK, _GREY, _BAND = "#1b2733", "#5b6b7a", "#eef2f6"


def plan_sheet(plan: Plan, units: Units, block_weight: float = 0.0) -> bytes:
    """The sheet as PDF.

    Args:
        plan: The plan.
        units: Of the sheet.
        block_weight: Added to hook loads, N.
    """
    with defer_signals():
        return _draw(plan, units, block_weight)


def _draw(plan: Plan, units: Units, block_weight: float) -> bytes:
    with without_windows():
        from matplotlib.backends.backend_pdf import FigureCanvasPdf
        from matplotlib.figure import Figure
        from matplotlib.patches import Rectangle

    paper = Figure(figsize=(_WIDTH, _HEIGHT))

    def write(x: float, y: float, text: str, size: float, colour: str = _INK, **style: Any) -> None:
        paper.text(x / _WIDTH, y / _HEIGHT, text, fontsize=size, color=colour, va="baseline", **style)

    write(_LEFT, 7.95, f"Rocking plan: {title(plan, units)}", 15, weight="bold")
    listed = [f"{name}: {units.convert_text(text)}" for name, text in facts(plan)]
    write(_LEFT, 7.62, "     ".join(listed[:4]), 8.5, colour=_GREY)
    write(_LEFT, 7.42, "     ".join(listed[4:]), 8.5, colour=_GREY)
    shown, top = columns(block_weight), 6.82
    step = (_RIGHT - _LEFT) / len(shown)
    for place, column in enumerate(shown):
        name, unit = head(column, units)
        for line, part in enumerate(textwrap.wrap(name, 8, break_long_words=False)[::-1]):
            write(_LEFT + step * (place + 1) - 0.06, top + 0.14 + 0.13 * line, part, 7, ha="right", weight="bold")
        write(_LEFT + step * (place + 1) - 0.06, top, unit, 7, ha="right", colour=_GREY)
    y = top
    for number, row in enumerate(_chosen(plan)):
        y -= _ROW
        if number % 2 == 0:
            box = (_LEFT / _WIDTH, (y - 0.06) / _HEIGHT)
            paper.add_artist(Rectangle(box, (_RIGHT - _LEFT) / _WIDTH, _ROW / _HEIGHT, color=_BAND, zorder=-1))
        for place, column in enumerate(shown):
            write(_LEFT + step * (place + 1) - 0.06, y, cell(column, row, units), 9, ha="right")
    y -= 0.35
    for note in notes(plan):
        for part in textwrap.wrap(units.convert_text(note), _NOTE_WIDTH):
            if y > 0.45:
                write(_LEFT, y, part, 7.5)
                y -= 0.145
        y -= 0.05
    write(_LEFT, 0.28, f"slider_drilling {__version__}; a plan from the rig file's numbers, not a replacement for "
          "watching torque, pressure and hook load.", 7, colour=_GREY)  # fmt: skip
    buffer = io.BytesIO()
    # Without a creation date the same plan gives the same bytes.
    FigureCanvasPdf(paper).print_pdf(buffer, metadata={"CreationDate": None, "Title": "Rocking plan"})
    return buffer.getvalue()


def _chosen(plan: Plan) -> list:
    count = len(plan.rows)
    if count <= MAX_ROWS:
        return list(plan.rows)
    return [plan.rows[round(k * (count - 1) / (MAX_ROWS - 1))] for k in range(MAX_ROWS)]
