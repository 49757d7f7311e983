"""A study on disk: an interactive page, a picture, the numbers and the claims."""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from slider_drilling import __version__
from slider_drilling.files import make_folder, write_whole
from slider_drilling.tools.study import Chart, Line, Map, Study

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SCHEMA = "slider_drilling/study/1"
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000", "#7f7f7f")
"""Okabe and Ito's, told apart by colour-blind readers too."""
CONFIG = {"responsive": True, "displaylogo": False}
MODE_COLOURS = ("#56b4e9", "#e69f00", "#009e73", "#dddddd")


def study_files(name: str, directory: Path) -> list[Path]:
    """What `write_study` writes for a study of this name; the directory is made. Raises InputError."""
    make_folder(directory)
    return [directory / f"{name}.{suffix}" for suffix in ("json", "csv", "png", "html")]


def write_study(study: Study, directory: Path, findings: dict[str, Any] | None = None) -> list[Path]:
    """Write NAME.json, NAME.csv, NAME.png and NAME.html into a directory, which is made; the four paths.

    findings: what NAME.json holds instead of the claims. Each file is written under a temporary name and renamed.
    Raises InputError where the directory cannot be made or a file cannot be written.
    """
    make_folder(directory)
    contents = {
        "json": (
            json.dumps(as_json(study) if findings is None else findings, indent=1, allow_nan=False) + "\n"
        ).encode(),
        "csv": _csv(study).encode(),
        "png": _png(study),
        "html": _html(study).encode(),
    }
    paths = {suffix: directory / f"{study.name}.{suffix}" for suffix in contents}
    for suffix, content in contents.items():
        write_whole(paths[suffix], content)
    return list(paths.values())


def as_json(study: Study) -> dict[str, Any]:
    """The claims with their verdicts, as NAME.json holds them."""
    claims = []
    for claim in study.claims:
        row = {"claim": claim.claim, "paper": claim.paper, "measured": claim.measured, "holds": bool(claim.holds)}
        claims.append({**row, "reason": claim.reason} if claim.reason else row)
    return {
        "schema": SCHEMA,
        "version": __version__,
        "study": study.name,
        "title": study.title,
        "settings": study.settings,
        "claims": claims,
        "notes": list(study.notes),
    }


def _csv(study: Study) -> str:
    """Long form: figure, series, x and y with their labels, and the value of a map."""
    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    rows.writerow(["figure", "series", "x_label", "x", "y_label", "y", "value"])
    for figure in study.figures:
        if isinstance(figure, Chart):
            for one in figure.lines:
                rows.writerows(
                    [figure.title, one.name, figure.x_label, f"{x:.9g}", figure.y_label, f"{y:.9g}", ""]
                    for x, y in zip(one.x, one.y, strict=True)
                )
            continue
        for y, across in zip(figure.y, figure.value, strict=True):
            rows.writerows(
                [
                    figure.title,
                    figure.value_label,
                    figure.x_label,
                    f"{x:.9g}",
                    figure.y_label,
                    f"{y:.9g}",
                    "" if np.isnan(value) else f"{value:.9g}",
                ]
                for x, value in zip(figure.x, across, strict=True)
            )
    return text.getvalue()


