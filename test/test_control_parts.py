"""The parts of the tool-face controller, each against what it must be in closed form."""

import itertools
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from slider_drilling.control.amplitude import LANDING, AmplitudeFinder
from slider_drilling.control.approach import Approach
from slider_drilling.control.auto_driller import AutoDriller
from slider_drilling.control.circular_belief import CircularBelief
from slider_drilling.control.differential_pressure import DifferentialPressure
from slider_drilling.control.drag import DragMonitor
from slider_drilling.control.drive import Motion, RockingDrive, Wish
from slider_drilling.control.heave import HeaveCompensator
from slider_drilling.control.learnt_rig import corrected, with_worn_motor
from slider_drilling.control.lock_up import Lock, LockUp
from slider_drilling.control.reach import Reach
from slider_drilling.control.rocking import Rocking
from slider_drilling.control.string_filter import Learnt
from slider_drilling.control.stroke_means import CycleMean, StrokeMeans
from slider_drilling.control.swing import Swing, apart
from slider_drilling.control.tool_face_estimator import EstimatorNoise, ToolFaceEstimator
from slider_drilling.control.torque_and_drag import TorqueAndDrag
from slider_drilling.control.torque_turn import TorqueTurn
from slider_drilling.rig import dump_rig, load_rig, parse_rig
from slider_drilling.signals import MwdSample

CONFIG = Path(__file__).resolve().parents[1] / "config"
RIG = load_rig(CONFIG / "rig.example.yaml")
NOISE = EstimatorNoise(math.radians(3.0), 150.0, 0.1, 0.1, 0.3, math.radians(0.6), math.radians(0.15))
S = 0.0042   # rad/(N m)


def test_drive_draws_the_ideal_trajectory():
    """With everything constant: the slopes, the turning points and the period of the paper's Fig. 22."""
    acceleration = 16.0
    rocking = Rocking(10.0, 10.0, 4.0 / acceleration)
    drive = RockingDrive(12.0, acceleration)
    angles, speeds = [], []
    for _ in range(4000):
        drive.advance(0.01, Wish(0.0, 10.0, 10.0))
        angles.append(drive.angle)
        speeds.append(drive.speed)
    assert max(angles) == pytest.approx(rocking.turning_angle, abs=1e-3)
    assert min(angles) == pytest.approx(-rocking.turning_angle, abs=1e-3)
    assert max(speeds) == pytest.approx(rocking.speed)
    peaks = [k for k in range(1, 3999) if angles[k - 1] < angles[k] >= angles[k + 1] and angles[k] > 9.0]
    assert np.diff(peaks) * 0.01 == pytest.approx(10.0, abs=0.02)


WISHES = st.builds(Wish, st.floats(-50.0, 50.0), st.floats(0.0, 40.0), st.floats(2.0, 40.0),
                   st.sampled_from([0.0, 1.0, 3.0]))


@given(st.lists(st.tuples(WISHES, st.sampled_from(list(Motion)), st.integers(1, 30)), min_size=1, max_size=8))
def test_drive_never_jumps_whatever_is_wished(wishes):
    drive = RockingDrive(12.0, 16.0, 3.0)
    for wish, motion, count in wishes:
        for _ in range(count):
            angle, speed = drive.angle, drive.speed
            drive.advance(0.1, wish, motion)
            assert abs(drive.speed) <= 12.0 + 1e-9
            assert abs(drive.speed - speed) <= 16.0 * 0.1 + 1e-9
            assert abs(drive.angle - angle) <= 12.0 * 0.1 + 1e-9


def test_belief_of_a_uniform_side_force_is_the_parabola(tmp_path):
    """Horizontal throughout: torque falls linearly, A = q s^2 / 2GJ."""
    text = (CONFIG / "rig.example.yaml").read_text()
    survey = text[text.index("    - [0.0, 0.0"):text.index("  hole_diameter")]
    flat = text.replace(survey, "    - [0.0, 90.0, 0.0]\n    - [4000.0, 90.0, 0.0]\n")
    flat = flat.replace("factor: 0.8", "factor: 1.0")
    flat = flat.replace("length: 60.0, outer_diameter: 0.165, inner_diameter: 0.0714",
                        "length: 60.0, outer_diameter: 0.127, inner_diameter: 0.1086")
    path = tmp_path / "flat.yaml"
    path.write_text(flat)
    rig = load_rig(path)
    belief = TorqueAndDrag(rig, 0.25, 0.0)
    area = math.pi / 4.0 * (0.127**2 - 0.1086**2)
    gradient = 0.25 * area * (7850.0 - 1200.0) * 9.81 * 0.127 / 2.0
    torsion = 7.92e10 * math.pi / 32.0 * (0.127**4 - 0.1086**4)
    for reach in (1000.0, 3000.0):
        amplitude = gradient * reach**2 / (2.0 * torsion)
        assert belief.reach(amplitude, 1.0) == pytest.approx(reach, abs=5.0)
        assert belief.breakover_torque(amplitude, 1.0) == pytest.approx(gradient * reach, rel=2e-3)
        assert belief.scale_from(amplitude, belief.breakover_torque(amplitude, 1.3)) == pytest.approx(1.3, rel=1e-3)
    zones = belief.zones(0.0, gradient * 500.0, 1.0)
    assert zones.reactive_from == pytest.approx(3500.0, abs=5.0)
    assert zones.static_length == pytest.approx(3500.0, abs=5.0)


