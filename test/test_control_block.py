"""Block control: pressure, drag, lock-up, return to bottom and heave, against closed forms."""

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest

from slider_drilling.control.block.auto_driller import AutoDriller
from slider_drilling.control.block.block_control import BlockControl, load_share_for_tool_face
from slider_drilling.control.block.heave_compensation import HeaveCompensator
from slider_drilling.control.block.return_to_bottom import ReturnToBottom
from slider_drilling.control.estimation.differential_pressure import DifferentialPressure
from slider_drilling.control.estimation.drag_monitor import DragMonitor
from slider_drilling.control.estimation.string_kalman_filter import StringKalmanFilter
from slider_drilling.control.interlocks.block_slip import BlockSlipInterlock
from slider_drilling.control.interlocks.load_check import LET_GO_SHARE
from slider_drilling.control.interlocks.lock_up import LockUpInterlock, LockUpState
from slider_drilling.control.slide_settings import SlideSettings
from slider_drilling.effects import BucklingContact
from slider_drilling.rig import load_rig

CONFIG = Path(__file__).resolve().parents[1] / "config"
RIG = load_rig(CONFIG / "rig.example.yaml")
STRING = StringKalmanFilter(5e-3, 60.0).estimate


def test_differential_pressure_off_bottom_is_independent_of_flow():
    for share in (0.6, 1.0, 1.1):
        pressure = DifferentialPressure(RIG, 0.0, 0.5, 5.0)
        for _ in range(100):
            pressure.update(1.8e7 * share**1.8 + 1e6, share * 0.032 / 0.0026, 1.0)
        assert pressure.smooth == pytest.approx(1e6, rel=1e-3)
        assert pressure.reactive_torque == pytest.approx(1600.0, rel=1e-3)


def test_missing_pressure_holds_last_value():
    pressure = DifferentialPressure(RIG, 0.0, 0.5, 5.0)
    pressure.update(1.9e7, 0.032 / 0.0026, 100.0)
    held = pressure.smooth
    pressure.update(math.nan, 12.3, 1.0)
    assert pressure.smooth == held


def test_auto_driller_reaches_target_pressure():
    """On the string as a spring and the rig file's rock, without friction."""
    driller = AutoDriller(RIG, 30.0, 0.02)
    wanted = driller.pressure_for(0.0025)
    stiffness, weight = 1.775e5, 0.0
    for _ in range(6000):
        speed = driller.update(weight / driller.weight_per_pressure, wanted, wanted / 60.0, 0.1)
        drilled = driller.speed_per_pressure * weight / driller.weight_per_pressure
        weight += stiffness * (speed - drilled) * 0.1
    assert weight / driller.weight_per_pressure == pytest.approx(wanted, rel=0.02)
    assert speed == pytest.approx(0.0025, rel=0.05)


def test_held_below_matches_drag_of_nonrotating_pipe():
    """In the horizontal hole the drag per metre of drill pipe is friction times its buoyed weight."""
    depths = []
    for held in (0.0, 3e4, 5e4, 9e5):
        drag = DragMonitor(RIG, 0.235, 8e4)
        drag.tare(460e3, 0.1)
        drag.update(460e3 - 8e4 - held, 8e4, 0.1, 1.0, 0.1)
        depths.append(drag.held_below)
    metre = 0.235 * (RIG.string.density - RIG.mud.density) * 9.81 * math.pi / 4.0 * (0.127**2 - 0.1086**2)
    assert depths[1] - depths[2] == pytest.approx(2e4 / metre, rel=0.01)
    assert depths[0] == pytest.approx(4000.0) and depths[3] == 0.0
    assert DragMonitor(RIG, 0.235, 8e4).held_below == pytest.approx(4000.0), "no measurement yet"
    looser = DragMonitor(RIG, 0.235, 8e4)
    looser.tare(460e3, 0.1)
    looser.update(460e3 - 8e4 - 3e4, 8e4, 0.1, 0.8, 0.1)
    assert looser.held_below < depths[1], "less friction needs more non-rotating pipe for the same drag"


