"""The scheduler of a cluster: any of `dask.distributed`."""

from __future__ import annotations

import logging
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from slider_drilling.errors import InputError

# s, for a first answer and for a first worker.
_ANSWER_S, _WORKER_S = 5.0, 30.0


@contextmanager
def connected(address: str, patience: float) -> Iterator[Any]:
    """A client of the scheduler, tried for patience s. Raises InputError where none answers or none works for it."""
    try:
        from distributed import Client
    except ImportError:
        raise InputError(f"--scheduler {address}: needs `pip install 'slider_drilling[cluster]'`") from None

    # A lost scheduler is told of in a line, not in a traceback for each of its connections.
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    deadline = time.monotonic() + patience
    while True:
        try:
            client = Client(address, timeout=_ANSWER_S)
            break
        except (OSError, ValueError) as error:
            if isinstance(error, ValueError):
                raise InputError(f"--scheduler {address}: not an address such as tcp://HOST:8786: {error}") from None
            if time.monotonic() > deadline:
                raise InputError(f"--scheduler {address}: no scheduler answers there; is it running?") from None
            time.sleep(1.0)
    try:
        _await_worker(client, address, max(patience, _WORKER_S))
        yield client
    finally:
        client.close(timeout=_ANSWER_S)


def _await_worker(client: Any, address: str, seconds: float) -> None:
    try:
        client.wait_for_workers(1, timeout=seconds)
    except TimeoutError:
        raise InputError(f"--scheduler {address}: it has no worker; start one with `dask worker {address}`") from None


def lost(error: Exception) -> bool:
    """Whether an exception says that the scheduler is gone."""
    from distributed import CancelledError
    from distributed.comm.core import CommClosedError

    return isinstance(error, (CancelledError, CommClosedError, OSError))
