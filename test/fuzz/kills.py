"""Every command ended by every signal at a random time.

It must end in time, without a traceback or a process left behind. Its files must be whole: those of an earlier run, or
new ones. After SIGKILL a hidden `.part` may remain.
"""

from __future__ import annotations

import itertools
import random
import re
import shutil
import signal
import subprocess
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

from commands import COMMANDS, make_inputs, started
from output_checks import contents, wrong_in
from tally import Tally

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGKILL)
TIMEOUT = 600.0  # s after a signal, enough on a busy machine
FIRST_MODULES = ("slider_drilling/__init__.py", "slider_drilling/__main__.py")
MAX_DURATION = 10.0  # s after which a command is killed at the latest


@dataclass(frozen=True)
class FullRun:
    """A run that was not killed. wall: its duration, s; before: the folder that it wrote."""

    wall: float
    before: Path


def fuzz(cases: int, seed: int, only: str = "") -> int:
    """Kill each command that starts with `only` `cases` times with each signal; returns 1 if one ended otherwise."""
    tally = Tally()
    with tempfile.TemporaryDirectory() as folder:
        here = Path(folder)
        make_inputs(here)
        for name, arguments in COMMANDS.items():
            if not name.startswith(only):
                continue
            full_run = run_fully(name, arguments, here)
            counted = Tally()
            for number, case in itertools.product(SIGNALS, range(cases)):
                draw = random.Random(f"kill {seed} {name} {number} {case}")
                after = draw.uniform(0.02, 1.0) * full_run.wall
                outcome = killed(arguments, number, after, full_run.before, here)
                counted.run(lambda outcome=outcome: outcome, f"{name} {number.name} after {after:.2f} s")
            counted.report(f"{name}, {full_run.wall:.1f} s")
            tally.add(counted)
    return tally.report("kills")


def run_fully(name: str, arguments: str, here: Path) -> FullRun:
    """Run a command to its end, or for MAX_DURATION."""
    out = here / "full runs" / name
    out.mkdir(parents=True)
    start = time.monotonic()
    with started(arguments, out, here) as command:
        try:
            command.process.communicate(timeout=MAX_DURATION)
        except subprocess.TimeoutExpired:
            command.process.terminate()
            command.process.communicate()
            shutil.rmtree(out)
            out.mkdir()
            return FullRun(MAX_DURATION, out)
    if command.process.returncode != 0:
        raise RuntimeError(f"{name}: ends with {command.process.returncode} when it is not killed")
    return FullRun(time.monotonic() - start, out)


def killed(arguments: str, number: signal.Signals, after: float, before: Path, here: Path) -> str:
    """The outcome: ``ended by the signal``, ``done before it``, or what is wrong."""
    with tempfile.TemporaryDirectory(dir=here) as folder:
        out = Path(folder) / "out"
        shutil.copytree(before, out)
        held = contents(out)
        with started(arguments, out, here) as command:
            time.sleep(after)
            command.process.send_signal(number)
            try:
                said = command.process.communicate(timeout=TIMEOUT)[1].decode(errors="replace").strip()
            except subprocess.TimeoutExpired:
                return "hang"
            left = command.left()
        if left:
            return f"left running: {left}"
        hard, code = number == signal.SIGKILL, command.process.returncode
        if number == signal.SIGINT and _before_the_first_line(said):
            return wrong_in(out, held, allow_parts=False) or "ended by the signal"
        if "Traceback" in said and not hard:
            return f"traceback on stderr: {said.splitlines()[-1][:200]}"
        # The system ends a program by the signal before its first line and after its last; a shell reports both as
        # 128 + number.
        if code not in (0, 128 + number, -number):
            return f"exit code {code}: {said[-200:]}"
        return wrong_in(out, held, allow_parts=hard) or ("done before it" if code == 0 else "ended by the signal")


def _before_the_first_line(said: str) -> bool:
    """Whether the output is Python's traceback of a SIGINT before the program's first line."""
    frames = re.findall(r'File "([^"]*)"', said)
    own = [frame for frame in frames if "slider_drilling/" in frame and not frame.endswith(FIRST_MODULES)]
    return said.endswith("\nKeyboardInterrupt") and not own
