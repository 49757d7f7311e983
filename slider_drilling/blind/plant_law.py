"""What a sealed plant does that its rig file does not say."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from slider_drilling.drillstring import Commands, Response
from slider_drilling.drillstring.kernel_arrays import Array
from slider_drilling.rig import Rig

# s, between two looks at a law that changes with time, and at one that changes with the pipe's angle.
SLOW_UPDATE_S, FAST_UPDATE_S = 8.0, 0.4


@dataclass(frozen=True)
class OperatingPoint:
    """When and where a law is asked: s since the start, top-drive angle rad, flow over the reference, s of the run."""

    time: float
    angle: float
    flow: float
    duration: float


@dataclass(frozen=True)
class PlantLaw:
    """One effect in a sealed plant.

    name: of the catalogue's effect, ``none``, or of something outside it; site: where it acts; in_catalogue: whether
    the diagnosis could name it; also: sites that no log could tell from it. values(moment): effect and nuisance
    values then, asked every so many s (None: once); friction, curvature (elements' middles -> (n,)): profiles along
    the hole; rig: what is changed in the rig; commands: what the rig really did; sensors: what the surface reads;
    interval: measured depths m between which it acts.
    """

    name: str
    site: str | None
    in_catalogue: bool
    other_sites: tuple[str, ...] = ()
    values: Callable[[OperatingPoint], dict[str, float]] = field(default=lambda at: {})
    update_interval: float | None = None
    friction: Callable[[Array], Array] | None = None
    curvature: Callable[[Array], Array] | None = None
    change_rig: Callable[[Rig, OperatingPoint], Rig] = field(default=lambda rig, at: rig)
    change_commands: Callable[[Commands], Commands] = field(default=lambda commands: commands)
    change_response: Callable[[Response], Response] = field(default=lambda response: response)
    depth_interval: tuple[float, float] | None = None


LawFactory = Callable[[np.random.Generator, Rig, float], PlantLaw]
"""(generator, rig, size) -> law; size 1 is a usual amount of the effect."""


def no_effect(generator: np.random.Generator, rig: Rig, size: float) -> PlantLaw:
    """Only the nuisance is off."""
    return PlantLaw("none", None, True)


def combine(first: PlantLaw, second: PlantLaw) -> PlantLaw:
    """Two laws at once: what the second does to sensors and commands comes after the first."""
    every = [law.update_interval for law in (first, second) if law.update_interval is not None]
    return replace(
        first,
        name=f"{first.name}+{second.name}",
        other_sites=(),
        values=lambda at: {**first.values(at), **second.values(at)},
        update_interval=min(every) if every else None,
        friction=_product(first.friction, second.friction),
        curvature=_sum(first.curvature, second.curvature),
        change_rig=lambda rig, at: second.change_rig(first.change_rig(rig, at), at),
        change_commands=lambda commands: second.change_commands(first.change_commands(commands)),
        change_response=lambda response: second.change_response(first.change_response(response)),
        depth_interval=first.depth_interval or second.depth_interval,
    )


Profile = Callable[[Array], Array]


def _product(first: Profile | None, second: Profile | None) -> Profile | None:
    if first is None or second is None:
        return first or second
    return lambda depth: first(depth) * second(depth)


def _sum(first: Profile | None, second: Profile | None) -> Profile | None:
    if first is None or second is None:
        return first or second
    return lambda depth: first(depth) + second(depth)
