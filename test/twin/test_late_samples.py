"""Samples that are late by as much as the twin waits are taken, wherever they come from."""

import datetime

import numpy as np
import pytest

from slider_drilling.errors import InputError
from slider_drilling.log import read_log
from slider_drilling.log.follow_recording import RecordingFollower
from slider_drilling.log.timestamps import MAX_STEP_BACK, SECOND
from slider_drilling.log.write import LogWriter
from slider_drilling.rig import dump_rig, load_rig
from slider_drilling.twin import TwinSettings
from slider_drilling.twin.feed import LogFeed, RecordingFeed
from slider_drilling.twin.wits_feed import WitsFeed

LATE_S = TwinSettings().patience
_TIMES = np.arange(0.0, 30.0, 0.1)


@pytest.fixture
def rig(request):
    return load_rig(request.config.rootpath / "config" / "rig.short.yaml")


@pytest.fixture
def make_log(tmp_path, rig):
    """Writes a log in which one sample of the top drive in forty comes so many s late."""

    def make(late):
        path = tmp_path / f"{late:g}.mcap"
        arrival = [(time + (late if k % 40 == 39 else 0.0), time) for k, time in enumerate(_TIMES.tolist())]
        with LogWriter(path, rig_text=dump_rig(rig), recorded_by="test") as writer:
            for at, time in sorted(arrival):
                angle = float(np.sin(0.3 * time))
                writer.joint_state("top_drive/joint_states", time, "top_drive", angle, 0.3, 900.0, log_time_s=at)
        return path

    return make


def _times(feed):
    pieces = []
    while not feed.ended:
        pieces += [samples["top_drive_angle"][0] for samples in feed.poll() if "top_drive_angle" in samples]
    return np.sort(np.concatenate(pieces))


def test_as_much_as_the_twin_waits():
    assert MAX_STEP_BACK / SECOND == LATE_S


@pytest.mark.parametrize("late", [0.5, 1.2, 1.9, 2.0])
def test_late_samples_of_a_log_are_kept(make_log, late):
    path = make_log(late)
    assert _times(LogFeed(read_log(path))) == pytest.approx(_TIMES, abs=1e-6)
    assert _times(RecordingFeed(RecordingFollower(path), patient=False)) == pytest.approx(_TIMES, abs=1e-6)


def test_log_whose_stamps_step_back_further_is_refused(make_log):
    with pytest.raises(InputError, match="two runs in one log"):
        read_log(_two_runs(make_log))


def _two_runs(make_log):
    path = make_log(0.0)
    two = path.with_name("two.mcap")
    with LogWriter(two, recorded_by="test") as writer:
        for run in range(2):
            for time in np.arange(0.0, 8.0, 0.1).tolist():
                logged = time + 13.0 * run
                writer.joint_state("top_drive/joint_states", time, "top_drive", time, 1.0, 900.0, log_time_s=logged)
    return two


def test_late_records_of_wits_are_kept(rig):
    def record(second):
        clock = (datetime.datetime(2026, 11, 27, 12) + datetime.timedelta(seconds=second)).strftime("%H%M%S")
        return f"&&\r\n0105261127\r\n0106{clock}\r\n01185.0\r\n0120-30.0\r\n01142600\r\n!!\r\n"

    order = [0, 1, 2, 3, 6, 7, 5, 4, 8, 9, 10]
    text = "".join(record(second) for second in order).encode()
    blocks = [text, b""]
    feed = WitsFeed(lambda: blocks.pop(0), "standard input", "field", rig)
    times = np.concatenate([piece["top_drive_speed"][0] for _ in range(2) for piece in feed.poll()])
    assert np.sort(times) == pytest.approx(np.arange(11.0))
