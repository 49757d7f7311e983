"""Torque and drag against the bit's depth, as a string goes into the hole: the planner's broomstick.

At each depth the string is what hangs there: its lower end, the bottom-hole assembly and as much pipe above it as the
depth takes. Loads are those of `static_loads`: picked up, slacked off and turned off bottom.
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
    """friction: the coefficient, None for that of the rig's contact; every array is (n,) at bit depths m.

    pick_up, slack_off, rotating: N of hook load; torque: N m to turn the string off bottom.
    """

    friction: float | None
    depth: Array
    pick_up: Array
    slack_off: Array
    rotating: Array
    torque: Array


def with_bit_at(rig: Rig, depth: float) -> Rig:
    """The rig while its bit is at this depth, m: pipe taken off at the top. Raises InputError outside the string."""
    if not 0.0 < depth <= rig.string.length + 1e-6:
        raise InputError(f"bit depth = {depth:g} m: must be above 0 and at most the string's {rig.string.length:g} m")
    left, sections = depth, []
    for section in reversed(rig.string.sections):
        if left <= 1e-9:
            break
        sections.append(dataclasses.replace(section, length=min(section.length, left)))
        left -= section.length
    return dataclasses.replace(rig, string=dataclasses.replace(rig.string, sections=tuple(sections[::-1])))


def broomstick(
    rig: Rig, friction: float | None = None, depths: Sequence[float] | None = None, elements: int = 200
) -> Broomstick:
    """Loads off bottom at every depth; by default 40 of them down to the string's length.

    friction: one coefficient for every slip, times the well's friction intervals; None takes the rig's contact's.
    Raises InputError for a depth outside the string and a friction below zero.
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
