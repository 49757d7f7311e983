"""A calibration that is enough with implausible values names the effect that it may hide."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pytest
from toy import EFFECTS, SHAPES, TIME, Toy, force, toy

from slider_drilling.gap import Effect, Parameter, SimulationOptions
from slider_drilling.gap.explain import explain

TILT = Effect(
    "tilt", "sensor", (Parameter("tilt", 0.0, -99.0, 99.0, 0.3, "N"),), scan=((-20.0,), (10.0,), (30.0,)),
    physical=(0.0, np.inf), nonphysical="a tilt to the left",
)  # fmt: skip
OWN = np.sin(6.0 * np.pi * TIME / TIME[-1])


@dataclass(frozen=True)
class Tilted(Toy):
    """An effect acts like a nuisance with a spread of 5, and a little in a way of its own (``own``)."""

    own: float = 0.0
    effects: tuple[Effect, ...] = (*EFFECTS, TILT)

    def simulate(
        self, run: int, sets: Sequence[Mapping[str, float]], options: SimulationOptions
    ) -> Mapping[str, np.ndarray]:
        tilted = SHAPES["slope"] + self.own * OWN
        return {"force": np.stack([force(values) + values.get("tilt", 0.0) * tilted for values in sets])}


@pytest.mark.parametrize(("slope", "masked"), [(30.0, ("tilt",)), (5.0, ()), (-30.0, ())])
def test_implausible_calibration_masks_an_effect(slope, masked):
    answer = explain(Tilted(toy({"slope": slope}, 3).runs))
    assert (answer.verdict, answer.effects, answer.masked_effects) == ("parameters", (), masked)
    assert ("which may hide tilt" in answer.sentence) == bool(masked)
    assert any("slope is calibrated to" in remark for remark in answer.remarks) == (abs(slope) > 12.5)


@pytest.mark.parametrize(("share", "named"), [(1.0, ("tilt",)), (0.0, ())])
def test_supported_effect_replaces_implausible_calibration(share, named):
    runs = toy({"slope": 30.0}, 3, extra=30.0 * 0.005 * share * OWN).runs
    answer = explain(Tilted(runs, own=0.005))
    assert answer.effects == named
    assert answer.verdict == ("effect" if named else "parameters")
    assert (answer.state.unrestricted is not None) == bool(named)
    if named:
        assert answer.gap_calibrated > 5.0 and answer.closed_interval[0] > 0.9
        assert answer.state.current.fit.values["tilt"] == pytest.approx(30.0, abs=5.0)
        assert any("calibration alone also fits this log" in remark for remark in answer.remarks)
