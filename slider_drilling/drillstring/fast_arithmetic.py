"""Fast arithmetic of the compiled step: only as accurate as friction is known, and without slow divisions.

Double-precision roots and divisions wait for each other in the processor's only divider and would take most of a step.
Friction is not known to one part in ten million, so single precision is enough where these functions are used.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from slider_drilling.process.jit_cache import INLINED_JIT_OPTIONS, JIT_OPTIONS, njit

# No "arcp" here: with it the compiler takes a coarser estimate in packed code than in scalar code.
_ROOTS: dict[str, Any] = {**INLINED_JIT_OPTIONS, "fastmath": {"contract", "nsz"}}


@njit(**_ROOTS)
def fast_sqrt(x):
    """Square root in single precision (relative error at most 1.2e-7); x within float32's range."""
    return math.sqrt(np.float32(x))


@njit(**_ROOTS)
def fast_inverse_sqrt(x):
    """``1 / sqrt(x)`` in single precision (relative error at most 1.8e-7)."""
    return np.float32(1.0) / math.sqrt(np.float32(x))


@njit(**_ROOTS)
def fast_reciprocal(x, real):
    """``1 / x`` by a Newton step from single precision; zero where x is beyond float32's range.

    real: np.float64 (relative error 2e-14) or np.float32.
    """
    seed = np.float32(1.0) / np.float32(x)
    return seed * (real(2.0) - x * seed)


@njit(**JIT_OPTIONS)
def fast_exp(x, real):
    """``exp(x)`` for 0 <= x <= 40, constant beyond, as the eighth power of a Taylor sum.

    The relative error of ``1 / fast_exp(x)`` is at most 5e-6. real: np.float64 or np.float32.
    """
    one, half, third, quarter, fifth = real(1.0), real(0.5), real(1.0 / 3.0), real(0.25), real(0.2)
    y = min(real(0.125) * x, real(5.0))
    term = one + y * (one + y * half * (one + y * third * (one + y * quarter * (one + y * fifth))))
    square = term * term
    fourth = square * square
    return fourth * fourth
