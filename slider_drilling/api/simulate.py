"""One simulated slide: the plant driven by commands, or a whole virtual rig by a controller."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from slider_drilling import drillstring
from slider_drilling.api.checks import check_commands, check_run
from slider_drilling.api.simulated_log import SensorReadings, build_log, sample_sensors
from slider_drilling.columns import Columns, SampledQuantity, join_samples
from slider_drilling.control.controller_loader import checked_step, load_controller, set_tool_face_target
from slider_drilling.control.interface import Controller, MwdSample
from slider_drilling.drillstring import ELEMENTS, Commands, InitialState, Response, VirtualRig
from slider_drilling.drillstring.recorded_channels import require_finite
from slider_drilling.errors import InputError
from slider_drilling.log import RigLog, save_log
from slider_drilling.rig import Rig

if TYPE_CHECKING:
    import pandas
    import plotly

    from slider_drilling.log.run_summary import RunSummary

Drive = Commands | Controller | Callable[[Rig], Controller] | str
"""What may drive a run: commands, a controller, its class or a function of the rig, or its name, module:Class."""

UNITS = {
    "top_drive_angle": "rad", "top_drive_speed": "rad/s", "block_position": "m", "block_speed": "m/s",
    "pump_speed": "rad/s", "surface_torque": "N m", "hook_load": "N", "standpipe_pressure": "Pa", "tool_face": "rad",
    "tool_face_rate": "rad/s", "bit_torque": "N m", "weight_on_bit": "N", "differential_pressure": "Pa",
    "bit_depth": "m", "rate_of_penetration": "m/s",
}  # fmt: skip


@dataclass(frozen=True, repr=False)
class Run:
    """A simulated slide.

    rig: what was simulated; commands: what moved it; response: what it did, free of noise; log: what a recorder
    would hold, sensor readings included, with the rig file that the controller was given.
    """

    rig: Rig
    commands: Commands
    response: Response
    log: RigLog
    driven_by: str

    def __repr__(self) -> str:
        torque = self.response.surface_torque / 1e3
        seconds = self.response.time[-1] - self.response.time[0]
        return (f"Run({seconds:.1f} s of {self.rig.string.length:g} m of string driven by {self.driven_by}: "
                f"surface torque {torque.min():.1f} to {torque.max():.1f} kN m, "
                f"bit {self.response.bit_depth[-1] - self.response.bit_depth[0]:.2f} m deeper)")

    def summary(self) -> RunSummary:
        """What happened, in the figures that a directional driller asks for first."""
        from slider_drilling.log.run_summary import summarise_run

        return summarise_run(self.log)

    def columns(self) -> Columns:
        """Commands and response, the sensors' readings as ``measured_...``, toolfaces when they were measured."""
        time = self.response.time - self.response.time[0]
        parts = [(self.commands, one.name) for one in fields(Commands)[1:]]
        parts += [(self.response, one.name) for one in fields(Response)[1:]]  # type: ignore[misc]
        found = [SampledQuantity(name, UNITS[name], time, getattr(part, name)) for part, name in parts]
        log = self.log
        if log.top_drive is not None and log.draw_works is not None and log.standpipe_pressure is not None:
            found += [SampledQuantity("measured_surface_torque", "N m", time, log.top_drive.effort),
                      SampledQuantity("measured_hook_load", "N", time, log.draw_works.effort),
                      SampledQuantity("measured_standpipe_pressure", "Pa", time, log.standpipe_pressure.value)]
        for name in ("mwd_tool_face", "tool_face_target"):
            series = getattr(log, name)
            if series is not None:
                found.append(SampledQuantity(name, "rad", series.time, series.position))
        return join_samples(found)

    def to_frame(self) -> pandas.DataFrame:
        """`columns` as a pandas DataFrame over time, s; SI units, in ``attrs["units"]``. Raises InputError."""
        return self.columns().to_frame()

    def to_csv(self, path: str | os.PathLike[str]) -> Path:
        """`columns` as CSV, units in its heads. Raises InputError."""
        return self.columns().to_csv(path)

    def to_parquet(self, path: str | os.PathLike[str]) -> Path:
        """`columns` as Parquet. Raises InputError."""
        return self.columns().to_parquet(path)

    def save(self, path: str | os.PathLike[str], notes: str = "") -> Path:
        """Write the log as MCAP, as a recorder would. Raises InputError."""
        save_log(self.log, path, recorded_by="slider_drilling.simulate", notes=notes)
        return Path(path)

    def plot(self) -> plotly.graph_objects.Figure:
        """The log's panels over time, in field units. Raises InputError where plotly is not installed."""
        return self.log.plot()


