"""The live page in a real browser; skipped without Chromium. Screenshots go to build/screenshots."""

from __future__ import annotations

import importlib.util
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
if CHROMIUM is None:
    pytest.skip("no chromium on this machine", allow_module_level=True)
if importlib.util.find_spec("nicegui") is None:  # not imported, which would take every worker half a second
    pytest.skip("no NiceGUI: pip install '.[live]'", allow_module_level=True)
playwright = pytest.importorskip("playwright.sync_api", reason="no Playwright: pip install playwright")

FRAMES = ".sd-instruments"


@pytest.fixture(scope="module")
def slide() -> Iterator[subprocess.Popen[str]]:
    """A slide 360 s old, in real time; its first line is the page's address."""
    program = Path(__file__).with_name("serve_slide.py")
    process = subprocess.Popen(
        [sys.executable, program, "1", "360"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONPATH": str(program.parents[2])},
    )
    yield process
    process.terminate()
    process.wait(20)


@pytest.fixture(scope="module")
def url(slide: subprocess.Popen[str]) -> str:
    assert slide.stdout is not None
    return slide.stdout.readline().strip()


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with playwright.sync_playwright() as engine:
        browser = engine.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        yield browser
        browser.close()


@pytest.fixture
def open_page(browser: Any, url: str) -> Iterator[Callable[..., Any]]:
    """A page of this size once it has drawn some frames; it must not complain."""
    contexts, complaints = [], []

    def open_one(width: int, height: int, scheme: str = "light") -> Any:
        context = browser.new_context(viewport={"width": width, "height": height}, color_scheme=scheme)
        contexts.append(context)
        page = context.new_page()
        page.on("pageerror", lambda error: complaints.append(str(error)))
        page.on("console", lambda said: complaints.append(said.text) if said.type == "error" else None)
        page.goto(url)
        frames_beyond(page, 15)
        return page

    yield open_one
    for context in contexts:
        context.close()
    assert complaints == []


def frames_beyond(page: Any, count: int) -> int:
    page.wait_for_function(f"Number(document.querySelector('{FRAMES}')?.dataset.frames) > {count}", timeout=60_000)
    return int(page.locator(FRAMES).get_attribute("data-frames"))


def drawn(page: Any, name: str) -> int:
    """How many colours a canvas shows."""
    return int(page.evaluate(
        "name => { const c = document.querySelector(`canvas.sd-${name}`);"
        "const d = new Uint32Array(c.getContext('2d').getImageData(0, 0, c.width, c.height).data.buffer);"
        "return new Set(d).size }", name))  # fmt: skip


def wait_until(true: Callable[[], bool]) -> None:
    end = time.monotonic() + 30.0
    while not true():
        assert time.monotonic() < end
        time.sleep(0.1)


@pytest.mark.parametrize(("name", "width", "height", "scheme"), [
    ("wide", 1440, 900, "light"), ("dark", 1440, 900, "dark"), ("phone", 390, 844, "light"),
])  # fmt: skip
def test_page_shows_the_slide(
    open_page: Callable[..., Any], repository: Path, name: str, width: int, height: int, scheme: str
) -> None:
    page = open_page(width, height, scheme)
    for canvas in ("dial", "strips", "string", "gaps", "timeline", "trends"):
        assert drawn(page, canvas) > 20, canvas
    page.get_by_text("torque within make-up and back-off limits").wait_for()
    page.get_by_text(re.compile(r"rocking ±\d+\.\d rad about .* target 45 deg.*recording")).wait_for()
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    folder = repository / "build" / "screenshots"
    folder.mkdir(parents=True, exist_ok=True)
    page.screenshot(path=folder / f"live_{name}.png", full_page=True)


def test_every_axis_has_two_numbers(browser: Any, repository: Path) -> None:
    source = (repository / "slider_drilling" / "live" / "script" / "paint.js").read_text()
    page = browser.new_page()
    for low, high in ((-190.8, 190.8), (-3.9, 5.1), (-2600.0, 3000.0), (55.0, 58.1)):
        numbers = page.evaluate(
            "async ([source, low, high]) => (await import('data:text/javascript,' + encodeURIComponent(source)))"
            ".ticks(low, high, 3)", [source, low, high])  # fmt: skip
        assert 2 <= len(numbers) <= 6 and low <= min(numbers) and max(numbers) <= high
    page.close()


def test_parameter_names_run_no_script(open_page: Callable[..., Any]) -> None:
    page = open_page(1200, 900)
    page.get_by_text("Parameters", exact=True).click()
    names = page.locator(".sd-settings .q-field__label").all_inner_texts()
    assert names[:4] == ["gain", "friction factor", "amplitude, rad", "make up torque limit, kN m"]
    assert names[4].startswith("a :hint=window.hacked=1")
    page.get_by_text("of rocking; 0: automatic. 0 to 200 (rocking_controller)").wait_for()
    assert page.locator(".sd-settings .q-field__suffix").all_inner_texts().count("automatic") == 1
    page.get_by_label("gain", exact=True).click()
    assert page.evaluate("window.hacked") is None


def test_page_cannot_be_framed(browser: Any, url: str) -> None:
    page = browser.new_page()
    with page.expect_event("framenavigated", lambda frame: frame.url.startswith("chrome-error:")) as refused:
        page.set_content(f"<iframe src='{url}'></iframe>")
    assert refused.value.locator(".sd-title").count() == 0
    page.close()


def test_print_keeps_the_shape_of_the_canvases(open_page: Callable[..., Any], repository: Path) -> None:
    page = open_page(1440, 900)
    shape = "name => { const c = document.querySelector(`canvas.sd-${name}`), b = c.getBoundingClientRect();"\
        "return (b.width / b.height) / (c.width / c.height) }"  # fmt: skip
    page.emulate_media(media="print")
    page.set_viewport_size({"width": 720, "height": 1000})
    for name in ("dial", "strips", "string", "gaps", "timeline", "trends"):
        assert 0.95 < page.evaluate(shape, name) < 1.05, name
    assert page.evaluate("document.documentElement.scrollWidth") <= 720
    folder = repository / "build" / "screenshots"
    page.screenshot(path=folder / "live_print.png", full_page=True)
    page.pdf(path=folder / "live_print.pdf")


def test_browser_keeps_only_the_window(open_page: Callable[..., Any]) -> None:
    page = open_page(800, 600)
    rows = int(page.locator(FRAMES).get_attribute("data-samples"))
    frames_beyond(page, 40)
    later = int(page.locator(FRAMES).get_attribute("data-samples"))
    # Backlog of the whole window, thinned to its extremes; what comes in goes out at the other end.
    assert 150 <= rows <= 450
    assert later <= rows + 40


def test_controls_reach_the_queue(open_page: Callable[..., Any], slide: subprocess.Popen[str]) -> None:
    page = open_page(1200, 900)
    page.get_by_label("new target, deg").fill("-60")
    page.get_by_role("button", name="Set target").click()
    page.get_by_text("target -60.0 deg", exact=True).wait_for()
    for button in ("Stop rocking", "Start rocking", "Pause recording"):
        page.get_by_role("button", name=button).click()
    page.get_by_text("Parameters", exact=True).click()
    gain = page.get_by_label("gain", exact=True)
    gain.fill("99")
    gain.blur()
    page.get_by_text("gain = 99: refused: out of range").wait_for()
    wait_until(lambda: gain.input_value() == "2")
    assert slide.stdin is not None and slide.stdout is not None
    slide.stdin.write("requests\n")
    slide.stdin.flush()
    received = slide.stdout.readline().strip()
    assert received == (
        "[SetTarget(target=-1.0471975511965976), SetRocking(on=False), SetRocking(on=True), SetRecording(on=False), "
        "SetParameter(node='rocking_controller', name='gain', value=99.0)]"
    )


def test_twin_is_asked_and_its_rig_used(open_page: Callable[..., Any], slide: subprocess.Popen[str]) -> None:
    page = open_page(1400, 900)
    names, values = (page.locator(f".sd-figure-{part}").all_inner_texts() for part in ("name", "value"))
    figures = dict(zip(names, values, strict=True))
    assert re.fullmatch(r"4\d\d\.\d kN|3\d\d\.\d kN", figures["hook load"])
    assert figures["bit depth"].startswith("400") and figures["rate of penetration"].endswith(" m/h")
    assert re.match(r"(learning|watching|operation)", page.locator("[data-name=twin]").inner_text())
    page.get_by_role("button", name="Diagnose now").click()
    page.get_by_role("button", name="Use calibrated rig").click()
    page.locator("[data-name=change]").first.wait_for()
    (change,) = page.locator("[data-name=change]").all_inner_texts()
    assert re.fullmatch(r"friction factor: 0\.235 becomes 0\.2\d+", change)
    page.get_by_text("off_bottom_pressure: the controller has no such parameter").wait_for()
    page.get_by_role("button", name="Use them").click()
    page.get_by_text(re.compile(r"friction_factor = 0\.2\d*: refused")).wait_for()
    assert slide.stdin is not None and slide.stdout is not None
    slide.stdin.write("requests\n")
    slide.stdin.flush()
    received = slide.stdout.readline()
    assert "DiagnoseNow()" in received and "name='friction_factor', value=0.2" in received


def test_page_without_a_server_says_so(open_page: Callable[..., Any], slide: subprocess.Popen[str]) -> None:
    """The server hangs, and then goes on."""
    page = open_page(800, 600)
    slide.send_signal(signal.SIGSTOP)
    try:
        page.wait_for_function("document.body.classList.contains('sd-server-lost')", timeout=60_000)
        banner = page.evaluate("document.body.dataset.silence")
        assert re.fullmatch(r"no data from the page's server for \d+ s", banner)
    finally:
        slide.send_signal(signal.SIGCONT)
    page.wait_for_function("!document.body.classList.contains('sd-server-lost')", timeout=60_000)


def test_dead_rig_looks_dead(
    open_page: Callable[..., Any], slide: subprocess.Popen[str], repository: Path
) -> None:
    """The last test of this module: the slide does not come back."""
    page = open_page(1440, 900)
    page.locator(".sd-status .sd-ok").first.wait_for()
    page.locator("[data-name=figures].sd-fresh").wait_for()
    assert slide.stdin is not None and slide.stdout is not None
    slide.stdin.write("die\n")
    slide.stdin.flush()
    assert slide.stdout.readline().strip() == "dead"
    page.locator(".sd-status.sd-late").first.wait_for()
    page.locator(".sd-status.sd-lost").first.wait_for()
    page.wait_for_function("document.querySelectorAll('.sd-ok').length == 0", timeout=60_000)
    faded = "name => Number(getComputedStyle(document.querySelector(name)).opacity) < 0.5"
    for name in (".sd-figures", ".sd-instruments"):
        assert page.evaluate(faded, name), f"{name}: numbers of a dead rig look alive"
    texts = page.locator("[data-name=statuses] .sd-status").all_inner_texts()
    assert texts and all(re.search(r"no status for \d+ s", text) for text in texts)
    assert re.search(r"\d+ s \(no sample since \d+ s\)", page.locator("[data-name=facts]").inner_text())
    page.locator("[data-name=facts].sd-lost").wait_for()
    page.screenshot(path=repository / "build" / "screenshots" / "live_dead.png", full_page=True)
