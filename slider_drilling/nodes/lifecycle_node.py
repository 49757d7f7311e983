"""The base of the package's lifecycle nodes (https://design.ros2.org/articles/node_lifecycle.html)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar

from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from rclpy.timer import Timer

from slider_drilling.errors import InputError
from slider_drilling.nodes.guarded import GuardedNode
from slider_drilling.nodes.parameters import NodeParameter, current_values, declare, on_change, warn_of_unknown
from slider_drilling.nodes.raw_topics import destroy, entities
from slider_drilling.nodes.shutdown import ShutdownRequest
from slider_drilling.nodes.spin import steady_timer

AUTOSTART = NodeParameter("autostart", True, "configure and activate on start; false: a lifecycle manager does it")


class ManagedNode(GuardedNode, LifecycleNode):
    """A lifecycle node that declares its parameters, runs its transitions and reports why one failed.

    A subclass sets `NAME` and `PARAMETERS` and overrides the hooks `configure`, `activate`, `deactivate`, `end`,
    `cleanup` and `apply_changes`. Publishers, subscriptions, services and timers that `configure` makes are destroyed
    on cleanup.

    Attributes:
        values: The value of each parameter, by name.
        is_configured: Whether the node is inactive or active.
        is_active: Whether the node is active.
        shutdown_request: Where the node asks the program to end, or reports the error that ends it.
    """

    NAME: ClassVar[str]
    PARAMETERS: ClassVar[tuple[NodeParameter, ...]]

    def __init__(self, shutdown_request: ShutdownRequest | None = None, **node_options: Any) -> None:
        """Declare the parameters and, with `autostart`, configure and activate.

        Args:
            shutdown_request: Shared by the nodes of one program; by default the node has its own.
            node_options: Passed to `rclpy.lifecycle.LifecycleNode`.

        Raises:
            InputError: A parameter, or a file that a parameter names, cannot be used.
        """
        super().__init__(self.NAME, **node_options)
        self._refuse_invalid_transitions()
        self.shutdown_request = shutdown_request or ShutdownRequest()
        self.is_configured = self.is_active = False
        self._transition_error: Exception | None = None
        self._own_timers: set[Timer] = set()
        self._is_autostarting = False
        self.values = declare(self, self.PARAMETERS)
        on_change(self, self._on_change)
        if self.values["autostart"]:
            self._autostart()

    def _refuse_invalid_transitions(self) -> None:
        """Answer a request for a transition that this state does not have with success = false.

        rclpy raises instead, which would end the program.
        """
        service = self._service_change_state
        change_state = service.callback

        def guarded(request: Any, response: Any) -> Any:
            try:
                return change_state(request, response)
            except rclpy_implementation.RCLError as error:
                name = request.transition.label or request.transition.id
                state = self._state_machine.current_state[1]
                self.get_logger().warning(f"transition {name} refused in state {state}: {str(error).splitlines()[0]}")
                response.success = False
                return response

        service.callback = guarded

    def configure(self) -> None:
        """Make what the node works with: files, topics, services, timers."""

    def activate(self) -> None:
        """Start the work."""

    def deactivate(self) -> None:
        """Pause the work."""

    def end(self) -> None:
        """Do what must be done before the program ends, while messages can still be sent."""

    def cleanup(self) -> None:
        """Release what `configure` acquired, apart from ROS entities; also called after `configure` failed."""

    def apply_changes(self, changes: dict[str, Any]) -> None:
        """Use new parameter values (name -> value) while configured. An InputError rejects them."""

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Run `configure`."""
        return self._run_transition(self._configure)

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Run `activate`."""
        self.is_active = True
        result = self._run_transition(self.activate)
        self.is_active = result == TransitionCallbackReturn.SUCCESS
        return result

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Run `deactivate`."""
        self.is_active = False
        return self._run_transition(self.deactivate)

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Destroy what `configure` made and run `cleanup`."""
        return self._run_transition(self._cleanup)

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """End the program."""
        self.shutdown_request.stop()
        return TransitionCallbackReturn.SUCCESS

    def replace_timer(self, timer: Timer, period: float, callback: Callable[[], None]) -> Timer:
        """Destroy a timer of `configure` and return another one in its place; period: s of wall time."""
        self.destroy_timer(timer)
        self._own_timers.discard(timer)
        self._own_timers.add(replacement := steady_timer(self, period, callback))
        return replacement

    def _configure(self) -> None:
        self._inherited = entities(self)
        self.values = current_values(self, self.PARAMETERS)
        try:
            self.configure()
        except BaseException:
            self._own_timers = set(self.timers) - self._inherited
            self._cleanup()
            raise
        self._own_timers = set(self.timers) - self._inherited
        self.is_configured = True
        warn_of_unknown(self)

    def _cleanup(self) -> None:
        self.is_configured = False
        # Timers made after `configure` belong to the program that spins this node.
        destroy(self, entities(self) - self._inherited - (set(self.timers) - self._own_timers))
        self.cleanup()

    def _run_transition(self, work: Callable[[], None]) -> TransitionCallbackReturn:
        """Run the work of a transition. If it raises, the transition fails and the node keeps its state."""
        try:
            work()
        except Exception as error:
            self._transition_error = error  # rclpy would swallow it
            if not self._is_autostarting:
                kind = "" if isinstance(error, InputError) else f"{type(error).__name__}: "
                self.get_logger().error(f"{kind}{error}")
            return TransitionCallbackReturn.FAILURE
        return TransitionCallbackReturn.SUCCESS

    def _autostart(self) -> None:
        """Configure and activate. Raises what a transition raised."""
        self._is_autostarting = True
        for trigger in (self.trigger_configure, self.trigger_activate):
            trigger()
            if self._transition_error is not None:
                raise self._transition_error
        self._is_autostarting = False

    def _on_change(self, changes: dict[str, Any]) -> None:
        previous = self.values
        self.values = previous | {name: value for name, value in changes.items() if name in previous}
        if not self.is_configured:
            return
        try:
            self.apply_changes(changes)
        except InputError:
            self.values = previous
            raise
