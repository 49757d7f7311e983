"""What is said where a record cannot show a change."""

import json
from types import SimpleNamespace

import numpy as np
import pytest
from click.testing import CliRunner

import slider_drilling as sd
from slider_drilling.api import what_changed
from slider_drilling.api.what_changed import find_since
from slider_drilling.commands.watch import command
from slider_drilling.errors import InputError
from slider_drilling.log import read_log
from slider_drilling.log.write import LogWriter
from slider_drilling.rig import dump_rig, load_rig
from slider_drilling.twin import Detection, Twin, TwinSettings, diagnose_after, learner, learning
from slider_drilling.twin.needed_samples import ALWAYS_LEARNT_S

NEVER = "the twin never finished learning the rig"


@pytest.fixture
def rig(request):
    return load_rig(request.config.rootpath / "config" / "rig.short.yaml")


@pytest.fixture
def make_log(tmp_path, rig):
    """Writes a log of a rig that rocks, of so many s and samples a second."""

    def make(seconds, rate, hook_load_rate=None):
        path = tmp_path / f"{seconds:g}_s.mcap"
        with LogWriter(path, rig_text=dump_rig(rig), recorded_by="test") as writer:
            for time in np.arange(0.0, seconds, 1.0 / rate).tolist():
                angle, speed = np.sin(0.3 * time), 0.3 * np.cos(0.3 * time)
                writer.joint_state("top_drive/joint_states", time, "top_drive", angle, speed, 1000.0 * angle)
            for time in np.arange(0.0, seconds, 1.0 / (hook_load_rate or rate)).tolist():
                writer.joint_state("draw_works/joint_states", time, "block", 0.01 * time, 0.01, 4e5)
        return path

    return make


@pytest.fixture
def never_learnt(make_log):
    return make_log(30.0, 10.0)


def run(*arguments):
    return CliRunner().invoke(command, [*map(str, arguments), "--no-diagnose"], catch_exceptions=False)


def test_twin_that_never_learnt_says_so_and_what_it_needs(never_learnt):
    end = [line for line in run(never_learnt).stdout.splitlines() if line.startswith("watched")]
    assert len(end) == 1 and NEVER in end[0] and "180 s of settled work" in end[0] and "longer record" in end[0]
    assert "changes detected" not in end[0]


def test_json_and_python_say_that_nothing_was_compared(never_learnt):
    printed = run(never_learnt, "--json")
    lines = [json.loads(line) for line in printed.stdout.splitlines()]
    assert lines and all(line["threshold"]["surface_torque"] is None for line in lines)
    found = sd.watch(str(never_learnt))
    assert NEVER in found.not_compared and "nothing compared" in repr(found)
    assert printed.stderr.strip().endswith(found.not_compared)


def test_since_auto_does_not_say_no_change_where_nothing_was_compared(never_learnt):
    log = read_log(never_learnt)
    with pytest.raises(InputError, match=f"since auto: .*{NEVER}") as caught:
        find_since(log, log.rig(), lambda what, share: None)
    assert "no change detected" not in str(caught.value)


CHANGE = Detection(1, 1300.0, 1000.0, (950.0, 1050.0), "hook_load", "sensor", "step", 3.0, "")


@pytest.mark.parametrize("shown_by", ["features", "checks", "nothing"])
def test_since_auto_asks_checks_only_where_nothing_else_shows_a_change(make_log, monkeypatch, shown_by):
    asked = []

    def first_change(log, rig, ask, progress):
        asked.append(ask)
        shown = "features" if ask is None else "checks"
        return (CHANGE if shown == shown_by else None), ""

    monkeypatch.setattr(what_changed, "_first_change", first_change)
    log = read_log(make_log(3.0, 10.0))
    if shown_by == "nothing":
        with pytest.raises(InputError, match=r"since auto: .*no change detected; give the time"):
            find_since(log, log.rig(), lambda what, share: None)
    else:
        assert find_since(log, log.rig(), lambda what, share: None)[0].time == 1000.0
    assert asked == ([None] if shown_by == "features" else [None, diagnose_after])