def test_known_buckling_leaves_drag_share():
    """Drag by buckling is lock-up: buckling in the rig file must not raise the reference drag."""
    known = dataclasses.replace(RIG, effects=dataclasses.replace(RIG.effects, buckling_contact=BucklingContact(1.0)))
    shares = []
    for rig in (RIG, known):
        drag = DragMonitor(rig, 0.235, 8e4)
        drag.tare(460e3, 0.1)
        drag.update(280e3, 4e4, 0.1, 1.0, 0.1)
        shares.append(drag.share)
    assert shares[1] == pytest.approx(shares[0])


def test_drag_is_weight_off_hook_and_bit():
    drag = DragMonitor(RIG, 0.235, 8e4)
    for _ in range(300):
        drag.tare(460e3, 0.1)
    limit = 5e4   # N, that leaves no room for drag
    assert drag.transmitted_share(limit) == 1.0
    for hook_load, weight, arriving in ((360e3, 8e4, 1.0), (250e3, 4e4, 0.0), (250e3, 4e4, 0.0), (360e3, 8e4, 1.0)):
        for _ in range(900):
            drag.update(hook_load, weight, 0.1, 1.0, 0.1)
        assert drag.drag == pytest.approx(460e3 - hook_load - weight, abs=500.0)
        assert drag.transmitted_share(limit) == arriving


def test_jolt_of_the_first_samples_is_not_tared():
    drag = DragMonitor(RIG, 0.235, 8e4)
    for k in range(200):
        drag.tare(1600e3 if k < 5 else 460e3, 0.1)
    drag.update(460e3, 0.0, 0.1, 1.0, 0.1)
    assert drag.drag == 0.0


@pytest.mark.parametrize(("drag", "share"), [(20e3, 1.0), (70e3, None), (200e3, 0.2)])
def test_drag_takes_weight_off_its_limit(drag, share):
    """All the drag that rocking was seen to let go at once has room below the weight limit."""
    block = BlockControl(RIG, SlideSettings())
    block.drag.start_tared(460e3)
    for _ in range(900):
        block.update_drag(460e3 - 4e4 - drag, 4e4 / block.auto_driller.weight_per_pressure, STRING, 1.0, 0.1)
    allowed = block.allowed_pressure * block.auto_driller.weight_per_pressure
    if share is None:
        assert 0.9 * block.weight_limit < allowed + LET_GO_SHARE * drag < block.weight_limit
    else:
        assert allowed == pytest.approx(share * block.target_weight_on_bit)


def test_weight_that_comes_on_shows_before_its_average():
    drag = DragMonitor(RIG, 0.235, 8e4)
    drag.start_tared(460e3)
    for sample in range(200):
        drag.update(460e3 - 5e2 * sample, 0.0, 0.1, 1.0, 0.1)
    assert drag.smooth_deficit < 50e3 < 75e3 < drag.highest_deficit < 100e3


def test_drag_lower_bound_subtracts_weight_uncertainty():
    """In a short well the uncertainty is as large as the drag."""
    drag = DragMonitor(RIG, 0.235, 8e4)
    drag.tare(460e3, 0.1)
    for sigma in (0.0, 0.12):
        drag.update(460e3 - 8e4 - 3e4, 8e4, sigma, 1.0, 0.1)
        open_share = math.hypot(sigma, 0.1) * 8e4 / 3e4
        assert drag.share_lower_bound == pytest.approx(drag.share * (1.0 - open_share))


@pytest.mark.parametrize(("falling", "lifted"), [(0.2, True), (0.03, True), (0.0, False), (-0.2, False)])
def test_slipping_block_is_lifted_back(falling, lifted):
    """The block falls (m/s) for 10 s beyond its command of 2.5 mm/s, and is lifted at 0.2 m/s."""
    slip, block, furthest = BlockSlipInterlock(), 0.0, 0.0
    for k in range(400):
        lift = slip.update(block, 0.0025, 0.1)
        block += 0.1 * (0.0025 + (falling if 100 <= k < 200 else 0.0) - (0.2 if lift else 0.0))
        furthest = max(furthest, block - 0.1 * (k + 1) * 0.0025)
    assert (slip.slips > 0) == lifted
    if lifted:
        assert furthest < 0.17
        assert block - 40.0 * 0.0025 < 0.2