def test_differential_pressure_is_zero_off_bottom_at_any_flow():
    for share in (0.6, 1.0, 1.1):
        pressure = DifferentialPressure(RIG, 0.0, 0.5, 5.0)
        for _ in range(100):
            pressure.update(1.8e7 * share**1.8 + 1e6, share * 0.032 / 0.0026, 1.0)
        assert pressure.smooth == pytest.approx(1e6, rel=1e-3)
        assert pressure.reactive_torque == pytest.approx(1600.0, rel=1e-3)


def test_lost_pressure_holds_the_last_value():
    pressure = DifferentialPressure(RIG, 0.0, 0.5, 5.0)
    pressure.update(1.9e7, 0.032 / 0.0026, 100.0)
    held = pressure.smooth
    pressure.update(math.nan, 12.3, 1.0)
    assert pressure.smooth == held


def test_auto_driller_holds_pressure_on_a_spring_and_a_bit():
    """Against the string's stiffness and the rig file's rock, without friction: the pressure wanted is reached."""
    driller = AutoDriller(RIG, 30.0, 0.02)
    wanted = driller.pressure_for(0.0025)
    stiffness, weight = 1.775e5, 0.0
    for _ in range(6000):
        speed = driller.update(weight / driller.weight_per_pressure, wanted, wanted / 60.0, 0.1)
        drilled = driller.speed_per_pressure * weight / driller.weight_per_pressure
        weight += stiffness * (speed - drilled) * 0.1
    assert weight / driller.weight_per_pressure == pytest.approx(wanted, rel=0.02)
    assert speed == pytest.approx(0.0025, rel=0.05)


def feed(estimator, twist, offset, until, samples):
    """Rocking of 8 s about a centre on target, on a string that the bit twists by `twist(t)`, its bend `offset` off."""
    for k in range(round(until / 0.5)):
        time = 0.5 * k
        estimator.advance(time)
        if time > 8.0 and time % 4.0 == 0.0:
            torque = twist(time - 4.0) / S
            estimator.observe(time, CycleMean(0.0, torque, torque, 8.0), 1.0, 0.0)
        if time in samples:
            angle = offset - twist(time - 6.0) if samples[time] is None else samples[time]
            estimator.correct(MwdSample(time - 6.0, time, math.remainder(angle, 2.0 * math.pi)), 0.0)


def test_torque_tells_the_tool_face_between_samples():
    """After four samples off bottom none come any more, and the reactive torque winds the string up by a turn."""
    estimator, x = slide(following=0.0, last_sample=54.0, duration=190.0)
    assert x < -2.0 * math.pi
    assert estimator.tool_face == pytest.approx(x, abs=2.0 * estimator.spread)
    assert estimator.spread < 1.5


def test_one_wrong_sample_hardly_counts_and_what_repeats_is_believed():
    every = dict.fromkeys(np.arange(18.0, 300.0, 12.0))
    estimator = ToolFaceEstimator(S, 60.0, NOISE)
    feed(estimator, lambda time: 0.0, 0.5, 300.0, every | {150.0: 3.0})
    assert estimator.rejections == 1
    assert estimator.tool_face == pytest.approx(0.5, abs=math.radians(1.0))
    feed(estimator := ToolFaceEstimator(S, 60.0, NOISE), lambda time: 0.0, 0.5, 300.0,
         every | dict.fromkeys(np.arange(150.0, 300.0, 12.0), 3.0))
    assert math.remainder(estimator.tool_face - 3.0, 2.0 * math.pi) == pytest.approx(0.0, abs=math.radians(3.0))


