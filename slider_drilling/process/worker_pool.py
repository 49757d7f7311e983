"""Runs calls in worker processes that end with this process, however it ends."""

from __future__ import annotations

import concurrent.futures
import contextlib
import os
import pickle
import queue
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from typing import Any, TypeVar

from slider_drilling.process.own_path import worker_command

T = TypeVar("T")
_CHECK_PERIOD = 0.5  # s between two looks whether the parent lives
_PARENT = "SLIDER_DRILLING_WORKER_OF"  # environment variable with the parent's process id


def map_in_processes(function: Callable[..., T], calls: Iterable[tuple[object, ...]], jobs: int) -> Iterator[T]:
    """Call a function in worker processes; one job runs in this process.

    Args:
        function: Can be pickled.
        calls: The arguments of each call.
        jobs: How many processes to use.

    Yields:
        The results, in the order in which the calls end.

    Raises:
        Exception: What a call raised.
    """
    if jobs == 1:
        yield from (function(*call) for call in calls)
        return
    waiting = list(calls)
    workers = [_Worker() for _ in range(min(jobs, len(waiting)))]
    free: queue.SimpleQueue[_Worker] = queue.SimpleQueue()
    for worker in workers:
        free.put(worker)

    def run(call: tuple[object, ...]) -> T:
        worker = free.get()
        try:
            return worker.call(function, call)
        finally:
            free.put(worker)  # after a failure, too: a thread that waits for it would keep the program from ending

    # One thread for each process, which waits for it.
    threads = concurrent.futures.ThreadPoolExecutor(max(len(workers), 1))
    try:
        ended = concurrent.futures.as_completed([threads.submit(run, call) for call in waiting])
        yield from (future.result() for future in ended)
    finally:
        threads.shutdown(wait=False, cancel_futures=True)
        for worker in workers:
            worker.kill()


class _Worker:
    """A process that makes one call after the other."""

    def __init__(self) -> None:
        # A session of its own: an interrupt at the terminal reaches this process alone, which ends the worker.
        self._process = subprocess.Popen(
            worker_command(__name__, "serve"), stdin=subprocess.PIPE, stdout=subprocess.PIPE,
            env={**os.environ, _PARENT: str(os.getpid())}, start_new_session=True)  # fmt: skip

    def call(self, function: Callable[..., Any], arguments: tuple[object, ...]) -> Any:
        """Return what the call returned. Raises what it raised."""
        assert self._process.stdin is not None and self._process.stdout is not None
        try:
            pickle.dump((function, arguments), self._process.stdin)
            self._process.stdin.flush()
            result, error = pickle.load(self._process.stdout)
        except (BrokenPipeError, EOFError):
            raise RuntimeError(f"a worker process ended with code {self._process.wait()}") from None
        if error is not None:
            raise error
        return result

    def kill(self) -> None:
        """End the process at once."""
        self._process.kill()
        self._process.wait()
        for pipe in (self._process.stdin, self._process.stdout):
            with contextlib.suppress(BrokenPipeError):
                assert pipe is not None
                pipe.close()


def serve() -> None:
    """The worker: one call in and one answer out, until the parent closes the pipe or ends."""
    exit_with_parent(int(os.environ.pop(_PARENT)))
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)   # what a call prints must not stand among the answers
    while True:
        try:
            function, arguments = pickle.load(sys.stdin.buffer)
        except EOFError:
            return
        pickle.dump(_answer(function, arguments), answers)
        answers.flush()


def _answer(function: Callable[..., Any], arguments: tuple[object, ...]) -> tuple[Any, BaseException | None]:
    """Result and error of a call, either of them None; an error that cannot be pickled as its text."""
    try:
        return function(*arguments), None
    except BaseException as error:
        try:
            pickle.loads(pickle.dumps(error))
        except Exception:
            return None, RuntimeError(f"{type(error).__name__}: {error}")
        return None, error


def exit_with_parent(parent: int) -> None:
    """A worker whose parent was killed would go on with its call."""

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(_CHECK_PERIOD)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
