"""A rig whose numbers become others while it runs."""

from dataclasses import replace

import numpy as np
import pytest
from short_well import short_rig

from slider_drilling.blind.manoeuvres import steady
from slider_drilling.drillstring import Switch, simulate_batch
from slider_drilling.drillstring.kernel_arrays import CHANNELS
from slider_drilling.effects import effects_with

ELEMENTS, AT = 20, 30.0


@pytest.fixture(scope="module")
def commands():
    return steady(np.random.default_rng(4), short_rig(), 60.0)


def _simulated(rig, commands, switch, single=False):
    (response,) = simulate_batch([rig], commands, ELEMENTS, single_precision=single, switch=switch)
    return {name: getattr(response, name) for name in CHANNELS}


@pytest.mark.parametrize("single", [False, True])
def test_rig_that_becomes_itself_runs_on(commands, single):
    rig = short_rig()
    unswitched, switched = (_simulated(rig, commands, own, single) for own in (None, Switch(AT, [rig])))
    for name, values in unswitched.items():
        np.testing.assert_array_equal(switched[name], values)


def test_rig_is_the_other_one_from_the_switch_on(commands):
    rig = short_rig()
    thin = replace(rig, hydraulics=replace(rig.hydraulics, reference_pressure=0.9 * rig.hydraulics.reference_pressure))
    was, became = _simulated(rig, commands, None), _simulated(rig, commands, Switch(AT, [thin]))
    before, late = commands.time < AT, commands.time > AT + 20.0
    lost = was["standpipe_pressure"] - became["standpipe_pressure"]
    np.testing.assert_array_equal(lost[before], 0.0)
    np.testing.assert_allclose(lost[late], 0.1 * rig.hydraulics.reference_pressure, rtol=0.01)
    np.testing.assert_array_equal(was["surface_torque"], became["surface_torque"])


def test_string_keeps_its_state_when_friction_changes(commands):
    """Torque goes on from where it was, and more friction needs more of it."""
    rig = short_rig()
    rough = replace(rig, effects=effects_with(viscous_drag={"coefficient": 40.0}))
    smooth, became = _simulated(rig, commands, None), _simulated(rig, commands, Switch(AT, [rough]))
    at = int(np.searchsorted(commands.time, AT))
    step = np.abs(np.diff(smooth["surface_torque"])).max()
    assert abs(became["surface_torque"][at] - became["surface_torque"][at - 1]) < 2.0 * step
    after = slice(at + 50, None)
    assert np.abs(became["surface_torque"][after]).mean() > 1.02 * np.abs(smooth["surface_torque"][after]).mean()
