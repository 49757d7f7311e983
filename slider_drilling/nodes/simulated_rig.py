"""A simulated rig for the launch files: simulator, controller and, with `record`, a recorder."""

from __future__ import annotations

from dataclasses import dataclass

from launch import LaunchDescriptionEntity

from slider_drilling.nodes.launch_helpers import (
    LaunchArguments,
    LaunchedNode,
    dashboard,
    number,
    process,
    run_together,
    speed,
    target,
    twin,
)

SIMULATED = ("rig", "duration", "speed", "target_deg", "controller", "programme", "record", "dashboard", "twin",
             "namespace", "parameters", "respawn", "discovery")  # fmt: skip


@dataclass(frozen=True)
class SimulatedRig:
    """The processes of one rig, by what their ends mean.

    Attributes:
        simulator: The launch ends with it.
        controller: The rig cannot be without it.
        observers: Recorder, live page and twin, whose ends stop nobody.
    """

    simulator: LaunchedNode
    controller: LaunchedNode
    observers: list[LaunchedNode]


def simulated_rig(given: LaunchArguments, namespace: str | None = None, port: int | None = None) -> SimulatedRig:
    """The processes of one rig.

    Args:
        given: The launch arguments.
        namespace: The rig's, if it is not the argument's.
        port: Of its live page.

    Raises:
        ValueError: An argument makes no sense.
    """
    observers = dashboard(given, namespace, port)
    simulator = process(
        "friction_simulator",
        given,
        {"speed": 1.0, "wait_for_controller": True},
        {
            "rig": given["rig"],
            "speed": speed(given),
            "duration": number(given, "duration"),
            "minimum_subscribers": 2 + len(observers) if given["record"] else None,
        },
        namespace,
    )
    controller = process(
        "rocking_controller",
        given,
        {"use_sim_time": True},
        {"rig": given["rig"], "tool_face_target": target(given), "controller": given["controller"],
         "programme": given.get("programme", "")},
        namespace,
    )
    if given["record"]:
        recorded = {"rig": given["rig"], "directory": given["record"], "programme": given.get("programme", "")}
        observers.insert(0, process("recorder", given, {"use_sim_time": True}, recorded, namespace))
    # The simulator does not wait for a twin: it must not keep a rig from starting.
    observers += twin(given, True, given["rig"], namespace)
    return SimulatedRig(simulator, controller, observers)


def one_rig(given: LaunchArguments) -> list[LaunchDescriptionEntity]:
    """A rig whose processes end with its simulator, and with its controller."""
    rig = simulated_rig(given)
    return run_together(ending=[rig.simulator], required=[rig.controller], optional=rig.observers)
