"""How the numerical loops are compiled: for this very processor, once, and kept on disk.

Modules take `njit` from here, so that the settings hold before numba's first function fixes them for the process, and
the cache (numba's own: beside the source where that can be written, else in the user's cache directory) is found again.
"""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import llvmlite.binding
from numba import njit
from numba.core import config
from numba.core.codegen import get_host_cpu_features
from numba.core.event import Event, Listener, install_listener

__all__ = ["COMPILE", "INNER", "announced", "njit", "vector_bits"]

COMPILE: dict[str, Any] = {
    "cache": True,
    "error_model": "numpy",
    # Not "nnan" and "ninf": a run that blows up must show it.
    "fastmath": {"contract", "arcp", "nsz", "reassoc"},
    "nogil": True,
    # The loops allocate nothing. Reference counts of their arrays, one atomic addition each, would cost a quarter of
    # a single run's step.
    "_nrt": False,
}
# Of functions that only compiled code calls: no entry for Python, which takes longest to compile.
INNER: dict[str, Any] = {**COMPILE, "cache": False, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}


def vector_bits() -> int:
    """Width of the vectors that loops are compiled for."""
    features = config.CPU_FEATURES or get_host_cpu_features()  # type: ignore[attr-defined]
    if "+avx512vl" in features and "-prefer-256-bit" in features:
        return 512
    return 256 if "+avx2" in features else 128


@contextmanager
def announced(function: Any, what: str) -> Iterator[None]:
    """Tell the user on stderr while ``function`` is compiled, if it is, during the block."""
    if function.overloads:
        yield
        return
    with install_listener("numba:compile", _Announcement(function, what)):
        yield


class _Announcement(Listener):
    """Hears of compilations that the cache could not spare."""

    def __init__(self, function: Any, what: str) -> None:
        self._function, self._what = function, what
        self._begun = 0.0

    def on_start(self, event: Event) -> None:
        if event.data["dispatcher"] is self._function:
            self._begun = time.monotonic()
            self._say(f"compiling {self._what} for this processor; this happens once and takes about ten seconds")

    def on_end(self, event: Event) -> None:
        if event.data["dispatcher"] is self._function:
            self._say(f"compiled in {time.monotonic() - self._begun:.0f} s")

    @staticmethod
    def _say(sentence: str) -> None:
        from slider_drilling.console import stderr

        stderr().print(sentence)


def _set_up() -> None:
    # LLVM vectorises a loop over many arrays only if it may check that they do not overlap; its default of 8 checks
    # is too few for a step of the string.
    llvmlite.binding.set_option("slider_drilling", "-runtime-memory-check-threshold=1000")
    if config.CPU_FEATURES is None:  # type: ignore[attr-defined]
        features = get_host_cpu_features()
        if "+avx512vl" in features:
            # LLVM avoids 512-bit vectors on processors that lower their clock for them; the step gains more than that.
            config.CPU_FEATURES = f"{features},-prefer-256-bit"  # type: ignore[attr-defined]
    # Where it can write neither beside the source nor at home, numba would end with a traceback. The folder is this
    # process's own: code from one that others can write to must not be run.
    places = (Path(__file__).parent, Path(os.path.expanduser("~/.cache")), Path.home())
    if not config.CACHE_DIR and not any(os.access(place, os.W_OK) for place in places):  # type: ignore[attr-defined]
        config.CACHE_DIR = tempfile.mkdtemp(prefix="slider_drilling_")  # type: ignore[attr-defined]


_set_up()
