"""What the launch files share: a process a node, arguments before parameter files, an end that tells of failures."""

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
MISTAKE = 2  # the exit code of what a user can mend: starting it again would not
RESPAWN_DELAY = 1.0  # s
# Every argument is empty by default: what is not given is left to the parameter file, and to the nodes themselves.
ARGUMENTS = {
    "rig": "rig file [the 4 km example well]",
    "duration": "simulated time, s; 0: until interrupted [0]",
    "speed": "simulated seconds a second; 0 or max: as fast as possible, in lockstep [1]",
    "target_deg": "toolface to hold, deg [0]",
    "controller": "controller as module:Class [this package's own]",
    "record": "folder for the log; empty: no recorder",
    "dashboard": "serve the live page, its address in the output: true or false [false]",
    "namespace": "namespace of every topic",
    "parameters": "YAML file with node parameters; arguments win over it",
    "respawn": "start a controller or recorder that died again: true or false [true]",
    "discovery": "who sees the nodes: localhost, subnet (other machines, too) or off [localhost]",
    "log": "MCAP log to play",
}
RANGES = {"": None, "localhost": None, "subnet": "SUBNET", "off": "OFF"}

LaunchArguments = Mapping[str, str]


def description(names: Iterable[str], entities: Any) -> LaunchDescription:
    """What `ros2 launch` asks for. names: of ARGUMENTS; entities: makes the launch's entities of what was given."""
    chosen = tuple(names)

    def make(context: LaunchContext) -> list[LaunchDescriptionEntity]:
        made: list[LaunchDescriptionEntity] = entities(
            {name: LaunchConfiguration(name).perform(context) for name in chosen}
        )
        return made

    declared = [DeclareLaunchArgument(name, default_value="", description=ARGUMENTS[name]) for name in chosen]
    return LaunchDescription([*declared, OpaqueFunction(function=make)])


def number(given: LaunchArguments, name: str) -> float | None:
    """An argument as a number, None where it was not given. Raises ValueError naming the argument."""
    if not given.get(name):
        return None
    try:
        return float(given[name])
    except ValueError:
        raise ValueError(f"{name}:={given[name]}: must be a number") from None


def speed(given: LaunchArguments) -> float | None:
    """The argument `speed`, 0 for `max`."""
    return 0.0 if given.get("speed") == "max" else number(given, "speed")


def target(given: LaunchArguments) -> float | None:
    """The argument `target_deg` in rad within (-pi, pi]."""
    degrees = number(given, "target_deg")
    return None if degrees is None else math.remainder(math.radians(degrees), 2.0 * math.pi)


def process(
    executable: str,
    given: LaunchArguments,
    defaults: Mapping[str, Any],
    wanted: Mapping[str, Any],
    namespace: str | None = None,
) -> Node:
    """One node as a process. defaults: parameters that the file may change; wanted: those that win, None left out."""
    file = given.get("parameters", "")
    mentioned = _mentioned(file, executable) if file else set()
    own = {name: value for name, value in defaults.items() if name not in mentioned}
    own |= {name: value for name, value in wanted.items() if value not in (None, "")}
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
        prefix=_waiting_signals(),
        additional_env=_environment(given),
    )


def _mentioned(file: str, node: str) -> set[str]:
    """Names of the parameters that a file gives a node. Raises ValueError for what is no parameter file.

    Defaults that a file mentions are left to it: ROS 2 does not go by the order of files but by that of the node
    names in them, and a default for this very node would win over one for `/**/node`.
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
    """An argument that is true or false, `otherwise` where it was not given. Raises ValueError naming it."""
    text = given.get(name) or str(otherwise)
    if text.lower() not in ("true", "false"):
        raise ValueError(f"{name}:={text}: must be true or false")
    return text.lower() == "true"


def dashboard(given: LaunchArguments, namespace: str | None = None, port: int | None = None) -> list[Node]:
    """The live page's process where it is asked for. port: that it takes unless the parameter file gives one."""
    defaults = {} if port is None else {"port": port}
    return [process("dashboard", given, defaults, {}, namespace)] if is_true(given, "dashboard") else []


def _waiting_signals() -> str | None:
    """A prefix that keeps signals waiting while Python starts: it answers them with a traceback."""
    has_env = sys.platform == "linux" and shutil.which("env") is not None
    return "env --block-signal=INT,TERM" if has_env else None


def _environment(given: LaunchArguments) -> dict[str, str]:
    wanted = given.get("discovery", "").lower()
    if wanted not in RANGES:
        raise ValueError(f"discovery:={wanted}: must be localhost, subnet or off")
    found = RANGES[wanted]
    return {PARENT_PID_VARIABLE: str(os.getpid())} | ({} if found is None else {"ROS_AUTOMATIC_DISCOVERY_RANGE": found})


def shut_down_together(
    ending: Sequence[Node], others: Iterable[Node], needed: Iterable[Node] = ()
) -> list[LaunchDescriptionEntity]:
    """The nodes, and what their ends mean: the launch ends with the last of `ending`, and fails where any node failed.

    A node of `others` that crashed is started again by `respawn`; one that says what its user can mend is not, nor is
    one that is `needed`.
    """
    left, once = set(ending), {*ending, *needed}

    def judge(node: Node) -> Any:
        def on_exit(event: Any, context: LaunchContext) -> list[LaunchDescriptionEntity]:
            code = event.returncode
            if context.is_shutdown:
                if code != 0:
                    raise RuntimeError(f"{event.process_name} failed while it ended: exit code {code}")
                return []
            if code == MISTAKE or (code != 0 and node in once):
                # launch returns 1 for an exception alone, and ends the other nodes in order.
                raise RuntimeError(f"{event.process_name} failed: exit code {code}")
            left.discard(node)
            return [] if left or not ending else [Shutdown(reason="the simulation has ended")]

        return on_exit

    nodes = [*once, *others]
    return [*(RegisterEventHandler(OnProcessExit(target_action=node, on_exit=judge(node))) for node in nodes), *nodes]
