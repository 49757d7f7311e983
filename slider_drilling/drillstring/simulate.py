"""The public door to the plant: step it, save it, restore it, or run it through a whole record of commands."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from slider_drilling.drillstring import assemble, kernel
from slider_drilling.drillstring.assemble import Modifiers
from slider_drilling.drillstring.depth_profile import DepthProfile, profile_of
from slider_drilling.drillstring.initial_state import InitialState, initial_kernel_state
from slider_drilling.drillstring.kernel_arrays import CHANNELS, Array, KernelState, in_single
from slider_drilling.drillstring.observer import Observer
from slider_drilling.drillstring.recorded_channels import Commands, Response
from slider_drilling.process.jit_cache import announce_compilation
from slider_drilling.process.parallel_map import idle_threads, parallel_map
from slider_drilling.rig import Rig

ELEMENTS = 200
"""Elements of the example rig at which doubling them changes surface torque by less than 1 % RMS."""
_LEAST_FACTOR = 1e-9  # of friction: one of zero leaves no length over which the strain of a contact decays
_LANES_PER_BLOCK = 16  # runs side by side: their arrays of 200 elements just fit a core's second-level cache


@dataclass(frozen=True)
class PlantState:
    """A copy of everything that changes in a plant; see `Plant.restore`."""

    arrays: KernelState
    last_command: Array


class Plant:
    """One drill string in its well, stepped at a fixed interval.

    ``interval`` (s, default that of the rig's sensors) is the time between two samples of the commands; the kernel's
    own step is the longest stable one that divides it, or ``interval / substeps``.
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
        substeps = substeps or _least_substeps([rig], mesh, interval)
        self._bundle = _Bundle([rig], mesh, interval, [start], [modifiers], substeps)

    @property
    def interval(self) -> float:
        """Seconds between two samples of the commands."""
        return self._bundle.interval

    @property
    def step(self) -> float:
        """The kernel's own time step, s."""
        return self._bundle.dt

    @property
    def mesh(self) -> assemble.Mesh:
        return self._bundle.mesh

    @property
    def time(self) -> float:
        """Seconds simulated since the start."""
        return float(self._bundle.state.clock[0]) if self._bundle.state else 0.0

    def advance(self, commands: Commands) -> Response:
        """Follow commands sampled every ``interval`` and give the response at their times.

        The first call starts the string at rest at its first sample; later calls continue, one interval before their
        first sample. Raises ValueError for samples that are not one interval apart.
        """
        channels = self._bundle.advance(commands)
        return Response(commands.time, *(channels[:, row, 0] for row in range(len(CHANNELS))))

    def scale_friction(self, factor: Array) -> None:
        """Multiply each element's friction by `factor` (n,) from now on, over that of rig file and modifiers."""
        self._bundle.scale_friction(factor)

    def save(self) -> PlantState:
        """A copy of the state; raises ValueError before the first `advance`."""
        return self._bundle.save()

    def restore(self, state: PlantState) -> None:
        """Go back to a saved state; the next `advance` continues from there bit for bit."""
        self._bundle.restore(state)

    def profile(self) -> DepthProfile:
        """The string along its length; raises ValueError before the first `advance`."""
        return self._bundle.profile()


def simulate(
    rig: Rig,
    commands: Commands,
    elements: int = ELEMENTS,
    start: InitialState = InitialState(),
    modifiers: Modifiers = Modifiers(),
    substeps: int | None = None,
) -> Response:
    """Drive the plant through a whole record, from rest at its first sample.

    The samples may be unevenly spaced: the plant then runs on an even grid of their median spacing and its response is
    interpolated back.
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
) -> list[Response]:
    """`simulate` for many parameter sets of one well and string, vectorised across them.

    Runs go through the kernel in blocks that fit the cache, on ``workers`` threads, or with None on those that have
    nothing to do; how they are shared out changes no bit. observer: lets the torque that was measured pull weakly at
    the top drive. friction: (n,) what all friction is multiplied by at the commands' times, joined linearly.
    acceleration: (n,) rad/s2 of the top drive at the commands' times, for torque that is read at its motor; the slope
    of the commands' speed where it is not given, which from a measured speed is mostly noise (see
    `drive_acceleration`). bite: (n,) what the bit's torque per weight is multiplied by at the commands' times, joined
    linearly. lowered: (K, n) m that each run's block is lower than the commands say at their times, joined linearly.
    single: in single precision but for positions and rotations, in half of the time; where no run is chaotic torque is
    off by tenths of a N m, hook load by some N.
    Raises InputError where the rigs differ in survey, sections, contact or sound speed.
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
    lower = (
        None
        if block_offset is None
        else np.stack([np.interp(grid, commands.time, row) for row in block_offset], axis=1)
    )
    measured = None if observer is None else observer.measured_at(grid)
    mesh = assemble.common_mesh(rigs, elements)
    substeps = substeps or _least_substeps(rigs, mesh, interval)
    shares = 1 + idle_threads() if workers is None else max(workers, 1)
    width = min(math.ceil(len(rigs) / shares), _LANES_PER_BLOCK)

    def run(first: int) -> list[Array]:
        block = slice(first, first + width)
        bundle = _Bundle(
            rigs[block], mesh, interval, starts[block], modifiers[block], substeps, observer, single_precision
        )
        below = None if lower is None else lower[:, block]
        channels = _joined(
            commands.time,
            grid,
            bundle.advance(sampled, measured, friction_factor, acceleration, bit_torque_factor, below),
        )
        return [channels[:, :, lane] for lane in range(channels.shape[2])]

    blocks = parallel_map(run, range(0, len(rigs), width), workers)
    return [Response(commands.time, *lane.T) for block in blocks for lane in block]


