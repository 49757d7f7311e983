"""Rocking: reference, amplitude adaptation, periods and averages, against closed forms."""

import itertools
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from slider_drilling.control.estimation.breakover_test import SLOW_DOWN_TRAVEL_TIMES, BreakoverTest
from slider_drilling.control.estimation.cycle_average import CycleAverager
from slider_drilling.control.estimation.rocking_phase import RockingPhase, period_with_distinct_phases
from slider_drilling.control.estimation.torque_and_drag import TorqueAndDrag
from slider_drilling.control.rocking import Rocking
from slider_drilling.control.top_drive.amplitude_adaptation import AmplitudeAdaptation
from slider_drilling.control.top_drive.rocking_reference import DriveMode, RockingReference, RockingSetpoint
from slider_drilling.control.top_drive.torque_limited_reversal import TorqueLimitedReversal
from slider_drilling.rig import load_rig

CONFIG = Path(__file__).resolve().parents[1] / "config"
RIG = load_rig(CONFIG / "rig.example.yaml")


def test_reference_follows_ideal_trajectory():
    """With everything constant: the slopes, the turning points and the period of the paper's Fig. 22."""
    acceleration = 16.0
    rocking = Rocking(10.0, 10.0, 4.0 / acceleration)
    drive = RockingReference(12.0, acceleration)
    angles, speeds = [], []
    for _ in range(4000):
        drive.advance(0.01, RockingSetpoint(0.0, 10.0, 10.0))
        angles.append(drive.angle)
        speeds.append(drive.speed)
    assert max(angles) == pytest.approx(rocking.turning_angle, abs=1e-3)
    assert min(angles) == pytest.approx(-rocking.turning_angle, abs=1e-3)
    assert max(speeds) == pytest.approx(rocking.speed)
    peaks = [k for k in range(1, 3999) if angles[k - 1] < angles[k] >= angles[k + 1] and angles[k] > 9.0]
    assert np.diff(peaks) * 0.01 == pytest.approx(10.0, abs=0.02)


SETPOINTS = st.builds(RockingSetpoint, st.floats(-50.0, 50.0), st.floats(0.0, 40.0), st.floats(2.0, 40.0),
                   st.sampled_from([0.0, 1.0, 3.0]))


@given(st.lists(st.tuples(SETPOINTS, st.sampled_from(list(DriveMode)), st.integers(1, 30)), min_size=1, max_size=8))
def test_reference_never_jumps(setpoints):
    drive = RockingReference(12.0, 16.0, 3.0)
    for setpoint, motion, count in setpoints:
        for _ in range(count):
            angle, speed = drive.angle, drive.speed
            drive.advance(0.1, setpoint, motion)
            assert abs(drive.speed) <= 12.0 + 1e-9
            assert abs(drive.speed - speed) <= 16.0 * 0.1 + 1e-9
            assert abs(drive.angle - angle) <= 12.0 * 0.1 + 1e-9


def test_rocking_phase_is_half_turn_per_stroke():
    phase = RockingPhase()
    assert math.isnan(phase.at(0.0))
    for k in range(60):
        phase.add_reversal(4.0 * k)
    assert math.isnan(phase.at(1.0)), "before the strokes that are kept"
    assert phase.at(201.0) - phase.at(199.0) == pytest.approx(0.5 * math.pi)
    assert phase.at(238.0) - phase.at(234.0) == pytest.approx(math.pi), "the stroke in progress"
    before = phase.at(230.0)
    phase.add_reversal(240.0)
    assert phase.at(230.0) == pytest.approx(before)


def test_chosen_period_gives_distinct_mwd_phases():
    def margin(period, sampling):
        cycles = abs(math.remainder(sampling / period, 1.0))
        return min(cycles / 0.2, (0.5 - cycles) / 0.05, 1.0)

    for period, sampling in itertools.product((6.0, 8.1, 11.2, 11.3), (8.0, 12.0, 20.0)):
        chosen = period_with_distinct_phases(period, sampling)
        assert 0.969 <= chosen / period <= 1.121
        assert margin(chosen, sampling) >= margin(period, sampling) - 1e-9
    # A shorter period only where no longer one serves.
    assert period_with_distinct_phases(11.2, 12.0) == pytest.approx(0.97 * 11.2)
    assert period_with_distinct_phases(6.0, 12.0) == pytest.approx(1.12 * 6.0)
    # A change of nearly half a cycle shows both sides of the swing.
    assert period_with_distinct_phases(8.3, 12.0) == 8.3


