"""`simulate`: one slide, driven by commands or by a controller."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from slider_drilling import drillstring
from slider_drilling.api.checks import check_commands, check_rig, check_run
from slider_drilling.api.simulated_log import SURFACE_SENSORS, SensorReadings, build_log, sample_sensors
from slider_drilling.columns import Columns, SampledQuantity, TableExport, join_samples
from slider_drilling.control.controller_loader import checked_step, load_controller, set_tool_face_target
from slider_drilling.control.interface import Controller, MwdSample
from slider_drilling.drillstring import ELEMENTS, Commands, InitialState, Response, VirtualRig
from slider_drilling.drillstring.kernel_arrays import Array
from slider_drilling.drillstring.recorded_channels import require_finite
from slider_drilling.errors import InputError
from slider_drilling.log import TOPICS, RigLog, save_log
from slider_drilling.programmes import Programme, dump_programme
from slider_drilling.programmes.controller import ProgrammeController
from slider_drilling.programmes.find_programme import FoundProgramme, find_programme
from slider_drilling.programmes.open_loop import check_simulated_start
from slider_drilling.programmes.progress import ProgrammeProgress
from slider_drilling.programmes.rig_check import check_start_depth
from slider_drilling.rig import Rig
from slider_drilling.schema.quantity_text import read_quantity
from slider_drilling.units import SI, Units

if TYPE_CHECKING:
    import plotly

    from slider_drilling.log.run_summary import RunSummary

ProgrammeSource = Programme | str | os.PathLike[str]
"""A programme, the path of its file or of a slide sheet, or ``"commissioning"`` or ``"stand"``."""

Drive = Commands | Controller | Callable[[Rig], Controller] | str
"""What may drive a run: commands, a controller, its class, a function of the rig, or ``"module:Class"``."""

_COLUMN_UNITS = {quantity.column: quantity.unit for topic in TOPICS.values() for quantity in topic.quantities}
UNITS = {
    part.name: {**_COLUMN_UNITS, "differential_pressure": "Pa"}[part.name]
    for part in (*fields(Commands)[1:], *fields(Response)[1:])
}


@dataclass(frozen=True, repr=False)
class Run(TableExport):
    """A simulated slide.

    Attributes:
        rig: The rig that was simulated.
        commands: Motion of top drive, block and pump.
        response: What the rig did, without noise.
        log: What a recorder would hold: sensor readings, and the rig file that the controller was given.
        driven_by: Name of the controller, or "commands".
        progress: How far a programme came; None where none was run.
    """

    rig: Rig
    commands: Commands
    response: Response
    log: RigLog
    driven_by: str
    progress: ProgrammeProgress | None = None

    def __repr__(self) -> str:
        torque = self.response.surface_torque / 1e3
        seconds = self.response.time[-1] - self.response.time[0]
        return (f"Run({seconds:.1f} s of {self.rig.string.length:g} m of string driven by {self.driven_by}: "
                f"surface torque {torque.min():.1f} to {torque.max():.1f} kN m, "
                f"bit {self.response.bit_depth[-1] - self.response.bit_depth[0]:.2f} m deeper)")

    def summary(self) -> RunSummary:
        """Toolface error, torque, hole made, and other figures that a directional driller asks for first."""
        from slider_drilling.log.run_summary import summarise_run

        return summarise_run(self.log)

    def channel(self, name: str) -> Array:
        """A noise-free channel, (n,) in SI units; the name is a key of `UNITS`."""
        channel: Array = getattr(self.response if hasattr(self.response, name) else self.commands, name)
        return channel

    def columns(self) -> Columns:
        """Commands and response, sensor readings as ``measured_...``, and toolfaces at the time of measurement."""
        time = self.response.time - self.response.time[0]
        parts = [(self.commands, field.name) for field in fields(Commands)[1:]]
        parts += [(self.response, field.name) for field in fields(Response)[1:]]  # type: ignore[misc]
        quantities = [SampledQuantity(name, UNITS[name], time, getattr(part, name)) for part, name in parts]
        log = self.log
        if log.top_drive is not None and log.draw_works is not None and log.standpipe_pressure is not None:
            quantities += [SampledQuantity("measured_surface_torque", "N m", time, log.top_drive.effort),
                      SampledQuantity("measured_hook_load", "N", time, log.draw_works.effort),
                      SampledQuantity("measured_standpipe_pressure", "Pa", time, log.standpipe_pressure.value)]
        for name in ("mwd_tool_face", "tool_face_target"):
            series = getattr(log, name)
            if series is not None:
                quantities.append(SampledQuantity(name, "rad", series.time, series.position))
        return join_samples(quantities)

    def save(self, path: str | os.PathLike[str], notes: str = "") -> Path:
        """Write the log as MCAP, as a recorder would; returns the path.

        Raises:
            InputError: The file cannot be written.
        """
        save_log(self.log, path, recorded_by="slider_drilling.simulate", notes=notes)
        return Path(path)

    def save_page(self, path: str | os.PathLike[str], units: Units = SI) -> Path:
        """Write summary and figures as one HTML file of less than a megabyte; for the arguments see `RigLog`."""
        return self.log.save_page(path, units)

    def plot(self, units: Units = SI) -> plotly.graph_objects.Figure:
        """The log's panels over time.

        Raises:
            InputError: plotly is not installed.
        """
        return self.log.plot(units)


def simulate(
    rig: Rig,
    drive: Drive | None = None,
    duration: float | None = None,
    *,
    programme: ProgrammeSource | None = None,
    target: float | str = 0.0,
    seed: int = 0,
    elements: int = ELEMENTS,
    start: InitialState = InitialState(),
    nominal: Rig | None = None,
) -> Run:
    """Simulate a slide.

    Args:
        rig: The rig to simulate.
        drive: `Commands`, or a controller: an object with ``step``, its class, a function of the rig, or
            ``"module:Class"``. A controller is limited by the drives and sees what the sensors read.
        duration: Simulated time, s. Required with a controller; commands have their own, and a programme its end.
        programme: What to run in place of a drive: a `Programme`, the path of its file or of a slide sheet, or the name
            of a built-in one, ``"commissioning"`` or ``"stand"``.
        target: Toolface that a controller holds, rad, or a text with its unit such as ``"45 deg"``.
        seed: Seed of the sensor noise.
        elements: Elements of the string.
        start: Twist and toolface of the string at the start.
        nominal: Rig file that the controller and the log get. The simulated one if None.

    Raises:
        InputError: An argument cannot be used; the message names it.
    """
    known = rig if nominal is None else nominal
    check_rig(rig, "simulate")
    check_rig(known, "simulate: nominal")
    if isinstance(target, str):
        target = read_quantity(target, "rad", "simulate: target")
    if (drive is None) == (programme is None):
        raise InputError("simulate: give a drive (commands or a controller) or a programme, one of them")
    if programme is not None:
        if target != 0.0:
            raise InputError("simulate: target: a programme gives the toolface of each slide; leave it out")
        return _run_programme(rig, known, programme, duration, seed, elements, start)
    if isinstance(drive, Commands):
        if duration is not None:
            raise InputError("simulate: duration: commands have their own; leave it out, or cut the commands")
        check_commands(rig, drive, "simulate")
        check_run(rig, float(drive.time[-1] - drive.time[0]), target, seed, elements, start, "simulate")
        response = require_finite(drillstring.simulate(rig, drive, elements, start))
        log = build_log(known, drive, response, sample_sensors(rig, response, seed), (), "simulation")
        return Run(rig, drive, response, log, "commands")
    if duration is None:
        raise InputError("simulate: duration is missing: a controller needs one, in s")
    check_run(rig, duration, target, seed, elements, start, "simulate")
    assert drive is not None
    controller = build_controller(drive, known)
    return _slide(rig, known, controller, duration, target, seed, elements, start)


def build_controller(drive: Controller | Callable[[Rig], Controller] | str, rig: Rig) -> Controller:
    """A controller for this rig.

    Args:
        drive: A controller, its class, a function of the rig, or ``"module:Class"``.
        rig: The rig file that the controller is built for.

    Raises:
        InputError: ``drive`` is none of these, or the controller cannot be built.
    """
    if isinstance(drive, str):
        return load_controller(drive, rig)
    # A class with a method `step` satisfies the protocol too, so classes are built first.
    if isinstance(drive, type) or (callable(drive) and not hasattr(drive, "step")):
        drive = drive(rig)
    if not isinstance(drive, Controller):
        raise InputError(f"simulate: {type(drive).__name__} drives nothing: give Commands, or an object with step()")
    return drive


def _run_programme(
    rig: Rig, known: Rig, source: ProgrammeSource, duration: float | None, seed: int, elements: int,
    start: InitialState,
) -> Run:  # fmt: skip
    """Step a programme's controller until it has ended, or for a duration, s."""
    found = FoundProgramme(source, None) if isinstance(source, Programme) else find_programme(source)
    name = "programme" if isinstance(source, Programme) else str(source)
    check_start_depth(found.start, known, name)
    check_simulated_start(found.programme, name)
    controller = ProgrammeController(known, found.programme, name)
    longest = controller.longest_time if duration is None else duration
    check_run(rig, longest, 0.0, seed, elements, start, "simulate")
    run = _slide(rig, known, controller, longest, None, seed, elements, start, lambda: controller.ended)
    log = dataclasses.replace(run.log, programme_text=dump_programme(found.programme))
    return dataclasses.replace(run, log=log, progress=controller.progress())


