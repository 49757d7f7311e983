"""What a sealed plant does that its rig file does not state."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from slider_drilling.drillstring import Commands, Response
from slider_drilling.drillstring.kernel_arrays import Array
from slider_drilling.rig import Rig

SLOW_UPDATE_S = 8.0
"""Interval between two evaluations of a law that changes with time."""
FAST_UPDATE_S = 0.4
"""Interval between two evaluations of a law that changes with the pipe's angle."""


@dataclass(frozen=True)
class OperatingPoint:
    """Where in the run a law is evaluated.

    Attributes:
        time: Since the start of the run, s.
        angle: Of the top drive, rad.
        flow: Relative to the reference flow.
        duration: Of the run, s.
    """

    time: float
    angle: float
    flow: float
    duration: float


Profile = Callable[[Array], Array]
"""Measured depths of the elements' middles, (n,) in m -> values there, (n,)."""


@dataclass(frozen=True)
class PlantLaw:
    """One law of a sealed plant, as changes to the plant that the rig file states.

    Attributes:
        name: Effect of the catalogue, a law outside it, or ``none``.
        site: Where it acts; None for ``none``.
        in_catalogue: Whether a diagnosis could name it.
        other_sites: Sites that no log can distinguish from `site`.
        values: Returns values of effects and nuisance parameters at an operating point.
        update_interval: Interval in s between two evaluations; None for a law that is constant.
        friction: Factor on friction along the hole.
        curvature: Curvature in rad/m that is added along the hole.
        change_rig: Changes the rig at an operating point.
        change_commands: Returns what the rig really did, given what the log states.
        change_response: Returns what the sensors read, given the true response.
        depth_interval: Measured depths in m between which friction differs.
    """

    name: str
    site: str | None
    in_catalogue: bool
    other_sites: tuple[str, ...] = ()
    values: Callable[[OperatingPoint], dict[str, float]] = field(default=lambda at: {})
    update_interval: float | None = None
    friction: Profile | None = None
    curvature: Profile | None = None
    change_rig: Callable[[Rig, OperatingPoint], Rig] = field(default=lambda rig, at: rig)
    change_commands: Callable[[Commands], Commands] = field(default=lambda commands: commands)
    change_response: Callable[[Response], Response] = field(default=lambda response: response)
    depth_interval: tuple[float, float] | None = None


LawFactory = Callable[[np.random.Generator, Rig, float], PlantLaw]
"""(generator, rig, size) -> law. Size 1 is a usual amount of the effect."""


def no_effect(generator: np.random.Generator, rig: Rig, size: float) -> PlantLaw:
    """Returns the law of a plant that differs from its rig file in nuisance parameters only."""
    return PlantLaw("none", None, True)


def combine(first: PlantLaw, second: PlantLaw) -> PlantLaw:
    """Returns a law that does what two laws do; commands and response go through the first one first."""
    intervals = [law.update_interval for law in (first, second) if law.update_interval is not None]
    return replace(
        first,
        name=f"{first.name}+{second.name}",
        other_sites=(),
        values=lambda at: {**first.values(at), **second.values(at)},
        update_interval=min(intervals, default=None),
        friction=_combine_profiles(first.friction, second.friction, np.multiply),
        curvature=_combine_profiles(first.curvature, second.curvature, np.add),
        change_rig=lambda rig, at: second.change_rig(first.change_rig(rig, at), at),
        change_commands=lambda commands: second.change_commands(first.change_commands(commands)),
        change_response=lambda response: second.change_response(first.change_response(response)),
        depth_interval=first.depth_interval or second.depth_interval,
    )


def _combine_profiles(first: Profile | None, second: Profile | None, operation: np.ufunc) -> Profile | None:
    if first is None or second is None:
        return first or second
    return lambda depth: operation(first(depth), second(depth))
