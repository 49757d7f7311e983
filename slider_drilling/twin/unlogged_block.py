"""The block of a rig that does not send it: lowered so that the simulated bit carries what the pressure shows."""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from slider_drilling.drillstring import Commands
from slider_drilling.log_checks.expected_levels import OFF_BOTTOM_STIFFNESS
from slider_drilling.rig import Rig
from slider_drilling.twin.samples import Array, SampleBuffer

_TIME_S = 20.0  # in which a wrong weight on bit is made up for; weight on bit follows a block no faster
_MAX_SPEED = 0.05  # m/s


class BlockSource(enum.Enum):
    """What moves the block of the plants, and what is said where that is not the rig's own."""

    BLOCK = ""
    PRESSURE = "the block is not sent: it is taken to follow the pressure, which then shows no change"
    NOTHING = "neither block nor standpipe pressure are sent: the bit is taken to be off bottom"

    def remarks(self, began_late: bool) -> tuple[str, ...]:
        """What to say of it; began_late: whether something worse stood for it before."""
        late = f"the {self.name.lower()} comes only now: the twin learns the rig anew" if began_late else ""
        return tuple(filter(None, (self.value, late)))


def source_of_block(buffers: Mapping[str, SampleBuffer]) -> BlockSource:
    """The best that has been sent so far."""
    if len(buffers["block_position"]) or len(buffers["block_speed"]):
        return BlockSource.BLOCK
    return BlockSource.PRESSURE if len(buffers["standpipe_pressure"]) else BlockSource.NOTHING


def rig_moved_by(source: BlockSource, rig: Rig) -> Rig:
    """The rig that is simulated: with `NOTHING` one whose bit carries no weight."""
    if source is not BlockSource.NOTHING:
        return rig
    return replace(rig, bit=replace(rig.bit, depth_of_cut_stiffness=OFF_BOTTOM_STIFFNESS))


class BlockFromPressure:
    """Second by second: drilled depth under the weight that the pressure shows, and what is missing of that weight.

    See `slider_drilling.log_inputs.reconstruct_block` for a whole log.

    Args:
        rig: The rig file.
    """

    def __init__(self, rig: Rig) -> None:
        self._rig = rig
        self._position = 0.0

    def with_block(self, commands: Commands, pressure: Array, weight_on_bit: float) -> Commands:
        """The commands with a block.

        Args:
            commands: Of the last second, (n,).
            pressure: At the standpipe, Pa, (n,), NaN where it was not measured.
            weight_on_bit: Of the plant now, N.
        """
        rate = self._rate(float(np.mean(commands.pump_speed)), pressure, weight_on_bit)
        interval = float(commands.time[1] - commands.time[0])
        block: Array = self._position + rate * interval * np.arange(1.0, commands.time.size + 1.0)
        self._position = float(block[-1])
        return Commands(
            commands.time, commands.top_drive_angle, commands.top_drive_speed, block, np.full(block.shape, rate),
            commands.pump_speed,
        )  # fmt: skip

    def _rate(self, pump: float, pressure: Array, weight_on_bit: float) -> float:
        """m/s at which the block is lowered."""
        motor, rig = self._rig.motor, self._rig
        flow = pump * rig.mud_pump.displacement
        if flow <= 0.0 or not np.isfinite(pressure).any():
            return 0.0
        circulating = float(rig.circulation_at(pump))
        of_motor = float(np.clip(np.nanmean(pressure) - circulating, 0.0, motor.pressure_at_stall))
        weight = of_motor * motor.torque_per_pressure / rig.bit.lever
        turns = flow / motor.displacement * (1.0 - motor.leak_at(of_motor))
        drilled = weight * max(turns, 0.0) / rig.bit.depth_of_cut_stiffness
        missing = (weight - weight_on_bit) / rig.string.axial_stiffness
        return float(np.clip(drilled + missing / _TIME_S, -_MAX_SPEED, _MAX_SPEED))
