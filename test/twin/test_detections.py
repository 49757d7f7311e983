import numpy as np
import pytest

from slider_drilling.twin.agreement import Began, DiagnosedChange
from slider_drilling.twin.change_statistic import FeatureChange
from slider_drilling.twin.detections import DetectionLog
from slider_drilling.twin.detector import Alarm
from slider_drilling.twin.regular_checks import ConfirmedChange


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


@pytest.mark.parametrize(("channel", "kind", "new"), [
    ("hook_load", "ramp", False), ("hook_load", "step", True), ("standpipe_pressure", "ramp", True),
])  # fmt: skip
def test_friction_that_grows_shows_later_in_the_hook_load(channel, kind, new):
    log = DetectionLog()
    log.take(_alarm(100.0, 80.0, kind="ramp", channel="surface_torque"))
    assert log.take(_alarm(500.0, 420.0, kind=kind, channel=channel)) is new


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


@pytest.mark.parametrize("after", [40.0, 60.0, 119.0, 200.0])
@pytest.mark.parametrize("kind", ["step", "ramp"])
@pytest.mark.parametrize("channel", ["standpipe_pressure", "surface_torque"])
def test_onset_after_detection_is_another_change(after, kind, channel):
    log = DetectionLog()
    log.take(_alarm(100.0, 80.0, size=2.0))
    assert log.take(_alarm(112.0 + after, 100.0 + after, size=5.0, kind=kind, channel=channel, evidence=50.0))
    assert [each.since for each in log.detections] == [80.0, 100.0 + after]


def test_onset_just_after_detection_is_a_late_sign_of_the_same_change():
    log = DetectionLog()
    log.take(_alarm(100.0, 80.0))
    assert not log.take(_alarm(130.0, 120.0, channel="hook_load", evidence=50.0))
    assert [each.since for each in log.detections] == [80.0]


def test_onset_never_lies_after_detection():
    rng = np.random.default_rng(3)
    for _ in range(50):
        log, time = DetectionLog(), 300.0
        for _ in range(40):
            time += float(rng.uniform(1.0, 200.0))
            channel = str(rng.choice(["standpipe_pressure", "hook_load", "surface_torque"]))
            since, kind = time - float(rng.uniform(0.0, 250.0)), str(rng.choice(["step", "ramp"]))
            log.take(_alarm(time, since, float(rng.normal(0.0, 4.0)), kind, channel, float(rng.uniform(10.0, 90.0))))
        assert all(each.since <= each.detected for each in log.detections)


def test_more_of_the_first_change_does_not_move_the_second():
    log = DetectionLog()
    log.take(_alarm(100.0, 80.0))
    log.take(_alarm(165.0, 145.0, channel="surface_torque"))
    assert not log.take(_alarm(170.0, 82.0, channel="hook_load", evidence=90.0))
    assert [(each.since, each.channel) for each in log.detections] == [(82.0, "hook_load"), (145.0, "surface_torque")]


def test_growing_ramp_keeps_its_onset():
    log = DetectionLog()
    log.take(_alarm(100.0, 80.0, kind="ramp"))
    assert not log.take(_alarm(180.0, 150.0, kind="ramp", evidence=90.0))
    assert log.detections[0].since == 80.0


def test_return_that_is_seen_again_stays_one_event():
    log = DetectionLog()
    log.take(_alarm(100.0, 80.0, size=4.0))
    assert not any(log.take(_alarm(300.0 + k, 280.0, size=-3.5)) for k in range(30))
    assert len(log.detections) == 1


CONFIRMED = ConfirmedChange(({}, {}), (700.0, 1000.0), "surface_torque", "step", 4.0)


def test_change_that_checks_find_is_a_detection_of_their_channel():
    log = DetectionLog()
    detection = log.take_confirmed(CONFIRMED, None, 1165.0)
    assert log.detections == [detection] and detection.detected == 1165.0
    assert (detection.since, detection.interval, detection.channel) == (850.0, (700.0, 1000.0), "surface_torque")


def test_alarm_of_what_checks_have_found_dates_it():
    log = DetectionLog()
    log.take_confirmed(CONFIRMED, None, 1165.0)
    assert not log.take(_alarm(1200.0, 960.0, channel="surface_torque"))
    (detection,) = log.detections
    assert (detection.since, detection.interval, detection.detected) == (960.0, (955.0, 965.0), 1165.0)


def test_alarm_of_the_other_sign_does_not_end_what_checks_have_found():
    log = DetectionLog()
    log.take_confirmed(CONFIRMED, None, 1165.0)
    assert log.take(_alarm(2000.0, 1950.0, size=-4.0, channel="surface_torque"))
    assert [each.ended for each in log.detections] == [None, None]


BEGAN = Began(84.0, (83.0, 86.0), "ramp")


def test_named_change_dates_the_detection_until_it_has_no_name():
    log = DetectionLog()
    log.take(_alarm(100.0, 90.0))
    log.take_diagnosis(1, DiagnosedChange("effect", ("washout",), began=BEGAN), 150.0)
    (found,) = log.detections
    assert (found.since, found.interval, found.kind, found.effects) == (84.0, (83.0, 86.0), "ramp", ("washout",))
    log.take(_alarm(160.0, 92.0, evidence=40.0))  # features do not move it now
    assert log.detections[0].since == 84.0 and log.seen(1).since == 92.0
    log.take_diagnosis(1, DiagnosedChange("unknown"), 200.0)
    assert (log.detections[0].since, log.detections[0].kind) == (92.0, "step")


def test_withdrawn_name_takes_its_site_along():
    log = DetectionLog()
    log.take(_alarm(100.0, 80.0))
    log.take_diagnosis(1, DiagnosedChange("effect", ("motor_wear",), site="motor"), 150.0)
    assert log.detections[0].site == "motor"
    log.take_diagnosis(1, DiagnosedChange("unknown"), 200.0)
    assert log.detections[0].site == "hydraulics"


def test_sentence_says_the_kind_that_the_date_says():
    log = DetectionLog()
    log.take(_alarm(100.0, 80.0))
    assert log.detections[0].what.endswith("rose against the twin, at once")
    began = Began(60.0, (50.0, 70.0), "ramp")
    log.take_diagnosis(1, DiagnosedChange("effect", ("washout",), began=began), 150.0)
    assert log.detections[0].what.endswith("rose against the twin, steadily")


def test_change_did_not_begin_after_it_was_detected():
    log = DetectionLog()
    log.take(_alarm(100.0, 90.0))
    log.take_diagnosis(1, DiagnosedChange("effect", ("washout",), began=Began(101.0, (95.0, 120.0), "step")), 150.0)
    assert log.detections[0].since == 90.0
