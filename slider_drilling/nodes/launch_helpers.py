"""Shared by the launch files: their arguments, the nodes' processes, and how a launch ends."""

from __future__ import annotations

import difflib
import math
import os
import shutil
import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import yaml
from launch import LaunchContext, LaunchDescription, LaunchDescriptionEntity, logging
from launch.actions import DeclareLaunchArgument, OpaqueFunction, RegisterEventHandler, Shutdown, TimerAction
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
    "programme": "programme to run in place of a controller; its node is not restarted after a crash",
    "record": "folder for the log; empty: no recorder",
    "dashboard": "serve the live page and print its address: true or false [false]",
    "twin": "run a twin beside the rig, which says live where they differ and why: true or false [false]",
    "namespace": "namespace of every topic",
    "parameters": "YAML file with node parameters; arguments win over it",
    "respawn": "restart a controller, recorder or twin that died: true or false [true]",
    "discovery": "which machines see the nodes: localhost, subnet or off [localhost]",
    "log": "MCAP log to play",
}
RANGES = {"": None, "localhost": None, "subnet": "SUBNET", "off": "OFF"}

LaunchArguments = Mapping[str, str]


class LaunchedNode(Node):
    """A node's process, which can be started again.

    Args:
        restarts: Whether to start it again after a crash.
        options: Of `launch_ros.actions.Node`.
    """

    def __init__(self, restarts: bool, **options: Any) -> None:
        super().__init__(**options)
        self.restarts = restarts
        self._options = options

    def copy(self) -> LaunchedNode:
        """The same node, not started."""
        return LaunchedNode(self.restarts, **self._options)


def description(names: Iterable[str], entities: Any) -> LaunchDescription:
    """The description that `ros2 launch` runs.

    Args:
        names: The file's arguments, of ARGUMENTS.
        entities: Makes the launch's entities from the argument values.
    """
    chosen = tuple(names)

    def make(context: LaunchContext) -> list[LaunchDescriptionEntity]:
        _warn_of_unknown(set(context.launch_configurations) - set(chosen), chosen)
        made: list[LaunchDescriptionEntity] = entities(
            {name: LaunchConfiguration(name).perform(context) for name in chosen}
        )
        return made

    declared = [DeclareLaunchArgument(name, default_value="", description=ARGUMENTS[name]) for name in chosen]
    return LaunchDescription([*declared, OpaqueFunction(function=make)])


def _warn_of_unknown(unknown: Iterable[str], known: Sequence[str]) -> None:
    """Log a warning for arguments that a launch file does not have; launch itself ignores them without a word."""
    for name in sorted(unknown):
        near = difflib.get_close_matches(name, known, n=1)
        hint = f"did you mean {near[0]}?" if near else f"there are {', '.join(known)}"
        logging.get_logger("launch").warning(f"argument {name} is not known and changes nothing; {hint}")


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
    """The argument `target_deg` in rad; ValueError beyond half a turn."""
    from slider_drilling.control.tool_face_target import target_refusal

    degrees = number(given, "target_deg")
    if refusal := target_refusal(degrees):
        raise ValueError(f"target_deg:={refusal}")
    return None if degrees is None else math.radians(degrees)


