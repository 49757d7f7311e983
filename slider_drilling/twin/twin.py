"""The twin: samples in, once a second a report out."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from slider_drilling.control.interface import Measurements
from slider_drilling.drillstring import InitialState
from slider_drilling.drillstring.observer_noise import needed_smoothing
from slider_drilling.errors import InputError
from slider_drilling.log_inputs.infer_initial_state import infer_initial_state
from slider_drilling.rig import Rig
from slider_drilling.twin.activity import OFF_BOTTOM, Activity, ActivityMonitor
from slider_drilling.twin.ask import Ask
from slider_drilling.twin.change_statistic import FeatureChange, Uncertainty
from slider_drilling.twin.channels import CHANNELS, COMPARED, SURFACE, declared_noise
from slider_drilling.twin.comparison import Comparison
from slider_drilling.twin.detections import DetectionLog
from slider_drilling.twin.detector import Alarm, ChangeDetector
from slider_drilling.twin.diagnoser import AnsweredQuestion, Diagnoser
from slider_drilling.twin.features import Feature, features
from slider_drilling.twin.follower import Followed, Follower
from slider_drilling.twin.forecast import ToolFaceSkill, make_forecast
from slider_drilling.twin.history import History
from slider_drilling.twin.learner import Learner
from slider_drilling.twin.learning import RecordedBlock
from slider_drilling.twin.level_remarks import LEVELS_AFTER_S, LeftOut, level_remarks
from slider_drilling.twin.motion import DriveMotion, SpeedIntegrals, new_buffers
from slider_drilling.twin.needed_samples import FIRST_S, SparseSamples, nothing_compared
from slider_drilling.twin.recorded_log import recorded_log
from slider_drilling.twin.report import Detection, Forecast, TwinReport
from slider_drilling.twin.samples import Array, noise_and_interval
from slider_drilling.twin.settings import TwinSettings
from slider_drilling.twin.stall_watch import StallWatch
from slider_drilling.twin.tracked import rig_at, tracked_parameters
from slider_drilling.twin.unlogged_block import BlockFromPressure, BlockSource, rig_moved_by, source_of_block
from slider_drilling.twin.wander import parameter_wanders

_REPORT_S = 1.0
_HISTORY_S = 400.0
_FEATURES_EVERY = 5  # seconds between two windows whose features are taken
_MOTION_S = 200.0  # of the drives' past, that a forecast repeats


class Twin:
    """Simulates alongside a rig. For one thread; beside a rig `add` and `advance` take milliseconds and never wait.

    Args:
        rig: The rig file.
        settings: How it follows the rig.
        ask: Asked in a process of its own after a detection; None for no diagnosis.
        replayed: The samples are of the past. `advance` waits for a diagnosis, whose answer comes as late as it would
            beside the rig, by its processor time.
        told: Called with every question that is answered.

    Attributes:
        report: The latest; None before the first second.
        remarks: One sentence each: what stands for channels that the rig does not send, which come too seldom, and
            after a minute which have values that such a rig does not have.
        detector: Watches for changes; None until the rig is learnt.
    """

    def __init__(
        self, rig: Rig, settings: TwinSettings = TwinSettings(), ask: Ask | None = None, replayed: bool = False,
        told: Callable[[AnsweredQuestion], None] = lambda question: None,
    ) -> None:  # fmt: skip
        self.rig, self.settings = rig, settings
        self._buffers = new_buffers(settings.kept)
        self._motion = DriveMotion(rig, self._buffers, settings.patience)
        self._integrals = SpeedIntegrals(self._buffers)
        self._parameters = tracked_parameters(rig)
        self._noise = {name: declared_noise(rig, name) for name in COMPARED}
        self._comparison = Comparison(self._buffers, self._noise, settings.patience)
        self._activity = ActivityMonitor(rig)
        self._history = History(_HISTORY_S)
        self._log = DetectionLog()
        self._diagnoser = Diagnoser(
            ask, rig, self._buffers, self._log, replayed, settings.check_every, self._dated, told
        )
        self._left_out, self._sparse, self._stall = LeftOut(), SparseSamples(self._buffers), StallWatch(rig)
        self._block_from: BlockSource | None = None  # None before the first second
        self._block: BlockFromPressure | None = None
        self._off_bottom, self._plant_rig = False, rig
        self._learner: Learner | None = None
        self.detector: ChangeDetector | None = None
        self._circulation = ChangeDetector.before_learning(len(self._parameters))
        self._recalibrated = -math.inf  # s, when the rig began to be learnt anew
        self._known_changes = 0  # detections when the rig began to be learnt
        self._compared = False  # whether a change could have shown so far
        self._next = math.nan  # s, the first grid time that is not simulated yet
        self._samples, self._seconds = round(_REPORT_S / settings.interval), 0
        self._forecast: Forecast | None = None
        self._skill = ToolFaceSkill()
        self.report: TwinReport | None = None
        self.remarks: tuple[str, ...] = ()

    @property
    def detections(self) -> tuple[Detection, ...]:
        """All so far, newest last."""
        return tuple(self._log.detections)

    @property
    def answer(self) -> dict[str, Any] | None:
        """The latest diagnosis, as diagnosis.json has it; None before the first."""
        return self._diagnoser.answer

    @property
    def answered(self) -> float | None:
        """s of the rig's time, when it came."""
        return self._diagnoser.answered

    @property
    def asking(self) -> bool:
        """Whether a diagnosis is under way."""
        return self._diagnoser.asking

    @property
    def failure(self) -> str:
        """Why the last diagnosis gave no answer, in one line; empty if it gave one."""
        return self._diagnoser.error or ""

    @property
    def learnt(self) -> bool:
        """Whether the rig is learnt, so that a change would show."""
        return self.detector is not None

    @property
    def span(self) -> float:
        """s from the first sample of the top drive to the newest of the rig; 0 without any."""
        return max(self._motion.newest - self._motion.started, 0.0)

    @property
    def left_out(self) -> tuple[str, ...]:
        """One sentence for each channel of which most values were left out: no rig has them."""
        return self._left_out.remarks()

    @property
    def not_compared(self) -> str:
        """Why no change could show so far, and what the twin needs, in one line; empty once one could."""
        if self._compared:
            return ""
        share = 0.0 if self._learner is None else self._learner.share
        return nothing_compared(self.learnt, share, self.settings.learning)

    def add(self, channel: str, times: ArrayLike, values: ArrayLike) -> None:
        """Take samples of one channel: any number, in any order.

        Args:
            channel: One of `channels.CHANNELS`.
            times: s, when they were measured, one or (n,).
            values: SI, as many; NaN is a missing value.

        Raises:
            InputError: The channel is unknown, or there are not as many values as times.
        """
        if channel not in self._buffers:
            raise InputError(f"twin: {channel}: no such channel; use {', '.join(CHANNELS)}")
        time, value = np.atleast_1d(np.asarray(times, float)), np.atleast_1d(np.asarray(values, float))
        if time.ndim != 1 or time.shape != value.shape:
            shapes = f"times of shape {time.shape} and values of shape {value.shape}"
            raise InputError(f"twin: {channel}: {shapes}; give as many values as times")
        self._buffers[channel].add(time, self._left_out.without(channel, value))

    def add_measurements(self, measurements: Measurements) -> None:
        """Take one sample of all channels at surface, and the toolfaces that came with it."""
        for name in CHANNELS:
            if name != "tool_face":
                self.add(name, measurements.time, getattr(measurements, name))
        for sample in measurements.mwd:
            self.add("tool_face", sample.measured_at, sample.tool_face)

    def advance(self) -> list[TwinReport]:
        """Simulate every second whose samples have arrived; returns a report for each."""
        reports = self._advance(self._motion.known_until())
        if not reports and self.report is not None:
            self._diagnoser.update(self._motion.newest)
        return reports

    def latest_report(self) -> TwinReport | None:
        """The latest report with the detections as they are known by now."""
        return None if self.report is None else replace(self.report, detections=self.detections)

    def finish(self) -> list[TwinReport]:
        """Simulate what is left when no more samples come; returns the reports."""
        return self._advance(self._motion.newest)

    def calibrated_rig(self) -> Rig:
        """The rig file with the numbers as they are now."""
        values = [p.nominal for p in self._parameters] if self._learner is None else self._learner.values
        return rig_at(self.rig, {p.name: float(v) for p, v in zip(self._parameters, values, strict=True)})

    def recalibrate(self) -> None:
        """Forget what was learnt of the rig, and learn it again from now on."""
        self._learner = self.detector = None
        self._circulation = ChangeDetector.before_learning(len(self._parameters))
        self._known_changes = len(self._log.detections)
        self._recalibrated = self._motion.newest
        self._diagnoser.checks.begin(math.inf)
        self._history.clear()

    def ask_diagnosis(self) -> None:
        """Ask for a diagnosis now, about the last detection or everything recorded.

        Raises:
            InputError: That is not possible: one is under way, or there are too few samples yet.
        """
        self._diagnoser.ask_now(self._motion.newest)

    def take_held_answer(self) -> None:
        """Take the answer that comes after the end of a replay."""
        self._diagnoser.take_held_reply()

    def close(self) -> None:
        """End the diagnosis in the background, if there is one."""
        self._diagnoser.close()

    def _advance(self, until: float) -> list[TwinReport]:
        reports: list[TwinReport] = []
        if math.isnan(self._next):
            start = self._motion.started
            if until - start < FIRST_S:
                return reports
            self._next = start
        interval = self.settings.interval
        while self._next + (self._samples - 1) * interval <= until + 1e-9:
            grid: Array = self._next + interval * np.arange(self._samples, dtype=float)
            self._next = float(grid[-1] + interval)
            reports.append(self._step(grid))
        return reports

    def _step(self, grid: Array) -> TwinReport:
        self._integrals.update()
        self._choose_block()
        learner = self._learner = self._learner or self._new_learner(float(grid[0]))
        measured = {name: self._comparison.measured(name, grid) for name in SURFACE}
        commands = self._motion.commands(grid)
        if learner.learnt:
            self._stall.update(commands, measured["standpipe_pressure"], learner.pressure_gain)
        if self._block is not None:
            weight = learner.follower.weight_on_bit
            commands = self._block.with_block(commands, measured["standpipe_pressure"], weight)
            measured["standpipe_pressure"] = np.full(grid.shape, np.nan)  # it has been used
        followed = learner.advance(commands, measured["surface_torque"])
        self._history.add(followed, commands)
        if self._motion.missing(grid):
            self._activity.disturb(float(grid[-1]), "samples of the top drive are missing")
        if self._stall.stalls:
            self._activity.disturb(float(grid[-1]), "the motor stalls")
        activity = self._activity.update(commands, math.inf if self._off_bottom else learner.follower.mean_weight)
        if learner.take(followed, RecordedBlock(commands, measured, activity.settled, activity.drilling)):
            self._history.clear()
            self.detector = self._new_detector(learner)
            self._diagnoser.checks.follow_from(max(self._motion.started, self._recalibrated))
        now = float(grid[-1])
        changes = self._log.detections[self._known_changes :]
        changed = min((each.interval[0] for each in changes), default=math.inf)
        self._comparison.update(self._history, learner.values, now, learner.learnt and activity.comparable, changed)
        self._look_for_changes(activity, now)
        self._diagnoser.update(now)
        self._look_ahead(activity, now)
        self.report = self._report(grid, followed, activity)
        self._seconds += 1
        if self._seconds % LEVELS_AFTER_S == 0:  # rates may change
            self._add_remarks(self._sparse.remarks(now - LEVELS_AFTER_S, now))
        if self._seconds == LEVELS_AFTER_S:
            self._note_levels(now, learner.fixed)
        return self.report

    def _new_learner(self, begin: float) -> Learner:
        self._add_remarks(self._sparse.remarks(begin, begin + FIRST_S))
        first = recorded_log(self._buffers, self.rig, begin, begin + FIRST_S)
        interval = self.settings.interval
        grid: Array = begin + interval * np.arange(round(FIRST_S / interval), dtype=float)
        start = infer_initial_state(first, self.rig, self._motion.commands(grid))
        return Learner(self._parameters, self._noise, self.settings.learning, lambda v: self._plants(start, v))

    def _choose_block(self) -> None:
        """Choose what moves the plants' block, and say what stands for it; begin anew where a better source comes."""
        before, self._block_from = self._block_from, source_of_block(self._buffers)
        source = self._block_from
        if source == before:
            return
        self._block = BlockFromPressure(self.rig) if source is BlockSource.PRESSURE else None
        self._off_bottom, self._plant_rig = source is BlockSource.NOTHING, rig_moved_by(source, self.rig)
        if before is not None:
            self.recalibrate()
        self._add_remarks(source.remarks(began_late=before is not None))

    def _add_remarks(self, remarks: Iterable[str]) -> None:
        self.remarks += tuple(remark for remark in remarks if remark not in self.remarks)

    def _note_levels(self, now: float, values: Array) -> None:
        """Say which channels have values that such a rig does not have."""
        begin = now - LEVELS_AFTER_S
        log, done = recorded_log(self._buffers, self.rig, begin, now), self._history.window(begin, now)
        self._add_remarks(self._left_out.remarks())
        if done is not None:
            torque = done.at(values)[:, list(COMPARED).index("surface_torque")]
            expected = {"time": done.time - begin, "surface_torque": torque}
            self._add_remarks(level_remarks(log, self._plant_rig, expected))

    def _plants(self, start: InitialState, values: Array) -> Follower:
        s = self.settings
        noise = noise_and_interval(self._buffers["surface_torque"], self._noise["surface_torque"], s.interval)
        smoothing = needed_smoothing(self.rig, *noise, s.observer_gain)
        follower = Follower(
            self._plant_rig, self._parameters, s.elements, s.interval, s.observer_gain, smoothing, start
        )
        follower.move_centre(values)
        return follower

    def _look_for_changes(self, activity: Activity, now: float) -> None:
        """Take the features of this second, test a part of them, and turn alarms into detections."""
        learner, detector = self._learner, self.detector
        if learner is None:
            return
        if self._seconds % _FEATURES_EVERY == 0 or math.isfinite(activity.valid_until):
            # Before the rig is learnt only circulation off bottom says something: its pressure needs no string.
            seen = activity if detector is not None else replace(activity, comparable=False)
            compared = seen.comparable or seen.circulating
            found = self._features(activity.period, now, learner.fixed) if compared else []
            (detector or self._circulation).add(now, seen, found)
            self._compared |= detector is not None and bool(found)
        if detector is None:
            return
        if activity.comparable:
            watched = detector.watched(activity.mode)[self._seconds % _FEATURES_EVERY :: _FEATURES_EVERY]
            self._take_alarms(map(detector.test, watched), now)
        if activity.circulation_known:
            ended = activity.mode != OFF_BOTTOM
            self._take_alarms((detector.test(key, ended) for key in detector.watched(OFF_BOTTOM)), now)
        since = self._log.settled_change(now)
        if since is not None:
            detector.forget(since)

    def _new_detector(self, learner: Learner) -> ChangeDetector:
        """A detector that knows what circulation off bottom has shown while the rig was learnt."""
        names = [parameter.name for parameter in self._parameters]
        nominal = np.array([parameter.nominal for parameter in self._parameters], dtype=float)
        uncertain = Uncertainty(learner.covariance, parameter_wanders(names))
        return self._circulation.recalibrated(learner.fixed - nominal, uncertain)

    def _take_alarms(self, alarms: Iterable[Alarm | None], now: float) -> None:
        """Turn alarms into detections, and ask about new ones.

        An alarm holds the time of the last value that shows it, some seconds before it is known.
        """
        for alarm in alarms:
            if alarm is not None and self._log.take(replace(alarm, time=now)):
                self._diagnoser.detected(self._log.detections[-1])

    def _dated(self, low: float, high: float) -> FeatureChange | None:
        return None if self.detector is None else self.detector.dated(low, high)

    def _features(self, period: float, now: float, values: Array) -> list[Feature]:
        end = now - self.settings.patience
        found = self._history.window(end - period, end)
        if found is None or found.time.size < 0.9 * period / self.settings.interval:
            return []
        expected = found.at(values)
        innovation = np.full_like(expected, np.nan)
        for row, name in enumerate(COMPARED):
            if name in SURFACE and not (name == "standpipe_pressure" and self._block is not None):
                innovation[:, row] = self._comparison.measured(name, found.time) - expected[:, row]
        return features(innovation, expected, found.sensitivity, self._noise)

    def _look_ahead(self, activity: Activity, now: float) -> None:
        settings, learner = self.settings, self._learner
        due = settings.forecast > 0.0 and self._seconds % round(settings.forecast_every) == 0
        past = self._history.motion(now - _MOTION_S, now) if due else None
        if past is None or learner is None or past.time.size < 2:
            return
        period = activity.period if activity.mode == "rocking" else None
        made = make_forecast(learner.follower, learner.values, past, period, settings.forecast)
        buffer, latest = self._buffers["tool_face"], self._history.window(now - 1e-6, now + 1e-6)
        if len(buffer) and latest is not None:
            present = float(latest.at(learner.values)[-1, list(COMPARED).index("tool_face")])
            made = self._skill.shrunk(made, present, self._comparison.tool_face_offset, float(buffer.value[-1]))
        self._forecast = made

    def _report(self, grid: Array, followed: Followed, activity: Activity) -> TwinReport:
        assert self._learner is not None
        now, learner = float(grid[-1]), self._learner
        calibrated = followed.at(learner.values)
        expected = {name: calibrated[:, row] for row, name in enumerate(COMPARED)}
        expected["tool_face"] = expected["tool_face"] + self._comparison.tool_face_offset
        states = {
            name: self._comparison.state(name, float(expected[name][-1]), now)
            for name in COMPARED if len(self._buffers[name])
        }  # fmt: skip
        state = "watching" if learner.learnt and activity.comparable else "operation" if learner.learnt else "learning"
        note = activity.why or ("" if learner.learnt else f"{100.0 * learner.share:.0f} % learnt")
        trends, stall = learner.trend_table(), self._stall.stall
        return TwinReport(now, state, note, grid, expected, states, trends, self._forecast, self.detections, stall)
