import numpy as np
import pytest
from short_well import short_rig

from slider_drilling.twin.agreement import Began, DiagnosedChange
from slider_drilling.twin.ask import windows_of_change
from slider_drilling.twin.change_statistic import FeatureChange
from slider_drilling.twin.detections import DetectionLog
from slider_drilling.twin.detector import Alarm
from slider_drilling.twin.diagnoser import Diagnoser
from slider_drilling.twin.samples import SampleBuffer


def test_baseline_ends_ten_seconds_before_a_step():
    windows = windows_of_change((1000.0, 1010.0), 1020.0, 0.0, 1200.0)
    assert windows.before == (390.0, 990.0) and windows.after == (1010.0, 1200.0)


def test_late_sight_moves_the_baseline_back():
    windows = windows_of_change((1000.0, 1150.0), 1300.0, 0.0, 1400.0)
    assert windows.before[1] == pytest.approx(1000.0 - 0.4 * 300.0)


@pytest.mark.parametrize(("low", "started", "end"), [(661.0, 0.0, 300.0), (250.0, 0.0, 240.0), (900.0, 700.0, 890.0)])
def test_late_sight_leaves_five_minutes_of_baseline(low, started, end):
    assert windows_of_change((low, 1181.0), 2031.0, started, 2100.0).before == (started, end)


def test_samples_since_are_forty_seconds_at_least():
    assert windows_of_change((1000.0, 1150.0), 1160.0, 0.0, 1170.0).after == (1130.0, 1170.0)


@pytest.mark.parametrize(("began", "end"), [(2000.0, 880.0), (800.0, 790.0), (100.0, 300.0)])
def test_samples_from_before_end_before_a_ramp_began(began, end):
    windows = windows_of_change((1000.0, 1150.0), 1300.0, 0.0, 1400.0, began)
    assert windows.before == (max(end - 600.0, 0.0), end) and windows.after == (1150.0, 1400.0)


@pytest.mark.parametrize(("kind", "before", "after"), [("ramp", 790.0, 1150.0), ("step", 600.0, 950.0)])
def test_all_of_a_ramp_is_there_where_features_see_it(kind, before, after):
    log = DetectionLog()
    seen = FeatureChange(30.0, 1100.0, (1000.0, 1150.0), "ramp", 5.0, in_operation=False)
    log.take(Alarm(1300.0, "standpipe_pressure", "mean", seen))
    log.take_diagnosis(1, DiagnosedChange("effect", ("washout",), began=Began(900.0, (800.0, 950.0), kind)), 1360.0)
    buffers = {"top_drive_angle": SampleBuffer(5000.0)}
    buffers["top_drive_angle"].add(np.array([0.0, 1.0]), np.zeros(2))
    windows = Diagnoser(None, short_rig(), buffers, log)._windows(log.detections[0], 1400.0)
    assert (windows.before[1], windows.after[0]) == (before, after)
