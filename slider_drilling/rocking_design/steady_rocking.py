"""Steady rocking of the plant while it drills: what a rocked slide settles to."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from slider_drilling.control.rocking import Rocking
from slider_drilling.drillstring import Commands, InitialState, Plant
from slider_drilling.drillstring.zones_from_motion import zones_from_motion
from slider_drilling.rig import Rig
from slider_drilling.rocking_design.block_feed import BlockFeed
from slider_drilling.rocking_design.closed_forms import BitLoad, critical_compression
from slider_drilling.wellbore.well_path import Array

_INTERVAL = 0.1  # s
_SNAPSHOTS = 40  # of the string in a period
_SETTLE_PERIODS, _SETTLE_TIME = 6, 200.0  # whichever takes longer, s
_MEASURED_PERIODS = 3
_CENTRE_PERIODS = 3.0


@dataclass(frozen=True)
class SteadyRocking:
    """What the last periods show.

    Attributes:
        bit_swing: Of the toolface, peak to peak, rad.
        rocked_to: Measured depth down to which rocking turns the string, m.
        torque_right, torque_left: At the turning points, positive clockwise, N m.
        hook_load: Mean, of the string alone, N.
        weight_on_bit: Mean, N.
        bit_torque: Mean, N m.
        buckling: Largest compression over that which buckles, and where, m.
    """

    bit_swing: float
    rocked_to: float
    torque_right: float
    torque_left: float
    hook_load: float
    weight_on_bit: float
    bit_torque: float
    buckling: float
    buckling_depth: float


@dataclass(frozen=True)
class RockedString:
    """Samples of a run: channels (n,) and, at its snapshots, the string (m, elements)."""

    time: Array
    surface_torque: Array
    hook_load: Array
    weight_on_bit: Array
    bit_torque: Array
    snapshot_time: Array
    rotation: Array
    torque: Array
    tension: Array
    side_force: Array


def steady_rocking(
    rig: Rig, drive: Rocking, load: BitLoad, elements: int, thorough: bool = False
) -> SteadyRocking:
    """Rock the plant, with the block fed so that the weight on bit stays, until it is steady.

    Args:
        rig: With its bit at the depth.
        drive: Trajectory of the top drive about its centre.
        load: Of the bit.
        elements: Of the string.
        thorough: Three times as long: pipe that is not freed may stick and slip along the hole over minutes.
    """
    start = InitialState(weight_on_bit=load.weight_on_bit, surface_torque=load.torque)
    plant = Plant(rig, elements, _INTERVAL, start)
    longer = 3 if thorough else 1
    settle = longer * max(_SETTLE_PERIODS * drive.period, _SETTLE_TIME)
    run = rock(plant, drive, load, settle, longer * _MEASURED_PERIODS * drive.period, 0.0,
               lambda _, weight_on_bit: load.weight_on_bit - weight_on_bit)  # fmt: skip
    return measure(run, plant, drive, load)


def rock(
    plant: Plant, drive: Rocking, load: BitLoad, settle: float, duration: float, centre: float,
    error: Callable[[float, float], float],
) -> RockedString:  # fmt: skip
    """Rock a plant and keep the samples after it has settled.

    Args:
        plant: At its start.
        drive: Trajectory of the top drive about its centre.
        load: Of the bit, for the first feed.
        settle, duration: s before and during the samples that are kept.
        centre: Reached over the first periods, rad.
        error: Force for `BlockFeed.update`, from hook load and weight on bit (N).
    """
    feed, block = BlockFeed(plant.rig, load.rate_of_penetration), 0.0
    stride = max(round(drive.period / _SNAPSHOTS / _INTERVAL), 1)
    pump = plant.rig.reference_pump_speed
    channels, snapshots = [], []
    for first in range(0, round((settle + duration) / _INTERVAL), stride):
        time = _INTERVAL * np.arange(first, first + stride, dtype=np.float64)
        angle, speed = np.array([drive.from_rest(t) for t in time]).T
        share = np.clip(time / (_CENTRE_PERIODS * drive.period), 0.0, 1.0)
        ahead = block + feed.speed * _INTERVAL * np.arange(1, stride + 1, dtype=np.float64)
        response = plant.advance(Commands(
            time, angle + centre * share**2 * (3.0 - 2.0 * share), speed, ahead, np.full(stride, feed.speed),
            np.full(stride, pump),
        ))  # fmt: skip
        block = float(ahead[-1])
        feed.update(error(float(response.hook_load.mean()), float(response.weight_on_bit.mean())), stride * _INTERVAL)
        if time[0] >= settle:
            profile = plant.profile()
            channels.append(np.stack([time, response.surface_torque, response.hook_load, response.weight_on_bit,
                                      response.bit_torque]))  # fmt: skip
            snapshots.append((time[-1], profile))
    times, surface_torque, hook_load, weight_on_bit, bit_torque = np.concatenate(channels, axis=1)
    return RockedString(
        time=times, surface_torque=surface_torque, hook_load=hook_load, weight_on_bit=weight_on_bit,
        bit_torque=bit_torque, snapshot_time=np.array([at for at, _ in snapshots]),
        rotation=np.array([profile.rotation for _, profile in snapshots]),
        torque=np.array([profile.torque for _, profile in snapshots]),
        tension=np.array([profile.tension for _, profile in snapshots]),
        side_force=np.array([profile.normal_force for _, profile in snapshots]),
    )  # fmt: skip


def measure(run: RockedString, plant: Plant, drive: Rocking, load: BitLoad) -> SteadyRocking:
    """What a steady run shows; swings and zones are means over its periods."""
    swings, reaches = [], []
    ends = np.arange(run.snapshot_time[-1], run.snapshot_time[0] + 0.9 * drive.period, -drive.period)
    for end in ends:
        inside = (run.snapshot_time > end - drive.period - 1e-9) & (run.snapshot_time <= end + 1e-9)
        zones = zones_from_motion(plant.mesh.middle, run.rotation[inside], run.torque[inside], load.torque)
        swings.append(float(np.ptp(run.rotation[inside][:, -1])))
        reaches.append(zones.rocked_to)
    critical = critical_compression(plant.rig, plant.mesh, run.side_force.mean(axis=0))
    share = np.maximum(-run.tension.mean(axis=0), 0.0) / critical
    worst = int(np.argmax(share))
    per_period = round(drive.period / _INTERVAL)
    return SteadyRocking(
        bit_swing=float(np.mean(swings)),
        rocked_to=float(np.mean(reaches)),
        torque_right=_mean_extreme(run.surface_torque, per_period, 1.0),
        torque_left=_mean_extreme(run.surface_torque, per_period, -1.0),
        hook_load=float(run.hook_load.mean()),
        weight_on_bit=float(run.weight_on_bit.mean()),
        bit_torque=float(run.bit_torque.mean()),
        buckling=float(share[worst]),
        buckling_depth=float(plant.mesh.middle[worst]),
    )


def _mean_extreme(torque: Array, per_period: int, sign: float) -> float:
    """Mean over the periods of the largest (sign 1) or smallest (-1) torque."""
    ends = range(len(torque), per_period - 1, -per_period)
    return float(np.mean([sign * np.max(sign * torque[end - per_period : end]) for end in ends]))
