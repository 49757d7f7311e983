"""The studies that run a whole well: the wells they are made of, and what they find."""

import numpy as np
import pytest

from slider_drilling.paper_studies import weight_transfer, zones
from slider_drilling.paper_studies.whole_well import longer, slide
from slider_drilling.rig.example import example_rig


def test_longer_well_keeps_string_on_bottom():
    rig = example_rig()
    well = longer(rig, 800.0)
    assert well.string.length == rig.string.length + 800.0
    assert well.well.survey[-1][0] == rig.well.survey[-1][0] + 800.0
    assert well.well.friction_intervals[-1].to == rig.well.friction_intervals[-1].to + 800.0
    assert well.well.friction_intervals[0] == rig.well.friction_intervals[0]
    assert well.string.sections[-1] == rig.string.sections[-1]


def test_slide_lowers_and_rocks_as_given():
    rig = example_rig()
    commands = slide(rig, 60.0, 9.0, amplitude=10.0, period=20.0)
    assert commands.block_position[-1] == pytest.approx(9.0 / 60.0)
    assert np.abs(commands.top_drive_speed).max() == pytest.approx(2.0)
    assert not np.any(slide(rig, 60.0, 9.0).top_drive_angle)
    flow = commands.pump_speed[0] * rig.mud_pump.displacement
    assert flow == pytest.approx(rig.hydraulics.reference_flow)


def test_wider_rocking_reaches_deeper():
    rig = example_rig()
    narrow, wide = zones.simulate_zones(rig, 3.0), zones.simulate_zones(rig, 8.0)
    assert narrow.surface_torque < wide.surface_torque
    assert narrow.motion.rocked_to < wide.motion.rocked_to < rig.string.length
    for reach in (narrow, wide):
        assert reach.motion.rocked_to == pytest.approx(reach.closed_form.rocked_to, rel=0.1)
        assert np.all(np.diff(reach.swing[reach.depth < reach.motion.rocked_to]) < 0.0)


def test_rocking_brings_weight_to_the_bit():
    rig = example_rig()
    still = weight_transfer.run_slide(rig, slide(rig, 300.0, 9.0))
    rocked = weight_transfer.run_slide(rig, slide(rig, 300.0, 9.0, 20.0, 24.0))
    assert rocked.share > 2.0 * still.share
    assert rocked.weight_on_bit > still.weight_on_bit
    assert rocked.hook_load > still.hook_load


def test_less_friction_brings_weight_to_bit():
    rig = example_rig()
    plain = slide(rig, 300.0, 9.0)
    without = weight_transfer.run_slide(rig, plain)
    with_tool = weight_transfer.run_slide(rig, plain, ratio=0.05)
    assert with_tool.share > without.share
