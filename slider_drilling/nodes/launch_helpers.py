"""Shared by the launch files: their arguments, the nodes' processes, and how a launch ends."""

from __future__ import annotations

import math
import os
import shutil
import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import yaml
from launch import LaunchContext, LaunchDescription, LaunchDescriptionEntity
from launch.actions import DeclareLaunchArgument, OpaqueFunction, RegisterEventHandler, Shutdown
from launch.event_handlers import OnProcessExit
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from slider_drilling.process.parent_death import PARENT_PID_VARIABLE

PACKAGE = "slider_drilling"
USER_MISTAKE = 2  # exit code of a node that a restart would not help
RESPAWN_DELAY = 1.0  # s
# Arguments are empty by default; the parameter file and the nodes then give the values in brackets.
ARGUMENTS = {
    "rig": "rig file [the 4 km example well]",
    "duration": "simulated time, s; 0: until interrupted [0]",
    "speed": "simulated seconds per second; 0 or max: as fast as possible, in lockstep [1]",
    "target_deg": "toolface to hold, deg [0]",
    "controller": "controller as module:Class [this package's own]",
    "record": "folder for the log; empty: no recorder",
    "dashboard": "serve the live page and print its address: true or false [false]",
    "namespace": "namespace of every topic",
    "parameters": "YAML file with node parameters; arguments win over it",
    "respawn": "restart a controller or recorder that died: true or false [true]",
    "discovery": "which machines see the nodes: localhost, subnet or off [localhost]",
    "log": "MCAP log to play",
}
RANGES = {"": None, "localhost": None, "subnet": "SUBNET", "off": "OFF"}

LaunchArguments = Mapping[str, str]


def description(names: Iterable[str], entities: Any) -> LaunchDescription:
    """The description that `ros2 launch` runs.

    Args:
        names: The file's arguments, of ARGUMENTS.
        entities: Makes the launch's entities from the argument values.
    """
    chosen = tuple(names)

    def make(context: LaunchContext) -> list[LaunchDescriptionEntity]:
        made: list[LaunchDescriptionEntity] = entities(
            {name: LaunchConfiguration(name).perform(context) for name in chosen}
        )
        return made

    declared = [DeclareLaunchArgument(name, default_value="", description=ARGUMENTS[name]) for name in chosen]
    return LaunchDescription([*declared, OpaqueFunction(function=make)])


def number(given: LaunchArguments, name: str) -> float | None:
    """An argument as a number; None if it was not given. Raises ValueError that names the argument."""
    if not given.get(name):
        return None
    try:
        return float(given[name])
    except ValueError:
        raise ValueError(f"{name}:={given[name]}: must be a number") from None


def speed(given: LaunchArguments) -> float | None:
    """The argument `speed`; 0 for `max`."""
    return 0.0 if given.get("speed") == "max" else number(given, "speed")


def target(given: LaunchArguments) -> float | None:
    """The argument `target_deg`, rad in (-pi, pi]."""
    degrees = number(given, "target_deg")
    return None if degrees is None else math.remainder(math.radians(degrees), 2.0 * math.pi)


def process(
    executable: str,
    given: LaunchArguments,
    defaults: Mapping[str, Any],
    overrides: Mapping[str, Any],
    namespace: str | None = None,
) -> Node:
    """One node as a process.

    Args:
        executable: Name of program and node.
        given: The launch arguments.
        defaults: Parameters that the parameter file may change.
        overrides: Parameters that win over the file; None and "" are left out.
        namespace: The node's, if it is not the argument's.
    """
    file = given.get("parameters", "")
    in_file = _parameters_in(file, executable) if file else set()
    own = {name: value for name, value in defaults.items() if name not in in_file}
    own |= {name: value for name, value in overrides.items() if value not in (None, "")}
    space = given.get("namespace", "") if namespace is None else namespace
    respawn = executable in ("recorder", "rocking_controller") and is_true(given, "respawn", True)
    return Node(
        package=PACKAGE,
        executable=executable,
        exec_name=executable,
        name=executable,
        namespace=space,
        output="screen",
        parameters=[*([file] if file else []), *([own] if own else [])],
        respawn=respawn,
        respawn_delay=RESPAWN_DELAY,
        prefix=_signal_blocking_prefix(),
        additional_env=_environment(given),
    )


