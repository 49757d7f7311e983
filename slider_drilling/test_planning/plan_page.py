"""A planned test as a page for the driller: what to do, how long, within which limits, and what it will show."""

from __future__ import annotations

from math import pi
from pathlib import Path
from shlex import quote

import numpy as np

from slider_drilling.diagnosis.programme_words import programme_in_words
from slider_drilling.gap.experiment_design.detectable_size import POWER
from slider_drilling.pages import Chart, Headline, Line, Page, Panel, Section, Table
from slider_drilling.pages.colours import BLUE, GREEN, GREY, RED
from slider_drilling.pages.page import Cell
from slider_drilling.pages.titles import well_name
from slider_drilling.plain_names import plain_name
from slider_drilling.test_planning.drilling_plan import DrillingPlan
from slider_drilling.test_planning.effect_sizes import (
    EffectRow,
    cannot_tell,
    effect_rows,
    power_in_words,
    shown_value,
)
from slider_drilling.units import Quantity, Text, sentence

_TURN = 2.0 * pi


def plan_page(plan: DrillingPlan) -> Page:
    """The page as plain data, for `slider_drilling.pages` to write."""
    steps = programme_in_words(plan.programme, plan.rig)
    rows = tuple(
        (str(number), _clock(step.begin), step.text, Quantity(round(step.duration), "s", 3))
        for number, step in enumerate(steps, 1)
    )  # fmt: skip
    todo = Table(("step", "at, min:s", "what to do", "lasts"), rows)
    sections = [
        Section("What to do", (todo,)),
        Section("Limits: stop if one is reached", (_limits(plan),)),
        Section("How it runs", _charts(plan)),
        Section("What it will show", _shows(plan)),
        Section("What it cannot tell", tuple(cannot_tell(plan))),
    ]
    duration = steps[-1].begin + steps[-1].duration
    return Page("Test programme", well_name(plan.rig), tuple(sections), _facts(plan, duration), _headline(plan),
                _notes(plan))  # fmt: skip


def _clock(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes}:{rest:02d}"


def _facts(plan: DrillingPlan, duration: float) -> tuple[tuple[str, str], ...]:
    after = "no log yet"
    if plan.after is not None:
        count = len(plan.after.logs)
        after = f"{count} log{'' if count == 1 else 's'}, verdict: {plain_name(plan.after.verdict)}"
    return (("takes", f"{_clock(duration)} min"), ("known before", after))


def _headline(plan: DrillingPlan) -> Headline:
    rows = effect_rows(plan)
    better = [row for row in rows if row.power_with >= POWER]
    before = [row for row in rows if row.power_without >= POWER]
    than = "the logs so far show" if plan.plan.without is not None else "routine rocking of this length shows"
    beyond = ", but uses more of a limit than a test may" if plan.plan.baseline_beyond_limits else ""
    text = (
        f"This test shows {len(better)} of {len(rows)} possible effects of a usual size in {power_in_words()}; {than} "
        f"{len(before)}{beyond}."
    )
    return Headline(text, "plain", "test programme")


def _limits(plan: DrillingPlan) -> Table:
    steps, response = plan.programmes.limits.steps, plan.response
    rows: list[tuple[Cell, ...]] = [
        ("torque to the right", Quantity(steps.right_torque / 1e3, "kN m"),
         Quantity(float(response.surface_torque.max()) / 1e3, "kN m")),
        ("torque to the left", Quantity(steps.left_torque / 1e3, "kN m"),
         Quantity(max(-float(response.surface_torque.min()), 0.0) / 1e3, "kN m")),
        ("weight on bit", Quantity(steps.weight_on_bit / 1e3, "kN"),
         Quantity(float(response.weight_on_bit.max()) / 1e3, "kN")),
        ("standpipe pressure", Quantity(steps.pressure / 1e5, "bar"),
         Quantity(float(response.standpipe_pressure.max()) / 1e5, "bar")),
    ]  # fmt: skip
    swing = plan.programmes.limits.tool_face_swing
    if np.isfinite(swing):
        moved = float(np.max(np.abs(response.tool_face - response.tool_face[0])))
        rows.append(("toolface to either side", Quantity(np.degrees(swing), "deg"), Quantity(np.degrees(moved), "deg")))
    caption = (
        f"With everything that may be off, and all weight that friction holds come to the bit, the test uses up to "
        f"{100.0 * plan.plan.planned.limit_use:.0f} % of a limit."
    )
    return Table(("", "limit", "expected at most"), tuple(rows), caption)


