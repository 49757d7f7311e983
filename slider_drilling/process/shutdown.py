"""SIGINT, SIGTERM and SIGHUP end a command by an exception, with an exit code that names the signal."""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

_ENDING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
_received: list[int] = []  # signal numbers
_deferred: list[int] | None = None  # received during `defer_signals`; None outside of it

_RESEND_DELAY = 0.02  # s after which a signal whose exception was lost is sent again


class TerminationSignal(KeyboardInterrupt):
    """A signal asks the command to end; code that handles Ctrl-C handles this too.

    Attributes:
        number: Of the signal.
    """

    def __init__(self, number: int) -> None:
        super().__init__(signal.Signals(number).name)
        self.number = number


def raise_on_signals() -> None:
    """Raise `TerminationSignal` on SIGINT, SIGTERM and SIGHUP, except those that the parent process ignores."""
    _received.clear()
    for number in _ENDING:
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, _handle)
    sys.unraisablehook = _resend_lost_signal


@contextmanager
def defer_signals() -> Iterator[None]:
    """Raise for signals after the block instead of within it. Use it for short work that must not be interrupted.

    A C++ library that calls Python turns an exception of a signal handler into another error, or aborts the process.
    """
    global _deferred
    if _deferred is not None or threading.current_thread() is not threading.main_thread():
        yield
        return
    received = _deferred = []
    try:
        yield
    finally:
        _deferred = None
    if received:
        raise TerminationSignal(received[0])


def restore_default_handlers() -> None:
    """Let signals end the process silently from now on: while Python shuts down, an exception would be printed."""
    for number in _ENDING:
        if signal.getsignal(number) is _handle:
            signal.signal(number, signal.SIG_DFL)


def signal_exit_code() -> int:
    """128 plus the number of the first signal, as shells report it; 0 without a signal."""
    return 128 + _received[0] if _received else 0


def caused_by_signal(error: BaseException) -> bool:
    """Whether a signal caused this error: Python and libraries wrap exceptions that pass through them."""
    cause: BaseException | None = error
    while cause is not None:
        if isinstance(cause, TerminationSignal):
            return True
        cause = cause.__cause__ or cause.__context__
    return False


def record_signal(number: int) -> None:
    """Note a signal that another handler received, for `signal_exit_code`."""
    _received.append(number)


def _handle(number: int, frame: FrameType | None) -> None:
    record_signal(number)
    if _deferred is not None:
        _deferred.append(number)
        return
    raise TerminationSignal(number)


def _resend_lost_signal(lost: Any) -> None:
    """Send a signal again whose exception Python dropped: in a finaliser, or in a callback of an import."""
    if isinstance(lost.exc_value, TerminationSignal):
        timer = threading.Timer(_RESEND_DELAY, os.kill, (os.getpid(), lost.exc_value.number))
        timer.daemon = True
        timer.start()
    else:
        sys.__unraisablehook__(lost)
