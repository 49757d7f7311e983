"""When a detection says that it was made."""

import numpy as np
import pytest

from slider_drilling.rig import load_rig
from slider_drilling.twin import Twin, TwinSettings
from slider_drilling.twin.change_statistic import FeatureChange
from slider_drilling.twin.detector import Alarm, ChangeDetector


@pytest.mark.parametrize("age", [0.0, 1.0, 4.0])
def test_detected_is_the_second_that_first_shows_it(request, monkeypatch, age):
    rig = load_rig(request.config.rootpath / "config" / "rig.short.yaml")
    twin = Twin(rig, TwinSettings(learning=60.0, forecast=0.0))

    def alarm(detector, key, complete=False):
        at = twin._seconds - 0.1 - age  # of the last value, some seconds before it is tested
        change = FeatureChange(50.0, at - 20.0, (at - 25.0, at - 15.0), "step", 4.0, "sudden")
        return Alarm(at, *key[1:], change)

    monkeypatch.setattr(ChangeDetector, "test", alarm)
    for second in range(220):
        time = second + np.arange(0.0, 1.0, 0.1)
        twin.add("top_drive_angle", time, 9.0 * np.sin(2.0 * np.pi * time / 20.0))
        twin.add("surface_torque", time, 300.0 * np.sign(np.cos(2.0 * np.pi * time / 20.0)))
        twin.add("block_position", time, 0.005 * time)
        for report in twin.advance():
            if report.detections:
                assert report.detections[0].detected == report.time
                return
    raise AssertionError("no detection")
