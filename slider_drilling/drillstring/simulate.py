"""The plant: step it, save and restore it, or simulate a whole record of commands, one run or a batch."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from slider_drilling.drillstring import assemble
from slider_drilling.drillstring.assemble import Modifiers
from slider_drilling.drillstring.depth_profile import DepthProfile
from slider_drilling.drillstring.initial_state import InitialState
from slider_drilling.drillstring.kernel_arrays import CHANNELS, Array
from slider_drilling.drillstring.lane_block import LaneBlock, PlantState, min_substeps
from slider_drilling.drillstring.observer import Observer
from slider_drilling.drillstring.recorded_channels import Commands, Response
from slider_drilling.process.parallel_map import idle_threads, parallel_map
from slider_drilling.rig import Rig

ELEMENTS = 200
"""Default number of elements: with more, surface torque of the example rig changes by less than 1 % RMS."""
_MORE_STEPS = 1.25  # times the steps of the easiest run of a batch, from which on a run is stepped apart
_LANES_PER_BLOCK = 16  # runs side by side whose arrays of 200 elements just fit a core's second-level cache


class Plant:
    """One drill string in its well, stepped at a fixed interval.

    Args:
        rig: The rig.
        elements: Number of elements of the string.
        interval: s between two samples of the commands; None for that of the rig's sensors.
        start: State in which the run begins.
        modifiers: What a user's own effect adds.
        substeps: Time steps per interval; None for the fewest that are stable.
    """

    def __init__(
        self,
        rig: Rig,
        elements: int = ELEMENTS,
        interval: float | None = None,
        start: InitialState = InitialState(),
        modifiers: Modifiers = Modifiers(),
        substeps: int | None = None,
    ) -> None:
        self.rig = rig
        interval = interval or 1.0 / rig.sensors.rate
        mesh = assemble.common_mesh([rig], elements)
        substeps = substeps or min_substeps([rig], mesh, interval)
        self._lanes = LaneBlock([rig], mesh, interval, [start], [modifiers], substeps)

    @property
    def interval(self) -> float:
        """Seconds between two samples of the commands."""
        return self._lanes.interval

    @property
    def step(self) -> float:
        """The kernel's own time step, s."""
        return self._lanes.dt

    @property
    def mesh(self) -> assemble.Mesh:
        return self._lanes.mesh

    @property
    def time(self) -> float:
        """Seconds simulated since the start."""
        return float(self._lanes.state.clock[0]) if self._lanes.state else 0.0

    def advance(self, commands: Commands) -> Response:
        """Follow commands that are sampled every ``interval``, and return the response at their times.

        The first call starts the string at its first sample. Later calls continue from one interval before their first
        sample. Raises ValueError for samples that are not one interval apart.
        """
        channels = self._lanes.advance(commands)
        return Response(commands.time, *(channels[:, row, 0] for row in range(len(CHANNELS))))

    def scale_friction(self, factor: Array) -> None:
        """Multiply each element's friction, as rig file and modifiers give it, by `factor` (n,) from now on."""
        self._lanes.scale_friction(factor)

    def save(self) -> PlantState:
        """A copy of the state. Raises ValueError before the first `advance`."""
        return self._lanes.save()

    def restore(self, state: PlantState) -> None:
        """Go back to a saved state; the next `advance` continues from there bit for bit."""
        self._lanes.restore(state)

    def profile(self) -> DepthProfile:
        """The string along its length. Raises ValueError before the first `advance`."""
        return self._lanes.profile()


def simulate(
    rig: Rig,
    commands: Commands,
    elements: int = ELEMENTS,
    start: InitialState = InitialState(),
    modifiers: Modifiers = Modifiers(),
    substeps: int | None = None,
) -> Response:
    """Simulate a whole record of commands.

    Unevenly spaced samples are allowed: the plant then runs on an even grid of their median spacing, and its response
    is interpolated back.

    Args:
        rig: The rig.
        commands: What drives it.
        elements, start, modifiers, substeps: As in `Plant`.

    Returns:
        The response at the commands' times.
    """
    return simulate_batch([rig], commands, elements, [start], [modifiers], substeps)[0]


