"""SIGINT, SIGTERM and SIGHUP end a command alike: by an exception, and with an exit code that tells which it was."""

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
_received: list[int] = []
_waiting: list[int] | None = None  # signals that came while they were put off; None while they are not

_LATER = 0.02  # s after which a signal whose exception was lost comes again


class TerminationSignal(KeyboardInterrupt):
    """A signal asked the command to end. What ends in order on Ctrl-C ends in order on this. number: of the signal."""

    def __init__(self, number: int) -> None:
        super().__init__(signal.Signals(number).name)
        self.number = number


def raise_on_signals() -> None:
    """Raise `TerminationSignal` on SIGINT, SIGTERM and SIGHUP, except those that the parent process ignores."""
    _received.clear()
    for number in _ENDING:
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, _end)
    sys.unraisablehook = _again


@contextmanager
def defer_signals() -> Iterator[None]:
    """Have the signals that come meanwhile end the command after this: for a second of work that must not be torn.

    A library in C++ that calls Python makes another error of what a signal raises there, or aborts the process.
    """
    global _waiting
    if _waiting is not None or threading.current_thread() is not threading.main_thread():
        yield
        return
    came = _waiting = []
    try:
        yield
    finally:
        _waiting = None
    if came:
        raise TerminationSignal(came[0])


def restore_default_handlers() -> None:
    """From now on such a signal ends the process without a word: what there was to do in order is done.

    While Python shuts down an exception would only be printed.
    """
    for number in _ENDING:
        if signal.getsignal(number) is _end:
            signal.signal(number, signal.SIG_DFL)


def signal_exit_code() -> int:
    """128 and the number of the first signal that came, as shells have it; 0 where none did."""
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
    """Keep for `exit_code` a signal that another handler has taken."""
    _received.append(number)


def _end(number: int, frame: FrameType | None) -> None:
    record_signal(number)
    if _waiting is not None:
        _waiting.append(number)
        return
    raise TerminationSignal(number)


def _again(lost: Any) -> None:
    """Send a signal again that came where Python lets nothing be raised: in a finaliser, in a callback of an import."""
    if isinstance(lost.exc_value, TerminationSignal):
        timer = threading.Timer(_LATER, os.kill, (os.getpid(), lost.exc_value.number))
        timer.daemon = True
        timer.start()
    else:
        sys.__unraisablehook__(lost)
