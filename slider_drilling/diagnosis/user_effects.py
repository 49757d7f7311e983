"""Effects that a user brings along: a class, named on the command line or by the entry point group.

An installed package offers effects under ``slider_drilling.effects``; ``diagnose --effect module:Class`` takes one
that is not installed. See docs/how_to/user_effects.md for an example.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from importlib.metadata import entry_points
from typing import Any, Protocol

import numpy as np

from slider_drilling.drillstring import Commands, Modifiers
from slider_drilling.errors import InputError
from slider_drilling.gap.model import Array, Effect, Values
from slider_drilling.rig import Rig
from slider_drilling.schema.yaml_tree import shorten
from slider_drilling.user_code import call_user_code, import_reference
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
    found = []
    for point in entry_points(group=GROUP):
        where = f"effect of entry point {point.name} ({point.value})"
        found.append(_made(call_user_code(point.load, f"{where}: loading it"), where))
    return found


def load_effect(reference: str) -> UserEffect:
    """The effect ``module:Class`` from the working directory or the Python path. Raises InputError."""
    where = f"--effect {reference}"
    return _made(import_reference(reference, where, "clay:SwellingClay"), where)


def _made(kind: Any, where: str) -> UserEffect:
    made = call_user_code(lambda: kind(), f"{where}: {getattr(kind, '__name__', kind)}()")
    for name in ("effect", "commands", "modifiers", "channels"):
        if not call_user_code(lambda name=name: hasattr(made, name), f"{where}: {name}"):  # type: ignore[misc]
            raise InputError(f"{where}: has no `{name}`; see docs/how_to/user_effects.md")
    if not isinstance(made.effect, Effect):
        raise InputError(f"{where}: `effect` is {shorten(made.effect)}, not a slider_drilling.gap.Effect")
    named = [made.effect.name, made.effect.site, *(parameter.name for parameter in made.effect.parameters)]
    for name in named:
        if not isinstance(name, str):
            raise InputError(f"{where}: `effect` has {shorten(name)} for a name, which must be text")
    return GuardedEffect(made.effect, made, where)


@dataclass
class GuardedEffect:
    """A user's effect each answer of which is checked: what it raises, or hands back wrong, is an InputError.

    where: begins the error, such as ``--effect clay:Clay``.
    """

    effect: Effect
    made: UserEffect
    where: str

    def commands(self, commands: Commands, values: Values) -> Commands:
        """As `UserEffect.commands`. Raises InputError."""
        what = f"{self.where}: commands"
        given = call_user_code(lambda: self.made.commands(commands, values), what)
        if not isinstance(given, Commands):
            raise InputError(f"{what} returned {type(given).__name__}, not Commands")
        arrays = [_array(getattr(given, f.name), (commands.time.size,), f"{what}: {f.name}") for f in fields(Commands)]
        return Commands(*arrays)

    def modifiers(self, measured_depth: Array, values: Values) -> Modifiers:
        """As `UserEffect.modifiers`. Raises InputError."""
        what = f"{self.where}: modifiers"
        given = call_user_code(lambda: self.made.modifiers(measured_depth, values), what)
        if not isinstance(given, Modifiers):
            raise InputError(f"{what} returned {type(given).__name__}, not Modifiers")
        shape = (measured_depth.size,)
        arrays = [_array(getattr(given, f.name), shape, f"{what}: {f.name}", True) for f in fields(Modifiers)]
        if np.any(arrays[0] < 0.0):
            raise InputError(f"{what}: friction_factor = {arrays[0].min():g}: friction cannot be negative")
        return Modifiers(*arrays)

    def channels(
        self, times: Mapping[str, Array], channels: Mapping[str, Array], values: Values
    ) -> Mapping[str, Array]:
        """As `UserEffect.channels`. Raises InputError."""
        what = f"{self.where}: channels"
        given = call_user_code(lambda: self.made.channels(times, channels, values), what)
        if not isinstance(given, Mapping):
            raise InputError(f"{what} returned {type(given).__name__}, not channels by name")
        for name in given:
            if name not in channels:
                raise InputError(f"{what} returned {shorten(name)}; this log has {', '.join(channels)}")
        return {name: _array(row, channels[name].shape, f"{what}: {name}") for name, row in given.items()}


def guarded(effect: UserEffect) -> GuardedEffect:
    """The effect, its answers checked."""
    return effect if isinstance(effect, GuardedEffect) else GuardedEffect(effect.effect, effect, effect.effect.name)


def try_effects(users: Sequence[GuardedEffect], known: Sequence[str], rig: Rig, commands: Commands) -> None:
    """Ask every effect once for all that a diagnosis will, before minutes of fitting.

    known: names of effects and of parameters that there are already. Raises InputError for an effect that answers
    wrong, or one that has a name that is taken.
    """
    taken = set(known)
    depth = build_mesh(rig, 40).middle
    short = commands.resampled(commands.time[:: max(commands.time.size // 100, 1)])
    names = ("surface_torque", "hook_load", "standpipe_pressure", "tool_face")
    flat = {name: np.zeros_like(short.time) for name in names}
    for user in users:
        effect, where = user.effect, user.where
        for name in (effect.name, *(parameter.name for parameter in effect.parameters)):
            if name in taken:
                raise InputError(f"{where}: the name {name} is taken; give another")
            taken.add(name)
        nominal = tuple(parameter.nominal for parameter in effect.parameters)
        for point in (nominal, *effect.scan):
            values = effect.values(point)
            user.commands(short, values)
            user.modifiers(depth, values)
            user.channels(dict.fromkeys(names, short.time), dict(flat), values)


def _array(value: Any, shape: tuple[int, ...], what: str, may_be_one: bool = False) -> Array:
    """Finite numbers (n,), one number repeated where that is allowed. Raises InputError."""
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{what} is {shorten(value)}, not an array of numbers") from None
    if array.shape != shape and not (may_be_one and array.shape == ()):
        raise InputError(f"{what} has shape {array.shape}, must have {shape}")
    if not np.all(np.isfinite(array)):
        raise InputError(f"{what} holds {array[~np.isfinite(array)].flat[0]}; must be finite numbers")
    return np.broadcast_to(array, shape)


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
