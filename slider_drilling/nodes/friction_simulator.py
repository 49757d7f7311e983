"""The node `friction_simulator`: a virtual rig on topics, in lockstep with its controller or in real time."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Any

from std_msgs.msg import String

from slider_drilling.drillstring import VirtualRig
from slider_drilling.errors import InputError
from slider_drilling.messages.health import Level, Status
from slider_drilling.nodes import raw_topics
from slider_drilling.nodes.command_inbox import TOP_DRIVE, CommandInbox, CommandLimits
from slider_drilling.nodes.command_subscriptions import COMMANDS, CommandSubscriptions
from slider_drilling.nodes.diagnostics import DiagnosticsPublisher
from slider_drilling.nodes.joint_names import JOINT_NAMES
from slider_drilling.nodes.late_joiners import LateJoiners
from slider_drilling.nodes.lifecycle_node import AUTOSTART, ManagedNode
from slider_drilling.nodes.pace import Pace
from slider_drilling.nodes.parameters import NodeParameter
from slider_drilling.nodes.rig_parameter import RIG_PARAMETER, read_rig, rig_name
from slider_drilling.nodes.rig_topics import RigPublishers
from slider_drilling.nodes.services import reset_service, stepping_services
from slider_drilling.nodes.simulator_lock import SimulatorLock
from slider_drilling.nodes.spin import steady_timer

MAX_LAG = 0.5  # s behind real time before the node logs a warning
START_PERIOD = 0.02  # s of wall time between checks whether the run can start
LOCKSTEP_PERIOD = 0.1  # s of wall time between checks for missing commands in lockstep


class FrictionSimulator(ManagedNode):
    """Publishes a virtual rig's channels and applies its commands.

    The command that answers sample k drives the rig to sample k + 1, in lockstep and in real time alike. Both give the
    same run as long as the controller answers within a sample. In lockstep only commands advance time.
    """

    NAME = "friction_simulator"
    PARAMETERS = (
        RIG_PARAMETER,
        NodeParameter("speed", 0.0, "simulated seconds per second; 0: lockstep, as fast as controller and plant run",
                      "s/s", 0.0, 1000.0, live=True),
        NodeParameter("duration", 0.0, "simulated time after which the node ends; 0: never", "s", 0.0, 1e7, live=True),
        NodeParameter("seed", 0, "seed of the sensor noise", "-", 0, 2**31 - 1),
        NodeParameter("elements", 200, "elements of the drill string", "-", 10, 5000),
        NodeParameter("start_time", 0.0, "stamp of the first sample", "s", 0.0, 2e9),
        NodeParameter("wait_for_controller", False, "wait for a controller before the first sample, also in real time"),
        NodeParameter("minimum_subscribers", 1,
                      "subscriptions to top_drive/joint_states to wait for, in lockstep or with wait_for_controller",
                      "-", 0, 100),
        NodeParameter("patience", 5.0, "wall time without progress after which the node says what it waits for", "s",
                      0.1, 3600.0, live=True),
        NodeParameter("command_timeout", 1.0, "rig time without a command, in real time, after which the top drive "
                      "holds and the block stops", "s", 0.2, 60.0, live=True),
        *JOINT_NAMES,
        AUTOSTART,
    )  # fmt: skip

    may_start: Callable[[], bool] = staticmethod(lambda: True)
    """Asked before the first sample; a program that records sets it to wait for its recorder."""

    _lock: SimulatorLock | None = None
    _stamp_ns = _first_ns = 0  # stamps of the present and of the first sample

    def configure(self) -> None:
        """Read the rig file, make the plant and the topics."""
        values = self.values
        self._rig, rig_text = read_rig(values["rig"])
        self._lock = SimulatorLock(self.get_namespace())
        self.get_logger().info("preparing the plant; the first time on a machine it is compiled")
        self._virtual = self._make_rig()
        self._start_ns = self._stamp_ns = self._first_ns = round(values["start_time"] * 1e9)
        self._inbox = CommandInbox(
            self._virtual.measurements.pump_speed,
            values["command_timeout"],
            self._is_lockstep(),
            CommandLimits.of(self._rig),
        )
        self._inbox.reset(self._stamp_ns)
        self._commands = CommandSubscriptions(
            self, self._inbox, self._on_command, lambda: self._virtual.measurements.top_drive_speed, values
        )
        self._late_joiners = LateJoiners(self._commands.controller_ids)
        # Published before the channels: a recorder that finds the top drive expects a description.
        description = self.create_publisher(String, raw_topics.RIG_DESCRIPTION.name, raw_topics.LATCHED)
        description.publish(String(data=rig_text))
        self._topics = RigPublishers(self, self._rig.sensors.standpipe_pressure.noise**2, values)
        self._diagnostics = DiagnosticsPublisher(self, rig_name(values["rig"]))
        stepping_services(self, self._pause, self._step_once)
        reset_service(self, self._reset)
        self._pace: Pace | None = None  # in real time, once started
        self._started = self._paused = False
        self._steps_left = 0  # samples to advance while paused
        self._awaited: tuple[str, ...] = ()
        self._last_progress = time.monotonic()
        self._timer = steady_timer(self, START_PERIOD, self._on_timer)

    def activate(self) -> None:
        """Let time run."""
        self._restart_wall_time()

    def cleanup(self) -> None:
        """Let another rig be simulated in this domain and namespace."""
        self._started = False
        if self._lock is not None:
            self._lock.release()

    def destroy_node(self) -> None:
        """Leave the graph and release the lock."""
        self.cleanup()
        super().destroy_node()

    def apply_changes(self, changes: dict[str, Any]) -> None:
        """Use a new speed or command timeout."""
        self._inbox.timeout = self.values["command_timeout"]
        self._inbox.lockstep = self._is_lockstep()
        if "speed" in changes and self._started:
            self._set_pace()

    @property
    def simulated(self) -> float:
        """Simulated seconds since the start."""
        return (self._stamp_ns - self._first_ns) / 1e9

    @property
    def truth(self) -> Any:
        """The virtual rig's true state, for a display of the run's progress."""
        return self._virtual.truth

    def _make_rig(self) -> VirtualRig:
        return VirtualRig(self._rig, self.values["seed"], self.values["elements"])

    def _is_lockstep(self) -> bool:
        return bool(self.values["speed"] == 0.0)

    def _unanswered(self) -> list[str]:
        return self._inbox.unanswered(self._stamp_ns, self._awaited)

    def _on_command(self) -> None:
        if self._started and self._is_lockstep() and not self._unanswered():
            self._advance()

    def _set_pace(self) -> None:
        speed = self.values["speed"]
        self._pace = Pace(speed, self.simulated, time.monotonic()) if speed > 0.0 else None
        # A tenth of a sample is the resolution of real time; in lockstep the timer only watches.
        period = 0.1 * self._virtual.interval / speed if speed > 0.0 else LOCKSTEP_PERIOD
        self._timer = self.replace_timer(self._timer, max(period, 0.0005), self._on_timer)

    def _restart_wall_time(self) -> None:
        """Count real time from now on: the time that passed while paused or inactive does not count."""
        if self._pace is not None:
            self._pace.restart(self.simulated, time.monotonic())
        self._last_progress = time.monotonic()

    def _pause(self, paused: bool) -> str:
        self._paused, self._steps_left = paused, 0
        self._restart_wall_time()
        return f"{'paused' if paused else 'running'} at {self.simulated:.1f} s"

    def _step_once(self) -> str:
        if not self._paused:
            raise InputError("not paused; pause first")
        self._steps_left += 1
        if self._started and not (self._is_lockstep() and self._unanswered()):
            self._advance()
        return f"one sample, at {self.simulated:.1f} s"

    def _reset(self) -> str:
        """Set the rig back to its start; stamps go on, so that a log of it stays one run."""
        self._virtual = self._make_rig()
        self._start_ns = self._stamp_ns + (round(self._virtual.interval * 1e9) if self._started else 0)
        self._inbox.reset(self._start_ns)
        if self._started:
            self._publish()
        return f"the rig is as at its start, at {self.simulated:.1f} s"

    def _on_timer(self) -> None:
        if self.shutdown_request.requested or not self.is_active:
            return
        if not self._started:
            self._start_when_ready()
        elif self._paused:
            self._report_waiting("paused", Level.OK, after=1.0)
        elif self._pace is None:
            self._check_lockstep()
        else:
            self._keep_pace(self._pace)

    def _start_when_ready(self) -> None:
        """Start once a controller and all subscribers that need the first sample are connected."""
        unpublished = self._commands.unpublished()
        reason = self._start_blocker(unpublished)
        if reason:
            self._report_waiting(reason)
            return
        self._awaited = tuple(topic for topic in COMMANDS if topic not in unpublished)
        self._started = True
        self._late_joiners.start(self._stamp_ns)
        self._last_progress = time.monotonic()
        self._set_pace()
        mode = "in lockstep" if self._is_lockstep() else f"at {self.values['speed']:g} times real time"
        self.get_logger().info(f"sliding {mode}")
        self._publish()

    def _start_blocker(self, unpublished: list[str]) -> str:
        """What the first sample still waits for; "" if nothing."""
        if self._is_lockstep() or self.values["wait_for_controller"]:
            if TOP_DRIVE in unpublished:
                return f"waiting for a controller: nobody publishes {TOP_DRIVE}"
            expected = self.values["minimum_subscribers"]
            if self._topics.subscription_count < expected:
                return (f"waiting: top_drive/joint_states has {self._topics.subscription_count} subscriptions, "
                        f"{expected} are expected (parameter minimum_subscribers)")  # fmt: skip
        return "" if self.may_start() else "waiting for the recorder to connect"

    def _check_lockstep(self) -> None:
        unanswered = self._unanswered()
        if not unanswered:
            # The answer came in real time or during a pause, when answers do not advance the rig.
            self._advance()
            return
        if self._late_joiners.should_resend(self._stamp_ns):
            self._resend_sample()
        refused = self._commands.last_refusal()
        cause = f"; the last one was refused: {refused}" if refused else ""
        self._report_waiting(
            f"waiting for {' and '.join(unanswered)} to answer the sample of {self._stamp_ns / 1e9:.3f} s{cause}"
        )

    def _resend_sample(self) -> None:
        """A restarted controller has not received the present sample; it may also publish other topics than before."""
        unpublished = self._commands.unpublished()
        self._awaited = tuple(topic for topic in COMMANDS if topic == TOP_DRIVE or topic not in unpublished)
        self.get_logger().info(f"a controller has joined: the sample of {self._stamp_ns / 1e9:.3f} s is sent again")
        self._inbox.note_resent()
        self._topics.resend()

    def _report_waiting(self, message: str, level: Level = Level.WARN, after: float | None = None) -> None:
        now = time.monotonic()
        if now - self._last_progress > (self.values["patience"] if after is None else after):
            self._last_progress = now
            if level is not Level.OK:
                self.get_logger().warning(message)
            self._diagnostics.publish(self._stamp_ns, [Status(level, "clock", message)])

    def _keep_pace(self, pace: Pace) -> None:
        """Advance if the next sample is due; warn if the rig falls behind real time."""
        if time.monotonic() < pace.due(self.simulated + self._virtual.interval):
            return
        self._commands.count_sample()
        self._advance()
        pace.note_sent(self.simulated, time.monotonic())
        if pace.lag > MAX_LAG:
            self.get_logger().warning(
                f"cannot keep {pace.speed:g} times real time: {pace.lag:.2f} s behind at {self.simulated:.1f} s",
                throttle_duration_sec=5.0,
            )
            pace.restart(self.simulated, time.monotonic())

    def _advance(self) -> None:
        if self.shutdown_request.requested or not self.is_active or (self._paused and self._steps_left == 0):
            return
        self._steps_left -= self._paused
        command = self._inbox.command(self._stamp_ns, self._virtual.measurements.top_drive_angle)
        measurements = self._virtual.step(command)
        if not math.isfinite(measurements.surface_torque + measurements.hook_load):
            self.shutdown_request.fail(InputError(
                f"friction_simulator: the simulation diverged at {measurements.time:.1f} s; "
                "check the rig file's stiffnesses and the number of elements"))  # fmt: skip
            return
        self._last_progress = time.monotonic()
        self._publish()
        if 0.0 < self.values["duration"] <= self.simulated + 1e-9:
            self.shutdown_request.stop()

    def _publish(self) -> None:
        stamp = self._stamp_ns = self._start_ns + round(self._virtual.measurements.time * 1e9)
        self._inbox.now_ns = stamp

        def publish_diagnostics() -> None:
            if self._diagnostics.is_due(stamp):
                self._diagnostics.publish(stamp, self._statuses())

        self._topics.publish(
            self._start_ns, stamp, self._virtual.measurements, self._virtual.truth, publish_diagnostics
        )

    def _statuses(self) -> list[Status]:
        """In lockstep they hold no wall time, so that repeated runs are identical."""
        commands = self._commands.status()
        if self._pace is None:
            if conflict := self._commands.conflict():
                # Which controller's command comes first is chance: the run would belong to neither.
                self.shutdown_request.fail(InputError(f"friction_simulator: {conflict}"))
            return [Status(Level.OK, "clock", "in lockstep with the controller"), commands]
        lag = self._pace.take_worst_lag()
        values = (("speed", f"{self._pace.speed:g}"), ("behind_s", f"{lag:.3f}"))
        if lag > self._virtual.interval / self._pace.speed:
            return [Status(Level.WARN, "clock", f"real time cannot be kept: {lag:.3f} s behind", values), commands]
        return [Status(Level.OK, "clock", "keeps real time", values), commands]