class _Bundle:
    """Rigs that are stepped side by side: constants, state and the last command."""

    def __init__(
        self,
        rigs: Sequence[Rig],
        mesh: assemble.Mesh,
        interval: float,
        starts: Sequence[InitialState],
        modifiers: Sequence[Modifiers],
        substeps: int,
        observer: Observer | None = None,
        single: bool = False,
    ) -> None:
        self.rigs, self.starts, self.interval = list(rigs), list(starts), interval
        self.mesh, self.substeps, self.dt = mesh, substeps, interval / substeps
        self.elements = assemble.elements(rigs, self.mesh, self.dt, modifiers)
        self._yielding = self.elements.yielding.copy()
        self.lanes = assemble.lanes(rigs, self.mesh, self.dt, observer)
        self.curve = assemble.friction_curve(rigs[0].contact)
        self.by_speed = bool(np.any(self.elements.stribeck_drop) or np.any(self.elements.drift_rate))
        self.by_rest = bool(np.any(self.elements.aging_growth))
        self.single = single
        self.state: KernelState | None = None
        self.last: Array | None = None

    def advance(
        self,
        commands: Commands,
        measured: Array | None = None,
        factor: Array | None = None,
        acceleration: Array | None = None,
        bite: Array | None = None,
        lowered: Array | None = None,
    ) -> Array:
        """(n, channels, lanes) at the times of the commands; measured: (n,) N m, the observer's torque; factor: (n,) of
        all friction; acceleration: (n,) rad/s2 of the top drive; bite: (n,) of the bit's torque per weight; lowered:
        (n, lanes) m that the blocks are lower than the commands say.
        """
        torque = np.zeros(len(commands.time)) if measured is None else measured
        ones = np.ones(len(commands.time))
        faster = self._slope(commands.top_drive_speed) if acceleration is None else acceleration
        factors, bites = (ones if values is None else values for values in (factor, bite))
        rows = np.column_stack([commands.rows(), torque, factors, faster, bites])
        gaps = commands.time[1:] - commands.time[:-1]
        if len(gaps) and np.abs(gaps - self.interval).max() > 1e-3 * self.interval:
            raise ValueError(f"commands: samples must be {self.interval:g} s apart; `simulate` takes uneven ones")
        width = len(self.rigs)
        lower = np.zeros((len(rows), 0)) if lowered is None else np.ascontiguousarray(lowered)
        out = np.empty((len(rows), len(CHANNELS), width))
        if self.state is None:
            self.state = initial_kernel_state(
                self.rigs, self.mesh, self.elements, self.lanes, self.curve, self.dt, rows[0], self.starts,
                0.0 if lowered is None else lower[0],
            )
            if self.single:
                self.elements, self.state = in_single(self.elements, self.state, width)
        else:
            rows = np.concatenate([self._started()[1][None], rows])
            lower = np.concatenate([lower[:1], lower])
        advance = kernel.advance_single if self.single else kernel.advance
        what = "the step of the drill string" + (", in single precision," if self.single else "")
        with announce_compilation(advance, what):
            advance(
                width, self.mesh.count, self.substeps, self.dt, self.by_speed, self.by_rest, rows, lower,
                self.elements, self.curve, self.lanes, self.state, out,
            )  # fmt: skip
        self.last = rows[-1].copy()
        return out

    def _slope(self, speed: Array) -> Array:
        """(n,) rad/s2, half from before each sample and half from behind it; the last one's is from before."""
        before = speed[0] if self.last is None else self.last[1]
        if speed.size == 1:  # a rig that is stepped: this comes once a sample
            return np.asarray((speed - before) / self.interval)
        if self.last is None:
            return np.asarray(np.gradient(speed, self.interval))
        return np.asarray(np.gradient(np.concatenate([[before], speed]), self.interval)[1:])

    def scale_friction(self, factor: Array) -> None:
        state, _ = self._started()
        rows = np.repeat(np.maximum(factor, _LEAST_FACTOR), len(self.rigs))
        self.elements.yielding[: len(rows)] = self._yielding[: len(rows)] / rows
        # The kernel takes a run's friction from its state, and renews that from the elements only where it varies.
        state.yielding[:] = self.elements.yielding

    def save(self) -> PlantState:
        state, last = self._started()
        return PlantState(KernelState(*(array.copy() for array in state)), last.copy())

    def restore(self, saved: PlantState) -> None:
        self.state = KernelState(*(array.copy() for array in saved.arrays))
        self.last = saved.last_command.copy()

    def profile(self) -> DepthProfile:
        return profile_of(self.mesh, self.elements, self.curve, self._started()[0])

    def _started(self) -> tuple[KernelState, Array]:
        if self.state is None or self.last is None:
            raise ValueError("plant: has no state before the first advance")
        return self.state, self.last


