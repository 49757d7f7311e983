"""A node in a process of its own."""

import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path

from fork_server import ForkedProcess, fork_program

from slider_drilling.nodes.run_node import NODES

DEADLINE = 120.0  # s, for anything that a process has to do; a process that needs it all has failed


class NodeProcess:
    """One node's process and its output.

    Args:
        name: Of its program.
        namespace: Of the node.
        folder: Its working directory.
        others: The processes that it works with; if a wait times out, the output and the stack of all of them is
            printed.
        new_interpreter: Start it as `ros2 run` does, and not as a fork of a process that has imported it.
        parameters: Of the node.
    """

    def __init__(
        self,
        name: str,
        namespace: str,
        folder: Path,
        others: Sequence["NodeProcess"] = (),
        new_interpreter: bool = True,
        **parameters: object,
    ) -> None:
        arguments = ["--ros-args", "-r", f"__ns:={namespace}"]
        for key, value in parameters.items():
            arguments += ["-p", f"{key}:={value}"]
        self.name = f"{namespace}/{name}"
        self._others = others
        self._started = time.monotonic()
        # A file, since a pipe that is not read would fill and block the process.
        self._output_file = tempfile.TemporaryFile()  # noqa: SIM115
        self.process: subprocess.Popen | ForkedProcess
        if new_interpreter:
            self.process = self._start_interpreter(name, arguments, folder)
        else:
            error = self._output_file.fileno()
            with open(os.devnull, "wb") as output:
                self.process = fork_program(
                    f"slider_drilling.nodes.programs:{name}", arguments, folder, output.fileno(), error,
                    loader="fork_loaders:load_nodes", imports=[NODES[name][0]],
                )  # fmt: skip

    def _start_interpreter(self, name: str, arguments: Sequence[str], folder: Path) -> subprocess.Popen:
        code = f"from slider_drilling.nodes.programs import {name}; {name}()"
        return subprocess.Popen(
            [sys.executable, "-c", code, *arguments],
            cwd=folder,
            stderr=self._output_file,
            stdout=subprocess.DEVNULL,
            env=os.environ | {"PYTHONPATH": _packages(), "PYTHONFAULTHANDLER": "1"},
        )

    @property
    def output(self) -> str:
        """Its output so far."""
        return os.pread(self._output_file.fileno(), 10_000_000, 0).decode()

    def wait_for(self, text: str) -> None:
        """Wait until it has printed a text."""
        self._until(lambda: text in self.output or self.process.poll() is not None, f"to print {text!r}")
        assert text in self.output, f"{text!r} never came; output: {self.output}"

    def kill(self) -> None:
        """Kill it with SIGKILL."""
        self.process.kill()
        self.process.wait()

    def end(self) -> int:
        """Wait until it ends; returns its exit code."""
        self._until(lambda: self.process.poll() is not None, "to end")
        return self.process.returncode

    def _until(self, has_happened: Callable[[], bool], what: str) -> None:
        end = time.monotonic() + DEADLINE
        while not has_happened():
            if time.monotonic() > end:
                processes = [self, *(other for other in self._others if other is not self)]
                outputs = "\n".join(process.last_output() for process in processes)
                raise AssertionError(f"waited {DEADLINE:g} s for {self.name} {what}\n{outputs}")
            time.sleep(0.01)

    def last_output(self) -> str:
        """Abort it if it still runs, which makes it print its stack; returns its output."""
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGABRT)
            self.process.wait(10.0)
            state = "was still running"
        else:
            state = f"had ended with {self.process.returncode}"
        words = "\n".join(line for line in self.output.splitlines() if not line.startswith("Extension modules:"))
        return f"--- {self.name}, started {time.monotonic() - self._started:.1f} s ago, {state}; output:\n{words}"


def _packages() -> str:
    return os.pathsep.join([str(Path(__file__).resolve().parents[2]), os.environ.get("PYTHONPATH", "")])
