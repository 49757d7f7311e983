import json

import numpy as np
import pytest
from click.testing import CliRunner

from slider_drilling.commands import watch_sources
from slider_drilling.commands.watch import _WITH_CAMPAIGN, _WITH_SOURCE, command
from slider_drilling.errors import InputError
from slider_drilling.log import read_log
from slider_drilling.log.follow_recording import RecordingFollower
from slider_drilling.log.write import LogWriter
from slider_drilling.rig import dump_rig, load_rig
from slider_drilling.twin.feed import LogFeed, RecordingFeed
from slider_drilling.twin.wits_feed import WitsFeed

FIELDS = ["t", "gap", "threshold", "detections"]
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


def test_recording_that_breaks_off_says_so(tmp_path, rig):
    path, cut, said = tmp_path / "run.mcap", tmp_path / "cut.mcap", []
    with LogWriter(path, rig_text=dump_rig(rig), recorded_by="test") as writer:
        _write(writer, 0.0, 5.0)
        writer.flush()
        cut.write_bytes(path.read_bytes())
    for each in (path, cut):
        feed = RecordingFeed(RecordingFollower(each), patient=False, note=said.append)
        while not feed.ended:
            feed.poll()
    assert len(said) == 1 and said[0].startswith(f"{cut}: breaks off: the program that wrote it has ended")


def test_what_a_log_has_lost_is_said(shared_data, tmp_path, capfd):
    path = tmp_path / "cut.mcap"
    path.write_bytes((shared_data / "logs" / "nominal_short.mcap").read_bytes()[:300_000])
    with watch_sources.open_feed(str(path), None, None, None, False, ""):
        assert "breaks off at byte" in capfd.readouterr().err


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


def _other(second, items, clock=True):
    """A record of another kind, sent now and then."""
    kind = next(iter(items))[:2]
    stamp = f"{kind}05261127\r\n{kind}0612{second // 60:02d}{second % 60:02d}\r\n" if clock else ""
    return "&&\r\n" + stamp + "".join(f"{item}{value}\r\n" for item, value in items.items()) + "!!\r\n"


def _drives(second):
    return _record(second, 5.0, -30.0).replace("071735.0\r\n", "")


@pytest.mark.parametrize("other", [_other(8, {"0830": 1.5}), _other(8, {"0717": 35.0}, clock=False),
                                   "&&\r\n0105261127\r\n010699:99\r\n01185.0\r\n!!\r\n"])  # fmt: skip
def test_wits_record_that_tells_nothing_does_not_end_the_watch(rig, other):
    """Such a record comes by itself: a twin reads a stream record by record."""
    first, later = "".join(map(_drives, range(8))), "".join(map(_drives, range(9, 12)))
    feed = _wits(rig, [first.encode(), other.encode(), later.encode()])
    pieces = [piece for _ in range(4) for piece in feed.poll()]
    assert np.concatenate([piece["top_drive_speed"][0] for piece in pieces]).size == 11


def test_wits_records_of_other_kinds_may_come_first(rig):
    text = "".join(_other(s, {"0830": 1.5}) for s in range(6)) + "".join(map(_drives, range(6, 14)))
    feed = _wits(rig, [text.encode()])
    assert sum(piece["top_drive_speed"][0].size for piece in feed.poll() if "top_drive_speed" in piece) == 8


def test_wits_item_that_comes_later_is_taken(rig):
    """A survey record with the toolface comes some times a minute."""
    said = []
    first, later = "".join(map(_drives, range(8))), "".join(map(_drives, range(9, 12)))
    tool_face = _other(8, {"0717": 35.0}) + _other(20, {"0717": 36.0})
    feed = _wits(rig, [first.encode(), tool_face.encode(), later.encode()], note=said.append)
    pieces = [piece for _ in range(4) for piece in feed.poll()]
    measured = np.concatenate([piece["tool_face"][1] for piece in pieces if "tool_face" in piece])
    assert measured == pytest.approx(np.radians([35.0, 36.0]))
    block = np.concatenate([piece["block_position"][1] for piece in pieces if "block_position" in piece])
    assert block[-1] == pytest.approx(0.3048 * 0.11) and len(said) == 1


