"""The node `friction_simulator`: a virtual rig on topics, in lockstep with its controller or in real time."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Any

from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.node import Node
from std_msgs.msg import String

from slider_drilling.drillstring import VirtualRig
from slider_drilling.errors import InputError
from slider_drilling.messages import cdr
from slider_drilling.messages.topics import TOPICS
from slider_drilling.nodes import link
from slider_drilling.nodes.command_inbox import BLOCK, PUMP, TOP_DRIVE, CommandInbox
from slider_drilling.nodes.halt import Halt
from slider_drilling.nodes.health import Health, Level, Status
from slider_drilling.nodes.pace import Pace
from slider_drilling.nodes.parameters import Declared, declare, on_change
from slider_drilling.nodes.rig_parameter import RIG, rig_of
from slider_drilling.signals import Measurements, MwdSample

PARAMETERS = (
    RIG,
    Declared("speed", 0.0, "simulated seconds a second; 0: as fast as controller and plant go, in lockstep", "s/s",
             0.0, 1000.0, live=True),
    Declared("duration", 0.0, "simulated time after which the node ends; 0: never", "s", 0.0, 1e7, live=True),
    Declared("seed", 0, "seed of the sensor noise", "-", 0, 2**31 - 1),
    Declared("elements", 200, "elements of the drill string", "-", 10, 5000),
    Declared("start_time", 0.0, "stamp of the first sample", "s", 0.0, 2e9),
    Declared("wait_for_controller", False, "hold the first sample until a controller is there, in real time as well"),
    Declared("minimum_subscribers", 1, "subscriptions to top_drive/joint_states to wait for, where one waits", "-",
             0, 100),
    Declared("patience", 5.0, "wall time without a command after which the node says what is missing", "s",
             0.1, 3600.0, live=True),
)
COMMANDS = (TOP_DRIVE, BLOCK, PUMP)
LATE = 0.5  # s behind real time before the log says so


class FrictionSimulator(Node):
    """Publishes a virtual rig's channels and takes its commands.

    The command that answers sample k drives the rig to sample k + 1, in lockstep and in real time alike, so both
    give the same run as long as the controller answers within a sample. In lockstep nothing else moves time. Raises
    InputError for a rig file or a parameter that cannot be used.
    """

    def __init__(self, halt: Halt, **node_options: Any) -> None:
        super().__init__("friction_simulator", **node_options)
        self._halt = halt
        values = declare(self, PARAMETERS)
        self._rig, rig_text = rig_of(values["rig"])
        self.get_logger().info("preparing the plant; the first time on a machine it is compiled")
        self._virtual = VirtualRig(self._rig, values["seed"], values["elements"])
        self._start_ns = round(values["start_time"] * 1e9)
        self._settings = {name: values[name] for name in ("speed", "duration", "patience")}
        self._waits = bool(values["wait_for_controller"])
        self._minimum_subscribers = values["minimum_subscribers"]
        self._inbox = CommandInbox(self._virtual.measurements.pump_speed)
        self._make_topics()
        self._health = Health(self)
        self._rig_publisher = self.create_publisher(String, link.RIG_DESCRIPTION.name, link.LATCHED)
        self._rig_publisher.publish(String(data=rig_text))
        self.may_start: Callable[[], bool] = lambda: True   # asked before the first sample
        self._pace: Pace | None = None       # in real time, once started
        self._started = False
        self._awaited: tuple[str, ...] = ()
        self._stamp_ns = self._start_ns
        self._last_progress = time.monotonic()
        self._unanswered = 0                 # samples in real time without a command of their own
        self._wall_clock = Clock(clock_type=ClockType.STEADY_TIME)
        self._timer = self.create_timer(0.02, self._on_timer, clock=self._wall_clock)
        on_change(self, self._change)

    @property
    def simulated(self) -> float:
        """Simulated seconds since the start."""
        return (self._stamp_ns - self._start_ns) / 1e9

    @property
    def truth(self) -> Any:
        """The virtual rig's truth, for whoever shows the run's progress."""
        return self._virtual.truth

    def _make_topics(self) -> None:
        self._clock_publisher = link.publisher(self, link.CLOCK)
        names = ("mwd_tool_face", "truth_bit", "truth_weight_on_bit", "truth_depth", "standpipe_pressure", "mud_pump",
                 "draw_works", "top_drive")
        self._publishers_of = {name: link.publisher(self, TOPICS[name]) for name in names}
        topics = (TOPICS["top_drive_command"], TOPICS["draw_works_command"], link.PUMP_COMMAND)
        self._command_subscriptions = {
            topic.name: link.subscription(self, topic, self._receiver(topic.name, topic.joint)) for topic in topics
        }

    def _receiver(self, topic: str, joint: str) -> Any:
        def receive(data: bytes) -> None:
            try:
                stamp_ns, position, velocity, _ = cdr.read_joint_state(data, joint)
            except InputError as error:
                self.get_logger().warning(f"{topic}: {error}", throttle_duration_sec=5.0)
                return
            if not self._inbox.put(topic, stamp_ns, position, velocity):
                self.get_logger().warning(
                    f"{topic}: refused position {position} and velocity {velocity} for {stamp_ns / 1e9:.3f} s: "
                    "not finite, or older than the command before", throttle_duration_sec=5.0)
                return
            if self._started and self._in_lockstep() and not self._inbox.missing(self._stamp_ns, self._awaited):
                self._advance()

        return receive

    def _in_lockstep(self) -> bool:
        return bool(self._settings["speed"] == 0.0)

    def _change(self, changes: dict[str, Any]) -> None:
        self._settings.update({name: changes[name] for name in self._settings if name in changes})
        if "speed" in changes and self._started:
            self._set_pace()

    def _set_pace(self) -> None:
        speed = self._settings["speed"]
        self._pace = Pace(speed, self.simulated, time.monotonic()) if speed > 0.0 else None
        # A tenth of a sample is the coarseness of real time; in lockstep the timer only watches.
        period = 0.1 * self._virtual.interval / speed if speed > 0.0 else 0.1
        self.destroy_timer(self._timer)
        self._timer = self.create_timer(max(period, 0.0005), self._on_timer, clock=self._wall_clock)

    def _on_timer(self) -> None:
        if self._halt.requested:
            return
        if not self._started:
            self._start_when_ready()
        elif self._in_lockstep():
            self._watch()
        else:
            self._keep_pace()

    def _start_when_ready(self) -> None:
        """Start once a controller and all who want the first sample are connected."""
        absent = [topic for topic, found in self._command_subscriptions.items() if found.get_publisher_count() == 0]
        subscribers = self._publishers_of["top_drive"].get_subscription_count()
        if self._in_lockstep() or self._waits:
            if TOP_DRIVE in absent:
                self._complain(f"waiting for a controller: nobody publishes {TOP_DRIVE}")
                return
            if subscribers < self._minimum_subscribers:
                self._complain(f"waiting: top_drive/joint_states has {subscribers} subscriptions, "
                               f"{self._minimum_subscribers} are expected (parameter minimum_subscribers)")
                return
        if not self.may_start():
            self._complain("waiting for the recorder to connect")
            return
        self._awaited = tuple(topic for topic in COMMANDS if topic not in absent)
        self._started = True
        self._last_progress = time.monotonic()
        self._set_pace()
        how = "in lockstep" if self._in_lockstep() else f"at {self._settings['speed']:g} times real time"
        self.get_logger().info(f"sliding {self._rig.string.length:g} m of string {how}")
        self._publish(self._virtual.measurements)

    def _watch(self) -> None:
        missing = self._inbox.missing(self._stamp_ns, self._awaited)
        if not missing:
            # The answer came while real time ran, when an answer moves nothing.
            self._advance()
        else:
            self._complain(f"waiting for {' and '.join(missing)} to answer the sample of {self._stamp_ns / 1e9:.3f} s")

    def _complain(self, what: str) -> None:
        now = time.monotonic()
        if now - self._last_progress > self._settings["patience"]:
            self._last_progress = now
            self.get_logger().warning(what)
            self._health.publish(self._stamp_ns, [Status(Level.WARN, "clock", what)])

    def _keep_pace(self) -> None:
        """Advance by the samples that are due; say so when real time cannot be kept."""
        pace = self._pace
        if pace is None:
            return
        following = self.simulated + self._virtual.interval
        if time.monotonic() < pace.due(following):
            return
        if self._inbox.missing(self._stamp_ns, (TOP_DRIVE,)):
            self._unanswered += 1
        self._advance()
        pace.passed(self.simulated, time.monotonic())
        if pace.behind > LATE:
            self.get_logger().warning(
                f"cannot keep {pace.speed:g} times real time: {pace.behind:.2f} s behind at {self.simulated:.1f} s",
                throttle_duration_sec=5.0)
            pace.forgive(self.simulated, time.monotonic())

    def _advance(self) -> None:
        if self._halt.requested:
            return
        command = self._inbox.command(self._stamp_ns, self._virtual.measurements.top_drive_angle)
        measurements = self._virtual.step(command)
        if not math.isfinite(measurements.surface_torque + measurements.hook_load):
            self._halt.fail(InputError(
                f"friction_simulator: the plant left finite numbers at {measurements.time:.1f} s; "
                "check the rig file's stiffnesses and the number of elements"))
            return
        self._last_progress = time.monotonic()
        self._publish(measurements)
        if 0.0 < self._settings["duration"] <= measurements.time + 1e-9:
            self._halt.stop()

    def _publish(self, measurements: Measurements) -> None:
        """One sample on its topics, the top drive's last: it is the one that controllers act on."""
        stamp = self._stamp_ns = self._start_ns + round(measurements.time * 1e9)
        truth, out = self._virtual.truth, self._publishers_of
        self._clock_publisher.publish(cdr.clock(stamp))
        for sample in measurements.mwd:
            self._publish_mwd(sample)
        out["truth_bit"].publish(
            cdr.joint_state(stamp, "bit", truth.tool_face, truth.tool_face_rate, truth.bit_torque))
        out["truth_weight_on_bit"].publish(cdr.wrench_stamped(stamp, (truth.weight_on_bit, 0.0, 0.0)))
        out["truth_depth"].publish(cdr.joint_state(stamp, "bit", truth.bit_depth, truth.rate_of_penetration))
        variance = self._rig.sensors.standpipe_pressure.noise ** 2
        out["standpipe_pressure"].publish(cdr.fluid_pressure(stamp, measurements.standpipe_pressure, variance))
        out["mud_pump"].publish(cdr.joint_state(stamp, "mud_pump", None, measurements.pump_speed))
        out["draw_works"].publish(cdr.joint_state(
            stamp, "block", measurements.block_position, measurements.block_speed, measurements.hook_load))
        if self._health.is_due(stamp):
            self._health.publish(stamp, self._statuses())
        out["top_drive"].publish(cdr.joint_state(
            stamp, "top_drive", measurements.top_drive_angle, measurements.top_drive_speed,
            measurements.surface_torque))

    def _publish_mwd(self, sample: MwdSample) -> None:
        measured = self._start_ns + round(sample.measured_at * 1e9)
        self._publishers_of["mwd_tool_face"].publish(cdr.joint_state(measured, "tool_face", sample.tool_face))

    def _statuses(self) -> list[Status]:
        """Nothing of the wall's clock in lockstep: the run is to be the same bit for bit."""
        commands = self._command_status()
        if self._pace is None:
            return [Status(Level.OK, "clock", "in lockstep with the controller"), commands]
        behind = self._pace.take_worst_behind()
        values = (("speed", f"{self._pace.speed:g}"), ("behind_s", f"{behind:.3f}"))
        if behind > self._virtual.interval / self._pace.speed:
            return [Status(Level.WARN, "clock", f"real time cannot be kept: {behind:.3f} s behind", values), commands]
        return [Status(Level.OK, "clock", "keeps real time", values), commands]

    def _command_status(self) -> Status:
        rivals = [topic for topic, found in self._command_subscriptions.items() if found.get_publisher_count() > 1]
        values = (("refused", str(self._inbox.refused)), ("unanswered_samples", str(self._unanswered)))
        if rivals:
            what = f"several nodes publish {' and '.join(rivals)}; stop all but one, or set another ROS_DOMAIN_ID"
            self.get_logger().warning(what, throttle_duration_sec=5.0)
            if self._in_lockstep():
                # Whose command comes first is chance: the run would be neither this controller's nor the other's.
                self._halt.fail(InputError(f"friction_simulator: {what}"))
            return Status(Level.ERROR, "commands", what, values)
        if self._unanswered:
            return Status(Level.WARN, "commands", "some samples had no command in time; the top drive held", values)
        return Status(Level.OK, "commands", "every sample is answered", values)