def test_drag_grows_and_swing_reduces_amplitude():
    def after(drag, swing, driving_twist=0.0, error=0.3, drag_sigma=0.0):
        adaptation = AmplitudeAdaptation()
        for k in range(1000):
            adaptation.check_response(driving_twist, 60.0, 0.0, error, False, 0.1)
            adaptation.update(drag, drag - drag_sigma, swing, 0.01, 0.1)
            assert 0.65 <= adaptation.factor <= 1.8, k
        return adaptation

    assert after(0.5, 0.0).factor > 1.2
    assert after(0.5, 0.0, drag_sigma=0.25).factor == 1.0, "uncertain drag asks for no amplitude"
    assert after(0.5, 0.1, drag_sigma=0.25).factor < 0.9, "uncertain drag does not stop the reduction by swing"
    assert after(0.2, 0.1).factor < 0.9
    assert after(0.19, 0.02).factor == 1.0
    assert after(0.3, 0.0).factor < after(0.3, 0.0, driving_twist=2.0).factor
    assert after(0.3, 0.0, driving_twist=2.0).bit_stuck and not after(0.3, 0.0).bit_stuck
    assert after(0.3, 0.0, driving_twist=2.0).gain_boost > 0.9 and after(0.3, 0.0).gain_boost == 0.0
    assert not after(0.3, 0.0, driving_twist=2.0, error=-0.3).bit_stuck, "this twist corrects no error"
    assert after(0.1, 0.0, driving_twist=2.0).factor <= 1.0, "without drag nothing holds the bit"


def test_cycle_average_cancels_rocking():
    """Friction that opposes both strokes equally, plus a mean torque."""
    averager, cycles, strokes = CycleAverager(), [], 0
    for k in range(1, 401):
        if k % 40 == 0:
            strokes += 1
        side = 1.0 if strokes % 2 == 0 else -1.0
        within = (k % 40) / 40.0 - 0.5
        cycle = averager.update(0.1, 2.0 + side * within, 700.0 + side * 3000.0, 500.0, strokes)
        cycles += [cycle] if cycle else []
    assert cycles[-1].torque == pytest.approx(700.0, abs=1e-6)
    assert cycles[-1].angle == pytest.approx(2.0, abs=1e-6)
    assert (cycles[-1].reactive_torque, cycles[-1].duration) == pytest.approx((500.0, 8.0))


def test_unmeasured_stroke_gives_no_average():
    averager, cycles = CycleAverager(), []
    for k in range(400):
        torque = math.nan if 80 <= k < 120 else 0.0
        cycles.append(averager.update(0.1, 0.0, torque, 0.0, k // 40))
    assert [k for k in range(400) if cycles[k]] == [80, 200, 240, 280, 320, 360]


@pytest.mark.parametrize("lag", [0.0, 0.5])
@pytest.mark.parametrize("friction", [0.75, 1.0, 1.25])
def test_breakover_test_finds_friction_despite_sensor_lag(friction, lag):
    """On a string without inertia: loaded along the closed form, unloaded and loaded again along twice of it."""
    belief = TorqueAndDrag(RIG, 0.235, 0.0)
    finder, drive = BreakoverTest(belief, 10.0), RockingReference(12.0, 16.0)
    setpoint = RockingSetpoint(0.0, 14.0, 9.0, SLOW_DOWN_TRAVEL_TIMES * belief.travel_time)
    from_angle, from_torque, sensed, side, twice = 0.0, 0.0, 0.0, 1.0, 1.0
    for _ in range(3000):
        drive.advance(0.1, setpoint)
        turned = side * (drive.angle - from_angle) / twice
        torque = from_torque + side * twice * belief.breakover_torque(max(turned, 0.0), friction)
        if drive.side != side:
            from_angle, from_torque, side, twice = drive.angle, torque, drive.side, 2.0
        sensed += (1.0 - math.exp(-0.1 / lag) if lag else 1.0) * (torque - sensed)
        finder.update(drive.angle, sensed, drive.strokes, lag / 0.1)
    assert not finder.running
    assert finder.friction_scale == pytest.approx(friction, rel=0.03 if lag else 0.01)


def test_torque_limits_reverse_strokes_with_bump():
    """On 200 N m per rad, limits 2 and 1 kN m; moving the centre right by 1 rad extends right strokes by 1 rad."""
    reversal, angle, side, ends = TorqueLimitedReversal(2000.0, 1000.0), 0.0, 1.0, []
    for _ in range(4000):
        angle += side * 0.05
        if reversal.must_reverse(angle, 200.0 * angle, side, 2.5 if len(ends) < 4 else 3.5):
            ends.append(angle)
            side = -side
    assert ends[0] == pytest.approx(10.0, abs=0.11) and ends[1] == pytest.approx(-5.0, abs=0.11)
    assert ends[4] == pytest.approx(11.0, abs=0.21)
    assert all(a * b < 0.0 for a, b in itertools.pairwise(ends))


def test_strokes_grow_until_a_stuck_bit_answers():
    adaptation = AmplitudeAdaptation()
    for _ in range(1500):
        adaptation.check_response(3.0, 60.0, 0.0, 0.5, True, 0.1)
    assert adaptation.tears_loose and adaptation.release > 1.4
    tool_face = 0.0
    for _ in range(600):
        tool_face += 0.1 * 3.0 / 60.0
        adaptation.check_response(3.0, 60.0, tool_face, 0.5, True, 0.1)
    assert not adaptation.tears_loose, "a bit that answers needs no larger strokes"


def test_small_errors_tear_nothing_loose():
    adaptation = AmplitudeAdaptation()
    for _ in range(1500):
        adaptation.check_response(3.0, 60.0, 0.0, 0.2, True, 0.1)
    assert adaptation.bit_stuck and adaptation.release == 1.0
