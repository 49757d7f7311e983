"""`batch`: simulate several rigs."""

from __future__ import annotations

import itertools
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from slider_drilling import drillstring
from slider_drilling.api.checks import check_commands, check_elements, check_rig, check_seed
from slider_drilling.api.simulate import UNITS, Run, simulate
from slider_drilling.api.simulated_log import build_log, sample_sensors
from slider_drilling.columns import Columns, TableExport
from slider_drilling.control.interface import Controller
from slider_drilling.drillstring import ELEMENTS, Commands, Response
from slider_drilling.drillstring.recorded_channels import require_finite
from slider_drilling.errors import InputError
from slider_drilling.plain_names import plain_name
from slider_drilling.rig import Rig

if TYPE_CHECKING:
    import plotly


@dataclass(frozen=True, repr=False)
class Batch(TableExport):
    """Several runs.

    Attributes:
        runs: In the order of their rigs.
        labels: For each run, the varied keys of the rig file and their values.
    """

    runs: tuple[Run, ...]
    labels: tuple[dict[str, Any], ...]

    def __len__(self) -> int:
        return len(self.runs)

    def __iter__(self) -> Iterator[Run]:
        return iter(self.runs)

    def __getitem__(self, index: int) -> Run:
        return self.runs[index]

    def __repr__(self) -> str:
        names = list(self.labels[0]) if self.labels else []
        return f"Batch({len(self.runs)} runs{', varied: ' + ', '.join(names) if names else ''})"

    def columns(self) -> Columns:
        """All runs below each other: number of the run, varied values, time, and noise-free channels."""
        lengths = [len(run.response.time) for run in self.runs]
        values = {"run": np.repeat(np.arange(len(self.runs)), lengths)}
        for name in self.labels[0]:
            values[name] = np.repeat(np.array([label[name] for label in self.labels]), lengths)
        for name in ("time", *UNITS):
            values[name] = np.concatenate([run.channel(name) for run in self.runs])
        return Columns(values, {"time": "s", **UNITS})

    def plot(self, channel: str = "surface_torque") -> plotly.graph_objects.Figure:
        """One channel of every run against time, in SI units.

        Raises:
            InputError: The channel is none of a run's, or plotly is not installed.
        """
        from slider_drilling.api.plots import lines

        if channel not in UNITS:
            raise InputError(f"plot: channel = {channel!r}: one of {', '.join(UNITS)}")
        curves = [(_name(label) or f"run {index}", run.response.time, run.channel(channel))
                  for index, (label, run) in enumerate(zip(self.labels, self.runs, strict=True))]  # fmt: skip
        return lines(curves, "time, s", f"{plain_name(channel)}, {UNITS[channel]}")


def _name(label: Mapping[str, Any]) -> str:
    return ", ".join(f"{key} {value:.4g}" if isinstance(value, float) else f"{key} {value}"
                     for key, value in label.items())  # fmt: skip


def batch(
    rigs: Rig | Sequence[Rig],
    drive: Commands | Callable[[Rig], Controller] | str,
    duration: float | None = None,
    *,
    vary: Mapping[str, Sequence[Any]] | None = None,
    target: float = 0.0,
    seed: int = 0,
    elements: int = ELEMENTS,
    workers: int = 2,
    progress: Callable[[int], None] = lambda done: None,
) -> Batch:
    """Simulate several rigs, or one rig with every combination of varied values.

    Commands are simulated together where wells and strings are the same: much faster than one by one.

    Args:
        rigs: The rigs, or the one rig to vary.
        drive: Commands, or a controller's class, a function of the rig, or ``"module:Class"``. Each run gets a new
            controller.
        duration: Simulated time, s. Only with a controller.
        vary: Key of the rig file -> its values, such as ``{"well.friction_intervals[1].factor": [0.8, 1.0]}``.
        target: Toolface that a controller holds, rad.
        seed: Seed of the sensor noise of run 0; run k has ``seed + k``.
        elements: Elements of the string.
        workers: Threads, used with commands.
        progress: Called with the number of runs that have ended.

    Raises:
        InputError: An argument cannot be used; the message names it.
    """
    varied, labels = _rigs(rigs, vary)
    if isinstance(drive, Commands):
        if duration is not None:
            raise InputError("batch: duration: commands have their own; leave it out")
        check_seed(seed, "batch")
        check_elements(elements, "batch")
        for rig in varied:
            check_commands(rig, drive, "batch")
        runs = _simulate_together(varied, drive, seed, elements, workers)
        progress(len(runs))
        return Batch(runs, labels)
    if not (isinstance(drive, (str, type)) or callable(drive)):
        raise InputError("batch: give the controller's class, not one controller: every run needs its own")
    slides = []
    for index, rig in enumerate(varied):
        slides.append(simulate(rig, drive, duration, target=target, seed=seed + index, elements=elements))
        progress(index + 1)
    return Batch(tuple(slides), labels)


def _rigs(
    rigs: Rig | Sequence[Rig], vary: Mapping[str, Sequence[Any]] | None
) -> tuple[list[Rig], tuple[dict[str, Any], ...]]:
    if vary is None:
        given = [rigs] if isinstance(rigs, Rig) or not isinstance(rigs, Iterable) else list(rigs)
        if not given:
            raise InputError("batch: no rigs: give at least one")
        for rig in given:
            check_rig(rig, "batch")
        return given, tuple({} for _ in given)
    if not isinstance(rigs, Rig):
        raise InputError("batch: vary: needs one rig to vary, not several")
    if not isinstance(vary, Mapping):
        raise InputError(f"batch: vary: {type(vary).__name__}; give a dict of keys, each with a list of values")
    for key, choices in vary.items():
        if isinstance(choices, str) or not isinstance(choices, Iterable):
            raise InputError(f"batch: vary: {key}: {choices!r}; give a list of values")
    combinations = [dict(zip(vary, values, strict=True)) for values in itertools.product(*vary.values())]
    if not combinations:
        raise InputError("batch: vary: one of its lists is empty")
    return [rigs.with_(values) for values in combinations], tuple(combinations)


def _simulate_together(rigs: list[Rig], commands: Commands, seed: int, elements: int, workers: int) -> tuple[Run, ...]:
    """Rigs with the same well and string share one call of the plant."""
    groups: dict[Any, list[int]] = defaultdict(list)
    for index, rig in enumerate(rigs):
        groups[rig.well.survey, rig.string.sections, rig.contact, rig.mud.sound_speed].append(index)
    responses: dict[int, Response] = {}
    for indices in groups.values():
        simulated = drillstring.simulate_batch([rigs[i] for i in indices], commands, elements, workers=workers)
        responses.update(zip(indices, map(require_finite, simulated), strict=True))
    return tuple(_run(rig, commands, responses[k], seed + k, f"run {k}") for k, rig in enumerate(rigs))


def _run(rig: Rig, commands: Commands, response: Response, seed: int, source: str) -> Run:
    log = build_log(rig, commands, response, sample_sensors(rig, response, seed), (), source)
    return Run(rig, commands, response, log, "commands")
