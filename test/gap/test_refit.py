"""Refits of the current model and of candidates from other starts."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pytest
from toy import EFFECTS, TIME, Toy, force, toy

from slider_drilling.gap import Parameter, SimulationOptions
from slider_drilling.gap.problem.noise import noise_floors
from slider_drilling.gap.search.least_squares import fit
from slider_drilling.gap.search.race import parameters_of
from slider_drilling.gap.selection.calibration import calibrate
from slider_drilling.gap.selection.refit import (
    finish_and_cross_validate,
    improve_incumbent,
    refit_from_incumbent,
    refit_from_scattered_nuisance,
)

PITCH = Parameter("pitch", 0.0, -9.0, 9.0, 0.1)
TRUE = 3.0


@dataclass(frozen=True)
class Tone(Toy):
    """A tone whose pitch is fitted: off by more than a cycle over the log, it has a local optimum for every cycle."""

    nuisance: tuple[Parameter, ...] = (PITCH,)

    def simulate(
        self, run: int, sets: Sequence[Mapping[str, float]], options: SimulationOptions
    ) -> Mapping[str, np.ndarray]:
        return {"force": np.stack([force(values) + tone(values.get("pitch", 0.0)) for values in sets])}


def tone(pitch: float) -> np.ndarray:
    return 6.0 * np.sin(2.0 * np.pi * TIME / 12.0 * (1.0 + 0.02 * pitch))


@pytest.fixture
def known():
    """A state whose pitch is in the wrong optimum, and an effect that there is nothing of, fitted in the right one."""
    model = Tone(toy({}, 5, extra=tone(TRUE)).runs)
    floors = noise_floors(model.runs)
    state = calibrate(model, EFFECTS, floors, ({},), 0, lambda stage, share: None)
    free, folds = state.modes[0], state.bootstrap.folds
    wrong = finish_and_cross_validate(free, (), fit(free, parameters_of(free, ()), {"pitch": -1.5}), folds)
    effect = (EFFECTS[0],)
    leader = finish_and_cross_validate(
        free, effect, fit(free, parameters_of(free, effect), {"pitch": TRUE + 0.1, "sine": 0.5}), folds
    )
    return replace(state, calibrated=wrong, current=wrong), leader


def test_finished_model_has_the_slopes_of_its_end(known):
    """Intervals of its parameters, its replicates and the screen of further effects rest on them."""
    state, leader = known
    for model in (state.current, leader):
        there = fit(model.problem, model.fit.parameters, model.fit.values, iterations=0).jacobian
        assert model.fit.jacobian == pytest.approx(there, abs=1e-9)


def test_incumbent_moves_to_a_better_optimum(known):
    state, leader = known
    assert state.current.score.gap > 2.0 > 1.2 > leader.score.gap
    better = improve_incumbent(state, leader, EFFECTS, seed=0)
    assert better.current is better.calibrated
    assert better.current.fit.values["pitch"] == pytest.approx(TRUE, abs=0.1)
    assert better.current.score.gap == pytest.approx(1.0, abs=0.1) and better.adequacy.within_thresholds


def test_incumbent_stays_where_no_start_is_better(known):
    state, leader = known
    right = improve_incumbent(state, leader, EFFECTS, seed=0)
    assert improve_incumbent(right, leader, EFFECTS, seed=0) is right


def test_scattered_nuisance_leads_out_of_a_wrong_optimum(known):
    state, _ = known
    free, folds, effect = state.modes[0], state.bootstrap.folds, (EFFECTS[0],)
    start = {"pitch": -3.0, "sine": 0.5}
    wrong = finish_and_cross_validate(free, effect, fit(free, parameters_of(free, effect), start), folds)
    assert wrong.score.gap > 2.0
    right = refit_from_scattered_nuisance(free, wrong, folds)
    assert right is not None and right.names == wrong.names
    assert right.fit.values["pitch"] == pytest.approx(TRUE, abs=0.1)
    assert right.score.gap == pytest.approx(1.0, abs=0.1)
    assert refit_from_scattered_nuisance(free, right, folds) is None


@pytest.mark.parametrize("there_is", [0.0, 3.0])
def test_larger_model_is_refitted_from_the_smaller_one(there_is):
    """A sine fitted at the wrong pitch, beside a calibration at the right one."""
    model = Tone(toy({"sine": there_is}, 5, extra=tone(TRUE)).runs)
    floors = noise_floors(model.runs)
    state = calibrate(model, EFFECTS, floors, ({},), 0, lambda stage, share: None)
    free, folds, effect = state.modes[0], state.bootstrap.folds, (EFFECTS[0],)
    right = finish_and_cross_validate(free, (), fit(free, parameters_of(free, ()), {"pitch": TRUE}), folds)
    state = replace(state, calibrated=right, current=right)
    wrong = finish_and_cross_validate(
        free, effect, fit(free, parameters_of(free, effect), {"pitch": -3.0, "sine": 0.5}), folds
    )
    assert wrong.fit.cost > right.fit.cost
    again = refit_from_incumbent(state, wrong)
    assert again.names == wrong.names
    if there_is:
        assert again.fit.values["sine"] == pytest.approx(there_is, abs=0.5)
        assert again.fit.cost < right.fit.cost
        assert refit_from_incumbent(state, again) is again
    else:
        assert again is wrong, "nothing is gained from there: not worth finishing"
