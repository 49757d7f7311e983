"""The one template: what a page says, in the reader's units, standing alone."""

import base64
import gzip
import json
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from slider_drilling.pages import (
    Bars,
    BulletList,
    Chart,
    Headline,
    HeatMap,
    Line,
    Link,
    Page,
    Panel,
    Quantity,
    Section,
    Table,
    Tag,
    line,
    page_html,
    write_page,
)  # fmt: skip
from slider_drilling.pages.colours import DARK, LIGHT, ORDER
from slider_drilling.pages.figures import decimate, wrapped_curve
from slider_drilling.pages.plotly_js import plotly_spec, round_ticks, rounded_numbers
from slider_drilling.pages.png import render_png
from slider_drilling.units import FIELD, SI, sentence

TIME = np.arange(0.0, 300.0, 0.1)
CHART = Chart(
    "Torque", "time, s",
    (Panel("surface torque, kN m", (Line("measured", TIME, 1.3558179483314004 + 0.0 * TIME, colour="ink"),
                                    Line("simulated", TIME, np.sin(TIME), "dashed"))),
     Panel("top drive, rad", (Line("angle", TIME, 2.0 * np.pi + 0.0 * TIME),), reference_line=(np.pi, "half"))),
    vertical_lines=((150.0, "not fitted"),),
)  # fmt: skip


def a_page(*items: Any) -> Page:
    sections = (Section("What happened", items),)
    return Page("Run", "Well <A>", sections, (("log", "run.mcap"),), Headline("Held.", "good"))


def drawings_in(html: str) -> list[dict[str, Any]]:
    (packed,) = re.findall(r'id="drawings" type="text/plain">([^<]+)<', html)
    return json.loads(gzip.decompress(base64.b64decode(packed)))


def test_page_is_one_small_file(tmp_path: Path) -> None:
    write_page(tmp_path / "run.html", a_page(CHART), SI)
    html = (tmp_path / "run.html").read_text()
    assert (tmp_path / "run.html").stat().st_size < 1_500_000
    outside = re.sub(r'<script id="\w+" type="text/plain">[^<]+</script>', "", html)
    assert not re.findall(r"""(?:src|href|url)\s*[=(]\s*["']?(?:https?:)?//""", outside)
    assert '<meta name="viewport"' in html and "<title>Run: Well &lt;A&gt;</title>" in html
    (packed,) = re.findall(r'id="plotly" type="text/plain">([^<]+)<', html)
    assert b"plotly.js (cartesian - minified) v4" in gzip.decompress(base64.b64decode(packed))[:100]


def test_page_without_figures_has_no_script() -> None:
    html = page_html(a_page("One sentence.", BulletList(("a", "b"))), SI)
    assert "<script" not in html and len(html) < 12_000


def test_png_ignores_mplbackend(tmp_path: Path) -> None:
    asks = "from slider_drilling.pages import Chart, Panel, line; from slider_drilling.pages.png import render_png;"
    asks += "from slider_drilling.units import SI; import os, sys;"
    asks += "chart = Chart('A', 'time, s', (Panel('force, N', (line('a', [0, 1], [0, 1]),)),));"
    asks += "sys.exit(render_png((chart,), SI)[:4] != b'\\x89PNG' or os.environ['MPLBACKEND'] != 'nope')"
    subprocess.run([sys.executable, "-c", asks], check=True, env={**os.environ, "MPLBACKEND": "nope"},
                   cwd=Path(__file__).parents[1])  # fmt: skip


def test_figure_texts_use_axis_units() -> None:
    rate = sentence(Quantity(3.0, "m/h", 2))
    chart = Chart(sentence("Friction at ", rate), "time, s", (Panel("friction, N", (Line(rate, TIME, TIME),)),))
    html = page_html(a_page(chart), FIELD)
    assert "<h3>Friction at 9.8 ft/h</h3>" in html
    assert drawings_in(html)[0]["data"][0]["name"] == "9.8 ft/h"


@pytest.mark.parametrize(("units", "torque", "angle"), [(SI, 1.3558, 2 * np.pi), (FIELD, 1000.0, 1.0)])
def test_figures_convert_to_reader_units(units: Any, torque: float, angle: float) -> None:
    (drawn,) = drawings_in(page_html(a_page(CHART), units))
    first, _, third = drawn["data"]
    assert first["y"][0] == pytest.approx(torque, rel=1e-4) and third["y"][-1] == pytest.approx(angle, rel=1e-4)
    names = [note["text"] for note in drawn["layout"]["annotations"]]
    assert names[0] == f"Surface torque, {units.display_unit('kN m')}"
    assert names[1] == f"Top drive, {units.display_unit('rad')} · dotted: half"
    half = [shape["y0"] for shape in drawn["layout"]["shapes"] if shape.get("xref") == "paper"]
    assert half == [pytest.approx(angle / 2)]


def test_axes_fit_data() -> None:
    (drawn,) = drawings_in(page_html(a_page(CHART), SI))
    low, high = drawn["layout"]["xaxis"]["range"]
    assert -5.0 < low <= 0.0 and TIME[-1] <= high < TIME[-1] + 5.0


