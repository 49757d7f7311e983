"""The drill string as a model of the gap engine: logs and a rig file in, channels for many parameter sets out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace

import numpy as np

from slider_drilling.diagnosis.user_effects import UserEffect, combined_modifiers
from slider_drilling.drillstring import Commands, Observer, Response, Start, simulate_batch
from slider_drilling.effects import Effects
from slider_drilling.gap.model import Array, Effect, How, Manoeuvre, Parameter, Run, Values
from slider_drilling.rig import FrictionInterval, Rig

COARSE, FINE = 32, 100
# Elements of each fidelity.
MESHES = (32, 100, 160)
# Of a refined model.
_COARSE, _FINE = 60, 160
FINER = 1.6  # times the fine mesh: what `discretisation` compares it with
_THREADS = 2
_SPLIT = 40
_REMEMBERED = 16


@dataclass(frozen=True)
class _Exact:
    """Channels of a run at one parameter set on the fine mesh, and what that adds to the coarse one, each (n,)."""

    fine: dict[str, Array]
    added: dict[str, Array]


@dataclass
class DrillString:
    """See `slider_drilling.gap.model.Model`, `Anchored`, `Refinable` and `Probed`.

    Simulations run on a coarse mesh; `anchor` measures what the fine mesh adds at one parameter set, and that
    difference is added until the next anchor. rig: with the log's nominal parameters; commands: one per run.
    """

    rig: Rig
    runs: tuple[Run, ...]
    commands: tuple[Commands, ...]
    nuisance: tuple[Parameter, ...]
    effects: tuple[Effect, ...]
    user_effects: Mapping[str, UserEffect] = field(default_factory=dict)
    probes: tuple[tuple[Parameter, float, float], ...] = ()
    together: tuple[str, ...] = ()
    coarse: int = COARSE
    fine: int = FINE
    _correction: list[dict[str, Array]] = field(default_factory=list, repr=False)
    _known: dict[tuple[int, tuple[tuple[str, float], ...]], _Exact] = field(
        default_factory=dict, init=False, repr=False
    )

    @property
    def pulled(self) -> str:
        """See `slider_drilling.gap.model.Pulled`."""
        return "surface_torque"

    def fed(self, run: int, measured: Array) -> DrillString:
        """See `slider_drilling.gap.model.Pulled`."""
        channels = tuple(
            replace(channel, measured=measured) if channel.name == self.pulled else channel
            for channel in self.runs[run].channels
        )
        runs = list(self.runs)
        runs[run] = replace(runs[run], channels=channels)
        return replace(self, runs=tuple(runs))

    @property
    def finest(self) -> int:
        """See `slider_drilling.gap.model.Graded`."""
        return len(MESHES) - 1

    def simulate(self, run: int, sets: Sequence[Values], how: How | None = None) -> Mapping[str, Array]:
        """Channels (K, n) on the coarse mesh plus the anchor's correction."""
        if how is not None:
            return self._channels(run, sets, MESHES[how.fidelity], how.pull)
        channels = self._channels(run, sets, self.coarse)
        if self._correction:
            for name, extra in self._correction[run].items():
                channels[name] = channels[name] + extra
        return channels

    def anchor(self, values: Sequence[Values]) -> None:
        """Make `simulate` equal the fine mesh at these values, one set per run."""
        self._correction = [self._exact(run, own).added for run, own in enumerate(values)]

    def _exact(self, run: int, values: Values) -> _Exact:
        """A run on the fine mesh, remembered: a search comes back to the same few places."""
        place = run, tuple(sorted(values.items()))
        if place not in self._known:
            while len(self._known) >= _REMEMBERED:
                self._known.pop(next(iter(self._known)))
            fine, coarse = (self._channels(run, [values], elements) for elements in (self.fine, self.coarse))
            self._known[place] = _Exact(
                {name: rows[0] for name, rows in fine.items()}, {name: fine[name][0] - coarse[name][0] for name in fine}
            )
        return self._known[place]

    def shortened(self, share: float) -> DrillString:
        """The first part of every run; whatever the anchor knew of it is kept."""
        runs, commands, corrections = [], [], []
        for index, run in enumerate(self.runs):
            until = run.time[0] + share * run.duration
            kept = [
                replace(c, time=c.time[c.time <= until], measured=c.measured[c.time <= until]) for c in run.channels
            ]
            kept = [channel for channel in kept if channel.time.size]
            inside = run.time <= until
            runs.append(replace(run, time=run.time[inside], excitation=run.excitation[inside], channels=tuple(kept)))
            own = self.commands[index]
            commands.append(Commands(*(getattr(own, name)[inside] for name in Commands.__dataclass_fields__)))
            if self._correction:
                corrections.append(
                    {channel.name: self._correction[index][channel.name][: channel.time.size] for channel in kept}
                )
        return replace(self, runs=tuple(runs), commands=tuple(commands), _correction=corrections)

    def refined(self) -> DrillString:
        """The same runs on finer meshes."""
        return replace(self, coarse=_COARSE, fine=_FINE, _correction=[])

    def manoeuvres(self) -> list[Manoeuvre]:
        """Runs that could be made next, see `slider_drilling.diagnosis.manoeuvres`."""
        from slider_drilling.diagnosis.manoeuvres import manoeuvres

        return manoeuvres(self)

    def discretisation(self, values: Sequence[Values]) -> list[dict[str, Array]]:
        """What a still finer mesh (with its shorter step) would change at these values."""
        differences = []
        for run, own in enumerate(values):
            finer = self._channels(run, [own], round(FINER * self.fine))
            # As a rule the anchor has just been there.
            fine = self._exact(run, own).fine
            differences.append({name: finer[name][0] - fine[name] for name in fine})
        return differences

    def _channels(self, run: int, sets: Sequence[Values], elements: int, pull: float = 0.0) -> dict[str, Array]:
        responses = self._responses(run, sets, elements, self._observer(run, pull))
        found: dict[str, Array] = {}
        for channel in self.runs[run].channels:
            lag = sensor_lag(self.rig, channel.name)
            rows = [sample(response, channel.name, channel.time, lag) for response in responses]
            found[channel.name] = np.stack(rows)
        for index, values in enumerate(sets):
            for user in self._switched_on(values):
                own = {name: rows[index] for name, rows in found.items()}
                times = {channel.name: channel.time for channel in self.runs[run].channels}
                for name, row in user.channels(times, own, values).items():
                    found[name][index] = row
        return found

    def _switched_on(self, values: Values) -> list[UserEffect]:
        return [user for name, user in self.user_effects.items() if user.effect.parameters[0].name in values]

    def _observer(self, run: int, pull: float) -> Observer | None:
        measured = [channel for channel in self.runs[run].channels if channel.name == self.pulled]
        if pull == 0.0 or not measured:
            return None
        time = self.commands[run].time
        return Observer(np.interp(time, measured[0].time, measured[0].measured), pull)

    def _responses(
        self, run: int, sets: Sequence[Values], elements: int, observer: Observer | None = None
    ) -> list[Response]:
        rigs = [rig_with(self.rig, values) for values in sets]
        starts = [start_with(values) for values in sets]
        users = [self._switched_on(values) for values in sets]
        if not any(users):
            return simulate_on_threads(rigs, self.commands[run], elements, starts, observer)
        responses = []
        for rig, start, own, values in zip(rigs, starts, users, sets, strict=True):
            commands = self.commands[run]
            for user in own:
                commands = user.commands(commands, values)
            extra = combined_modifiers(own, rig, elements, values)
            responses += simulate_batch([rig], commands, elements, [start], [extra], observer=observer)
        return responses


