"""Simulator, controller and recorder in one process: the same nodes and topics as three processes have."""

from __future__ import annotations

import contextlib
import functools
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import rclpy
from rclpy.parameter import Parameter

from slider_drilling.files.installed_files import installed_file
from slider_drilling.live.server import Address
from slider_drilling.nodes.friction_simulator import FrictionSimulator
from slider_drilling.nodes.recorder import Recorder
from slider_drilling.nodes.rig_parameter import EXAMPLE
from slider_drilling.nodes.rocking_controller import RockingController
from slider_drilling.nodes.run_node import init
from slider_drilling.nodes.shutdown import ShutdownRequest
from slider_drilling.nodes.spin import drain, spin
from slider_drilling.process.shutdown import TerminationSignal


@dataclass(frozen=True)
class SessionOptions:
    """What to run. rig, record: paths; duration: s, 0 for no end; speed: times real time, 0 for lockstep; target: rad.

    plant: path of the rig file that is simulated, where it is not the one that controller and log are told of;
    settings: of the controller; notes: for the log's metadata; live: where to serve the live page, if at all.
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
    settings: Mapping[str, float] = field(default_factory=dict)
    notes: str = ""
    live: Address | None = None


@dataclass(frozen=True)
class SessionResult:
    """What came of a run. log: path or None; simulated, wall: s; messages: in the log; signal: that ended it, or 0."""

    log: Path | None
    simulated: float
    wall: float
    messages: int
    signal: int


def run_session(
    plan: SessionOptions,
    progress: Callable[[float], None] = lambda simulated: None,
    announce: Callable[[str], None] = lambda address: None,
) -> SessionResult:
    """Run it. Raises InputError.

    progress: told the simulated seconds now and then; announce: told the live page's address once it is there.
    """
    # Nodes of this process are configured by the plan; `--ros-args` are for nodes that run alone.
    init(["slider-drilling"])
    halt = ShutdownRequest()
    halt.raise_on_signals(TerminationSignal)
    try:
        with contextlib.ExitStack() as ending:
            return _run(plan, progress, announce, halt, ending)
    finally:
        rclpy.try_shutdown()
        halt.restore_handlers()


def _run(
    plan: SessionOptions,
    progress: Callable[[float], None],
    announce: Callable[[str], None],
    halt: ShutdownRequest,
    ending: contextlib.ExitStack,
) -> SessionResult:
    def make(kind: Callable[..., Any], **parameters: Any) -> Any:
        overrides = [Parameter(name, value=value) for name, value in parameters.items() if value is not None]
        node = kind(halt, parameter_overrides=overrides)
        ending.callback(node.destroy_node)
        return node

    # The simulator first: where another rig is simulated already, nothing is recorded of that one.
    simulator = make(
        FrictionSimulator,
        rig=plan.plant or plan.rig,
        speed=float(plan.speed),
        duration=float(plan.duration),
        seed=plan.seed,
        elements=plan.elements,
        wait_for_controller=True,
        minimum_subscribers=1 + (plan.record is not None) + (plan.live is not None),
    )
    recorder: Recorder | None = None
    if plan.record is not None:
        halt.take_signals()  # its file is begun while it is made, and has to be ended
        recorder = make(Recorder, directory=str(plan.record), rig=_told(plan), notes=plan.notes, use_sim_time=True)
        ending.push(functools.partial(_finish, recorder))
        halt.raise_on_signals(TerminationSignal)
    dashboard = None
    if plan.live is not None:
        dashboard = _make_dashboard(make, plan.live, announce)
    controller = make(
        RockingController,
        rig=plan.rig,
        use_sim_time=True,
        tool_face_target=plan.target,
        controller=plan.controller,
        **plan.settings,
    )
    reporting = [node for node in (simulator, recorder, controller) if node is not None]
    nodes = reporting if dashboard is None else [*reporting, dashboard]
    if recorder is not None:
        # A reader that knows its writer gets messages in the order of their sending, from the first one on.
        simulator.may_start = functools.partial(recorder.is_connected, len(reporting))
    halt.take_signals()
    begun = time.perf_counter()
    executor = spin(nodes, halt, lambda: progress(simulator.simulated))
    ending.callback(executor.shutdown)
    wall = time.perf_counter() - begun
    progress(simulator.simulated)
    if recorder is None:
        halt.raise_error()
        return SessionResult(None, simulator.simulated, wall, 0, halt.signal)
    drain(executor, lambda: recorder.messages)
    halt.raise_error()
    return SessionResult(recorder.path, simulator.simulated, wall, recorder.messages, halt.signal)


def _told(plan: SessionOptions) -> str:
    """The rig file that goes into the log: never the plant's own, where that differs."""
    return str(installed_file(EXAMPLE)) if plan.plant and not plan.rig else plan.rig


def _make_dashboard(make: Callable[..., Any], address: Address, announce: Callable[[str], None]) -> Any:
    from slider_drilling.nodes.dashboard import Dashboard

    dashboard = make(Dashboard, host=address.host, port=address.port, token=address.token)
    announce(dashboard.url)
    return dashboard


def _finish(recorder: Recorder, kind: type[BaseException] | None, error: BaseException | None, trace: object) -> None:
    """Close the log: one up to where a controller failed explains the failure. An empty one explains nothing."""
    if error is not None and recorder.messages == 0:
        recorder.discard()
    else:
        recorder.close()
