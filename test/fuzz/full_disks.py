"""Every command on a disk that is full at a random byte, and with a standard output that is full.

A command must end with exit code 2 and one line that says so, still print its answer, and leave only whole files: the
old ones unchanged, and new ones. The disks are small tmpfs mounts, which need root or user namespaces.
"""

from __future__ import annotations

import json
import os
import random
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from commands import COMMANDS, make_inputs, started
from output_checks import contents, wrong_in
from tally import Tally

TIMEOUT = 900.0  # s, enough on a busy machine
PAGE = 4096
SILENT = {"run", "import", "recover"}  # their answer is the file
WITHOUT_JSON = {"run", "bench", "completion"}
NO_FILES = {"info", "bench", "completion"}
FULL = "No space left on device"


def fuzz(cases: int, seed: int, only: str = "") -> int:
    """Run each command whose name starts with `only` `cases` times; returns 1 if one ended otherwise."""
    if os.geteuid() != 0:
        os.execvp("unshare", ["unshare", "--user", "--map-root-user", "--mount", sys.executable, *sys.argv])
    tally = Tally()
    with tempfile.TemporaryDirectory() as folder:
        here = Path(folder)
        make_inputs(here)
        for name, arguments in COMMANDS.items():
            if not name.startswith(only) or name == "bench":
                continue
            counted = Tally()
            outcome = _with_full_stdout(arguments, here / name)
            counted.run(lambda outcome=outcome: outcome, f"{name} > /dev/full")
            if name not in NO_FILES:
                size = _size(here / name)
                for case in range(cases):
                    draw = random.Random(f"disk {seed} {name} {case}")
                    room = draw.randrange(0, size, PAGE)
                    as_json = name not in WITHOUT_JSON and draw.random() < 0.5
                    fresh = name == "run" or draw.random() < 0.5
                    outcome = _on_small_disk(name, arguments + " --json" * as_json, room, fresh, here)
                    what = f"{name} with {room} bytes, --json {as_json}, empty {fresh}"
                    counted.run(lambda outcome=outcome: outcome, what)
            counted.report(name)
            tally.add(counted)
    return tally.report("full disks")


def _with_full_stdout(arguments: str, out: Path) -> str:
    """Run the command with a full standard output; its files must be written."""
    out.mkdir()
    with open("/dev/full", "wb") as full, started(arguments, out, out.parent, full) as command:
        said = command.process.communicate(timeout=TIMEOUT)[1].decode(errors="replace").strip()
    wrong = _wrong(command.process.returncode, said) or wrong_in(out, {}, allow_parts=False)
    if not wrong and out.name not in NO_FILES and not contents(out):
        wrong = "no file was written"
    return wrong or "said that the disk is full"


def _size(out: Path) -> int:
    """Disk space of the command's files, bytes."""
    return sum(-(-path.stat().st_size // PAGE) * PAGE for path in out.rglob("*") if path.is_file())


def _on_small_disk(name: str, arguments: str, room: int, fresh: bool, here: Path) -> str:
    """Run the command with `room` bytes free, in an empty folder or beside what it wrote before."""
    taken = 0 if fresh else _size(here / name)
    with tempfile.TemporaryDirectory(dir=here) as folder, _disk(Path(folder), room + taken) as disk:
        out = disk / "out"
        out.mkdir() if fresh else shutil.copytree(here / name, out)
        held = contents(out)
        with started(arguments, out, here) as command:
            shown, said = (text.decode(errors="replace").strip() for text in
                           command.process.communicate(timeout=TIMEOUT))  # fmt: skip
        if command.process.returncode == 0:
            return wrong_in(out, held, allow_parts=False) or "ran"
        wrong = _wrong(command.process.returncode, said) or wrong_in(out, held, allow_parts=False)
        if not wrong and name not in SILENT:
            wrong = _unanswered(shown, "--json" in arguments)
        return wrong or "said that the disk is full"


def _wrong(code: int, said: str) -> str:
    """"" for exit code 2 and a last line with the reason."""
    if "Traceback" in said:
        return f"traceback on stderr: {said.splitlines()[-1][:200]}"
    if code != 2 or FULL not in (said.splitlines() or [""])[-1]:
        return f"exit code {code}: {said[-300:]}"
    return ""


def _unanswered(shown: str, as_json: bool) -> str:
    if not shown:
        return "no answer was printed"
    if as_json:
        try:
            json.loads(shown)
        except ValueError as error:
            return f"the output is not JSON: {error}"
    return ""


@contextmanager
def _disk(folder: Path, size: int) -> Iterator[Path]:
    """A disk of this size, bytes."""
    subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={max(size, PAGE)}", "none", str(folder)], check=True)
    try:
        yield folder
    finally:
        subprocess.run(["umount", str(folder)], check=True)
