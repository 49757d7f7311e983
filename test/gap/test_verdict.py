"""Named effects must outperform every free form at another site, and yield to one that predicts better."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import pytest
from toy import EFFECTS, SHAPES, TIME, Toy, toy

from slider_drilling.gap import Effect, Parameter, explain
from slider_drilling.gap.evidence.score import HeldOutScore
from slider_drilling.gap.model import FreeForm
from slider_drilling.gap.selection.verdict import SiteScore, likely_explanations, reach_verdict, with_smaller_gap

TUNED = {"level": 2.0, "slope": -1.5}
SINE = tuple(effect for effect in EFFECTS if effect.name == "sine")


@dataclass(frozen=True)
class Rubbed(Toy):
    """The toy with one law, and one disturbance that has a shape of the toy's, at a site of its own choice."""

    effects: tuple[Effect, ...] = SINE
    shape: str = "saw"
    site: str = "string"
    like: tuple[str, ...] = ()
    fitted: bool = False

    def free_forms(self, values: Mapping[str, float]) -> list[FreeForm]:
        free = (Parameter(self.shape, 0.0, -50.0, 50.0, 0.3),) if self.fitted else ()
        moved = ({**values, self.shape: 0.1},)
        return [FreeForm(self.site, self.words, self.like, (0.0,), "-", moved, (0.1,), free)]

    @property
    def words(self) -> str:
        return f"a {self.shape} that no law describes"

    def sensor_site(self, channel: str) -> str:
        return "sensor"


def rubbed(truth: Mapping[str, float], seed: int = 3, **what: object) -> Rubbed:
    """Under an excitation that no law's shape follows: a reading that is off by it would be one of them."""
    (run,) = toy(TUNED | truth, seed).runs
    return Rubbed((replace(run, excitation=np.sin(2.0 * np.pi * TIME / 17.0)),), **what)


@pytest.mark.parametrize("material", [{}, {"sine": 9.0}])
def test_cause_too_small_to_act_on_leaves_nothing_unknown(material):
    model = toy(TUNED | {"sine": 4.0}, 3)
    answer = explain(replace(model, effects=tuple(replace(effect, material=material) for effect in SINE)))
    assert (answer.effects == ("sine",)) == (not material)
    assert (answer.verdict == "parameters") == bool(material)
    assert answer.small_cause == ("sine" if material else None)


@pytest.mark.parametrize("fitted", [False, True])
def test_equal_free_form_elsewhere_makes_effect_a_likeness(fitted):
    answer = explain(rubbed({"sine": 4.0}, shape="sine", fitted=fitted))
    assert answer.effects == ("sine",)
    assert answer.verdict == "effect_and_unknown"
    assert answer.alternative is not None and answer.alternative.site == "string"
    assert "a sine that no law describes fits as well" in answer.sentence


@pytest.mark.parametrize("fitted", [False, True])
def test_effect_better_than_free_forms_is_named(fitted):
    answer = explain(rubbed({"sine": 4.0}, shape="saw", fitted=fitted))
    assert (answer.verdict, answer.effects, answer.alternative) == ("effect", ("sine",), None)


def test_remainder_beside_an_effect_is_no_alternative():
    answer = explain(rubbed({"sine": 9.0, "saw": 4.0}, fitted=True))
    assert (answer.verdict, answer.effects, answer.alternative) == ("effect_and_unknown", ("sine",), None)
    assert answer.remainder is not None and answer.remainder.description.startswith("a saw")
    np.testing.assert_allclose(answer.remainder.y, [4.0], atol=4.0 * 2.0 / np.sqrt(TIME.size * np.var(SHAPES["saw"])))
    assert "remains: a saw that no law describes" in answer.sentence and "fits as well" not in answer.sentence


def test_free_form_of_the_effect_is_no_rival():
    own = SINE[0].site
    answer = explain(rubbed({"sine": 4.0}, shape="sine", site=own, like=("sine",), fitted=True))
    assert (answer.verdict, answer.effects) == ("effect", ("sine",))


def test_better_free_form_gives_unknown_with_shape():
    answer = explain(rubbed({"saw": 4.0}, fitted=True))
    assert (answer.verdict, answer.effects, answer.site) == ("unknown", (), "string")
    assert answer.alternative is not None and answer.alternative.description.startswith("a saw")
    np.testing.assert_allclose(answer.alternative.y, [4.0], atol=4.0 * 2.0 / np.sqrt(TIME.size * np.var(SHAPES["saw"])))


def worse(score: HeldOutScore, by: float, wider: float) -> HeldOutScore:
    """A score that predicts one short stretch worse, and leaves a wider gap throughout."""
    density = score.density.copy()
    density[:10] += by / 10.0
    squares = wider * score.squares
    return replace(score, density=density, squares=squares, gap=float(np.sqrt(np.mean(squares))))


@pytest.mark.parametrize(("by", "named"), [(2.0, ("sine",)), (20.0, ())])
def test_likelier_free_form_elsewhere_withdraws_effect(by, named):
    """Not significantly, since it comes from one stretch, but by more than one of so many forms does by chance."""
    state = explain(rubbed({"sine": 4.0}, shape="sine")).state
    (taken,) = state.steps
    current = replace(state.current, score=worse(state.current.score, by, 1.02))
    refitted = (replace(taken.candidates[0], fitted=current),)
    decided = reach_verdict(replace(state, current=current, steps=(replace(taken, candidates=refitted),)))
    assert decided.effects == named
    assert decided.site == ("contact" if named else "string")
    assert decided.alternative is not None and decided.alternative.site == "string"


