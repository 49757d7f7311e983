"""What is known is held against a finalist from where that one got to, and an effect is fitted from other places."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pytest
from toy import EFFECTS, TIME, Toy, force, toy

from slider_drilling.gap import How, Parameter
from slider_drilling.gap.choice.forward import begin
from slider_drilling.gap.choice.refit import at_its_best, from_other_starts, no_less_likely, scored
from slider_drilling.gap.problem.noise import noise_floor
from slider_drilling.gap.search.least_squares import fit
from slider_drilling.gap.search.race import parameters_of

PITCH = Parameter("pitch", 0.0, -9.0, 9.0, 0.1)
TRUE = 3.0


@dataclass(frozen=True)
class Tone(Toy):
    """A tone whose pitch is tuned: off by more than a cycle over the log, it has a valley for every cycle."""

    nuisance: tuple[Parameter, ...] = (PITCH,)

    def simulate(self, run: int, sets: Sequence[Mapping[str, float]], how: How) -> Mapping[str, np.ndarray]:
        return {"force": np.stack([force(values) + tone(values.get("pitch", 0.0)) for values in sets])}


def tone(pitch: float) -> np.ndarray:
    return 6.0 * np.sin(2.0 * np.pi * TIME / 12.0 * (1.0 + 0.02 * pitch))


@pytest.fixture
def known():
    """A state whose pitch is in the wrong valley, and an effect that there is nothing of, fitted in the right one."""
    model = Tone(toy({}, 5, extra=tone(TRUE)).runs)
    floors = [{channel.name: noise_floor(channel) for channel in run.channels} for run in model.runs]
    state = begin(model, EFFECTS, floors, ({},), 0, lambda stage, share: None)
    free, folds = state.ways[0], state.blocks.folds
    wrong = scored(free, (), fit(free, parameters_of(free, ()), {"pitch": -1.5}), folds)
    effect = (EFFECTS[0],)
    leader = scored(free, effect, fit(free, parameters_of(free, effect), {"pitch": TRUE + 0.1, "sine": 0.5}), folds)
    return replace(state, tuned=wrong, current=wrong), leader


def test_the_better_valley_is_what_is_known_from_then_on(known):
    state, leader = known
    assert state.current.score.gap > 2.0 > 1.2 > leader.score.gap
    better = at_its_best(state, leader, EFFECTS, seed=0)
    assert better.current is better.tuned
    assert better.current.fit.values["pitch"] == pytest.approx(TRUE, abs=0.1)
    assert better.current.score.gap == pytest.approx(1.0, abs=0.1) and better.enough.within


def test_nothing_changes_where_the_leader_knows_no_better_place(known):
    state, leader = known
    right = at_its_best(state, leader, EFFECTS, seed=0)
    assert at_its_best(right, leader, EFFECTS, seed=0) is right


def test_an_effect_fitted_in_the_wrong_valley_is_found_in_the_right_one(known):
    state, _ = known
    free, folds, effect = state.ways[0], state.blocks.folds, (EFFECTS[0],)
    begun = {"pitch": -3.0, "sine": 0.5}
    wrong = scored(free, effect, fit(free, parameters_of(free, effect), begun), folds)
    assert wrong.score.gap > 2.0
    right = from_other_starts(free, wrong, folds)
    assert right is not None and right.names == wrong.names
    assert right.fit.values["pitch"] == pytest.approx(TRUE, abs=0.1)
    assert right.score.gap == pytest.approx(1.0, abs=0.1)
    assert from_other_starts(free, right, folds) is None


@pytest.mark.parametrize("there_is", [0.0, 3.0])
def test_what_contains_the_known_is_no_less_likely_than_it_where_there_is_something(there_is):
    """A sine fitted in the wrong valley of the pitch, beside a re-tuning in the right one."""
    model = Tone(toy({"sine": there_is}, 5, extra=tone(TRUE)).runs)
    floors = [{channel.name: noise_floor(channel) for channel in run.channels} for run in model.runs]
    state = begin(model, EFFECTS, floors, ({},), 0, lambda stage, share: None)
    free, folds, effect = state.ways[0], state.blocks.folds, (EFFECTS[0],)
    right = scored(free, (), fit(free, parameters_of(free, ()), {"pitch": TRUE}), folds)
    state = replace(state, tuned=right, current=right)
    wrong = scored(free, effect, fit(free, parameters_of(free, effect), {"pitch": -3.0, "sine": 0.5}), folds)
    assert wrong.fit.cost > right.fit.cost
    again = no_less_likely(state, wrong)
    assert again.names == wrong.names
    if there_is:
        assert again.fit.values["sine"] == pytest.approx(there_is, abs=0.5)
        assert again.fit.cost < right.fit.cost
        assert no_less_likely(state, again) is again
    else:
        assert again is wrong, "nothing is gained from there: not worth finishing"
