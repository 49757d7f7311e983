"""Simulator, controller, recorder and twin in one process, with the same nodes and topics as in three."""

from __future__ import annotations

import contextlib
import functools
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import rclpy

from slider_drilling.files.installed_files import installed_file
from slider_drilling.live.server import Address
from slider_drilling.nodes.friction_simulator import FrictionSimulator
from slider_drilling.nodes.recorder import Recorder
from slider_drilling.nodes.rig_parameter import EXAMPLE
from slider_drilling.nodes.rocking_controller import RockingController
from slider_drilling.nodes.run_node import init
from slider_drilling.nodes.shutdown import ShutdownRequest
from slider_drilling.nodes.spin import drain, node_maker, spin
from slider_drilling.process.shutdown import TerminationSignal
from slider_drilling.programmes.progress import ProgrammeProgress


@dataclass(frozen=True)
class SessionOptions:
    """What to run.

    Attributes:
        rig: Path of the rig file that controller and log get; empty: the example well.
        plant: Path of the rig file to simulate, if it is another one.
        duration: Simulated time, s; 0: until interrupted.
        speed: Simulated seconds per second; 0: in lockstep.
        record: Folder of the log; None: no log.
        target: Toolface to hold, rad.
        controller: As `module:Class`; None: the default controller.
        seed: Of the sensor noise.
        elements: Of the drill string.
        programme: Path of the programme to run in place of a controller; empty: none. The run ends with it.
        settings: Of the controller.
        notes: For the log's metadata.
        live: Where to serve the live page; None: nowhere.
        units: Of the live page, si or field.
        twin: Whether a twin runs beside the rig.
    """

    rig: str = ""
    plant: str = ""
    duration: float = 300.0
    speed: float = 0.0
    record: Path | None = None
    target: float | None = None
    controller: str | None = None
    seed: int = 0
    elements: int = 200
    programme: str = ""
    settings: Mapping[str, float] = field(default_factory=dict)
    notes: str = ""
    live: Address | None = None
    units: str = "si"
    twin: bool = False


@dataclass(frozen=True)
class SessionResult:
    """What a run gave.

    Attributes:
        log: Path of the log; None if there is none.
        simulated: Simulated time, s.
        wall: Wall time, s.
        messages: In the log.
        signal: Number of the signal that ended the run, or 0.
        programme: How far the programme came; None where none ran.
    """

    log: Path | None
    simulated: float
    wall: float
    messages: int
    signal: int
    programme: ProgrammeProgress | None = None


def run_session(
    options: SessionOptions,
    progress: Callable[[float], None] = lambda simulated: None,
    announce: Callable[[str], None] = lambda address: None,
) -> SessionResult:
    """Run simulator, controller, recorder and twin until the duration is over or a signal comes.

    Args:
        options: What to run.
        progress: Called with the simulated time, s, about ten times a second.
        announce: Called with the live page's address once it is served.

    Raises:
        InputError: A rig file, controller, parameter or folder cannot be used.
    """
    # `options` configure the nodes of this process; `--ros-args` are for nodes that run alone.
    init(["slider-drilling"])
    shutdown_request = ShutdownRequest()
    shutdown_request.raise_on_signals(TerminationSignal)
    try:
        with contextlib.ExitStack() as ending:
            return _run(options, progress, announce, shutdown_request, ending)
    finally:
        rclpy.try_shutdown()
        shutdown_request.restore_handlers()


def _run(
    options: SessionOptions,
    progress: Callable[[float], None],
    announce: Callable[[str], None],
    shutdown_request: ShutdownRequest,
    ending: contextlib.ExitStack,
) -> SessionResult:
    make = node_maker(shutdown_request, ending)
    # The simulator first: if another rig is simulated already, that one is not recorded.
    simulator = _make_simulator(make, options)
    recorder: Recorder | None = None
    if options.record is not None:
        shutdown_request.take_signals()  # its constructor opens a file, which must be closed
        rig = _attached_rig(options)
        recorder = make(Recorder, directory=str(options.record), rig=rig, programme=options.programme,
                        notes=options.notes, use_sim_time=True)  # fmt: skip
        ending.push(functools.partial(_finish, recorder))
        shutdown_request.raise_on_signals(TerminationSignal)
    dashboard = None if options.live is None else _make_dashboard(make, options.live, options.units, announce)
    twin = _make_twin(make, options) if options.twin else None
    controller = _make_controller(make, options)
    reporting = [node for node in (simulator, recorder, twin, controller) if node is not None]
    nodes = reporting if dashboard is None else [*reporting, dashboard]
    if recorder is not None:
        # A subscription that is connected receives all messages in the order in which they were sent.
        simulator.may_start = functools.partial(recorder.is_connected, len(reporting))
    shutdown_request.take_signals()
    start = time.perf_counter()
    executor = spin(nodes, shutdown_request, lambda: progress(simulator.simulated))
    ending.callback(executor.shutdown)
    wall = time.perf_counter() - start
    progress(simulator.simulated)
    if recorder is None:
        shutdown_request.raise_error()
        return SessionResult(None, simulator.simulated, wall, 0, shutdown_request.signal, controller.programme_progress)
    drain(executor, lambda: recorder.messages)
    shutdown_request.raise_error()
    signal, progress_made = shutdown_request.signal, controller.programme_progress
    return SessionResult(recorder.path, simulator.simulated, wall, recorder.messages, signal, progress_made)


def _make_simulator(make: Callable[..., Any], options: SessionOptions) -> Any:
    return make(
        FrictionSimulator,
        rig=options.plant or options.rig,
        speed=float(options.speed),
        duration=float(options.duration),
        seed=options.seed,
        elements=options.elements,
        wait_for_controller=True,
        minimum_subscribers=1 + (options.record is not None) + (options.live is not None) + options.twin,
    )


def _make_controller(make: Callable[..., Any], options: SessionOptions) -> Any:
    return make(
        RockingController,
        rig=options.rig,
        use_sim_time=True,
        tool_face_target=options.target,
        controller=options.controller,
        programme=options.programme or None,
        end_with_programme=True if options.programme else None,
        **options.settings,
    )


def _make_twin(make: Callable[..., Any], options: SessionOptions) -> Any:
    from slider_drilling.nodes.twin import TwinNode

    return make(TwinNode, rig=options.rig, use_sim_time=True)


def _attached_rig(options: SessionOptions) -> str:
    """Path of the rig file for the log: never that of a plant that differs from it."""
    return str(installed_file(EXAMPLE)) if options.plant and not options.rig else options.rig


def _make_dashboard(
    make: Callable[..., Any], address: Address, units: str, announce: Callable[[str], None]
) -> Any:
    from slider_drilling.nodes.dashboard import Dashboard

    dashboard = make(Dashboard, host=address.host, port=address.port, token_file=address.token_file, units=units)
    announce(dashboard.url)
    return dashboard


def _finish(recorder: Recorder, kind: type[BaseException] | None, error: BaseException | None, trace: object) -> None:
    """Close the log; delete it if the run failed before the first message."""
    if error is not None and recorder.messages == 0:
        recorder.discard()
    else:
        recorder.close()
