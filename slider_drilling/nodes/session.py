"""Simulator, controller and recorder in one process: the same nodes and topics as three processes have."""

from __future__ import annotations

import contextlib
import functools
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import rclpy
from rclpy.parameter import Parameter

from slider_drilling.nodes.friction_simulator import FrictionSimulator
from slider_drilling.nodes.halt import Halt
from slider_drilling.nodes.recorder import Recorder
from slider_drilling.nodes.rocking_controller import RockingController
from slider_drilling.nodes.run_node import init
from slider_drilling.nodes.spin import drain, spin


@dataclass(frozen=True)
class Plan:
    """What to run. rig, record: paths; duration: s; speed: times real time, 0 for lockstep; target: rad."""

    rig: str = ""
    duration: float = 300.0
    speed: float = 0.0
    record: Path | None = None
    target: float | None = None
    controller: str | None = None
    seed: int = 0
    elements: int = 200


@dataclass(frozen=True)
class Outcome:
    """What came of a run. log: path or None; simulated, wall: s; messages: in the log; interrupted: by a signal."""

    log: Path | None
    simulated: float
    wall: float
    messages: int
    interrupted: bool


def run(plan: Plan, progress: Callable[[float], None] = lambda simulated: None) -> Outcome:
    """Run it; `progress` is told the simulated seconds now and then. Raises InputError."""
    # Nodes of this process are configured by the plan; `--ros-args` are for nodes that run alone.
    init(["slider-drilling"])
    halt = Halt()
    halt.leave_on_signals(KeyboardInterrupt)
    try:
        with contextlib.ExitStack() as ending:
            return _run(plan, progress, halt, ending)
    finally:
        rclpy.try_shutdown()
        halt.give_signals_back()


def _run(plan: Plan, progress: Callable[[float], None], halt: Halt, ending: contextlib.ExitStack) -> Outcome:
    def make(kind: Callable[..., Any], **parameters: Any) -> Any:
        overrides = [Parameter(name, value=value) for name, value in parameters.items() if value is not None]
        node = kind(halt, parameter_overrides=overrides)
        ending.callback(node.destroy_node)
        return node

    # The simulator first: where another rig is simulated already, nothing is recorded of that one.
    simulator = make(FrictionSimulator, rig=plan.rig, speed=float(plan.speed), duration=float(plan.duration),
                     seed=plan.seed, elements=plan.elements, wait_for_controller=True,
                     minimum_subscribers=1 if plan.record is None else 2)
    recorder: Recorder | None = None
    if plan.record is not None:
        recorder = make(Recorder, directory=str(plan.record), rig=plan.rig, use_sim_time=True)
        ending.push(functools.partial(_finish, recorder))
    controller = make(RockingController, rig=plan.rig, use_sim_time=True, tool_face_target=plan.target,
                      controller=plan.controller)
    nodes = [node for node in (simulator, recorder, controller) if node is not None]
    if recorder is not None:
        # A reader that knows its writer gets messages in the order of their sending, from the first one on.
        simulator.may_start = functools.partial(recorder.is_connected, len(nodes))
    halt.take_signals()
    begun = time.perf_counter()
    executor = spin(nodes, halt, lambda: progress(simulator.simulated))
    ending.callback(executor.shutdown)
    wall = time.perf_counter() - begun
    progress(simulator.simulated)
    if recorder is None:
        halt.raise_error()
        return Outcome(None, simulator.simulated, wall, 0, halt.interrupted)
    drain(executor, lambda: recorder.messages)
    halt.raise_error()
    return Outcome(recorder.path, simulator.simulated, wall, recorder.messages, halt.interrupted)


def _finish(recorder: Recorder, kind: type[BaseException] | None, error: BaseException | None, trace: object) -> None:
    """Close the log: one up to where a controller failed explains the failure. An empty one explains nothing."""
    if error is not None and recorder.messages == 0:
        recorder.discard()
    else:
        recorder.close()
