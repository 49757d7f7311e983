"""Friction of one rigid, elliptical asperity that slips in any direction.

The direction sets the effective attack angle (paper section 3.3.1, eq. 6 as corrected),

    theta_eff   tan t = 2 h sqrt((a sin beta_v)^2 + (b cos beta_v)^2) / (chi a b)

with beta_v the angle between the slip and the asperity's axis e3; the angle sets the wear regime of
`asperity_friction`.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from slider_drilling.asperity_friction import friction_coefficient
from slider_drilling.errors import InputError
from slider_drilling.rig import Asperity, Contact

TABLE_SIZE = 257
"""Entries of a friction table; linear interpolation is then accurate to 2e-7 for the paper's asperity."""

PAPER = Contact(
    asperity=Asperity(height=5.09e-6, minor_axis=10.45e-6, major_axis=15.65e-6, shape_factor=math.pi),
    shear_factor=0.1,
    stiffness=42700.0,
    reference_load=1887.0,
)
"""The contact that the paper identifies in its section 4.

The paper gives neither f nor chi. With f = 0.1 and chi = pi the friction coefficient is 0.23 to 0.34, the range of open
holes in the field; chi = 1 would give 0.70 to 1.09.
"""


def effective_attack_angle(asperity: Asperity, beta_v: ArrayLike) -> NDArray[np.float64]:
    """Attack angle (rad) of an elliptical asperity to a slip at beta_v (rad) from its minor axis (eq. 6)."""
    cosine = np.cos(np.asarray(beta_v, dtype=float))
    return _attack_angle_of_cosine_squared(asperity, cosine * cosine)


def friction_coefficient_of_direction(contact: Contact, beta_v: ArrayLike) -> NDArray[np.float64]:
    """Friction coefficient for a slip at beta_v (rad) from the asperity's axis e3 (eq. 1-6).

    Raises InputError as `friction_coefficient` does, and for an asperity whose axes are not positive.
    """
    return friction_coefficient(contact.shear_factor, effective_attack_angle(contact.asperity, beta_v))


def friction_table(shear_factor: float, asperity: Asperity, size: int = TABLE_SIZE) -> NDArray[np.float64]:
    """Friction coefficient over q = cos^2(beta_v), for loops that must not call a transcendental function.

    In q the tangent of the effective attack angle is the root of a straight line, so friction is smooth and linear
    interpolation errs by at most max|mu''(q)| / (8 (size - 1)^2): 1.6e-7 for the paper's asperity at the default
    size, 4 times less with each doubling.

    Args:
        shear_factor: f.
        asperity: The asperity.
        size: Entries of the table.

    Returns:
        (size,), entry k at q = k / (size - 1).

    Raises:
        InputError: As `friction_coefficient_of_direction` does, and for fewer than two entries.
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
