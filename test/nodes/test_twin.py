"""The node `twin` beside a rig: real processes, its log, its clock, its services, and its death."""

from __future__ import annotations

import json
import math
import signal
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import rclpy
from mcap.reader import make_reader
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions
from std_srvs.srv import Trigger
from turning import turn

from slider_drilling.errors import InputError
from slider_drilling.log import read_log
from slider_drilling.log.info import log_info
from slider_drilling.messages import cdr
from slider_drilling.messages.health import Level, Status
from slider_drilling.messages.topics import GAP_DIAGNOSIS, TOPICS, TWIN_TOPICS
from slider_drilling.nodes.log_player import LogPlayer
from slider_drilling.nodes.shutdown import ShutdownRequest
from slider_drilling.nodes.twin import CHANNELS, TwinNode
from slider_drilling.nodes.twin_status_relay import NOT_COMPARED
from slider_drilling.nodes.watchdog import Watchdog
from slider_drilling.rig import dump_rig, parse_rig
from slider_drilling.twin import Detection, Twin

OK = 0


@pytest.mark.slow
def test_log_holds_what_twin_says_and_controller_outlives_it(start, listener, tmp_path: Path):
    """Simulator, controller, twin and recorder; then kill -9 of the twin."""
    folder = tmp_path / "out"
    recorder = start("recorder", directory=folder, use_sim_time=True)
    twin = start("twin", use_sim_time=True)
    start("rocking_controller", use_sim_time=True)
    start("friction_simulator", elements=20, wait_for_controller=True, speed=5.0, minimum_subscribers=4)
    listener.until_status("twin: measurements", OK, "every channel is there")
    listener.until_status("twin: hydraulics", OK, "not compared yet")
    listener.until_status("rocking_controller: twin", OK, "learns the rig")
    assert listener.call(Trigger, "twin/recalibrate").success
    # A busy machine may connect a topic seconds after the others.
    log = next(folder.glob("*.mcap"))
    needed = {one.name for one in TWIN_TOPICS} | {one.name for one in TOPICS.values() if one.is_measured}
    listener.until(lambda: needed <= topics_of(log), "what is measured and what the twin says is recorded")
    twin.kill()
    gone = listener.time
    listener.statuses.pop("rocking_controller: twin")
    listener.until_status("rocking_controller: twin", OK, "silent since")
    listener.until(lambda: listener.latest("top_drive_command")[0] > gone + 5.0, "commands go on")
    listener.until_status("rocking_controller: measurements", OK, "every surface channel")
    recorder.process.send_signal(signal.SIGINT)
    assert recorder.end() == 0, recorder.output
    check_log(log)


def topics_of(path: Path) -> set[str]:
    """Names of the topics in a log that is being written, without the namespace."""
    return {one.topic.strip("/").partition("/")[2] for one in log_info(path).topics if one.messages}


def check_log(path: Path) -> None:
    """The twin's topics are in the log, beside the measurements and on their clock."""
    log = read_log(path)
    for key, sensor in (("expected_top_drive", log.top_drive), ("expected_draw_works", log.draw_works)):
        series = log.series()[key]
        assert len(series.time) > 20 and np.isfinite(series.effort).all() and np.isnan(series.position).all()
        assert np.isin(np.round(series.time, 3), np.round(sensor.time, 3)).all(), "stamped as the samples"
    expected, pressure = log.expected_standpipe_pressure, log.standpipe_pressure
    measured = np.interp(expected.time, pressure.time, pressure.value)
    assert np.median(np.abs(expected.value - measured)) < 5e5
    assert (np.abs(log.expected_mwd_tool_face.position) <= math.pi).all()
    assert topics_of(path) > {one.name for one in TWIN_TOPICS}
    with path.open("rb") as file:
        topics = {channel.topic.rpartition("/rig_")[2].partition("/")[2]: message.data
                  for _, channel, message in make_reader(file).iter_messages()}  # fmt: skip
    tree = json.loads(cdr.decode_string(topics[GAP_DIAGNOSIS.name]))
    assert tree["schema"] == "slider_drilling/gap_diagnosis/1" and tree["detections"] == []


@pytest.fixture
def heard() -> list[dict[str, Status]]:
    """What the twin published in `diagnostics`, by subject."""
    return []


@pytest.fixture
def make_twin(alone, monkeypatch, heard):
    """Makes a twin's node in this process."""
    rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
    made: list[TwinNode] = []

    def make(**parameters: object) -> TwinNode:
        overrides = [Parameter(name, value=value) for name, value in parameters.items()]
        node = TwinNode(ShutdownRequest(), parameter_overrides=overrides)
        monkeypatch.setattr(
            node._diagnostics, "publish", lambda stamp_ns, rows: heard.append({one.name: one for one in rows})
        )
        made.append(node)
        return node

    yield make
    for node in made:
        node.destroy_node()
    rclpy.try_shutdown()