@pytest.mark.parametrize(("log_end", "until"), [(1500.0, 1500.0), (9000.0, 1760.0)])
def test_since_auto_compares_as_far_as_the_twin_asks(monkeypatch, log_end, until):
    monkeypatch.setattr(what_changed, "_first_change", lambda *args: (CHANGE, ""))
    _, windows = find_since(SimpleNamespace(end=log_end), None, lambda what, share: None)
    assert windows.after == (1050.0, until)


def test_rig_that_was_not_learnt_is_not_saved(never_learnt, tmp_path):
    saved = tmp_path / "saved.yaml"
    with pytest.raises(InputError, match=f"--save-rig .*not written: {NEVER}"):
        run(never_learnt, "--save-rig", saved)
    assert not saved.exists()


def test_learning_ends_within_the_record_that_is_called_enough():
    slices = 1.0 + 1.0 / (learning._BLOCKS_A_SLICE - 1)  # of the blocks so far, and of those that come meanwhile
    assert learner._LONGEST_S * slices**learning._ROUNDS < ALWAYS_LEARNT_S


def test_record_too_short_for_a_twin_is_refused(make_log):
    for seconds in (0.5, 2.0):
        path = make_log(seconds, 10.0)
        for watched in (lambda path=path: run(path), lambda path=path: sd.watch(str(path))):
            with pytest.raises(InputError, match=r"_s\.mcap: shows \d\.\d s of the top drive; the twin needs 3 s"):
                watched()


@pytest.mark.parametrize(("rate", "noted"), [(2.0, True), (3.5, True), (4.0, False), (10.0, False)])
def test_drive_sampled_too_seldom_is_noted_once(make_log, rate, noted):
    path = make_log(12.0, rate)
    for options in ([], ["--json"]):
        printed = run(path, *options)
        said = f"the top drive is sampled at {rate:.2g} Hz"
        assert (printed.stdout + printed.stderr).count(said) == noted
    assert any(said in remark for remark in sd.watch(str(path)).remarks) == noted


def test_channel_that_comes_too_seldom_is_noted(make_log):
    assert "hook load is sampled at 0.5 Hz: it shows no change" in run(make_log(12.0, 10.0, hook_load_rate=0.5)).stderr


def test_twin_that_compared_says_nothing_of_it(rig):
    twin = Twin(rig, TwinSettings(learning=60.0))
    assert NEVER in twin.not_compared and not twin.learnt
    rng = np.random.default_rng(7)
    for second in range(200):
        time = second + np.arange(0.0, 1.0, 0.1)
        angle = 9.0 * np.sin(2.0 * np.pi * time / 20.0)
        twin.add("top_drive_angle", time, angle)
        twin.add("surface_torque", time, 300.0 * np.sign(np.cos(2.0 * np.pi * time / 20.0)) + rng.normal(0.0, 50.0, 10))
        twin.add("block_position", time, 0.005 * time)
        twin.advance()
    assert twin.learnt and twin.not_compared == ""


def test_rate_that_falls_later_is_said_once(make_log):
    log = read_log(make_log(250.0, 10.0))
    twin, said = Twin(log.rig()), []
    for second in np.arange(250.0):
        rows = np.flatnonzero((log.top_drive.time >= second) & (log.top_drive.time < second + 1.0))
        rows = rows if second < 30.0 else rows[:1]
        for channel, array in (("top_drive_angle", "position"), ("surface_torque", "effort")):
            twin.add(channel, log.top_drive.time[rows], getattr(log.top_drive, array)[rows])
        twin.advance()
        said.append(sum("the top drive is sampled at 1 Hz" in remark for remark in twin.remarks))
    assert said[60] == 0 and said[130] == said[-1] == 1
