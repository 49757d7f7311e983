"""The drill string as a model of the gap engine: logs and a rig file in, channels for many parameter sets out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from slider_drilling.diagnosis.catalogue import to_user, user_parameters
from slider_drilling.diagnosis.free_forms import (
    bite_factor,
    commands_part,
    contact_with,
    disturbances,
    disturbed,
    friction_factor,
)
from slider_drilling.diagnosis.manoeuvres import next_runs
from slider_drilling.diagnosis.run_inputs import RunInputs
from slider_drilling.diagnosis.unlogged_block import lowered_blocks
from slider_drilling.diagnosis.unlogged_flow import with_steps
from slider_drilling.diagnosis.user_effects import UserEffect, combined_modifiers
from slider_drilling.drillstring import InitialState, Observer, Response, simulate_batch
from slider_drilling.effects import Effects
from slider_drilling.gap.model import (
    Array,
    Effect,
    FreeForm,
    LoggedRun,
    Manoeuvre,
    Parameter,
    SimulationOptions,
    Values,
)
from slider_drilling.rig import FrictionInterval, Rig

# Elements of each fidelity.
MESHES = (32, 100, 160)


@dataclass(frozen=True)
class DrillString:
    """See `slider_drilling.gap.model`: `Model` and every optional protocol beside it (`Has...`, `CanTruncate`).

    rig: with the log's nominal parameters; driven: what moved it, one per run. Nothing here changes by being used.
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

    @property
    def user_parameters(self) -> Mapping[str, Parameter]:
        """See `HasUserParameters`."""
        return user_parameters(self.rig.string.length)

    def to_user(self, values: Values) -> dict[str, float]:
        """See `HasUserParameters`."""
        return to_user(values, self.rig.string.length)

    def free_forms(self, values: Values) -> list[FreeForm]:
        """See `HasFreeForms`."""
        return disturbances(values, self.probes, max(run.duration for run in self.runs), self.rig.contact)

    def sensor_site(self, channel: str) -> str:
        """See `HasFreeForms`."""
        return "hydraulics" if channel == "standpipe_pressure" else "sensor"

    def simulate(self, run: int, sets: Sequence[Values], options: SimulationOptions) -> Mapping[str, Array]:
        """Channels (K, n) of K parameter sets."""
        return self._channels(run, sets, self.meshes[options.fidelity], options.observer_gain)

    def truncated(self, fraction: float) -> DrillString:
        """The first part of every run."""
        runs, driven = [], []
        for index, run in enumerate(self.runs):
            until = run.time[0] + fraction * run.duration
            kept = [
                replace(c, time=c.time[c.time <= until], measured=c.measured[c.time <= until]) for c in run.channels
            ]
            inside = run.time <= until
            channels = tuple(channel for channel in kept if channel.time.size)
            runs.append(replace(run, time=run.time[inside], excitation=run.excitation[inside], channels=channels))
            own = self.inputs[index]
            faster = None if own.acceleration is None else own.acceleration[inside]
            driven.append(replace(own, commands=own.commands.samples(inside), acceleration=faster))
        return replace(self, runs=tuple(runs), inputs=tuple(driven))

    def manoeuvres(self) -> list[Manoeuvre]:
        """Runs that could be made next."""
        return [
            Manoeuvre(text, settings, replace(self, runs=(run,), inputs=(RunInputs(commands),)))
            for text, settings, run, commands in next_runs(self.rig, self.runs[0], self.inputs[0].commands)
        ]

    def _channels(self, run: int, sets: Sequence[Values], elements: int, pull: float = 0.0) -> dict[str, Array]:
        responses = self._responses(run, sets, elements, self._observer(run, pull))
        found: dict[str, Array] = {}
        for channel in self.runs[run].channels:
            lag = sensor_lag(self.rig, channel.name)
            rows = [sample(response, channel.name, channel.time, lag) for response in responses]
            if channel.name == "standpipe_pressure" and self.inputs[run].flow_steps:
                rows = [self._with_steps(run, row, channel.time, own) for row, own in zip(rows, sets, strict=True)]
            found[channel.name] = np.stack(rows)
        for index, values in enumerate(sets):
            for user in self._switched_on(values):
                own = {name: rows[index] for name, rows in found.items()}
                times = {channel.name: channel.time for channel in self.runs[run].channels}
                for name, row in user.channels(times, own, values).items():
                    found[name][index] = row
        return found

    def _lowered(self, run: int, sets: Sequence[Values]) -> Array | None:
        own = self.inputs[run]
        return lowered_blocks(own.commands.time, sets, self.nuisance) if own.lowered else None

    def _with_steps(self, run: int, row: Array, time: Array, values: Values) -> Array:
        lag = rig_with(self.rig, values).hydraulics.lag
        return with_steps(row, time, self.inputs[run].flow_steps or (), values, lag)

    def _switched_on(self, values: Values) -> list[UserEffect]:
        return [user for name, user in self.user_effects.items() if user.effect.parameters[0].name in values]

    def _observer(self, run: int, pull: float) -> Observer | None:
        measured = [channel for channel in self.runs[run].channels if channel.name == self.observed_channel]
        if pull == 0.0 or not measured:
            return None
        return Observer(measured[0].time, measured[0].measured, pull)

    def _responses(
        self, run: int, sets: Sequence[Values], elements: int, observer: Observer | None = None
    ) -> list[Response]:
        """One batch of those that differ in the rig alone; a user's effect, which may change the elements, runs by
        itself.
        """
        found: dict[int, Response] = {}
        batches: dict[tuple[tuple[str, float], ...], list[int]] = {}
        for index, values in enumerate(sets):
            if self._switched_on(values):
                found[index] = self._with_users(run, values, elements, observer)
            else:
                batches.setdefault(commands_part(values), []).append(index)
        for own in batches.values():
            first, rigs = sets[own[0]], [rig_with(self.rig, sets[index]) for index in own]
            commands = disturbed(self.inputs[run].commands, first)
            batch = simulate_batch(
                rigs, commands, elements, [start_with(sets[index], self.inputs[run].start) for index in own],
                workers=None, observer=observer, friction_factor=friction_factor(commands, first),
                acceleration=self.inputs[run].acceleration,
                bit_torque_factor=bite_factor(commands, first),
                block_offset=self._lowered(run, [sets[index] for index in own]), single_precision=True,
            )  # fmt: skip
            found.update(zip(own, batch, strict=True))
        return [found[index] for index in range(len(sets))]

    def _with_users(self, run: int, values: Values, elements: int, observer: Observer | None) -> Response:
        users, rig = self._switched_on(values), rig_with(self.rig, values)
        commands = disturbed(self.inputs[run].commands, values)
        for user in users:
            commands = user.commands(commands, values)
        extra = combined_modifiers(users, rig, elements, values)
        return simulate_batch(
            [rig], commands, elements, [start_with(values, self.inputs[run].start)], [extra], observer=observer,
            friction_factor=friction_factor(commands, values), acceleration=self.inputs[run].acceleration,
            bit_torque_factor=bite_factor(commands, values), block_offset=self._lowered(run, [values]),
            single_precision=True,
        )[0]  # fmt: skip


