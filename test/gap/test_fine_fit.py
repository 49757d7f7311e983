"""Fits are finished in the simulation that they are compared in."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pytest
from toy import SHAPES, Toy, force, toy

from slider_drilling.gap import SimulationOptions
from slider_drilling.gap.problem.problem import build_problem
from slider_drilling.gap.search.fine_fit import refit_in_fine_simulation, refit_with_correction
from slider_drilling.gap.search.least_squares import fit
from slider_drilling.gap.search.race import parameters_of

TRUTH = {"level": 2.0, "sine": 6.0}


@dataclass(frozen=True)
class Coarse(Toy):
    """The cheap simulation makes more of a sine than there is, and a bend besides, the more so the larger it is."""

    max_fidelity: int = 2

    def simulate(
        self, run: int, sets: Sequence[Mapping[str, float]], options: SimulationOptions
    ) -> Mapping[str, np.ndarray]:
        rows = [force(one) for one in sets]
        if options.fidelity == 0:
            off = [one.get("sine", 0.0) ** 2 * (0.05 * SHAPES["sine"] + 0.1 * SHAPES["bend"]) for one in sets]
            rows = [row + extra for row, extra in zip(rows, off, strict=True)]
        return {"force": np.stack(rows)}


def coarse_fit() -> tuple:
    model = Coarse(toy(TRUTH, seed=4).runs)
    problem = build_problem(model, [{"force": 1.0}])
    sine = [one for one in model.effects if one.name == "sine"]
    return problem, fit(problem, parameters_of(problem, sine), {"sine": 1.0}, iterations=20)


def least_squares(measured: np.ndarray) -> dict[str, float]:
    names = ["level", "slope", "sine"]
    solved, *_ = np.linalg.lstsq(np.stack([SHAPES[name] for name in names]).T, measured, rcond=None)
    return dict(zip(names, solved, strict=True))


def test_fit_ends_at_optimum_of_fine_simulation():
    problem, coarse = coarse_fit()
    _, ended = refit_in_fine_simulation(*refit_with_correction(problem, coarse))
    best = least_squares(problem.model.runs[0].channels[0].measured)
    assert abs(coarse.values["sine"] - best["sine"]) > 0.3, "the coarse one is elsewhere"
    assert ended.values["sine"] == pytest.approx(best["sine"], abs=0.03)
    assert ended.values["level"] == pytest.approx(best["level"], abs=0.05)


def test_corrected_cheap_simulation_equals_the_fine_one():
    problem, coarse = coarse_fit()
    exact, ended = refit_in_fine_simulation(*refit_with_correction(problem, coarse))
    assert exact.options.fidelity == 0
    np.testing.assert_allclose(exact.residuals([ended.values])[0], ended.residual, atol=1e-9)


def test_fit_far_behind_the_leader_ends_early():
    problem, coarse = coarse_fit()
    before = problem.counter.count
    refit_in_fine_simulation(*refit_with_correction(problem, coarse))
    alone = problem.counter.count - before
    before = problem.counter.count
    refit_in_fine_simulation(*refit_with_correction(problem, coarse), leader=-1e6)
    assert problem.counter.count - before < alone


def test_added_rows_are_added_once():
    problem, coarse = coarse_fit()
    ramp = np.linspace(0.0, 1.0, problem.size)
    bent = problem.with_added_rows({"drift": ramp})
    values = {**coarse.values, "drift": 3.0}
    for one in (bent, bent.corrected_at(values, 1), bent.with_options(SimulationOptions(1))):
        np.testing.assert_allclose(one.simulate([values])[0] - one.simulate([coarse.values])[0], 3.0 * ramp, atol=1e-9)
    np.testing.assert_allclose(
        bent.corrected_at(values, 1).simulate([values])[0],
        bent.with_options(SimulationOptions(1)).simulate([values])[0],
    )