def _least_substeps(rigs: Sequence[Rig], mesh: assemble.Mesh, interval: float) -> int:
    """Steps of an interval that are stable for all of the rigs: the same for each, whoever it is stepped beside."""
    return max(1, math.ceil(interval / min(assemble.longest_step(rig, mesh) for rig in rigs)))


def _even_grid(time: Array) -> Array:
    """The times themselves where they are even to a thousandth, else an even grid of their median spacing."""
    if len(time) < 3:
        return time
    gap = float(np.median(np.diff(time)))
    even = time[0] + (time[-1] - time[0]) / (len(time) - 1) * np.arange(len(time))
    if np.max(np.abs(np.diff(time) - gap)) <= 1e-3 * gap and np.max(np.abs(even - time)) <= 1e-2 * gap:
        return time
    return time[0] + gap * np.arange(math.ceil((time[-1] - time[0]) / gap - 1e-9) + 1)


def _joined(time: Array, grid: Array, channels: Array) -> Array:
    """(n, channels, lanes) at the times, joined linearly; channels: (m, channels, lanes) on the grid."""
    if grid is time:
        return channels
    after = np.clip(np.searchsorted(grid, time), 1, len(grid) - 1)
    share = ((time - grid[after - 1]) / (grid[after] - grid[after - 1]))[:, None, None]
    before = channels[after - 1]
    return np.asarray(before + np.clip(share, 0.0, 1.0) * (channels[after] - before))
