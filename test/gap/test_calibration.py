"""Calibration: the first state of the search."""

import itertools

from toy import EFFECTS, TIME, toy

from slider_drilling.gap.problem.noise import noise_floor
from slider_drilling.gap.selection.calibration import calibrate


def test_calibration_does_not_change_its_input():
    model = toy({"level": 1.0}, 1)
    floors = [{"force": noise_floor(model.runs[0].channels[0])}]
    before = [dict(own) for own in floors]
    states = [calibrate(model, EFFECTS, floors, [{}], 0, lambda stage, share: None) for _ in range(2)]
    assert floors == before
    assert states[0].calibrated.fit.values == states[1].calibrated.fit.values
    assert all(a.name != b.name for a, b in itertools.pairwise(states[0].calibrated.fit.parameters))
    assert states[0].calibrated.problem.size == TIME.size
