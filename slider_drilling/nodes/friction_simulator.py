"""The node `friction_simulator`: a virtual rig on topics, in lockstep with its controller or in real time."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Any

from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from std_msgs.msg import String

from slider_drilling.drillstring import VirtualRig
from slider_drilling.errors import InputError
from slider_drilling.nodes import raw_topics
from slider_drilling.nodes.command_inbox import TOP_DRIVE, CommandInbox
from slider_drilling.nodes.command_subscriptions import COMMANDS, CommandSubscriptions
from slider_drilling.nodes.diagnostics import DiagnosticsPublisher, Level, Status
from slider_drilling.nodes.late_joiners import LateJoiners
from slider_drilling.nodes.lifecycle_node import AUTOSTART, Transitions
from slider_drilling.nodes.pace import Pace
from slider_drilling.nodes.parameters import NodeParameter, declare, on_change
from slider_drilling.nodes.rig_parameter import RIG_PARAMETER, read_rig, rig_name
from slider_drilling.nodes.rig_topics import RigTopics
from slider_drilling.nodes.services import reset_service, stepping_services
from slider_drilling.nodes.shutdown import ShutdownRequest
from slider_drilling.nodes.simulator_lock import SimulatorLock

PARAMETERS = (
    RIG_PARAMETER,
    NodeParameter(
        "speed",
        0.0,
        "simulated seconds a second; 0: as fast as controller and plant go, in lockstep",
        "s/s",
        0.0,
        1000.0,
        live=True,
    ),
    NodeParameter("duration", 0.0, "simulated time after which the node ends; 0: never", "s", 0.0, 1e7, live=True),
    NodeParameter("seed", 0, "seed of the sensor noise", "-", 0, 2**31 - 1),
    NodeParameter("elements", 200, "elements of the drill string", "-", 10, 5000),
    NodeParameter("start_time", 0.0, "stamp of the first sample", "s", 0.0, 2e9),
    NodeParameter(
        "wait_for_controller", False, "hold the first sample until a controller is there, in real time as well"
    ),
    NodeParameter(
        "minimum_subscribers", 1, "subscriptions to top_drive/joint_states to wait for, where one waits", "-", 0, 100
    ),
    NodeParameter(
        "patience",
        5.0,
        "wall time without a command after which the node says what is missing",
        "s",
        0.1,
        3600.0,
        live=True,
    ),
    NodeParameter(
        "command_timeout",
        1.0,
        "rig time without a command, in real time, after which the top drive stands and the block stops",
        "s",
        0.2,
        60.0,
        live=True,
    ),
    AUTOSTART,
)
LATE = 0.5  # s behind real time before the log says so


class FrictionSimulator(LifecycleNode):
    """Publishes a virtual rig's channels and takes its commands.

    The command that answers sample k drives the rig to sample k + 1, in lockstep and in real time alike, so both
    give the same run as long as the controller answers within a sample. In lockstep nothing else moves time. Raises
    InputError for a rig file or a parameter that cannot be used.
    """

    def __init__(self, halt: ShutdownRequest, **node_options: Any) -> None:
        super().__init__("friction_simulator", **node_options)
        self._halt = halt
        self._values = declare(self, PARAMETERS)
        self.may_start: Callable[[], bool] = lambda: True  # asked before the first sample
        self._transitions = Transitions(self)
        self._place: SimulatorLock | None = None  # in the graph, while configured
        self._configured = self._active = self._started = self._paused = False
        self._steps = 0  # samples still to go while paused
        self._stamp_ns = self._first_ns = round(self._values["start_time"] * 1e9)
        on_change(self, self._change)
        if self._values["autostart"]:
            self._transitions.start()

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Read the rig file, make the plant and the topics."""
        return self._transitions.run(self._configure)

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Let time run."""
        return self._transitions.run(self._activate)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Stop the rig's time."""
        self._active = False
        return TransitionCallbackReturn.SUCCESS

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Forget the rig and its topics."""
        raw_topics.destroy(self, self._own)
        if self._place is not None:
            self._place.release()
        self._configured = self._started = False
        return TransitionCallbackReturn.SUCCESS

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """End the program."""
        self._halt.stop()
        return TransitionCallbackReturn.SUCCESS

    def _configure(self) -> None:
        before = raw_topics.entities(self)
        values = self._values = {one.name: self.get_parameter(one.name).value for one in PARAMETERS}
        self._rig, rig_text = read_rig(values["rig"])
        self._place = SimulatorLock(self.get_namespace())
        self.get_logger().info("preparing the plant; the first time on a machine it is compiled")
        self._virtual = self._make_rig()
        # The stamp of the rig's time 0, and that of the present and the first sample.
        self._start_ns = self._stamp_ns = self._first_ns = round(values["start_time"] * 1e9)
        pump_speed = self._virtual.measurements.pump_speed
        self._inbox = CommandInbox(pump_speed, values["command_timeout"], self._in_lockstep())
        self._inbox.reset(self._stamp_ns)
        self._port = CommandSubscriptions(self, self._inbox, self._on_command)
        self._newcomers = LateJoiners(self._port.controllers)
        # Before the readings: who hears the top drive shall know that there is a rig to be told of.
        self._rig_publisher = self.create_publisher(String, raw_topics.RIG_DESCRIPTION.name, raw_topics.LATCHED)
        self._rig_publisher.publish(String(data=rig_text))
        self._topics = RigTopics(self, self._rig.sensors.standpipe_pressure.noise**2)
        self._health = DiagnosticsPublisher(self, rig_name(values["rig"]))
        stepping_services(self, self._pause, self._step_once)
        reset_service(self, self._reset)
        self._pace: Pace | None = None  # in real time, once started
        self._started = False
        self._awaited: tuple[str, ...] = ()
        self._last_progress = time.monotonic()
        self._wall_clock = Clock(clock_type=ClockType.STEADY_TIME)
        self._timer = self.create_timer(0.02, self._on_timer, clock=self._wall_clock)
        self._own = raw_topics.entities(self) - before
        self._configured = True

    def destroy_node(self) -> None:
        """Leave the graph, and room for another rig in it."""
        if self._place is not None:
            self._place.release()
        super().destroy_node()

    def _activate(self) -> None:
        self._active = True
        self._forgive()

    def _make_rig(self) -> VirtualRig:
        return VirtualRig(self._rig, self._values["seed"], self._values["elements"])

    @property
    def simulated(self) -> float:
        """Simulated seconds since the start."""
        return (self._stamp_ns - self._first_ns) / 1e9

    @property
    def truth(self) -> Any:
        """The virtual rig's truth, for whoever shows the run's progress."""
        return self._virtual.truth

    def _on_command(self) -> None:
        if self._started and self._in_lockstep() and not self._inbox.missing(self._stamp_ns, self._awaited):
            self._advance()

    def _in_lockstep(self) -> bool:
        return bool(self._values["speed"] == 0.0)

    def _change(self, changes: dict[str, Any]) -> None:
        self._values.update(changes)
        if not self._configured:
            return
        self._inbox.timeout = self._values["command_timeout"]
        self._inbox.lockstep = self._in_lockstep()
        if "speed" in changes and self._started:
            self._set_pace()

    def _set_pace(self) -> None:
        speed = self._values["speed"]
        self._pace = Pace(speed, self.simulated, time.monotonic()) if speed > 0.0 else None
        # A tenth of a sample is the coarseness of real time; in lockstep the timer only watches.
        period = 0.1 * self._virtual.interval / speed if speed > 0.0 else 0.1
        self.destroy_timer(self._timer)
        self._own.discard(self._timer)
        self._timer = self.create_timer(max(period, 0.0005), self._on_timer, clock=self._wall_clock)
        self._own.add(self._timer)

    def _forgive(self) -> None:
        """Count real time from here on: what passed meanwhile was no time of the rig."""
        if self._pace is not None:
            self._pace.restart(self.simulated, time.monotonic())
        self._last_progress = time.monotonic()

    def _pause(self, paused: bool) -> str:
        self._paused, self._steps = paused, 0
        self._forgive()
        return f"{'paused' if paused else 'running'} at {self.simulated:.1f} s"

    def _step_once(self) -> str:
        if not self._paused:
            raise InputError("not paused; pause first")
        self._steps += 1
        if self._started and not (self._in_lockstep() and self._inbox.missing(self._stamp_ns, self._awaited)):
            self._advance()
        return f"one sample, at {self.simulated:.1f} s"

    def _reset(self) -> str:
        """The rig as at the start; time goes on, so that a log of it stays one run."""
        self._virtual = self._make_rig()
        self._start_ns = self._stamp_ns + (round(self._virtual.interval * 1e9) if self._started else 0)
        self._inbox.reset(self._start_ns)
        if self._started:
            self._publish()
        return f"the rig is as at its start, at {self.simulated:.1f} s"

    def _on_timer(self) -> None:
        if self._halt.requested or not self._active:
            return
        if not self._started:
            self._start_when_ready()
        elif self._paused:
            self._complain("paused", Level.OK, after=1.0)
        elif self._in_lockstep():
            self._watch()
        else:
            self._keep_pace()

    def _start_when_ready(self) -> None:
        """Start once a controller and all who want the first sample are connected."""
        absent = self._port.absent()
        if self._in_lockstep() or self._values["wait_for_controller"]:
            if TOP_DRIVE in absent:
                self._complain(f"waiting for a controller: nobody publishes {TOP_DRIVE}")
                return
            if self._topics.listeners < self._values["minimum_subscribers"]:
                self._complain(
                    f"waiting: top_drive/joint_states has {self._topics.listeners} subscriptions, "
                    f"{self._values['minimum_subscribers']} are expected (parameter minimum_subscribers)"
                )
                return
        if not self.may_start():
            self._complain("waiting for the recorder to connect")
            return
        self._awaited = tuple(topic for topic in COMMANDS if topic not in absent)
        self._started = True
        self._newcomers.start(self._stamp_ns)
        self._last_progress = time.monotonic()
        self._set_pace()
        how = "in lockstep" if self._in_lockstep() else f"at {self._values['speed']:g} times real time"
        self.get_logger().info(f"sliding {self._rig.string.length:g} m of string {how}")
        self._publish()

    def _watch(self) -> None:
        missing = self._inbox.missing(self._stamp_ns, self._awaited)
        if not missing:
            # The answer came while real time ran, or a pause, when an answer moves nothing.
            self._advance()
            return
        if self._newcomers.should_resend(self._stamp_ns):
            self._serve_newcomer()
        refused = self._port.last_refusal()
        why = f"; the last one was refused: {refused}" if refused else ""
        self._complain(f"waiting for {' and '.join(missing)} to answer the sample of {self._stamp_ns / 1e9:.3f} s{why}")

    def _serve_newcomer(self) -> None:
        """A controller that was started again never heard the sample that waits; it may command other topics, too."""
        absent = self._port.absent()
        self._awaited = tuple(topic for topic in COMMANDS if topic == TOP_DRIVE or topic not in absent)
        self.get_logger().info(f"a controller has come: the sample of {self._stamp_ns / 1e9:.3f} s is sent again")
        self._inbox.sent_again()
        self._topics.publish_again()

    def _complain(self, what: str, level: Level = Level.WARN, after: float | None = None) -> None:
        now = time.monotonic()
        if now - self._last_progress > (self._values["patience"] if after is None else after):
            self._last_progress = now
            if level is not Level.OK:
                self.get_logger().warning(what)
            self._health.publish(self._stamp_ns, [Status(level, "clock", what)])

    def _keep_pace(self) -> None:
        """Advance by the samples that are due; say so when real time cannot be kept."""
        pace = self._pace
        if pace is None:
            return
        following = self.simulated + self._virtual.interval
        if time.monotonic() < pace.due(following):
            return
        self._port.note_sample()
        self._advance()
        pace.note_sent(self.simulated, time.monotonic())
        if pace.behind > LATE:
            self.get_logger().warning(
                f"cannot keep {pace.speed:g} times real time: {pace.behind:.2f} s behind at {self.simulated:.1f} s",
                throttle_duration_sec=5.0,
            )
            pace.restart(self.simulated, time.monotonic())

    def _advance(self) -> None:
        if self._halt.requested or not self._active or (self._paused and self._steps == 0):
            return
        self._steps -= self._paused
        command = self._inbox.command(self._stamp_ns, self._virtual.measurements.top_drive_angle)
        measurements = self._virtual.step(command)
        if not math.isfinite(measurements.surface_torque + measurements.hook_load):
            self._halt.fail(
                InputError(
                    f"friction_simulator: the plant left finite numbers at {measurements.time:.1f} s; "
                    "check the rig file's stiffnesses and the number of elements"
                )
            )
            return
        self._last_progress = time.monotonic()
        self._publish()
        if 0.0 < self._values["duration"] <= self.simulated + 1e-9:
            self._halt.stop()

    def _publish(self) -> None:
        stamp = self._stamp_ns = self._start_ns + round(self._virtual.measurements.time * 1e9)
        self._inbox.now_ns = stamp

        def tell_health() -> None:
            if self._health.is_due(stamp):
                self._health.publish(stamp, self._statuses())

        self._topics.publish(self._start_ns, stamp, self._virtual.measurements, self._virtual.truth, tell_health)

    def _statuses(self) -> list[Status]:
        """Nothing of the wall's clock in lockstep: the run is to be the same bit for bit."""
        commands = self._port.status()
        if self._pace is None:
            if rivals := self._port.rivals():
                # Whose command comes first is chance: the run would be neither this controller's nor the other's.
                self._halt.fail(InputError(f"friction_simulator: {rivals}"))
            return [Status(Level.OK, "clock", "in lockstep with the controller"), commands]
        behind = self._pace.take_worst_lag()
        values = (("speed", f"{self._pace.speed:g}"), ("behind_s", f"{behind:.3f}"))
        if behind > self._virtual.interval / self._pace.speed:
            return [Status(Level.WARN, "clock", f"real time cannot be kept: {behind:.3f} s behind", values), commands]
        return [Status(Level.OK, "clock", "keeps real time", values), commands]