def simulate_batch(
    rigs: Sequence[Rig],
    commands: Commands,
    elements: int = ELEMENTS,
    starts: Sequence[InitialState] | None = None,
    modifiers: Sequence[Modifiers] | None = None,
    substeps: int | None = None,
    workers: int | None = 1,
    observer: Observer | None = None,
    friction_factor: Array | None = None,
    acceleration: Array | None = None,
    bit_torque_factor: Array | None = None,
    block_offset: Array | None = None,
    single_precision: bool = False,
    switch: Switch | None = None,
) -> list[Response]:
    """`simulate` for many parameter sets of one well and string, vectorised across them.

    Args:
        rigs: The rigs, K of them.
        commands: What drives all of them, n samples.
        elements, substeps: As in `Plant`.
        starts, modifiers: As in `Plant`, one a rig.
        workers: Threads that share the runs; None for all that are idle. Their number changes no bit of the result.
        observer: Feedback of measured torque to the top drive.
        friction_factor: Multiplies all friction at the commands' times, (n,), joined linearly.
        acceleration: Of the top drive, rad/s2, (n,), for torque that is read at its motor. By default the slope of
            the commands' speed, which is mostly noise where the speed was measured (see `drive_acceleration`).
        bit_torque_factor: Multiplies the bit's torque per weight, (n,), joined linearly.
        block_offset: m that each run's block is lower than the commands say, (K, n), joined linearly.
        single_precision: Compute in single precision except for positions and rotations, in half the time. Where no
            run is chaotic, torque differs by tenths of a N m and hook load by some N.
        switch: When the rigs become others, and which.

    Returns:
        One response a rig, at the commands' times.

    Raises:
        InputError: Where the rigs differ in survey, sections, contact or sound speed.
    """
    if not rigs:
        return []
    grid = _even_grid(commands.time)
    sampled = commands if grid is commands.time else commands.resampled(grid)
    interval = float((grid[-1] - grid[0]) / (len(grid) - 1)) if len(grid) > 1 else 1.0
    starts = starts or [InitialState()] * len(rigs)
    modifiers = modifiers or [Modifiers()] * len(rigs)
    given = (friction_factor, acceleration, bit_torque_factor)
    friction_factor, acceleration, bit_torque_factor = (
        None if values is None else np.interp(grid, commands.time, values) for values in given
    )
    offset = (
        None
        if block_offset is None
        else np.stack([np.interp(grid, commands.time, row) for row in block_offset], axis=1)
    )
    measured = None if observer is None else observer.measured_at(grid)
    mesh = assemble.common_mesh(rigs, elements)
    becomes = rigs if switch is None else switch.rigs
    needed = [substeps or min_substeps(both, mesh, interval) for both in zip(rigs, becomes, strict=True)]
    # Samples before the switch.
    first = len(grid) if switch is None else int(np.clip(np.searchsorted(grid, switch.time), 1, len(grid)))
    threads = 1 + idle_threads() if workers is None else max(workers, 1)
    width = min(math.ceil(len(rigs) / threads), _LANES_PER_BLOCK)

    def run(block: _Block) -> Array:
        lane_block = LaneBlock(
            [rigs[lane] for lane in block.lanes], mesh, interval, [starts[lane] for lane in block.lanes],
            [modifiers[lane] for lane in block.lanes], block.substeps, observer, single_precision,
        )  # fmt: skip
        own_offset = None if offset is None else offset[:, block.lanes]
        series = (measured, friction_factor, acceleration, bit_torque_factor, own_offset)
        parts = []
        for part in (slice(0, first), slice(first, len(grid))):
            if part.start == part.stop:
                break
            if part.start:
                lane_block = lane_block.with_rigs([becomes[lane] for lane in block.lanes])
            own = (None if values is None else values[part] for values in series)
            parts.append(lane_block.advance(sampled.samples(part), *own))
        return _interpolate(commands.time, grid, np.concatenate(parts))

    blocks = _blocks(needed, width)
    responses = {
        lane: Response(commands.time, *channels[:, :, place].T)
        for block, channels in zip(blocks, parallel_map(run, blocks, workers), strict=True)
        for place, lane in enumerate(block.lanes)
    }
    return [responses[lane] for lane in range(len(rigs))]


@dataclass(frozen=True)
class Switch:
    """When rigs become others of the same well and string while they run.

    Attributes:
        time: s of the commands.
        rigs: What each of them becomes.
    """

    time: float
    rigs: Sequence[Rig]


class _Block(NamedTuple):
    """Runs of a batch that are stepped side by side, and their steps per interval."""

    lanes: list[int]
    substeps: int


def _blocks(needed: Sequence[int], width: int) -> list[_Block]:
    """Blocks of at most ``width`` runs. A run that needs many steps more than others does not slow these down."""
    blocks: list[_Block] = []
    left = list(range(len(needed)))
    while left:
        most = int(_MORE_STEPS * min(needed[lane] for lane in left))
        alike = [lane for lane in left if needed[lane] <= most]
        substeps = max(needed[lane] for lane in alike)
        blocks += [_Block(alike[first : first + width], substeps) for first in range(0, len(alike), width)]
        left = [lane for lane in left if needed[lane] > most]
    return blocks


def _even_grid(time: Array) -> Array:
    """The times themselves where they are even to 1e-3, else an even grid of their median spacing."""
    if len(time) < 3:
        return time
    gap = float(np.median(np.diff(time)))
    even = time[0] + (time[-1] - time[0]) / (len(time) - 1) * np.arange(len(time))
    if np.max(np.abs(np.diff(time) - gap)) <= 1e-3 * gap and np.max(np.abs(even - time)) <= 1e-2 * gap:
        return time
    return time[0] + gap * np.arange(math.ceil((time[-1] - time[0]) / gap - 1e-9) + 1)


def _interpolate(time: Array, grid: Array, channels: Array) -> Array:
    """Channels (n, channels, lanes) at the times, from those (m, channels, lanes) on the grid, joined linearly."""
    if grid is time:
        return channels
    after = np.clip(np.searchsorted(grid, time), 1, len(grid) - 1)
    fraction = ((time - grid[after - 1]) / (grid[after] - grid[after - 1]))[:, None, None]
    before = channels[after - 1]
    return np.asarray(before + np.clip(fraction, 0.0, 1.0) * (channels[after] - before))
