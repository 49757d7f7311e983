"""Many slides that differ in the rig, side by side."""

from __future__ import annotations

import itertools
import os
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from slider_drilling import drillstring
from slider_drilling.api.checks import check_commands, check_elements, check_seed
from slider_drilling.api.simulate import UNITS, Run, simulate
from slider_drilling.api.simulated_log import build_log, sample_sensors
from slider_drilling.columns import Columns
from slider_drilling.control.interface import Controller
from slider_drilling.drillstring import ELEMENTS, Commands, Response
from slider_drilling.drillstring.recorded_channels import require_finite
from slider_drilling.errors import InputError
from slider_drilling.rig import Rig

if TYPE_CHECKING:
    import pandas
    import plotly


@dataclass(frozen=True, repr=False)
class Batch:
    """Runs in the order of their rigs; labels: of each run, what was varied and its value there."""

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
        """One below the other: run number, what was varied, time and the noise-free channels of each."""
        lengths = [len(one.response.time) for one in self.runs]
        values = {"run": np.repeat(np.arange(len(self.runs)), lengths)}
        for name in self.labels[0]:
            values[name] = np.repeat(np.array([label[name] for label in self.labels]), lengths)
        for name in ("time", *UNITS):
            parts = (one.response if hasattr(one.response, name) else one.commands for one in self.runs)
            values[name] = np.concatenate([getattr(part, name) for part in parts])
        return Columns(values, {"time": "s", **UNITS})

    def to_frame(self) -> pandas.DataFrame:
        """`columns` as a pandas DataFrame over the run's number, SI units. Raises InputError."""
        return self.columns().to_frame()

    def to_csv(self, path: str | os.PathLike[str]) -> Path:
        """`columns` as CSV, units in its heads. Raises InputError."""
        return self.columns().to_csv(path)

    def to_parquet(self, path: str | os.PathLike[str]) -> Path:
        """`columns` as Parquet. Raises InputError."""
        return self.columns().to_parquet(path)

    def plot(self, channel: str = "surface_torque") -> plotly.graph_objects.Figure:
        """One channel of every run against time, SI units. Raises InputError for a channel that runs do not have."""
        from slider_drilling.api.plots import lines

        if channel not in UNITS:
            raise InputError(f"plot: channel = {channel!r}: one of {', '.join(UNITS)}")
        named = [
            (", ".join(f"{name} {value:.4g}" if isinstance(value, float) else f"{name} {value}"
                       for name, value in label.items()) or f"run {index}", run)
            for index, (label, run) in enumerate(zip(self.labels, self.runs, strict=True))
        ]
        held = [(name, run.response.time, getattr(run.response if hasattr(run.response, channel) else run.commands,
                                                  channel)) for name, run in named]
        return lines(held, "time, s", f"{channel.replace('_', ' ')}, {UNITS[channel]}")


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
    """`simulate` for several rigs, or for one rig with every combination of the values in ``vary``.

    vary: path of a rig-file value -> its values, such as ``{"well.friction_intervals[1].factor": [0.8, 1.0]}``.
    Commands run through the plant side by side on ``workers`` threads where wells and strings are the same, much
    faster than one by one. A controller is given by its class, a function of the rig, or its name: every run gets
    a new one. Run k has the sensor seed ``seed + k``. Raises InputError.
    """
    made, labels = _rigs(rigs, vary)
    if isinstance(drive, Commands):
        if duration is not None:
            raise InputError("batch: duration: commands have their own; leave it out")
        check_seed(seed, "batch")
        check_elements(elements, "batch")
        for rig in made:
            check_commands(rig, drive, "batch")
        runs = _side_by_side(made, drive, seed, elements, workers)
        progress(len(runs))
        return Batch(runs, labels)
    if not (isinstance(drive, (str, type)) or callable(drive)):
        raise InputError("batch: give the controller's class, not one controller: every run needs its own")
    slid = []
    for index, rig in enumerate(made):
        slid.append(simulate(rig, drive, duration, target=target, seed=seed + index, elements=elements))
        progress(index + 1)
    return Batch(tuple(slid), labels)


def _rigs(
    rigs: Rig | Sequence[Rig], vary: Mapping[str, Sequence[Any]] | None
) -> tuple[list[Rig], tuple[dict[str, Any], ...]]:
    if vary is None:
        made = [rigs] if isinstance(rigs, Rig) else list(rigs)
        if not made:
            raise InputError("batch: no rigs: give at least one")
        return made, tuple({} for _ in made)
    if not isinstance(rigs, Rig):
        raise InputError("batch: vary: needs one rig to vary, not several")
    combinations = [dict(zip(vary, values, strict=True)) for values in itertools.product(*vary.values())]
    if not combinations:
        raise InputError("batch: vary: one of its lists is empty")
    return [rigs.with_(values) for values in combinations], tuple(combinations)


def _side_by_side(rigs: list[Rig], commands: Commands, seed: int, elements: int, workers: int) -> tuple[Run, ...]:
    """Rigs of one well and string together, the others apart."""
    alike: dict[Any, list[int]] = defaultdict(list)
    for index, rig in enumerate(rigs):
        alike[rig.well.survey, rig.string.sections, rig.contact, rig.mud.sound_speed].append(index)
    responses: dict[int, Response] = {}
    for indices in alike.values():
        found = drillstring.simulate_batch([rigs[i] for i in indices], commands, elements, workers=workers)
        responses.update(zip(indices, map(require_finite, found), strict=True))
    return tuple(_run(rig, commands, responses[k], seed + k, f"run {k}") for k, rig in enumerate(rigs))


def _run(rig: Rig, commands: Commands, response: Response, seed: int, source: str) -> Run:
    log = build_log(rig, commands, response, sample_sensors(rig, response, seed), (), source)
    return Run(rig, commands, response, log, "commands")
