"""What a running node can be told to do, as services of standard types."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.node import Node
from std_srvs.srv import Trigger

from slider_drilling.errors import InputError


def trigger_service(node: Node, name: str, act: Callable[[], str]) -> None:
    """`~/name` of std_srvs/Trigger. act: returns what it did, raises InputError with what stood in its way."""

    def serve(request: Any, response: Any) -> Any:
        return _answered(response, act)

    node.create_service(Trigger, f"~/{name}", serve)


def stepping_services(node: Node, pause: Callable[[bool], str], step: Callable[[], str]) -> None:
    """`~/pause`, `~/resume` and `~/step` of std_srvs/Trigger; pause: told True to pause, False to go on."""
    trigger_service(node, "pause", lambda: pause(True))
    trigger_service(node, "resume", lambda: pause(False))
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