def feed(node: TwinNode, first: float, seconds: float) -> None:
    """Samples at 10 Hz of a rig that stands on bottom; time s of the rig's clock."""
    numbers = {
        "mud_pump": (math.nan, 12.0, math.nan),
        "draw_works": (0.0, 0.0, 4e5),
        "standpipe_pressure": (1.8e7, 0.0),
        "top_drive": (0.0, 0.0, 0.0),
    }
    for k in range(round(10 * seconds)):
        for key, values in numbers.items():
            node._take(key, CHANNELS[key], round((first + 0.1 * k) * 1e9), *values)
    node._advance()


def test_twin_reports_on_the_rigs_clock(make_twin, heard):
    node = make_twin()
    feed(node, 1.7e9, 8.0)
    assert node.twin.report.time == pytest.approx(7.9), "s since its start"
    sites = {"contact", "string", "top_drive", "draw_works", "motor", "bit", "hydraulics", "sensor"}
    assert set(heard[-1]) == {"measurements", "state"} | sites
    assert all(heard[-1][site].message == NOT_COMPARED for site in sites)
    assert heard[-1]["state"].message.startswith("learning")


def test_replayed_log_is_followed(make, shared_data, tmp_path: Path):
    path = shared_data / "logs" / "nominal_short.mcap"
    rig = tmp_path / "rig.yaml"
    rig.write_text(dump_rig(read_log(path).rig()))
    twin = make(TwinNode, rig=str(rig), use_sim_time=True, forecast=0.0)
    player = make(LogPlayer, log=str(path), rate=10.0, delay=0.3)
    turn([player, twin], lambda: twin.twin.report is not None and twin.twin.report.time > 15.0)
    report = twin.twin.report
    assert report.channels["surface_torque"].gap_10 < 0.5
    assert report.channels["standpipe_pressure"].gap_10 < 0.5


def test_clock_that_is_set_starts_the_twin_anew(make_twin, heard, capfd):
    node = make_twin()
    feed(node, 1000.0, 6.0)
    node._take("top_drive", CHANNELS["top_drive"], 10**18, 0.0, 0.0, 0.0)
    feed(node, 1006.0, 2.0)
    assert node._restarts == 0, "one wrong stamp is dropped"
    feed(node, 500.0, 4.0)
    feed(node, 9000.0, 4.0)
    said = capfd.readouterr().err
    assert "went from 1007.9 to 500.0 s: the twin starts anew" in said
    assert "went from 503.9 to 9000.1 s: the twin starts anew" in said
    assert dict(heard[-1]["state"].values)["restarts"] == "2"
    assert heard[-1]["measurements"].level is Level.WARN, "these stamps are of another clock than the node's"


def test_silent_rig_is_reported(make_twin, heard, monkeypatch):
    node = make_twin()
    feed(node, 1000.0, 6.0)
    monkeypatch.setattr(node._watchdog, "silent_for", lambda stale_after: 7.0)
    monkeypatch.setattr(node._watchdog, "tick", lambda: False)
    node._advance()
    assert heard[-1]["measurements"] == Status(Level.ERROR, "measurements", "the rig is silent since 7 s")
    count = len(heard)
    node._advance()
    assert len(heard) == count, "once a second of silence"


def test_rig_is_not_silent_while_the_twin_works(make_twin, heard, monkeypatch):
    node, clock = make_twin(), [0.0]
    feed(node, 1000.0, 6.0)
    node._watchdog = Watchdog(lambda: clock[0])
    node._watchdog.note_sample()
    monkeypatch.setattr(node.twin, "advance", lambda: clock.insert(0, 40.0) or [])
    count = len(heard)
    node._advance()
    assert len(heard) == count


def test_inactive_twin_takes_no_sample(make_twin):
    node = make_twin()
    node.trigger_deactivate()
    feed(node, 1000.0, 6.0)
    assert node.twin.report is None
    node.trigger_cleanup()
    assert node.twin is None
    node.trigger_configure()
    node.trigger_activate()
    feed(node, 1000.0, 6.0)
    assert node.twin.report is not None


def test_drives_of_one_topic_are_told_apart(make_twin):
    node = make_twin(joint_states="joint_states", top_drive_joint="quill")
    (drives,) = [one for one in node._sensors if one.name == "joint_states"]
    names, numbers = ("block", "quill", "mud_pump"), ((7.0, 3.0, math.nan), (0.1, 0.2, 12.0))
    drives._receive(cdr.encode_joint_states(10**9, names, *numbers))
    drives._receive(cdr.encode_joint_states(2 * 10**9, names, *numbers))
    waiting = {channel: values[-1] for channel, (_, values) in node._waiting.items()}
    assert waiting == {"top_drive_angle": 3.0, "top_drive_speed": 0.2, "block_position": 7.0, "block_speed": 0.1,
                       "pump_speed": 12.0}  # fmt: skip


