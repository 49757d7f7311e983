"""The drill string as a model of the gap engine: it simulates logged runs for many parameter sets at once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from slider_drilling.diagnosis.catalogue import of_run, to_user, user_parameters
from slider_drilling.diagnosis.drilling_programmes import (
    DrillingProgrammes,
    programme_limits,
    surface_channels,
)
from slider_drilling.diagnosis.free_forms import (
    bit_torque_factor,
    catalogue_free_forms,
    contact_with,
    disturbance_key,
    disturbed_commands,
    friction_factor,
    turning_difference,
)
from slider_drilling.diagnosis.nuisance import (
    conditional_nuisance,
    hook_load_reading,
    reported_nuisance,
    torque_reading,
    with_reported_nuisance,
)
from slider_drilling.diagnosis.rig_changes import with_rig_changes
from slider_drilling.diagnosis.run_inputs import RunInputs
from slider_drilling.diagnosis.unlogged_block import block_offsets
from slider_drilling.diagnosis.unlogged_flow import add_flow_steps
from slider_drilling.diagnosis.user_effects import UserEffect, combined_modifiers
from slider_drilling.drillstring import Commands, InitialState, Modifiers, Observer, Response, simulate_batch
from slider_drilling.effects import Effects
from slider_drilling.gap.model import (
    Array,
    Effect,
    FreeForm,
    LoggedRun,
    Parameter,
    SimulationOptions,
    Values,
)
from slider_drilling.rig import FrictionInterval, Rig

# Parameters that the plant does not know: they act on readings alone.
READINGS = frozenset(parameter.name for parameter in (*hook_load_reading(), *torque_reading()))
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
        responses = self._responses(run, sets, elements, self._observer(run, observer_gain))
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

    def _observer(self, run: int, gain: float) -> Observer | None:
        measured = [channel for channel in self.runs[run].channels if channel.name == self.observed_channel]
        if gain == 0.0 or not measured:
            return None
        return Observer(measured[0].time, measured[0].measured, gain)

    def _responses(
        self, run: int, sets: Sequence[Values], elements: int, observer: Observer | None = None
    ) -> list[Response]:
        """Simulate in batches of sets that differ in the rig alone.

        A set with a user's effect runs by itself: the effect may change the elements.
        """
        # Sets that differ in how channels are read alone share one simulation.
        keys = [tuple(item for item in sorted(values.items()) if item[0] not in READINGS) for values in sets]
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

    def _batch(self, run: int, sets: Sequence[Values], elements: int, observer: Observer | None) -> Sequence[Response]:
        """Simulate sets with the same disturbance."""
        inputs, disturbance = self.inputs[run], sets[0]
        commands = disturbed_commands(inputs.commands, disturbance)
        return simulate_batch(
            [rig_with(self.rig, values) for values in sets], commands, elements,
            [initial_state_with(values, inputs.initial_state) for values in sets],
            [Modifiers(turning_difference=turning_difference(disturbance))] * len(sets), workers=None,
            observer=observer, friction_factor=friction_factor(commands, disturbance),
            acceleration=inputs.acceleration, bit_torque_factor=bit_torque_factor(commands, disturbance),
            block_offset=self._block_offset(run, sets), single_precision=True,
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


_NEUTRAL_READING = (("gain", 1.0), ("offset", 0.0), ("delay", 0.0))
# m/s of block speed, below which the friction of the sheaves is not fully turned round. A choice, for which no number
# was found in print: a fifth of the speed of lowering at 9 m/h, so that a block that drills has all of it.
SHEAVE_REVERSAL_SPEED = 5e-4


def direction_of_block(commands: Commands, time: Array) -> Array:
    """(n,) from -1, raised, to 1, lowered, at the times, s."""
    return np.tanh(np.interp(time, commands.time, commands.block_speed) / SHEAVE_REVERSAL_SPEED)


def read_hook_load(load: Array, moving: Array, values: Values) -> Array:
    """The hook load as it is read at the dead line.

    Args:
        load: (n,) N, at the hook.
        moving: (n,) direction of the block, see `direction_of_block`.
        values: Calibrated values of `hook_load_reading`.
    """
    values = with_rig_changes(values)
    gain, offset = values.get("hook_load_gain", 1.0), values.get("hook_load_offset", 0.0)
    return np.asarray(gain * load + offset - values.get("sheave_friction", 0.0) * moving)


def read_torque(torque: Array, time: Array, values: Values) -> Array:
    """Surface torque as it is read.

    Args:
        torque: (n,) N m, at the sensor.
        time: (n,) s.
        values: Calibrated values of `torque_reading`.
    """
    gain, offset, delay = (values.get(f"torque_{name}", neutral) for name, neutral in _NEUTRAL_READING)
    if (gain, offset, delay) == (1.0, 0.0, 0.0):
        return torque
    late = np.interp(time - delay, time, torque) if delay != 0.0 else torque
    return np.asarray(gain * late + offset)


def initial_state_with(values: Values, before: InitialState) -> InitialState:
    """The initial state with fitted values; before: without them."""
    start = replace(before, twist=values.get("start_twist", 0.0), tool_face_offset=values.get("tool_face_offset", 0.0))
    if not before.loaded:
        return start
    weight = max(before.weight_on_bit + values.get("start_weight", 0.0), 0.0)
    drag = min(max(before.axial_friction_share + values.get("start_drag", 0.0), -1.0), 1.0)
    hold = values.get("start_hold", 0.0)
    return replace(start, weight_on_bit=weight, axial_friction_share=drag, tangential_friction_share=hold)


def rig_with(rig: Rig, values: Values) -> Rig:
    """The rig with nuisance multiples and effect parameters; values that are not the rig's are ignored.

    If the file has one friction for the whole hole, ``friction_2`` is that of its lower half.
    """
    values = with_rig_changes(values)
    intervals = rig.well.friction_intervals or (FrictionInterval(rig.string.length, 1.0),)
    if len(intervals) == 1 and "friction_2" in values:
        intervals = (FrictionInterval(0.5 * rig.string.length, intervals[0].factor), *intervals)
    scaled = [
        replace(interval, factor=interval.factor * values.get(f"friction_{index + 1}", 1.0))
        for index, interval in enumerate(intervals)
    ]
    string, motor, hydraulics = rig.string, rig.motor, rig.hydraulics
    calibrated = replace(
        rig,
        well=replace(rig.well, friction_intervals=with_probes(tuple(scaled), rig.string.length, values)),
        string=replace(
            string,
            shear_modulus=string.shear_modulus * values.get("torsional_stiffness", 1.0),
            axial_damping=string.axial_damping * values.get("axial_damping", 1.0),
            torsional_damping=string.torsional_damping * values.get("torsional_damping", 1.0),
            weight_factor=string.weight_factor * values.get("string_weight", 1.0),
            contact_radius_factor=string.contact_radius_factor * values.get("contact_radius", 1.0),
        ),
        contact=contact_with(rig.contact, values),
        bit=replace(
            rig.bit,
            aggressiveness=rig.bit.aggressiveness * values.get("bit_aggressiveness", 1.0),
            depth_of_cut_stiffness=rig.bit.depth_of_cut_stiffness * values.get("bit_stiffness", 1.0),
        ),
        motor=replace(
            motor,
            torque_per_pressure=motor.torque_per_pressure * values.get("motor_gain", 1.0),
            leak=motor.leak * values.get("motor_leak", 1.0),
        ),
        hydraulics=replace(
            hydraulics,
            reference_pressure=hydraulics.reference_pressure * values.get("pressure_gain", 1.0),
            lag=hydraulics.lag * values.get("pressure_lag", 1.0),
        ),
    )
    return replace(calibrated, effects=_effects_with(calibrated, to_user(values, string.length)))


def _effects_with(rig: Rig, values: Values) -> Effects:
    blocks: dict[str, dict[str, float]] = {}
    for name, value in values.items():
        effect, dot, parameter = name.partition(".")
        if dot and hasattr(rig.effects, effect):
            blocks.setdefault(effect, {})[parameter] = value
    changed = {name: replace(getattr(rig.effects, name), **block) for name, block in blocks.items()}
    return replace(rig.effects, **changed)


def depth_probes(length: float, count: int = 10) -> tuple[tuple[Parameter, float, float], ...]:
    """Friction multipliers (parameter, from, to) of equal stretches of a hole; length: m."""
    edges = np.linspace(0.0, length, count + 1)
    return tuple(
        (Parameter(f"probe_{index}", 1.0, 0.1, 5.0, 0.2), float(edges[index]), float(edges[index + 1]))
        for index in range(count)
    )


def with_probes(intervals: tuple[FrictionInterval, ...], length: float, values: Values) -> tuple[FrictionInterval, ...]:
    """Friction intervals, cut at the edges of the probes among the values and multiplied by them."""
    probes = [(low, high, values[p.name]) for p, low, high in depth_probes(length) if p.name in values]
    if not probes:
        return intervals
    edges = sorted(
        {interval.to for interval in intervals} | {e for low, high, _ in probes for e in (low, high) if e > 0}
    )
    cut = []
    for edge in edges:
        factor = next(interval.factor for interval in intervals if interval.to >= edge - 1e-9)
        for low, high, multiple in probes:
            if low < edge <= high + 1e-9:
                factor *= multiple
        cut.append(FrictionInterval(edge, factor))
    return tuple(cut)


def sensor_lag(rig: Rig, channel: str) -> float:
    """First-order lag, s, of a surface sensor by the rig file; 0 for the toolface."""
    sensor = getattr(rig.sensors, channel, None)
    return float(sensor.lag) if sensor is not None else 0.0


def sample_channel(response: Response, channel: str, times: Array, lag: float) -> Array:
    """A channel as its sensor shows it: (n,) at the sensor's times, s, behind its first-order lag, s."""
    values = getattr(response, channel)
    if lag > 0.0:
        values = _lagged(response.time, values, lag)
    if times.size == response.time.size and np.array_equal(times, response.time):
        return np.asarray(values)
    return np.interp(times, response.time, values)


def _lagged(time: Array, values: Array, lag: float) -> Array:
    kept = np.exp(-np.diff(time) / lag)
    out = np.empty_like(values)
    out[0] = values[0]
    for index, share in enumerate(kept):
        out[index + 1] = share * out[index] + (1.0 - share) * values[index + 1]
    return out
