"""The rigs that run: state of plants and instruments, a slot for each, started and stepped on all idle threads."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slider_drilling.blind.foreign import kernel
from slider_drilling.control.interface import Measurements, MwdSample
from slider_drilling.drillstring.kernel_arrays import CHANNELS, Array, KernelState
from slider_drilling.process.jit_cache import announce_compilation
from slider_drilling.process.parallel_map import idle_threads, parallel_map
from slider_drilling.training.drawn_rigs import FOREIGN_STATE, DrawnRigs, transit_depth
from slider_drilling.training.foreign_step import step_foreign_rigs
from slider_drilling.training.instruments import ANGLE, HOOK_LOAD, PRESSURE, READINGS, SPEED, TORQUE, InstrumentRecords
from slider_drilling.training.model_step import step_rigs
from slider_drilling.training.stacking import stack_rows

Indices = NDArray[Any]
Flags = NDArray[np.bool_]
_NORMALS = 2048  # random numbers that a slot holds; what a step may use is added
_A_SAMPLE_USES = 4  # normal numbers: three sensors and the clock's jitter; toolfaces are added
_CHUNKS_PER_THREAD = 4  # so that a thread with slower rigs does not end last


class RigSlots:
    """Runs of drawn rigs.

    Args:
        rigs: The drawn rigs.
        count: Number of slots.
        duration: s that a run lasts at most.
        samples: Of the sensors that a step takes at most.
        threads: How many share the slots; None for all that are idle. Their number changes no bit of the result.

    Attributes:
        records: Instruments and true channels of each slot.
    """

    def __init__(self, rigs: DrawnRigs, count: int, duration: float, samples: int, threads: int | None) -> None:
        self.rigs, self._count, self._threads = rigs, count, threads
        toolfaces = math.ceil(rigs.interval / float(np.min(rigs.instruments.mwd[:, 0])))
        self._reserve = samples * (_A_SAMPLE_USES + toolfaces)
        self.records = _records(rigs, count, duration, _NORMALS + self._reserve)
        self._random: list[np.random.Generator] = [np.random.default_rng(0)] * count
        self._model = None if rigs.model is None else _empty_model(rigs.model.initial, count)
        self._model_out = np.empty((count, 1, len(CHANNELS), 1))
        self._foreign = None if rigs.foreign_plants is None else _empty_foreign(rigs.foreign_plants.initial, count)
        self._foreign_out = np.empty((count, 1, len(CHANNELS) + 2))
        self._foreign_rows = np.zeros((count, 2, 9))
        self._driven, self._held = np.zeros((count, 2)), np.zeros((count, 2))

    def start(self, slots: Indices, rigs: Indices, twist: Array, seeds: Indices) -> None:
        """Start runs, and measure their first sample.

        Args:
            slots, rigs: Numbers of the slots, and of the drawn rigs that run there, (m,).
            twist: Of each string, rad, (m,).
            seeds: Of sensor noise and losses of the MWD, (m,): `VirtualRig` and `FaultyRig` use them alike.
        """
        s = self.records
        s.rig[slots] = rigs
        for values in (s.samples, s.commanded, s.drives, s.taken, s.waiting, s.rows, s.uniforms_used):
            values[slots] = 0
        s.drives[slots, 4] = self.rigs.pump_speed[rigs]
        s.rows[slots, :, 4] = self.rigs.pump_speed[rigs][:, None]
        s.rows[slots, :, 6] = s.rows[slots, :, 8] = 1.0
        s.last_mwd[slots] = math.nan, math.nan, 0.0
        for slot, seed in zip(slots, seeds, strict=True):
            self._random[slot] = np.random.default_rng(int(seed))
            s.normals[slot] = self._random[slot].standard_normal(s.normals.shape[1])
            s.uniforms[slot] = np.random.default_rng((int(seed), 1)).uniform(size=s.uniforms.shape[1:])
        s.normals_used[slots] = 0
        self._start_model(slots, rigs, twist)
        self._start_foreign(slots, rigs, twist)
        active = np.zeros(self._count, dtype=bool)
        active[slots] = True
        self._advance(active, np.zeros((self._count, 4)), 1, absolute=False, fresh=True)

    def step(self, active: Flags, commands: Array, samples: int, absolute: bool) -> None:
        """Hold commands for some samples.

        Args:
            active: (slots,) which slots move.
            commands: (slots, 4) top-drive angle rad and speed rad/s, block speed m/s, pump speed rad/s.
            samples: Of the sensors.
            absolute: Whether the angle counts; else it follows from the speed.
        """
        self._draw_noise()
        self._advance(active, commands, samples, absolute, fresh=False)

    def measurements(self, slot: int) -> Measurements:
        """The last sample of one slot; its MWD sample is there if it arrived in the last step."""
        s = self.records
        drives, read, mwd = s.drives[slot], s.readings[slot], s.last_mwd[slot]
        return Measurements(
            time=float(s.samples[slot] * self.rigs.interval), top_drive_angle=float(read[ANGLE]),
            top_drive_speed=float(read[SPEED]), surface_torque=float(read[TORQUE]), block_position=float(drives[2]),
            block_speed=float(drives[3]), hook_load=float(read[HOOK_LOAD]), standpipe_pressure=float(read[PRESSURE]),
            pump_speed=float(drives[4]), mwd=(MwdSample(*map(float, mwd)),) if s.received[slot] else (),
        )  # fmt: skip

    def _start_model(self, slots: Indices, rigs: Indices, twist: Array) -> None:
        """Strings that hang at rest, with their twist."""
        mine = ~self.rigs.foreign[rigs]
        if self._model is None or self.rigs.model is None or not mine.any():
            return
        slots, plants, twist = slots[mine], self.rigs.plants[rigs[mine]], twist[mine]
        model, state = self.rigs.model, self._model
        for own, first in zip(state, model.initial, strict=True):
            own[slots] = first[plants]
        count = self.rigs.elements
        state.rotation[slots, 1 : count + 1] += model.twist_share[plants] * twist[:, None]
        spring = model.elements.torsional_spring[plants, 0]
        turned = state.rotation[slots, 0] - state.rotation[slots, 1]
        state.sensed_torque[slots, 0] = model.lanes.torque_scale[plants, 0] * spring * turned

    def _start_foreign(self, slots: Indices, rigs: Indices, twist: Array) -> None:
        mine = self.rigs.foreign[rigs]
        if self._foreign is None or self.rigs.foreign_plants is None or not mine.any():
            return
        slots, plants, twist = slots[mine], self.rigs.plants[rigs[mine]], twist[mine]
        foreign = self.rigs.foreign_plants
        for own, first in zip(self._foreign, foreign.initial, strict=True):
            own[slots] = first[plants]
        rotation, scalars = (self._foreign[FOREIGN_STATE.index(name)] for name in ("rotation", "scalars"))
        rotation[slots] += foreign.twist_share[plants] * twist[:, None]
        torque = foreign.elements.torsional_spring[plants, 0] * -rotation[slots, 0]
        for at in (kernel.QUILL_TORQUE, kernel.READ_TORQUE, kernel.LAGGED_TORQUE):
            scalars[slots, at] = torque

    def _draw_noise(self) -> None:
        """Give each slot that could run out of random numbers the next ones."""
        s = self.records
        size = s.normals.shape[1]
        for slot in np.flatnonzero(s.normals_used > size - self._reserve):
            used = int(s.normals_used[slot])
            s.normals[slot, : size - used] = s.normals[slot, used:]
            s.normals[slot, size - used :] = self._random[slot].standard_normal(used)
            s.normals_used[slot] = 0

    def _advance(self, active: Flags, commands: Array, samples: int, absolute: bool, fresh: bool) -> None:
        foreign = self.rigs.foreign[self.records.rig]
        for mine, step, function in (
            (active & ~foreign, self._model_step, step_rigs), (active & foreign, self._foreign_step, step_foreign_rigs)
        ):  # fmt: skip
            if mine.any():
                with announce_compilation(function, "the step of many rigs"):
                    self._in_chunks(lambda first, last, run=step, which=mine: run(
                        first, last, samples, which, fresh, absolute, commands))  # fmt: skip

    def _in_chunks(self, run: Any) -> None:
        threads = 1 + idle_threads() if self._threads is None else self._threads
        chunks = min(threads * _CHUNKS_PER_THREAD, self._count) if threads > 1 else 1
        bounds = np.linspace(0, self._count, chunks + 1).round().astype(int).tolist()
        parallel_map(lambda at: run(bounds[at], bounds[at + 1]), range(chunks), threads)

    def _model_step(
        self, first: int, last: int, samples: int, active: Flags, fresh: bool, absolute: bool, commands: Array
    ) -> None:
        rigs, model = self.rigs, self.rigs.model
        assert model is not None
        step_rigs(
            first, last, samples, rigs.elements, rigs.interval, active, fresh, absolute, commands, rigs.steps,
            rigs.plants, np.empty((2, 0)), self._model_out, self.records, rigs.instruments, model.elements,
            model.lanes, model.curves, self._model,
        )  # fmt: skip

    def _foreign_step(
        self, first: int, last: int, samples: int, active: Flags, fresh: bool, absolute: bool, commands: Array
    ) -> None:
        rigs, foreign = self.rigs, self.rigs.foreign_plants
        assert foreign is not None
        step_foreign_rigs(
            first, last, samples, rigs.interval, active, fresh, absolute, commands, rigs.steps, rigs.plants,
            self._foreign_rows, self._driven, self._held, self._foreign_out, self.records, rigs.instruments,
            foreign.elements, foreign.friction, foreign.runs, foreign.instruments, foreign.slow_changes, self._foreign,
        )  # fmt: skip


def _records(rigs: DrawnRigs, count: int, duration: float, normals: int) -> InstrumentRecords:
    def numbers(*shape: int) -> Array:
        return np.zeros((count, *shape))

    def counters() -> Any:
        return np.zeros(count, dtype=np.int64)

    toolfaces = math.ceil(duration / float(np.min(rigs.instruments.mwd[:, 0]))) + 2
    return InstrumentRecords(
        rig=counters(), samples=counters(), commanded=numbers(), drives=numbers(5), rows=numbers(2, 9),
        truth=numbers(len(CHANNELS)), lagged=numbers(3), readings=numbers(READINGS), taken=counters(),
        transit=numbers(transit_depth(rigs), 3), waiting=counters(), last_mwd=numbers(3), received=counters(),
        normals=numbers(normals), normals_used=counters(), uniforms=numbers(toolfaces, 3), uniforms_used=counters(),
    )  # fmt: skip


def _empty_model(initial: KernelState, count: int) -> KernelState:
    above = ("position", "rotation")
    return KernelState(*(
        stack_rows([np.zeros(values.shape[1])] * count, 1 if name in above else 0) if values.shape[1] > 2
        else np.zeros((count, values.shape[1])) for name, values in zip(KernelState._fields, initial, strict=True)
    ))  # fmt: skip


def _empty_foreign(initial: tuple[Array, ...], count: int) -> tuple[Array, ...]:
    return tuple(np.zeros((count, *values.shape[1:])) for values in initial)
