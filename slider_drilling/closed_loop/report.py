"""The scenarios' figures as JSON and as a page that stands alone."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slider_drilling.closed_loop.contenders import ABOUT, BASELINES, INFORMED, LIMITS, ORACLE, UNDER_TEST
from slider_drilling.closed_loop.run import Outcome
from slider_drilling.closed_loop.scenario import Scenario
from slider_drilling.closed_loop.score import ALLOWED, HELD, WITHIN_DEG, Score, error_deg
from slider_drilling.closed_loop.trace import Array, Trace
from slider_drilling.files import write_whole

_COLOURS = {UNDER_TEST: "#00798c", INFORMED: "#7a5195", ORACLE: "#2f4b7c",
            "no_rocking": "#7b8794", "fixed_rocking": "#edae49", "shifted_rocking": "#d1495b"}
_STRETCHES = 150   # of a trace, each drawn by its least and its greatest value
PAGE = """\
<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>Closed loop</title>
<style>
 body { font: 15px/1.45 system-ui, sans-serif; max-width: 1180px; margin: 1.5rem auto; padding: 0 1rem; color: #1c2733 }
 h1 { font-size: 1.3rem } h2 { font-size: 1.1rem; margin: 2rem 0 .2rem }
 table { border-collapse: collapse; margin: .5rem 0 1rem; font-size: .88rem }
 td, th { padding: .15rem .8rem .15rem 0; border-bottom: 1px solid #e3e8ee; text-align: right }
 td:first-child, th:first-child { text-align: left } p, footer { color: #53606e } .off { color: #b3261e }
</style></head><body>
<h1>Closed loop: {{ name }}</h1>
<p>Tool-face error on truth, from {{ allowed }} s after the start and after each new target. Set: within {{ within }}
degrees for {{ held }} s without a break. Peak torque is of either sign.</p>
<table><tr>{% for head in heads %}<th>{{ head }}</th>{% endfor %}</tr>
{% for row in rows %}<tr>{% for cell in row %}<td>{{ cell }}</td>{% endfor %}</tr>{% endfor %}</table>
{% for scenario in scenarios %}<h2>{{ scenario.name }}</h2><p>{{ scenario.about }}</p>{{ scenario.plot | safe }}
{% if scenario.events %}<table>{% for event in scenario.events %}<tr>{% for cell in event %}<td>{{ cell }}</td>
{% endfor %}</tr>{% endfor %}</table>{% endif %}{% endfor %}
<footer>seed {{ seed }}, {{ elements }} elements</footer>
</body></html>
"""
HEADS = ("scenario", "well", "mean |error| deg", "95 % below", "within 15 deg %", "set s", "informed", "oracle",
         "no rocking", "fixed", "shifted", "peak torque kN m", "WOB spread kN", "ROP m/h")
BRIEF = ("scenario", "mean", "95 %", "in 15", "set s", "informed", "oracle", "kN m", "m/h")


def by_scenario(outcomes: Sequence[Outcome], scenarios: Sequence[Scenario]) -> list[dict[str, Outcome]]:
    """Contender -> outcome for each scenario, in order."""
    table = [{outcome.contender: outcome for outcome in outcomes if outcome.scenario is scenario
              or outcome.scenario == scenario} for scenario in scenarios]
    return [row for row in table if UNDER_TEST in row]


def as_json(rows: Sequence[dict[str, Outcome]], name: str, seed: int, elements: int) -> dict[str, Any]:
    """The figures of every scenario, each with those of the other contenders; NaN becomes null."""
    scenarios = []
    for row in rows:
        scenario = row[UNDER_TEST].scenario
        head = {"name": scenario.name, "well": scenario.well, "about": scenario.about,
                "mwd_period_s": scenario.mwd_period}
        others = {key: _figures(row[key].score) for key in (*LIMITS, *BASELINES) if key in row}
        scenarios.append({**head, **_figures(row[UNDER_TEST].score), **others})
    return {"schema": "slider_drilling/closed_loop/1", "controller": name, "seed": seed, "elements": elements,
            "scenarios": scenarios}


def _figures(score: Score) -> dict[str, float | None]:
    return {key: None if value is None or not math.isfinite(value) else round(value, 4)
            for key, value in asdict(score).items()}


def cells(row: dict[str, Outcome]) -> list[str]:
    """One line of the page's table: a cell for each of `HEADS`."""
    scenario, own = row[UNDER_TEST].scenario, row[UNDER_TEST].score
    return [scenario.name, scenario.well, f"{own.mean_abs_error_deg:.2f}", f"{own.p95_abs_error_deg:.1f}",
            f"{100.0 * own.within_15_deg:.1f}", _set_after(own), *(_mean(row, key) for key in (*LIMITS, *BASELINES)),
            f"{own.peak_torque_n_m / 1e3:.2f}", f"{own.weight_spread_n / 1e3:.1f}", f"{own.rop_m_h:.2f}"]


def brief_cells(row: dict[str, Outcome]) -> list[str]:
    """One line of the terminal's table, which fits 80 columns: a cell for each of `BRIEF`."""
    own = row[UNDER_TEST].score
    return [row[UNDER_TEST].scenario.name, f"{own.mean_abs_error_deg:.2f}", f"{own.p95_abs_error_deg:.1f}",
            f"{100.0 * own.within_15_deg:.1f}", _set_after(own), *(_mean(row, key) for key in LIMITS),
            f"{own.peak_torque_n_m / 1e3:.1f}", f"{own.rop_m_h:.1f}"]


def _mean(row: dict[str, Outcome], contender: str) -> str:
    return f"{row[contender].score.mean_abs_error_deg:.2f}" if contender in row else ""


def _set_after(own: Score) -> str:
    return "never" if own.time_to_set_s is None else f"{own.time_to_set_s:.0f}"


def write_page(path: Path, rows: Sequence[dict[str, Outcome]], name: str, seed: int, elements: int) -> None:
    """The table and every scenario's plots; needs no network. Raises InputError."""
    import jinja2

    shown = [{"name": row[UNDER_TEST].scenario.name, "about": row[UNDER_TEST].scenario.about,
              "plot": _plot(row, first=index == 0), "events": _events(row[UNDER_TEST].trace)}
             for index, row in enumerate(rows)]
    template = jinja2.Environment(autoescape=True).from_string(PAGE)
    page = template.render(name=name, allowed=f"{ALLOWED:.0f}", within=f"{WITHIN_DEG:.0f}", held=f"{HELD:.0f}",
                           heads=HEADS, rows=[cells(row) for row in rows], scenarios=shown, seed=seed,
                           elements=elements)
    write_whole(path, page.encode("utf-8"))


def _plot(row: dict[str, Outcome], first: bool) -> str:
    import plotly.graph_objects as go
    from plotly.subplots import make_subplots

    titles = ("tool-face error<br>deg", "top drive<br>rad", "surface torque<br>kN m", "weight on bit<br>kN")
    figure = make_subplots(rows=len(titles), cols=1, shared_xaxes=True, vertical_spacing=0.03)
    for contender, outcome in row.items():
        trace = outcome.trace
        series = (error_deg(trace), trace.top_drive_angle, trace.surface_torque / 1e3, trace.weight_on_bit / 1e3)
        for index, values in enumerate(series):
            time, drawn = thinned(trace.time, values)
            if index == 0:
                drawn[1:][np.abs(np.diff(drawn)) > 180.0] = np.nan
            figure.add_trace(
                go.Scatter(x=time, y=drawn, name=ABOUT[contender],
                           legendgroup=contender, showlegend=index == 0, line_color=_COLOURS[contender],
                           line_width=1.4 if contender == UNDER_TEST else 0.8,
                           visible=True if index == 0 or contender == UNDER_TEST else "legendonly"),
                row=index + 1, col=1)
    for index, title in enumerate(titles):
        figure.update_yaxes(title_text=title, row=index + 1, col=1)
    figure.update_xaxes(title_text="time, s", row=len(titles), col=1)
    figure.update_layout(height=640, margin={"l": 80, "r": 20, "t": 10, "b": 40}, template="plotly_white",
                         legend={"orientation": "h", "y": -0.1})
    html: str = figure.to_html(full_html=False, include_plotlyjs=first)
    return html


def thinned(time: Array, values: Array) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """The least and the greatest value of each stretch, in order of time: fewer points, the same outline. Single
    precision is what a plot needs, and half the page."""
    picked: set[int] = set()
    for stretch in np.array_split(np.arange(len(values)), _STRETCHES):
        if len(stretch):
            picked |= {int(stretch[np.argmin(values[stretch])]), int(stretch[np.argmax(values[stretch])])}
    index = np.array(sorted(picked), dtype=int)
    return time[index].astype(np.float32), values[index].astype(np.float32)


def _events(trace: Trace) -> list[tuple[str, ...]]:
    return [(f"{time:.0f} s", level, name.replace("_", " "), message) for time, level, name, message in trace.events]
