"""Ends a program of nodes: when its work is done, on a signal, or on an error."""

from __future__ import annotations

import signal
from collections.abc import Callable
from types import FrameType
from typing import Any, TypeVar

from slider_drilling.errors import InputError
from slider_drilling.process.shutdown import record_signal

Result = TypeVar("Result")


class SignalInterrupt(BaseException):
    """A signal came before there was anything to finish, or in a user's code, which must not catch it."""


class ShutdownRequest:
    """Nodes and signals ask it to end the program; the loop that spins the nodes checks it.

    A callback calls `fail` instead of raising, since the executor would print a traceback of a user's mistake. A signal
    only sets `requested`, since `on_stop` need not be safe in a signal handler.

    Attributes:
        requested: Whether the program is to end.
        signal: Number of the first signal that came, or 0.
        error: The first error that a node reported.
        on_stop: Called by `stop`.
    """

    def __init__(self) -> None:
        self.requested = False
        self.signal = 0
        self.error: InputError | None = None
        self.on_stop: Callable[[], None] = lambda: None
        self._may_interrupt = False
        self._before: dict[signal.Signals, Any] = {}

    def stop(self) -> None:
        """End the program: its work is done."""
        self.requested = True
        self.on_stop()

    def fail(self, error: InputError) -> None:
        """End the program with an error; the first one counts."""
        self.error = self.error or error
        self.stop()

    def take_signals(self) -> None:
        """Request shutdown on SIGINT, SIGTERM and SIGHUP from now on.

        rclpy's own handlers would shut its context down immediately. A second SIGINT would then interrupt the shutdown
        and leave a recorder's file unfinished.
        """
        self._handle_with(self._on_signal)

    def raise_on_signals(self, exception: Callable[[int], BaseException]) -> None:
        """Raise an exception on SIGINT, SIGTERM and SIGHUP, while there is nothing to finish yet.

        The first compilation of the plant takes a quarter of a minute, which an interrupt must not wait for.

        Args:
            exception: Makes it from the signal's number. Not KeyboardInterrupt: if that leaves code run by `exec`, as
                in libraries that generate code, Python ends the process by SIGINT.
        """

        def handler(number: int, frame: FrameType | None) -> None:
            self.take_signals()  # a second signal would interrupt the clean-up after the first
            self._on_signal(number, frame)
            raise exception(number)

        self._handle_with(handler)
        if self.signal:
            self.take_signals()
            raise exception(self.signal)

    def _handle_with(self, handler: Callable[[int, FrameType | None], None]) -> None:
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            if signal.getsignal(number) is signal.SIG_IGN:
                continue  # the parent process wants it so: nohup
            before = signal.signal(number, handler)
            self._before.setdefault(number, before)

    def restore_handlers(self) -> None:
        """Restore the signal handlers from before."""
        for number, handler in self._before.items():
            signal.signal(number, handler)
        self._before.clear()

    def run_interruptible(self, work: Callable[[], Result]) -> Result | None:
        """Run a user's code, which may never return; None if a signal interrupted it."""
        try:
            try:
                self._may_interrupt = True
                return work()
            finally:
                self._may_interrupt = False
        except SignalInterrupt:
            return None

    def _on_signal(self, number: int, frame: FrameType | None) -> None:
        self.signal = self.signal or number
        record_signal(number)
        self.requested = True
        if self._may_interrupt:
            raise SignalInterrupt

    def raise_error(self) -> None:
        """Raise the error that a node reported, if any."""
        if self.error is not None:
            raise self.error
