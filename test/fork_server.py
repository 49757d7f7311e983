"""Starts programs as forks of one process that has imported them and loaded their compiled code.

A program that starts in a new interpreter spends a second of processor on that; a fork has it done. Run as a program,
this module is the server; `fork_program` starts one for the process that calls it, and asks it.
"""

from __future__ import annotations

import atexit
import functools
import gc
import importlib
import json
import os
import select
import signal
import socket
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

CLI = "slider_drilling.cli:main"
MAX_REQUEST = 1_000_000  # bytes: program, arguments, folder and environment
REPOSITORY = Path(__file__).resolve().parents[1]


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


def fork_program(
    program: str,
    arguments: Sequence[str],
    folder: Path,
    output: int,
    error: int,
    environment: Mapping[str, str] | None = None,
    loader: str = "fork_loaders:load_commands",
    imports: Sequence[str] = (),
) -> ForkedProcess:
    """Start a program.

    Args:
        program: Its function, as module:function.
        arguments: Of its command line.
        folder: Its working directory.
        output: File descriptor of its stdout.
        error: File descriptor of its stderr.
        environment: Its variables; those of this process by default.
        loader: The function that imports what programs of its server need, as module:function.
        imports: More modules that its server imports, once, before it forks.
    """
    server = _server(loader)
    exit_code, theirs = os.pipe()
    variables = dict(os.environ if environment is None else environment)
    request = {
        "program": program,
        "arguments": list(arguments),
        "folder": str(folder),
        "environment": variables,
        "imports": list(imports),
    }
    socket.send_fds(server, [json.dumps(request).encode()], [output, error, theirs])
    os.close(theirs)
    return ForkedProcess(int(server.recv(16)), exit_code)


def run_cli(
    *arguments: object,
    folder: Path,
    environment: Mapping[str, str] | None = None,
    output: int | None = None,
    loader: str = "fork_loaders:load_commands",
) -> subprocess.CompletedProcess[str]:
    """What `slider-drilling ARGUMENTS` answers, run to its end in a process of its own.

    The arguments are those of `fork_program`; without an `output`, its stdout is in the answer.
    """
    words = [str(argument) for argument in arguments]
    with tempfile.TemporaryFile() as printed, tempfile.TemporaryFile() as error:
        out = printed.fileno() if output is None else output
        process = fork_program(CLI, words, folder, out, error.fileno(), environment, loader)
        try:
            code = process.wait(120.0)
        except subprocess.TimeoutExpired:
            process.kill()
            raise
        said, complained = (os.pread(file.fileno(), 10_000_000, 0).decode() for file in (printed, error))
    return subprocess.CompletedProcess(words, code, said, complained)


@functools.cache
def _server(loader: str) -> socket.socket:
    """The connection to this process's server, which ends with it."""
    own, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    path = os.pathsep.join([str(REPOSITORY), *sys.path, os.environ.get("PYTHONPATH", "")])
    process = subprocess.Popen(
        [sys.executable, "-c", f"import fork_server; fork_server.main({theirs.fileno()}, {loader!r})"],
        env=os.environ | {"PYTHONPATH": path, "PYTHONFAULTHANDLER": "1"},
        pass_fds=[theirs.fileno()],
    )
    theirs.close()

    def end() -> None:
        own.close()
        process.wait()

    atexit.register(end)
    return own


def main(connection: int, loader: str) -> None:
    """Serve until the other end of the connection is closed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    _function(loader)()
    gc.collect()
    gc.freeze()  # a collection in a fork would touch, and so copy, all that is loaded
    request, output, error = _serve(socket.socket(fileno=connection))
    if request:
        _run(request, output, error)


def _function(name: str) -> Any:
    module, _, function = name.partition(":")
    return getattr(importlib.import_module(module), function)


def _serve(connection: socket.socket) -> tuple[dict[str, Any], int, int]:
    """Fork for each request. Returns in the fork, with its request, stdout and stderr; empty at the server's end."""
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
        text, received, _, _ = socket.recv_fds(connection, MAX_REQUEST, 3)
        if not text:
            return {}, -1, -1
        request = json.loads(text)
        for module in request["imports"]:
            importlib.import_module(module)
        output, error, exit_code = received
        pid = os.fork()
        if pid == 0:
            signal.set_wakeup_fd(-1)
            connection.close()
            for descriptor in (wake, woken, exit_code, *exit_codes.values()):
                os.close(descriptor)
            return request, output, error
        os.close(output)
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


def _run(request: dict[str, Any], output: int, error: int) -> None:
    """Run the program with its own arguments, folder, environment, output and signal handlers."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    for number in (signal.SIGTERM, signal.SIGHUP, signal.SIGCHLD):
        signal.signal(number, signal.SIG_DFL)
    for descriptor, standard in ((output, 1), (error, 2)):
        os.dup2(descriptor, standard)
        os.close(descriptor)
    os.chdir(request["folder"])
    os.environ.clear()
    os.environ.update(request["environment"])
    sys.argv = ["-c", *request["arguments"]]
    _function(request["program"])()
