"""The node `rocking_controller`: the shell around any controller of `slider_drilling.control`'s protocol."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from typing import Any

from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from rclpy.parameter import Parameter
from rclpy.publisher import Publisher

from slider_drilling.control.controller_loader import (
    DEFAULT_CONTROLLER,
    checked_step,
    configure,
    load_controller,
    set_tool_face_target,
    settings_of,
    statuses_of,
)
from slider_drilling.control.interface import Measurements, RigCommand
from slider_drilling.errors import InputError
from slider_drilling.messages import cdr
from slider_drilling.messages.topics import TOPICS
from slider_drilling.nodes import raw_topics
from slider_drilling.nodes.controller_settings import settings_parameters
from slider_drilling.nodes.diagnostics import DiagnosticsPublisher, Level, Status
from slider_drilling.nodes.lifecycle_node import AUTOSTART, Transitions
from slider_drilling.nodes.own_echoes import OwnEchoes
from slider_drilling.nodes.parameters import NodeParameter, declare, on_change
from slider_drilling.nodes.rig_parameter import RIG_PARAMETER, read_rig, rig_name
from slider_drilling.nodes.sample_inbox import JointReading, SampleInbox
from slider_drilling.nodes.services import reset_service, trigger_service
from slider_drilling.nodes.shutdown import ShutdownRequest
from slider_drilling.nodes.watchdog import Watchdog

PARAMETERS = (
    RIG_PARAMETER,
    NodeParameter("controller", DEFAULT_CONTROLLER, "the controller, as module:Class"),
    NodeParameter(
        "tool_face_target",
        0.0,
        "toolface to hold, also taken from tool_face/target",
        "rad",
        -math.pi,
        math.pi,
        live=True,
    ),
    NodeParameter("stale_after", 1.0, "age at which a channel counts as lost", "s", 0.05, 60.0, live=True),
    AUTOSTART,
)
SET_BACK = 1.0  # s by which a rig's clock goes back when the rig has begun anew


class RockingController(LifecycleNode):
    """Makes Measurements of the rig's topics, steps the controller, publishes its command with the sample's stamp.

    Reads surface channels and MWD only, never truth. Raises InputError for a rig file, controller or parameter that
    cannot be used.
    """

    def __init__(self, halt: ShutdownRequest, **node_options: Any) -> None:
        super().__init__("rocking_controller", **node_options)
        self._halt = halt
        self._values = declare(self, PARAMETERS)
        self._transitions = Transitions(self)
        self._configured = self._active = False
        on_change(self, self._change)
        if self._values["autostart"]:
            self._transitions.start()

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Build the controller, declare its settings, make the topics."""
        return self._transitions.run(self._configure)

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Answer samples."""
        self._active = True
        return TransitionCallbackReturn.SUCCESS

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Give no more commands: what the rig does then is the rig's own affair, as with a controller that died."""
        self._active = False
        return TransitionCallbackReturn.SUCCESS

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Forget controller and topics."""
        self._configured = False
        raw_topics.destroy(self, raw_topics.entities(self) - self._before)
        for name in self._settings:
            self.undeclare_parameter(name)
        return TransitionCallbackReturn.SUCCESS

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """End the program."""
        self._halt.stop()
        return TransitionCallbackReturn.SUCCESS

    def _configure(self) -> None:
        self._before = raw_topics.entities(self)
        values = self._values = {one.name: self.get_parameter(one.name).value for one in PARAMETERS}
        self._rig, _ = read_rig(values["rig"])
        self._target = values["tool_face_target"]
        self._build_controller()
        self._declare_settings()
        self._inbox = SampleInbox(values["stale_after"])
        self._health = DiagnosticsPublisher(self, rig_name(values["rig"]))
        self._stamp_ns: int | None = None  # of the last sample
        self._heard_ns = 0  # this node's clock at the last sample
        self._command: RigCommand | None = None
        self._silence = Watchdog()
        self._silent_from: float | None = None  # s, stamp of the last sample before the rig went silent
        self._echoes = OwnEchoes()
        self._target_publisher = raw_topics.publisher(self, TOPICS["tool_face_target"])
        self._subscribe()
        # Made once the rig's topics are connected: a simulator in lockstep starts when it sees them.
        self._command_publishers: dict[str, Publisher] = {}
        self._timer = self.create_timer(0.02, self._on_timer, clock=Clock(clock_type=ClockType.STEADY_TIME))
        reset_service(self, self._reset)
        trigger_service(self, "start_rocking", lambda: self._set_rocking(1.0))
        trigger_service(self, "stop_rocking", lambda: self._set_rocking(0.0))
        self._configured = True
        self.get_logger().info(f"rocking with {values['controller']}")

    def _build_controller(self) -> None:
        self._controller = load_controller(self._values["controller"], self._rig)
        set_tool_face_target(self._controller, self._target)

    def _declare_settings(self) -> None:
        self._settings: tuple[str, ...] = ()
        settings = settings_of(self._controller)
        if settings is not None:
            declared = settings_parameters(settings)
            configure(self._controller, dataclasses.replace(settings, **declare(self, declared)))
            self._settings = tuple(one.name for one in declared)

    def _reset(self) -> str:
        """A new controller with the settings and the target of the old one."""
        settings = settings_of(self._controller)
        self._build_controller()
        if settings is not None:
            configure(self._controller, settings)
        return f"{self._values['controller']} begins anew"

    def _set_rocking(self, share: float) -> str:
        if "rocking" not in self._settings:
            raise InputError(f"{self._values['controller']} has no setting `rocking`")
        (result,) = self.set_parameters([Parameter("rocking", Parameter.Type.DOUBLE, share)])
        if not result.successful:
            raise InputError(result.reason)
        return "rocking" if share else "the top drive parks"

    def _subscribe(self) -> None:
        # MWD first: where several messages wait, an executor may take them in this order.
        self._mwd = raw_topics.SensorSubscription(self, TOPICS["mwd_tool_face"], self._on_mwd)
        raw_topics.SensorSubscription(self, TOPICS["tool_face_target"], self._on_target)
        self._channels = [
            raw_topics.SensorSubscription(self, TOPICS["standpipe_pressure"], self._on_standpipe_pressure),
            *(
                raw_topics.SensorSubscription(self, TOPICS[name], self._joint_receiver(name))
                for name in ("mud_pump", "draw_works", "top_drive")
            ),
        ]

    def _joint_receiver(self, channel: str) -> Callable[[bytes], None]:
        topic = TOPICS[channel]

        def receive(data: bytes) -> None:
            try:
                reading = JointReading(*cdr.decode_joint_state(data, topic.joint))
            except InputError as error:
                self._unreadable(topic.name, error)
                return
            self._take(channel, reading)

        return receive

    def _on_standpipe_pressure(self, data: bytes) -> None:
        try:
            stamp_ns, pressure, _ = cdr.decode_fluid_pressure(data)
        except InputError as error:
            self._unreadable("standpipe_pressure", error)
            return
        self._take("standpipe_pressure", JointReading(stamp_ns, pressure, math.nan, math.nan))

    def _on_mwd(self, data: bytes) -> None:
        try:
            stamp_ns, tool_face, _, _ = cdr.decode_joint_state(data, "tool_face")
        except InputError as error:
            self._unreadable("mwd/tool_face", error)
            return
        if math.isfinite(tool_face):
            self._inbox.put_mwd(stamp_ns, tool_face)

    def _on_target(self, data: bytes) -> None:
        try:
            _, target, _, _ = cdr.decode_joint_state(data, "tool_face")
        except InputError as error:
            self._unreadable("tool_face/target", error)
            return
        if self._echoes.is_own(data):
            return
        if not math.isfinite(target):
            self.get_logger().warning(f"tool_face/target: {target} rad refused: must be finite")
            return
        target = math.remainder(target, 2.0 * math.pi)
        self.set_parameters([Parameter("tool_face_target", Parameter.Type.DOUBLE, target)])

    def _unreadable(self, topic: str, error: InputError) -> None:
        self.get_logger().warning(f"{topic}: {error}", throttle_duration_sec=5.0)

    def _take(self, channel: str, reading: JointReading) -> None:
        if not self._active:
            return
        if channel == "top_drive":
            if reading == self._inbox.answered and self._command is not None:
                # A simulator that lost sight of this node asks again; a second step would be one too many.
                self._publish_command(reading.stamp_ns, self._command)
                return
            self._begin_anew_with_the_rig(reading.stamp_ns)
        for measurements in self._inbox.put(channel, reading):
            # The clock comes on a topic of its own and may lag behind the sample.
            self._heard_ns = max(self.get_clock().now().nanoseconds, round(measurements.time * 1e9))
            self._silence.note_sample()
            if self._silent_from is not None:
                self.get_logger().info(f"the rig is back at {measurements.time:.1f} s")
            self._silent_from = None
            self._step(measurements)

    def _begin_anew_with_the_rig(self, stamp_ns: int) -> None:
        """A rig whose clock was set back is another run: what the controller believes is of the one before."""
        if self._stamp_ns is not None and (self._stamp_ns - stamp_ns) / 1e9 > SET_BACK:
            self.get_logger().warning(
                f"the rig's clock went back from {self._stamp_ns / 1e9:.1f} to {stamp_ns / 1e9:.1f} s: {self._reset()}"
            )
            self._stamp_ns = None

    def _step(self, measurements: Measurements) -> None:
        if self._halt.error is not None:
            return
        self._stamp_ns = stamp_ns = round(measurements.time * 1e9)
        try:
            command = self._halt.run_interruptible(lambda: checked_step(self._controller, measurements))
        except InputError as error:
            self._halt.fail(error)
            return
        if command is None:
            return
        self._command = command
        if self._health.is_due(stamp_ns):
            self._health.publish(stamp_ns, self._statuses(stamp_ns))
            self._publish_target(stamp_ns)
        self._publish_command(stamp_ns, command)

    def _publish_command(self, stamp_ns: int, command: RigCommand) -> None:
        self._make_command_publishers()
        out = self._command_publishers
        out["mud_pump"].publish(cdr.encode_joint_state(stamp_ns, "mud_pump", None, float(command.pump_speed)))
        out["block"].publish(cdr.encode_joint_state(stamp_ns, "block", None, float(command.block_speed)))
        out["top_drive"].publish(
            cdr.encode_joint_state(
                stamp_ns, "top_drive", float(command.top_drive_angle), float(command.top_drive_speed)
            )
        )

    def _make_command_publishers(self) -> None:
        """The top drive's last: who waits for it then knows the others."""
        if not self._command_publishers:
            topics = (raw_topics.PUMP_COMMAND, TOPICS["draw_works_command"], TOPICS["top_drive_command"])
            self._command_publishers = {topic.joint: raw_topics.publisher(self, topic) for topic in topics}

    def _on_timer(self) -> None:
        """Connect; and notice when the rig has gone silent."""
        if not self._active or self._halt.requested:
            return
        if not self._command_publishers:
            if all(channel.get_publisher_count() > 0 for channel in (*self._channels, self._mwd)):
                self._make_command_publishers()
            return
        if self._stamp_ns is None:
            return
        silent = self._silence.silent_for(self._inbox.stale_after)
        if not self.get_parameter("use_sim_time").value:
            passed_ns = round(silent * 1e9)
        else:
            passed_ns = self.get_clock().now().nanoseconds - self._heard_ns
        if passed_ns > self._inbox.stale_after * 1e9:
            self._step_blindly(self._stamp_ns, passed_ns)
        elif silent:
            self._tell_silence(self._stamp_ns, silent)

    def _step_blindly(self, stamp_ns: int, passed_ns: int) -> None:
        """The rig's clock goes on without readings: the controller is told that there are none."""
        if self._silent_from is None:
            self._silent_from = stamp_ns / 1e9
            self.get_logger().error(f"the rig is silent since {self._silent_from:.1f} s")
        now_ns = round(self._silent_from * 1e9) + passed_ns
        if now_ns - stamp_ns >= 100_000_000:
            self._step(self._inbox.nothing(now_ns))

    def _tell_silence(self, stamp_ns: int, silent: float) -> None:
        """Simulated time stands still: no step, which would be a time that never was, but everybody is told."""
        if self._silent_from is None:
            self._silent_from, self._told_silence = stamp_ns / 1e9, 0.0
            self.get_logger().error(f"no sample and no time from the rig for {silent:.1f} s: paused, or gone")
        if silent - self._told_silence >= 1.0:
            self._told_silence = silent
            self._health.publish(stamp_ns, self._statuses(stamp_ns))

    def _change(self, changes: dict[str, Any]) -> None:
        self._values.update({name: value for name, value in changes.items() if name in self._values})
        if not self._configured:
            return
        settings = settings_of(self._controller)
        own = {name: value for name, value in changes.items() if hasattr(settings, name)}
        if own:
            configure(self._controller, dataclasses.replace(settings, **own))
        self._inbox.stale_after = changes.get("stale_after", self._inbox.stale_after)
        if "tool_face_target" in changes:
            self._set_target(changes["tool_face_target"])
            if self._stamp_ns is not None:
                self._publish_target(self._stamp_ns)

    def _set_target(self, target: float) -> None:
        set_tool_face_target(self._controller, target)
        self._target = target

    def _publish_target(self, stamp_ns: int) -> None:
        data = cdr.encode_joint_state(stamp_ns, "tool_face", self._target)
        self._echoes.add(data)
        self._target_publisher.publish(data)

    def _statuses(self, stamp_ns: int) -> list[Status]:
        stale = self._inbox.stale(stamp_ns)
        if self._silent_from is not None:
            heard = Status(Level.ERROR, "measurements", f"the rig is silent since {self._silent_from:.1f} s")
        elif stale:
            heard = Status(Level.WARN, "measurements", f"no {', '.join(stale)} for {self._inbox.stale_after:g} s")
        else:
            heard = Status(Level.OK, "measurements", "every surface channel is there")
        try:
            return [heard, *statuses_of(self._controller)]
        except InputError as error:
            self._halt.fail(error)
            return [heard]
