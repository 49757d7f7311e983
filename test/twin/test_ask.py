import pytest

from slider_drilling.twin.ask import windows_of_change


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
