"""Wear regimes and friction of one rigid asperity: the slip-line fields of Challen and Oxley.

Paper section 3.3.1, eq. 1-5. Three of its equations are misprinted; those computed here are

    cutting     mu = tan(t - pi/4 + arccos(f)/2)                                              (1)
    ploughing   mu = (A1 sin t + cos(arccos f - t)) / (A1 cos t + sin(arccos f - t))           (2)
                A1 = 1 + pi/2 + arccos f - 2 t - 2 arcsin(sin t / sqrt(1 - f))                 (3)
    wedge       mu = (W sin t + f cos t) / (W cos t - f sin t),  W = 1 - 2 sin A2 + sqrt(1-f^2) (4)
                A2 = t - pi/4 - arccos(f)/2 + arcsin(sin t / sqrt(1 - f))                      (5)

with t the attack angle and f the shear factor. Where each regime exists (`model.md` section 1):

* ploughing: A2 is minus the fan angle of the plastic wave, so A2 <= 0;
* cutting: the chip's shear plane leaves at t - pi/2 + arccos(f)/2, so that angle is >= 0;
* wedge formation: between the two the wave has become a wedge that the asperity pushes along.
"""

from __future__ import annotations

import math
from enum import IntEnum

import numpy as np
from numpy.typing import ArrayLike, NDArray

from slider_drilling.errors import InputError


class WearMode(IntEnum):
    """How an asperity wears the surface it slides on. NO_STEADY_SOLUTION: eq. 4 has no positive denominator."""

    PLOUGHING = 0
    WEDGE_FORMATION = 1
    CUTTING = 2
    NO_STEADY_SOLUTION = 3


def wear_mode(shear_factor: ArrayLike, attack_angle: ArrayLike) -> NDArray[np.int8]:
    """Wear regime as `WearMode` values (paper Fig. 8).

    Args:
        shear_factor: f, in [0, 1).
        attack_angle: rad, in (0, pi/2); broadcasts with ``shear_factor``.

    Raises:
        InputError: Outside these ranges.
    """
    return _solve(shear_factor, attack_angle)[0]


def friction_coefficient(shear_factor: ArrayLike, attack_angle: ArrayLike) -> NDArray[np.float64]:
    """Friction coefficient of an asperity (eq. 1-5).

    Args:
        shear_factor: f, in [0, 1).
        attack_angle: rad, in (0, pi/2); broadcasts with ``shear_factor``.

    Returns:
        Shape of the broadcast arguments.

    Raises:
        InputError: Outside these ranges, and where there is no steady solution, naming the first such pair.
    """
    mode, friction = _solve(shear_factor, attack_angle)
    stuck = np.flatnonzero(mode == WearMode.NO_STEADY_SOLUTION)
    if stuck.size:
        shear, angle = np.broadcast_arrays(shear_factor, attack_angle)
        raise InputError(
            f"contact: shear_factor = {shear.flat[stuck[0]]:.6g} with attack angle = "
            f"{angle.flat[stuck[0]]:.6g} rad: no steady wedge exists there (eq. 4 has no positive denominator); "
            "lower one of the two"
        )
    return friction


def _solve(shear_factor: ArrayLike, attack_angle: ArrayLike) -> tuple[NDArray[np.int8], NDArray[np.float64]]:
    f, t = np.broadcast_arrays(np.asarray(shear_factor, dtype=float), np.asarray(attack_angle, dtype=float))
    _require(f, (f >= 0.0) & (f < 1.0), "shear_factor", "must be in [0, 1)")
    _require(t, (t > 0.0) & (t < 0.5 * math.pi), "attack angle", "must be in (0, pi/2) rad")
    half = 0.5 * np.arccos(f)
    sine = np.sin(t) / np.sqrt(1.0 - f)
    arcsine = np.arcsin(np.minimum(sine, 1.0))
    a2 = t - 0.25 * math.pi - half + arcsine
    # At f = 0 ploughing ends where cutting begins; testing cutting first keeps rounding from putting wedge between.
    cuts = t - 0.5 * math.pi + half >= 0.0
    ploughs = (sine <= 1.0) & (a2 <= 0.0)

    a1 = 1.0 - 2.0 * a2
    ploughing = (a1 * np.sin(t) + np.cos(2 * half - t)) / (a1 * np.cos(t) + np.sin(2 * half - t))
    wedge = 1.0 - 2.0 * np.sin(a2) + np.sqrt(1.0 - f * f)
    denominator = wedge * np.cos(t) - f * np.sin(t)
    stuck = ~cuts & ~ploughs & (denominator <= 0.0)
    wedging = (wedge * np.sin(t) + f * np.cos(t)) / np.where(denominator > 0.0, denominator, 1.0)
    cutting = np.tan(np.where(cuts, t - 0.25 * math.pi + half, 0.0))

    which = [cuts, ploughs, stuck]
    modes = [WearMode.CUTTING, WearMode.PLOUGHING, WearMode.NO_STEADY_SOLUTION]
    mode = np.select(which, modes, WearMode.WEDGE_FORMATION)
    friction = np.select(which, [cutting, ploughing, np.full_like(t, math.nan)], wedging)
    return mode.astype(np.int8), friction


def _require(value: NDArray[np.float64], valid: NDArray[np.bool_], name: str, rule: str) -> None:
    if not valid.all():
        raise InputError(f"contact: {name} = {value[~valid].flat[0]:.6g}: {rule}")
