"""The programs that `ros2 run slider_drilling NAME` starts: one node each, one line for a user's mistake."""

from __future__ import annotations

import importlib
import itertools
import sys
from collections.abc import Callable, Sequence
from typing import Any, Protocol, runtime_checkable

from slider_drilling.errors import InputError
from slider_drilling.nodes import environment
from slider_drilling.nodes.halt import Halt

NODES = {
    "friction_simulator": ("slider_drilling.nodes.friction_simulator", "FrictionSimulator"),
    "rocking_controller": ("slider_drilling.nodes.rocking_controller", "RockingController"),
    "recorder": ("slider_drilling.nodes.recorder", "Recorder"),
    "log_player": ("slider_drilling.nodes.log_player", "LogPlayer"),
    "dashboard": ("slider_drilling.nodes.dashboard", "Dashboard"),
}


@runtime_checkable
class Recording(Protocol):
    """A node that must be closed: what it has received so far is finished then."""

    messages: int

    def close(self) -> None:
        """Finish what was received."""
        ...


def friction_simulator() -> None:
    """Entry point of `friction_simulator`."""
    _main("friction_simulator")


def rocking_controller() -> None:
    """Entry point of `rocking_controller`."""
    _main("rocking_controller")


def recorder() -> None:
    """Entry point of `recorder`."""
    _main("recorder")


def log_player() -> None:
    """Entry point of `log_player`."""
    _main("log_player")


def dashboard() -> None:
    """Entry point of `dashboard`."""
    _main("dashboard")


def _main(name: str) -> None:
    """Run the node and end the process: 0 after its work or a signal, 2 for the user's mistake."""
    halt = Halt()
    halt.leave_on_signals(SystemExit)
    try:
        environment.prepare()
        _run(name, halt)
    except InputError as error:
        print(" ".join(str(error).split()), file=sys.stderr)
        raise SystemExit(2) from None
    raise SystemExit(0)


def _run(name: str, halt: Halt) -> None:
    import rclpy

    from slider_drilling.nodes.link import flush
    from slider_drilling.nodes.spin import drain, spin

    module, kind = NODES[name]
    node_class = getattr(importlib.import_module(module), kind)
    if {"-h", "--help"} & set(sys.argv[1:]):
        print(_help(name, node_class, importlib.import_module(module).PARAMETERS))
        return
    init(sys.argv)
    try:
        node = node_class(halt)
        halt.take_signals()
        try:
            executor = spin([node], halt)
            if isinstance(node, Recording):
                drain(executor, lambda: node.messages)
            flush(node)
            halt.raise_error()
        finally:
            if isinstance(node, Recording):
                node.close()
    finally:
        rclpy.try_shutdown()


def init(arguments: list[str]) -> None:
    """Start rclpy without its signal handlers. Raises InputError for arguments that it or we cannot use."""
    import rclpy
    from rclpy.exceptions import ROSInterruptException
    from rclpy.impl.implementation_singleton import rclpy_implementation
    from rclpy.signals import SignalHandlerOptions
    from rclpy.utilities import remove_ros_args

    wrong = (rclpy_implementation.RCLError, rclpy_implementation.RCLInvalidROSArgsError,
             rclpy_implementation.UnknownROSArgsError, ROSInterruptException)
    try:
        extra = remove_ros_args(arguments)[1:]
        if extra:
            raise InputError(f"{' '.join(extra)}: not understood; parameters are given as --ros-args -p NAME:=VALUE")
        rclpy.init(args=[*arguments, *own_clock(arguments)], signal_handler_options=SignalHandlerOptions.NO)
    except wrong as error:
        raise InputError(f"ROS 2 cannot start: {str(error).splitlines()[0]}") from None


def own_clock(arguments: Sequence[str]) -> list[str]:
    """Further arguments that give a rig in a namespace a clock of its own, in that namespace.

    ROS 2 knows one topic of time, /clock, and two rigs on it spoil each other's time. Who remaps /clock is obeyed.
    """
    rules = [rule for flag, rule in itertools.pairwise(arguments) if flag in ("-r", "--remap")]
    if any(rule.partition(":=")[0].rpartition(":")[2] == "/clock" for rule in rules):
        return []
    spaces = [value.strip("/") for rule in rules for name, _, value in [rule.partition(":=")]
              if name.rpartition(":")[2] == "__ns"]
    return ["--ros-args", "-r", f"/clock:=/{spaces[0]}/clock"] if spaces and spaces[0] else []


def _help(name: str, node_class: Callable[..., Any], parameters: Any) -> str:
    """The node's purpose and its parameters."""
    purpose = (node_class.__doc__ or "").strip().splitlines()[0]
    rows = [f"usage: ros2 run slider_drilling {name} --ros-args -p NAME:=VALUE ...", "", purpose, "", "parameters:"]
    for one in parameters:
        unit = "" if one.unit == "-" else f" [{one.unit}]"
        rows.append(f"  {one.name} ({type(one.default).__name__}, {one.default!r}): {one.description}{unit}")
    return "\n".join(rows)
