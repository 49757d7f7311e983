"""The one template in a real browser: drawn without a request or a complaint, on a telephone, in dark and on paper."""

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from slider_drilling.pages import Chart, HeatMap, Line, Page, Panel, Section, Table, write_page
from slider_drilling.units import FIELD

playwright = pytest.importorskip("playwright.sync_api", reason="no Playwright: pip install playwright")
CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
if CHROMIUM is None:
    pytest.skip("no chromium on this machine", allow_module_level=True)

TIME = np.linspace(0.0, 300.0, 3000)
WAVE = Line("measured", TIME, np.sin(TIME / 5.0), colour="ink")
OTHER = Line("simulated", TIME, np.cos(TIME / 5.0), "dashed", "blue")
PANELS = tuple(Panel(f"channel {k}, kN m", (WAVE, OTHER)) for k in range(9))


@pytest.fixture(scope="module")
def browser():
    with playwright.sync_playwright() as engine:
        opened = engine.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        yield opened
        opened.close()


@pytest.fixture(scope="module")
def page_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("page") / "page.html"
    table = Table(tuple(f"column {k}, kN" for k in range(14)), (tuple(float(k) for k in range(14)),) * 3)
    grid = HeatMap("A map", "speed, m/s", "size, mm", "share", np.arange(5.0), np.arange(4.0), np.eye(4, 5))
    chart = Chart("Tall", "time, s", PANELS, wide=True)
    claims = Table(("claim", "size, kN", "what came of it"), (("It holds " * 20, 1.0, "as far as it goes " * 10),) * 2)
    reference = (1.0, "what noise reaches in 100 logs")
    level = Chart("Level", "time, s", (Panel("channel, kN m", (WAVE,), reference_line=reference),))
    folded = Section("Folded", (Chart("In it", "time, s", PANELS[:1]),), collapsed=True)
    what = Section("What", ("Text.", table, chart, grid, claims, level))
    write_page(path, Page("Run", "A well, 45 deg, by a_module.of.many.words:AndAClassOfMore", (what, folded)), FIELD)
    return path


def opened(browser, path: Path, **context):
    """A drawn page and what its console and network said."""
    said = []
    page = browser.new_context(**context).new_page()
    page.on("console", lambda message: said.append(message.text) if message.type in ("error", "warning") else None)
    page.on("pageerror", lambda error: said.append(str(error)))
    page.on("request", lambda one: None if one.url.startswith(("file:", "data:", "blob:")) else said.append(one.url))
    page.goto(path.as_uri())
    page.wait_for_function("document.documentElement.dataset.drawn === 'yes'", timeout=120_000)
    return page, said


def test_page_draws_without_network_and_fits_telephone(browser, page_file: Path) -> None:
    page, said = opened(browser, page_file, viewport={"width": 390, "height": 844}, is_mobile=True, has_touch=True)
    assert said == []
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    assert page.locator(".plot .main-svg").count() > 0
    widths = page.evaluate("[...document.querySelectorAll('.plot .main-svg')].map(one => one.clientWidth)")
    assert max(widths) <= 390
    # Sentences stand one below the other, each with its heading; a heading of two lines is whole.
    assert page.evaluate("[...document.querySelectorAll('.prose')].map(one => one.scrollWidth <= 390)") == [True]
    cell = "document.querySelector('.prose td:nth-child(2)')"
    said = page.evaluate(f"[{cell}.textContent, getComputedStyle({cell}, '::before').content]")
    assert said == ["0.225", '"size, klbf: "']
    heads = page.evaluate("""[...document.querySelectorAll('.plot')].filter(plot => plot.data).map(plot =>
        Math.min(...[...plot.querySelectorAll('.annotation-text')].map(one => one.getBoundingClientRect().top))
        - plot.getBoundingClientRect().top)""")
    assert min(heads) >= 0.0
    # Turned off with its name, a line is gone from every panel; a folded figure is drawn once it is opened.
    page.locator(".legend button", has_text="simulated").first.click()
    shown = page.evaluate("document.querySelector('.plot').data.map(one => one.visible)")
    assert shown.count("legendonly") == len(PANELS)
    assert page.evaluate("!document.querySelector('details .plot').data")
    page.locator("summary").click()
    page.wait_for_function("Boolean(document.querySelector('details .plot').data)")


def test_dark_page_has_dark_figures(browser, page_file: Path) -> None:
    page, said = opened(browser, page_file, color_scheme="dark")
    assert said == []
    assert page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(20, 25, 31)"
    lines = page.evaluate("document.querySelector('.plot').data.map(one => one.line.color)")
    assert lines[0] == "#e8edf2" and len(set(lines)) == 2
    page.emulate_media(color_scheme="light")
    page.wait_for_function("document.querySelector('.plot').data[0].line.color === '#1c2733'")


def test_print_is_light_and_figures_fit_page(browser, page_file: Path, tmp_path: Path) -> None:
    page, _ = opened(browser, page_file, color_scheme="dark")
    page.pdf(path=tmp_path / "page.pdf", format="A4")
    page.evaluate("dispatchEvent(new Event('beforeprint'))")
    heights = page.evaluate(
        "[...document.querySelectorAll('.plot')].filter(one => one.layout).map(one => one.layout.height)"
    )
    assert max(heights) <= 900 and len(heights) == 3  # the folded figure is not printed
    assert page.evaluate("document.querySelector('.plot').data[0].line.color") == "#1c2733"
    if shutil.which("pdftotext"):
        text = subprocess.run(["pdftotext", tmp_path / "page.pdf", "-"], capture_output=True, text=True, check=True)
        assert "A well, 45 deg" in text.stdout and "Tall" in text.stdout
