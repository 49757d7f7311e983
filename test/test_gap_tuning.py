"""Re-tuning: from several places, and with a finer model before what the mesh leaves is called something else."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from slider_drilling.gap import Channel, Parameter, Run, explain
from slider_drilling.gap.explain import Ranked
from slider_drilling.gap.noise import NoiseFloor
from slider_drilling.gap.residuals import build_problem
from slider_drilling.gap.tune import fit_growing, spread_out

TIME = np.arange(0.0, 600.0, 0.05)
FLOORS = [{"height": NoiseFloor(1.0, "declared")}]
PITCH = Parameter("pitch", 1.0, 0.2, 2.0, 0.002, spread=0.1)
SLOPE = Parameter("slope", 0.0, -5.0, 5.0, 0.1)


def recorded(height):
    noise = np.random.default_rng(2).normal(0.0, 1.0, TIME.size)
    return (Run("run", TIME, np.sin(TIME), (Channel("height", TIME, height + noise),)),)


@dataclass
class Tone:
    """A sine whose pitch is tuned: a few cycles off, every one of them is a minimum."""

    runs: tuple[Run, ...]
    nuisance: tuple[Parameter, ...] = (PITCH,)
    effects: tuple = ()

    def simulate(self, run, sets):
        return {"height": np.stack([8.0 * np.sin(0.2 * values.get("pitch", 1.0) * TIME) for values in sets])}


@dataclass
class Meshed:
    """A slope with an error of its own, which a finer mesh makes ten times smaller."""

    runs: tuple[Run, ...]
    nuisance: tuple[Parameter, ...] = (SLOPE,)
    effects: tuple = ()
    error: float = 0.32

    def simulate(self, run, sets):
        slope = np.array([values.get("slope", 0.0) for values in sets])[:, None]
        return {"height": 0.01 * slope * TIME + self.error * np.cos(0.3 * TIME)}

    def refined(self):
        return replace(self, error=0.1 * self.error)


@dataclass
class Coarse(Meshed):
    """One that cannot be refined: what it leaves is not known to be its own."""

    refined = None


def test_tuning_begins_from_elsewhere_where_nominal_is_a_trap():
    model = Tone(recorded(8.0 * np.sin(0.2 * 1.13 * TIME)))
    problem = build_problem(model, FLOORS)
    assert fit_growing(problem, [PITCH], {}).cost > 5.0
    answer = explain(model, floors=FLOORS)
    assert answer.verdict == "parameters"
    assert answer.parameters["pitch"] == pytest.approx(1.13, abs=1e-3)


@pytest.mark.parametrize("made, verdict", [(Meshed, "parameters"), (Coarse, "unknown")])
def test_what_the_mesh_leaves_is_no_gap(made, verdict):
    answer = explain(made(recorded(0.02 * TIME)), floors=FLOORS)
    assert answer.verdict == verdict
    assert (answer.tuned < 1.01) == (verdict == "parameters")


def test_shares_are_dashes_where_there_is_nothing_to_close():
    none = float("nan")
    tried = Ranked("heave", "draw_works", none, (none, none), {}, True, False, True, True, 1)
    assert tried.shown() == ("-", "-")
    assert replace(tried, closed=0.5, interval=(0.1, 0.7)).shown() == ("0.50", "0.10 to 0.70")
    assert replace(tried, closed=0.5, fitted=False).shown() == ("0.50", "screened only")


def test_points_are_spread_over_so_many_spreads_or_the_bounds():
    near, wide = Parameter("near", 1.0, 0.95, 9.0, 0.1, spread=0.2), Parameter("wide", 0.0, -2.0, 3.0, 0.1)
    points = spread_out([near, wide], 64, 2.0)
    for name, low, high in (("near", 0.95, 1.4), ("wide", -2.0, 3.0)):
        values = [point[name] for point in points]
        assert low <= min(values) < low + 0.05 * (high - low) and high - 0.05 * (high - low) < max(values) <= high
    assert spread_out([], 3, 1.0) == [{}, {}, {}]