def test_sensor_faults_are_no_block_slip():
    slip = BlockSlipInterlock()
    waves = [0.2 * math.sin(2.0 * math.pi * 0.1 * k / 8.0) for k in range(200)]   # asked for, and made 0.2 s later
    readings = [5.0, math.nan, 0.3, 0.0, *(waves[max(k - 2, 0)] for k in range(200))]
    commanded = [0.0, 0.0, 0.0, 0.0, 0.0, *(np.diff(waves) / 0.1)]
    for reading, speed in zip(readings, commanded, strict=True):
        assert not slip.update(reading, speed, 0.1)
    assert slip.slips == 0


def lock_up_after(lock, drag, pressure, seconds):
    for _ in range(round(10.0 * seconds)):
        lock.update(drag, pressure, 1.8e6, 0.1)
    return lock.state


def test_drag_that_may_let_go_does_not_stop_lowering():
    """A short string has less drag than the bit may carry: it slides on while that leaves most of the weight."""
    block = BlockControl(RIG, SlideSettings())
    limit = block.weight_limit
    weight = 0.7 * block.target_weight_on_bit
    block.drag.tare(460e3, 0.1)
    for drag, arriving in ((0.8 * (limit - weight), 1.0), (1.6 * (limit - weight), 0.0)):
        block.drag._full_drag = drag / 0.7
        for _ in range(900):
            block.drag.update(460e3 - weight - drag, weight, 0.1, 1.0, 0.1)
            block.update_lock_up(0.5 * block.target_pressure, 0.1)
        assert block.drag.share == pytest.approx(0.7, rel=1e-2)
        assert block.drag.transmitted_share(limit) == pytest.approx(arriving, abs=0.1)
        assert block.lock_up.stops == (arriving == 0.0)


def test_lock_up_reduces_weight_then_latches():
    lock = LockUpInterlock()
    assert lock_up_after(lock, 0.7, 1.7e6, 600.0) is LockUpState.FREE, "weight arrives"
    assert lock_up_after(lock, 0.3, 0.9e6, 600.0) is LockUpState.FREE, "low drag holds no weight"
    for trip, share in ((1, 0.9), (2, 0.81)):
        assert lock_up_after(lock, 0.7, 0.9e6, 21.0) is LockUpState.HELD and lock.stops
        assert lock.share_left == pytest.approx(share) and lock.trips == trip
        assert lock_up_after(lock, 0.5, 0.9e6, 60.0) is LockUpState.HELD, "not freed yet"
        assert lock_up_after(lock, 0.2, 0.9e6, 20.0) is LockUpState.HELD, "not freed for long enough"
        assert lock_up_after(lock, 0.2, 0.9e6, 11.0) is LockUpState.LESS and not lock.stops
    assert lock_up_after(lock, 0.7, 0.9e6, 21.0) is LockUpState.LATCHED
    assert lock_up_after(lock, 0.0, 1.8e6, 3600.0) is LockUpState.LATCHED and lock.stops, "a latch stays without drag"
    lock.release()
    assert lock.state is LockUpState.FREE and lock.share_left == 1.0


def test_lock_up_not_freed_by_rocking_latches():
    lock = LockUpInterlock()
    assert lock_up_after(lock, 0.7, 0.9e6, 300.0) is LockUpState.LATCHED
    assert lock.never_freed and lock.trips == 1


def test_moderate_drag_trips_lock_up_later():
    assert lock_up_after(LockUpInterlock(), 0.45, 0.9e6, 110.0) is LockUpState.FREE
    assert lock_up_after(LockUpInterlock(), 0.45, 0.9e6, 181.0) is LockUpState.HELD
    assert lock_up_after(LockUpInterlock(), math.nan, 0.9e6, 600.0) is LockUpState.FREE


def test_drag_holds_back_lowering():
    driller = AutoDriller(RIG, 20.0, 0.1)
    free = [driller.update(0.5e6, 1.8e6, 1e5, 0.1) for _ in range(100)]
    hung = AutoDriller(RIG, 20.0, 0.1)
    held = [hung.update(0.5e6, 1.8e6, 1e5, 0.1, transmitted_share=0.0) for _ in range(100)]
    assert held[-1] == pytest.approx(min(hung.speed_per_pressure * 0.5e6, held[0])) and free[-1] > held[-1]
    assert hung.setpoint == 0.0 and driller.setpoint == pytest.approx(1e6)
    driller.track(0.3e6)
    assert driller.setpoint == 0.3e6


