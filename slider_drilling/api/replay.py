"""`replay`: drive the plant with a log's commands and compare."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from slider_drilling.api.checks import check_elements, check_rig
from slider_drilling.api.simulate import Run
from slider_drilling.columns import Columns, SampledQuantity, TableExport, join_samples
from slider_drilling.diagnosis import replay as engine
from slider_drilling.drillstring import ELEMENTS
from slider_drilling.drillstring.simulated_log import write_simulated
from slider_drilling.log import RigLog, read_log
from slider_drilling.plain_names import plain_name
from slider_drilling.rig import Rig
from slider_drilling.units import SI, Units

if TYPE_CHECKING:
    import plotly


@dataclass(frozen=True, repr=False)
class ReplayResult(TableExport):
    """A log beside its simulation.

    Attributes:
        log: The log.
        rig: The rig that was simulated.
        replay: Commands, response and channels of the simulation.
    """

    log: RigLog
    rig: Rig
    replay: engine.Replay

    @property
    def rms(self) -> dict[str, float]:
        """RMS difference of each channel, SI units."""
        return {name: channel.rms for name, channel in self.replay.channels.items()}

    @property
    def rms_over_noise(self) -> dict[str, float | None]:
        """RMS difference over the noise that the rig file declares, None where it declares none."""
        return {name: channel.rms_over_noise for name, channel in self.replay.channels.items()}

    def __repr__(self) -> str:
        differences = (f"{name} {compared.rms:.4g} {compared.channel.unit}"
                       for name, compared in self.replay.channels.items())
        return f"ReplayResult({self.log.source}: RMS difference {', '.join(differences)})"

    def columns(self) -> Columns:
        """``measured_NAME`` and ``simulated_NAME`` of each channel against time."""
        quantities = []
        for name, compared in self.replay.channels.items():
            channel = compared.channel
            quantities += [SampledQuantity(f"measured_{name}", channel.unit, channel.time, channel.measured),
                      SampledQuantity(f"simulated_{name}", channel.unit, channel.time, compared.simulated)]  # fmt: skip
        return join_samples(quantities)

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write the simulated channels as an MCAP log; returns the path.

        Raises:
            InputError: The file cannot be written.
        """
        write_simulated(Path(path), self.rig, self.replay.commands, self.replay.response, self.log.start,
                        f"replay of {self.log.source}")
        return Path(path)

    def save_page(self, path: str | os.PathLike[str], units: Units = SI) -> Path:
        """Write measured and simulated channels as one HTML file of less than a megabyte; returns its path.

        Args:
            path: The file.
            units: `slider_drilling.units.SI` or `FIELD`.

        Raises:
            InputError: The file cannot be written.
        """
        from slider_drilling.diagnosis.replay_page import replay_page
        from slider_drilling.pages import write_page

        write_page(Path(path), replay_page(self.log, self.replay, units), units)
        return Path(path)

    def plot(self, channel: str = "surface_torque") -> plotly.graph_objects.Figure:
        """One channel, measured and simulated, against time in SI units; the name is a key of `rms`."""
        from slider_drilling.api.plots import lines

        compared = self.replay.channels[channel]
        measured = compared.channel
        curves = [("measured", measured.time, measured.measured), ("simulated", measured.time, compared.simulated)]
        return lines(curves, "time, s", f"{plain_name(channel)}, {measured.unit}")


def replay(
    log: str | os.PathLike[str] | RigLog | Run,
    rig: Rig | None = None,
    *,
    elements: int = ELEMENTS,
    namespace: str | None = None,
    topics: str | os.PathLike[str] | None = None,
) -> ReplayResult:
    """Drive the plant with a log's commands from its first sample, and compare each channel.

    Args:
        log: A path, a log or a run.
        rig: The rig to simulate; the log's own rig file if None.
        elements: Elements of the string.
        namespace: Namespace of the topics, if ``log`` is a path to a log of several rigs.
        topics: Topics file, if ``log`` is a path to a log whose topics have other names.

    Raises:
        InputError: The log cannot be read or replayed.
    """
    check_elements(elements, "replay")
    record = as_log(log, namespace, topics)
    simulated = record.rig() if rig is None else rig
    check_rig(simulated, "replay")
    return ReplayResult(record, simulated, engine.replay(record, simulated, elements))


def as_log(
    log: str | os.PathLike[str] | RigLog | Run,
    namespace: str | None = None,
    topics: str | os.PathLike[str] | None = None,
) -> RigLog:
    """The log itself, the log of a run, or the log at a path. Raises InputError."""
    if isinstance(log, Run):
        return log.log
    return log if isinstance(log, RigLog) else read_log(log, namespace=namespace, topics=topics)
