"""report.html: the diagnosis as one page that stands alone."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from slider_drilling.diagnosis.diagnose import Diagnosis

_SHOWN = {"N m": (1e-3, "kN m"), "N": (1e-3, "kN"), "Pa": (1e-5, "bar"), "rad": (180.0 / np.pi, "deg")}
_BLUE, _RED, _GREEN, _GREY = "#0072b2", "#d55e00", "#009e73", "#7f7f7f"
_STAGES = {"nominal": "as given", "tuned": "re-tuned", "with_effect": "with effect"}
_COLOURS = {"nominal": _GREY, "tuned": _BLUE, "with_effect": _GREEN}
_MOST_POINTS = 1500

PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width">
<title>Diagnosis: {{ logs | join(", ") }}</title>
<style>
 body { font: 15px/1.5 system-ui, sans-serif; max-width: 1100px; margin: 2rem auto; padding: 0 1rem; color: #1c2733 }
 .verdict { border-left: 6px solid {{ colour }}; background: #f4f7fa; padding: .8rem 1.2rem; font-size: 1.15rem }
 .verdict b { text-transform: uppercase; letter-spacing: .04em; font-size: .85rem; color: {{ colour }} }
 table { border-collapse: collapse; margin: 1rem 0 } td, th { padding: .25rem .8rem; border-bottom: 1px solid #dde4ec;
 text-align: left; vertical-align: top } td.n { text-align: right; font-variant-numeric: tabular-nums }
 .dim { color: #69788a } h2 { margin-top: 2.2rem }
</style></head><body>
<h1>Sim-to-real gap</h1><p class="dim">{{ logs | join(", ") }}</p>
<p class="verdict"><b>{{ verdict | replace("_", " ") }}{% if partial %} (partial){% endif %}</b><br>{{ sentence }}</p>
{% if remarks %}<ul>{% for line in remarks %}<li>{{ line }}</li>{% endfor %}</ul>{% endif %}
<h2>How large</h2>
<p>E is the RMS difference in noise floors (with what the final model itself cannot foretell, after a bit has broken
free); 1 is a perfect model, {{ threshold }} is what noise alone can reach.
Held out: every stretch is scored by parameters fitted without it.</p>
{{ waterfall | safe }}
<table><tr><th>channel</th><th>noise floor</th><th>from</th><th>nominal</th><th>re-tuned</th><th>with effect</th></tr>
{% for row in channels %}<tr>{% for cell in row %}<td class="{{ "n" if loop.index in (2, 4, 5, 6) }}">{{ cell }}</td>
{% endfor %}</tr>{% endfor %}</table>
<h3>In one run through the log</h3>
<p>RMS error of one simulation of the whole log with each stage's parameters{% if beyond %}; no fit has seen the rest of
the log{% endif %}.</p>
<table><tr>{% for head in simulated[0] %}<th>{{ head }}</th>{% endfor %}</tr>
{% for row in simulated[1] %}<tr>{% for cell in row %}<td class="{{ "n" if loop.index not in (1, 3) }}">{{ cell }}</td>
{% endfor %}</tr>{% endfor %}</table>
<h2>Where</h2>{{ where | safe }}
<h2>Which</h2>
<table><tr><th>effect</th><th>site</th><th>gap closed</th><th>95 %</th><th>parameters</th><th>not told apart from</th>
<th>verdict on it</th></tr>
{% for row in ranking %}<tr>{% for cell in row %}<td>{{ cell }}</td>{% endfor %}</tr>{% endfor %}</table>
{{ intervals | safe }}
{% if manoeuvre %}<h2>What to do next</h2><p>{{ manoeuvre }}</p>{% endif %}
{% if would_help %}<p>With more channels more could be told apart:</p>
<ul>{% for line in would_help %}<li>{{ line }}</li>{% endfor %}</ul>{% endif %}
<h2>Measured and simulated</h2>
<p>One simulation of the whole log with each stage's parameters{% if beyond %}; what follows the dotted line was not
fitted{% endif %}.</p>{{ traces | safe }}
<h2>Parameters</h2><table>{% for name, value in parameters %}<tr><td>{{ name }}</td><td class="n">{{ value }}</td></tr>
{% endfor %}</table><p class="dim">Took {{ runtime }} s.</p></body></html>
"""


