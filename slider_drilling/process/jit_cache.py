"""How the numerical loops are compiled: for this very processor, once, and kept on disk.

Modules take `njit` from here, so that the settings hold before numba's first function fixes them for the process, and
the cache (numba's own: beside the source where that can be written, else in the user's cache directory) is found again.
"""

from __future__ import annotations

import contextlib
import os
import stat
import tempfile
import time
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import get_ident
from typing import Any

from slider_drilling.errors import InputError

try:
    with warnings.catch_warnings():
        warnings.filterwarnings("error", message="Environment variable 'NUMBA_")
        import llvmlite.binding
        from numba import njit
        from numba.core import config
        from numba.core.codegen import get_host_cpu_features
        from numba.core.event import Event, Listener, install_listener
except Exception as error:
    # Whatever numba makes of a variable that it cannot read; without any it is no fault of the user's.
    if not (_given := " ".join(f"{name}={value}" for name, value in os.environ.items() if name.startswith("NUMBA_"))):
        raise
    _why = str(error).partition("\n")[0].rstrip(".")
    raise InputError(f"{_given}: numba does not start: {_why}; unset it") from None

__all__ = ["INLINED_JIT_OPTIONS", "JIT_OPTIONS", "announce_compilation", "available_threads", "njit", "vector_bits"]

JIT_OPTIONS: dict[str, Any] = {
    "cache": True,
    "error_model": "numpy",
    # Not "nnan" and "ninf": a run that blows up must show it.
    "fastmath": {"contract", "arcp", "nsz", "reassoc"},
    "nogil": True,
    # The loops allocate nothing. Reference counts of their arrays, one atomic addition each, would cost a quarter of
    # a single run's step.
    "_nrt": False,
}
# Of functions that only compiled code calls: no entry for Python, which takes longest to compile, and no calls, each of
# which would push seven words an array and compare every two arrays for overlap anew: 40 % of a step of few elements.
INLINED_JIT_OPTIONS: dict[str, Any] = {
    **JIT_OPTIONS, "cache": False, "forceinline": True, "no_cpython_wrapper": True, "no_cfunc_wrapper": True,
}  # fmt: skip


def available_threads() -> int:
    """How many threads a batch of simulations may use: two, or as many as numba was allowed (NUMBA_NUM_THREADS)."""
    return min(2, config.NUMBA_NUM_THREADS)  # type: ignore[attr-defined]


def vector_bits() -> int:
    """Width of the vectors that loops are compiled for."""
    features = config.CPU_FEATURES or get_host_cpu_features()  # type: ignore[attr-defined]
    if "+avx512vl" in features and "-prefer-256-bit" in features:
        return 512
    return 256 if "+avx2" in features else 128


@contextmanager
def announce_compilation(function: Any, description: str) -> Iterator[None]:
    """Tell the user on stderr while ``function`` is compiled, if it is, during the block."""
    if function.overloads:
        yield
        return
    with install_listener("numba:compile", _Announcement(function, description)):
        yield


class _Announcement(Listener):
    """Hears of compilations that the cache could not spare: of its own thread, for every listener hears of all."""

    def __init__(self, function: Any, what: str) -> None:
        self._function, self._what = function, what
        self._thread, self._begun = get_ident(), 0.0

    def on_start(self, event: Event) -> None:
        if self._is_own(event):
            self._begun = time.monotonic()
            self._say(f"compiling {self._what} for this processor; this happens once and takes about ten seconds")

    def on_end(self, event: Event) -> None:
        if self._is_own(event):
            self._say(f"compiled in {time.monotonic() - self._begun:.0f} s")

    def _is_own(self, event: Event) -> bool:
        return event.data["dispatcher"] is self._function and get_ident() == self._thread

    @staticmethod
    def _say(sentence: str) -> None:
        from slider_drilling.console.streams import stderr

        stderr().print(sentence)


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
    config.CACHE_DIR = cache_folder(config.CACHE_DIR)  # type: ignore[attr-defined]


def cache_folder(given: str) -> str:
    """Where numba is to keep what it compiles: the folder given, its own choice (empty), or one of this user's.

    Raises InputError where the folder given cannot be written; numba would end with a traceback there, as it would
    where it can write neither beside the source nor at home.
    """
    if given:
        try:
            os.makedirs(given, exist_ok=True)
            with tempfile.TemporaryFile(dir=given):
                return given
        except OSError as error:
            raise InputError(
                f"NUMBA_CACHE_DIR = {given}: cannot be written: {error.strerror}; name a folder of yours, or unset it"
            ) from None
    beside, home = Path(__file__).parent, Path(os.path.expanduser("~"))
    if any(os.access(place, os.W_OK) for place in (beside, home / ".cache", home)):
        return ""
    # One folder a user, found again by the next run; code from one that others can write to must not be run.
    own = Path(tempfile.gettempdir()) / f"slider_drilling_{os.getuid()}"
    with contextlib.suppress(FileExistsError):
        own.mkdir(mode=0o700)
    found = own.lstat()
    if not stat.S_ISDIR(found.st_mode) or found.st_uid != os.getuid() or stat.S_IMODE(found.st_mode) & 0o077:
        raise InputError(f"{own}: not this user's own folder for compiled code; remove it, or set NUMBA_CACHE_DIR")
    return str(own)


_set_up()
