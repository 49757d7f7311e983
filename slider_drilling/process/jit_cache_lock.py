"""Numba's cache on disk, with a lock: of several programs that need a function at once, one compiles it.

Nodes of one launch, workers of one campaign and parallel tests start together. Without a lock each compiles the same
loops, and all are late.
"""

from __future__ import annotations

import contextlib
import fcntl
import os
import time
from pathlib import Path
from typing import IO, Any

from numba.core.caching import FunctionCache

_LONGEST_WAIT_S = 60.0  # for a program that compiles; one that was stopped meanwhile must not stop all others
_POLLED_S = 0.05


class LockedFunctionCache(FunctionCache):
    """The cache of one function. The lock is held from a function that is not there until it has been saved."""

    def __init__(self, function: Any) -> None:
        super().__init__(function)
        self._path = Path(self.cache_path) / f"{self._impl.filename_base}.lock"
        self._held: IO[bytes] | None = None

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """See numba. Waits for another program that is compiling the function, up to a minute."""
        found = super().load_overload(sig, target_context)
        if found is None:
            self._acquire()
            found = super().load_overload(sig, target_context)
            if found is not None:
                self._release()
        return found

    def save_overload(self, sig: Any, data: Any) -> None:
        """See numba."""
        try:
            super().save_overload(sig, data)
        finally:
            self._release()

    def _acquire(self) -> None:
        self._release()  # still held if the last compilation failed
        with contextlib.suppress(OSError):  # a full or read-only disk: numba says so when it saves
            held = self._path.open("ab")
            os.set_inheritable(held.fileno(), False)
            self._held = held
            end = time.monotonic() + _LONGEST_WAIT_S
            while time.monotonic() < end:
                with contextlib.suppress(BlockingIOError):
                    fcntl.flock(held, fcntl.LOCK_EX | fcntl.LOCK_NB)
                    return
                time.sleep(_POLLED_S)

    def _release(self) -> None:
        if self._held is not None:
            self._held.close()
            self._held = None