def report_page(diagnosis: Diagnosis) -> str:
    """The page's HTML, plots included; it needs no network."""
    import jinja2

    answer = diagnosis.answer
    template = jinja2.Environment(autoescape=True).from_string(PAGE)
    calm = {"none": _GREEN, "parameters": _GREEN, "effect": _BLUE}
    return template.render(
        logs=diagnosis.logs, verdict=diagnosis.verdict, sentence=diagnosis.sentence, partial=answer.partial,
        colour=calm.get(diagnosis.verdict, _RED), threshold=f"{answer.threshold:.2f}",
        remarks=[*diagnosis.remarks, *answer.remarks],
        waterfall=_waterfall(diagnosis), channels=_channel_rows(diagnosis), where=_where(diagnosis),
        ranking=_ranking_rows(diagnosis), intervals=_intervals(diagnosis), manoeuvre=_manoeuvre(diagnosis),
        would_help=diagnosis.would_help, traces=_traces(diagnosis),
        parameters=[(name, f"{value:.4g}") for name, value in answer.parameters.items()],
        runtime=f"{answer.runtime:.0f}", simulated=simulated_table(diagnosis), beyond=bool(diagnosis.beyond.rest),
    )  # fmt: skip


def _html(figure: Any, first: bool = False) -> str:
    figure.update_layout(template="plotly_white", margin={"l": 70, "r": 20, "t": 30, "b": 45})
    return str(figure.to_html(full_html=False, include_plotlyjs=first))


def _waterfall(diagnosis: Diagnosis) -> str:
    import plotly.graph_objects as go

    answer = diagnosis.answer
    names = list(_STAGES.values())[: 3 if answer.effects else 2]
    values = [answer.nominal, answer.tuned, answer.with_effect][: len(names)]
    figure = go.Figure(go.Bar(x=names, y=values, marker_color=list(_COLOURS.values())[: len(names)],
                              text=[f"{value:.2f}" for value in values], textposition="outside"))  # fmt: skip
    figure.add_hline(y=answer.threshold, line_dash="dot", annotation_text="noise alone")
    figure.update_yaxes(title_text="E, noise floors", type="log" if max(values) > 8.0 else "linear")
    figure.update_layout(height=320)
    return _html(figure, first=True)


def _channel_rows(diagnosis: Diagnosis) -> list[list[str]]:
    from slider_drilling.diagnosis.diagnose import rms_by_stage

    answer = diagnosis.answer
    stages = rms_by_stage(answer)
    rows = []
    for channel in diagnosis.prepared.model.runs[0].channels:
        factor, unit = _SHOWN[channel.unit]
        floor = answer.floors[0][channel.name]
        row = [channel.name.replace("_", " "), f"{floor.sigma * factor:.3g} {unit}", floor.method]
        for stage in _STAGES:
            value = stages.get(stage, {}).get(channel.name)
            row.append("-" if value is None else f"{value * factor:.3g} {unit}")
        rows.append(row)
    return rows


def simulated_table(diagnosis: Diagnosis) -> tuple[list[str], list[list[str]]]:
    """Headings and rows: RMS error of one simulation with each stage's parameters, by channel and part of the log."""
    beyond = diagnosis.beyond
    parts = [("whole log", beyond.whole)]
    if beyond.rest:
        share = f"{100.0 * beyond.share:.0f} %"
        parts = [(f"first {share}, fitted", beyond.fitted), ("the rest, not fitted", beyond.rest), *parts]
    channels = {channel.name: channel for run in diagnosis.prepared.model.runs for channel in run.channels}
    rows = []
    for stage, freed in beyond.freed.items():
        for name, channel in channels.items():
            factor, unit = _SHOWN[channel.unit]
            errors = [f"{factor * part[stage][name]:.3g} {unit}" for _, part in parts]
            rows.append([_STAGES[stage], str(freed), name.replace("_", " "), *errors])
    return ["", "parameters fitted", "channel", *(title for title, _ in parts)], rows


def _where(diagnosis: Diagnosis) -> str:
    import plotly.graph_objects as go
    from plotly.subplots import make_subplots

    where = diagnosis.answer.where
    if where is None:
        return "<p>Not known.</p>"
    titles = ("channel", "phase", "frequency", "time, s", "measured depth, m")
    figure = make_subplots(rows=2, cols=3, subplot_titles=titles, vertical_spacing=0.25)
    for place, shares in enumerate((where.channel, where.phase, where.band), start=1):
        figure.add_trace(go.Bar(x=[name.replace("_", " ") for name in shares], y=list(shares.values()),
                                marker_color=_BLUE), row=1, col=place)  # fmt: skip
    for place, rows in enumerate((where.time, where.depth), start=1):
        middle = [0.5 * (row["from"] + row["to"]) for row in rows]
        width = [0.9 * (row["to"] - row["from"]) for row in rows]
        colour = [_RED if row.get("change", 0.0) > 0.0 else _BLUE for row in rows]
        note = [f"friction {100.0 * row['change']:+.0f} %" if "change" in row else "" for row in rows]
        figure.add_trace(go.Bar(x=middle, y=[row["share"] for row in rows], width=width, marker_color=colour,
                                hovertext=note), row=2, col=place)  # fmt: skip
    figure.update_yaxes(title_text="share of E^2", col=1)
    figure.update_layout(height=620, showlegend=False)
    return _html(figure) + "<p class='dim'>Depth: red asks for more friction there, blue for less.</p>"