def simulate(
    rig: Rig,
    drive: Drive,
    duration: float | None = None,
    *,
    target: float = 0.0,
    seed: int = 0,
    elements: int = ELEMENTS,
    start: InitialState = InitialState(),
    nominal: Rig | None = None,
) -> Run:
    """Simulate a slide on `rig`.

    drive: `Commands`, whose own duration counts; or a controller (an object with ``step``, its class, or
    ``"module:Class"``), stepped for ``duration`` s with the drives' limits and the sensors' errors. target: rad, the
    toolface that a controller is to hold; seed: of the sensors' noise; elements: of the string; believed: the rig
    file that a controller and the log get, where it is not the one simulated. Raises InputError.
    """
    told = rig if nominal is None else nominal
    if isinstance(drive, Commands):
        if duration is not None:
            raise InputError("simulate: duration: commands have their own; leave it out, or cut the commands")
        check_commands(rig, drive, "simulate")
        check_run(rig, float(drive.time[-1] - drive.time[0]), target, seed, elements, start, "simulate")
        response = require_finite(drillstring.simulate(rig, drive, elements, start))
        log = build_log(told, drive, response, sample_sensors(rig, response, seed), (), "simulation")
        return Run(rig, drive, response, log, "commands")
    if duration is None:
        raise InputError("simulate: duration is missing: a controller needs one, in s")
    check_run(rig, duration, target, seed, elements, start, "simulate")
    controller = build_controller(drive, told)
    return _slide(rig, told, controller, duration, target, seed, elements, start)


def build_controller(drive: Controller | Callable[[Rig], Controller] | str, rig: Rig) -> Controller:
    """The controller that `drive` means for this rig. Raises InputError."""
    if isinstance(drive, str):
        return load_controller(drive, rig)
    # A class with a method `step` passes for a controller too: it is built first.
    if isinstance(drive, type) or (callable(drive) and not hasattr(drive, "step")):
        drive = drive(rig)
    if not isinstance(drive, Controller):
        raise InputError(f"simulate: {type(drive).__name__} drives nothing: give Commands, or an object with step()")
    return drive


def _slide(
    rig: Rig,
    told: Rig,
    controller: Controller,
    duration: float,
    target: float,
    seed: int,
    elements: int,
    start: InitialState,
) -> Run:
    virtual = VirtualRig(rig, seed, elements, start)
    set_tool_face_target(controller, target)
    measurements, truths = [virtual.measurements], [virtual.truth]
    samples: list[MwdSample] = []
    for _ in range(round(duration / virtual.interval)):
        measurements.append(virtual.step(checked_step(controller, measurements[-1])))
        truths.append(virtual.truth)
        samples += measurements[-1].mwd
    commands = Commands(*(np.array([getattr(one, field.name) for one in measurements]) for field in fields(Commands)))
    response = Response(*(np.array([getattr(one, field.name) for one in truths]) for field in fields(Response)))
    surface = {name: np.array([getattr(one, name) for one in measurements])
               for name in ("surface_torque", "hook_load", "standpipe_pressure")}
    name = type(controller).__name__
    readings = SensorReadings(surface, tuple(samples))
    log = build_log(told, commands, response, readings, ((0.0, target),), f"simulation by {name}")
    return Run(rig, commands, response, log, name)