def _parameters_in(file: str, node: str) -> set[str]:
    """Names of the parameters that a file gives a node. Raises ValueError if it is not a parameter file.

    `process` drops the defaults that the file gives. ROS 2 does not apply files in order but prefers specific node
    names, so a default for this node would win over the file's value for `/**/node`.
    """
    try:
        tree = yaml.safe_load(Path(file).read_text())
    except (OSError, ValueError, yaml.YAMLError) as error:
        raise ValueError(f"parameters:={file}: cannot be read: {' '.join(str(error).split())}") from None

    def names(branch: Any, here: str) -> set[str]:
        if not isinstance(branch, dict):
            return set()
        found = set(branch.get("ros__parameters") or ()) if here in (node, "*", "**") else set()
        return found.union(
            *(names(below, str(key).rpartition("/")[2]) for key, below in branch.items() if key != "ros__parameters")
        )

    return names(tree, "")


def is_true(given: LaunchArguments, name: str, otherwise: bool = False) -> bool:
    """An argument that is true or false; `otherwise` if it was not given. Raises ValueError that names it."""
    text = given.get(name) or str(otherwise)
    if text.lower() not in ("true", "false"):
        raise ValueError(f"{name}:={text}: must be true or false")
    return text.lower() == "true"


def dashboard(given: LaunchArguments, namespace: str | None = None, port: int | None = None) -> list[Node]:
    """The live page's process, if the argument asks for it; port: used unless the parameter file gives one."""
    defaults = {} if port is None else {"port": port}
    return [process("dashboard", given, defaults, {}, namespace)] if is_true(given, "dashboard") else []


def _signal_blocking_prefix() -> str | None:
    """A command prefix that blocks signals while Python starts, which would answer them with a traceback."""
    has_env = sys.platform == "linux" and shutil.which("env") is not None
    return "env --block-signal=INT,TERM" if has_env else None


def _environment(given: LaunchArguments) -> dict[str, str]:
    discovery = given.get("discovery", "").lower()
    if discovery not in RANGES:
        raise ValueError(f"discovery:={discovery}: must be localhost, subnet or off")
    reach = RANGES[discovery]
    return {PARENT_PID_VARIABLE: str(os.getpid())} | ({} if reach is None else {"ROS_AUTOMATIC_DISCOVERY_RANGE": reach})


def shut_down_together(
    ending: Sequence[Node], others: Iterable[Node], needed: Iterable[Node] = ()
) -> list[LaunchDescriptionEntity]:
    """The nodes, with handlers for their ends. The launch fails if a node fails that is not restarted.

    Args:
        ending: The launch ends when the last of these has ended; none: when it is interrupted.
        others: Restarted by `respawn` if they crash, but not after a mistake of the user.
        needed: Never restarted.
    """
    running, once = set(ending), {*ending, *needed}

    def exit_handler(node: Node) -> Any:
        def on_exit(event: Any, context: LaunchContext) -> list[LaunchDescriptionEntity]:
            code = event.returncode
            if context.is_shutdown:
                if code != 0:
                    raise RuntimeError(f"{event.process_name} failed while it ended: exit code {code}")
                return []
            if code == USER_MISTAKE or (code != 0 and node in once):
                # After an exception, and only then, launch ends the other nodes in order and returns 1.
                raise RuntimeError(f"{event.process_name} failed: exit code {code}")
            running.discard(node)
            return [] if running or not ending else [Shutdown(reason="the simulation has ended")]

        return on_exit

    nodes = [*once, *others]
    return [
        *(RegisterEventHandler(OnProcessExit(target_action=node, on_exit=exit_handler(node))) for node in nodes),
        *nodes,
    ]
