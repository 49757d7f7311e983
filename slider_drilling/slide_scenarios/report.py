"""Figures of the scenarios: JSON, the table of the terminal, and sentences."""

from __future__ import annotations

import math
import statistics
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from slider_drilling.slide_scenarios.contenders import BASELINES, UNDER_TEST, UPPER_BOUNDS
from slider_drilling.slide_scenarios.run import ScenarioResult
from slider_drilling.slide_scenarios.scenario import Scenario
from slider_drilling.slide_scenarios.score import SlideScore
from slider_drilling.units import Units, format_number

SCHEMA = "slider_drilling/closed_loop/1"
_HEADER = ("scenario", "mean\ndeg", "95 %\ndeg", "within\n15 deg", "set\ns", "informed\ndeg", "oracle\ndeg")


def by_scenario(results: Sequence[ScenarioResult], scenarios: Sequence[Scenario]) -> list[dict[str, ScenarioResult]]:
    """Return contender -> result for each scenario, in order; only scenarios that the controller under test ended."""
    table = [{result.contender: result for result in results if result.scenario is scenario
              or result.scenario == scenario} for scenario in scenarios]
    return [row for row in table if UNDER_TEST in row]


def as_json(rows: Sequence[dict[str, ScenarioResult]], name: str, seed: int, elements: int) -> dict[str, Any]:
    """Return the tree of closed_loop.json; NaN becomes null.

    Args:
        rows: Contender -> result for each scenario.
        name: module:Class of the controller under test.
        seed: Of sensor noise and faults.
        elements: Of the string.
    """
    scenarios = []
    for row in rows:
        scenario = row[UNDER_TEST].scenario
        head = {"name": scenario.name, "well": scenario.well, "about": scenario.about,
                "mwd_period_s": scenario.mwd_period,
                "interlocks": [{"time_s": round(time, 3), "name": interlock, "message": message}
                               for time, interlock, message in interlock_stops(row)]}
        others = {key: _figures(row[key].score) for key in (*UPPER_BOUNDS, *BASELINES) if key in row}
        scenarios.append({**head, **_figures(row[UNDER_TEST].score), **others})
    return {"schema": SCHEMA, "controller": name, "seed": seed, "elements": elements, "scenarios": scenarios}


def _figures(score: SlideScore) -> dict[str, float | None]:
    return {key: None if value is None or not math.isfinite(value) else round(value, 4)
            for key, value in asdict(score).items()}


def terminal_header(units: Units) -> tuple[str, ...]:
    """Column labels over `terminal_row`."""
    return (*_HEADER, f"torque\n{units.display_unit('kN m')}", f"ROP\n{units.display_unit('m/h')}")


def terminal_row(row: dict[str, ScenarioResult], units: Units) -> list[str]:
    """One line of the terminal's table, which fits 80 columns."""
    score, name = row[UNDER_TEST].score, row[UNDER_TEST].scenario.name
    bounds = [_mean_error(row, key) for key in UPPER_BOUNDS]
    end = [format_number(units.convert(score.peak_torque_n_m / 1e3, "kN m"), 2),
           format_number(units.convert(score.rop_m_h, "m/h"), 2)]
    if score.nothing_drilled:
        return [name, "idle", "-", "-", "-", *bounds, *end]
    return [name, f"{score.mean_abs_error_deg:.2f}", f"{score.p95_abs_error_deg:.1f}",
            f"{100.0 * score.within_15_deg:.1f} %", set_after(score), *bounds, *end]


def set_after(score: SlideScore) -> str:
    """Time to set the toolface, s, or "never"."""
    return "never" if score.time_to_set_s is None else f"{score.time_to_set_s:.0f}"


def information_costs(rows: Sequence[dict[str, ScenarioResult]]) -> str:
    """Return in a sentence what the inaccurate rig file and MWD cost; empty for fewer than two scenarios.

    Only scenarios count in which the controller under test and both upper bounds drilled.
    """
    contenders = (UNDER_TEST, *UPPER_BOUNDS)
    errors = [[row[key].score.mean_abs_error_deg for key in contenders] for row in rows
              if all(key in row and not row[key].score.nothing_drilled for key in contenders)]
    if len(errors) < 2:
        return ""
    own, informed, oracle = (statistics.median(column) for column in zip(*errors, strict=True))
    rig_file = statistics.median(row[0] - row[1] for row in errors)
    mwd = statistics.median(row[1] - row[2] for row in errors)
    return (f"Median error of {len(errors)} scenarios: {own:.2f} deg; {informed:.2f} deg with the true rig file, "
            f"{oracle:.2f} deg with the true toolface at 10 Hz as well. The inaccurate rig file costs {rig_file:+.2f} "
            f"deg, MWD {mwd:+.2f} deg (medians of the differences).")


def interlock_stops(row: dict[str, ScenarioResult]) -> list[tuple[float, str, str]]:
    """Return (s, name, message) of the first error of each interlock of the controller under test."""
    first: dict[str, tuple[float, str, str]] = {}
    for time, level, name, message in row[UNDER_TEST].trace.events:
        if level == "ERROR":
            first.setdefault(name, (time, name, message))
    return list(first.values())


def _mean_error(row: dict[str, ScenarioResult], contender: str) -> str:
    return f"{row[contender].score.mean_abs_error_deg:.2f}" if contender in row else ""
