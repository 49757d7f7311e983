"""Torque and drag over bit depth while a string goes into the hole: the planner's broomstick plot.

At each depth the string in the hole is its lower end: the bottom-hole assembly and as much pipe above it as the depth
needs. Loads are those of `static_loads`: picking up, slacking off and rotating off bottom.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from slider_drilling.errors import InputError
from slider_drilling.rig import Rig
from slider_drilling.wellbore.mesh import build_mesh
from slider_drilling.wellbore.static_loads import static_loads
from slider_drilling.wellbore.well_path import Array


@dataclass(frozen=True)
class Broomstick:
    """Loads over bit depth, each array (n,).

    Attributes:
        friction: Friction coefficient; None for that of the rig's contact.
        depth: Of the bit, m.
        pick_up, slack_off, rotating: Hook load, N.
        torque: To rotate the string off bottom, N m.
        calibrated: Whether the friction is that of the driller's weights.
    """

    friction: float | None
    depth: Array
    pick_up: Array
    slack_off: Array
    rotating: Array
    torque: Array
    calibrated: bool = False

    @property
    def label(self) -> str:
        """``calibrated``, ``contact`` or the coefficient."""
        if self.calibrated:
            return "calibrated"
        return "contact" if self.friction is None else f"{self.friction:g}"


def with_bit_at(rig: Rig, depth: float) -> Rig:
    """The rig with its bit at this depth (m): pipe is removed at the top. Raises InputError outside the string."""
    if not 0.0 < depth <= rig.string.length + 1e-6:
        raise InputError(f"bit depth = {depth:g} m: must be above 0 and at most the string's {rig.string.length:g} m")
    missing, sections = depth, []
    for section in reversed(rig.string.sections):
        if missing <= 1e-9:
            break
        sections.append(dataclasses.replace(section, length=min(section.length, missing)))
        missing -= section.length
    return dataclasses.replace(rig, string=dataclasses.replace(rig.string, sections=tuple(sections[::-1])))


def broomstick(
    rig: Rig, friction: float | None = None, depths: Sequence[float] | None = None, elements: int = 200
) -> Broomstick:
    """Loads off bottom at every depth.

    Args:
        friction: One coefficient for every slip, times the well's friction intervals; None for the rig's contact.
        depths: Of the bit, m, (n,); None for 40 of them down to the string's length.
        elements: Of the string at each depth.

    Raises:
        InputError: For a depth outside the string and a friction below zero.
    """
    length = rig.string.length
    at = np.linspace(length / 40.0, length, 40) if depths is None else np.asarray(depths, dtype=float)
    rows = []
    for depth in at:
        here = with_bit_at(rig, float(depth))
        mesh = build_mesh(here, elements)
        up, down, turned = (
            static_loads(here, axial, turn, friction_coefficient=friction, mesh=mesh)
            for axial, turn in ((-1.0, 0.0), (1.0, 0.0), (0.0, 1.0))
        )
        rows.append((up.hook_load, down.hook_load, turned.hook_load, turned.surface_torque))
    return Broomstick(friction, at, *np.array(rows).reshape(-1, 4).T)