def _ranking_rows(diagnosis: Diagnosis) -> list[list[str]]:
    rows = []
    for entry in diagnosis.answer.ranking:
        settings = ", ".join(f"{name.rpartition('.')[2]} {value:.4g}" for name, value in entry.parameters.items())
        judged = "accepted" if entry.accepted else "; ".join(entry.reasons)
        rows.append([entry.effect, entry.site, *entry.shown(), settings, ", ".join(entry.group), judged])
    return rows


def _intervals(diagnosis: Diagnosis) -> str:
    import plotly.graph_objects as go

    shown = [entry for entry in diagnosis.answer.ranking if entry.fitted and not np.isnan(entry.interval[0])]
    if not shown:
        return ""
    shown = shown[::-1]
    figure = go.Figure(go.Scatter(
        x=[entry.closed for entry in shown], y=[entry.effect for entry in shown], mode="markers",
        marker={"size": 9, "color": [_GREEN if entry.accepted else _GREY for entry in shown]},
        error_x={"type": "data", "symmetric": False,
                 "array": [entry.interval[1] - entry.closed for entry in shown],
                 "arrayminus": [entry.closed - entry.interval[0] for entry in shown]},
    ))  # fmt: skip
    figure.update_xaxes(title_text="share of the gap closed on held-out stretches", range=[-1.0, 1.15])
    figure.update_layout(height=90 + 40 * len(shown))
    return _html(figure)


def _manoeuvre(diagnosis: Diagnosis) -> str:
    found = diagnosis.answer.manoeuvre
    if found is None:
        return ""
    first, second = found.separates
    return (
        f"To tell {first} from {second}: {found.description}. The two would differ by {found.distance:.1f} noise "
        f"floors there; in this log they differ by {found.now:.1f}."
    )


def _traces(diagnosis: Diagnosis) -> str:
    from plotly.subplots import make_subplots

    beyond = diagnosis.beyond
    problem = beyond.problem
    stages = [(_STAGES[stage], left, _COLOURS[stage]) for stage, left in beyond.left.items()]
    channels = [(index, channel) for index, run in enumerate(problem.model.runs) for channel in run.channels]
    figure = make_subplots(rows=2 * len(channels), cols=1, shared_xaxes=True, vertical_spacing=0.015)
    for place, (index, channel) in enumerate(channels):
        factor, unit = _SHOWN[channel.unit]
        part = problem.slices[index, channel.name]
        keep = slice(None, None, max(channel.time.size // _MOST_POINTS, 1))
        rows = [("measured", factor * channel.measured, "#000000")]
        rows += [(name, factor * (channel.measured - left[part]), colour) for name, left, colour in stages]
        _lines(
            figure, 2 * place + 1, np.round(channel.time[keep], 2), [(n, v[keep], c) for n, v, c in rows], place == 0
        )
        below = [(name, factor * left[part][keep], colour) for name, left, colour in stages]
        _lines(figure, 2 * place + 2, np.round(channel.time[keep], 2), below, False)
        figure.update_yaxes(title_text=f"{channel.name.replace('_', ' ')}<br>{unit}", row=2 * place + 1, col=1)
        figure.update_yaxes(title_text=f"residual<br>{unit}", row=2 * place + 2, col=1)
    figure.update_xaxes(title_text="time, s", row=2 * len(channels), col=1)
    if beyond.rest and len(problem.model.runs) == 1:
        run = problem.model.runs[0]
        figure.add_vline(x=run.time[0] + beyond.share * run.duration, line_dash="dot")
    figure.update_layout(height=300 * len(channels) + 80, legend={"orientation": "h", "y": 1.04}, hovermode="x unified")
    return _html(figure.update_traces(line_width=1.0))


def _lines(figure: Any, row: int, time: Any, lines: Sequence[tuple[str, Any, str]], legend: bool) -> None:
    import plotly.graph_objects as go

    for name, values, colour in lines:
        figure.add_trace(go.Scatter(x=time, y=np.round(values, 4), name=name, line_color=colour, showlegend=legend),
                         row=row, col=1)  # fmt: skip
