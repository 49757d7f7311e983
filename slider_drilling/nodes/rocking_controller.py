"""The node `rocking_controller`: runs any controller of the protocol in `slider_drilling.control`."""

from __future__ import annotations

import dataclasses
import math
import time
from collections.abc import Callable
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.parameter import Parameter

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
from slider_drilling.messages.health import Level, Status
from slider_drilling.messages.topics import DIAGNOSTICS, TOPICS
from slider_drilling.nodes import raw_topics
from slider_drilling.nodes.clock_check import SET_BACK, ClockFaultReports, clock_offset_message, is_on_clock
from slider_drilling.nodes.command_publishers import CommandPublishers
from slider_drilling.nodes.controller_settings import settings_parameters
from slider_drilling.nodes.diagnostics import DiagnosticsPublisher, read_statuses
from slider_drilling.nodes.drive_subscriptions import COMMON_TOPIC, drive_subscriptions
from slider_drilling.nodes.joint_names import JOINT_NAMES, named
from slider_drilling.nodes.lifecycle_node import AUTOSTART, ManagedNode
from slider_drilling.nodes.parameters import NodeParameter, declare
from slider_drilling.nodes.programme_run import ProgrammeRun
from slider_drilling.nodes.rig_parameter import RIG_PARAMETER, read_rig, rig_name
from slider_drilling.nodes.safe_stop import safe_stop
from slider_drilling.nodes.sample_inbox import JointReading, SampleInbox
from slider_drilling.nodes.services import reset_service, trigger_service
from slider_drilling.nodes.spin import steady_timer
from slider_drilling.nodes.target_topic import TargetTopic
from slider_drilling.nodes.twin_status_relay import TwinStatusRelay
from slider_drilling.nodes.watchdog import SILENCE_PERIOD, Watchdog
from slider_drilling.programmes.progress import ProgrammeProgress

WATCH_PERIOD = 0.02  # s of wall time between checks for connections and silence
BLIND_STEP_NS = 100_000_000  # interval of steps without readings
LEAVE_TIME = 3.0  # s of wall time that a simulator may take from its last sample to its end
REPORT_PERIOD = 5.0  # s of wall time between reports of what the node waits for, and between those of its clock


