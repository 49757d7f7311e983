"""The global search, on a free oscillation: off in frequency, all points far from the truth look alike."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from slider_drilling.gap import Channel, LoggedRun
from slider_drilling.gap.problem.problem import build_problem
from slider_drilling.gap.search.global_search import global_search

TIME = np.arange(250) * 0.1
TRUTH = {"frequency": 0.83, "decay": 0.01, "size": 5.0}
SPANS = {"frequency": (0.5, 1.3), "decay": (0.0, 0.05), "size": (1.0, 20.0)}


@dataclass(frozen=True)
class Swing:
    """Samples asked for are counted in `spent`, by the length of the run."""

    runs: tuple[LoggedRun, ...]
    spent: dict[int, int]
    nuisance: tuple = ()
    effects: tuple = ()

    def simulate(self, run, sets, options):
        time = self.runs[run].channels[0].time
        self.spent[time.size] = self.spent.get(time.size, 0) + len(sets)
        return {"force": np.stack([force(values, time) for values in sets])}


class Truncating(Swing):
    def truncated(self, fraction):
        channel = self.runs[0].channels[0]
        kept = channel.time <= fraction * TIME[-1]
        return Truncating((run_of(channel.time[kept], channel.measured[kept]),), self.spent)


def force(values, time):
    return values["size"] * np.exp(-values["decay"] * time) * np.sin(2.0 * np.pi * values["frequency"] * time)


def run_of(time, measured):
    return LoggedRun("swing", time, np.ones_like(time), (Channel("force", time, measured, "N", declared_noise=0.5),))


@pytest.fixture(params=[Swing, Truncating])
def problem(request):
    measured = force(TRUTH, TIME) + np.random.default_rng(5).normal(0.0, 0.5, TIME.size)
    return build_problem(request.param((run_of(TIME, measured),), {}), [{"force": 0.5}])


def test_global_search_finds_the_frequency_repeatably(problem):
    """Most of the search sees a part of the run only, where the model has parts."""
    ends = global_search(problem, problem, SPANS, {"other": 1.0}, seed=1)
    whole = problem.model.spent[TIME.size]
    shorter = sum(problem.model.spent.values()) - whole
    assert (shorter > 0.5 * whole) == isinstance(problem.model, Truncating)
    assert ends[0]["frequency"] == pytest.approx(TRUTH["frequency"], abs=1e-3)
    assert ends[0]["size"] == pytest.approx(TRUTH["size"], rel=0.1)
    assert ends[0]["other"] == 1.0
    costs = [problem.cost(problem.residuals([end])[0])[0] for end in ends]
    assert costs == sorted(costs)
    assert global_search(problem, problem, SPANS, {"other": 1.0}, seed=1) == ends