def _slide(
    rig: Rig,
    known: Rig,
    controller: Controller,
    duration: float,
    target: float | None,
    seed: int,
    elements: int,
    start: InitialState,
    ended: Callable[[], bool] = lambda: False,
) -> Run:
    """Step the controller; ``known`` is the rig file that the log gets; a target of None is the controller's own."""
    virtual = VirtualRig(rig, seed, elements, start)
    if target is not None:
        set_tool_face_target(controller, target)
    targets: list[tuple[float, float]] = [] if target is None else [(0.0, target)]
    measurements, truths = [virtual.measurements], [virtual.truth]
    samples: list[MwdSample] = []
    for _ in range(round(duration / virtual.interval)):
        measurements.append(virtual.step(checked_step(controller, measurements[-1])))
        truths.append(virtual.truth)
        samples += measurements[-1].mwd
        held = getattr(controller, "held_tool_face", None)
        if held is not None and (not targets or targets[-1][1] != held):
            targets.append((measurements[-1].time, held))
        if ended():
            break
    commands = Commands(*(_column(measurements, field.name) for field in fields(Commands)))
    response = Response(*(_column(truths, field.name) for field in fields(Response)))
    surface = {name: _column(measurements, name) for name in SURFACE_SENSORS}
    name = type(controller).__name__
    readings = SensorReadings(surface, tuple(samples))
    log = build_log(known, commands, response, readings, targets, f"simulation by {name}")
    return Run(rig, commands, response, log, name)


def _column(samples: Sequence[object], name: str) -> Array:
    return np.array([getattr(sample, name) for sample in samples])