def test_wits_without_a_usable_record_is_refused(rig):
    feed = _wits(rig, ["".join(_other(s % 60, {"0830": 1.5}) for s in range(200)).encode()])
    with pytest.raises(InputError, match="holds none of the items"):
        feed.poll()


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


def test_empty_folder_is_waited_for(tmp_path, rig, monkeypatch, capfd):
    """The first file appears while it waits, and its samples a while after that."""
    waited, path = [], tmp_path / "run.mcap"

    def sleep(seconds):
        waited.append(seconds)
        if len(waited) == 3:
            path.write_bytes(b"")
        if len(waited) == 6:
            whole = tmp_path / "whole.part"
            with LogWriter(whole, rig_text=dump_rig(rig), recorded_by="test") as writer:
                _write(writer, 0.0, 5.0)
            path.write_bytes(whole.read_bytes())

    monkeypatch.setattr(watch_sources.time, "sleep", sleep)
    with watch_sources.open_feed(str(tmp_path), None, None, None, True, "") as (feed, found, replayed):
        assert found == rig and not replayed
        assert len(feed.poll()[0]["top_drive_angle"][0]) == 50
    assert capfd.readouterr().err.count("holds no log yet: waiting for the first one; Ctrl-C ends it") == 1


def test_empty_folder_without_follow_is_refused(tmp_path):
    with pytest.raises(InputError, match="holds no logs"):
        CliRunner().invoke(command, [str(tmp_path)], catch_exceptions=False)


_OF_CAMPAIGN = [["--begins", "washout"], ["--duration", "1000"], ["--seed", "2"], ["-o", "out"], ["--jobs", "2"],
                ["--scheduler", "tcp://host:1"]]  # fmt: skip
_OF_RECORDING = [["--follow"], ["--namespace", "rig"], ["--topics", "topics.yaml"]]
_OF_SOURCE = [*_OF_RECORDING, ["--save-rig", "saved.yaml"], ["--wits-units", "field"], ["--units", "field"]]
_IGNORED = [
    *((["run.mcap"], each, "without --campaign") for each in _OF_CAMPAIGN),
    *((["--campaign", "2"], each, "with --campaign") for each in _OF_SOURCE),
    *((["-", "--rig", "rig.yaml"], each, "with a stream of WITS") for each in _OF_RECORDING),
]  # fmt: skip


@pytest.mark.parametrize(("source", "option", "kind"), _IGNORED)
def test_option_that_would_be_ignored_is_refused(source, option, kind):
    with pytest.raises(InputError, match=f"{option[0].lstrip('-')[0]}.*: has no meaning {kind}; leave it out"):
        CliRunner().invoke(command, [*source, *option], catch_exceptions=False)


@pytest.mark.parametrize("option", [["--duration", "-1"], ["--duration", "nan"], ["--campaign", "-1"], ["--seed", "-1"],
                                    ["--jobs", "-1"]])  # fmt: skip
def test_number_that_cannot_be_is_refused(option, tmp_path):
    campaign = [] if option[0] == "--campaign" else ["--campaign", "2"]
    arguments = [*campaign, *option, "-o", str(tmp_path / "out")]
    result = CliRunner().invoke(command, arguments)
    assert result.exit_code == 2 or isinstance(result.exception, InputError)
    assert not (tmp_path / "out").exists()


def test_every_option_is_for_a_kind_of_run_or_for_all():
    """A new option must be put into one of the lists."""
    for_all = {"source", "rig_path", "diagnose", "campaign", "as_json"}
    assert {each.name for each in command.params} == {*_WITH_CAMPAIGN, *_WITH_SOURCE, *for_all}
