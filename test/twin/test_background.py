import os
import time

import pytest

from slider_drilling.diagnosis.onset import Since
from slider_drilling.errors import InputError
from slider_drilling.log import RigLog
from slider_drilling.rig import load_rig
from slider_drilling.twin.ask import Answer
from slider_drilling.twin.background import BackgroundDiagnosis, Question

_LOG = RigLog("test", 0)


def answer_at_once(before, after, rig, since, onset):
    return Answer({"verdict": "effect", "effects": ["heave"], "channel": since.channel, "process": os.getpid()})


def refuse(before, after, rig, since, onset):
    raise InputError("too short:\ngive more")


def sleep_long(before, after, rig, since, onset):
    time.sleep(600.0)
    return Answer({})


def _ask(question, rig):
    background = BackgroundDiagnosis()
    background.start(Question(question, _LOG, _LOG, rig, Since(1.0, channel="hook_load")))
    return background


def _await(background):
    reply = None
    until = time.monotonic() + 120.0
    while background.running and time.monotonic() < until:
        reply = background.poll()
        time.sleep(0.02)
    return reply


@pytest.fixture(scope="module")
def rig(request):
    return load_rig(request.config.rootpath / "config" / "rig.short.yaml")


def test_answer_comes_from_another_process(rig):
    background = _ask(answer_at_once, rig)
    reply = _await(background)
    background.close()
    assert reply.tree["effects"] == ["heave"] and reply.tree["channel"] == "hook_load"
    assert reply.tree["process"] != os.getpid()
    assert reply.error is None and reply.cpu > 0.0 and reply.peak > 1e6


def test_refusal_is_told_in_one_line(rig):
    background = _ask(refuse, rig)
    reply = _await(background)
    background.close()
    assert reply.tree is None and reply.error == "too short: give more"


def test_closing_does_not_wait_for_answer(rig):
    background = _ask(sleep_long, rig)
    began = time.monotonic()
    assert background.poll() is None and background.running
    background.close()
    assert time.monotonic() - began < 5.0 and not background.running
