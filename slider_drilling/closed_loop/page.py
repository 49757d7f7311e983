"""The scenarios on a page: one table, and every scenario's traces."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from slider_drilling.closed_loop.contenders import ABOUT, BASELINES, INFORMED, LIMITS, ORACLE, UNDER_TEST
from slider_drilling.closed_loop.report import information_costs
from slider_drilling.closed_loop.run import ScenarioResult
from slider_drilling.closed_loop.score import ALLOWED, HELD, HELD_SHARE, WITHIN_DEG, SlideScore, error_deg
from slider_drilling.pages import Bars, Chart, Headline, Line, Page, Panel, Section, Table, Tag
from slider_drilling.pages.colours import AMBER, BLUE, GREEN, GREY, PURPLE, RED, SKY
from slider_drilling.pages.page import Cell

HEADS = ("scenario", "well", "mean error, deg", "95 % below, deg", "within 15 deg, %", "set after, s", "informed, deg",
         "oracle, deg", "no rocking, deg", "fixed, deg", "shifted, deg", "peak torque, kN m", "WOB spread, kN",
         "ROP, m/h")  # fmt: skip
_COLOURS = {UNDER_TEST: BLUE, INFORMED: PURPLE, ORACLE: GREEN, "no_rocking": GREY, "fixed_rocking": AMBER,
            "shifted_rocking": RED}  # fmt: skip
_POINTS = 300  # of a line: enough for the outline of a slide


def closed_loop_page(rows: Sequence[dict[str, ScenarioResult]], name: str, seed: int, elements: int) -> Page:
    """Contender -> outcome for each scenario; `name` is the controller under test."""
    table = Section("Every scenario", (
        f"Error of the toolface on truth, mean of its magnitude, from {ALLOWED:.0f} s after the start and after each "
        f"new target. Set: within {WITHIN_DEG:.0f} deg for {HELD:.0f} s without a break. Peak torque: of either sign. "
        + " ".join(f"{key.replace('_', ' ').capitalize()}: {ABOUT[key]}." for key in (*LIMITS, *BASELINES)),
        Table(HEADS, tuple(cells(row) for row in rows)), information_costs(rows), _means(rows),
    ))  # fmt: skip
    scenarios = tuple(_scenario(row) for row in rows)
    facts = (("seed", str(seed)), ("elements", str(elements)))
    title = f"{name.partition(':')[2] or name} in {len(rows)} scenario{'' if len(rows) == 1 else 's'}"
    return Page("Closed loop", title, (table, *scenarios), facts,
                _lead(rows))  # fmt: skip


def cells(row: dict[str, ScenarioResult]) -> tuple[Cell, ...]:
    """One line of the table: a cell for each of `HEADS`."""
    scenario, own = row[UNDER_TEST].scenario, row[UNDER_TEST].score
    others = tuple(row[key].score.mean_abs_error_deg if key in row else None for key in (*LIMITS, *BASELINES))
    held: tuple[Cell, ...] = (own.mean_abs_error_deg, own.p95_abs_error_deg, 100.0 * own.within_15_deg, set_after(own))
    if own.nothing_drilled:
        held = (Tag("nothing drilled", "bad"), None, None, "-")
    return (scenario.name, scenario.well, *held, *others, own.peak_torque_n_m / 1e3, own.weight_spread_n / 1e3,
            own.rop_m_h)  # fmt: skip


def set_after(own: SlideScore) -> str:
    """Seconds, or that it never was."""
    return "never" if own.time_to_set_s is None else f"{own.time_to_set_s:.0f}"


def _lead(rows: Sequence[dict[str, ScenarioResult]]) -> Headline | None:
    own = [row[UNDER_TEST].score for row in rows]
    idle = sum(score.nothing_drilled for score in own)
    errors = [score.mean_abs_error_deg for score in own if not score.nothing_drilled]
    unset = sum(score.time_to_set_s is None for score in own if not score.nothing_drilled)
    said = []
    if errors:
        said.append(f"The toolface was {np.mean(errors):.1f} deg off its target on average, "
                    f"{max(errors):.1f} deg in the worst scenario.")  # fmt: skip
    lost = sum(score.within_15_deg < HELD_SHARE for score in own if not score.nothing_drilled)
    share = f"{1.0 - HELD_SHARE:.0%}".replace("%", " %")
    said += [f"It was more than {WITHIN_DEG:.0f} deg off for over {share} of the time in {lost}."] if lost else []
    said += [f"It was never set in {unset}."] if unset else []
    said += [f"Nothing was drilled in {idle}."] if idle else []
    return Headline(" ".join(said), "bad" if idle or unset or lost else "good") if said else None


def _means(rows: Sequence[dict[str, ScenarioResult]]) -> Chart:
    shown = [row for row in rows if not row[UNDER_TEST].score.nothing_drilled]
    names = tuple(row[UNDER_TEST].scenario.name for row in shown)
    means = np.array([row[UNDER_TEST].score.mean_abs_error_deg for row in shown])
    bars = Bars("", names, means, (BLUE,), tuple(f"{mean:.1f}" for mean in means), horizontal=True)
    panel = Panel("scenario", (bars,), height=max(0.09 * len(names), 0.35))
    return Chart("Mean error of the controller under test", "mean error, deg", (panel,), wide=True)


def _scenario(row: dict[str, ScenarioResult]) -> Section:
    scenario = row[UNDER_TEST].scenario
    items: list[str | Chart | Table] = [scenario.about, _traces(row)]
    events = row[UNDER_TEST].trace.events
    if events:
        lines = tuple((time, level, name.replace("_", " "), message) for time, level, name, message in events)
        items.append(Table(("time, s", "", "", "what its interlocks said"), lines))
    return Section(scenario.name, tuple(items), collapsed=True)


def _traces(row: dict[str, ScenarioResult]) -> Chart:
    """Every contender's error; top drive, torque and weight of the one under test."""
    errors = []
    for contender, outcome in row.items():
        error = error_deg(outcome.trace)
        error[1:][np.abs(np.diff(error)) > 180.0] = np.nan
        name, hidden = contender.replace("_", " "), contender not in (UNDER_TEST, ORACLE)
        errors.append(Line(name, outcome.trace.time, error, colour=_COLOURS.get(contender, SKY), hidden=hidden))
    own, score = row[UNDER_TEST].trace, row[UNDER_TEST].score
    most = score.p95_abs_error_deg if math.isfinite(score.p95_abs_error_deg) else 0.0
    reach = min(max(1.5 * most, WITHIN_DEG), 180.0)
    panels = (
        Panel("toolface error, deg", tuple(errors), limits=(-reach, reach), height=1.3),
        Panel("top drive, rad", (Line(UNDER_TEST, own.time, own.top_drive_angle, colour=BLUE),)),
        Panel("surface torque, kN m", (Line(UNDER_TEST, own.time, own.surface_torque / 1e3, colour=BLUE),)),
        Panel("weight on bit, kN", (Line(UNDER_TEST, own.time, own.weight_on_bit / 1e3, colour=BLUE),)),
    )
    caption = (f"The first axis shows {reach:.0f} deg to either side, where the controller stays once set; before "
               "that the error may lie outside. Names above the figure show and hide what else ran.")  # fmt: skip
    return Chart("Traces", "time, s", panels, caption, wide=True, max_points=_POINTS)
