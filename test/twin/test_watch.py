import json

import numpy as np
import pytest
from click.testing import CliRunner

from slider_drilling.commands.watch import command
from slider_drilling.errors import InputError
from slider_drilling.log import read_log
from slider_drilling.log.follow_recording import RecordingFollower
from slider_drilling.log.write import LogWriter
from slider_drilling.rig import dump_rig, load_rig
from slider_drilling.twin.feed import LogFeed, RecordingFeed
from slider_drilling.twin.wits_feed import WitsFeed

FIELDS = ["t", "gap", "threshold", "detections", "compared"]
DETECTION_FIELDS = ["detected", "since", "interval", "site", "effects", "suspected", "verdict", "answered"]


@pytest.fixture(scope="module")
def rig(request):
    return load_rig(request.config.rootpath / "config" / "rig.short.yaml")


def test_json_has_a_line_a_second(shared_data):
    log = shared_data / "logs" / "nominal_short.mcap"
    result = CliRunner().invoke(command, [str(log), "--json", "--no-diagnose"], catch_exceptions=False)
    lines = [json.loads(line) for line in result.stdout.splitlines()]
    assert all(list(line) == FIELDS for line in lines)
    assert np.allclose(np.diff([line["t"] for line in lines]), 1.0)
    assert lines[-1]["gap"]["surface_torque"] < 0.5
    assert lines[-1]["detections"] == []


def test_samples_of_a_log_come_as_they_arrived(shared_data):
    log = read_log(shared_data / "logs" / "nominal_short.mcap")
    feed, second, times = LogFeed(log), 0, []
    while not feed.ended:
        for samples in feed.poll():
            second += 1
            if "tool_face" in samples:
                times.append((second, float(samples["tool_face"][0][0])))
    latency = log.rig().sensors.mwd.latency
    assert times and all(arrived >= measured + latency - 1.0 for arrived, measured in times)


def _write(writer, begin, end):
    for time in np.arange(begin, end, 0.1):
        writer.joint_state("top_drive/joint_states", float(time), "top_drive", float(np.sin(time)), 0.0, 1000.0)


def test_growing_recording_is_followed_to_its_end(tmp_path, rig):
    path = tmp_path / "run.mcap"
    with LogWriter(path, rig_text=dump_rig(rig), recorded_by="test") as writer:
        _write(writer, 0.0, 5.0)
        writer.flush()
        feed = RecordingFeed(RecordingFollower(path), patient=False)
        first = feed.poll()
        assert not feed.ended
        assert len(first[0]["top_drive_angle"][0]) == 50
        assert feed.rig() == rig
        _write(writer, 5.0, 8.0)
        writer.flush()
        second = feed.poll()
        assert second[0]["top_drive_angle"][0] == pytest.approx(np.arange(5.0, 8.0, 0.1), abs=1e-6)
    rest = [feed.poll() for _ in range(3)]
    assert feed.ended and not any(rest)


def _record(second, torque, rpm):
    items = {"0105": "261127", "0106": f"12{second // 60:02d}{second % 60:02d}", "0118": torque, "0120": rpm,
             "0114": 120.0, "0121": 2600.0, "0112": 80.0 - 0.01 * second, "0123": 60, "0717": 35.0}  # fmt: skip
    return "&&\r\n" + "".join(f"{item}{value}\r\n" for item, value in items.items()) + "!!\r\n"


def _wits(rig, blocks, units="field", note=lambda text: None):
    remaining = [*blocks, b""]
    return WitsFeed(lambda: remaining.pop(0), "standard input", units, rig, note)


def test_wits_records_become_si_samples(rig):
    text = "".join(_record(second, 5.0, -30.0) for second in range(8)).encode()
    feed = _wits(rig, [text[:300], text[300:700], text[700:]])
    samples = [piece for _ in range(4) for piece in feed.poll()]
    torque = np.concatenate([piece["surface_torque"][1] for piece in samples])
    block = np.concatenate([piece["block_position"][1] for piece in samples])
    assert feed.ended
    assert torque == pytest.approx(np.full(8, 5.0e3 * 1.3558179), rel=1e-4)
    assert block == pytest.approx(0.3048 * 0.01 * np.arange(8), abs=1e-9)
    assert samples[0]["top_drive_speed"][1][0] == pytest.approx(-np.pi)
    assert sum(piece["tool_face"][0].size for piece in samples) == 1


def test_what_was_taken_for_granted_of_wits_is_said(rig):
    said = []
    feed = _wits(rig, ["".join(_record(second, 5.0, -30.0) for second in range(8)).encode()], note=said.append)
    feed.poll()
    assert said == ["block heights are taken to count up from the floor: sign -1, from the first row"]


def test_wits_without_units_is_refused(rig):
    feed = _wits(rig, ["".join(_record(s, 5.0, 30.0) for s in range(8)).encode()], units="")
    with pytest.raises(InputError, match="WITS does not tell the units"):
        feed.poll()


def test_wits_that_rocks_without_sign_is_refused(rig):
    rows = [_record(s, round(8.0 * np.sin(2 * np.pi * s / 20.0), 3), abs(round(40.0 * np.cos(2 * np.pi * s / 20.0), 2)))
            for s in range(150)]  # fmt: skip
    feed = _wits(rig, ["".join(rows).encode()])
    with pytest.raises(InputError, match="RPMA rocks without a sign"):
        feed.poll()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["-"], "WITS holds no rig file; give --rig"),
        (["missing.mcap"], "missing.mcap"),
        (["missing.mcap", "--wits-units", "field"], "is no stream of WITS"),
    ],
)
def test_bad_source_is_refused_in_one_line(arguments, message):
    with pytest.raises(InputError, match=message):
        CliRunner().invoke(command, arguments, catch_exceptions=False)