def _charts(plan: DrillingPlan) -> tuple[Chart, ...]:
    response, steps = plan.response, plan.programmes.limits.steps
    commands = plan.programmes.commands(plan.plan.planned.manoeuvre)
    time, flow = commands.time, commands.pump_speed * plan.rig.mud_pump.displacement * 1e3
    orders = Chart("The drives", "time, s", (
        Panel("top drive, turns", (Line("top drive", time, commands.top_drive_angle / _TURN, colour=BLUE),)),
        Panel("block, lowered, m", (Line("block", time, commands.block_position, colour=GREEN),)),
        Panel("flow, L/s", (Line("flow", time, flow, colour=GREY),)),
    ))  # fmt: skip
    torque, weight = response.surface_torque / 1e3, response.weight_on_bit / 1e3
    bounds = [
        Line("limit right", time[[0, -1]], np.full(2, steps.right_torque / 1e3), "dashed", RED),
        Line("limit left", time[[0, -1]], np.full(2, -steps.left_torque / 1e3), "dashed", RED),
    ]
    expected = Chart("What to expect", "time, s", (
        Panel("surface torque, kN m", (Line("torque", time, torque, colour=BLUE), *bounds)),
        Panel("hook load, kN", (Line("hook load", time, response.hook_load / 1e3, colour=GREEN),)),
        Panel("weight on bit, kN", (Line("weight on bit", time, weight, colour=GREY),)),
        Panel("standpipe pressure, bar", (Line("pressure", time, response.standpipe_pressure / 1e5, colour=BLUE),)),
    ))  # fmt: skip
    return (orders, expected)


def _shows(plan: DrillingPlan) -> tuple[Text | Table, ...]:
    without = "after the logs so far" if plan.plan.without is not None else "with routine rocking"
    header = ("effect", "in", f"smallest that shows {without}", "with this test", "usual", f"power {without}",
              "power with this test")  # fmt: skip
    items: list[Text | Table] = [
        f"The smallest size of each effect that a diagnosis names in {power_in_words()}, while everything that is "
        "calibrated stays free and the simulator may be wrong by its own error; and the probability that a usual size "
        "is named.",
        Table(header, tuple(_cells(row) for row in effect_rows(plan)), digits=2),
    ]
    separations = plan.plan.planned.prospect.separations
    if separations:
        weights = {each.name: each.weight for each in plan.plan.knowledge.explanations}
        rows = tuple(
            (plain_name(each.first), _percent(weights[each.first]), plain_name(each.second),
             _percent(weights[each.second]), each.log_likelihood_ratio)
            for each in separations
        )  # fmt: skip
        items += [
            "What may explain the logs so far, and how well this test is expected to distinguish two of them: the "
            "logarithm of the likelihood ratio if one of them is true; 7 decides 1000 to 1.",
            Table(("explanation", "probability", "and", "probability", "expected log likelihood ratio"), rows),
        ]
    return tuple(items)


def _cells(row: EffectRow) -> tuple[Cell, ...]:
    return (
        plain_name(row.name), plain_name(row.parameter), shown_value(row.without, row.unit),
        shown_value(row.with_plan, row.unit), shown_value(row.usual, row.unit),
        _percent(row.power_without), _percent(row.power_with),
    )  # fmt: skip


def _percent(share: float) -> str:
    return f"{100.0 * share:.0f} %"


def _notes(plan: DrillingPlan) -> tuple[Text, ...]:
    lines: list[Text] = [
        "Rotate or rock off bottom first, so that no drag holds the string. Start with the bit just on bottom without "
        "weight, the string at rest and the pump at the reference flow, and record from the first second to the last.",
        "The toolface is not held: orient again after the test."
        if not np.isfinite(plan.programmes.limits.tool_face_swing)
        else "The toolface stays within its limit by the simulator; watch it.",
        "Sizes and powers follow from the rig file. A rig that differs more from it than a calibration shows less.",
    ]
    if plan.after is not None:
        logs = " ".join(quote(log) for log in plan.after.logs)
        # A log that was diagnosed for this plan alone has left no file to start from.
        start = f" --after {quote(plan.after.source)}" if Path(plan.after.source).exists() else ""
        lines.append(sentence(f"Then: slider-drilling diagnose {logs} NEW_LOG --together{start}"))
    return tuple(lines)
