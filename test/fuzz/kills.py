"""Every command ended by every signal at a random time: in time, no trace, its files whole, nobody left behind.

What was in the folder before, whole files of a run that was let be, is there afterwards or has been replaced by what is
whole. SIGKILL asks nobody: it may leave a hidden `.part`, and nothing else that is not whole.
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
from tally import Tally
from whole import contents, wrong_in

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGKILL)
PATIENCE = 600.0  # s that a command may take to end after a signal, on a machine that others use, too
FIRST = ("slider_drilling/__init__.py", "slider_drilling/__main__.py")
LONGEST = 10.0  # s of a command within which it is killed


@dataclass(frozen=True)
class Length:
    """wall: s that a command takes when it is let be; before: folder with what it left."""

    wall: float
    before: Path


def fuzz(cases: int, seed: int, only: str = "") -> int:
    """Kill each command (only: those that begin so) `cases` times with each signal; 1 where one ended otherwise."""
    tally = Tally()
    with tempfile.TemporaryDirectory() as folder:
        here = Path(folder)
        make_inputs(here)
        for name, arguments in COMMANDS.items():
            if not name.startswith(only):
                continue
            length = let_be(name, arguments, here)
            counted = Tally()
            for number, case in itertools.product(SIGNALS, range(cases)):
                draw = random.Random(f"kill {seed} {name} {number} {case}")
                after = draw.uniform(0.02, 1.0) * length.wall
                outcome = killed(arguments, number, after, length.before, here)
                counted.run(lambda outcome=outcome: outcome, f"{name} {number.name} after {after:.2f} s")
            counted.report(f"{name}, {length.wall:.1f} s")
            tally.add(counted)
    return tally.report("kills")


def let_be(name: str, arguments: str, here: Path) -> Length:
    """Run the command to its end, or for as long as it is killed within."""
    out = here / "let be" / name
    out.mkdir(parents=True)
    begun = time.monotonic()
    with started(arguments, out, here) as command:
        try:
            command.process.communicate(timeout=LONGEST)
        except subprocess.TimeoutExpired:
            command.process.terminate()
            command.process.communicate()
            shutil.rmtree(out)
            out.mkdir()
            return Length(LONGEST, out)
    if command.process.returncode != 0:
        raise RuntimeError(f"{name}: ends with {command.process.returncode} when it is let be")
    return Length(time.monotonic() - begun, out)


def killed(arguments: str, number: signal.Signals, after: float, before: Path, here: Path) -> str:
    """What came of it, ``ended by the signal`` or ``done before it`` where all is as it should be."""
    with tempfile.TemporaryDirectory(dir=here) as folder:
        out = Path(folder) / "out"
        shutil.copytree(before, out)
        held = contents(out)
        with started(arguments, out, here) as command:
            time.sleep(after)
            command.process.send_signal(number)
            try:
                said = command.process.communicate(timeout=PATIENCE)[1].decode(errors="replace").strip()
            except subprocess.TimeoutExpired:
                return "hang"
            left = command.left()
        if left:
            return f"left running: {left}"
        hard, code = number == signal.SIGKILL, command.process.returncode
        if number == signal.SIGINT and _before_the_first_line(said):
            return wrong_in(out, held, parts_too=False) or "ended by the signal"
        if "Traceback" in said and not hard:
            return f"traceback on stderr: {said.splitlines()[-1][:200]}"
        # A shell says 128 + number of both: of a program that ends so, and of one that the system ends, as it does
        # before the program's first line and after its last.
        if code not in (0, 128 + number, -number):
            return f"exit code {code}: {said[-200:]}"
        return wrong_in(out, held, parts_too=hard) or ("done before it" if code == 0 else "ended by the signal")


def _before_the_first_line(said: str) -> bool:
    """Whether it is Python's own trace of a SIGINT that came while Python began: the program takes signals first."""
    frames = re.findall(r'File "([^"]*)"', said)
    own = [frame for frame in frames if "slider_drilling/" in frame and not frame.endswith(FIRST)]
    return said.endswith("\nKeyboardInterrupt") and not own
