"""Every command ended by every signal at a random time: in time, no trace, its files whole, nobody left behind."""

from __future__ import annotations

import contextlib
import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from tally import Tally

import slider_drilling as sd
from slider_drilling.log import read_log

PROGRAM = [sys.executable, "-m", "slider_drilling"]
SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
PATIENCE = 60.0  # s that a command may take to end after a signal, on a busy machine
COMMANDS = {
    "analyse": "analyse run.mcap --elements 20 -o {out}",
    "plot": "plot run.mcap -o {out}",
    "replay": "replay run.mcap --elements 50 -o {out}/replayed.mcap",
    "import": "import table.csv --mapping mapping.yaml -o {out}/imported.mcap",
    "diagnose": "diagnose run.mcap -o {out}",
    "identify": "identify friction.csv --generations 20 -o {out}",
    "closed-loop": "closed-loop --only hold --elements 20 -o {out}",
    "study": "study all -o {out}",
    "blind-check": "blind-check -o {out}",
}
MAPPING = """\
schema: slider_drilling/csv/1
time: {column: t, unit: s}
channels: {surface_torque: {column: torque, unit: N m}, top_drive_speed: {column: speed, unit: rad/s}}
"""


def fuzz(cases: int, seed: int) -> int:
    """Kill each command `cases` times with each signal; 1 where one did not end as it should."""
    tally = Tally()
    with tempfile.TemporaryDirectory() as folder:
        here = Path(folder)
        _inputs(here)
        for name, arguments in COMMANDS.items():
            longest = _length(arguments, here)
            for number in SIGNALS:
                for case in range(cases):
                    draw = random.Random(f"kill {seed} {name} {number} {case}")
                    after = draw.uniform(0.3, 1.0) * longest
                    outcome = _killed(arguments, number, after, here)
                    tally.run(lambda outcome=outcome: outcome, f"{name} {number.name} after {after:.1f} s")
    return tally.report("kills")


def _inputs(here: Path) -> None:
    run = sd.simulate(sd.load_rig(), "slider_drilling.control:SlideController", 60.0, elements=20)
    run.save(here / "run.mcap")
    (here / "mapping.yaml").write_text(MAPPING)
    (here / "table.csv").write_text("t,torque,speed\n" + "".join(f"{0.01 * k:.2f},{k % 7},1\n" for k in range(100_000)))
    head = "feed_m_per_s,vibration_m_per_s,frequency_hz,normal_force_n,friction_n\n"
    (here / "friction.csv").write_text(head + "".join(f"0.01,{0.02 * k},10,1000,{250 - 3 * k}\n" for k in range(30)))


def _length(arguments: str, here: Path) -> float:
    """Seconds that the command takes when it is let be, 20 at most."""
    begun = time.monotonic()
    with contextlib.suppress(subprocess.TimeoutExpired), _started(arguments, here / "let_be", here) as process:
        try:
            process.wait(20.0)
        finally:
            os.killpg(process.pid, signal.SIGKILL) if process.poll() is None else None
    return time.monotonic() - begun


def _started(arguments: str, out: Path, here: Path) -> subprocess.Popen[bytes]:
    out.mkdir(exist_ok=True)
    words = arguments.format(out=out).split()
    return subprocess.Popen(
        [*PROGRAM, *words], cwd=here, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, start_new_session=True
    )


def _killed(arguments: str, number: signal.Signals, after: float, here: Path) -> str:
    """What came of it, ``ran`` where all is as it should be."""
    with tempfile.TemporaryDirectory(dir=here) as out:
        process = _started(arguments, Path(out), here)
        time.sleep(after)
        process.send_signal(number)
        try:
            said = process.communicate(timeout=PATIENCE)[1].decode(errors="replace")
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            process.communicate()
            return "hang"
        left = _left_in(process.pid)
        if left:
            os.killpg(process.pid, signal.SIGKILL)
            return "a process left behind"
        if "Traceback" in said:
            return f"traceback on stderr: {said.strip().splitlines()[-1][:200]}"
        if process.returncode not in (0, 128 + number):
            return f"exit code {process.returncode}: {said.strip()[-200:]}"
        return _whole(Path(out))


def _left_in(session: int) -> bool:
    """Whether a process of this session is there a little later."""
    for _ in range(30):
        try:
            os.killpg(session, 0)
        except ProcessLookupError:
            return False
        time.sleep(0.1)
    return True


def _whole(out: Path) -> str:
    for path in out.rglob("*"):
        if path.name.endswith(".part"):
            return f"left {path.name}"
        if path.suffix == ".json":
            json.loads(path.read_text())
        if path.suffix == ".mcap":
            read_log(path)
        if path.suffix == ".html" and "</html>" not in path.read_text()[-200:]:
            return f"{path.name} is not whole"
    return "ran"