def _png(study: Study) -> bytes:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    columns = 1 if len(study.figures) == 1 else 2
    rows = -(-len(study.figures) // columns)
    page = Figure(figsize=(7.2 * columns, 4.4 * rows + 0.4), dpi=110, layout="constrained")
    page.suptitle(study.title)
    for k, figure in enumerate(study.figures):
        axes = page.add_subplot(rows, columns, k + 1)
        axes.set_title(figure.title, fontsize=10)
        axes.set_xlabel(figure.x_label)
        axes.set_ylabel(figure.y_label)
        if isinstance(figure, Chart):
            _draw_chart(axes, figure)
        else:
            _draw_map(axes, figure)
    picture = io.BytesIO()
    FigureCanvasAgg(page).print_png(picture)
    return picture.getvalue()


def _draw_chart(axes: Axes, chart: Chart) -> None:
    for k, one in enumerate(chart.lines):
        axes.plot(one.x, one.y, "--" if one.dashed else "-", color=_colour(one, k), lw=1.3, label=one.name)
    if chart.level is not None:
        axes.axhline(chart.level[0], color="#999999", lw=0.9, ls=":", label=chart.level[1])
    if chart.log_x:
        axes.set_xscale("log")
    if chart.log_y:
        axes.set_yscale("log")
    if chart.depth_down:
        axes.invert_yaxis()
    axes.grid(alpha=0.3)
    if len(chart.lines) > 1 or chart.level is not None:
        axes.legend(fontsize=8)


def _colour(one: Line, place: int) -> str:
    return COLOURS[(place if one.colour is None else one.colour) % len(COLOURS)]


def _draw_map(axes: Axes, figure: Map) -> None:
    from matplotlib.colors import LogNorm, Normalize

    if figure.categories:
        from matplotlib.colors import ListedColormap
        from matplotlib.patches import Patch

        axes.pcolormesh(figure.x, figure.y, figure.value, cmap=ListedColormap(MODE_COLOURS), vmin=-0.5, vmax=3.5)
        patches = [Patch(color=MODE_COLOURS[k], label=name) for k, name in enumerate(figure.categories)]
        axes.legend(handles=patches, fontsize=8, loc="lower left")
        return
    norm = LogNorm() if figure.log else Normalize()
    shown = axes.pcolormesh(figure.x, figure.y, figure.value, cmap="viridis", shading="nearest", norm=norm)
    assert axes.figure is not None
    axes.figure.colorbar(shown, ax=axes, label=figure.value_label)


def _html(study: Study) -> str:
    """One page that stands alone: plotly's own script is inside."""
    import jinja2
    import plotly.io
    from plotly.offline import get_plotlyjs

    figures = [
        plotly.io.to_html(_plotly(figure), full_html=False, include_plotlyjs=False, div_id=f"figure-{k}", config=CONFIG)
        for k, figure in enumerate(study.figures)
    ]
    page = jinja2.Environment(autoescape=True).from_string(PAGE)
    return page.render(study=study, claims=as_json(study)["claims"], figures=figures, script=get_plotlyjs())


def _plotly(figure: Chart | Map) -> Any:
    import plotly.graph_objects as go

    page = go.Figure(
        layout={
            "title": {"text": figure.title, "font": {"size": 15}},
            "template": "plotly_white",
            "modebar": {"orientation": "v"},
            "legend": {"orientation": "h", "y": -0.22},
            "height": 430,
            "margin": {"l": 70, "r": 20, "t": 50, "b": 55},
            "xaxis": {"title": {"text": figure.x_label}},
            "yaxis": {"title": {"text": figure.y_label}},
        }
    )
    if isinstance(figure, Map):
        page.add_trace(_plotly_map(figure))
        return page
    for k, one in enumerate(figure.lines):
        style = {"color": _colour(one, k), "dash": "dash" if one.dashed else "solid", "width": 1.6}
        page.add_trace(go.Scatter(x=one.x, y=one.y, name=one.name, mode="lines", line=style))
    if figure.level is not None:
        page.add_hline(y=figure.level[0], line={"dash": "dot", "color": "#999999"}, annotation_text=figure.level[1])
    page.update_xaxes(type="log" if figure.log_x else "linear")
    page.update_yaxes(type="log" if figure.log_y else "linear", autorange="reversed" if figure.depth_down else True)
    return page


def _plotly_map(figure: Map) -> Any:
    import plotly.graph_objects as go

    bar: dict[str, Any] = {"title": {"text": figure.value_label}}
    style: dict[str, Any] = {"colorscale": "Viridis", "colorbar": bar}
    if figure.categories:
        n = len(figure.categories)
        steps = [(edge / n, MODE_COLOURS[k]) for k in range(n) for edge in (k, k + 1)]
        bar.update(tickvals=list(range(n)), ticktext=list(figure.categories))
        style.update(colorscale=steps, zmin=-0.5, zmax=n - 0.5)
    if figure.log:
        bar["title"] = {"text": f"log10 of {figure.value_label}"}
    return go.Heatmap(x=figure.x, y=figure.y, z=np.log10(figure.value) if figure.log else figure.value, **style)


PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>{{ study.title }}</title>
<meta name="viewport" content="width=device-width, initial-scale=1">
<style>
body { font: 15px/1.45 system-ui, sans-serif; max-width: 1180px; margin: 1.5em auto; padding: 0 1em; color: #222; }
table { border-collapse: collapse; width: 100%; } td, th { border-bottom: 1px solid #ddd; padding: .45em .6em;
text-align: left; vertical-align: top; } code { font-size: 12px; word-break: break-word; }
.yes { color: #00724f; font-weight: 600; } .no { color: #b23c00; font-weight: 600; }
.figures { display: grid; grid-template-columns: repeat(auto-fit, minmax(500px, 1fr)); gap: 1em; }
.figures > div { min-width: 0; overflow: hidden; }
</style><script>{{ script | safe }}</script></head><body>
<h1>{{ study.title }}</h1>
<p>{% for name, value in study.settings.items() %}{{ name }}: {{ value }}{{ "; " if not loop.last }}{% endfor %}</p>
{% if claims %}<h2>What the paper says, and what the model does</h2>
<table><tr><th>claim</th><th>where</th><th>measured</th><th>verdict</th></tr>
{% for claim in claims %}<tr><td>{{ claim.claim }}</td><td>{{ claim.paper }}</td>
<td>{% for name, value in claim.measured.items() %}<code>{{ name }}: {{ value }}</code><br>{% endfor %}</td>
<td><span class="{{ 'yes' if claim.holds else 'no' }}">{{ "holds" if claim.holds else "does not hold" }}</span>
{% if claim.reason %}<br>{{ claim.reason }}{% endif %}</td></tr>{% endfor %}</table>{% endif %}
{% for table in study.tables %}<h2>{{ table.title }}</h2><table><tr>{% for cell in table.header %}<th>{{ cell }}</th>
{% endfor %}</tr>{% for row in table.rows %}<tr>{% for cell in row %}<td>{{ cell }}</td>{% endfor %}</tr>{% endfor %}
</table>{% endfor %}
{% for note in study.notes %}<p>{{ note }}</p>{% endfor %}
<div class="figures">{% for figure in figures %}<div>{{ figure | safe }}</div>{% endfor %}</div>
<script>window.addEventListener("load", () => window.dispatchEvent(new Event("resize")));</script>
</body></html>
"""
