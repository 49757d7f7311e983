"""A simulated rig for the launch files: simulator, controller and, with `record`, a recorder."""

from __future__ import annotations

from launch import LaunchDescriptionEntity
from launch_ros.actions import Node

from slider_drilling.nodes.launch_helpers import (
    LaunchArguments,
    dashboard,
    number,
    process,
    shut_down_together,
    speed,
    target,
)

SIMULATED = ("rig", "duration", "speed", "target_deg", "controller", "record", "dashboard", "namespace", "parameters",
             "respawn", "discovery")  # fmt: skip


def simulated_rig(
    given: LaunchArguments, namespace: str | None = None, port: int | None = None
) -> tuple[Node, list[Node]]:
    """The simulator's process, and the other processes of one rig.

    Args:
        given: The launch arguments.
        namespace: The rig's, if it is not the argument's.
        port: Of its live page.

    Raises:
        ValueError: An argument makes no sense.
    """
    shown = dashboard(given, namespace, port)
    simulator = process(
        "friction_simulator",
        given,
        {"speed": 1.0, "wait_for_controller": True},
        {
            "rig": given["rig"],
            "speed": speed(given),
            "duration": number(given, "duration"),
            "minimum_subscribers": 2 + len(shown) if given["record"] else None,
        },
        namespace,
    )
    others = [
        process(
            "rocking_controller",
            given,
            {"use_sim_time": True},
            {"rig": given["rig"], "tool_face_target": target(given), "controller": given["controller"]},
            namespace,
        )
    ]
    if given["record"]:
        others.append(
            process(
                "recorder",
                given,
                {"use_sim_time": True},
                {"rig": given["rig"], "directory": given["record"]},
                namespace,
            )
        )
    return simulator, [*others, *shown]


def one_rig(given: LaunchArguments) -> list[LaunchDescriptionEntity]:
    """A rig whose processes all end with its simulator."""
    simulator, others = simulated_rig(given)
    return shut_down_together([simulator], others)