def slide(softer=0.0, motor=0.0, bias=0.0, following=1.0, last_sample=math.inf, duration=600.0, seed=0):
    """A rocked string without static zone, in closed form: off bottom, a ramp of pressure, then drilling; the centre
    follows a share of the twist that the rig file would need, and a step. Returns the estimator and the true
    tool-face."""
    random = np.random.default_rng(seed)
    estimator = ToolFaceEstimator(S, 60.0, NOISE)
    compliance, x, samples = S * (1.0 + softer), 0.4, []
    for k in range(round(duration / 0.5)):
        time = 0.5 * k
        shown = 2900.0 * min(max((time - 60.0) / 60.0, 0.0), 1.0)
        centre = following * S * shown + (1.0 if time > 300.0 else 0.0)
        torque, reactive = (centre - x + 0.4) / compliance, (1.0 + motor) * shown
        x += 0.5 * compliance * (torque - reactive) / 60.0
        estimator.settled = time > 130.0
        estimator.advance(time, shown)
        if time > 8.0 and time % 4.0 == 0.0:
            estimator.observe(time, CycleMean(centre, torque + bias + random.normal(0.0, 17.0), shown, 8.0), 1.0, 0.0)
        if time % 12.0 == 0.0 and time <= last_sample:
            samples.append(MwdSample(time, time + 6.0, math.remainder(x + random.normal(0.0, 0.02), 2.0 * math.pi)))
        while samples and samples[0].arrived_at <= time:
            estimator.correct(samples.pop(0), 0.0)
    return estimator, x


@pytest.mark.parametrize(("softer", "motor", "bias"), [
    (0.13, 0.0, 0.0), (0.0, -0.25, 0.0), (0.0, 0.0, -500.0), (0.08, -0.12, 300.0), (0.0, 0.0, 0.0)])  # fmt: skip
def test_string_is_learnt_while_sliding(softer, motor, bias):
    """Compliance, motor and sensor at once, within what their stated one-sigma allows; the tool-face is right."""
    estimator, x = slide(softer, motor, bias)
    learnt = estimator.filter.learnt
    assert estimator.tool_face == pytest.approx(x, abs=math.radians(3.0))
    assert learnt.compliance == pytest.approx(softer, abs=3.0 * learnt.compliance_sigma)
    assert learnt.motor == pytest.approx(motor, abs=3.0 * learnt.motor_sigma)
    assert learnt.bias == pytest.approx(bias, abs=3.0 * learnt.bias_sigma)
    # together they foretell the torque at which the tool-face rests better than the rig file does
    resting = (1.0 + learnt.motor) * 2900.0 + learnt.bias
    assert resting == pytest.approx((1.0 + motor) * 2900.0 + bias, abs=60.0)


def test_what_was_learnt_is_a_rig_file():
    learnt = Learnt(0.1, 0.02, -0.2, 0.05, 250.0, 80.0, 70.0)
    again = parse_rig(dump_rig(corrected(RIG, learnt)))
    assert again.effects.torsional_compliance.extra == pytest.approx(0.1)
    assert again.effects.motor_wear.torque_loss == pytest.approx(0.2)
    assert again.effects.torque_sensor_bias.bias == pytest.approx(250.0)
    assert with_worn_motor(again).motor.torque_per_pressure == pytest.approx(0.8 * RIG.motor.torque_per_pressure)
    assert TorqueAndDrag(again, 0.235, 0.0).compliance == pytest.approx(1.1 * TorqueAndDrag(RIG, 0.235, 0.0).compliance)


def swung(amplitude, period, drift=0.0, noise=0.02):
    """A swing as MWD every 12 s shows it, over 400 s of rocking."""
    random, swing = np.random.default_rng(1), Swing(0.025)
    for k in range(1, 4001):
        time = 0.1 * k
        if k % round(5.0 * period) == 0:
            swing.reversal(time)
        swing.fade(0.1)
        if k % 120 == 0:
            angle = math.pi * time / (0.5 * period)
            swing.update(time, amplitude * math.sin(angle + 0.7) + drift * time + random.normal(0.0, noise))
    return swing


@pytest.mark.parametrize("amplitude", [0.0, 0.03, 0.1])
def test_swing_is_found_in_slow_samples_beside_a_drift(amplitude):
    swing = swung(amplitude, 7.4, drift=1e-3)
    assert swing.amplitude == pytest.approx(amplitude, abs=3.0 * swing.spread)
    assert swing.spread < 0.02


