"""Of several runs, an effect must close the gap of the one that its fit has not seen."""

from dataclasses import replace

import numpy as np
import pytest
from toy import SHAPES, Toy, toy

from slider_drilling.gap import explain
from slider_drilling.gap.evidence.compare import gap_closed
from slider_drilling.gap.evidence.score import score_left_out_runs
from slider_drilling.gap.problem.noise import noise_floor
from slider_drilling.gap.problem.problem import build_problem
from slider_drilling.gap.search.least_squares import fit
from slider_drilling.gap.search.race import parameters_of
from slider_drilling.gap.selection.calibration import calibrate
from slider_drilling.gap.selection.evidence_tests import Evidence
from slider_drilling.gap.selection.naming_criteria import Stage, failures
from slider_drilling.gap.selection.refit import finish_and_cross_validate


def both(*amplitudes: float) -> Toy:
    """One run for each amplitude of the sine."""
    runs = [toy({"level": 1.0, "sine": amplitude}, seed).runs[0] for seed, amplitude in enumerate(amplitudes)]
    return Toy(tuple(replace(run, name=f"toy {number}") for number, run in enumerate(runs)))


def silent(stage: str, share: float) -> None:
    """Where progress goes."""


def test_effect_in_every_run_is_named():
    answer = explain(both(3.0, 3.0))
    assert answer.effects == ("sine",)
    (found,) = [one for one in answer.candidates if one.effect.name == "sine"]
    assert found.closed_in_other_runs is not None
    closed, (low, high) = found.closed_in_other_runs
    assert 0.0 < low <= closed <= high <= 1.2


@pytest.mark.parametrize(("amplitudes", "passes"), [((3.0, 3.0), True), ((5.0, -1.0), False), ((-1.0, 4.0), False)])
def test_effect_wrong_in_another_run_fails(amplitudes, passes):
    model = both(*amplitudes)
    sine = next(effect for effect in model.effects if effect.name == "sine")
    floors = [{"force": noise_floor(run.channels[0])} for run in model.runs]
    state = calibrate(model, model.effects, floors, [{}], 0, silent)
    found = fit(state.current_mode, parameters_of(state.current_mode, [sine]), {})
    fitted = finish_and_cross_validate(state.current_mode, [sine], found, state.bootstrap.folds)
    assert (failures(Stage.OTHER_RUNS, Evidence(state, state.current, fitted)) == ()) == passes
    closed, _ = gap_closed(state.bootstrap, state.current.cross_run_score, fitted.cross_run_score)
    assert (closed > 0.0) == passes


def test_each_run_is_scored_by_the_others():
    model = both(3.0, -2.0)
    problem = build_problem(model, [{"force": 1.0}] * 2)
    sine = next(effect for effect in model.effects if effect.name == "sine")
    found = fit(problem, parameters_of(problem, [sine]), {})
    score = score_left_out_runs(problem, found)
    for run in (0, 1):
        (other,) = (piece for piece in problem.pieces if piece.run != run)
        rows = slice(run * 240, (run + 1) * 240)
        alone = fit(problem.restricted_to([1 - run]), found.parameters, {})
        shapes = np.array([SHAPES[parameter.name] for parameter in found.parameters])
        values = np.array([alone.values[parameter.name] for parameter in found.parameters])
        expected = model.runs[run].channels[0].measured - values @ shapes
        assert other.run == 1 - run
        np.testing.assert_allclose(score.residual[rows], expected, atol=0.05)


def test_restricted_problem_simulates_its_runs_only():
    problem = build_problem(both(0.0, 0.0), [{"force": 1.0}] * 2)
    problem.restricted_to([1]).simulate([{}, {}])
    assert problem.counter.count == 2
    assert np.all(problem.restricted_to([1]).residuals([{}])[0][:240] == 0.0)


@pytest.mark.parametrize("seed", range(4))
def test_noise_in_two_runs_names_nothing(seed):
    runs = (toy({}, 2 * seed + 90).runs[0], replace(toy({}, 2 * seed + 91).runs[0], name="again"))
    assert explain(Toy(runs)).effects == ()
