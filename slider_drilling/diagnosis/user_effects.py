"""Effects that a user brings along: a class, named on the command line or by the entry point group.

An installed package offers effects under ``slider_drilling.effects``; ``diagnose --effect module:Class`` takes one
that is not installed. See docs/user_effects.md for an example.
"""

from __future__ import annotations

import importlib
import os
import sys
from collections.abc import Mapping, Sequence
from importlib.metadata import entry_points
from typing import Protocol

import numpy as np

from slider_drilling.drillstring import Commands, Modifiers
from slider_drilling.errors import InputError
from slider_drilling.gap.model import Array, Effect, Values
from slider_drilling.rig import Rig
from slider_drilling.wellbore.mesh import build_mesh

GROUP = "slider_drilling.effects"


class UserEffect(Protocol):
    """What a user's effect offers. Each method may hand back what it was given.

    `effect` names it, its site, its parameters (the first is the amplitude; it is neutral at its nominal) and the
    points where a search begins.
    """

    effect: Effect

    def commands(self, commands: Commands, values: Values) -> Commands:
        """What the rig really did when the log says ``commands``."""

    def modifiers(self, measured_depth: Array, values: Values) -> Modifiers:
        """Friction factor (-), extra curvature (rad/m) and axial force (N) of elements at these middles (n,) m."""

    def channels(
        self, times: Mapping[str, Array], channels: Mapping[str, Array], values: Values
    ) -> Mapping[str, Array]:
        """What the sensors show at ``times`` of each channel when the plant does ``channels``."""


class UnchangedPlant:
    """The three methods of a `UserEffect` that change nothing, for classes that need only one of them."""

    def commands(self, commands: Commands, values: Values) -> Commands:
        """The log's commands."""
        return commands

    def modifiers(self, measured_depth: Array, values: Values) -> Modifiers:
        """A neutral string."""
        return Modifiers()

    def channels(
        self, times: Mapping[str, Array], channels: Mapping[str, Array], values: Values
    ) -> Mapping[str, Array]:
        """The plant's own channels."""
        return channels


def installed_effects() -> list[UserEffect]:
    """Every effect that an installed package offers. Raises InputError naming one that cannot be used."""
    return [_checked(point.load()(), f"entry point {point.name}") for point in entry_points(group=GROUP)]


def load_effect(reference: str) -> UserEffect:
    """The effect ``module:Class`` from the working directory or the Python path. Raises InputError."""
    module, colon, name = reference.partition(":")
    if not colon or not module or not name:
        raise InputError(f"--effect {reference}: write it as module:Class")
    if os.getcwd() not in sys.path:
        sys.path.insert(0, os.getcwd())
    try:
        made = getattr(importlib.import_module(module), name)()
    except (ImportError, AttributeError, TypeError, ValueError) as error:
        raise InputError(f"--effect {reference}: cannot be loaded: {error}") from None
    return _checked(made, f"--effect {reference}")


def _checked(made: object, where: str) -> UserEffect:
    for name in ("effect", "commands", "modifiers", "channels"):
        if not hasattr(made, name):
            raise InputError(f"{where}: has no `{name}`; see docs/user_effects.md")
    if not isinstance(made.effect, Effect):  # type: ignore[attr-defined]
        raise InputError(f"{where}: `effect` is {made.effect!r}, not a slider_drilling.gap.Effect")  # type: ignore[attr-defined]
    return made  # type: ignore[return-value]


def combined_modifiers(users: Sequence[UserEffect], rig: Rig, elements: int, values: Values) -> Modifiers:
    """What several effects add to the elements of this rig's mesh together."""
    middle = build_mesh(rig, elements).middle
    friction: Array = np.ones(middle.size)
    curvature: Array = np.zeros(middle.size)
    force: Array = np.zeros(middle.size)
    for user in users:
        own = user.modifiers(middle, values)
        friction = friction * own.friction_factor
        curvature = curvature + own.extra_curvature
        force = force + own.axial_force
    return Modifiers(friction, curvature, force)