def test_period_is_chosen_so_that_samples_meet_unlike_phases():
    for period, sampling in itertools.product((6.0, 8.1, 11.3), (8.0, 12.0, 20.0)):
        chosen = apart(period, sampling)
        cycles = abs(math.remainder(sampling / chosen, 1.0))
        before = abs(math.remainder(sampling / period, 1.0))
        assert abs(chosen / period - 1.0) <= 0.121
        assert chosen >= period
        assert min(cycles, 1.0 - 2.0 * cycles) >= min(before, 1.0 - 2.0 * before, 0.1) - 1e-9


def test_drag_is_the_weight_that_neither_hook_nor_bit_carries():
    drag = DragMonitor(RIG, 0.235, 8e4)
    for _ in range(300):
        drag.tare(460e3, 0.1)
    assert drag.arriving == 1.0
    for hook_load, weight, arriving in ((360e3, 8e4, 1.0), (250e3, 4e4, 0.0), (250e3, 4e4, 0.0), (360e3, 8e4, 1.0)):
        for _ in range(900):
            drag.update(hook_load, weight, 1.0, 0.1)
        assert drag.drag == pytest.approx(460e3 - hook_load - weight, abs=500.0)
        assert drag.arriving == arriving


def lock_up_after(lock, drag, pressure, seconds):
    for _ in range(round(10.0 * seconds)):
        lock.update(drag, pressure, 1.8e6, 0.1)
    return lock.state


def test_lock_up_lets_go_with_less_weight_each_time_and_then_latches():
    lock = LockUp()
    assert lock_up_after(lock, 0.7, 1.7e6, 600.0) is Lock.FREE, "weight that arrives is no lock-up"
    assert lock_up_after(lock, 0.3, 0.9e6, 600.0) is Lock.FREE, "pipe that hardly drags holds no weight"
    for trip, share in ((1, 0.8), (2, 0.64)):
        assert lock_up_after(lock, 0.7, 0.9e6, 21.0) is Lock.HELD and lock.stops
        assert lock.share_left == pytest.approx(share) and lock.trips == trip
        assert lock_up_after(lock, 0.5, 0.9e6, 60.0) is Lock.HELD, "not freed yet"
        assert lock_up_after(lock, 0.2, 0.9e6, 20.0) is Lock.HELD, "not freed for long enough"
        assert lock_up_after(lock, 0.2, 0.9e6, 11.0) is Lock.LESS and not lock.stops
    assert lock_up_after(lock, 0.7, 0.9e6, 21.0) is Lock.LATCHED
    assert lock_up_after(lock, 0.0, 1.8e6, 3600.0) is Lock.LATCHED and lock.stops, "drag that is gone tells nothing now"
    lock.release()
    assert lock.state is Lock.FREE and lock.share_left == 1.0


def test_lock_up_that_rocking_does_not_free_latches():
    lock = LockUp()
    assert lock_up_after(lock, 0.7, 0.9e6, 300.0) is Lock.LATCHED
    assert lock.never_freed and lock.trips == 1


def test_weight_that_arrives_too_slowly_is_lock_up_too():
    assert lock_up_after(LockUp(), 0.45, 0.9e6, 170.0) is Lock.FREE
    assert lock_up_after(LockUp(), 0.45, 0.9e6, 181.0) is Lock.HELD
    assert lock_up_after(LockUp(), math.nan, 0.9e6, 600.0) is Lock.FREE


def test_nothing_is_lowered_that_would_hang_on_the_wall():
    driller = AutoDriller(RIG, 20.0, 0.1)
    free = [driller.update(0.5e6, 1.8e6, 1e5, 0.1) for _ in range(100)]
    hung = AutoDriller(RIG, 20.0, 0.1)
    held = [hung.update(0.5e6, 1.8e6, 1e5, 0.1, arriving=0.0) for _ in range(100)]
    assert held[-1] == pytest.approx(min(hung.speed_per_pressure * 0.5e6, held[0])) and free[-1] > held[-1]
    assert hung.setpoint == 0.0 and driller.setpoint == pytest.approx(1e6)
    driller.follow(0.3e6)
    assert driller.setpoint == 0.3e6


