"""A log beside the plant driven by its commands."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from slider_drilling.api.simulate import Run
from slider_drilling.columns import Columns, SampledQuantity, join_samples
from slider_drilling.diagnosis import replay as engine
from slider_drilling.drillstring import ELEMENTS
from slider_drilling.drillstring.simulated_log import write_simulated
from slider_drilling.log import RigLog, read_log
from slider_drilling.rig import Rig

if TYPE_CHECKING:
    import pandas
    import plotly


@dataclass(frozen=True, repr=False)
class ReplayResult:
    """A replay: the log, the rig that was simulated, and what `diagnosis.replay` found."""

    log: RigLog
    rig: Rig
    replay: engine.Replay

    @property
    def rms(self) -> dict[str, float]:
        """RMS difference of each channel, SI units."""
        return {name: one.rms for name, one in self.replay.channels.items()}

    @property
    def rms_over_noise(self) -> dict[str, float | None]:
        """The same over the noise that the rig file declares, None where it declares none."""
        return {name: one.rms_over_noise for name, one in self.replay.channels.items()}

    def __repr__(self) -> str:
        told = (f"{name} {one.rms:.4g} {one.channel.unit}" for name, one in self.replay.channels.items())
        return f"ReplayResult({self.log.source}: RMS difference {', '.join(told)})"

    def columns(self) -> Columns:
        """``measured_NAME`` and ``simulated_NAME`` of each channel against time."""
        found = []
        for name, one in self.replay.channels.items():
            channel = one.channel
            found += [SampledQuantity(f"measured_{name}", channel.unit, channel.time, channel.measured),
                      SampledQuantity(f"simulated_{name}", channel.unit, channel.time, one.simulated)]
        return join_samples(found)

    def to_frame(self) -> pandas.DataFrame:
        """`columns` as a pandas DataFrame. Raises InputError."""
        return self.columns().to_frame()

    def to_csv(self, path: str | os.PathLike[str]) -> Path:
        """`columns` as CSV. Raises InputError."""
        return self.columns().to_csv(path)

    def to_parquet(self, path: str | os.PathLike[str]) -> Path:
        """`columns` as Parquet. Raises InputError."""
        return self.columns().to_parquet(path)

    def save(self, path: str | os.PathLike[str]) -> Path:
        """The simulated channels as an MCAP log. Raises InputError."""
        write_simulated(Path(path), self.rig, self.replay.commands, self.replay.response, self.log.start,
                        f"replay of {self.log.source}")
        return Path(path)

    def plot(self, channel: str = "surface_torque") -> plotly.graph_objects.Figure:
        """One channel measured and simulated against time, SI units; its name is a key of `rms`."""
        from slider_drilling.api.plots import lines

        one = self.replay.channels[channel]
        named = [("measured", one.channel.time, one.channel.measured), ("simulated", one.channel.time, one.simulated)]
        return lines(named, "time, s", f"{channel.replace('_', ' ')}, {one.channel.unit}")


def replay(
    log: str | os.PathLike[str] | RigLog | Run,
    rig: Rig | None = None,
    *,
    elements: int = ELEMENTS,
    namespace: str | None = None,
) -> ReplayResult:
    """Drive the plant with a log's commands from its first sample and compare channel by channel.

    log: a path, a log or a run; rig: in place of the log's own; namespace: whose topics to read, of a path.
    Raises InputError.
    """
    record = as_log(log, namespace)
    simulated = record.rig() if rig is None else rig
    return ReplayResult(record, simulated, engine.replay(record, simulated, elements))


def as_log(log: str | os.PathLike[str] | RigLog | Run, namespace: str | None = None) -> RigLog:
    """The log that a path, a log or a run means. Raises InputError."""
    if isinstance(log, Run):
        return log.log
    return log if isinstance(log, RigLog) else read_log(log, namespace=namespace)
