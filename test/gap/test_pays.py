"""An effect has to be worth its own parameters on the whole log."""

from types import SimpleNamespace

import pytest
from scipy.stats import chi2

from slider_drilling.gap.evidence.compare import LEVEL, pays

CANDIDATES = 12


def fitted(cost, parameters):
    return SimpleNamespace(cost=cost, parameters=("nuisance",) * parameters)


@pytest.mark.parametrize("added", [1, 3])
def test_what_free_parameters_gain_on_noise_is_no_reason_for_a_name(added):
    least = chi2.ppf(1.0 - LEVEL / CANDIDATES, added)
    known = fitted(1000.0, 5)
    assert not pays(known, fitted(1000.0 - 0.99 * least, 5 + added), CANDIDATES)
    assert pays(known, fitted(1000.0 - 1.01 * least, 5 + added), CANDIDATES)


def test_more_parameters_have_to_gain_more():
    known = fitted(1000.0, 5)
    assert pays(known, fitted(990.0, 6), CANDIDATES)
    assert not pays(known, fitted(990.0, 8), CANDIDATES)