def simulate_on_threads(
    rigs: Sequence[Rig],
    commands: Commands,
    elements: int,
    starts: Sequence[Start],
    observer: Observer | None = None,
) -> list[Response]:
    """One batch split over the cores (the kernel runs without the interpreter's lock)."""
    if len(rigs) < _SPLIT:
        return simulate_batch(rigs, commands, elements, starts, observer=observer)
    share = int(np.ceil(len(rigs) / _THREADS))

    def run(begin: int) -> list[Response]:
        end = begin + share
        return simulate_batch(rigs[begin:end], commands, elements, starts[begin:end], observer=observer)

    with ThreadPoolExecutor(_THREADS) as pool:
        answers = pool.map(run, range(0, len(rigs), share))
        return [response for answer in answers for response in answer]


def nuisance_parameters(rig: Rig, channels: Sequence[str]) -> tuple[Parameter, ...]:
    """What any rig is tuned in, as multiples of the rig file's values; those that no channel can see are left out."""
    intervals = range(len(rig.well.friction_intervals) or 1)
    # Nothing but torque: no hook load has checked the file's friction, no tool-face how far its string twists.
    alone = set(channels) == {"surface_torque"}
    lowest, spread = (0.15, 0.5) if alone else (0.4, 0.2)
    found = [Parameter(f"friction_{index + 1}", 1.0, lowest, 2.5, 0.05, spread=spread) for index in intervals]
    found += [
        Parameter("torsional_damping", 1.0, 0.1, 5.0, 0.2, spread=0.5),
        Parameter("start_twist", 0.0, -60.0, 60.0, 0.2, "rad", spread=5.0, per_run=True),
    ]
    if alone:
        found.append(Parameter("torsional_stiffness", 1.0, 0.7, 1.5, 0.02, spread=0.15))
    seen = set(channels)
    if seen & {"hook_load", "standpipe_pressure", "tool_face"}:
        found.append(Parameter("axial_damping", 1.0, 0.1, 5.0, 0.2, spread=0.5))
        found.append(Parameter("bit_stiffness", 1.0, 0.4, 2.5, 0.05, spread=0.2))
    if "standpipe_pressure" in seen:
        # A gain that is off by more than this is a fault with a name (motor_wear), not a calibration.
        found.append(Parameter("motor_gain", 1.0, 0.85, 1.15, 0.02, spread=0.05))
        found.append(Parameter("pressure_gain", 1.0, 0.8, 1.2, 0.005, spread=0.05))
    if "tool_face" in seen:
        found.append(Parameter("tool_face_offset", 0.0, -3.2, 3.2, 0.1, "rad", spread=0.5, per_run=True))
    return tuple(found)


