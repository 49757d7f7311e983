"""The spreads of assumed numbers are priors of the diagnosis."""

from __future__ import annotations

import dataclasses

import pytest

from slider_drilling.api.rigs import load_rig
from slider_drilling.diagnosis.assumed_priors import with_assumed_spreads
from slider_drilling.diagnosis.nuisance import nuisance_parameters
from slider_drilling.diagnosis.rig_values import rig_with
from slider_drilling.gap.model import Parameter
from slider_drilling.rig import Assumption, Rig, check_rig

CHANNELS = ("surface_torque", "hook_load", "standpipe_pressure", "tool_face")
RIG = load_rig()


def assuming(**spreads: float) -> Rig:
    items = tuple(Assumption(key.replace("__", "."), spread) for key, spread in spreads.items())
    return dataclasses.replace(RIG, assumed=items)


def test_nothing_assumed_changes_nothing() -> None:
    names = {parameter.name for parameter in nuisance_parameters(RIG, CHANNELS)}
    assert not names & {"bit_aggressiveness", "motor_leak"}


def test_spread_over_value_is_the_prior() -> None:
    rig = dataclasses.replace(RIG, assumed=(Assumption("well.friction_intervals[1].factor", 0.3),
                                            Assumption("motor.torque_per_pressure", 0.2 * 1.6e-3)))  # fmt: skip
    parameters = {parameter.name: parameter for parameter in nuisance_parameters(rig, CHANNELS)}
    assert parameters["friction_2"].spread == pytest.approx(0.3)
    assert parameters["friction_1"].spread == 0.2
    gain = parameters["motor_gain"]
    assert gain.spread == pytest.approx(0.2)
    assert (gain.lower, gain.upper) == pytest.approx((0.4, 1.6))


@pytest.mark.parametrize(
    ("key", "name", "spread"),
    [("string__weight_factor", "string_weight", 0.03), ("bit__aggressiveness", "bit_aggressiveness", 0.1),
     ("motor__leak", "motor_leak", 0.06)],
)  # fmt: skip
def test_assumed_number_is_calibrated(key: str, name: str, spread: float) -> None:
    rig = assuming(**{key: spread})
    (parameter,) = (item for item in nuisance_parameters(rig, CHANNELS) if item.name == name)
    block, number = key.split("__")
    value = getattr(getattr(RIG, block), number)
    assert parameter.spread == pytest.approx(spread / value)
    for end in (parameter.lower, parameter.upper):
        fitted = rig_with(rig, {name: end})
        assert getattr(getattr(check_rig(fitted), block), number) == pytest.approx(end * value)
    assert name not in {item.name for item in nuisance_parameters(rig, ["surface_torque"])}


def test_lag_of_the_pressure_takes_its_spread() -> None:
    usual = Parameter("pressure_lag", 1.0, 0.3, 3.0, 0.05, spread=0.2)
    (lag,) = with_assumed_spreads([usual], assuming(hydraulics__lag=1.0))
    assert lag.spread == pytest.approx(1.0 / 1.5) and lag.lower == pytest.approx(0.1)
