"""Records a live stream of WITS level 0, from a TCP port or a serial line, as a WITS file."""

from __future__ import annotations

import os
import socket
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from urllib.parse import parse_qs, urlsplit

from slider_drilling.errors import InputError

_STANDARD_INPUT = 0  # its descriptor is open even where the caller has closed it, see `cli`
_BLOCK = 65_536
_WAIT_S = 0.5  # between two looks at the clock
_BAUD = 9600


def is_live(data: str) -> bool:
    """Whether a name is the address of a stream."""
    return data.startswith(("wits://", "serial://")) or data == "-"


def record_wits(address: str, path: Path, duration: float | None) -> Path:
    """Write what a stream sends into a file until it ends, Ctrl-C, or so many seconds have passed.

    Args:
        address: wits://HOST:PORT, serial:///dev/ttyS0?baud=9600, or - for standard input.
        path: The file to write, beside the log, so that nothing is lost; the name must be free.
        duration: s; None for no limit.

    Returns:
        The file.

    Raises:
        InputError: The address cannot be reached, nothing was sent, or the file cannot be written.
    """
    until = None if duration is None else time.monotonic() + duration
    count = 0
    with open_stream(address) as receive:
        try:
            with open(path, "xb") as file:
                try:
                    for block in _blocks(receive, until):
                        file.write(block)
                        file.flush()
                        count += len(block)
                except KeyboardInterrupt:
                    pass  # the usual end of a recording
        except FileExistsError:
            raise InputError(f"{path}: exists already; move it, or give another -o") from None
        except OSError as error:
            raise InputError(f"{path}: cannot record {address}: {error.strerror or error}") from None
    if not count:
        path.unlink()
        raise InputError(f"{address}: sent nothing; check address, and that the sender is on")
    return path


def _blocks(receive: Callable[[], bytes | None], until: float | None) -> Iterator[bytes]:
    """Yield what is received until the stream ends (an empty block) or the time is up; None is a wait without data."""
    while until is None or time.monotonic() < until:
        block = receive()
        if block == b"":
            return
        if block is not None:
            yield block


@contextmanager
def open_stream(address: str) -> Iterator[Callable[[], bytes | None]]:
    """A function that returns what a stream has sent; None after a wait without data, empty at its end."""
    if address == "-":
        yield lambda: os.read(_STANDARD_INPUT, _BLOCK)
        return
    parts = urlsplit(address)
    if parts.scheme == "serial":
        yield from _serial(address, parts.path, parse_qs(parts.query))
        return
    try:
        host, port = parts.hostname, parts.port
    except ValueError:
        host, port = None, None
    if not host or not port:
        raise InputError(f"{address}: give host and port, such as wits://10.0.0.7:5000")
    try:
        connection = socket.create_connection((host, port), timeout=10.0)
    except OSError as error:
        raise InputError(f"{address}: cannot connect: {error.strerror or error}") from None
    with connection:
        connection.settimeout(_WAIT_S)

        def receive() -> bytes | None:
            try:
                return connection.recv(_BLOCK)
            except TimeoutError:
                return None
            except OSError as error:
                raise _lost(address, error) from None

        yield receive


def _serial(address: str, device: str, query: dict[str, list[str]]) -> Iterator[Callable[[], bytes | None]]:
    try:
        import serial
    except ImportError:
        raise InputError(
            f"{address}: needs pyserial; install it with `pip install 'slider_drilling[tables]'`"
        ) from None
    try:
        baud = int(query.get("baud", [str(_BAUD)])[0])
        line = serial.Serial(device, baud, timeout=_WAIT_S)
    except (ValueError, OSError) as error:
        raise InputError(f"{address}: cannot open this serial line: {error}") from None

    def receive() -> bytes | None:
        try:
            return line.read(max(line.in_waiting, 1)) or None
        except OSError as error:
            raise _lost(address, error) from None

    with line:
        yield receive


def _lost(address: str, error: OSError) -> InputError:
    return InputError(f"{address}: the connection was lost: {error.strerror or error}; start it again")