def start_with(values: Values) -> Start:
    """How the run begins."""
    return Start(twist=values.get("start_twist", 0.0), offset=values.get("tool_face_offset", 0.0))


def rig_with(rig: Rig, values: Values) -> Rig:
    """The rig with nuisance multiples and effect parameters set; what else values holds is not the rig's."""
    intervals = rig.well.friction_intervals or (FrictionInterval(rig.string.length, 1.0),)
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
        bit=replace(rig.bit, depth_of_cut_stiffness=rig.bit.depth_of_cut_stiffness * values.get("bit_stiffness", 1.0)),
        motor=replace(motor, torque_per_pressure=motor.torque_per_pressure * values.get("motor_gain", 1.0)),
        hydraulics=replace(
            hydraulics, reference_pressure=hydraulics.reference_pressure * values.get("pressure_gain", 1.0)
        ),
    )
    return replace(tuned, effects=_effects_with(tuned, _rectified(values)))


def _effects_with(rig: Rig, values: Values) -> Effects:
    blocks: dict[str, dict[str, float]] = {}
    for name, value in values.items():
        effect, dot, parameter = name.partition(".")
        if dot and hasattr(rig.effects, effect):
            blocks.setdefault(effect, {})[parameter] = value
    changed = {name: replace(getattr(rig.effects, name), **block) for name, block in blocks.items()}
    return replace(rig.effects, **changed)


def _rectified(values: Values) -> Values:
    """A wave of negative amplitude is the same wave half a period on; the rig file wants it positive."""
    if values.get("heave.amplitude", 0.0) >= 0.0:
        return values
    phase = (values.get("heave.phase", 0.0) + 2.0 * np.pi) % (2.0 * np.pi) - np.pi
    return {**values, "heave.amplitude": -values["heave.amplitude"], "heave.phase": phase}


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
    """The lag s that the rig file states for a surface sensor, 0 for the tool-face."""
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
