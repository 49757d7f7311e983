"""What a running node can be told to do, as services of standard types."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.node import Node
from std_srvs.srv import SetBool, Trigger

from slider_drilling.errors import InputError


def trigger_service(node: Node, name: str, act: Callable[[], str]) -> None:
    """`~/name` of std_srvs/Trigger. act: returns what it did, raises InputError with what stood in its way."""

    def serve(request: Any, response: Any) -> Any:
        return _answered(response, act)

    node.create_service(Trigger, f"~/{name}", serve)


def stepping_services(node: Node, pause: Callable[[bool], str], step: Callable[[], str]) -> None:
    """`~/pause` of std_srvs/SetBool and `~/step` of std_srvs/Trigger."""

    def serve(request: Any, response: Any) -> Any:
        return _answered(response, lambda: pause(request.data))

    node.create_service(SetBool, "~/pause", serve)
    trigger_service(node, "step", step)


def reset_service(node: Node, reset: Callable[[], str]) -> None:
    """`~/reset` of std_srvs/Trigger."""
    trigger_service(node, "reset", reset)


def _answered(response: Any, act: Callable[[], str]) -> Any:
    try:
        response.success, response.message = True, act()
    except InputError as error:
        response.success, response.message = False, str(error)
    return response
