"""What `watch` prints beside its rows, and what it writes when Ctrl-C ends it."""

import importlib
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from click.testing import CliRunner

from slider_drilling.commands.watch import command
from slider_drilling.commands.watch_output import JsonLines, TableLines
from slider_drilling.errors import InputError
from slider_drilling.rig import Rig, load_rig
from slider_drilling.twin import ChannelState, Detection, Twin, TwinReport
from slider_drilling.twin.report import Trend
from slider_drilling.units import SI

UNSURE = Trend(-200.0, -11200.0, 10700.0, "N")


def make_report(channels=(), offset=UNSURE):
    states = {name: ChannelState(name, "N", 1.0, 1.0, 1.0, 1.0, 1.0, 2.0, 1.0) for name in channels}
    return TwinReport(9.9, "watching", "", np.arange(10.0), {}, states, {"hook_load_offset": offset})


def make_twin(**changes):
    given = {"remarks": (), "failure": "", "learnt": True, "not_compared": ""}
    return SimpleNamespace(**{**given, **changes})


@pytest.mark.parametrize("lines", [lambda twin: JsonLines(twin), lambda twin: TableLines(twin, SI)])
def test_failed_diagnosis_is_a_note(lines, capfd):
    twin = make_twin(failure="too short")
    shown = lines(twin)
    for _ in range(2):
        shown.show(make_report())
    printed = capfd.readouterr()
    assert printed.err == "note: the diagnosis gave no answer: too short\n"
    assert "gave no answer" not in printed.out


def test_answer_says_since_when(capfd):
    change = Detection(1, 9.0, 7.0, (6.0, 8.0), "standpipe_pressure", "hydraulics", "step", 3.0, "pressure fell")
    named = replace(change, effects=("washout",), verdict="effect", answered=9.9, since=4.0, interval=(3.0, 5.0))
    lines = TableLines(make_twin(), SI)
    for each in (change, named):
        lines.show(replace(make_report(), detections=(each,)))
    seen, answer = capfd.readouterr().out.splitlines()[-2:]
    assert "pressure fell, since 7 s (6 to 8 s), 3.0 noise levels" in seen
    assert answer == "ANSWER 1 at 10 s: washout (effect, site hydraulics), since 4 s (3 to 5 s)"


def end_of(twin, report, capfd):
    lines = TableLines(twin, SI)
    lines.show(report)
    lines.end()
    return capfd.readouterr().out.splitlines()[-1]


@pytest.mark.parametrize(("offset", "text"), [
    (UNSURE, "hook load reads 0.2 kN too little (-10.7 to 11.2)"),
    (Trend(3000.0, 2000.0, 4500.0, "N"), "hook load reads 3.0 kN too much (2.0 to 4.5)"),
])  # fmt: skip
def test_error_of_the_hook_load_has_a_direction(offset, text, capfd):
    assert end_of(make_twin(), make_report(["hook_load"], offset), capfd) == text


@pytest.mark.parametrize(("twin", "channels"), [(make_twin(), []), (make_twin(learnt=False), ["hook_load"])])
def test_hook_load_that_is_not_known_has_no_error(twin, channels, capfd):
    assert end_of(twin, make_report(channels), capfd) == "watched 10 s: 0 changes detected"


@pytest.fixture
def interrupted(monkeypatch, shared_data, tmp_path):
    """Watches until it is stopped with `--save-rig`; returns the file."""

    def run(learnt, stop=KeyboardInterrupt):
        def interrupt(twin, feed, show, source):
            raise stop

        monkeypatch.setattr(importlib.import_module("slider_drilling.twin.watch"), "watch", interrupt)
        monkeypatch.setattr(Twin, "learnt", learnt)
        path = tmp_path / "calibrated.yaml"
        log = shared_data / "logs" / "nominal_short.mcap"
        result = CliRunner().invoke(command, [str(log), "--no-diagnose", "--save-rig", str(path)])
        assert result.exit_code != 0
        return path

    return run


def test_interrupt_writes_the_calibrated_rig(interrupted):
    assert isinstance(load_rig(interrupted(learnt=True)), Rig)


def test_stream_that_cannot_go_on_leaves_the_calibrated_rig(interrupted):
    assert isinstance(load_rig(interrupted(learnt=True, stop=InputError("its clock was set back"))), Rig)


@pytest.mark.parametrize(
    ("stop", "summaries"), [(KeyboardInterrupt(), 1), (InputError("lost"), 1), (OSError("full"), 0)]
)
def test_watch_that_cannot_print_prints_no_summary(stop, summaries, monkeypatch, shared_data):
    ended = []
    monkeypatch.setattr(JsonLines, "end", lambda lines: ended.append(lines))

    def interrupt(twin, feed, show, source):
        raise stop

    monkeypatch.setattr(importlib.import_module("slider_drilling.twin.watch"), "watch", interrupt)
    result = CliRunner().invoke(command, [str(shared_data / "logs" / "nominal_short.mcap"), "--json", "--no-diagnose"])
    assert result.exit_code != 0 and len(ended) == summaries


def test_interrupt_before_the_rig_is_learnt_writes_nothing(interrupted):
    assert not interrupted(learnt=False).exists()
