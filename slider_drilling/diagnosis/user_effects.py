"""Effects of users: a class, named on the command line or offered by an installed package.

A package offers effects under the entry point group ``slider_drilling.effects``; ``diagnose --effect module:Class``
takes one that is not installed. See docs/how_to/user_effects.md for an example.
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
    """What a user's effect must have. Each method may return its argument unchanged.

    Attributes:
        effect: Name, site, parameters (the first is the amplitude, neutral at its nominal value) and search starts.
    """

    effect: Effect

    def commands(self, commands: Commands, values: Values) -> Commands:
        """What the rig really did if the log says `commands`."""

    def modifiers(self, measured_depth: Array, values: Values) -> Modifiers:
        """Friction factor (-), extra curvature (rad/m) and axial force (N) of each element; measured_depth: (n,) m."""

    def channels(
        self, times: Mapping[str, Array], channels: Mapping[str, Array], values: Values
    ) -> Mapping[str, Array]:
        """What the sensors show if the plant's channels are `channels`; times: s, of each channel."""


class UnchangedPlant:
    """Base class: the three methods of a `UserEffect`, changing nothing. Override those that you need."""

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


def installed_effects() -> list[CheckedUserEffect]:
    """All effects of installed packages. Raises InputError for one that cannot be loaded."""
    effects = []
    for point in entry_points(group=GROUP):
        where = f"effect of entry point {point.name} ({point.value})"
        effects.append(_instance(call_user_code(point.load, f"{where}: loading it"), where))
    return effects


def load_effect(reference: str) -> CheckedUserEffect:
    """The effect ``module:Class`` from the working directory or the Python path. Raises InputError."""
    where = f"--effect {reference}"
    return _instance(import_reference(reference, where, "clay:SwellingClay"), where)


def _instance(user_class: Any, where: str) -> CheckedUserEffect:
    user = call_user_code(lambda: user_class(), f"{where}: {getattr(user_class, '__name__', user_class)}()")
    for name in ("effect", "commands", "modifiers", "channels"):
        if not call_user_code(lambda name=name: hasattr(user, name), f"{where}: {name}"):  # type: ignore[misc]
            raise InputError(f"{where}: has no `{name}`; see docs/how_to/user_effects.md")
    if not isinstance(user.effect, Effect):
        raise InputError(f"{where}: `effect` is {shorten(user.effect)}, not a slider_drilling.gap.Effect")
    names = [user.effect.name, user.effect.site, *(parameter.name for parameter in user.effect.parameters)]
    for name in names:
        if not isinstance(name, str):
            raise InputError(f"{where}: `effect` has {shorten(name)} for a name, which must be text")
    return CheckedUserEffect(user.effect, user, where)


@dataclass
class CheckedUserEffect:
    """A user's effect whose results are checked: an exception or a wrong result becomes an InputError.

    Attributes:
        effect: As `UserEffect.effect`.
        user_object: The user's own object.
        where: Start of the error message, such as ``--effect clay:Clay``.
    """

    effect: Effect
    user_object: UserEffect
    where: str

    def commands(self, commands: Commands, values: Values) -> Commands:
        """As `UserEffect.commands`. Raises InputError."""
        what = f"{self.where}: commands"
        result = call_user_code(lambda: self.user_object.commands(commands, values), what)
        if not isinstance(result, Commands):
            raise InputError(f"{what} returned {type(result).__name__}, not Commands")
        arrays = [_array(getattr(result, f.name), (commands.time.size,), f"{what}: {f.name}") for f in fields(Commands)]
        return Commands(*arrays)

    def modifiers(self, measured_depth: Array, values: Values) -> Modifiers:
        """As `UserEffect.modifiers`. Raises InputError."""
        what = f"{self.where}: modifiers"
        result = call_user_code(lambda: self.user_object.modifiers(measured_depth, values), what)
        if not isinstance(result, Modifiers):
            raise InputError(f"{what} returned {type(result).__name__}, not Modifiers")
        shape = (measured_depth.size,)
        arrays = [_array(getattr(result, f.name), shape, f"{what}: {f.name}", True) for f in fields(Modifiers)]
        if np.any(arrays[0] < 0.0):
            raise InputError(f"{what}: friction_factor = {arrays[0].min():g}: friction cannot be negative")
        return Modifiers(*arrays)

    def channels(
        self, times: Mapping[str, Array], channels: Mapping[str, Array], values: Values
    ) -> Mapping[str, Array]:
        """As `UserEffect.channels`. Raises InputError."""
        what = f"{self.where}: channels"
        result = call_user_code(lambda: self.user_object.channels(times, channels, values), what)
        if not isinstance(result, Mapping):
            raise InputError(f"{what} returned {type(result).__name__}, not a mapping of channels by name")
        for name in result:
            if name not in channels:
                raise InputError(f"{what} returned {shorten(name)}; this log has {', '.join(channels)}")
        return {name: _array(row, channels[name].shape, f"{what}: {name}") for name, row in result.items()}


def checked_effect(effect: UserEffect) -> CheckedUserEffect:
    """The effect with its results checked."""
    return (
        effect
        if isinstance(effect, CheckedUserEffect)
        else CheckedUserEffect(effect.effect, effect, effect.effect.name)
    )


def check_user_effects(users: Sequence[CheckedUserEffect], known: Sequence[str], rig: Rig, commands: Commands) -> None:
    """Call every method of every effect once, so that errors show before minutes of fitting.

    Args:
        users: The effects.
        known: Names of effects and parameters that are taken.
        rig: The rig file as given.
        commands: Of the first log.

    Raises:
        InputError: An effect returns something wrong, or a name is taken.
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
                raise InputError(f"{where}: the name {name} is already taken; choose another")
            taken.add(name)
        nominal = tuple(parameter.nominal for parameter in effect.parameters)
        for point in (nominal, *effect.scan):
            values = effect.values(point)
            user.commands(short, values)
            user.modifiers(depth, values)
            user.channels(dict.fromkeys(names, short.time), dict(flat), values)


def _array(value: Any, shape: tuple[int, ...], what: str, scalar_allowed: bool = False) -> Array:
    """Finite numbers of this shape; an allowed scalar is repeated. Raises InputError."""
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{what} is {shorten(value)}, not an array of numbers") from None
    if array.shape != shape and not (scalar_allowed and array.shape == ()):
        raise InputError(f"{what} has shape {array.shape}, must have {shape}")
    if not np.all(np.isfinite(array)):
        raise InputError(f"{what} holds {array[~np.isfinite(array)].flat[0]}; must be finite numbers")
    return np.broadcast_to(array, shape)


def combined_modifiers(users: Sequence[UserEffect], rig: Rig, elements: int, values: Values) -> Modifiers:
    """The modifiers of several effects together, on this rig's mesh."""
    middle = build_mesh(rig, elements).middle
    friction: Array = np.ones(middle.size)
    curvature: Array = np.zeros(middle.size)
    force: Array = np.zeros(middle.size)
    for user in users:
        modifiers = user.modifiers(middle, values)
        friction = friction * modifiers.friction_factor
        curvature = curvature + modifiers.extra_curvature
        force = force + modifiers.axial_force
    return Modifiers(friction, curvature, force)
