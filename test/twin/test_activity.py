import numpy as np
import pytest

from slider_drilling.drillstring import Commands
from slider_drilling.rig import load_rig
from slider_drilling.twin.activity import ActivityMonitor


def _run(rig, speed, seconds, pump=1.0, block_speed=0.0, weight=5e4):
    """Activities, one a second; each of the last five may be a function of the time in s."""
    monitor, found, angle, block = ActivityMonitor(rig), [], 0.0, 0.0
    reference = rig.hydraulics.reference_flow / rig.mud_pump.displacement
    for second in range(seconds):
        time = second + 0.1 * np.arange(10)
        speeds = np.array([speed(t) for t in time])
        angles = angle + np.cumsum(speeds) * 0.1
        lowered = block_speed(second) if callable(block_speed) else block_speed
        blocks = block + lowered * 0.1 * np.arange(1, 11)
        angle, block = float(angles[-1]), float(blocks[-1])
        flow = reference * (pump(second) if callable(pump) else pump)
        commands = Commands(time, angles, speeds, blocks, np.full(10, lowered), np.full(10, flow))
        found.append(monitor.update(commands, weight(second) if callable(weight) else weight))
    return found


@pytest.fixture(scope="module")
def rig(request):
    return load_rig(request.config.rootpath / "config" / "rig.example.yaml")


def _rocking(time):
    return 5.0 * np.sign(np.sin(2.0 * np.pi * time / 8.0))


def test_rocking_settles_and_shows_its_period(rig):
    found = _run(rig, _rocking, 200)
    assert not found[30].settled and found[30].why == "rocking has just begun"
    assert found[-1].mode == "rocking" and found[-1].settled
    assert found[-1].period == pytest.approx(8.0, abs=0.3)


def test_parked_drive_takes_back_what_it_showed(rig):
    found = _run(rig, lambda t: _rocking(t) if t < 160.0 else 0.0, 260)
    parked = next(index for index, activity in enumerate(found) if activity.mode == "parked")
    assert 165 <= parked <= 172
    assert found[parked].valid_until == pytest.approx(160.0, abs=0.2)
    assert not found[parked + 10].settled and found[-1].settled
    assert found[-1].stretch > found[150].stretch


def test_steady_rotation_is_turning(rig):
    found = _run(rig, lambda t: _rocking(t) if t < 160.0 else 6.0, 200)
    assert found[-1].mode == "turning"
    assert not found[-1].settled


def test_flow_step_unsettles_for_a_minute(rig):
    found = _run(rig, _rocking, 320, pump=lambda s: 1.0 if s < 200 else 0.9)
    assert found[198].settled
    assert not found[201].settled and found[201].why == "the flow has changed"
    assert found[275].settled


def test_pick_up_unsettles(rig):
    found = _run(rig, _rocking, 240, block_speed=lambda s: 0.002 if s < 200 else -0.05)
    assert found[198].settled and found[207].why == "the string was picked up"
    assert found[198].comparable and not found[207].comparable
    assert min(activity.valid_until for activity in found[200:207]) < 200.0


@pytest.mark.parametrize(("changes", "mode"), [({"pump": 0.0}, "pump off"), ({"weight": 0.0}, "off bottom")])
def test_nothing_is_calibrated_off_bottom(rig, changes, mode):
    found = _run(rig, _rocking, 200, **changes)
    assert found[-1].mode == mode and not found[-1].settled


def test_steering_unsettles_until_it_is_over(rig):
    found = _run(rig, lambda t: _rocking(t) + (0.4 if 200.0 < t < 240.0 else 0.0), 330)
    assert found[198].settled
    assert any(activity.why == "the centre of the rocking moves" for activity in found[210:260])
    assert found[-1].settled


def test_steering_moves_the_centre_and_rocking_does_not(rig):
    found = _run(rig, lambda t: 5.0 * np.sin(2.0 * np.pi * t / 8.0) + (0.4 if 200.0 < t < 210.0 else 0.0), 300)
    assert 2.0 < found[-1].steering - found[198].steering < 6.0
    assert found[198].steering - found[100].steering < 0.5