class RockingController(ManagedNode):
    """Collects measurements from the rig's topics, steps the controller and publishes its command.

    Commands carry the stamp of the sample that they answer. The node reads surface channels and MWD only, never truth.
    An end of the node, or of its activity, stops block and top drive.
    """

    NAME = "rocking_controller"
    PARAMETERS = (
        RIG_PARAMETER,
        NodeParameter("controller", DEFAULT_CONTROLLER, "the controller, as module:Class"),
        NodeParameter("programme", "", "programme or slide sheet to run in place of a controller; empty: none"),
        NodeParameter("end_with_programme", False, "end the node when its programme has ended"),
        NodeParameter("tool_face_target", 0.0, "toolface to hold, also taken from tool_face/target", "rad",
                      -math.pi, math.pi, live=True),
        NodeParameter("stale_after", 1.0, "age at which a channel counts as lost", "s", 0.05, 60.0, live=True),
        COMMON_TOPIC,
        *JOINT_NAMES,
        NodeParameter("atomic_command", False, "publish one command of all drives on drives/command, instead of three"),
        AUTOSTART,
    )  # fmt: skip

    _settings: tuple[str, ...] = ()  # the controller's own, declared as parameters

    def configure(self) -> None:
        """Build the controller, declare its settings, make the topics."""
        values = self.values
        self._rig, _ = read_rig(values["rig"])
        self._target = values["tool_face_target"]
        self._programme = ProgrammeRun(values["programme"], values["end_with_programme"])
        self._build_controller()
        self._declare_settings()
        self._inbox = SampleInbox(values["stale_after"])
        self._diagnostics = DiagnosticsPublisher(self, rig_name(values["rig"]))
        self._stamp_ns: int | None = None  # of the last step
        self._sample_ns: int | None = None  # of the last sample
        self._received_ns = 0  # this node's clock at the last sample
        self._clock_fault = ""  # what is wrong with the samples' stamps
        self._clock_reports = ClockFaultReports(time.monotonic())
        self._last_report = time.monotonic()
        self._command: RigCommand | None = None
        self._watchdog = Watchdog()
        self._twin_relay = TwinStatusRelay()
        self._silent_from: float | None = None  # s, stamp of the last sample before the rig went silent
        self._reported_silence = 0.0  # s of wall time
        self._is_silence_logged = False
        self._subscribe()
        self._commands = CommandPublishers(self, self.values)
        steady_timer(self, WATCH_PERIOD, self._on_timer)
        reset_service(self, self._reset)
        trigger_service(self, "start_rocking", lambda: self._set_rocking(1.0))
        trigger_service(self, "stop_rocking", lambda: self._set_rocking(0.0))
        trigger_service(self, "abort", lambda: self._programme.abort("asked for by the service abort"))
        running = self._programme.path or values["controller"]
        self.get_logger().info(f"{'running' if self._programme.path else 'rocking with'} {running}")

    def activate(self) -> None:
        """Listen from now on: what came before, and that nothing was heard, does not count."""
        self._inbox.clear()
        self._watchdog.restart()
        self._received_ns = self.get_clock().now().nanoseconds
        self._silent_from = None
        self._clock_reports = ClockFaultReports(time.monotonic())
        self._last_report = time.monotonic()

    def deactivate(self) -> None:
        """Stop block and top drive. A programme is aborted: the rig may be elsewhere when the node is active again."""
        if self._programme.path:
            self._programme.abort("the node was deactivated")
        self.stop_rig()

    def end(self) -> None:
        """Stop block and top drive before the program ends."""
        if self.is_active:
            self.stop_rig()

    def stop_rig(self) -> None:
        """Command the rig, if it is there, to stop the block and to hold the top drive where it comes to rest."""
        if self._command is None or self._sample_ns is None or self._channels[-1].get_publisher_count() == 0:
            return
        last = self._inbox.last_reading
        angle, speed = (math.nan, math.nan) if last is None else (last.position, last.velocity)
        self._command = safe_stop(self._command, angle, speed, self._rig.top_drive.max_acceleration)
        self._commands.publish(self._stamp_ns or self._sample_ns, self._command)

    def cleanup(self) -> None:
        """Undeclare the controller's settings."""
        for name in self._settings:
            self.undeclare_parameter(name)
        self._settings = ()

    def apply_changes(self, changes: dict[str, Any]) -> None:
        """Use new settings of the controller, a new target or another age of lost channels."""
        if "tool_face_target" in changes and self._programme.path:
            raise InputError(f"tool_face_target: {self._programme.path} gives the toolface of each slide")
        settings = settings_of(self._controller)
        own = {name: value for name, value in changes.items() if hasattr(settings, name)}
        if own:
            configure(self._controller, dataclasses.replace(settings, **own))
        self._inbox.stale_after = changes.get("stale_after", self._inbox.stale_after)
        if "tool_face_target" in changes:
            set_tool_face_target(self._controller, changes["tool_face_target"])
            self._target = changes["tool_face_target"]
            if self._stamp_ns is not None:
                self._publish_target(self._stamp_ns)

    @property
    def programme_progress(self) -> ProgrammeProgress | None:
        """How far the programme is; None where the node runs another controller."""
        return self._programme.progress

    @property
    def settings(self) -> Any:
        """The controller's settings; None if it has none."""
        return settings_of(self._controller)

    def _publish_target(self, stamp_ns: int) -> None:
        """Publish the toolface that is held; a programme holds none between its slides."""
        target = self._programme.held_tool_face(self._target)
        if target is not None:
            self._target_topic.publish(stamp_ns, target)

    def _build_controller(self) -> None:
        if self._programme.path:
            self._controller = self._programme.load(self._rig)
            return
        self._controller = load_controller(self.values["controller"], self._rig)
        set_tool_face_target(self._controller, self._target)

    def _declare_settings(self) -> None:
        settings = self.settings
        if settings is not None:
            parameters = settings_parameters(settings)
            configure(self._controller, dataclasses.replace(settings, **declare(self, parameters)))
            self._settings = tuple(parameter.name for parameter in parameters)

    def _reset(self) -> str:
        """Replace the controller by a new one with the same settings and target."""
        settings = self.settings
        self._build_controller()
        if settings is not None:
            configure(self._controller, settings)
        return f"{self._programme.path or self.values['controller']} starts anew"

    def _set_rocking(self, share: float) -> str:
        if "rocking" not in self._settings:
            raise InputError(f"{self.values['controller']} has no setting `rocking`")
        (result,) = self.set_parameters([Parameter("rocking", Parameter.Type.DOUBLE, share)])
        if not result.successful:
            raise InputError(result.reason)
        return "rocking" if share else "the top drive parks"

    def _subscribe(self) -> None:
        # MWD first: if several messages wait, an executor may take them in this order.
        self._mwd = self._sensor("mwd_tool_face", self._on_mwd)
        self._target_topic = TargetTopic(self, self._take_target)
        self.create_subscription(DiagnosticArray, DIAGNOSTICS.name, self._on_diagnostics, raw_topics.RELIABLE)
        drives = drive_subscriptions(self, self.values, self._joint_receiver)
        self._channels = [self._sensor("standpipe_pressure", self._on_standpipe_pressure), *drives]

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        self._twin_relay.take(read_statuses(message))

    def _sensor(self, name: str, receive: Callable[..., None]) -> raw_topics.SensorSubscription:
        topic = named(TOPICS[name], self.values)
        return raw_topics.SensorSubscription(self, topic, raw_topics.decoding(self, topic, receive))

    def _joint_receiver(self, channel: str) -> Callable[..., None]:
        return lambda *fields: self._receive(channel, JointReading(*fields))

    def _on_standpipe_pressure(self, stamp_ns: int, pressure: float, variance: float) -> None:
        self._receive("standpipe_pressure", JointReading(stamp_ns, pressure, math.nan, math.nan))

    def _on_mwd(self, stamp_ns: int, tool_face: float, velocity: float, effort: float) -> None:
        if self.is_active and math.isfinite(tool_face):
            self._inbox.put_mwd(stamp_ns, tool_face)

    def _take_target(self, target: float) -> None:
        """Hold another target, rad."""
        self.set_parameters([Parameter("tool_face_target", Parameter.Type.DOUBLE, target)])

    def _receive(self, channel: str, reading: JointReading) -> None:
        """Take one reading; step the controller once a sample is complete."""
        if not self.is_active:
            return
        if channel == "top_drive":
            if reading == self._inbox.last_reading and self._command is not None:
                # The simulator sends a sample again if the answer was lost. A second step would be one too many.
                self._commands.publish(reading.stamp_ns, self._command)
                return
            self._reset_if_clock_went_back(reading.stamp_ns)
            self._sample_ns = reading.stamp_ns
        for measurements in self._inbox.put(channel, reading):
            now_ns, stamp_ns = self.get_clock().now().nanoseconds, round(measurements.time * 1e9)
            # The clock comes on its own topic and may lag behind the sample.
            self._received_ns = max(now_ns, stamp_ns)
            self._watchdog.note_sample()
            self._check_clock(stamp_ns, now_ns)
            if self._stamp_ns is not None and stamp_ns < self._stamp_ns:
                continue  # it waited while the controller was stepped without readings: time never goes back
            if self._silent_from is not None:
                self.get_logger().info(f"the rig is back at {measurements.time:.1f} s")
            self._silent_from = None
            self._step(measurements)

    def _reset_if_clock_went_back(self, stamp_ns: int) -> None:
        """If the rig's clock was set back, this is another run: the controller's estimates do not hold for it.

        A programme does not begin again by itself.
        """
        if self._sample_ns is not None and (self._sample_ns - stamp_ns) / 1e9 > SET_BACK:
            back = f"the rig's clock went back from {self._sample_ns / 1e9:.1f} to {stamp_ns / 1e9:.1f} s"
            outcome = self._programme.abort(back) if self._programme.path else self._reset()
            self.get_logger().warning(f"{back}: {outcome}")
            self._stamp_ns = None

    def _check_clock(self, stamp_ns: int, now_ns: int) -> None:
        """Say if the rig's stamps come from another clock than this node's; the status says so all the time."""
        sim_time = bool(self.get_parameter("use_sim_time").value)
        self._clock_fault = clock_offset_message(stamp_ns, now_ns, sim_time)
        offset = (stamp_ns - now_ns) / 1e9
        if self._clock_reports.is_due(self._clock_fault, offset, time.monotonic(), REPORT_PERIOD):
            self.get_logger().warning(self._clock_fault)

    def _report(self, message: str) -> None:
        if time.monotonic() - self._last_report > REPORT_PERIOD:
            self._last_report = time.monotonic()
            self.get_logger().warning(message)

    def _step(self, measurements: Measurements) -> None:
        if self.shutdown_request.error is not None:
            return
        self._stamp_ns = stamp_ns = round(measurements.time * 1e9)
        try:
            command = self.shutdown_request.run_interruptible(lambda: checked_step(self._controller, measurements))
        except InputError as error:
            self.shutdown_request.fail(error)
            return
        if command is None:
            return
        self._command = command
        if self._diagnostics.is_due(stamp_ns):
            self._diagnostics.publish(stamp_ns, self._statuses(stamp_ns))
            self._publish_target(stamp_ns)
        self._commands.publish(stamp_ns, command)
        if self._programme.ends_node(measurements.time):
            self.shutdown_request.stop()

    def _on_timer(self) -> None:
        """Connect to the rig; then watch for its silence."""
        is_catching_up = self._watchdog.tick()
        if not self.is_active or self.shutdown_request.requested:
            return
        if not self._commands.are_made and not self._connect():
            return
        if self._sample_ns is None:
            self._report("waiting for the rig: all its topics have a publisher, but no sample of top_drive comes")
        elif not is_catching_up:
            self._watch(self._sample_ns)

    def _connect(self) -> bool:
        """Make the command publishers once the rig is there; until then say what is missing."""
        missing = [channel.name for channel in (*self._channels, self._mwd) if channel.get_publisher_count() == 0]
        if missing:
            self._report(f"waiting for a rig: nobody publishes {', '.join(missing)}")
            return False
        self._commands.make()
        return True

    def _watch(self, sample_ns: int) -> None:
        """React to a silent rig. Whether its time goes on is known on /clock, or if its stamps are on this clock."""
        silent = self._watchdog.silent_for(self._inbox.stale_after)
        if self.get_parameter("use_sim_time").value:
            elapsed_ns = self.get_clock().now().nanoseconds - self._received_ns
        elif is_on_clock(sample_ns, self._received_ns):
            elapsed_ns = round(silent * 1e9)
        else:
            elapsed_ns = 0
        if elapsed_ns > self._inbox.stale_after * 1e9:
            self._step_without_readings(sample_ns, elapsed_ns)
        elif silent:
            self._report_silence(sample_ns, silent)

    def _step_without_readings(self, sample_ns: int, elapsed_ns: int) -> None:
        """The rig's clock goes on without readings: step the controller with a sample that holds none."""
        if self._silent_from is None:
            self._silent_from = sample_ns / 1e9
            self.get_logger().error(f"the rig is silent since {self._silent_from:.1f} s")
        now_ns = sample_ns + elapsed_ns
        if now_ns - (self._stamp_ns or 0) >= BLIND_STEP_NS:
            self._step(self._inbox.empty_sample(now_ns))

    def _report_silence(self, sample_ns: int, silent: float) -> None:
        """The rig's time stands still, or is unknown: take no step, whose time may never exist, but stop the rig."""
        if self._silent_from is None:
            self._silent_from, self._reported_silence, self._is_silence_logged = sample_ns / 1e9, 0.0, False
        if not self._is_silence_logged:
            self._log_silence(silent)
        if silent - self._reported_silence >= SILENCE_PERIOD:
            self._reported_silence = silent
            self._diagnostics.publish(sample_ns, self._statuses(sample_ns))
            if not self.get_parameter("use_sim_time").value:
                self.stop_rig()

    def _log_silence(self, silent: float) -> None:
        """An error, unless the rig's topics vanish within LEAVE_TIME: a program that ends normally takes them along."""
        if all(channel.get_publisher_count() == 0 for channel in self._channels):
            self.get_logger().info(f"the rig has left: nobody publishes its topics for {silent:.1f} s; waiting for it")
        elif silent > self._inbox.stale_after + LEAVE_TIME:
            self.get_logger().error(f"no sample and no time from the rig for {silent:.1f} s: paused, or gone")
        else:
            return
        self._is_silence_logged = True

    def _statuses(self, stamp_ns: int) -> list[Status]:
        stale = self._inbox.stale_channels(stamp_ns)
        if self._silent_from is not None:
            measured = Status(Level.ERROR, "measurements", f"the rig is silent since {self._silent_from:.1f} s")
        elif self._clock_fault:
            measured = Status(Level.WARN, "measurements", self._clock_fault)
        elif stale:
            measured = Status(Level.WARN, "measurements", f"no {', '.join(stale)} for {self._inbox.stale_after:g} s")
        else:
            measured = Status(Level.OK, "measurements", "every surface channel is there")
        try:
            return [measured, *statuses_of(self._controller), *self._twin_relay.statuses()]
        except InputError as error:
            self.shutdown_request.fail(error)
            return [measured]