def process(
    executable: str,
    given: LaunchArguments,
    defaults: Mapping[str, Any],
    overrides: Mapping[str, Any],
    namespace: str | None = None,
    clock: str | None = None,
) -> LaunchedNode:
    """One node as a process.

    Args:
        executable: Name of program and node.
        given: The launch arguments.
        defaults: Parameters that the parameter file may change.
        overrides: Parameters that win over the file; None and "" are left out.
        namespace: The node's, if it is not the argument's.
        clock: Namespace of the rig's time, if it is not the node's.
    """
    file = given.get("parameters", "")
    in_file = _parameters_in(file, executable) if file else set()
    own = {name: value for name, value in defaults.items() if name not in in_file}
    own |= {name: value for name, value in overrides.items() if value not in (None, "")}
    space = given.get("namespace", "") if namespace is None else namespace
    restarts = executable in ("recorder", "rocking_controller", "twin") and is_true(given, "respawn", True)
    # A programme must not begin again in the middle of a stand.
    restarts = restarts and not (executable == "rocking_controller" and given.get("programme"))
    return LaunchedNode(
        restarts,
        package=PACKAGE,
        executable=executable,
        exec_name=executable,
        name=executable,
        namespace=space,
        output="screen",
        parameters=[*([file] if file else []), *([own] if own else [])],
        remappings=[] if clock is None else [("/clock", f"/{clock.strip('/')}/clock".replace("//", "/"))],
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


def dashboard(given: LaunchArguments, namespace: str | None = None, port: int | None = None) -> list[LaunchedNode]:
    """The live page's process, if the argument asks for it; port: used unless the parameter file gives one."""
    defaults = {} if port is None else {"port": port}
    return [process("dashboard", given, defaults, {}, namespace)] if is_true(given, "dashboard") else []


def twin(
    given: LaunchArguments, use_sim_time: bool, rig: str, namespace: str | None = None, clock: str | None = None
) -> list[LaunchedNode]:
    """The twin's process, if the argument asks for it.

    Args:
        given: The launch arguments.
        use_sim_time: Whether the rig's time is on /clock.
        rig: Path of the rig file, or of a log that has one.
        namespace: The node's, if it is not the argument's.
        clock: Namespace of the rig's time, if it is not the node's.
    """
    if not is_true(given, "twin"):
        return []
    return [process("twin", given, {"use_sim_time": use_sim_time}, {"rig": rig}, namespace, clock)]


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


def run_together(
    ending: Iterable[LaunchedNode], required: Iterable[LaunchedNode], optional: Iterable[LaunchedNode]
) -> list[LaunchDescriptionEntity]:
    """The nodes of a launch, each with its role: whether its end ends the others.

    A node that crashes is started again if it may be (`respawn`), whatever its role; one that reports a mistake of the
    user is not. The launch returns 1 if any node failed for good, also if it went on without it.

    Args:
        ending: Simulators and players, whose work has an end: the launch ends with the last of them, or if one fails.
        required: A controller, or the rig: what is left without it makes no sense, so its end ends the launch.
        optional: Recorder, dashboard, twin: never end the others. Their failure is logged.
    """
    roles = _Roles(set(ending), set(required))
    return [entity for node in (*roles.ending, *roles.required, *optional) for entity in roles.watched(node)]


class _Roles:
    """Handles the ends of a launch's nodes."""

    def __init__(self, ending: set[LaunchedNode], required: set[LaunchedNode]) -> None:
        self.ending, self.required = ending, required
        self._has_end = bool(ending)
        self._failures: list[str] = []

    def watched(self, node: LaunchedNode) -> list[LaunchDescriptionEntity]:
        """The node, with a handler for its end."""

        def on_exit(event: Any, context: LaunchContext) -> list[LaunchDescriptionEntity]:
            return self._on_exit(node, event, context)

        return [RegisterEventHandler(OnProcessExit(target_action=node, on_exit=on_exit)), node]

    def _on_exit(self, node: LaunchedNode, event: Any, context: LaunchContext) -> list[LaunchDescriptionEntity]:
        code = event.returncode
        is_crash = code not in (0, USER_MISTAKE)
        if not context.is_shutdown and is_crash and node.restarts:
            return self._start_again(node)
        if code != 0:
            self._failures.append(f"{event.process_name} failed: exit code {code}")
        if context.is_shutdown:
            return self._shut_down() if self._failures else []
        if node in self.required or (node in self.ending and code != 0):
            return self._shut_down()
        if node in self.ending:
            self.ending.discard(node)
            return [] if self.ending else self._shut_down()
        if code != 0:
            logging.get_logger("launch").error(f"{self._failures[-1]}; the other nodes go on")
        return []

    def _start_again(self, node: LaunchedNode) -> list[LaunchDescriptionEntity]:
        again = node.copy()
        for group in (self.ending, self.required):
            if node in group:
                group.remove(node)
                group.add(again)
        return [TimerAction(period=RESPAWN_DELAY, actions=self.watched(again))]

    def _shut_down(self) -> list[LaunchDescriptionEntity]:
        """End the launch. After an exception, and only then, it ends the other nodes in order and returns 1."""
        if self._failures:
            raise RuntimeError("; ".join(self._failures))
        return [Shutdown(reason="the simulation has ended" if self._has_end else "a node that is needed has ended")]
