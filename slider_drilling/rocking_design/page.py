"""A rocking plan as a page."""

from __future__ import annotations

import numpy as np

from slider_drilling.log.series import Array
from slider_drilling.pages import Chart, Line, Page, Panel, Section, Table
from slider_drilling.pages.colours import BLUE, GREEN, GREY, RED
from slider_drilling.rocking_design.plan import Plan
from slider_drilling.rocking_design.plan_table import cell, columns, facts, head, notes, title
from slider_drilling.units import Units


def plan_page(plan: Plan, units: Units, block_weight: float = 0.0) -> Page:
    """The page: the driller's table, and its columns over depth.

    Args:
        plan: The plan.
        units: Of the page.
        block_weight: Added to hook loads, N.
    """
    shown = columns(block_weight)
    heads = tuple(", ".join(filter(None, head(column, units))) for column in shown)
    rows = tuple(tuple(cell(column, row, units) for column in shown) for row in plan.rows)
    charts = plan_charts(plan) if len(plan.rows) > 1 else ()
    sections = (Section("How to rock", (Table(heads, rows),)), *((Section("Over depth", charts),) if charts else ()))
    shown_facts = tuple((name, units.convert_text(text)) for name, text in facts(plan))
    return Page("Rocking plan", title(plan, units), sections, shown_facts, notes=notes(plan))


def plan_charts(plan: Plan) -> tuple[Chart, ...]:
    """Turning points, torque and weight on bit over the bit's depth."""
    depth = np.array([row.depth for row in plan.rows])

    def over_depth(name: str, label: str, *lines: Line) -> Chart:
        return Chart(name, label, (Panel("bit depth, m", lines, inverted=True),))

    def line(name: str, values: list[float], colour: str, style: str = "line") -> Line:
        array: Array = np.array(values)
        return Line(name, array, depth, style, colour)  # type: ignore[arg-type]

    rows = plan.rows
    return (
        over_depth("Turning points from neutral", "angle to the right, rad",
                   line("right", [row.right for row in rows], GREEN), line("left", [-row.left for row in rows], RED),
                   line("offset", [row.offset for row in rows], GREY, "dashed")),
        over_depth("Torque at the turning points", "surface torque, kN m",
                   line("right", [row.steady.torque_right / 1e3 for row in rows], GREEN),
                   line("left", [row.steady.torque_left / 1e3 for row in rows], RED)),
        over_depth("Weight on bit at the same hook load", "weight on bit, kN",
                   line("with rocking", [row.steady.weight_on_bit / 1e3 for row in rows], BLUE),
                   line("without rocking", [row.weight_without_rocking / 1e3 for row in rows], RED)),
        over_depth("Depth that rocking frees", "measured depth, m",
                   line("rocks down to", [row.steady.rocked_to for row in rows], BLUE),
                   line("bit", [row.depth for row in rows], GREY, "dashed")),
    )  # fmt: skip
