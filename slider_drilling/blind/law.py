"""What a sealed plant does that its rig file does not say."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from slider_drilling.drillstring import Commands, Response
from slider_drilling.drillstring.kernel_arrays import Array
from slider_drilling.rig import Rig

# s, between two looks at a law that changes with time, and at one that changes with the pipe's angle.
SLOWLY, FAST = 8.0, 0.4


@dataclass(frozen=True)
class Moment:
    """When and where a law is asked: s since the start, top-drive angle rad, flow over the reference, s of the run."""

    time: float
    angle: float
    flow: float
    duration: float


@dataclass(frozen=True)
class Law:
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
    also: tuple[str, ...] = ()
    values: Callable[[Moment], dict[str, float]] = field(default=lambda at: {})
    every: float | None = None
    friction: Callable[[Array], Array] | None = None
    curvature: Callable[[Array], Array] | None = None
    rig: Callable[[Rig, Moment], Rig] = field(default=lambda rig, at: rig)
    commands: Callable[[Commands], Commands] = field(default=lambda commands: commands)
    sensors: Callable[[Response], Response] = field(default=lambda response: response)
    interval: tuple[float, float] | None = None


Make = Callable[[np.random.Generator, Rig, float], Law]
"""(generator, rig, size) -> law; size 1 is a usual amount of the effect."""


def no_effect(generator: np.random.Generator, rig: Rig, size: float) -> Law:
    """Only the nuisance is off."""
    return Law("none", None, True)


def both(first: Law, second: Law) -> Law:
    """Two laws at once: what the second does to sensors and commands comes after the first."""
    every = [law.every for law in (first, second) if law.every is not None]
    return replace(
        first,
        name=f"{first.name}+{second.name}",
        also=(),
        values=lambda at: {**first.values(at), **second.values(at)},
        every=min(every) if every else None,
        friction=_product(first.friction, second.friction),
        curvature=_sum(first.curvature, second.curvature),
        rig=lambda rig, at: second.rig(first.rig(rig, at), at),
        commands=lambda commands: second.commands(first.commands(commands)),
        sensors=lambda response: second.sensors(first.sensors(response)),
        interval=first.interval or second.interval,
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
