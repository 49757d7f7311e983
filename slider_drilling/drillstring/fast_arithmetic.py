"""Arithmetic of the compiled step: as exact as friction is known, and no division that a pass would wait for."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from slider_drilling.process.jit_cache import INLINED_JIT_OPTIONS, JIT_OPTIONS, njit

# No "arcp" here: with it the compiler takes a coarser estimate in packed code than in scalar code.
_ROOTS: dict[str, Any] = {**INLINED_JIT_OPTIONS, "fastmath": {"contract", "nsz"}}


@njit(**_ROOTS)
def root(x):
    """Square root in single precision (off by 1.2e-7 at most), for friction; x within float32's range.

    Double-precision roots and divisions, one after the other in the processor's only divider, would take most of a
    step. Friction is not known to a part in ten million.
    """
    return math.sqrt(np.float32(x))


@njit(**_ROOTS)
def per_root(x):
    """``1 / sqrt(x)`` in single precision (1.8e-7)."""
    return np.float32(1.0) / math.sqrt(np.float32(x))


@njit(**_ROOTS)
def reciprocal(x, real):
    """``1 / x`` in a precision (np.float64 or np.float32) by a Newton step from single precision, in double off by
    2e-14; zero where x is beyond float32's range.
    """
    seed = np.float32(1.0) / np.float32(x)
    return seed * (real(2.0) - x * seed)


@njit(**JIT_OPTIONS)
def exponential(x, real):
    """``exp(x)`` in a precision for x >= 0, held at 40, as the eighth power of a Taylor sum; its inverse is off by at
    most 5e-6.
    """
    one, half, third, quarter, fifth = real(1.0), real(0.5), real(1.0 / 3.0), real(0.25), real(0.2)
    y = min(real(0.125) * x, real(5.0))
    term = one + y * (one + y * half * (one + y * third * (one + y * quarter * (one + y * fifth))))
    square = term * term
    fourth = square * square
    return fourth * fourth
