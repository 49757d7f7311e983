"""Page of a closed loop: tables over all scenarios, and the time series of each."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from slider_drilling.pages import Bars, BulletList, Chart, Headline, Line, Page, Panel, Section, Table, Tag
from slider_drilling.pages.colours import AMBER, BLUE, GREEN, GREY, PURPLE, RED, SKY
from slider_drilling.pages.page import Cell, Tone
from slider_drilling.plain_names import plain_name
from slider_drilling.slide_scenarios.contenders import ABOUT, BASELINES, INFORMED, ORACLE, UNDER_TEST, UPPER_BOUNDS
from slider_drilling.slide_scenarios.report import information_costs, set_after
from slider_drilling.slide_scenarios.run import ScenarioResult
from slider_drilling.slide_scenarios.score import ALLOWED_TIME, MIN_HELD_SHARE, SET_TIME, TOLERANCE_DEG, error_deg
from slider_drilling.units import quantities_in

_CONTROL_HEADER = ("scenario", "well", "mean error, deg", "95 % below, deg", "within 15 deg, %", "set after, s")
_DRILLING_HEADER = ("scenario", "peak torque, kN m", "spread of weight on bit, kN", "rate of penetration, m/h")
_COMPARISON_HEADER = ("scenario", *(f"{plain_name(key)}, deg" for key in (UNDER_TEST, *UPPER_BOUNDS, *BASELINES)))
_COLOURS = {UNDER_TEST: BLUE, INFORMED: PURPLE, ORACLE: GREEN, "no_rocking": GREY, "fixed_rocking": AMBER,
            "shifted_rocking": RED}  # fmt: skip
_POINTS = 300  # per line


def closed_loop_page(rows: Sequence[dict[str, ScenarioResult]], name: str, seed: int, elements: int) -> Page:
    """Return the page of a closed loop.

    Args:
        rows: Contender -> result for each scenario.
        name: module:Class of the controller under test.
        seed: Of sensor noise and faults.
        elements: Of the string.
    """
    control = Section("Toolface", (
        f"Mean magnitude of the true toolface error, scored from {ALLOWED_TIME:.0f} s after the start and after each "
        f"new target. The toolface is set once it stays within {TOLERANCE_DEG:.0f} deg for {SET_TIME:.0f} s.",
        Table(_CONTROL_HEADER, tuple(_control_row(row) for row in rows)), _mean_errors(rows),
    ))  # fmt: skip
    comparison = Section("Compared with the other contenders", (
        "Mean toolface error of each contender.",
        BulletList(tuple(f"{plain_name(key)}: {ABOUT[key]}" for key in (*UPPER_BOUNDS, *BASELINES))),
        Table(_COMPARISON_HEADER, tuple(_comparison_row(row) for row in rows)), information_costs(rows),
    ))  # fmt: skip
    drilling = Section("Torque and drilling", (
        "Of the controller under test. Peak torque: the largest to either side. Spread: one standard deviation.",
        Table(_DRILLING_HEADER, tuple(_drilling_row(row) for row in rows)),
    ))  # fmt: skip
    facts = (("seed", str(seed)), ("elements", str(elements)))
    title = f"{name.partition(':')[2] or name} in {len(rows)} scenario{'' if len(rows) == 1 else 's'}"
    sections = (control, comparison, drilling, *(_scenario(row) for row in rows))
    return Page("Closed loop", title, sections, facts, _headline(rows))


def _control_row(row: dict[str, ScenarioResult]) -> tuple[Cell, ...]:
    scenario, score = row[UNDER_TEST].scenario, row[UNDER_TEST].score
    if score.nothing_drilled:
        return (scenario.name, scenario.well, Tag("nothing drilled", "bad"), None, None, "-")
    return (scenario.name, scenario.well, score.mean_abs_error_deg, score.p95_abs_error_deg,
            100.0 * score.within_15_deg, set_after(score))  # fmt: skip


def _comparison_row(row: dict[str, ScenarioResult]) -> tuple[Cell, ...]:
    contenders = (UNDER_TEST, *UPPER_BOUNDS, *BASELINES)
    return (row[UNDER_TEST].scenario.name, *(
        row[key].score.mean_abs_error_deg if key in row else None for key in contenders))  # fmt: skip


def _drilling_row(row: dict[str, ScenarioResult]) -> tuple[Cell, ...]:
    score = row[UNDER_TEST].score
    return (row[UNDER_TEST].scenario.name, score.peak_torque_n_m / 1e3, score.weight_spread_n / 1e3, score.rop_m_h)


def _headline(rows: Sequence[dict[str, ScenarioResult]]) -> Headline | None:
    scores = [row[UNDER_TEST].score for row in rows]
    idle = sum(score.nothing_drilled for score in scores)
    drilled = [score for score in scores if not score.nothing_drilled]
    errors = [score.mean_abs_error_deg for score in drilled]
    unset = sum(score.time_to_set_s is None for score in drilled)
    not_held = sum(score.within_15_deg < MIN_HELD_SHARE for score in drilled)
    sentences = []
    if errors:
        sentences.append(f"The toolface was {np.mean(errors):.1f} deg off its target on average, "
                         f"{max(errors):.1f} deg in the worst scenario.")  # fmt: skip
    if not_held:
        sentences.append(f"It was more than {TOLERANCE_DEG:.0f} deg off for over {100.0 * (1.0 - MIN_HELD_SHARE):.0f} "
                         f"% of the time in {not_held}.")  # fmt: skip
    sentences += [f"It was never set in {unset}."] if unset else []
    sentences += [f"Nothing was drilled in {idle}."] if idle else []
    tone: Tone = "bad" if idle or unset or not_held else "good"
    return Headline(" ".join(sentences), tone) if sentences else None


def _mean_errors(rows: Sequence[dict[str, ScenarioResult]]) -> Chart:
    drilled = [row for row in rows if not row[UNDER_TEST].score.nothing_drilled]
    names = tuple(row[UNDER_TEST].scenario.name for row in drilled)
    means = np.array([row[UNDER_TEST].score.mean_abs_error_deg for row in drilled])
    bars = Bars("", names, means, (BLUE,), tuple(f"{mean:.1f}" for mean in means), horizontal=True)
    panel = Panel("scenario", (bars,), height=max(0.09 * len(names), 0.35))
    return Chart("Mean error of the controller under test", "mean error, deg", (panel,), wide=True)


def _scenario(row: dict[str, ScenarioResult]) -> Section:
    scenario = row[UNDER_TEST].scenario
    items: list[str | Chart | Table] = [scenario.about, scenario_chart(row)]
    events = row[UNDER_TEST].trace.events
    if events:
        lines = tuple(
            (time, level, plain_name(name), quantities_in(message)) for time, level, name, message in events
        )
        items.append(Table(("time, s", "level", "status", "message"), lines, "Messages of the controller"))
    return Section(scenario.name, tuple(items), collapsed=True)


def scenario_chart(row: dict[str, ScenarioResult]) -> Chart:
    """Toolface error of every contender; top drive, torque and weight on bit of the controller under test."""
    errors = []
    for contender, result in row.items():
        error = error_deg(result.trace)
        # Break the line where the error wraps around.
        error[1:][np.abs(np.diff(error)) > 180.0] = np.nan
        name, hidden = plain_name(contender), contender not in (UNDER_TEST, ORACLE)
        errors.append(Line(name, result.trace.time, error, colour=_COLOURS.get(contender, SKY), hidden=hidden))
    trace, score = row[UNDER_TEST].trace, row[UNDER_TEST].score
    p95 = score.p95_abs_error_deg if math.isfinite(score.p95_abs_error_deg) else 0.0
    limit = min(max(1.5 * p95, TOLERANCE_DEG), 180.0)
    panels = (
        Panel("toolface error, deg", tuple(errors), limits=(-limit, limit), height=1.3),
        Panel("top drive, rad", (Line(UNDER_TEST, trace.time, trace.top_drive_angle, colour=BLUE),)),
        Panel("surface torque, kN m", (Line(UNDER_TEST, trace.time, trace.surface_torque / 1e3, colour=BLUE),)),
        Panel("weight on bit, kN", (Line(UNDER_TEST, trace.time, trace.weight_on_bit / 1e3, colour=BLUE),)),
    )
    caption = (f"The first axis ends at {limit:.0f} deg to either side; before the toolface is set, its error may lie "
               "outside. Click a name above the figure to show or hide a contender.")  # fmt: skip
    return Chart("Traces", "time, s", panels, caption, wide=True, max_points=_POINTS)
