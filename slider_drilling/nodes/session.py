"""Simulator, controller and recorder in one process: the same nodes and topics as three processes have."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import rclpy
from rclpy.node import Node
from rclpy.parameter import Parameter

from slider_drilling.errors import InputError
from slider_drilling.nodes.friction_simulator import FrictionSimulator
from slider_drilling.nodes.halt import Halt
from slider_drilling.nodes.programs import init
from slider_drilling.nodes.recorder import Recorder
from slider_drilling.nodes.rocking_controller import RockingController
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
    halt.take_signals()
    recorder = None
    try:
        recorder = _recorder(plan, halt)
        simulator = _make(FrictionSimulator, halt, rig=plan.rig, speed=plan.speed, duration=plan.duration,
                          seed=plan.seed, elements=plan.elements, wait_for_controller=True,
                          minimum_subscribers=1 if recorder is None else 2)
        own = {"tool_face_target": plan.target, "controller": plan.controller}
        controller = _make(RockingController, halt, rig=plan.rig, use_sim_time=True,
                           **{name: value for name, value in own.items() if value is not None})
        nodes: list[Node] = [node for node in (simulator, recorder, controller) if node is not None]
        begun = time.perf_counter()
        executor = spin(nodes, halt, lambda: progress(simulator.simulated))
        wall = time.perf_counter() - begun
        progress(simulator.simulated)
        if recorder is not None:
            drain(executor, lambda: recorder.messages)
        halt.raise_error()
    except InputError:
        # A log up to where a controller failed is what explains the failure; an empty one explains nothing.
        if recorder is not None and recorder.messages == 0:
            recorder.discard()
        raise
    finally:
        if recorder is not None:
            recorder.close()
        rclpy.try_shutdown()
        halt.give_signals_back()
    messages = 0 if recorder is None else recorder.messages
    return Outcome(None if recorder is None else recorder.path, simulator.simulated, wall, messages, halt.interrupted)


def _recorder(plan: Plan, halt: Halt) -> Recorder | None:
    if plan.record is None:
        return None
    return _make(Recorder, halt, directory=str(plan.record), rig=plan.rig, use_sim_time=True)


def _make(kind: Callable[..., Any], halt: Halt, **parameters: Any) -> Any:
    overrides = [Parameter(name, value=value) for name, value in parameters.items()]
    return kind(halt, parameter_overrides=overrides)