def test_cells_show_every_kind() -> None:
    table = Table(
        ("channel", "noise, kN m", "verdict", "weight"),
        (("torque", 1.3558179483314004, Tag("holds", "good"), Quantity(4.4482216152605, "kN")),
         ("pressure", None, (Tag("no", "bad"), "why"), Link("page", "a.html")),
         ("rounding", 3.33e-16, "", 7)),
    )  # fmt: skip
    html = page_html(a_page(table), FIELD)
    assert "noise, ft lbf" in html and ">1000<" in html and ">1.00 klbf<" in html and ">0<" in html
    assert '<span class="tag good">holds</span>' in html and '<br>why' in html and '<a href="a.html">page</a>' in html
    assert '<td class="n">-</td>' in html and "3.33e-16" not in html


def test_single_line_has_no_legend() -> None:
    single = Chart("One", "time, s", (Panel("torque, kN m", (line("only", TIME, TIME),)),))
    assert plotly_spec(single, SI)["legend"] == []
    assert [entry["name"] for entry in plotly_spec(CHART, SI)["legend"]] == ["measured", "simulated", "angle"]


def test_horizontal_bars_start_at_top() -> None:
    bars = Bars("closed", ("first", "second"), np.array([0.2, 0.9]), ("grey", "green"), horizontal=True)
    drawn = plotly_spec(Chart("Ranking", "share", (Panel("effect", (bars,)),)), SI)
    assert drawn["data"][0]["orientation"] == "h" and drawn["data"][0]["x"] == [0.2, 0.9]
    assert drawn["layout"]["yaxis"]["autorange"] == "reversed"
    assert drawn["data"][0]["marker"]["color"] == ["@grey", "@green"]


def test_intervals_become_whiskers_and_bands() -> None:
    low, middle, high = np.array([1.0, 2.0]), np.array([2.0, 3.0]), np.array([4.0, 5.0])
    dots = Line("a", low, middle, "dots", low=low, high=high)
    band = Line("b", low, middle, low=low, high=high)
    traces = plotly_spec(Chart("", "x", (Panel("y", (dots, band)),)), SI)["data"]
    assert traces[0]["error_y"]["array"] == [2.0, 2.0] and traces[0]["error_y"]["arrayminus"] == [1.0, 1.0]
    assert len(traces) == 4 and traces[2]["fill"] == "tonexty" and traces[2]["fillcolor"] == "@red33"


def test_log_axis_has_round_ticks() -> None:
    assert round_ticks(1.1, 23.0) == [1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0]
    assert {1.5, 2.0, 3.0, 4.0} < set(round_ticks(1.5, 4.0)) and len(round_ticks(1.5, 4.0)) < 15
    assert round_ticks(1e-6, 1e3) == pytest.approx([10.0**k for k in range(-6, 4)])


def test_numbers_keep_screen_resolution() -> None:
    assert rounded_numbers(np.array([4000.123456, 4000.654321])) == [4000.123456, 4000.654321]
    assert rounded_numbers(np.array([0.0123456789, 1000.123456])) == [0.01235, 1000.12]
    assert rounded_numbers(np.array([1e-6, np.nan, 1e3])) == [1e-6, None, 1000.0]


def test_nan_breaks_line_and_map() -> None:
    chart = Chart("", "time, s", (Panel("y", (line("a", [0.0, 1.0, 2.0], [1.0, np.nan, 3.0]),)),))
    assert plotly_spec(chart, SI)["data"][0]["y"] == [1.0, None, 3.0]
    grid = HeatMap("", "x", "y", "v", np.arange(2.0), np.arange(1.0), np.array([[np.nan, 2.0]]))
    assert plotly_spec(grid, SI)["data"][0]["z"] == [[None, 2.0]]
    json.dumps([plotly_spec(chart, SI), plotly_spec(grid, SI)], allow_nan=False)


def test_decimation_keeps_extremes() -> None:
    value = np.sin(np.arange(100_000) / 3000.0)
    value[54_321], value[12_345], value[777] = 9.0, -9.0, np.nan
    time, thinned = decimate(np.arange(100_000.0), value, 1000)
    assert len(time) <= 1100 and (np.diff(time) > 0).all()
    assert np.nanmax(thinned) == 9.0 and np.nanmin(thinned) == -9.0 and np.isnan(thinned).sum() == 1
    x, y = decimate(np.cos(TIME), np.sin(TIME), 500)
    assert x.min() == np.cos(TIME).min() and y.max() == np.sin(TIME).max() and len(x) <= 600


def test_wrapping_breaks_line_at_180_degrees() -> None:
    degrees = np.array([170.0, 175.0, 185.0, 190.0])
    np.testing.assert_array_equal(wrapped_curve(degrees), [170.0, 175.0, np.nan, -170.0])
    assert degrees[2] == 185.0


def test_colours_exist_in_light_and_dark() -> None:
    assert set(LIGHT) == set(DARK) == set(ORDER)


def test_png_draws_every_kind_of_figure() -> None:
    bars = Chart("Bars", "stage", (Panel("E", (Bars("", ("a", "b"), np.array([1.0, 2.0]), text=("1", "2")),)),))
    kinds = HeatMap("Kinds", "speed, m/s", "size, mm", "kind", np.arange(3.0), np.arange(2.0), np.eye(2, 3), ("p", "q"))
    assert render_png((CHART, bars, kinds), FIELD, "Every kind")[:8] == b"\x89PNG\r\n\x1a\n"