def start_with(values: Values, before: InitialState) -> InitialState:
    """How the run begins; before: without the values."""
    start = replace(before, twist=values.get("start_twist", 0.0), tool_face_offset=values.get("tool_face_offset", 0.0))
    if not before.loaded:
        return start
    weight = max(before.weight_on_bit + values.get("start_weight", 0.0), 0.0)
    drag = min(max(before.axial_friction_share + values.get("start_drag", 0.0), -1.0), 1.0)
    hold = values.get("start_hold", 0.0)
    return replace(start, weight_on_bit=weight, axial_friction_share=drag, tangential_friction_share=hold)


def rig_with(rig: Rig, values: Values) -> Rig:
    """The rig with nuisance multiples and effect parameters set; what else values holds is not the rig's. A second
    friction is that of the lower half where the file has one for the whole hole.
    """
    intervals = rig.well.friction_intervals or (FrictionInterval(rig.string.length, 1.0),)
    if len(intervals) == 1 and "friction_2" in values:
        intervals = (FrictionInterval(0.5 * rig.string.length, intervals[0].factor), *intervals)
    scaled = [
        replace(interval, factor=interval.factor * values.get(f"friction_{index + 1}", 1.0))
        for index, interval in enumerate(intervals)
    ]
    string, motor, hydraulics = rig.string, rig.motor, rig.hydraulics
    tuned = replace(
        rig,
        well=replace(rig.well, friction_intervals=with_probes(tuple(scaled), rig.string.length, values)),
        string=replace(
            string,
            shear_modulus=string.shear_modulus * values.get("torsional_stiffness", 1.0),
            axial_damping=string.axial_damping * values.get("axial_damping", 1.0),
            torsional_damping=string.torsional_damping * values.get("torsional_damping", 1.0),
        ),
        contact=contact_with(rig.contact, values),
        bit=replace(rig.bit, depth_of_cut_stiffness=rig.bit.depth_of_cut_stiffness * values.get("bit_stiffness", 1.0)),
        motor=replace(motor, torque_per_pressure=motor.torque_per_pressure * values.get("motor_gain", 1.0)),
        hydraulics=replace(
            hydraulics,
            reference_pressure=hydraulics.reference_pressure * values.get("pressure_gain", 1.0),
            lag=hydraulics.lag * values.get("pressure_lag", 1.0),
        ),
    )
    return replace(tuned, effects=_effects_with(tuned, to_user(values, string.length)))


def _effects_with(rig: Rig, values: Values) -> Effects:
    blocks: dict[str, dict[str, float]] = {}
    for name, value in values.items():
        effect, dot, parameter = name.partition(".")
        if dot and hasattr(rig.effects, effect):
            blocks.setdefault(effect, {})[parameter] = value
    changed = {name: replace(getattr(rig.effects, name), **block) for name, block in blocks.items()}
    return replace(rig.effects, **changed)


def depth_probes(length: float, count: int = 10) -> tuple[tuple[Parameter, float, float], ...]:
    """Friction multipliers of equal stretches of the hole."""
    edges = np.linspace(0.0, length, count + 1)
    return tuple(
        (Parameter(f"probe_{index}", 1.0, 0.1, 5.0, 0.2), float(edges[index]), float(edges[index + 1]))
        for index in range(count)
    )


def with_probes(intervals: tuple[FrictionInterval, ...], length: float, values: Values) -> tuple[FrictionInterval, ...]:
    """Friction intervals cut at the probes' edges and multiplied where a probe says so."""
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
    """The lag s that the rig file states for a surface sensor, 0 for the toolface."""
    sensor = getattr(rig.sensors, channel, None)
    return float(sensor.lag) if sensor is not None else 0.0


def sample(response: Response, channel: str, times: Array, lag: float) -> Array:
    """A channel of the response at the sensor's own times (n,), through its first-order lag."""
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
