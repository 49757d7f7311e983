"""Node parameters with type, unit, range and meaning; a value that cannot be used is rejected with a reason."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor, SetParametersResult
from rclpy.exceptions import InvalidParameterTypeException, InvalidParameterValueException
from rclpy.node import Node
from rclpy.parameter import Parameter

from slider_drilling.errors import InputError


@dataclass(frozen=True)
class NodeParameter:
    """One parameter of a node.

    Attributes:
        name: As `ros2 param` shows it.
        default: Its value if none is given; gives the type. ROS 2 has no type for an empty list: use [""].
        description: What the parameter means.
        unit: "-" if it has none.
        low: Smallest value of a number.
        high: Largest value of a number.
        live: Whether it may change while the node runs.
    """

    name: str
    default: str | bool | int | float | list[str]
    description: str
    unit: str = "-"
    low: float = 0.0
    high: float = 0.0
    live: bool = False

    def descriptor(self) -> ParameterDescriptor:
        """What `ros2 param describe` shows."""
        unit = "" if self.unit == "-" else f" [{self.unit}]"
        described = ParameterDescriptor(description=self.description + unit, read_only=not self.live)
        if isinstance(self.default, float):
            described.floating_point_range = [FloatingPointRange(from_value=self.low, to_value=self.high)]
        elif isinstance(self.default, int) and not isinstance(self.default, bool):
            described.integer_range = [IntegerRange(from_value=int(self.low), to_value=int(self.high), step=1)]
        return described


def declare(node: Node, parameters: Sequence[NodeParameter]) -> dict[str, Any]:
    """Declare parameters and return name -> value. Raises InputError if a given value cannot be used."""
    values = {}
    for parameter in parameters:
        try:
            values[parameter.name] = node.declare_parameter(
                parameter.name, parameter.default, parameter.descriptor()
            ).value
        except (InvalidParameterTypeException, InvalidParameterValueException) as error:
            raise InputError(f"{node.get_name()}: parameter {parameter.name}: {_reason(parameter, error)}") from None
    return values


def current_values(node: Node, parameters: Sequence[NodeParameter]) -> dict[str, Any]:
    """Name -> present value of declared parameters."""
    return {parameter.name: node.get_parameter(parameter.name).value for parameter in parameters}


def _reason(parameter: NodeParameter, error: Exception) -> str:
    if isinstance(error, InvalidParameterTypeException):
        wanted = {
            str: "text",
            bool: "true or false",
            int: "a whole number",
            float: "a number with a decimal point",
            list: "a list of texts",
        }
        return f"must be {wanted[type(parameter.default)]}, such as {parameter.default!r}"
    return str(error)


def warn_of_unknown(node: Node) -> None:
    """Log a warning for every given parameter that the node does not have; call it once all are declared."""
    ros = ("qos_overrides.", "start_type_description_service")
    known = sorted(name for name in node._parameters if not name.startswith(ros))
    for name in sorted(node._parameter_overrides):
        if not node.has_parameter(name) and not name.startswith("qos_overrides."):
            near = difflib.get_close_matches(name, known, n=1)
            hint = f"did you mean {near[0]}?" if near else f"there are {', '.join(known)}"
            node.get_logger().warning(f"parameter {name} is not known and changes nothing; {hint}")


def on_change(node: Node, change: Callable[[dict[str, Any]], None]) -> None:
    """Call `change` with name -> new value of parameters that are set together. An InputError rejects them all."""

    def accept(parameters: list[Parameter]) -> SetParametersResult:
        try:
            change({parameter.name: parameter.value for parameter in parameters})
        except InputError as error:
            return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    node.add_on_set_parameters_callback(accept)
