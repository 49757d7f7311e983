"""The sensitivity study names constants of the engine as strings."""

import pytest

from slider_drilling.benchmarks.sensitivity import CONSTANTS, constant_set_to


@pytest.mark.parametrize("constant", CONSTANTS, ids=lambda constant: f"{constant.module}.{constant.name}")
def test_constant_exists_and_is_restored(constant):
    with constant_set_to(constant, constant.values[0]) as usual:
        assert usual not in constant.values
    with constant_set_to(constant, constant.values[0]) as restored:
        assert restored == usual
