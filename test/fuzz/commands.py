"""Every command with small inputs, started so that processes which it leaves behind are ids."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

import slider_drilling as sd

PROGRAM = [sys.executable, "-m", "slider_drilling"]
COMMANDS = {
    "run": "run --duration 60 --elements 20 --record {out}",
    "plot": "plot run.mcap -o {out}",
    "closed-loop": "closed-loop --only hold --elements 20 -o {out}",
    "closed-loop --campaign": "closed-loop --campaign 2 --elements 20 -o {out}",
    "replay": "replay run.mcap --elements 50 -o {out}/replayed.mcap --page {out}/replayed.html",
    "diagnose": "diagnose run.mcap --only stribeck -o {out}",
    "diagnose, a folder": "diagnose logs --only stribeck -o {out}",
    "blind-check": "blind-check --cases 1 --effects none --no-oracle -o {out}",
    "torque-drag": "torque-drag --survey path.csv -o {out}",
    "study": "study all -o {out}",
    "analyse": "analyse run.mcap --elements 20 -o {out}",
    "identify": "identify friction.csv --generations 5 -o {out}",
    "import": "import table.csv --mapping mapping.yaml -o {out}/imported.mcap",
    "info": "info run.mcap",
    "recover": "recover broken.mcap -o {out}/recovered.mcap",
    "bench": "bench",
    "completion": "completion bash",
}
MAPPING = """\
schema: slider_drilling/csv/1
time: {column: t, unit: s}
channels: {surface_torque: {column: torque, unit: N m}, top_drive_speed: {column: speed, unit: rad/s}}
"""
_MARK = "SLIDER_DRILLING_FUZZ_MARK"  # environment variable of a command and its child processes


def make_inputs(here: Path) -> None:
    """Write the commands' input files."""
    (here / "logs").mkdir()
    for name, duration in (("run", 60.0), ("logs/monday", 60.0), ("logs/tuesday", 50.0)):
        run = sd.simulate(sd.load_rig(), "slider_drilling.control:SlideController", duration, elements=20)
        run.save(here / f"{name}.mcap")
    whole = (here / "run.mcap").read_bytes()
    (here / "broken.mcap").write_bytes(whole[: len(whole) * 2 // 3])
    (here / "mapping.yaml").write_text(MAPPING)
    (here / "table.csv").write_text("t,torque,speed\n" + "".join(f"{0.01 * k:.2f},{k % 7},1\n" for k in range(30_000)))
    stations = "".join(f"{depth},{min(90.0, depth / 20.0)},0\n" for depth in range(0, 4800, 100))
    (here / "path.csv").write_text("md_m,inclination,azimuth\n" + stations)
    head = "feed_m_per_s,vibration_m_per_s,frequency_hz,normal_force_n,friction_n\n"
    (here / "friction.csv").write_text(head + "".join(f"0.01,{0.02 * k},10,1000,{250 - 3 * k}\n" for k in range(30)))


@contextmanager
def started(
    arguments: str, out: Path, here: Path, stdout: int | IO[bytes] = subprocess.PIPE
) -> Iterator[RunningCommand]:
    """Start a command; on exit kill what is left of it."""
    words = [word.format(out=out) for word in arguments.split()]
    mark = f"{os.getpid()} {out}"
    process = subprocess.Popen(
        [*PROGRAM, *words], cwd=here, stdout=stdout, stderr=subprocess.PIPE, start_new_session=True,
        preexec_fn=_restore_signals, env={**os.environ, _MARK: mark, "ROS_DOMAIN_ID": str(1 + os.getpid() % 100)},
    )  # fmt: skip
    command = RunningCommand(process, f"{_MARK}={mark}".encode())
    try:
        yield command
    finally:
        for number in command.process_ids():
            os.kill(number, signal.SIGKILL)
        process.communicate()


def _restore_signals() -> None:
    """Under nohup, or in the background, child processes would ignore signals that this process ignores."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_DFL)


class RunningCommand:
    """A running command; mark: in the environment of it and its child processes."""

    def __init__(self, process: subprocess.Popen[bytes], mark: bytes) -> None:
        self.process = process
        self.mark = mark

    def process_ids(self) -> list[int]:
        """The ids of its processes."""
        ids = []
        for entry in Path("/proc").iterdir():
            if not entry.name.isdigit():
                continue
            try:
                if self.mark in (entry / "environ").read_bytes().split(b"\0"):
                    ids.append(int(entry.name))
            except OSError:
                continue  # ended meanwhile, a zombie, or another user's
        return ids

    def left(self) -> str:
        """A process that still runs ten seconds after the command ended; "" if none does."""
        for _ in range(100):
            ids = self.process_ids()
            if not ids:
                return ""
            time.sleep(0.1)
        return Path(f"/proc/{ids[0]}/cmdline").read_bytes().replace(b"\0", b" ").decode()[:200]
