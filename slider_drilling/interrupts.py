"""SIGINT, SIGTERM and SIGHUP end a command alike: by an exception, and with an exit code that tells which it was."""

from __future__ import annotations

import signal
from types import FrameType

_ENDING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
_received: list[int] = []


class Ended(KeyboardInterrupt):
    """A signal asked the command to end. What ends in order on Ctrl-C ends in order on this."""


def raise_on_signals() -> None:
    """Raise `Ended` on the signals that end a command, but for those that whoever started it had ignored."""
    _received.clear()
    for number in _ENDING:
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, _end)


def end_at_once() -> None:
    """From now on such a signal ends the process without a word: what there was to do in order is done.

    While Python shuts down an exception would only be printed.
    """
    for number in _ENDING:
        if signal.getsignal(number) is _end:
            signal.signal(number, signal.SIG_DFL)


def exit_code() -> int:
    """128 and the number of the first signal that came, as shells have it; 0 where none did."""
    return 128 + _received[0] if _received else 0


def note(number: int) -> None:
    """Keep for `exit_code` a signal that another handler has taken."""
    _received.append(number)


def _end(number: int, frame: FrameType | None) -> None:
    note(number)
    raise Ended(signal.Signals(number).name)
