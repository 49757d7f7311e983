"""Where along a model something is missing, by its probes."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pytest
from toy import TIME, Toy, toy

from slider_drilling.gap import Parameter, SimulationOptions
from slider_drilling.gap.evidence.score import make_folds, score_held_out
from slider_drilling.gap.problem.problem import build_problem
from slider_drilling.gap.results.breakdown import band_edges, break_down_along
from slider_drilling.gap.search.least_squares import fit
from slider_drilling.gap.selection.state import FittedModel

SIZE = 10.0
PARTS = tuple(np.sin(2.0 * np.pi * TIME / 7.0) * (k == TIME // 40.0) for k in range(3))


@dataclass(frozen=True)
class Along(Toy):
    """A toy of three stretches, each as strong as its probe says."""

    @property
    def probes(self) -> tuple[tuple[Parameter, float, float], ...]:
        return tuple((Parameter(f"part_{k}", 1.0, 0.1, 5.0, 0.2), 100.0 * k, 100.0 * (k + 1)) for k in range(3))

    def simulate(
        self, run: int, sets: Sequence[Mapping[str, float]], options: SimulationOptions
    ) -> Mapping[str, np.ndarray]:
        made = [sum(SIZE * one.get(f"part_{k}", 1.0) * part for k, part in enumerate(PARTS)) for one in sets]
        return {"force": np.stack(made)}


def located(second: float) -> list[dict[str, float]]:
    (run,) = toy({}, 4, extra=SIZE * (PARTS[0] + second * PARTS[1] + PARTS[2])).runs
    problem = build_problem(Along((run,), nuisance=()), [{"force": 1.0}])
    found = fit(problem, (), {})
    return break_down_along(FittedModel((), problem, found, score_held_out(problem, found, make_folds(problem))))


def test_stretch_with_more_is_located_with_its_size():
    rows = located(1.4)
    assert [(row["from"], row["to"]) for row in rows] == [(0.0, 100.0), (100.0, 200.0), (200.0, 300.0)]
    assert rows[1]["change"] == pytest.approx(0.4, abs=0.1)
    assert rows[1]["share"] > 0.7
    assert sum(row["share"] for row in rows) == pytest.approx(1.0)


def test_probe_change_stays_within_its_bounds():
    assert located(-3.0)[1]["change"] == pytest.approx(-0.9, abs=1e-6)


def test_bands_of_cycles_are_called_as_the_run_calls_them():
    (run,) = toy({}, 4).runs
    names = [[name for name, *_ in band_edges(each)] for each in (run, replace(run, cycle="rocking"))]
    assert names[0][:2] == ["below the cycle frequency", "cycle and its harmonics"]
    assert names[1][:2] == ["below the rocking frequency", "rocking and its harmonics"]
