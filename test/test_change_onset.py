"""A later log that begins before the change: the change finds the string in the state that it has there."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from short_well import coarse_meshes, routine_slide, short_rig

from slider_drilling.api.what_changed import windows_at
from slider_drilling.diagnosis import prediction_noise
from slider_drilling.diagnosis.baseline import candidates_for_change, fit_baseline
from slider_drilling.diagnosis.build_model import build_model as model_of
from slider_drilling.diagnosis.change_search import TriedChange, under_their_names
from slider_drilling.diagnosis.changed_string import ChangedString, compared_around
from slider_drilling.diagnosis.diagnose_change import diagnose_change
from slider_drilling.diagnosis.onset import Onset
from slider_drilling.diagnosis.rig_changes import RIG_CHANGES
from slider_drilling.diagnosis.usual_error import usual_gaps
from slider_drilling.errors import InputError
from slider_drilling.gap.model import Parameter, SimulationOptions
from slider_drilling.gap.problem.noise import NoiseFloor
from slider_drilling.gap.problem.problem import build_problem
from slider_drilling.gap.search.least_squares import Fit
from slider_drilling.log.time_window import cut_time_window
from slider_drilling.twin.ask import Windows

BIAS = 800.0


@pytest.fixture(scope="module", autouse=True)
def coarse():
    with coarse_meshes():
        yield


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    """A routine slide of 220 s, in which the torque reading is off from 150 s on."""
    whole = routine_slide(tmp_path_factory.mktemp("onset") / "slide.mcap", short_rig(), 3, 220.0)
    drive = whole.top_drive
    return replace(whole, top_drive=replace(drive, effort=drive.effort + BIAS * (drive.time > 150.0)))


@pytest.fixture(scope="module")
def baseline(log):
    return fit_baseline([cut_time_window(log, 0.0, 150.0)], short_rig())


def test_reading_that_goes_off_within_the_log_is_named(log, baseline):
    found = diagnose_change(
        baseline, [cut_time_window(log, 100.0, 220.0)], short_rig(), whole=(True, False), onset=Onset(48.0, 52.0)
    )
    assert found.effects == ("torque_sensor_bias",) and found.change.growing is False
    low, high = found.tuned_parameters["torque_sensor_bias.bias"].interval
    assert low < BIAS < high
    # The error as given is that of the samples since, one of the noise more than BIAS.
    torque = next(trace for trace in found.traces if trace.channel == "surface_torque")
    missed = (torque.measured - torque.simulated["nominal"])[torque.time >= 52.0]
    assert found.gap.rms["surface_torque"].nominal == pytest.approx(np.sqrt(np.mean(missed**2)))


def _stop():
    raise InputError("far enough")


def test_onset_behind_an_operation_is_not_used(log, baseline, monkeypatch):
    from slider_drilling.diagnosis import diagnose_change as module

    monkeypatch.setattr(module, "is_calm", lambda *arguments: False)
    later, seen = cut_time_window(log, 100.0, 220.0), []
    monkeypatch.setattr(module, "search_change", lambda model, baseline: seen.append(model) or _stop())
    with pytest.raises(InputError, match="far enough"):
        diagnose_change(baseline, [later], short_rig(), whole=(True, False), onset=Onset(48.0, 52.0))
    (model,) = seen
    assert model.onset is None and model.runs[0].duration == pytest.approx(120.0 - 52.0, abs=0.3)


@pytest.fixture(scope="module")
def changed(log):
    """The model of the last two minutes with a change between 48 and 52 s of them."""
    string = model_of([cut_time_window(log, 100.0, 220.0)], short_rig()).model
    onset = Onset(48.0, 52.0)
    return ChangedString(compared_around(string, onset), {}, string.nuisance, string.effects, onset=onset)


def _simulated(model, names, growing=False, **values):
    effects = [effect for effect in model.effects if effect.name in names]
    changed = model.changed_in(effects, growing, {})
    rows = changed.simulate(0, [{}, {name.replace("__", "."): value for name, value in values.items()}],
                            SimulationOptions())  # fmt: skip
    return rows["surface_torque"]


def test_what_changes_is_as_before_until_the_onset(changed):
    time = next(own.time for own in changed.runs[0].channels if own.name == "surface_torque")
    as_before, biased = _simulated(changed, ("torque_sensor_bias",), torque_sensor_bias__bias=500.0)
    np.testing.assert_allclose(biased - as_before, np.where(time <= 48.0, 0.0, 500.0))
    _, grown = _simulated(changed, ("torque_sensor_bias",), growing=True, torque_sensor_bias__bias=500.0)
    share = np.clip((time - 50.0) / (changed.runs[0].duration - 50.0), 0.0, 1.0)
    np.testing.assert_allclose(grown - as_before, 500.0 * share, atol=1e-6)


def test_what_does_not_change_holds_from_the_start(changed):
    as_before, biased = _simulated(changed, ("stribeck",), torque_sensor_bias__bias=500.0)
    np.testing.assert_allclose(biased - as_before, 500.0)


def test_what_the_rig_had_all_along_is_as_large_before_a_change(changed):
    """A standing bias of 200, calibrated to 250, that becomes 500."""
    effects = [effect for effect in changed.effects if effect.name == "torque_sensor_bias"]
    standing = replace(changed, shared={"torque_sensor_bias.bias": 200.0})
    model = standing.changed_in(effects, False, {"torque_sensor_bias.bias": 250.0})
    sets = [{"torque_sensor_bias.bias": 250.0}, {"torque_sensor_bias.bias": 500.0}]
    still, more = model.simulate(0, sets, SimulationOptions())["surface_torque"]
    time = next(own.time for own in changed.runs[0].channels if own.name == "surface_torque")
    np.testing.assert_allclose(more - still, np.where(time <= 48.0, 0.0, 250.0))


def test_nobody_knows_of_what_is_within_the_onset_interval(changed):
    for channel in changed.runs[0].channels:
        assert not np.any((channel.time > 48.0) & (channel.time < 52.0)) and channel.time.size > 10


def test_errors_count_the_samples_since_the_change_alone(changed):
    problem = build_problem(changed, [{channel.name: 1.0 for channel in changed.runs[0].channels}])
    residual = np.zeros(problem.size)
    for piece in problem.pieces:
        residual[piece.rows] = np.where(piece.channel.time < 50.0, 7.0, 2.0)
    assert set(usual_gaps(problem, residual).values()) == {2.0}


@pytest.mark.parametrize(("fitted", "name", "gain"), [(-0.05, "washout", 60.0), (0.05, "plugged_nozzle", 60.0)])
def test_sign_of_a_pressure_change_is_its_name(fitted, name, gain):
    """The same fit under the name that its sign has, and of two with one name the better."""
    effects = {each.name: each for each in candidates_for_change((), (), {})}
    values = {"pressure_gain": 1.01}

    def tried(candidate, value, gain):
        parameter = effects[candidate].parameters[0]
        parameters = (Parameter("pressure_gain", 1.0, 0.8, 1.2, 0.005), parameter)
        found = Fit(values | {parameter.name: value}, parameters, np.zeros(2), np.zeros(2),
                    np.array([[1.0, 1.0], [2.0, -4.0]]), 10.0, {}, True, False)  # fmt: skip
        return TriedChange(effects[candidate], False, None, found, gain)

    other = tried("washout" if name == "washout" else "plugged_nozzle", 0.01, 20.0)
    (best,) = under_their_names([tried("plugged_nozzle", fitted, gain), other], list(effects.values()))
    assert best.effect.name == name and best.gain == gain
    assert best.fit.values == values | {RIG_CHANGES[name].parameter: 0.05}
    assert [each.name for each in best.fit.parameters] == ["pressure_gain", RIG_CHANGES[name].parameter]
    np.testing.assert_array_equal(best.fit.jacobian[1], [-2.0, 4.0] if name == "washout" else [2.0, -4.0])


def test_a_unit_of_error_is_that_of_predicting_the_rig_itself(log, monkeypatch):
    """Parts of its own log that calibrated numbers predict within twice the noise make the unit so large."""
    sizes = iter([3.0, 1.0])
    noise = {"surface_torque": NoiseFloor(50.0, "declared", 50.0, None)}
    monkeypatch.setattr(prediction_noise, "fit_start_state", lambda problem: SimpleNamespace(residual=None))
    monkeypatch.setattr(prediction_noise, "usual_gaps", lambda problem, residual: {"surface_torque": next(sizes)})
    long_enough = [cut_time_window(log, 0.0, 210.0)]
    found = prediction_noise.prediction_noise(long_enough, short_rig(), noise, {})["surface_torque"]
    assert found.sigma == pytest.approx(50.0 * np.sqrt(5.0)) and found.method == "baseline"
    monkeypatch.setattr(prediction_noise, "calm_share", lambda part, rig: 0.6)  # an operation takes much of each
    assert prediction_noise.prediction_noise(long_enough, short_rig(), noise, {}) == noise
    monkeypatch.undo()
    # Too short to be cut.
    assert prediction_noise.prediction_noise([cut_time_window(log, 0.0, 190.0)], short_rig(), noise, {}) == noise


def test_string_is_not_simulated_through_a_long_time_in_which_it_may_have_changed():
    close, far = (Windows((0.0, 600.0), (start, 1000.0)).onset_from(0.0) for start in (830.0, 850.0))
    assert close == Onset(600.0, 830.0) and close.simulated_from == 480.0
    assert far == Onset(600.0, 850.0) and far.simulated_from == 850.0


def test_time_of_a_change_that_a_user_gives(log):
    windows = windows_at(log, 150.0)
    assert (windows.before, windows.after) == ((0.0, 150.0), (150.0, log.end))
    assert windows.onset_from(0.0) == Onset(150.0, 150.0) and windows.onset_from(0.0).simulated_from == 30.0
    assert windows_at(log, 70.0).onset_from(0.0).simulated_from == 0.0
