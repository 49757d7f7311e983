"""Times of a rig's clock in words."""

import pytest

from slider_drilling.clock_time import time_of_day


@pytest.mark.parametrize(("seconds", "words"), [
    (1203.4, "1203 s"), (0.0, "0 s"), (1700000060.0, "22:14:20 UTC"), (946684800.0, "00:00:00 UTC"),
])  # fmt: skip
def test_clock_with_a_date_gives_the_time_of_day(seconds, words):
    assert time_of_day(seconds) == words
