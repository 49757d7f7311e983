"""A node as a process of its own, started as `ros2 run` starts it."""

import os
import select
import subprocess
import sys
import time
from pathlib import Path

DEADLINE = 60.0  # s, for anything that a process has to do; a process that needs it all has failed


class Program:
    """One node's process and what it has said."""

    def __init__(self, name: str, namespace: str, folder: Path, **parameters: object) -> None:
        code = f"from slider_drilling.nodes.programs import {name}; {name}()"
        arguments = ["--ros-args", "-r", f"__ns:={namespace}"]
        for key, value in parameters.items():
            arguments += ["-p", f"{key}:={value}"]
        self.process = subprocess.Popen([sys.executable, "-c", code, *arguments], cwd=folder, stderr=subprocess.PIPE,
                                        stdout=subprocess.DEVNULL, env=os.environ | {"PYTHONPATH": _packages()})
        self.said = ""

    def wait_for(self, text: str) -> None:
        """Read what it says until the text comes."""
        end = time.monotonic() + DEADLINE
        stream = self.process.stderr
        assert stream is not None
        while text not in self.said:
            ready, _, _ = select.select([stream], [], [], max(0.0, end - time.monotonic()))
            chunk = os.read(stream.fileno(), 65536).decode() if ready else ""
            assert chunk, f"{text!r} never came; said: {self.said}"
            self.said += chunk

    def kill(self) -> None:
        """End it as a power cut does: it can do nothing about it."""
        self.process.kill()
        self.end()

    def end(self) -> int:
        """Its exit code, once it has ended by itself."""
        _, rest = self.process.communicate(timeout=DEADLINE)
        self.said += rest.decode()
        return self.process.returncode


def _packages() -> str:
    return os.pathsep.join([str(Path(__file__).resolve().parents[2]), os.environ.get("PYTHONPATH", "")])
