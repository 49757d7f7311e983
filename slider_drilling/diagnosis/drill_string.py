"""The drill string as a model of the gap engine: it simulates logged runs for many parameter sets at once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from slider_drilling.diagnosis.catalogue import of_run, to_user, user_parameters
from slider_drilling.diagnosis.disturbances import (
    bit_torque_factor,
    disturbance_key,
    disturbed_commands,
    friction_factor,
    turning_difference,
)
from slider_drilling.diagnosis.drilling_programmes import (
    DrillingProgrammes,
    programme_limits,
    surface_channels,
)
from slider_drilling.diagnosis.free_forms import catalogue_free_forms
from slider_drilling.diagnosis.nuisance import (
    conditional_nuisance,
    reported_nuisance,
    with_reported_nuisance,
)
from slider_drilling.diagnosis.readings import (
    READINGS,
    direction_of_block,
    read_hook_load,
    read_tool_face,
    read_torque,
    sample_channel,
    sensor_lag,
)
from slider_drilling.diagnosis.rig_values import initial_state_with, rig_with
from slider_drilling.diagnosis.run_inputs import RunInputs
from slider_drilling.diagnosis.unlogged_block import block_offsets
from slider_drilling.diagnosis.unlogged_flow import add_flow_steps
from slider_drilling.diagnosis.user_effects import UserEffect, combined_modifiers
from slider_drilling.drillstring import Modifiers, Observer, Response, Switch, simulate_batch
from slider_drilling.drillstring.observer_noise import needed_smoothing, noise_shrinkage
from slider_drilling.gap.model import (
    Array,
    Channel,
    Effect,
    FreeForm,
    LoggedRun,
    Parameter,
    SimulationOptions,
    Values,
)
from slider_drilling.gap.problem.noise import difference_noise
from slider_drilling.rig import Rig

# Elements of the string at each fidelity.
MESHES = (32, 100, 160)


@dataclass(frozen=True)
class DrillString:
    """A `slider_drilling.gap.model.Model` with every optional protocol (`Has...`, `CanTruncate`). It is immutable.

    Attributes:
        rig: The rig file as given.
        runs: The logs.
        inputs: What drove each run.
        nuisance: Calibrated parameters.
        effects: All candidates, users' effects among them.
        user_effects: Users' effects by name.
        probes: Friction multipliers (parameter, from, to), m of measured depth, which locate the gap along the hole.
        coupled_effects: Effects that may show only together.
        meshes: Elements of the string at each fidelity.
    """

    rig: Rig
    runs: tuple[LoggedRun, ...]
    inputs: tuple[RunInputs, ...]
    nuisance: tuple[Parameter, ...]
    effects: tuple[Effect, ...]
    user_effects: Mapping[str, UserEffect] = field(default_factory=dict)
    probes: tuple[tuple[Parameter, float, float], ...] = ()
    coupled_effects: tuple[str, ...] = ()
    meshes: tuple[int, ...] = MESHES

    @property
    def max_fidelity(self) -> int:
        """See `HasFidelities`."""
        return len(self.meshes) - 1

    @property
    def observed_channel(self) -> str:
        """See `HasObserver`."""
        return "surface_torque"

    def with_measured(self, run: int, measured: Array) -> DrillString:
        """See `HasObserver`."""
        channels = tuple(
            replace(channel, measured=measured) if channel.name == self.observed_channel else channel
            for channel in self.runs[run].channels
        )
        runs = list(self.runs)
        runs[run] = replace(runs[run], channels=channels)
        return replace(self, runs=tuple(runs))

    def with_channels(self, names: Sequence[str]) -> DrillString:
        """The same model with these channels only, as far as a run has them."""
        runs = tuple(
            replace(run, channels=tuple(channel for channel in run.channels if channel.name in names))
            for run in self.runs
        )
        return replace(self, runs=runs)

    @property
    def user_parameters(self) -> Mapping[str, Parameter]:
        """See `HasUserParameters`."""
        return user_parameters(self.rig.string.length) | reported_nuisance()

    def to_user(self, values: Values) -> dict[str, float]:
        """See `HasUserParameters`."""
        return with_reported_nuisance(to_user(values, self.rig.string.length))

    @property
    def conditional_nuisance(self) -> tuple[Effect, ...]:
        """See `HasConditionalNuisance`."""
        freed = {parameter.name for parameter in self.nuisance}
        return tuple(each for each in conditional_nuisance() if each.parameters[0].name not in freed)

    def with_nuisance(self, parameters: Sequence[Parameter]) -> DrillString:
        """See `HasConditionalNuisance`."""
        return replace(self, nuisance=(*self.nuisance, *parameters))

    def free_forms(self, values: Values) -> list[FreeForm]:
        """See `HasFreeForms`."""
        return catalogue_free_forms(values, self.probes, max(run.duration for run in self.runs), self.rig.contact)

    def sensor_site(self, channel: str) -> str:
        """See `HasFreeForms`."""
        return "hydraulics" if channel == "standpipe_pressure" else "sensor"

    def simulate(self, run: int, sets: Sequence[Values], options: SimulationOptions) -> Mapping[str, Array]:
        """See `Model`."""
        return self._channels(run, sets, self.meshes[options.fidelity], options.observer_gain)

    def truncated(self, fraction: float) -> DrillString:
        """See `CanTruncate`."""
        runs, inputs = [], []
        for index, run in enumerate(self.runs):
            until = run.time[0] + fraction * run.duration
            kept = [
                replace(c, time=c.time[c.time <= until], measured=c.measured[c.time <= until]) for c in run.channels
            ]
            inside = run.time <= until
            channels = tuple(channel for channel in kept if channel.time.size)
            runs.append(replace(run, time=run.time[inside], excitation=run.excitation[inside], channels=channels))
            whole = self.inputs[index]
            acceleration = None if whole.acceleration is None else whole.acceleration[inside]
            inputs.append(replace(whole, commands=whole.commands.samples(inside), acceleration=acceleration))
        return replace(self, runs=tuple(runs), inputs=tuple(inputs))

    @property
    def programme_duration(self) -> float:
        """See `HasProgrammes`."""
        return 240.0

    def programmes(self, duration: float) -> DrillingProgrammes:
        """See `HasProgrammes`: the channels are those of the last log, or of the rig's recorder before any log."""
        channels = self.runs[-1].channels if self.runs else surface_channels(self.rig)
        return DrillingProgrammes(self, duration, channels, programme_limits(self.rig))

    def with_run(self, run: LoggedRun, inputs: RunInputs) -> DrillString:
        """The same rig with one run in the place of its logs."""
        return replace(self, runs=(run,), inputs=(inputs,))

    def responses(self, run: int, sets: Sequence[Values]) -> list[Response]:
        """What the rig does in a run, K times, in the cheapest simulation."""
        return self._responses(run, [of_run(values, run) for values in sets], self.meshes[0])

    def _channels(
        self, run: int, sets: Sequence[Values], elements: int, observer_gain: float = 0.0
    ) -> dict[str, Array]:
        sets = [of_run(values, run) for values in sets]
        return self._read(run, sets, self._responses(run, sets, elements, self._observer(run, observer_gain)))

    def simulate_switched(
        self, run: int, before: Sequence[Values], after: Sequence[Values], time: float, options: SimulationOptions
    ) -> dict[str, Array]:
        """`simulate` of sets that become others at a time of the run, s; none with a user's effect.

        Args:
            run: Index of the run.
            before: Until then, K sets.
            after: From then on, K sets.
            time: On the run's own clock, s.
            options: See `Model`.
        """
        pairs = [(of_run(old, run), of_run(new, run)) for old, new in zip(before, after, strict=True)]
        keys = [(_simulated_key(old), _simulated_key(new)) for old, new in pairs]
        distinct = dict(zip(keys, pairs, strict=True))
        first, then = zip(*distinct.values(), strict=True)
        switch = Switch(time, [rig_with(self.rig, values) for values in then])
        batch = self._batch(run, first, self.meshes[options.fidelity], switch=switch)
        simulated = dict(zip(distinct, batch, strict=True))
        responses = [simulated[key] for key in keys]
        old, new = (self._read(run, list(sets), responses) for sets in zip(*pairs, strict=True))
        times = {channel.name: channel.time for channel in self.runs[run].channels}
        return {name: np.where(times[name] > time, new[name], old[name]) for name in new}

    def _read(self, run: int, sets: Sequence[Values], responses: Sequence[Response]) -> dict[str, Array]:
        """What the run's channels read of these responses (K, n)."""
        simulated: dict[str, Array] = {}
        for channel in self.runs[run].channels:
            lag = sensor_lag(self.rig, channel.name)
            rows = [sample_channel(response, channel.name, channel.time, lag) for response in responses]
            if channel.name == "standpipe_pressure" and self.inputs[run].flow_step_times:
                rows = [
                    self._with_flow_steps(run, row, channel.time, values)
                    for row, values in zip(rows, sets, strict=True)
                ]
            if channel.name == "hook_load":
                moving = direction_of_block(self.inputs[run].commands, channel.time)
                rows = [read_hook_load(row, moving, values) for row, values in zip(rows, sets, strict=True)]
            if channel.name == "surface_torque":
                rows = [read_torque(row, channel.time, values) for row, values in zip(rows, sets, strict=True)]
            if channel.name == "tool_face":
                rows = [read_tool_face(row, values) for row, values in zip(rows, sets, strict=True)]
            simulated[channel.name] = np.stack(rows)
        for index, values in enumerate(sets):
            for user in self._active_users(values):
                rows_of_set = {name: rows[index] for name, rows in simulated.items()}
                times = {channel.name: channel.time for channel in self.runs[run].channels}
                for name, row in user.channels(times, rows_of_set, values).items():
                    simulated[name][index] = row
        return simulated

    def _block_offset(self, run: int, sets: Sequence[Values]) -> Array | None:
        inputs = self.inputs[run]
        return block_offsets(inputs.commands.time, sets, self.nuisance) if inputs.block_from_pressure else None

    def _with_flow_steps(self, run: int, pressure: Array, time: Array, values: Values) -> Array:
        lag = rig_with(self.rig, values).hydraulics.lag
        return add_flow_steps(pressure, time, self.inputs[run].flow_step_times or (), values, lag)

    def _active_users(self, values: Values) -> list[UserEffect]:
        """Users' effects whose amplitude is among the values."""
        return [user for user in self.user_effects.values() if user.effect.parameters[0].name in values]

    def noise_shrinkage(self, run: int, gain: float) -> float:
        """See `HasObserver`."""
        torque = self._observed(run)
        return noise_shrinkage(gain, gain**2 * self._unit_smoothing[run], _interval(torque)) if torque else 1.0

    def _observed(self, run: int) -> Channel | None:
        return next((each for each in self.runs[run].channels if each.name == self.observed_channel), None)

    def _observer(self, run: int, gain: float) -> Observer | None:
        torque = self._observed(run)
        if gain == 0.0 or torque is None:
            return None
        return Observer(torque.time, torque.measured, gain, smoothing=gain**2 * self._unit_smoothing[run])

    @cached_property
    def _unit_smoothing(self) -> tuple[float, ...]:
        """By run: smoothing of an observer of gain 1, s; it goes with the gain's square."""
        observed = [self._observed(run) for run in range(len(self.runs))]
        return tuple(
            needed_smoothing(self.rig, difference_noise(torque.measured), _interval(torque), 1.0) if torque else 0.0
            for torque in observed
        )

    def _responses(
        self, run: int, sets: Sequence[Values], elements: int, observer: Observer | None = None
    ) -> list[Response]:
        """Simulate in batches of sets that differ in the rig alone.

        A set with a user's effect runs by itself: the effect may change the elements.
        """
        keys = [_simulated_key(values) for values in sets]
        responses: dict[tuple[tuple[str, float], ...], Response] = {}
        batches: dict[tuple[tuple[str, float], ...], dict[tuple[tuple[str, float], ...], Values]] = {}
        for key, values in zip(keys, sets, strict=True):
            if self._active_users(values):
                responses[key] = responses.get(key) or self._with_users(run, values, elements, observer)
            else:
                batches.setdefault(disturbance_key(values), {}).setdefault(key, values)
        for batch in batches.values():
            responses.update(zip(batch, self._batch(run, list(batch.values()), elements, observer), strict=True))
        return [responses[key] for key in keys]

    def _batch(
        self, run: int, sets: Sequence[Values], elements: int, observer: Observer | None = None,
        switch: Switch | None = None,
    ) -> Sequence[Response]:  # fmt: skip
        """Simulate sets with the same disturbance."""
        inputs, disturbance = self.inputs[run], sets[0]
        commands = disturbed_commands(inputs.commands, disturbance)
        return simulate_batch(
            [rig_with(self.rig, values) for values in sets], commands, elements,
            [initial_state_with(values, inputs.initial_state) for values in sets],
            [Modifiers(turning_difference=turning_difference(disturbance))] * len(sets), workers=None,
            observer=observer, friction_factor=friction_factor(commands, disturbance),
            acceleration=inputs.acceleration, bit_torque_factor=bit_torque_factor(commands, disturbance),
            block_offset=self._block_offset(run, sets), single_precision=True, switch=switch,
        )  # fmt: skip

    def _with_users(self, run: int, values: Values, elements: int, observer: Observer | None) -> Response:
        users, rig, inputs = self._active_users(values), rig_with(self.rig, values), self.inputs[run]
        commands = disturbed_commands(inputs.commands, values)
        for user in users:
            commands = user.commands(commands, values)
        return simulate_batch(
            [rig], commands, elements, [initial_state_with(values, inputs.initial_state)],
            [replace(combined_modifiers(users, rig, elements, values), turning_difference=turning_difference(values))],
            observer=observer,
            friction_factor=friction_factor(commands, values), acceleration=inputs.acceleration,
            bit_torque_factor=bit_torque_factor(commands, values), block_offset=self._block_offset(run, [values]),
            single_precision=True,
        )[0]  # fmt: skip


def _simulated_key(values: Values) -> tuple[tuple[str, float], ...]:
    """What a simulation depends on: sets that differ in how channels are read alone share one."""
    return tuple(item for item in sorted(values.items()) if item[0] not in READINGS)


def _interval(channel: Channel) -> float:
    """s between two samples."""
    return float(np.median(np.diff(channel.time)))
