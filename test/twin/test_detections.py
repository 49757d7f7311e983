from slider_drilling.twin.change_statistic import FeatureChange
from slider_drilling.twin.detections import DetectionLog
from slider_drilling.twin.detector import Alarm


def _alarm(time, since, size=3.0, kind="step", channel="standpipe_pressure", evidence=20.0):
    interval = (since - 5.0, since + 5.0)
    return Alarm(time, channel, "mean", FeatureChange(evidence, since, interval, kind, size, "sudden"))


def test_other_channels_soon_after_are_one_change():
    log = DetectionLog()
    assert log.take(_alarm(100.0, 80.0))
    assert not log.take(_alarm(150.0, 85.0, channel="hook_load", evidence=15.0))
    assert len(log.detections) == 1 and log.detections[0].channel == "standpipe_pressure"


def test_stronger_evidence_moves_the_onset():
    log = DetectionLog()
    log.take(_alarm(100.0, 90.0))
    log.take(_alarm(140.0, 82.0, kind="ramp", evidence=40.0))
    found = log.detections[0]
    assert (found.detected, found.since, found.interval, found.kind) == (100.0, 82.0, (77.0, 87.0), "ramp")


def test_late_alarm_with_same_onset_is_no_new_change():
    log = DetectionLog()
    log.take(_alarm(100.0, 80.0))
    assert not log.take(_alarm(400.0, 95.0, channel="hook_load"))


def test_growing_ramp_is_one_change():
    log = DetectionLog()
    log.take(_alarm(100.0, 80.0, kind="ramp"))
    assert not log.take(_alarm(500.0, 420.0, kind="ramp"))
    assert len(log.detections) == 1


def test_change_that_goes_back_is_an_event():
    log = DetectionLog()
    log.take(_alarm(100.0, 80.0, size=4.0))
    assert not log.take(_alarm(300.0, 280.0, size=-3.5))
    assert log.detections[0].kind == "event" and log.detections[0].ended == 280.0


def test_later_change_of_another_channel_is_new():
    log = DetectionLog()
    log.take(_alarm(100.0, 80.0))
    assert log.take(_alarm(900.0, 850.0, channel="surface_torque"))
    assert [each.number for each in log.detections] == [1, 2]


def test_past_is_forgotten_when_a_change_is_refined():
    log = DetectionLog()
    log.take(_alarm(100.0, 80.0))
    assert log.settled_change(200.0) is None
    assert log.settled_change(400.0) == 80.0
