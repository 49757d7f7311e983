"""The node `twin`: simulates beside the rig, says live where they differ, what changed, and since when."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path

from slider_drilling.errors import InputError
from slider_drilling.files.output_files import check_outputs, write_atomically
from slider_drilling.messages.health import Level, Status
from slider_drilling.messages.topics import TOPICS
from slider_drilling.nodes import raw_topics
from slider_drilling.nodes.clock_check import SET_BACK, clock_offset_message
from slider_drilling.nodes.diagnostics import DiagnosticsPublisher
from slider_drilling.nodes.drive_subscriptions import COMMON_TOPIC, DRIVES, drive_subscriptions
from slider_drilling.nodes.joint_names import JOINT_NAMES
from slider_drilling.nodes.lifecycle_node import AUTOSTART, ManagedNode
from slider_drilling.nodes.parameters import NodeParameter
from slider_drilling.nodes.rig_parameter import RIG_PARAMETER, read_rig, rig_name
from slider_drilling.nodes.services import trigger_service
from slider_drilling.nodes.spin import steady_timer
from slider_drilling.nodes.twin_statuses import TwinHealth, twin_statuses
from slider_drilling.nodes.twin_topics import TwinPublishers
from slider_drilling.nodes.watchdog import SILENCE_PERIOD, Watchdog
from slider_drilling.rig.rig_file import dump_rig
from slider_drilling.twin import Twin, TwinReport, TwinSettings, diagnose_after
from slider_drilling.twin.settings import LIMITS

ADVANCE_PERIOD = 0.1  # s of wall time between two looks for seconds that are complete
MAX_GAP = 600.0  # s by which a stamp may be ahead of those before
STALE_AFTER = 1.0  # s of wall time without a sample after which the rig is silent
# Topic of the registry -> the twin's channels, in the order of the message's numbers; empty for one that is not used.
CHANNELS = {
    "standpipe_pressure": ("standpipe_pressure",),
    "mud_pump": ("", "pump_speed"),
    "draw_works": ("block_position", "block_speed", "hook_load"),
    "mwd_tool_face": ("tool_face",),
    "top_drive": ("top_drive_angle", "top_drive_speed", "surface_torque"),
}
_SETTINGS = TwinSettings()


class TwinNode(ManagedNode):
    """Gives a twin the rig's samples and publishes what it says. It commands nothing.

    Attributes:
        twin: The twin; another one after the rig's clock was set back.
    """

    NAME = "twin"
    PARAMETERS = (
        RIG_PARAMETER,
        NodeParameter("diagnose_changes", True, "ask for diagnoses, after a detection and every 150 s without one"),
        NodeParameter("calibrated_rig", "calibrated_rig.yaml", "path that the service save_rig writes the rig file to"),
        NodeParameter("elements", _SETTINGS.elements, "of the simulated string", "-", *LIMITS["elements"]),
        NodeParameter("learning", _SETTINGS.learning, "undisturbed work after which the twin is calibrated and watches",
                      "s", *LIMITS["learning"]),
        NodeParameter("patience", _SETTINGS.patience, "how long it waits for samples of the drives that are late", "s",
                      *LIMITS["patience"]),
        NodeParameter("forecast", _SETTINGS.forecast, "how far a forecast looks ahead; 0: no forecast", "s",
                      *LIMITS["forecast"]),
        NodeParameter("kept", _SETTINGS.kept, "samples that are kept for a diagnosis", "s", *LIMITS["kept"]),
        COMMON_TOPIC,
        *JOINT_NAMES,
        AUTOSTART,
    )  # fmt: skip

    twin: Twin | None = None

    def configure(self) -> None:
        """Read the rig file, make the twin and the topics."""
        self._rig, _ = read_rig(self.values["rig"])
        self._watchdog = Watchdog()
        self._newest_ns: int | None = None  # stamp of the newest sample of the top drive
        self._restarts = 0
        self._restart()
        noise = self._rig.sensors.standpipe_pressure.noise
        self._topics = TwinPublishers(self, noise**2)
        self._diagnostics = DiagnosticsPublisher(self, rig_name(self.values["rig"]))
        self._reported_silence = 0.0
        # The drives last: they complete a second.
        self._sensors = [self._subscribe(key) for key in CHANNELS if key not in DRIVES]
        self._sensors += drive_subscriptions(self, self.values, self._receiver)
        steady_timer(self, ADVANCE_PERIOD, self._advance)
        trigger_service(self, "recalibrate", self._recalibrate)
        trigger_service(self, "save_rig", self._save_rig)
        trigger_service(self, "diagnose", self._diagnose)
        self.get_logger().info(f"a twin of {self._rig.well.name or rig_name(self.values['rig'])}")

    def activate(self) -> None:
        """Listen from now on."""
        self._watchdog.restart()

    def cleanup(self) -> None:
        """End the twin's processes."""
        self.close_twin()

    def destroy_node(self) -> None:
        """End the twin's processes, then destroy the node."""
        self.close_twin()
        super().destroy_node()

    def close_twin(self) -> None:
        """End the twin and its processes; call it however the program ends."""
        twin, self.twin = self.twin, None
        if twin is not None:
            twin.close()

    def apply_changes(self, changes: dict[str, object]) -> None:
        """No parameter is live."""

    def _receiver(self, key: str) -> Callable[..., None]:
        return functools.partial(self._take, key, CHANNELS[key])

    def _subscribe(self, key: str) -> raw_topics.SensorSubscription:
        topic = TOPICS[key]
        return raw_topics.SensorSubscription(self, topic, raw_topics.decoding(self, topic, self._receiver(key)))

    def _restart(self) -> None:
        """Another twin that has seen nothing yet."""
        self.close_twin()
        self.twin = Twin(self._rig, self._settings(), diagnose_after if self.values["diagnose_changes"] else None)
        self._start_ns: int | None = None  # stamp of the twin's time 0
        self._waiting: dict[str, tuple[list[float], list[float]]] = {}  # channel -> times and values to add
        self._ahead_ns: int | None = None  # stamp far ahead of the others, which may be wrong
        self._clock_fault = self._failure = ""
        self._remarked = 0  # how many of the twin's remarks were said

    def _settings(self) -> TwinSettings:
        known = {field.name for field in fields(TwinSettings)}
        return TwinSettings(**{name: value for name, value in self.values.items() if name in known})

    def _take(self, key: str, channels: tuple[str, ...], stamp_ns: int, *numbers: float) -> None:
        """Keep one message's numbers until the next look."""
        if not self.is_active or self.twin is None or not self._is_usable(key, stamp_ns):
            return
        if self._start_ns is None:
            self._start_ns = stamp_ns
        at = (stamp_ns - self._start_ns) / 1e9
        for channel, number in zip(channels, numbers, strict=False):
            if channel and math.isfinite(number):
                times, values = self._waiting.setdefault(channel, ([], []))
                times.append(at)
                values.append(number)

    def _is_usable(self, key: str, stamp_ns: int) -> bool:
        """Whether a stamp belongs to the rig's time; a clock that was set starts the twin anew."""
        newest = self._newest_ns
        if key != "top_drive":
            return newest is not None and abs(stamp_ns - newest) <= MAX_GAP * 1e9
        self._watchdog.note_sample()
        if newest is not None and stamp_ns - newest > MAX_GAP * 1e9 and not self._confirms_jump(stamp_ns):
            return False
        late = max(SET_BACK, self._settings().patience)
        if newest is not None and not -late * 1e9 <= stamp_ns - newest <= MAX_GAP * 1e9:
            self.get_logger().warning(
                f"the rig's clock went from {newest / 1e9:.1f} to {stamp_ns / 1e9:.1f} s: the twin starts anew"
            )
            self._restarts += 1
            self._restart()
            self._topics.restart()
            newest = None
        self._newest_ns = stamp_ns if newest is None else max(stamp_ns, newest)
        now_ns, sim_time = self.get_clock().now().nanoseconds, bool(self.get_parameter("use_sim_time").value)
        # The clock comes on its own topic and may lag behind the sample.
        self._clock_fault = clock_offset_message(stamp_ns, max(now_ns, stamp_ns) if sim_time else now_ns, sim_time)
        return True

    def _confirms_jump(self, stamp_ns: int) -> bool:
        """Whether a stamp far ahead is the second of its kind; a single one is wrong and dropped."""
        before, self._ahead_ns = self._ahead_ns, stamp_ns
        return before is not None and abs(stamp_ns - before) <= MAX_GAP * 1e9

    def _advance(self) -> None:
        """Simulate what is complete, publish it, and report once a second."""
        # Before the twin works, which may take long: meanwhile samples wait, and the rig is not silent.
        silence = 0.0 if self._watchdog.tick() else self._watchdog.silent_for(STALE_AFTER)
        if not self.is_active or self.twin is None or self.shutdown_request.requested:
            return
        for channel, (times, values) in self._waiting.items():
            self.twin.add(channel, times, values)
        self._waiting.clear()
        try:
            reports = self.twin.advance()
        except InputError as error:
            self._fail(error)
            return
        for remark in self.twin.remarks[self._remarked :]:
            self.get_logger().warning(remark)
        self._remarked = len(self.twin.remarks)
        for report in reports:
            self._publish(report)
        if not reports:
            self._publish_diagnosis(self.twin.latest_report())  # an answer may come while the rig is silent
        if silence - self._reported_silence >= SILENCE_PERIOD:
            self._reported_silence = silence
            self._report(silence)
        elif silence == 0.0:
            self._reported_silence = 0.0

    def _fail(self, error: InputError) -> None:
        """The twin cannot simulate this: say so, and start anew."""
        self.get_logger().error(f"{error}: the twin starts anew", throttle_duration_sec=5.0)
        self._restart()
        self._failure = f"started anew: {error}"

    def _publish(self, report: TwinReport) -> None:
        if self.twin is None or self._start_ns is None:
            return
        self._topics.publish(report, self._start_ns)
        self._publish_diagnosis(report)
        if self._diagnostics.is_due(self._start_ns + round(report.time * 1e9)):
            self._report(0.0)

    def _publish_diagnosis(self, report: TwinReport | None) -> None:
        if report is not None and self.twin is not None and self._start_ns is not None:
            start = self._start_ns / 1e9
            self._topics.publish_diagnosis(report, start, self.twin.answer, self.twin.answered)

    def _report(self, silence: float) -> None:
        """Publish the statuses; silence: s of wall time without a sample."""
        if self._newest_ns is None or self.twin is None:
            return
        report, start = self.twin.latest_report(), (self._start_ns or 0) / 1e9
        behind = 0.0 if report is None else self._newest_ns / 1e9 - start - report.time
        failure = self._failure or (f"no diagnosis: {self.twin.failure}" if self.twin.failure else "")
        health = TwinHealth(behind, self._restarts, self.twin.asking, failure)
        statuses = [self._measurements_status(silence), *twin_statuses(report, start, health)]
        self._diagnostics.publish(self._newest_ns, statuses)

    def _measurements_status(self, silence: float) -> Status:
        if silence > 0.0:
            return Status(Level.ERROR, "measurements", f"the rig is silent since {silence:.0f} s")
        if self._clock_fault:
            return Status(Level.WARN, "measurements", self._clock_fault)
        missing = [one.name for one in self._sensors if one.get_publisher_count() == 0]
        if missing:
            return Status(Level.WARN, "measurements", f"nobody publishes {', '.join(missing)}")
        return Status(Level.OK, "measurements", "every channel is there")

    def _recalibrate(self) -> str:
        self._running().recalibrate()
        return "learns the rig anew"

    def _diagnose(self) -> str:
        if not self.values["diagnose_changes"]:
            raise InputError("diagnose_changes is false")
        self._running().ask_diagnosis()
        return "asked; the answer comes on gap/diagnosis"

    def _save_rig(self) -> str:
        path = Path(self.values["calibrated_rig"])
        given = Path(self.values["rig"]) if self.values["rig"] else None
        check_outputs([path], [given])
        twin = self._running()
        if not twin.learnt:
            note = "" if twin.report is None else f" ({twin.report.note})"
            raise InputError(f"{path}: not written: the twin still learns the rig{note}; call again when it watches")
        write_atomically(path, dump_rig(twin.calibrated_rig()).encode())
        return f"wrote {path}"

    def _running(self) -> Twin:
        """The twin, once it has simulated something. Raises InputError before."""
        if self.twin is None or self.twin.report is None:
            raise InputError("the twin has no sample of the rig yet")
        return self.twin
