"""How a program of nodes ends: by itself, by a signal, or by an error that one line explains."""

from __future__ import annotations

import signal
from collections.abc import Callable
from types import FrameType
from typing import Any, TypeVar

from slider_drilling.errors import InputError
from slider_drilling.process.shutdown import record_signal

Result = TypeVar("Result")


class SignalInterrupt(BaseException):
    """A signal came while nothing was there yet to be ended, or a user's code ran, which is not to swallow it."""


class ShutdownRequest:
    """Asked by nodes and signals to end the program; the spinning loop looks at it.

    A callback does not raise: the executor would print the trace of what is a user's mistake. It calls `fail`.
    A signal only sets `requested`: what `on_stop` does need not be safe to do in the middle of anything.
    """

    def __init__(self) -> None:
        self.requested = False
        self.signal = 0  # number of the first one that came
        self.error: InputError | None = None
        self.on_stop: Callable[[], None] = lambda: None
        self._may_interrupt = False
        self._before: dict[signal.Signals, Any] = {}

    def stop(self) -> None:
        """End the program, its work being done."""
        self.requested = True
        self.on_stop()

    def fail(self, error: InputError) -> None:
        """End the program with this error; the first one counts."""
        self.error = self.error or error
        self.stop()

    def take_signals(self) -> None:
        """End on SIGINT, SIGTERM and SIGHUP from now on, however often they come.

        rclpy's own handlers would shut its context down at once, and a second SIGINT would then end the
        shut-down code itself, a recorder's file unfinished.
        """
        self._handle_with(self._on_signal)

    def raise_on_signals(self, leaving: Callable[[int], BaseException]) -> None:
        """Raise this, of a signal's number, on SIGINT, SIGTERM and SIGHUP: while there is nothing to end in order yet.

        Raises it at once where such a signal has come already. The first time on a machine a plant compiles for a
        quarter of a minute; nobody should have to wait for that. No bare KeyboardInterrupt: where one leaves a text
        that Python executes, as libraries do that make code, Python ends the process by SIGINT after all is done.
        """

        def leave(number: int, frame: FrameType | None) -> None:
            # A second one would break off the leaving.
            self.take_signals()
            self._on_signal(number, frame)
            raise leaving(number)

        self._handle_with(leave)
        if self.signal:
            self.take_signals()
            raise leaving(self.signal)

    def _handle_with(self, handler: Callable[[int, FrameType | None], None]) -> None:
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            if signal.getsignal(number) is signal.SIG_IGN:
                continue  # whoever started it wants it so: nohup
            before = signal.signal(number, handler)
            self._before.setdefault(number, before)

    def restore_handlers(self) -> None:
        """Let signals do again what they did before."""
        for number, handler in self._before.items():
            signal.signal(number, handler)
        self._before.clear()

    def run_interruptible(self, work: Callable[[], Result]) -> Result | None:
        """Do a user's work, which may never end: a signal ends it, and None is returned then."""
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
        """Raise what `fail` was told."""
        if self.error is not None:
            raise self.error