@pytest.mark.parametrize(("unit", "site"), [(1.0, "contact"), (2.0, "string")])
def test_scores_in_other_noise_units_are_ignored(unit, site):
    state = explain(rubbed({"saw": 4.0}, fitted=True)).state
    (taken,) = state.steps
    found = taken.candidates[0].fitted
    pieces = tuple(replace(piece, noise=unit * piece.noise) for piece in found.problem.pieces)
    score = replace(found.score, density=found.score.density - 100.0, squares=np.ones_like(found.score.squares))
    better = replace(found, problem=replace(found.problem, pieces=pieces), score=replace(score, gap=1.0))
    steps = (replace(taken, candidates=(replace(taken.candidates[0], fitted=better), *taken.candidates[1:])),)
    assert reach_verdict(replace(state, steps=steps)).site == site


def test_significant_explanations_come_before_gap_reductions():
    state = explain(rubbed({"saw": 4.0}, fitted=True)).state
    tuned = state.calibrated.score
    half = np.arange(tuned.squares.size) % 2 == 0

    def tried(gain: np.ndarray, left: np.ndarray) -> SiteScore:
        squares = tuned.squares * left
        gap = float(np.sqrt(np.mean(squares)))
        return SiteScore("string", replace(tuned, density=tuned.density - gain, squares=squares, gap=gap))

    everywhere, once = np.full(half.size, 1.0), np.where(np.arange(half.size) < 10, 3.0, -0.05)
    shrunk, as_it_was = np.full(half.size, 0.5), np.where(half, 1.5, 0.5)
    certain, once_shrunk, once_worse = tried(everywhere, shrunk), tried(once, shrunk), tried(-once, shrunk)
    worse, unshrunk = tried(-everywhere, shrunk), tried(everywhere, as_it_was)
    assert likely_explanations(state, [worse, unshrunk, once_worse, once_shrunk, certain]) == [certain]
    assert likely_explanations(state, [worse, unshrunk, once_worse, once_shrunk]) == [once_worse, once_shrunk]
    assert likely_explanations(state, [worse, unshrunk]) == []
    wider, less = tried(3.0 * everywhere, np.full(half.size, 2.0)), tried(once, np.where(half, 1.2, 0.5))
    assert with_smaller_gap(state, [worse, wider, less]) == [less]


def test_periodic_curve_closes_around_its_mean():
    made = rubbed({"saw": 4.0}, fitted=True)
    (one,) = made.free_forms({})
    around = replace(one, x=(0.0, 1.0), parameter_sets=(*one.parameter_sets, {"step": 0.1}), steps=(0.1, 0.1),
        period=2.0,
                     parameters=(*one.parameters, Parameter("step", 0.0, -50.0, 50.0, 0.3)))  # fmt: skip

    class Around(Rubbed):
        def free_forms(self, values: Mapping[str, float]) -> list[FreeForm]:
            return [around]

    alternative = explain(Around(made.runs)).alternative
    assert alternative is not None
    np.testing.assert_allclose(alternative.x, [0.0, 1.0, 2.0])
    assert alternative.y[0] == alternative.y[2]
    assert abs(alternative.y[0] + alternative.y[1]) < 1e-9


# A sine law whose cause is not quite its own: it leaves a bend, which a law of the catalogue has.
MISSHAPEN = {"sine": 6.0, "bend": 4.0}
LAWS = tuple(effect for effect in EFFECTS if effect.name in ("sine", "bend"))


def test_free_form_of_first_effect_excludes_second():
    answer = explain(rubbed(MISSHAPEN, effects=LAWS, shape="bend", like=("sine",), site="contact"))
    assert (answer.verdict, answer.effects) == ("effect_and_unknown", ("sine",))
    (bend,) = answer.state.steps[-1].candidates
    assert bend.fitted.names == ("sine", "bend")
    assert any("a free form of an effect already in the model" in why and "a bend" in why for why in bend.failures)


def test_second_effect_unlike_free_forms_is_named():
    answer = explain(rubbed(MISSHAPEN, effects=LAWS, shape="saw", like=("sine",), site="contact"))
    assert (answer.verdict, set(answer.effects)) == ("effect", {"sine", "bend"})


@pytest.mark.parametrize(("shape", "verdict"), [("sine", "parameters"), ("saw", "effect")])
def test_adequate_calibration_allows_no_alternative(shape, verdict):
    """Where calibration leaves only noise, an effect is named without alternative, or not at all."""
    state = explain(rubbed({"sine": 4.0}, shape=shape, fitted=True)).state
    assert not state.calibrated_adequacy.adequate
    quiet = replace(
        state, calibrated_adequacy=replace(state.calibrated_adequacy, within_thresholds=True, channels_structured=())
    )
    decided = reach_verdict(quiet)
    assert (decided.verdict, decided.effects) == (verdict, ("sine",) if verdict == "effect" else ())
    assert decided.alternative is None and (decided.state.current is quiet.calibrated) == (verdict == "parameters")


def test_effects_without_gap_reduction_are_withdrawn():
    state = explain(toy({"level": 2.0, "sine": 4.0}, seed=2), effects=EFFECTS).state
    assert reach_verdict(state).effects == ("sine",)
    score = state.current.score
    half = np.arange(score.squares.size) % 2 == 0
    wider = np.where(half, state.calibrated.score.squares * 1.2, state.calibrated.score.squares * 0.9)
    worse = replace(score, squares=wider, gap=float(np.sqrt(np.mean(wider))))
    decided = reach_verdict(replace(state, current=replace(state.current, score=worse)))
    assert decided.effects == ()
    assert decided.verdict == "unknown"
    assert decided.state.current is decided.state.calibrated