def test_reach_goes_deeper_for_drag_and_less_deep_for_swing():
    def after(drag, swing, pull=0.0, error=0.3):
        reach = Reach()
        for k in range(1000):
            reach.answer(pull, 60.0, 0.0, error, 0.1)
            reach.update(drag, swing, 0.01, 0.1)
            assert 0.65 <= reach.share <= 1.8, k
        return reach

    assert after(0.5, 0.0).share > 1.2
    assert after(0.2, 0.1).share < 0.9
    assert after(0.19, 0.02).share == 1.0
    assert after(0.3, 0.0).share < after(0.3, 0.0, pull=2.0).share
    assert after(0.3, 0.0, pull=2.0).stuck and not after(0.3, 0.0).stuck
    assert after(0.3, 0.0, pull=2.0).urge > 0.9 and after(0.3, 0.0).urge == 0.0
    assert not after(0.3, 0.0, pull=2.0, error=-0.3).stuck, "a pull that no error asked for is the sensors'"
    assert after(0.1, 0.0, pull=2.0).share <= 1.0, "pipe that does not drag does not hold the bit"


def test_pressure_is_tared_off_bottom_but_not_while_drilling():
    for extra, tared in ((3e5, True), (1.8e6, False)):
        pressure = DifferentialPressure(RIG, 0.0, 0.5, 5.0)
        for _ in range(400):
            pressure.tare(1.8e7 + extra, 0.032 / 0.0026, 0.1)
        pressure.update(1.8e7 + extra + 1e6, 0.032 / 0.0026, 100.0)
        assert pressure.smooth == pytest.approx(1e6 + (0.0 if tared else extra), rel=0.01)


def test_a_wrong_first_sample_is_outvoted():
    estimator = ToolFaceEstimator(S, 60.0, NOISE)
    feed(estimator, lambda time: 0.0, 0.5, 60.0, {18.0: -2.5, 30.0: None, 42.0: None})
    assert estimator.tool_face == pytest.approx(0.5, abs=math.radians(2.0))


@pytest.mark.parametrize("sample", [MwdSample(math.nan, 1.0, 0.0), MwdSample(0.0, 1.0, math.nan),
                                    MwdSample(1e9, 1e9, 0.0), MwdSample(-200.0, 1.0, 0.0)])
def test_estimator_refuses_nonsense(sample):
    estimator = ToolFaceEstimator(S, 60.0, NOISE)
    assert not estimator.correct(sample, 0.0)
    estimator.observe(10.0, CycleMean(0.0, 0.0, 0.0, 8.0), 1.0, 0.0)
    assert not estimator.correct(sample, 0.0)
    assert not estimator.known


def test_circular_belief_is_bayes_of_normal_samples():
    """Across the half turn; variances add as for the normal distribution, and spread by what it may have moved."""
    belief = CircularBelief(0.05)
    for off in (-0.02, 0.06):
        belief.update(math.remainder(math.pi + off, 2.0 * math.pi), 0.01)
    assert abs(math.remainder(belief.mean - (math.pi + 0.02), 2.0 * math.pi)) < 2e-3
    assert belief.spread == pytest.approx(math.sqrt(0.005), rel=0.05)
    assert belief.weight > 0.99
    belief.diffuse(0.02)
    assert belief.spread == pytest.approx(math.sqrt(0.025), rel=0.05)


def test_means_over_whole_strokes_leave_no_rocking():
    """Friction that opposes either stroke alike and a mean torque, on strokes of unlike speed."""
    means, cycles, strokes = StrokeMeans(), [], 0
    for k in range(1, 401):
        if k % 40 == 0:
            strokes += 1
        side = 1.0 if strokes % 2 == 0 else -1.0
        within = (k % 40) / 40.0 - 0.5
        cycle = means.update(0.1, 2.0 + side * within, 700.0 + side * 3000.0, 500.0, strokes)
        cycles += [cycle] if cycle else []
    assert cycles[-1].torque == pytest.approx(700.0, abs=1e-6)
    assert cycles[-1].angle == pytest.approx(2.0, abs=1e-6)
    assert (cycles[-1].reactive_torque, cycles[-1].duration) == pytest.approx((500.0, 8.0))


