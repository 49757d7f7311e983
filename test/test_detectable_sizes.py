"""Detectable sizes: the staircase finds where half of the trials hit; the planner predicts a size for each effect."""

from types import SimpleNamespace

import numpy as np
import pytest

from slider_drilling.benchmarks import detectable_sizes
from slider_drilling.blind.catalogue_laws import CATALOGUE_LAWS


@pytest.mark.parametrize("begins", [0.5, 4.0])
def test_staircase_finds_half_hits(monkeypatch, begins):
    generator = np.random.default_rng(1)

    def trial(run, name, size, seed):
        return size, bool(size > 2.0 * np.exp(generator.normal(0.0, 0.2)))

    monkeypatch.setattr(detectable_sizes, "_trial", trial)
    row = detectable_sizes.detectable(SimpleNamespace(predicted=lambda name: begins), "stribeck", trials=24)
    assert row.found == pytest.approx(2.0, rel=0.25)
    assert row.ratio == pytest.approx(row.found / begins)
    assert len(row.hits) == 24


def test_every_effect_has_a_predicted_size():
    run = detectable_sizes.Commissioning()
    sizes = {name: run.predicted(name) for name in CATALOGUE_LAWS}
    assert all(0.01 < size < 100.0 for size in sizes.values()), sizes
