"""A node as a process of its own, started as `ros2 run` starts it."""

import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path

DEADLINE = 120.0  # s, for anything that a process has to do; a process that needs it all has failed


class Program:
    """One node's process and what it has said.

    others: the programs that it works with. Where one waits in vain, what all of them said and where each of them
    stands is told.
    """

    def __init__(
        self, name: str, namespace: str, folder: Path, others: Sequence["Program"] = (), **parameters: object
    ) -> None:
        code = f"from slider_drilling.nodes.programs import {name}; {name}()"
        arguments = ["--ros-args", "-r", f"__ns:={namespace}"]
        for key, value in parameters.items():
            arguments += ["-p", f"{key}:={value}"]
        self.name = f"{namespace}/{name}"
        self._others = others
        self._begun = time.monotonic()
        # A pipe that nobody reads while somebody else is waited for would fill, and stop the process.
        self._words = tempfile.TemporaryFile()  # noqa: SIM115
        environment = os.environ | {"PYTHONPATH": _packages(), "PYTHONFAULTHANDLER": "1"}
        self.process = subprocess.Popen(
            [sys.executable, "-c", code, *arguments],
            cwd=folder,
            stderr=self._words,
            stdout=subprocess.DEVNULL,
            env=environment,
        )

    @property
    def said(self) -> str:
        """What it has said so far."""
        return os.pread(self._words.fileno(), 10_000_000, 0).decode()

    def wait_for(self, text: str) -> None:
        """Wait until it has said the text."""
        self._until(lambda: text in self.said or self.process.poll() is not None, f"to say {text!r}")
        assert text in self.said, f"{text!r} never came; said: {self.said}"

    def kill(self) -> None:
        """End it as a power cut does: it can do nothing about it."""
        self.process.kill()
        self.process.wait()

    def end(self) -> int:
        """Its exit code, once it has ended by itself."""
        self._until(lambda: self.process.poll() is not None, "to end")
        return self.process.returncode

    def _until(self, has_happened: Callable[[], bool], what: str) -> None:
        end = time.monotonic() + DEADLINE
        while not has_happened():
            if time.monotonic() > end:
                told = "\n".join(one.last_words() for one in (self, *(one for one in self._others if one is not self)))
                raise AssertionError(f"waited {DEADLINE:g} s for {self.name} {what}\n{told}")
            time.sleep(0.01)

    def last_words(self) -> str:
        """Ends it if it is still there, which makes it say where it stands; gives all it said."""
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGABRT)
            self.process.wait(10.0)
            state = "was still there"
        else:
            state = f"had ended with {self.process.returncode}"
        words = "\n".join(line for line in self.said.splitlines() if not line.startswith("Extension modules:"))
        return f"--- {self.name}, started {time.monotonic() - self._begun:.1f} s ago, {state}; said:\n{words}"


def _packages() -> str:
    return os.pathsep.join([str(Path(__file__).resolve().parents[2]), os.environ.get("PYTHONPATH", "")])
