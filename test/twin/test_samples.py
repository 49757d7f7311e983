import numpy as np

from slider_drilling.twin.samples import SampleBuffer


def _filled(kept: float = 1e9) -> SampleBuffer:
    buffer = SampleBuffer(kept)
    buffer.add(np.arange(5.0), np.arange(5.0))
    return buffer


def test_late_samples_are_put_in_order():
    buffer = _filled()
    buffer.add(np.array([2.5, 0.5]), np.array([7.0, 8.0]))
    assert buffer.time.tolist() == [0.0, 0.5, 1.0, 2.0, 2.5, 3.0, 4.0]
    assert buffer.value.tolist() == [0.0, 8.0, 1.0, 2.0, 7.0, 3.0, 4.0]


def test_second_sample_of_a_time_replaces():
    buffer = _filled()
    buffer.add(np.array([3.0]), np.array([9.0]))
    assert buffer.value.tolist() == [0.0, 1.0, 2.0, 9.0, 4.0]


def test_missing_values_are_left_out():
    buffer = _filled()
    buffer.add(np.array([5.0, 6.0]), np.array([np.nan, 1.0]))
    assert buffer.time.tolist()[-2:] == [4.0, 6.0]


def test_buffer_forgets_and_stays_bounded():
    buffer = SampleBuffer(100.0)
    for second in range(20_000):
        buffer.add(second + 0.1 * np.arange(10), np.zeros(10))
    assert 990 <= len(buffer) <= 1020
    assert buffer._time.size <= 8192
