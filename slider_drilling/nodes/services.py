"""Services of a running node, of standard types."""

from __future__ import annotations

from collections.abc import Callable

from rclpy.node import Node
from std_srvs.srv import Trigger

from slider_drilling.errors import InputError


def trigger_service(node: Node, name: str, act: Callable[[], str]) -> None:
    """Offer `~/name` of type std_srvs/Trigger; `act` returns what it did, or raises InputError if it cannot."""

    def serve(request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        try:
            response.success, response.message = True, act()
        except InputError as error:
            response.success, response.message = False, str(error)
        return response

    node.create_service(Trigger, f"~/{name}", serve)


def stepping_services(node: Node, pause: Callable[[bool], str], step: Callable[[], str]) -> None:
    """Offer `~/pause`, `~/resume` and `~/step`; `pause` is called with True to pause and False to resume."""
    trigger_service(node, "pause", lambda: pause(True))
    trigger_service(node, "resume", lambda: pause(False))
    trigger_service(node, "step", step)


def reset_service(node: Node, reset: Callable[[], str]) -> None:
    """Offer `~/reset`."""
    trigger_service(node, "reset", reset)
