"""Stamps of what comes beside a rig."""

from types import SimpleNamespace

import numpy as np
import pytest

from slider_drilling.errors import InputError
from slider_drilling.log.follow_recording import RecordingFollower
from slider_drilling.log.write import LogWriter
from slider_drilling.rig import dump_rig, load_rig
from slider_drilling.twin.checked_feed import CheckedFeed
from slider_drilling.twin.feed import RecordingFeed
from slider_drilling.twin.wits_feed import WitsFeed


class _Pieces:
    def __init__(self, stamps):
        self._stamps, self.ended = [np.atleast_1d(np.array(each, dtype=float)) for each in stamps], False

    def poll(self):
        stamps = self._stamps.pop(0)
        self.ended = not self._stamps
        return [{"top_drive_angle": (stamps, 10.0 * stamps), "hook_load": (stamps, 20.0 * stamps)}]


def taken(*stamps):
    """The stamps that are passed on, and what is said."""
    notes, found = [], []
    feed = CheckedFeed(_Pieces(stamps), "rig", notes.append)
    while not feed.ended:
        for piece in feed.poll():
            for factor, (times, values) in zip((10.0, 20.0), piece.values(), strict=True):
                assert np.array_equal(values, factor * times)
            assert np.array_equal(piece["top_drive_angle"][0], piece["hook_load"][0])
            found += piece["top_drive_angle"][0].tolist()
    return found, notes


def test_a_single_stamp_far_ahead_is_left_out_and_said():
    found, notes = taken(0.0, 1.0, 86402.0, 3.0, 4.0)
    assert found == [0.0, 1.0, 3.0, 4.0]
    assert notes == ["rig: a sample stamped 86401 s after those before it is left out"]


def test_so_is_one_among_others_of_a_piece():
    assert taken([0.0, 1.0], [2.0, 9e4, 3.0], [4.0])[0] == [0.0, 1.0, 2.0, 3.0, 4.0]


def test_a_pause_of_the_recording_is_no_wrong_stamp():
    assert taken(0.0, 1.0, 1002.0, 1003.0, 1004.0)[0] == [0.0, 1.0, 1003.0, 1004.0]
    assert taken([0.0, 1.0], [1002.0, 1003.0])[0] == [0.0, 1.0, 1002.0, 1003.0]


def test_what_comes_before_a_fault_is_passed_on_though_both_come_at_once():
    pieces = _Pieces([5000.0, 1400.0, 1401.0, 1402.0])
    at_once = SimpleNamespace(ended=True, poll=lambda: [pieces.poll()[0] for _ in range(4)])
    feed = CheckedFeed(at_once, "rig", print)
    assert [feed.poll()[0]["hook_load"][0].tolist() for _ in range(3)] == [[5000.0], [1400.0], [1401.0]]
    assert not feed.ended
    with pytest.raises(InputError, match="its clock was set back by 3598 s"):
        feed.poll()


def test_a_stream_of_wits_whose_clock_is_set_back_is_refused(request):
    """Two runs in one file, which arrive in one block."""
    run = "".join(f"&&\r\n0105261127\r\n01061200{k:02d}\r\n01185.0\r\n0120-30.0\r\n!!\r\n" for k in range(30))
    blocks = [(run + run).encode(), b""]
    rig = load_rig(request.config.rootpath / "config" / "rig.short.yaml")
    feed = CheckedFeed(WitsFeed(lambda: blocks.pop(0), "standard input", "metric", rig), "standard input", print)
    with pytest.raises(InputError, match="standard input: its clock was set back by"):
        while not feed.ended:
            feed.poll()


def test_late_stamps_are_passed_on():
    assert taken(0.0, 9.0, 8.0, 4.0, 10.0, 5.0, 11.0) == ([0.0, 9.0, 8.0, 4.0, 10.0, 5.0, 11.0], [])


def test_a_clock_that_was_set_back_is_refused():
    """Otherwise nothing would come of an hour of samples."""
    with pytest.raises(InputError, match=r"rig: its clock was set back by 3598 s at 5000 s; start the watch again"):
        taken(4999.0, 5000.0, 1400.0, 1401.0, 1402.0, 1403.0)


def test_growing_recording_with_a_wrong_stamp(tmp_path, request):
    path, rig = tmp_path / "run.mcap", load_rig(request.config.rootpath / "config" / "rig.short.yaml")
    with LogWriter(path, rig_text=dump_rig(rig), recorded_by="test") as writer:
        for time in np.arange(0.0, 5.0, 0.1).tolist():
            stamp = 1e6 if abs(time - 3.0) < 1e-6 else time
            writer.joint_state("top_drive/joint_states", stamp, "top_drive", 0.0, 0.0, 1000.0, log_time_s=time)
    (piece,) = CheckedFeed(RecordingFeed(RecordingFollower(path), patient=False), "rig", print).poll()
    assert piece["top_drive_angle"][0].size == 49 and piece["top_drive_angle"][0].max() < 5.0
