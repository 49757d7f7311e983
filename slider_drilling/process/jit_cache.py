"""Compiles the numerical loops for this processor and keeps the machine code on disk.

Modules import `njit` from here, because numba fixes its settings with the first function that it decorates. The cache
is numba's own, in the folder of `jit_cache_folder`.
"""

from __future__ import annotations

import functools
import os
import time
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import get_ident
from typing import Any

from slider_drilling.errors import InputError
from slider_drilling.process.jit_cache_folder import versioned_cache_folder

try:
    with warnings.catch_warnings():
        warnings.filterwarnings("error", message="Environment variable 'NUMBA_")
        import llvmlite.binding
        from numba import __version__ as numba_version
        from numba import njit as numba_njit
        from numba.core import config
        from numba.core.codegen import get_host_cpu_features
        from numba.core.event import Event, Listener, install_listener
        from numpy import __version__ as numpy_version
except Exception as error:
    # Numba raises different errors for a variable that it cannot read. Without variables it is not the user's mistake.
    if not (_given := " ".join(f"{name}={value}" for name, value in os.environ.items() if name.startswith("NUMBA_"))):
        raise
    _cause = str(error).partition("\n")[0].rstrip(".")
    raise InputError(f"{_given}: numba does not start: {_cause}; unset it") from None

from slider_drilling.process.jit_cache_lock import LockedFunctionCache  # needs a numba that starts

__all__ = ["INLINED_JIT_OPTIONS", "JIT_OPTIONS", "announce_compilation", "available_threads", "njit", "vector_bits"]

_LIBRARIES = (f"numba {numba_version}", f"numpy {numpy_version}")
JIT_OPTIONS: dict[str, Any] = {
    "cache": True,
    "error_model": "numpy",
    # Not "nnan" and "ninf": a diverging run must show NaN or infinity.
    "fastmath": {"contract", "arcp", "nsz", "reassoc"},
    "nogil": True,
    # The loops allocate nothing, and counting references to their arrays would cost a quarter of a single run's step.
    "_nrt": False,
}
# For functions that only compiled code calls. Without an entry for Python, which takes longest to compile; and inlined,
# since each call would push seven words per array and check all pairs of arrays for overlap: 40 % of a short step.
INLINED_JIT_OPTIONS: dict[str, Any] = {
    **JIT_OPTIONS, "cache": False, "forceinline": True, "no_cpython_wrapper": True, "no_cfunc_wrapper": True,
}  # fmt: skip


def njit(function: Any = None, **options: Any) -> Any:
    """Numba's `njit`, with a cache folder for each version of the function's module and of what it imports."""
    if function is None:
        return functools.partial(njit, **options)
    given = config.CACHE_DIR  # type: ignore[attr-defined]
    try:
        if options.get("cache"):
            module = Path(function.__code__.co_filename).absolute()
            config.CACHE_DIR = versioned_cache_folder(given, module, _LIBRARIES)  # type: ignore[attr-defined]
        compiled = numba_njit(**options)(function)
        if options.get("cache"):
            compiled._cache = LockedFunctionCache(function)
        return compiled
    finally:
        config.CACHE_DIR = given  # type: ignore[attr-defined]


def available_threads() -> int:
    """How many threads a batch may use: NUMBA_NUM_THREADS, by default the cores that this process may run on."""
    return int(config.NUMBA_NUM_THREADS)  # type: ignore[attr-defined]


def vector_bits() -> int:
    """Width of the vector registers that the loops are compiled for, bits."""
    features = config.CPU_FEATURES or get_host_cpu_features()  # type: ignore[attr-defined]
    if "+avx512vl" in features and "-prefer-256-bit" in features:
        return 512
    return 256 if "+avx2" in features else 128


@contextmanager
def announce_compilation(function: Any, description: str) -> Iterator[None]:
    """Report on stderr if a function is compiled during the block.

    Args:
        function: Made by `njit`.
        description: What the function is, for the message.
    """
    if function.overloads:
        yield
        return
    with install_listener("numba:compile", _Announcement(function, description)):
        yield


class _Announcement(Listener):
    """Reports compilations of one function by its own thread; numba tells every listener of all compilations."""

    def __init__(self, function: Any, description: str) -> None:
        self._function, self._description = function, description
        self._thread, self._start = get_ident(), 0.0

    def on_start(self, event: Event) -> None:
        if self._is_own(event):
            self._start = time.monotonic()
            self._print(f"compiling {self._description} for this processor, once; it takes about ten seconds")

    def on_end(self, event: Event) -> None:
        if self._is_own(event):
            self._print(f"compiled in {time.monotonic() - self._start:.0f} s")

    def _is_own(self, event: Event) -> bool:
        return event.data["dispatcher"] is self._function and get_ident() == self._thread

    @staticmethod
    def _print(message: str) -> None:
        from slider_drilling.console.streams import stderr

        stderr().print(message)


def _set_up() -> None:
    if config.DISABLE_JIT:  # type: ignore[attr-defined]
        raise InputError("NUMBA_DISABLE_JIT = 1: the loops run compiled only; unset it")
    # LLVM vectorises a loop over many arrays only if it may check that they do not overlap; its default of 8 checks
    # is too few for a step of the string.
    llvmlite.binding.set_option("slider_drilling", "-runtime-memory-check-threshold=1000")
    if config.CPU_FEATURES is None:  # type: ignore[attr-defined]
        features = get_host_cpu_features()
        if "+avx512vl" in features:
            # LLVM avoids 512-bit vectors on processors that lower their clock for them; the step gains more than that.
            config.CPU_FEATURES = f"{features},-prefer-256-bit"  # type: ignore[attr-defined]


_set_up()
