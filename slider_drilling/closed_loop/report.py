"""The scenarios' figures as JSON and as the lines of a terminal's table."""

from __future__ import annotations

import math
import statistics
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from slider_drilling.closed_loop.contenders import BASELINES, LIMITS, UNDER_TEST
from slider_drilling.closed_loop.run import ScenarioResult
from slider_drilling.closed_loop.scenario import Scenario
from slider_drilling.closed_loop.score import SlideScore
from slider_drilling.units import Units, format_number

BRIEF = ("scenario", "mean", "95 %", "in 15", "set s", "informed", "oracle")


def by_scenario(outcomes: Sequence[ScenarioResult], scenarios: Sequence[Scenario]) -> list[dict[str, ScenarioResult]]:
    """Contender -> outcome for each scenario, in order."""
    table = [{outcome.contender: outcome for outcome in outcomes if outcome.scenario is scenario
              or outcome.scenario == scenario} for scenario in scenarios]
    return [row for row in table if UNDER_TEST in row]


def as_json(rows: Sequence[dict[str, ScenarioResult]], name: str, seed: int, elements: int) -> dict[str, Any]:
    """The figures of every scenario, each with those of the other contenders; NaN becomes null."""
    scenarios = []
    for row in rows:
        scenario = row[UNDER_TEST].scenario
        head = {"name": scenario.name, "well": scenario.well, "about": scenario.about,
                "mwd_period_s": scenario.mwd_period,
                "interlocks": [{"time_s": round(time, 3), "name": interlock, "message": message}
                               for time, interlock, message in interlock_stops(row)]}
        others = {key: _figures(row[key].score) for key in (*LIMITS, *BASELINES) if key in row}
        scenarios.append({**head, **_figures(row[UNDER_TEST].score), **others})
    return {"schema": "slider_drilling/closed_loop/1", "controller": name, "seed": seed, "elements": elements,
            "scenarios": scenarios}


def _figures(score: SlideScore) -> dict[str, float | None]:
    return {key: None if value is None or not math.isfinite(value) else round(value, 4)
            for key, value in asdict(score).items()}


def brief_heads(units: Units) -> tuple[str, ...]:
    """Over the columns of `brief_cells`."""
    return (*BRIEF, units.display_unit("kN m"), units.display_unit("m/h"))


def brief_cells(row: dict[str, ScenarioResult], units: Units) -> list[str]:
    """One line of the terminal's table, which fits 80 columns: a cell for each of `brief_heads`."""
    own = row[UNDER_TEST].score
    end = [
        format_number(units.convert(own.peak_torque_n_m / 1e3, "kN m"), 2),
        format_number(units.convert(own.rop_m_h, "m/h"), 2),
    ]
    if own.nothing_drilled:
        return [row[UNDER_TEST].scenario.name, "idle", "-", "-", "-", *(_mean(row, key) for key in LIMITS), *end]
    set_after = "never" if own.time_to_set_s is None else f"{own.time_to_set_s:.0f}"
    return [row[UNDER_TEST].scenario.name, f"{own.mean_abs_error_deg:.2f}", f"{own.p95_abs_error_deg:.1f}",
            f"{100.0 * own.within_15_deg:.1f}", set_after, *(_mean(row, key) for key in LIMITS), *end]


def information_costs(rows: Sequence[dict[str, ScenarioResult]]) -> str:
    """In a sentence, over the scenarios in which all three drilled: what not knowing the rig costs, what MWD does. None
    of one scenario, whose figures stand above it."""
    means = [[row[key].score.mean_abs_error_deg for key in (UNDER_TEST, *LIMITS)] for row in rows
             if all(key in row and not row[key].score.nothing_drilled for key in (UNDER_TEST, *LIMITS))]
    if len(means) < 2:
        return ""
    own, informed, oracle = (statistics.median(column) for column in zip(*means, strict=True))
    unknown = statistics.median(one[0] - one[1] for one in means)
    mwd = statistics.median(one[1] - one[2] for one in means)
    return (f"Half of {len(means)} scenarios: below {own:.2f} deg, {informed:.2f} with the true rig file, {oracle:.2f} "
            f"with the true toolface at 10 Hz too. Not knowing the rig costs {unknown:+.2f} deg, the period and the "
            f"noise of MWD alone {mwd:+.2f} deg (medians).")


def interlock_stops(row: dict[str, ScenarioResult]) -> list[tuple[float, str, str]]:
    """When (s) each interlock of the controller under test first stopped something, its name, and why."""
    first: dict[str, tuple[float, str, str]] = {}
    for time, level, name, message in row[UNDER_TEST].trace.events:
        if level == "ERROR":
            first.setdefault(name, (time, name, message))
    return list(first.values())


def _mean(row: dict[str, ScenarioResult], contender: str) -> str:
    return f"{row[contender].score.mean_abs_error_deg:.2f}" if contender in row else ""