def test_load_is_a_share_of_the_largest(rig):
    found = _run(rig, _rocking, 300, weight=lambda s: 5e4 if s < 200 else 2.5e4)
    assert found[198].load == pytest.approx(1.0, abs=0.01) and found[-1].load == pytest.approx(0.5, abs=0.01)


def test_bit_that_hardly_drills_is_not_compared(rig):
    found = _run(rig, _rocking, 400, weight=lambda s: 5e4 if not 200 <= s < 300 else 4e3)
    assert found[198].comparable and found[280].mode == "hardly loaded" and not found[280].comparable
    assert found[-1].comparable and found[-1].stretch > found[198].stretch


def test_wider_swing_than_ever_is_other_work(rig):
    def wider(time):
        return _rocking(time) * (1.3 if 200.0 <= time < 240.0 or time >= 320.0 else 1.0)

    found = _run(rig, wider, 400)
    assert found[198].comparable and any(a.why == "the drive swings wider than before" for a in found[205:225])
    assert found[310].comparable and found[335].stretch == found[310].stretch


def _period(before, after, changed=200.0):
    """Rocking at 5 rad/s with strokes of half the one period, then of half the other."""
    return lambda t: 5.0 * np.sign(np.sin(2.0 * np.pi * (t - changed) / (before if t < changed else after)))


def test_period_follows_another_way_of_rocking(rig):
    found = _run(rig, _period(8.0, 20.0), 330)
    assert found[198].period == pytest.approx(8.0, abs=0.3) and found[235].period == pytest.approx(20.0, abs=0.5)
    assert all(each.mode == "rocking" for each in found[20:])
    assert found[-1].settled and found[-1].pace == pytest.approx(np.log(20.0), abs=0.03)


def test_one_long_stroke_keeps_the_period(rig):
    found = _run(rig, lambda t: 5.0 if 200.0 < t < 207.0 else _rocking(t), 300)
    assert all(each.period == pytest.approx(8.0, abs=0.5) for each in found[100:])


def test_longer_stroke_than_the_last_ones_is_no_rotation_for_long(rig):
    found = _run(rig, _period(12.0, 34.0), 330)
    assert sum(each.mode == "turning" for each in found[20:]) <= 6
    assert {each.mode for each in found[240:]} == {"rocking"}


def test_drill_pipe_that_rocks_in_other_ways_all_the_time_drills(rig):
    found = _run(rig, lambda t: (1.0 + 0.3 * (t // 40.0)) * _rocking(t), 330)
    assert not any(each.settled for each in found[130:]) and all(each.drilling for each in found[130:])


def test_wave_of_the_block_is_no_pick_up(rig):
    found = _run(rig, _rocking, 300, block_speed=lambda s: 0.06 * np.sin(2.0 * np.pi * s / 10.0))
    assert all(activity.comparable for activity in found[100:])


def test_momentary_lift_ends_no_stretch(rig):
    found = _run(rig, _rocking, 260, weight=lambda s: 0.0 if s in (200, 201, 202) else 5e4)
    assert found[-1].stretch == found[190].stretch


def test_work_is_comparable_before_it_is_calibrated(rig):
    found = _run(rig, _rocking, 320, pump=lambda s: 1.0 if s < 200 else 0.9)
    assert not found[215].comparable
    assert found[245].comparable and not found[245].settled


def _off_bottom(second):
    return 0.0 if 100 <= second < 200 else 5e4


def test_circulation_off_bottom_is_seen_until_the_bit_may_have_touched(rig):
    found = _run(rig, _rocking, 300, weight=_off_bottom)
    off = [index for index, activity in enumerate(found) if activity.circulating]
    assert 115 <= off[0] <= 145 and off[-1] == 199 and found[198].hanging and found[198].circulation_known
    assert found[200].circulation_known and not found[200].circulating
    assert found[200].valid_until == pytest.approx(186.0, abs=2.0)


def test_circulation_is_judged_at_its_end_where_the_bit_is_lowered(rig):
    found = _run(rig, _rocking, 300, block_speed=0.01, weight=_off_bottom)
    assert not any(activity.hanging for activity in found)
    assert [index for index, activity in enumerate(found) if activity.circulation_known] == [200]
