"""The two pictures that need a browser, for README and site: `python -m site_build.screenshots` (about ten minutes).

Needs Debian's chromium, `pip install playwright` and the extras `analysis`, `live` and `ros`. Writes
docs/pictures/live.png and docs/pictures/diagnosis.png.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from pathlib import Path

from playwright.sync_api import Browser, sync_playwright

from site_build.pictures import BED

PICTURES = Path(__file__).resolve().parent.parent / "docs" / "pictures"
PORT = 8899
HARDER = "formation_change:factor=1.6,time=500"
SHOWN_AT = 760  # s of the slide
HEAD = {"x": 0.0, "y": 0.0, "width": 1400.0, "height": 1010.0}  # px: figures, instruments, twin
CHROMIUM = "/usr/bin/chromium"
PROGRAM = (sys.executable, "-m", "slider_drilling")


def live(browser: Browser) -> None:
    """A slide into harder rock, as its live page shows it some minutes after the twin has seen the change."""
    command = [*PROGRAM, "run", "--live", "--twin", "--live-port", str(PORT), "--target", "45", "--speed", "max",
               "--elements", "40", "--effect", HARDER]  # fmt: skip
    run = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        page = browser.new_page(viewport={"width": 1400, "height": 900})
        for _ in range(60):
            try:
                page.goto(f"http://127.0.0.1:{PORT}/", timeout=5000)
                break
            except Exception as error:  # not up yet: whatever the browser calls that
                print(f"waiting for the live page: {str(error).splitlines()[0]}")
                time.sleep(1.0)
        page.wait_for_function(
            f"parseFloat(document.querySelector('[data-name=facts]')?.textContent) > {SHOWN_AT}", timeout=900_000
        )
        page.screenshot(path=PICTURES / "live.png", full_page=True, clip=HEAD)
    finally:
        run.terminate()
        run.wait(30.0)


def diagnosis(browser: Browser, folder: Path) -> None:
    """The head of the diagnosis of a slide over a bed of cuttings."""
    subprocess.run([*PROGRAM, "run", "--effect", BED, "--record", str(folder)], check=True)
    log = next(folder.glob("*.mcap"))
    subprocess.run([*PROGRAM, "diagnose", str(log), "-o", str(folder / "diagnosis")], check=True)
    shot(browser, folder / "diagnosis" / "report.html")


def shot(browser: Browser, report: Path) -> None:
    """What a screen shows of a diagnosis's page."""
    page = browser.new_page(viewport={"width": 1180, "height": 1100})
    page.goto(report.as_uri())
    page.wait_for_function("document.documentElement.dataset.drawn === 'yes'")
    page.screenshot(path=PICTURES / "diagnosis.png")


if __name__ == "__main__":
    PICTURES.mkdir(exist_ok=True)
    with sync_playwright() as playwright, tempfile.TemporaryDirectory() as scratch:
        chromium = playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        live(chromium)
        diagnosis(chromium, Path(scratch))