def test_a_stroke_that_was_not_measured_gives_no_mean():
    means, cycles = StrokeMeans(), []
    for k in range(400):
        torque = math.nan if 80 <= k < 120 else 0.0
        cycles.append(means.update(0.1, 0.0, torque, 0.0, k // 40))
    assert [k for k in range(400) if cycles[k]] == [80, 200, 240, 280, 320, 360]


@pytest.mark.parametrize("lag", [0.0, 0.5])
@pytest.mark.parametrize("friction", [0.75, 1.0, 1.25])
def test_breakover_test_finds_friction_through_a_sensor_that_lags(friction, lag):
    """On a string without inertia: loaded along the closed form, unloaded and loaded again along twice of it."""
    belief = TorqueAndDrag(RIG, 0.235, 0.0)
    finder, drive = AmplitudeFinder(belief, 10.0), RockingDrive(12.0, 16.0)
    wish = Wish(0.0, 14.0, 9.0, LANDING * belief.travel_time)
    from_angle, from_torque, sensed, side, twice = 0.0, 0.0, 0.0, 1.0, 1.0
    for _ in range(3000):
        drive.advance(0.1, wish)
        turned = side * (drive.angle - from_angle) / twice
        torque = from_torque + side * twice * belief.breakover_torque(max(turned, 0.0), friction)
        if drive.side != side:
            from_angle, from_torque, side, twice = drive.angle, torque, drive.side, 2.0
        sensed += (1.0 - math.exp(-0.1 / lag) if lag else 1.0) * (torque - sensed)
        finder.update(drive.angle, sensed, drive.strokes)
    assert not finder.testing
    assert finder.scale == pytest.approx(friction, rel=0.08 if lag else 0.01)


def test_approach_knows_where_the_bit_touches_and_a_slip_hardly_moves_it():
    """Drilling at 80 kN on 1e5 N/m the bit would touch 0.8 m higher; a block that slips 0.6 m shows before pressure."""
    approach, pressure = Approach(1e5, 0.04), 2e6
    for k in range(3000):
        approach.drilling(10.0 + 2.5e-4 * k, pressure, 0.1)
    end = 10.0 + 2.5e-4 * 3000
    for _ in range(50):
        approach.drilling(end + 0.6, pressure, 0.1)
    approach.pick_up()
    assert approach.speed(end - 2.8, 0.1, 0.5, 0.1) == 0.1 and approach.fast
    position = end - 2.8
    while approach.speed(position, 0.1, 0.5, 0.1) > 0.0:
        position += 0.1 * approach.speed(position, 0.1, 0.5, 0.0)
    assert position == pytest.approx(end - 0.8 - 0.25, abs=0.12)
    assert not approach.fast and approach.under_way
    assert approach.speed(position, 0.1, 0.1, 0.1) > 0.0


def test_approach_that_knows_no_bottom_creeps():
    assert Approach(1e5, 0.04).speed(0.0, 0.1, 0.0, 0.1) < 0.01


def test_torque_turn_ends_strokes_and_bumps():
    """On 200 N m per rad with limits of 2 and 1 kN m; a centre wanted 1 rad right goes a rad beyond the right one."""
    turn, angle, side, ends = TorqueTurn(2000.0, 1000.0), 0.0, 1.0, []
    for _ in range(4000):
        angle += side * 0.05
        if turn.must_turn(angle, 200.0 * angle, side, 2.5 if len(ends) < 4 else 3.5):
            ends.append(angle)
            side = -side
    assert ends[0] == pytest.approx(10.0, abs=0.11) and ends[1] == pytest.approx(-5.0, abs=0.11)
    assert ends[4] == pytest.approx(11.0, abs=0.21)
    assert all(a * b < 0.0 for a, b in itertools.pairwise(ends))


def test_heave_is_found_and_taken_out_of_the_block():
    """A wave of 0.15 m on a spring three times as stiff as believed, beside rocking at 4 s and a slow drift of load."""
    heave, moved, loads, random = HeaveCompensator(1e5, 0.2), 0.0, [], np.random.default_rng(2)
    for k in range(4000):
        time = 0.1 * k
        wave = 0.15 * math.sin(2.0 * math.pi * time / 11.0 + 1.0)
        load = 4e5 - 3e5 * (wave + moved) + 4e3 * math.sin(2.0 * math.pi * time / 4.0) - 50.0 * time
        loads.append(load + 50.0 * time)
        moved += 0.1 * heave.update(load + random.normal(0.0, 4e3), 8.0, True, 0.1)
    assert heave.period == pytest.approx(11.0, rel=0.02)
    assert np.std(loads[-500:]) < 0.25 * np.std(loads[:500])
    assert abs(moved) < 0.3


def test_rocking_is_not_taken_for_heave():
    heave, random = HeaveCompensator(1e5, 0.2), np.random.default_rng(2)
    for k in range(3000):
        load = 4e5 + 1e4 * math.sin(2.0 * math.pi * 0.1 * k / 8.0) + random.normal(0.0, 4e3)
        assert heave.update(load, 8.0, True, 0.1) == 0.0
    assert math.isnan(heave.period)
