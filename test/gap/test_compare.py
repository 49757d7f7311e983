"""The only "better than", the race, and the screen, on the linear toy whose answers are known."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from toy import EFFECTS, TIME, toy

from slider_drilling.gap.evidence.block_bootstrap import make_bootstrap
from slider_drilling.gap.evidence.compare import gap_closed, predicts_better, share_closed
from slider_drilling.gap.evidence.score import Folds, HeldOutScore, make_folds, score_held_out
from slider_drilling.gap.problem.noise import noise_floor
from slider_drilling.gap.problem.problem import build_problem
from slider_drilling.gap.search.least_squares import fit
from slider_drilling.gap.search.race import FINALISTS, Arm, finalists, parameters_of, race
from slider_drilling.gap.search.screen import scan_effects, screen
from slider_drilling.gap.selection.forward_selection import calibrate


def fitted(model, names):
    problem = build_problem(model, [{"force": 1.0}])
    effects = [effect for effect in EFFECTS if effect.name in names]
    return problem, fit(problem, parameters_of(problem, effects), {})


def test_a_fit_is_least_squares_where_nothing_else_is_asked():
    model = toy({"level": 2.0, "slope": -1.0, "saw": 3.0}, 4)
    problem, found = fitted(model, ["saw"])
    columns = np.column_stack([problem.simulate([{name: 1.0}])[0] for name in ("level", "slope", "saw")])
    weight = np.diag([1.0 / 5.0**2, 1.0 / 5.0**2, 0.0])
    measured = model.runs[0].channels[0].measured
    exact = np.linalg.solve(columns.T @ columns + weight, columns.T @ measured)
    assert [found.values[name] for name in ("level", "slope", "saw")] == pytest.approx(exact, abs=0.02)


def test_the_truth_beats_what_lacks_it_and_nothing_beats_its_equal():
    wins = draws = 0
    for seed in range(20):
        model = toy({"level": 1.0, "saw": 4.0}, seed)
        scores = {}
        for names in ((), ("saw",), ("saw", "bend")):
            problem, found = fitted(model, names)
            folds = make_folds(problem)
            scores[names] = score_held_out(problem, found, folds)
        blocks = make_bootstrap(folds, 0)
        wins += predicts_better(blocks, scores["saw",], scores[()])
        draws += predicts_better(blocks, scores["saw", "bend"], scores["saw",])
        assert not predicts_better(blocks, scores["saw",], scores["saw",])
    assert wins == 20
    assert draws <= 4


def test_the_race_ends_where_an_exhaustive_search_does():
    model = toy({"level": 1.0, "slope": 0.5, "bend": 3.0}, 8)
    problem = build_problem(model, [{"force": 1.0}])
    base = fit(problem, parameters_of(problem, ()), {})
    costs = {}
    for effect in EFFECTS:
        begun = [base.values | effect.values(point) for point in effect.scan]
        ends = [fit(problem, parameters_of(problem, [effect]), start, iterations=20) for start in begun]
        costs[effect.name] = min(end.cost for end in ends)
    arms = [
        Arm((c.effect,), 0, start, base) for c in screen(scan_effects(problem, base, EFFECTS)) for start in c.starts
    ]
    ran = race((problem,), arms)
    assert ran[0].names == (min(costs, key=lambda name: costs[name]),) == ("bend",)
    assert ran[0].cost == pytest.approx(costs["bend"], abs=0.5)


def test_the_screen_promises_what_a_linear_effect_brings():
    model = toy({"level": 1.0, "saw": 3.0}, 8)
    problem = build_problem(model, [{"force": 1.0}])
    base = fit(problem, parameters_of(problem, ()), {})
    first = screen(scan_effects(problem, base, EFFECTS))[0]
    found = fit(problem, parameters_of(problem, [first.effect]), first.starts[0])
    assert first.effect.name == "saw"
    assert base.cost - found.cost == pytest.approx(first.predicted_gain, rel=0.05)


def test_held_out_never_sees_its_own_stretch():
    """Noise that is foretold by nobody costs the same held out whatever a fit does with it."""
    model = toy({}, 5)
    problem, found = fitted(model, [effect.name for effect in EFFECTS])
    score = score_held_out(problem, found, make_folds(problem))
    assert float(np.mean(score.residual**2)) > float(np.mean(found.residual**2))
    assert score.unrefitted_folds == 0


def test_share_closed():
    assert float(share_closed(5.0, 1.0)) == 1.0
    assert float(share_closed(5.0, 7.0)) == pytest.approx(-0.5)
    assert np.isnan(share_closed(0.9, 0.8))


@pytest.mark.parametrize("number", [6, 20])
def test_an_interval_of_few_blocks_holds_the_share_as_often_as_it_says(number):
    """What is left differs from place to place, four of which are a block; a share of three quarters is closed."""
    per_block, each = 4, 5
    size = number * per_block * each
    folds = Folds(np.zeros(size, dtype=int), np.arange(size), (size,), (per_block * each,))
    generator = np.random.default_rng(5)
    before = HeldOutScore(np.zeros(size), np.zeros(size), np.full(size, 5.0), np.sqrt(5.0), {}, 0)
    blocks = [make_bootstrap(folds, seed) for seed in range(10)]
    held, logs = 0, 400
    for log in range(logs):
        squares = np.repeat(generator.normal(2.0, 0.3, number * per_block), each)
        after = replace(before, squares=squares, gap=float(np.sqrt(np.mean(squares))))
        low, high = gap_closed(blocks[log % 10], before, after)[1]
        held += low <= 0.75 <= high
    assert 0.92 < held / logs < 0.98


def test_begin_leaves_what_it_was_given_alone():
    model = toy({"level": 1.0}, 1)
    floors = [{"force": noise_floor(model.runs[0].channels[0])}]
    before = [dict(own) for own in floors]
    states = [calibrate(model, EFFECTS, floors, [{}], 0, lambda stage, share: None) for _ in range(2)]
    assert floors == before
    assert states[0].calibrated.fit.values == states[1].calibrated.fit.values
    assert all(a.name != b.name for a, b in itertools.pairwise(states[0].calibrated.fit.parameters))
    assert states[0].calibrated.problem.size == TIME.size


def test_what_bends_to_much_with_the_wrong_sign_takes_no_named_effects_place():
    signed = [replace(effect, physical=(0.0, np.inf)) for effect in EFFECTS]
    wrong = [Arm((effect,), 0, {effect.name: -3.0}, None) for effect in signed[:3]]
    right = [Arm((effect,), 0, {effect.name: 3.0}, None) for effect in signed]
    judged = [arms[0] for arms in finalists([*wrong, *right])]
    assert sum(arm.physical for arm in judged) == FINALISTS
    assert [arm.names for arm in judged if not arm.physical] == [(signed[0].name,)]
