"""Runs one node in a process of its own."""

from __future__ import annotations

import contextlib
import importlib
import itertools
import sys
from collections.abc import Sequence
from typing import Any, Protocol, runtime_checkable

import rclpy
from rclpy.exceptions import ROSInterruptException
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.signals import SignalHandlerOptions
from rclpy.utilities import remove_ros_args

from slider_drilling.errors import InputError
from slider_drilling.nodes.lifecycle_node import ManagedNode
from slider_drilling.nodes.raw_topics import flush
from slider_drilling.nodes.shutdown import ShutdownRequest, SignalInterrupt
from slider_drilling.nodes.spin import drain, spin

NODES = {
    "friction_simulator": ("slider_drilling.nodes.friction_simulator", "FrictionSimulator"),
    "rocking_controller": ("slider_drilling.nodes.rocking_controller", "RockingController"),
    "recorder": ("slider_drilling.nodes.recorder", "Recorder"),
    "log_player": ("slider_drilling.nodes.log_player", "LogPlayer"),
    "dashboard": ("slider_drilling.nodes.dashboard", "Dashboard"),
    "twin": ("slider_drilling.nodes.twin", "TwinNode"),
    "opcua_bridge": ("slider_drilling.nodes.opcua_bridge", "OpcuaBridge"),
}
# Nodes that need no speed use an executor that rclpy supports; see `spin.make_executor`.
UNHURRIED = ("dashboard", "opcua_bridge")
WRONG_ARGUMENTS = (
    rclpy_implementation.RCLError,
    rclpy_implementation.RCLInvalidROSArgsError,
    rclpy_implementation.UnknownROSArgsError,
    ROSInterruptException,
)


@runtime_checkable
class ClosableNode(Protocol):
    """A node whose output must be finished with `close`."""

    messages: int

    def close(self) -> None:
        """Finish the output."""
        ...


def run_node(name: str) -> None:
    """Run the node of this program name until its work is done or a signal comes. Raises InputError."""
    shutdown_request = ShutdownRequest()
    shutdown_request.raise_on_signals(SignalInterrupt)
    try:
        module = importlib.import_module(NODES[name][0])
        node_class = getattr(module, NODES[name][1])
        if {"-h", "--help"} & set(sys.argv[1:]):
            print(_help(name, node_class))
            return
        init(sys.argv)
        try:
            _spin_node(node_class, shutdown_request)
        finally:
            rclpy.try_shutdown()
    except SignalInterrupt:
        return  # a signal came while there was nothing to finish


def _spin_node(node_class: Any, shutdown_request: ShutdownRequest) -> None:
    if hasattr(node_class, "close"):
        shutdown_request.take_signals()  # its constructor opens a file, which must be closed
    try:
        node = node_class(shutdown_request)
    except rclpy_implementation.RCLError as error:
        raise InputError(f"ROS 2 cannot make the node: {str(error).splitlines()[0]}") from None
    shutdown_request.take_signals()
    with contextlib.ExitStack() as ending:
        ending.callback(node.destroy_node)
        if isinstance(node, ClosableNode):
            ending.callback(node.close)
        executor = spin([node], shutdown_request, supported=node_class.NAME in UNHURRIED)
        ending.callback(executor.shutdown)
        if isinstance(node, ClosableNode):
            drain(executor, lambda: node.messages)
        if isinstance(node, ManagedNode):
            node.end()
        flush(node)
        shutdown_request.raise_error()


def init(arguments: list[str]) -> None:
    """Start rclpy without its signal handlers. Raises InputError for arguments that cannot be used."""
    try:
        extra = remove_ros_args(arguments)[1:]
        if extra:
            raise InputError(f"{' '.join(extra)}: not understood; parameters are given as --ros-args -p NAME:=VALUE")
        rclpy.init(args=[*arguments, *own_clock(arguments)], signal_handler_options=SignalHandlerOptions.NO)
    except WRONG_ARGUMENTS as error:
        raise InputError(f"ROS 2 cannot start: {str(error).splitlines()[0]}") from None


def own_clock(arguments: Sequence[str]) -> list[str]:
    """Arguments that remap /clock into the node's namespace, unless the user remaps it.

    ROS 2 has one time topic, /clock; two rigs that both publish it would mix their times.
    """
    rules = [rule.partition(":=") for flag, rule in itertools.pairwise(arguments) if flag in ("-r", "--remap")]
    # A rule may be meant for one node: `NODE:FROM:=TO`.
    targets = {name.rpartition(":")[2]: value.strip("/") for name, _, value in reversed(rules)}
    space = targets.get("__ns", "")
    return ["--ros-args", "-r", f"/clock:=/{space}/clock"] if space and "/clock" not in targets else []


def _help(name: str, node_class: Any) -> str:
    """The node's usage, purpose and parameters."""
    purpose = (node_class.__doc__ or "").strip().splitlines()[0]
    rows = [f"usage: ros2 run slider_drilling {name} --ros-args -p NAME:=VALUE ...", "", purpose, "", "parameters:"]
    for parameter in node_class.PARAMETERS:
        unit = "" if parameter.unit == "-" else f" [{parameter.unit}]"
        default = parameter.default
        rows.append(f"  {parameter.name} ({type(default).__name__}, {default!r}): {parameter.description}{unit}")
    return "\n".join(rows)
