"""The node `dashboard`: feeds the live page from the ROS graph and forwards its requests to the nodes."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from rcl_interfaces.msg import ParameterDescriptor, ParameterType
from rcl_interfaces.srv import DescribeParameters, GetParameters, ListParameters, SetParameters
from rclpy.parameter import Parameter
from rclpy.task import Future
from std_msgs.msg import String
from std_srvs.srv import Trigger

from slider_drilling.errors import InputError
from slider_drilling.live.page_requests import (
    DiagnoseNow,
    RequestQueue,
    SetParameter,
    SetRecording,
    SetRocking,
    SetTarget,
)
from slider_drilling.live.server import LOCAL, PORT, Address, PageServer
from slider_drilling.live.state import LiveParameter, LiveState
from slider_drilling.messages.topics import DIAGNOSTICS, TOPICS
from slider_drilling.nodes import raw_topics
from slider_drilling.nodes.diagnostics import read_statuses
from slider_drilling.nodes.guarded import GuardedNode, guarded
from slider_drilling.nodes.joint_names import JOINT_NAMES, named
from slider_drilling.nodes.parameters import NodeParameter, declare, warn_of_unknown
from slider_drilling.nodes.shutdown import ShutdownRequest
from slider_drilling.nodes.spin import steady_timer
from slider_drilling.nodes.twin_subscriptions import subscribe_to_twin
from slider_drilling.plain_names import plain_name
from slider_drilling.rig import parse_rig
from slider_drilling.units import UNITS, display_unit

CONTROLLER, RECORDER, TWIN = "rocking_controller", "recorder", "twin"
ADJUSTABLE_NODES = (CONTROLLER, "friction_simulator")
REQUEST_PERIOD = 0.05  # s of wall time between two looks for requests of the page
PARAMETER_PERIOD = 2.0  # s of wall time between two reads of the nodes' parameters


class Dashboard(GuardedNode):
    """Shows the rig of its namespace on a page, see `slider_drilling.live`."""

    NAME = "dashboard"
    PARAMETERS = (
        NodeParameter("host", LOCAL, "address to serve on; addresses that other machines reach need the token"),
        NodeParameter("port", PORT, "port to serve on; 0: a free one", "-", 0, 65535),
        NodeParameter("units", "si", f"units of the page: {' or '.join(UNITS)}"),
        NodeParameter("token_file", "", "file of the token, made if it is missing; empty: a temporary one if needed"),
        *JOINT_NAMES,
    )

    def __init__(self, shutdown_request: ShutdownRequest | None = None, **node_options: Any) -> None:
        """Serve the page. Raises InputError if a parameter cannot be used or the address is taken."""
        super().__init__(self.NAME, **node_options)
        values = declare(self, self.PARAMETERS)
        warn_of_unknown(self)
        if values["units"] not in UNITS:
            raise InputError(f"dashboard: units = {values['units']!r}: must be {' or '.join(UNITS)}")
        self.state, self.requests = LiveState(), RequestQueue()
        self._joints = values
        self._subscribe()
        self._clients_by_service: dict[tuple[str, str], Any] = {}
        self._adjustable: dict[str, list[LiveParameter]] = {}  # by node
        steady_timer(self, REQUEST_PERIOD, self._serve_requests)
        steady_timer(self, PARAMETER_PERIOD, self._read_parameters)
        address = Address(values["host"], values["port"], values["token_file"])
        if shutdown_request is not None:
            shutdown_request.take_signals()  # the server may make a token file, which must be deleted
        self._server = PageServer(self.state, self.requests, address, UNITS[values["units"]])
        # Without the token: the message is on /rosout and in log files.
        self.get_logger().info(f"live page: {self.url}")

    @property
    def url(self) -> str:
        """The page's address; a shell completes it with the token of a file that only its owner can read."""
        token = self._server.token
        return self._server.url + ("" if token is None else token.query)

    def destroy_node(self) -> None:
        """Stop the page's server, then destroy the node."""
        self._server.stop()
        super().destroy_node()

    def _subscribe(self) -> None:
        state = self.state
        for name, use in (
            ("top_drive", lambda stamp_ns, angle, _, torque: state.add_sample(stamp_ns / 1e9, angle, torque)),
            ("draw_works", lambda stamp_ns, at, _, load: state.set_block(stamp_ns / 1e9, at, load)),
            ("bit_depth", lambda stamp_ns, depth, *_: state.set_bit_depth(stamp_ns / 1e9, depth)),
            ("mud_pump", lambda stamp_ns, _, speed, __: state.set_pump_speed(stamp_ns / 1e9, speed)),
            ("mwd_tool_face", self._on_tool_face),
            ("tool_face_target", lambda stamp_ns, angle, *_: setattr(state, "target", angle)),
            ("truth_bit", lambda stamp_ns, angle, *_: setattr(state, "truth", angle)),
            ("standpipe_pressure", lambda stamp_ns, pressure, _: state.set_pressure(stamp_ns / 1e9, pressure)),
        ):
            topic = named(TOPICS[name], self._joints)
            raw_topics.subscription(self, topic, raw_topics.decoding(self, topic, use))
        subscribe_to_twin(self, state)
        self.create_subscription(DiagnosticArray, DIAGNOSTICS.name, self._on_diagnostics, raw_topics.RELIABLE)
        self.create_subscription(String, raw_topics.RIG_DESCRIPTION.name, self._on_rig_description, raw_topics.LATCHED)

    def _on_tool_face(self, stamp_ns: int, angle: float, velocity: float, effort: float) -> None:
        if math.isfinite(angle):
            self.state.add_tool_face(stamp_ns / 1e9, angle)

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        statuses = read_statuses(message)
        for status in statuses:
            if status.name.rpartition("/")[2] == f"{RECORDER}: log":
                self.state.recording = not status.message.startswith(("paused", "not recording"))
        self.state.update_statuses(statuses)

    def _on_rig_description(self, message: String) -> None:
        try:
            self.state.set_rig(parse_rig(message.data, "rig_description"))
        except InputError as error:
            self.get_logger().error(str(error))
            self.state.add_notice(str(error), success=False)

    def _serve_requests(self) -> None:
        """Forward the page's requests to the nodes."""
        for request in self.requests.take():
            if isinstance(request, SetTarget):
                done = f"target {math.degrees(request.target):.1f} deg"
                self._set_parameter(CONTROLLER, "tool_face_target", request.target, done)
            elif isinstance(request, SetParameter):
                done = _change(request, self.state.parameters())
                self._set_parameter(request.node, request.name, request.value, done)
            elif isinstance(request, SetRocking):
                self._trigger(f"{CONTROLLER}/{'start_rocking' if request.on else 'stop_rocking'}")
            elif isinstance(request, SetRecording):
                self._trigger(f"{RECORDER}/{'resume' if request.on else 'pause'}")
            elif isinstance(request, DiagnoseNow):
                self._trigger(f"{TWIN}/diagnose")

    def _set_parameter(self, node: str, name: str, value: float, change: str) -> None:
        """change: how a notice names it."""
        request = SetParameters.Request(parameters=[Parameter(name, value=float(value)).to_parameter_msg()])

        def on_answer(future: Future) -> None:
            (result,) = future.result().results
            refusal = "" if result.successful else f": refused: {result.reason}"
            self.state.add_notice(f"{change}{refusal}", result.successful)
            self._adjustable.pop(node, None)

        self._call(SetParameters, f"{node}/set_parameters", request, on_answer)

    def _trigger(self, service: str) -> None:
        def on_answer(future: Future) -> None:
            answer = future.result()
            action = plain_name(service.rpartition("/")[2])
            self.state.add_notice(f"{action}: {answer.message or 'done'}", answer.success)

        self._call(Trigger, service, Trigger.Request(), on_answer)

    def _call(
        self, kind: Any, service: str, request: Any, on_answer: Callable[[Future], None], quiet: bool = False
    ) -> None:
        """Call a service if a node offers it; otherwise leave a notice, unless quiet."""
        key = (service, kind.__name__)
        if key not in self._clients_by_service:
            self._clients_by_service[key] = self.create_client(kind, service)
        client = self._clients_by_service[key]
        if client.service_is_ready():
            node = service.partition("/")[0]
            forget = partial(self._adjustable.pop, node, None)  # its parameters may be others by now: read them again
            answered = guarded(self, f"the answer of {service}", on_answer, on_fault=forget)
            client.call_async(request).add_done_callback(answered)
        elif not quiet:
            self.state.add_notice(f"{service}: no node offers it", success=False)

    def _read_parameters(self) -> None:
        """Find the parameters that can change, then read their values."""
        for node in ADJUSTABLE_NODES:
            if node in self._adjustable:
                self._read_values(node, self._adjustable[node])
            else:
                request, on_answer = ListParameters.Request(), partial(self._on_names, node)
                self._call(ListParameters, f"{node}/list_parameters", request, on_answer, quiet=True)

    def _on_names(self, node: str, future: Future) -> None:
        request = DescribeParameters.Request(names=list(future.result().result.names))
        on_answer = partial(self._on_descriptors, node)
        self._call(DescribeParameters, f"{node}/describe_parameters", request, on_answer, quiet=True)

    def _on_descriptors(self, node: str, future: Future) -> None:
        """Keep the numbers that may change and have a range; the page has its own control for the target."""
        self._adjustable[node] = [
            _live_parameter(node, descriptor)
            for descriptor in future.result().descriptors
            if descriptor.type == ParameterType.PARAMETER_DOUBLE
            and not descriptor.read_only
            and descriptor.floating_point_range
            and descriptor.name != "tool_face_target"
        ]
        self._read_values(node, self._adjustable[node])

    def _read_values(self, node: str, parameters: list[LiveParameter]) -> None:
        def on_answer(future: Future) -> None:
            values = [value.double_value for value in future.result().values]
            self.state.update_parameters(
                replace(parameter, value=value) for parameter, value in zip(parameters, values, strict=True)
            )

        request = GetParameters.Request(names=[parameter.name for parameter in parameters])
        self._call(GetParameters, f"{node}/get_parameters", request, on_answer, quiet=True)


def _change(request: SetParameter, known: Sequence[LiveParameter]) -> str:
    """How a notice names a change of a parameter, in the units of texts."""
    of = (request.node, request.name)
    unit, factor = display_unit(next((each.unit for each in known if (each.node, each.name) == of), "-"))
    return f"{request.name} = {request.value * factor:.6g}" + ("" if unit == "-" else f" {unit}")


def _live_parameter(node: str, descriptor: ParameterDescriptor) -> LiveParameter:
    """A parameter as the page shows it, its value not known yet."""
    limits = descriptor.floating_point_range[0]
    description, _, unit = descriptor.description.rpartition(" [")  # see NodeParameter.descriptor
    return LiveParameter(
        node,
        descriptor.name,
        math.nan,
        unit.rstrip("]") if description else "-",
        limits.from_value,
        limits.to_value,
        description or unit,
    )
