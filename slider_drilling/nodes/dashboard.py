"""The node `dashboard`: feeds the live page from the graph, and asks the graph what the page asks for."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from rcl_interfaces.msg import ParameterType
from rcl_interfaces.srv import DescribeParameters, GetParameters, ListParameters, SetParameters
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.task import Future
from std_msgs.msg import String
from std_srvs.srv import Trigger

from slider_drilling.errors import InputError
from slider_drilling.live.page_requests import RequestQueue, SetParameter, SetRecording, SetRocking, SetTarget
from slider_drilling.live.server import LOCAL, PORT, Address, PageServer
from slider_drilling.live.state import LiveParameter, LiveState
from slider_drilling.messages import cdr
from slider_drilling.messages.topics import DIAGNOSTICS, TOPICS
from slider_drilling.nodes import raw_topics
from slider_drilling.nodes.diagnostics import Level, Status
from slider_drilling.nodes.parameters import NodeParameter, declare
from slider_drilling.nodes.shutdown import ShutdownRequest
from slider_drilling.rig import parse_rig

PARAMETERS = (
    NodeParameter("host", LOCAL, "address to serve on; any but this machine's own asks for the token"),
    NodeParameter("port", PORT, "port to serve on; 0: a free one", "-", 0, 65535),
    NodeParameter("token", "", "letters and digits that whoever comes from another machine must know; empty: made up"),
)
CONTROLLER, RECORDER = "rocking_controller", "recorder"
ADJUSTABLE = (CONTROLLER, "friction_simulator")
_WISHES, _SETTINGS = 0.05, 2.0  # s between looks at the desk, at the parameters


class Dashboard(Node):
    """Shows the rig of its namespace on a page, see `slider_drilling.live`. Raises InputError."""

    def __init__(self, halt: ShutdownRequest, **node_options: Any) -> None:
        super().__init__("dashboard", **node_options)
        values = declare(self, PARAMETERS)
        self.state, self._desk = LiveState(), RequestQueue()
        self._subscribe()
        self._clients_of: dict[tuple[str, str], Any] = {}
        self._described: dict[str, list[LiveParameter]] = {}
        wall = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(_WISHES, self._grant, clock=wall)
        self.create_timer(_SETTINGS, self._look_at_settings, clock=wall)
        self._server = PageServer(self.state, self._desk, Address(values["host"], values["port"], values["token"]))
        self.get_logger().info(f"live page: {self._server.url}")

    @property
    def url(self) -> str:
        """Where the page is, token included."""
        return self._server.url

    def destroy_node(self) -> None:
        """Take the page down, then the node."""
        self._server.stop()
        super().destroy_node()

    def _subscribe(self) -> None:
        raw_topics.subscription(self, TOPICS["top_drive"], self._joint("top_drive", self._on_top_drive))
        raw_topics.subscription(self, TOPICS["mud_pump"], self._joint("mud_pump", self._on_pump))
        raw_topics.subscription(self, TOPICS["mwd_tool_face"], self._joint("tool_face", self._on_tool_face))
        raw_topics.subscription(self, TOPICS["tool_face_target"], self._joint("tool_face", self._on_target))
        raw_topics.subscription(self, TOPICS["truth_bit"], self._joint("bit", self._on_truth))
        raw_topics.subscription(self, TOPICS["standpipe_pressure"], self._on_pressure)
        self.create_subscription(DiagnosticArray, DIAGNOSTICS.name, self._on_diagnostics, raw_topics.RELIABLE)
        self.create_subscription(String, raw_topics.RIG_DESCRIPTION.name, self._on_rig, raw_topics.LATCHED)

    def _joint(self, joint: str, take: Callable[[float, float, float], None]) -> Callable[[bytes], None]:
        def receive(data: bytes) -> None:
            try:
                stamp_ns, position, velocity, effort = cdr.decode_joint_state(data, joint)
            except InputError as error:
                self.get_logger().warning(f"{joint}: {error}", throttle_duration_sec=5.0)
                return
            take(stamp_ns / 1e9, position, velocity if joint == "mud_pump" else effort)

        return receive

    def _on_top_drive(self, time: float, angle: float, torque: float) -> None:
        self.state.take_top_drive(time, angle, torque)

    def _on_pump(self, time: float, angle: float, speed: float) -> None:
        self.state.take_pump(time, speed)

    def _on_tool_face(self, measured_at: float, angle: float, torque: float) -> None:
        if math.isfinite(angle):
            self.state.take_tool_face(measured_at, angle)

    def _on_target(self, time: float, angle: float, torque: float) -> None:
        self.state.target = angle

    def _on_truth(self, time: float, angle: float, torque: float) -> None:
        self.state.truth = angle

    def _on_pressure(self, data: bytes) -> None:
        try:
            stamp_ns, pressure, _ = cdr.decode_fluid_pressure(data)
        except InputError as error:
            self.get_logger().warning(f"standpipe_pressure: {error}", throttle_duration_sec=5.0)
            return
        self.state.take_pressure(stamp_ns / 1e9, pressure)

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        statuses = []
        for one in message.status:
            level = int.from_bytes(one.level, "little") if isinstance(one.level, bytes) else int(one.level)
            values = tuple((pair.key, pair.value) for pair in one.values)
            statuses.append(Status(Level(min(level, Level.ERROR)), one.name, one.message, values))
            if one.name == f"{RECORDER}: log":
                self.state.recording = one.message != "paused"
        self.state.take_statuses(statuses)

    def _on_rig(self, message: String) -> None:
        try:
            self.state.take_rig(parse_rig(message.data, "rig_description"))
        except InputError as error:
            self.get_logger().error(str(error))
            self.state.add_notice(str(error), good=False)

    def _grant(self) -> None:
        """Ask the graph for what the page asks for."""
        for wish in self._desk.take():
            if isinstance(wish, SetTarget):
                self._set(CONTROLLER, "tool_face_target", wish.target, f"target {math.degrees(wish.target):.1f} deg")
            elif isinstance(wish, SetParameter):
                self._set(wish.node, wish.name, wish.value, f"{wish.name} = {wish.value:g}")
            elif isinstance(wish, SetRocking):
                self._trigger(f"{CONTROLLER}/{'start_rocking' if wish.on else 'stop_rocking'}")
            elif isinstance(wish, SetRecording):
                self._trigger(f"{RECORDER}/{'resume' if wish.on else 'pause'}")

    def _set(self, node: str, name: str, value: float, what: str) -> None:
        request = SetParameters.Request(parameters=[Parameter(name, value=float(value)).to_parameter_msg()])

        def done(future: Future) -> None:
            (result,) = future.result().results
            self.state.add_notice(what if result.successful else f"{what}: refused: {result.reason}", result.successful)
            self._described.pop(node, None)

        self._call(SetParameters, f"{node}/set_parameters", request, done)

    def _trigger(self, service: str) -> None:
        def done(future: Future) -> None:
            answer = future.result()
            what = service.rpartition("/")[2].replace("_", " ")
            self.state.add_notice(f"{what}: {answer.message or 'done'}", answer.success)

        self._call(Trigger, service, Trigger.Request(), done)

    def _call(self, kind: Any, service: str, request: Any, done: Callable[[Future], None], quiet: bool = False) -> None:
        """Call a service whose server is there; say so where it is not."""
        key = (service, kind.__name__)
        if key not in self._clients_of:
            self._clients_of[key] = self.create_client(kind, service)
        client = self._clients_of[key]
        if client.service_is_ready():
            client.call_async(request).add_done_callback(done)
        elif not quiet:
            self.state.add_notice(f"{service}: no node offers it", good=False)

    def _look_at_settings(self) -> None:
        """Learn which parameters can change, then keep an eye on their values."""
        for node in ADJUSTABLE:
            if node in self._described:
                self._read_values(node, self._described[node])
            else:
                self._call(
                    ListParameters,
                    f"{node}/list_parameters",
                    ListParameters.Request(),
                    partial(self._on_names, node),
                    quiet=True,
                )

    def _on_names(self, node: str, future: Future) -> None:
        names = list(future.result().result.names)
        self._call(
            DescribeParameters,
            f"{node}/describe_parameters",
            DescribeParameters.Request(names=names),
            partial(self._on_described, node),
            quiet=True,
        )

    def _on_described(self, node: str, future: Future) -> None:
        """Numbers that may change and have a range."""
        found = []
        for one in future.result().descriptors:
            if one.type != ParameterType.PARAMETER_DOUBLE or one.read_only or not one.floating_point_range:
                continue
            if one.name == "tool_face_target":
                continue  # the page has a control of its own for it
            limits = one.floating_point_range[0]
            about, _, unit = one.description.rpartition(" [")
            found.append(
                LiveParameter(
                    node,
                    one.name,
                    math.nan,
                    unit.rstrip("]") if about else "-",
                    limits.from_value,
                    limits.to_value,
                    about or unit,
                )
            )
        self._described[node] = found
        self._read_values(node, found)

    def _read_values(self, node: str, settings: list[LiveParameter]) -> None:
        def done(future: Future) -> None:
            values = [one.double_value for one in future.result().values]
            self.state.take_parameters(
                LiveParameter(node, one.name, value, one.unit, one.low, one.high, one.about)
                for one, value in zip(settings, values, strict=True)
            )

        request = GetParameters.Request(names=[one.name for one in settings])
        self._call(GetParameters, f"{node}/get_parameters", request, done, quiet=True)
