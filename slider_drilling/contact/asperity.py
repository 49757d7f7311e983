"""Friction of one rigid asperity: the Challen-Oxley regimes and the effective attack angle.

Paper section 3.3.1, eq. 1-6. Three of them are misprinted; what is computed here is

    cutting     mu = tan(t - pi/4 + arccos(f)/2)                                              (1)
    ploughing   mu = (A1 sin t + cos(arccos f - t)) / (A1 cos t + sin(arccos f - t))           (2)
                A1 = 1 + pi/2 + arccos f - 2 t - 2 arcsin(sin t / sqrt(1 - f))                 (3)
    wedge       mu = (W sin t + f cos t) / (W cos t - f sin t),  W = 1 - 2 sin A2 + sqrt(1-f^2) (4)
                A2 = t - pi/4 - arccos(f)/2 + arcsin(sin t / sqrt(1 - f))                      (5)
    theta_eff   tan t = 2 h sqrt((a sin beta_v)^2 + (b cos beta_v)^2) / (chi a b)              (6)

with t the attack angle, f the shear factor and beta_v the angle between the slip and the asperity's
axis e3. A2 is minus the fan angle of the plastic wave, so the wave (ploughing) needs A2 <= 0; the
shear plane of a chip leaves at t - pi/2 + arccos(f)/2, so cutting needs that to be >= 0; between
the two the wave has become a wedge that is pushed along.
"""

from __future__ import annotations

import math
from enum import IntEnum

import numpy as np
from numpy.typing import ArrayLike, NDArray

from slider_drilling.errors import InputError
from slider_drilling.rig import Asperity, Contact

TABLE_SIZE = 257
"""Entries of a friction table: linear interpolation is then within 2e-7 for the paper's asperity."""


class WearMode(IntEnum):
    """How an asperity wears what it slides on; without a steady solution eq. 4 has no positive denominator."""

    PLOUGHING = 0
    WEDGE_FORMATION = 1
    CUTTING = 2
    NO_STEADY_SOLUTION = 3


PAPER = Contact(
    asperity=Asperity(height=5.09e-6, minor_axis=10.45e-6, major_axis=15.65e-6, shape_factor=math.pi),
    shear_factor=0.1,
    stiffness=42700.0,
    reference_load=1887.0,
)
"""The contact identified in the paper's section 4. It gives neither f nor chi: 0.1 and pi put mu between
0.23 and 0.34, the field's open-hole range (chi = 1 would give 0.70 to 1.09)."""


def wear_mode(shear_factor: ArrayLike, attack_angle: ArrayLike) -> NDArray[np.int8]:
    """Regime of the wear-mode diagram (paper Fig. 8), as WearMode values.

    shear_factor f (-) and attack_angle (rad) broadcast. Raises InputError unless 0 <= f < 1 and
    0 < angle < pi/2.
    """
    return _solve(shear_factor, attack_angle)[0]


def friction_coefficient(shear_factor: ArrayLike, attack_angle: ArrayLike) -> NDArray[np.float64]:
    """Friction coefficient of an asperity (eq. 1-5), shape of the broadcast arguments.

    shear_factor f: -; attack_angle: rad. Raises InputError outside 0 <= f < 1, 0 < angle < pi/2, and where
    there is no steady solution, naming the first such pair.
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


def effective_attack_angle(asperity: Asperity, beta_v: ArrayLike) -> NDArray[np.float64]:
    """Attack angle (rad) of an elliptical asperity to a slip at beta_v (rad) from its minor axis (eq. 6)."""
    cosine = np.cos(np.asarray(beta_v, dtype=float))
    return _attack_angle_of_cosine_squared(asperity, cosine * cosine)


def friction_coefficient_of_direction(contact: Contact, beta_v: ArrayLike) -> NDArray[np.float64]:
    """Friction coefficient for a slip at beta_v (rad) from the asperity's axis e3 (eq. 1-6).

    Raises InputError as `friction_coefficient` does, and for an asperity that is no ellipse.
    """
    return friction_coefficient(contact.shear_factor, effective_attack_angle(contact.asperity, beta_v))


def friction_table(shear_factor: float, asperity: Asperity, size: int = TABLE_SIZE) -> NDArray[np.float64]:
    """Friction coefficient against q = cos^2(beta_v), for loops that must not call a transcendental.

    Entry k is mu at q = k / (size - 1). In q the effective attack angle is arctan of the root of a straight
    line, which is smooth, so linear interpolation errs by at most max|mu''(q)| / (8 (size - 1)^2): measured
    1.6e-7 for the paper's asperity at the default size, 4 times less with each doubling. Raises InputError as
    `friction_coefficient_of_direction` does, and for fewer than two entries.
    """
    if size < 2:
        raise InputError(f"contact: friction table size = {size}: needs at least 2 entries")
    q = np.linspace(0.0, 1.0, size, dtype=np.float64)
    return friction_coefficient(shear_factor, _attack_angle_of_cosine_squared(asperity, q))


def _attack_angle_of_cosine_squared(asperity: Asperity, q: NDArray[np.float64]) -> NDArray[np.float64]:
    a, b = asperity.minor_axis, asperity.major_axis
    for name in ("height", "minor_axis", "major_axis", "shape_factor"):
        value = getattr(asperity, name)
        if not (math.isfinite(value) and value > 0.0):
            raise InputError(f"contact: asperity.{name} = {value}: must be a positive finite number")
    width = np.sqrt(a * a * (1.0 - q) + b * b * q)
    return np.arctan(2.0 * asperity.height * width / (asperity.shape_factor * a * b))


def _solve(shear_factor: ArrayLike, attack_angle: ArrayLike) -> tuple[NDArray[np.int8], NDArray[np.float64]]:
    f, t = np.broadcast_arrays(np.asarray(shear_factor, dtype=float), np.asarray(attack_angle, dtype=float))
    _require(f, (f >= 0.0) & (f < 1.0), "shear_factor", "must be in [0, 1)")
    _require(t, (t > 0.0) & (t < 0.5 * math.pi), "attack angle", "must be in (0, pi/2) rad")
    half = 0.5 * np.arccos(f)
    sine = np.sin(t) / np.sqrt(1.0 - f)
    arcsine = np.arcsin(np.minimum(sine, 1.0))
    a2 = t - 0.25 * math.pi - half + arcsine
    # At f = 0 ploughing ends where cutting begins; no rounding of A2 may open a sliver of wedge between.
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
