"""A re-tuning that was enough, but went far, says which law it may stand for."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pytest
from toy import EFFECTS, SHAPES, Toy, force, toy

from slider_drilling.gap import Effect, How, Parameter
from slider_drilling.gap.explain import explain

TILT = Effect(
    "tilt", "sensor", (Parameter("tilt", 0.0, -99.0, 99.0, 0.3, "N"),), scan=((-20.0,), (10.0,), (30.0,)),
    physical=(0.0, np.inf), nonphysical="a tilt to the left",
)  # fmt: skip


@dataclass(frozen=True)
class Tilted(Toy):
    """An effect does what a nuisance does, which no log can tell apart; rigs vary in the nuisance by a spread of 5."""

    effects: tuple[Effect, ...] = (*EFFECTS, TILT)

    def simulate(self, run: int, sets: Sequence[Mapping[str, float]], how: How) -> Mapping[str, np.ndarray]:
        rows = [force(values) + values.get("tilt", 0.0) * SHAPES["slope"] for values in sets]
        return {"force": np.stack(rows)}


@pytest.mark.parametrize(("slope", "told"), [(30.0, ("tilt",)), (5.0, ()), (-30.0, ())])
def test_a_law_is_told_where_re_tuning_went_far_and_never_named(slope, told):
    answer = explain(Tilted(toy({"slope": slope}, 3).runs))
    assert (answer.verdict, answer.effects, answer.instead) == ("parameters", (), told)
    assert ("or tilt makes it look so" in answer.sentence) == bool(told)
    assert any("slope is tuned to" in remark for remark in answer.remarks) == (abs(slope) > 12.5)
