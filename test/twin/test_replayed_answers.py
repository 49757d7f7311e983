"""In a replay an answer comes by the processor time of its diagnosis, however busy the machine is."""

import time

import numpy as np
import pytest

from slider_drilling.rig import load_rig
from slider_drilling.twin.ask import Answer
from slider_drilling.twin.background import Reply
from slider_drilling.twin.change_statistic import FeatureChange
from slider_drilling.twin.detections import DetectionLog
from slider_drilling.twin.detector import Alarm
from slider_drilling.twin.diagnoser import ASKED_AFTER_S, Diagnoser
from slider_drilling.twin.motion import new_buffers

ASKED = 500.0 + ASKED_AFTER_S[0]


def answer_slowly(before, after, rig, channel):
    """Little work, in a process that hardly gets the processor."""
    time.sleep(2.0)
    return Answer({"verdict": "effect", "effects": ["heave"], "site": "draw_works"})


@pytest.fixture
def asked(request):
    """A diagnoser that has just asked about a detection, in a replay."""
    rig = load_rig(request.config.rootpath / "config" / "rig.short.yaml")
    buffers, log = new_buffers(3600.0), DetectionLog()
    times = np.arange(0.0, ASKED, 0.5)
    buffers["top_drive_angle"].add(times, np.sin(times))
    log.take(Alarm(500.0, "hook_load", "mean", FeatureChange(30.0, 480.0, (470.0, 490.0), "step", 5.0, "sudden")))
    diagnoser = Diagnoser(answer_slowly, rig, buffers, log)
    diagnoser.detected(log.detections[0])
    diagnoser.update(ASKED)
    assert diagnoser.asking
    yield diagnoser, log
    diagnoser.close()


def test_answer_comes_when_its_processor_time_is_over(asked):
    diagnoser, log = asked
    diagnoser.hold_reply()
    cpu = diagnoser._held.cpu
    for second in range(1, 60):
        assert diagnoser.asking and log.detections[0].answered is None
        diagnoser.update(ASKED + second)
        if second >= cpu:
            break
    assert log.detections[0].answered == ASKED + np.ceil(cpu) and log.detections[0].effects == ("heave",)
    assert not diagnoser.asking


@pytest.mark.parametrize("cpu", [0.5, 7.3, 31.0])
def test_reply_is_held_for_its_processor_time_alone(asked, monkeypatch, cpu):
    diagnoser, log = asked
    monkeypatch.setattr(diagnoser._background, "wait", lambda: Reply({"verdict": "none"}, None, None, cpu))
    diagnoser.hold_reply()
    diagnoser.update(ASKED + cpu - 0.1)
    assert log.detections[0].answered is None
    diagnoser.update(ASKED + cpu)
    assert log.detections[0].answered == ASKED + cpu


def test_answer_after_the_end_of_a_replay_has_its_time(asked):
    diagnoser, log = asked
    diagnoser.take_last_reply()
    answered = log.detections[0].answered
    assert answered > ASKED and not diagnoser.asking


def test_nothing_asked_is_not_waited_for(asked):
    diagnoser, _ = asked
    diagnoser.take_last_reply()
    began = time.monotonic()
    diagnoser.hold_reply()
    assert time.monotonic() - began < 1.0