def test_toolface_left_of_target_reduces_load():
    """Only to the left: reactive torque turns the toolface left, and so corrects an error to the right."""
    degrees = (-90.0, 0.0, 8.0, 10.5, 13.0, 18.0, 90.0)
    shares = [load_share_for_tool_face(math.radians(behind)) for behind in degrees]
    assert shares == pytest.approx([1.0, 1.0, 1.0, 0.5, 0.0, -1.0, -1.0])
    driller = AutoDriller(RIG, 20.0, 0.1)
    risen = [driller.update(0.5e6, 1.8e6, 1e5, 0.1) for _ in range(100)]
    reached = driller.setpoint
    taken = [driller.update(0.5e6, 1.8e6, 1e5, 0.1, transmitted_share=-1.0) for _ in range(50)]
    assert reached == pytest.approx(1e6) and driller.setpoint == reached
    assert taken[-1] < driller.speed_per_pressure * 0.5e6 < risen[-1]


def test_pressure_tare_ignores_drilling():
    for extra, tared in ((3e5, True), (1.8e6, False)):
        pressure = DifferentialPressure(RIG, 0.0, 0.5, 5.0)
        for _ in range(400):
            pressure.tare(1.8e7 + extra, 0.032 / 0.0026, 0.1)
        pressure.update(1.8e7 + extra + 1e6, 0.032 / 0.0026, 100.0)
        assert pressure.smooth == pytest.approx(1e6 + (0.0 if tared else extra), rel=0.01)


def test_return_to_bottom_rests_above_touching_point():
    """At 80 kN on 1e5 N/m the bit touches 0.8 m higher; a short slip of 0.6 m hardly moves that point."""
    approach, pressure = ReturnToBottom(1e5, 0.04), 2e6
    for k in range(3000):
        approach.update_touching_position(10.0 + 2.5e-4 * k, pressure, 0.1)
    end = 10.0 + 2.5e-4 * 3000
    for _ in range(50):
        approach.update_touching_position(end + 0.6, pressure, 0.1)
    approach.pick_up()
    assert approach.speed(end - 2.8, 0.1, 0.5, 0.1) == 0.1 and approach.fast
    position = end - 2.8
    while approach.speed(position, 0.1, 0.5, 0.1) > 0.0:
        position += 0.1 * approach.speed(position, 0.1, 0.5, 0.0)
    assert position == pytest.approx(end - 0.8 - 0.25, abs=0.12)
    assert not approach.fast and approach.under_way
    assert approach.speed(position, 0.1, 0.1, 0.1) > 0.0


def test_return_to_unknown_bottom_creeps():
    assert ReturnToBottom(1e5, 0.04).speed(0.0, 0.1, 0.0, 0.1) < 0.01


def test_heave_is_found_and_cancelled():
    """A wave of 0.15 m on a string three times as stiff as assumed, with rocking at 4 s and a drifting load."""
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


def test_rocking_is_not_heave():
    """Rocking changes the hook load twice per cycle."""
    heave, random = HeaveCompensator(1e5, 0.2), np.random.default_rng(2)
    for k in range(3000):
        load = 4e5 + 1e4 * math.sin(2.0 * math.pi * 0.1 * k / 6.0) + random.normal(0.0, 4e3)
        assert heave.update(load, 12.0, True, 0.1) == 0.0
    assert math.isnan(heave.period)


@pytest.mark.parametrize("rocking", [8.3, 9.0])
def test_heave_near_rocking_period_is_found(rocking):
    """Slightly faster than the wave, and at the period of the wave."""
    heave, moved, loads, random = HeaveCompensator(1.8e5, 0.2), 0.0, [], np.random.default_rng(2)
    for k in range(4000):
        time = 0.1 * k
        load = 4e5 - 1.8e5 * (0.05 * math.sin(2.0 * math.pi * time / 9.0) + moved)
        loads.append(load)
        load += 2e3 * math.sin(4.0 * math.pi * time / rocking) + random.normal(0.0, 4e3)
        moved += 0.1 * heave.update(load, rocking, True, 0.1)
    assert heave.period == pytest.approx(9.0, rel=0.02)
    assert np.std(loads[-500:]) < 0.25 * np.std(loads[:500])
