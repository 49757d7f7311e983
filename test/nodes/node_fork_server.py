"""Starts nodes as forks of one process that has imported them and loaded their compiled code.

A node that starts in a new interpreter spends a second of processor on that; a fork has it done. Run as a program, this
module is the server; `fork_node` starts one for the process that calls it, and asks it.
"""

from __future__ import annotations

import atexit
import functools
import importlib
import json
import os
import select
import signal
import socket
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

LOADED = ("friction_simulator", "rocking_controller", "recorder", "log_player", "twin")
MAX_REQUEST = 1_000_000  # bytes: name, arguments, folder and environment of a node
REPOSITORY = Path(__file__).resolve().parents[2]


class ForkedProcess:
    """A process of the server, with the part of subprocess.Popen that tests use."""

    def __init__(self, pid: int, exit_code: int) -> None:
        self.pid = pid
        self.returncode: int | None = None
        self._exit_code = exit_code  # a pipe's end

    def __del__(self) -> None:
        os.close(self._exit_code)

    def wait(self, timeout: float | None = None) -> int:
        """Its exit code, negative for a signal. Raises subprocess.TimeoutExpired after timeout s."""
        if self.returncode is None:
            ready, _, _ = select.select([self._exit_code], [], [], timeout)
            if not ready:
                raise subprocess.TimeoutExpired(f"process {self.pid}", timeout or 0.0)
            self.returncode = int(os.read(self._exit_code, 16))
        return self.returncode

    def poll(self) -> int | None:
        """Its exit code; None while it runs."""
        try:
            return self.wait(0.0)
        except subprocess.TimeoutExpired:
            return None

    def send_signal(self, number: int) -> None:
        """Send a signal, unless it has ended."""
        if self.poll() is None:
            os.kill(self.pid, number)

    def kill(self) -> None:
        """Send SIGKILL."""
        self.send_signal(signal.SIGKILL)


def fork_node(name: str, arguments: Sequence[str], folder: Path, error: int) -> ForkedProcess:
    """Start a node's program.

    Args:
        name: Of the program.
        arguments: Of its command line.
        folder: Its working directory.
        error: File descriptor that its stderr is written to.
    """
    server = _server()
    exit_code, theirs = os.pipe()
    request = {"name": name, "arguments": list(arguments), "folder": str(folder), "environment": dict(os.environ)}
    socket.send_fds(server, [json.dumps(request).encode()], [error, theirs])
    os.close(theirs)
    return ForkedProcess(int(server.recv(16)), exit_code)


@functools.cache
def _server() -> socket.socket:
    """The connection to this process's server, which ends with it."""
    own, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    path = os.pathsep.join([str(REPOSITORY), str(Path(__file__).parent), os.environ.get("PYTHONPATH", "")])
    process = subprocess.Popen(
        [sys.executable, "-c", f"import node_fork_server; node_fork_server.main({theirs.fileno()})"],
        env=os.environ | {"PYTHONPATH": path, "PYTHONFAULTHANDLER": "1"},
        pass_fds=[theirs.fileno()],
    )
    theirs.close()

    def end() -> None:
        own.close()
        process.wait()

    atexit.register(end)
    return own


def main(connection: int) -> None:
    """Serve until the other end of the connection is closed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    _load()
    request, error = _serve(socket.socket(fileno=connection))
    if request:
        _run(request, error)


def _load() -> None:
    """Import the nodes and their libraries, and load the compiled code that they run."""
    from slider_drilling.nodes import environment

    environment.prepare()
    for name in LOADED:
        _import(name)
    from slider_drilling.control import SlideController
    from slider_drilling.drillstring import VirtualRig
    from slider_drilling.rig import load_rig

    rig = load_rig(REPOSITORY / "config" / "rig.example.yaml")
    virtual, controller = VirtualRig(rig, elements=20), SlideController(rig)
    for _ in range(3):
        virtual.step(controller.step(virtual.measurements))


def _import(name: str) -> None:
    from slider_drilling.nodes.run_node import NODES

    importlib.import_module(NODES[name][0])


def _serve(connection: socket.socket) -> tuple[dict[str, Any], int]:
    """Fork for each request. Returns in the fork, with its request and stderr; without one at the server's end."""
    wake, woken = os.pipe()
    os.set_blocking(woken, False)
    signal.signal(signal.SIGCHLD, lambda number, frame: None)
    signal.set_wakeup_fd(woken)
    exit_codes: dict[int, int] = {}
    while True:
        ready, _, _ = select.select([connection, wake], [], [])
        if wake in ready:
            os.read(wake, 1024)
            _reap(exit_codes)
        if connection not in ready:
            continue
        text, received, _, _ = socket.recv_fds(connection, MAX_REQUEST, 2)
        if not text:
            return {}, -1
        request = json.loads(text)
        _import(request["name"])
        error, exit_code = received
        pid = os.fork()
        if pid == 0:
            signal.set_wakeup_fd(-1)
            connection.close()
            for descriptor in (wake, woken, exit_code, *exit_codes.values()):
                os.close(descriptor)
            return request, error
        os.close(error)
        exit_codes[pid] = exit_code
        connection.send(str(pid).encode())


def _reap(exit_codes: dict[int, int]) -> None:
    """Tell the exit codes of the processes that have ended."""
    for pid in list(exit_codes):
        ended, status = os.waitpid(pid, os.WNOHANG)
        if ended:
            descriptor = exit_codes.pop(pid)
            os.write(descriptor, str(os.waitstatus_to_exitcode(status)).encode())
            os.close(descriptor)


def _run(request: dict[str, Any], error: int) -> None:
    """Run the program with its own arguments, folder, environment, output and signal handlers."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    for number in (signal.SIGTERM, signal.SIGHUP, signal.SIGCHLD):
        signal.signal(number, signal.SIG_DFL)
    os.dup2(error, 2)
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    os.chdir(request["folder"])
    os.environ.clear()
    os.environ.update(request["environment"])
    sys.argv = ["-c", *request["arguments"]]
    from slider_drilling.nodes import programs

    getattr(programs, request["name"])()
