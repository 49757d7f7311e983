"""In a replay an answer comes by the processor time of its diagnosis, however busy the machine is."""

import os
import time

import numpy as np
import pytest

from slider_drilling.log import RigLog
from slider_drilling.rig import load_rig
from slider_drilling.twin.ask import ASKED_AFTER_S, Answer
from slider_drilling.twin.background import BackgroundDiagnosis, Question, Reply
from slider_drilling.twin.change_statistic import FeatureChange
from slider_drilling.twin.detections import DetectionLog
from slider_drilling.twin.detector import Alarm
from slider_drilling.twin.diagnoser import Diagnoser
from slider_drilling.twin.motion import new_buffers

ASKED = 500.0 + ASKED_AFTER_S[0]


def answer_slowly(before, after, rig, since, onset):
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
    diagnoser = Diagnoser(answer_slowly, rig, buffers, log, replayed=True)
    diagnoser.detected(log.detections[0])
    diagnoser.update(ASKED)
    assert diagnoser.asking
    yield diagnoser, log
    diagnoser.close()


def test_answer_comes_when_its_processor_time_is_over(asked):
    diagnoser, log = asked
    cpu = diagnoser._held.cpu
    for second in range(1, 60):
        assert diagnoser.asking and log.detections[0].answered is None
        diagnoser.update(ASKED + second)
        if second >= cpu:
            break
    assert log.detections[0].answered == ASKED + np.ceil(cpu) and log.detections[0].effects == ("heave",)
    assert not diagnoser.asking


@pytest.mark.parametrize("cpu", [0.5, 7.3, 31.0])
def test_reply_is_held_for_its_processor_time_alone(asked, cpu):
    diagnoser, log = asked
    diagnoser._held = Reply({"verdict": "none"}, None, None, cpu)
    diagnoser.update(ASKED + cpu - 0.1)
    assert log.detections[0].answered is None
    diagnoser.update(ASKED + cpu)
    assert log.detections[0].answered == ASKED + cpu


def test_answer_after_the_end_of_a_replay_has_its_time(asked):
    diagnoser, log = asked
    diagnoser.take_held_reply()
    answered = log.detections[0].answered
    assert answered > ASKED and not diagnoser.asking


def how_nice(before, after, rig, since, onset):
    return Answer({"verdict": "none", "nice": os.nice(0)})


@pytest.mark.parametrize(("nice", "above"), [({}, 10), ({"nice": 0}, 0)])
def test_only_beside_a_rig_a_diagnosis_stands_back(request, nice, above):
    rig = load_rig(request.config.rootpath / "config" / "rig.short.yaml")
    log, background = RigLog("test", 0), BackgroundDiagnosis()
    background.start(Question(how_nice, log, log, rig, None, **nice))
    reply = background.wait()
    background.close()
    assert reply.tree["nice"] == min(os.nice(0) + above, 19)
    assert background.wait() is None