def test_diagnosis_is_published_when_it_changes(make_twin, heard, monkeypatch):
    node = make_twin()
    feed(node, 1000.0, 6.0)
    words: list[dict[str, object]] = []
    monkeypatch.setattr(node._topics._diagnosis, "publish", lambda message: words.append(json.loads(message.data)))
    change = Detection(1, 4.0, 2.0, (1.0, 3.0), "hook_load", "sensor", "step", 2.0, "hook load 8 kN higher")
    for detections in ((), (change,), (change,), (replace(change, effects=("heave",), answered=5.0),)):
        node._publish(replace(node.twin.report, detections=detections))
    assert [[one["effects"] for one in word["detections"]] for word in words] == [[[]], [["heave"]]]
    assert words[0]["detections"][0]["since"] == 1002.0, "s of the rig's clock"
    node._report(0.0)
    assert heard[-1]["sensor"].level is Level.OK, "statuses are those of the twin's own report"


def test_answer_that_comes_while_the_rig_is_silent_is_published(make_twin, monkeypatch):
    node = make_twin()
    feed(node, 1000.0, 6.0)
    words: list[dict[str, object]] = []
    monkeypatch.setattr(node._topics._diagnosis, "publish", lambda message: words.append(json.loads(message.data)))
    change = Detection(1, 4.0, 2.0, (1.0, 3.0), "hook_load", "sensor", "step", 2.0, "", effects=("heave",))
    monkeypatch.setattr(Twin, "detections", (change,))
    for _ in range(2):
        node._advance()
    assert [[one["effects"] for one in word["detections"]] for word in words] == [[["heave"]]]


def test_calibrated_rig_is_written_whole_or_not(make_twin, tmp_path: Path, repository: Path, monkeypatch):
    given = tmp_path / "rig.yaml"
    text = (repository / "config" / "rig.example.yaml").read_text()
    given.write_text(text)
    saved = tmp_path / "saved.yaml"
    node = make_twin(rig=str(given), calibrated_rig=str(saved))
    for act in (node._save_rig, node._recalibrate, node._diagnose):
        with pytest.raises(InputError, match="the twin has no sample of the rig yet"):
            act()
    feed(node, 1000.0, 6.0)
    monkeypatch.setattr(Twin, "learnt", True)
    assert node._save_rig() == f"wrote {saved}"
    assert parse_rig(saved.read_text(), str(saved)).string.length == 4000.0
    assert node._recalibrate() == "learns the rig anew"
    same = make_twin(rig=str(given), calibrated_rig=str(given))
    feed(same, 1000.0, 6.0)
    with pytest.raises(InputError, match=r"rig\.yaml"):
        same._save_rig()
    assert given.read_text() == text


def called(node: TwinNode, name: str) -> Trigger.Response:
    """The response of a service of the node."""
    offered = {service.srv_name.rpartition("/")[2]: service for service in node.services}
    return offered[name].callback(Trigger.Request(), Trigger.Response())


def test_rig_that_is_not_learnt_is_not_saved(make_twin, tmp_path: Path):
    saved = tmp_path / "saved.yaml"
    node = make_twin(calibrated_rig=str(saved), learning=60.0)
    for seconds in (6.0, 40.0):
        feed(node, 1000.0, seconds)
        response = called(node, "save_rig")
        assert not response.success and "not written: the twin still learns the rig" in response.message
        assert not saved.exists()


def test_diagnosis_asked_too_early_is_refused(make_twin, heard):
    node = make_twin()
    for begin in range(1000, 1300, 100):
        feed(node, float(begin), 100.0)
        with pytest.raises(InputError, match=r"too early for a diagnosis: it needs 150 s .* before the change"):
            node._diagnose()
        assert not node.twin.asking and node.twin.failure == ""
    node._report(0.0)
    assert "no diagnosis" not in heard[-1]["state"].message


def test_late_sample_of_the_drive_starts_nothing_anew(make_twin):
    node = make_twin()
    feed(node, 1000.0, 6.0)
    for late in (0.5, 1.5, 1.9):
        node._take("top_drive", CHANNELS["top_drive"], round((1005.9 - late) * 1e9) + 1, 0.0, 0.0, 0.0)
    assert node._restarts == 0


def test_values_that_no_rig_has_are_warned_of_once(make_twin, capfd):
    node = make_twin(forecast=0.0)
    for second in range(70):
        for k in range(10):
            at = round((1000.0 + second + 0.1 * k) * 1e9)
            node._take("draw_works", CHANNELS["draw_works"], at, 0.0, 0.0, 400.0)
            node._take("top_drive", CHANNELS["top_drive"], at, 0.0, 0.0, 0.0)
        node._advance()
    assert capfd.readouterr().err.count("hook_load starts at") == 1


def test_impossible_samples_do_not_end_the_node(make_twin, heard, monkeypatch, capfd):
    node = make_twin()
    feed(node, 1000.0, 6.0)

    def refuse() -> list[object]:
        raise InputError("the drives moved backwards in time")

    monkeypatch.setattr(node.twin, "advance", refuse)
    node._advance()
    assert "the drives moved backwards in time: the twin starts anew" in capfd.readouterr().err
    feed(node, 1006.0, 6.0)
    assert "started anew: the drives moved backwards in time" in heard[-1]["state"].message
    assert node.shutdown_request.error is None
