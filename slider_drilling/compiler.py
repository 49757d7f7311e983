"""How the numerical loops are compiled: for this very processor, once, and kept on disk.

Imported by every module that compiles, before it does, so that the settings hold from the first function on and the
cache (numba's own: beside the source where that can be written, else in the user's cache directory) is found again.
"""

from __future__ import annotations

from typing import Any

import llvmlite.binding
from numba.core import config
from numba.core.codegen import get_host_cpu_features

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


def _set_up() -> None:
    # LLVM vectorises a loop over many arrays only if it may check that they do not overlap; its default of 8 checks
    # is too few for a step of the string.
    llvmlite.binding.set_option("slider_drilling", "-runtime-memory-check-threshold=1000")
    if config.CPU_FEATURES is None:  # type: ignore[attr-defined]
        features = get_host_cpu_features()
        if "+avx512vl" in features:
            # LLVM avoids 512-bit vectors on processors that lower their clock for them; the step gains more than that.
            config.CPU_FEATURES = f"{features},-prefer-256-bit"  # type: ignore[attr-defined]


_set_up()
