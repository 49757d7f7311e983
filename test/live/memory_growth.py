"""Whether a live page that is left open grows: `python test/live/memory_growth.py --minutes 10`.

Serves a slide on the live page, keeps the page open in chromium, and prints once half a minute how much memory the
serving process, the browser's processes and the page's script hold, and what the server used of a core. Ends with 1
where the last third holds more than the middle third by a tenth, which five minutes of strips (the first) explain no
more.
"""

from __future__ import annotations

import argparse
import os
import shutil
import statistics
import subprocess
import sys
import time
from pathlib import Path

from playwright.sync_api import CDPSession, sync_playwright

EVERY = 30.0  # s
GROWTH = 1.1
SERVER = Path(__file__).with_name("serve_slide.py")


def main(minutes: float, speed: str) -> int:
    """Measure; 1 where something grows."""
    program = [sys.executable, str(SERVER), speed, "320"]
    with (
        subprocess.Popen(program, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as server,
        sync_playwright() as engine,
    ):
        assert server.stdout is not None
        browser = engine.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
        page = browser.new_page(viewport={"width": 1280, "height": 900})
        page.goto(server.stdout.readline().strip())
        tools = page.context.new_cdp_session(page)
        rows, end = [], time.monotonic() + 60.0 * minutes
        print("minute  server MB  browser MB  script MB  elements  server % of a core  frames", flush=True)
        started, used = time.monotonic(), _server(server)[1]
        while time.monotonic() < end:
            page.wait_for_timeout(1e3 * EVERY)
            held, spent = _server(server)
            gone, started = time.monotonic() - started, time.monotonic()
            script, elements = _script(tools)
            frames = page.locator(".sd-instruments").get_attribute("data-frames")
            rows.append((held, _browser(), script, float(elements)))
            minute = minutes - (end - time.monotonic()) / 60.0
            print(f"{minute:6.1f}  {held:9.1f}  {rows[-1][1]:10.1f}  {script:9.2f}  {elements:8}  "
                  f"{100.0 * (spent - used) / gone:18.1f}  {frames}", flush=True)  # fmt: skip
            used = spent
        browser.close()
        server.terminate()
    third = max(len(rows) // 3, 1)
    grown = [
        name
        for place, name in enumerate(("server", "browser", "script", "elements"))
        if _middle(rows[-third:], place) > GROWTH * _middle(rows[third : 2 * third] or rows, place)
    ]
    print(f"grows: {', '.join(grown) or 'nothing'}")
    return 1 if grown else 0


def _middle(rows: list[tuple[float, ...]], place: int) -> float:
    return statistics.median(row[place] for row in rows)


def _server(server: subprocess.Popen[str]) -> tuple[float, float]:
    """MB that the serving process holds, and s of processor that it used."""
    assert server.stdin is not None and server.stdout is not None
    server.stdin.write("rss\n")
    server.stdin.flush()
    kilobytes, seconds = server.stdout.readline().split()
    return float(kilobytes) / 1e3, float(seconds)


def _browser() -> float:
    """MB that the browser's processes, those below this one, hold of their own."""
    total = 0.0
    for entry in Path("/proc").iterdir():
        try:
            if "chromium" in os.readlink(entry / "exe") and _is_below(entry):
                total += sum(float(line.split()[1]) for line in (entry / "smaps_rollup").read_text().splitlines()
                             if line.startswith(("Pss:",)))  # fmt: skip
        except OSError:
            continue  # no process, or gone meanwhile
    return total / 1e3


def _is_below(entry: Path) -> bool:
    while entry.name not in ("0", "1"):
        if entry.name == str(os.getpid()):
            return True
        stat = (entry / "stat").read_text()
        entry = Path("/proc") / stat.rpartition(")")[2].split()[1]
    return False


def _script(tools: CDPSession) -> tuple[float, int]:
    """MB of the page's script after its garbage is collected, and the page's elements."""
    tools.send("HeapProfiler.collectGarbage")
    return (tools.send("Runtime.getHeapUsage")["usedSize"] / 1e6,
            tools.send("Memory.getDOMCounters")["nodes"])  # fmt: skip


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--speed", default="1", help="of the slide, times real time")
    given = parser.parse_args()
    sys.exit(main(given.minutes, given.speed))
