"""Downhole state of the fitted plant while it follows a log: friction, zones and weight transfer along the string."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from slider_drilling.analysis.cycles import RockingCycle
from slider_drilling.contact import friction_coefficient_of_direction
from slider_drilling.drillstring import Commands, DepthProfile, InitialState, Plant
from slider_drilling.drillstring.zones_from_motion import friction_torque, zones_from_motion
from slider_drilling.rig import Rig
from slider_drilling.wellbore.mesh import friction_factors
from slider_drilling.wellbore.zones import Zones, zones_in_closed_form

Array = NDArray[np.float64]

SNAPSHOT = 0.5
"""s between two samples of the string."""


@dataclass(frozen=True)
class StringHistory:
    """The string over time (n,) and measured depth (m,).

    Attributes:
        time: s.
        measured_depth: m.
        axial_friction: Of the whole string against the feed, N, (n,).
        coulomb_friction: The same if all of the string slid straight down, N, (n,).
        weight_on_bit, bit_torque: N and N m, (n,).
        rotation, torque: rad and N m, (n, m).
        friction_coefficient, beta_v: - and rad, (n, m).
        friction_torque: That turns each element at the end, N m, (m,).
        last: The string at the end.
    """

    time: Array
    measured_depth: Array
    axial_friction: Array
    coulomb_friction: Array
    weight_on_bit: Array
    bit_torque: Array
    rotation: Array
    torque: Array
    friction_coefficient: Array
    beta_v: Array
    friction_torque: Array
    last: DepthProfile

    @property
    def turning_torque(self) -> float:
        """Torque that turns the whole string against friction, N m."""
        return float(np.sum(self.friction_torque))

    @property
    def weight_transfer(self) -> Array:
        """Fraction (n,) of the weight let down that reaches the bit: WOB over WOB plus axial friction; else NaN."""
        friction = np.maximum(self.axial_friction, 0.0)
        total = self.weight_on_bit + friction
        return np.divide(self.weight_on_bit, total, out=np.full_like(total, np.nan), where=total > 100.0)


def without_rocking(commands: Commands) -> Commands:
    """The same block and pump with the top drive held where it started."""
    return replace(
        commands,
        top_drive_angle=np.full_like(commands.time, commands.top_drive_angle[0]),
        top_drive_speed=np.zeros_like(commands.time),
    )


def simulate_along_string(
    rig: Rig, start: InitialState, commands: Commands, elements: int, progress: Callable[[float], None] | None = None
) -> StringHistory:
    """Simulate a record and sample the string every half second.

    Args:
        rig, start, elements: As in `Plant`.
        commands: What drives the plant.
        progress: Called with the fraction that is done.
    """
    interval = 0.1
    count = int((commands.time[-1] - commands.time[0]) / interval) + 1
    grid = commands.time[0] + interval * np.arange(count)
    plant = Plant(rig, elements, interval, start)
    sampled = commands.resampled(grid)
    stride = round(SNAPSHOT / interval)
    rows: list[tuple] = []
    profiles: list[DepthProfile] = []
    for first in range(0, count, stride):
        response = plant.advance(sampled.samples(slice(first, min(first + stride, count))))
        profiles.append(plant.profile())
        rows.append((response.time[-1], response.weight_on_bit[-1], response.bit_torque[-1]))
        if progress is not None:
            progress(min(first + stride, count) / count)
    time, weight, torque = (np.array(column) for column in zip(*rows, strict=True))
    along = float(friction_coefficient_of_direction(rig.contact, rig.contact.asperity.orientation))
    factors = friction_factors(rig, plant.mesh)
    return StringHistory(
        time=time,
        measured_depth=profiles[0].measured_depth,
        axial_friction=np.array([-p.axial_friction.sum() for p in profiles]),
        coulomb_friction=np.array([along * float(np.sum(factors * p.normal_force * p.length)) for p in profiles]),
        weight_on_bit=weight,
        bit_torque=torque,
        rotation=np.array([p.rotation for p in profiles]),
        torque=np.array([p.torque for p in profiles]),
        friction_coefficient=np.array([p.friction_coefficient for p in profiles]),
        beta_v=np.array([p.beta_v for p in profiles]),
        friction_torque=friction_torque(plant, profiles[-1]),
        last=profiles[-1],
    )


def zones_over_time(history: StringHistory, cycles: list[RockingCycle]) -> list[tuple[float, Zones]]:
    """The three zones in every rocking cycle: (time of its middle s, zones).

    The reach of the rocking is seen in the motion. The reactive torque is taken in closed form, since the mean torque
    along the string also holds what the rocking's own centre puts into it.
    """
    zones = []
    for cycle in cycles:
        inside = (history.time >= cycle.start) & (history.time <= cycle.end)
        if np.count_nonzero(inside) < 4:
            continue
        reactive = float(np.mean(history.bit_torque[inside]))
        moving = zones_from_motion(history.measured_depth, history.rotation[inside], history.torque[inside], reactive)
        closed = zones_in_closed_form(history.last.length, history.friction_torque, 0.0, reactive)
        zones.append((0.5 * (cycle.start + cycle.end), Zones(moving.rocked_to, closed.reactive_from)))
    return zones
