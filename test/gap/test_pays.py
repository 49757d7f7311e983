"""An effect has to be worth its own parameters on the whole log."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import chi2

from slider_drilling.gap.evidence.compare import LEVEL, fit_exceeds_evidence_threshold, passes_likelihood_ratio_test

CANDIDATES = 12


def fitted(cost, parameters):
    return SimpleNamespace(cost=cost, parameters=("nuisance",) * parameters)


@pytest.mark.parametrize("added", [1, 3])
def test_what_free_parameters_gain_on_noise_is_no_reason_for_a_name(added):
    least = chi2.ppf(1.0 - LEVEL / CANDIDATES, added)
    known = fitted(1000.0, 5)
    assert not passes_likelihood_ratio_test(known, fitted(1000.0 - 0.99 * least, 5 + added), CANDIDATES)
    assert passes_likelihood_ratio_test(known, fitted(1000.0 - 1.01 * least, 5 + added), CANDIDATES)


def test_more_parameters_have_to_gain_more():
    known = fitted(1000.0, 5)
    assert passes_likelihood_ratio_test(known, fitted(990.0, 6), CANDIDATES)
    assert not passes_likelihood_ratio_test(known, fitted(990.0, 8), CANDIDATES)


@pytest.mark.parametrize("added", [1, 3])
def test_beyond_doubt_is_what_a_ratio_would_be_foretold_to_be(added):
    """Twice the logarithm of candidates over level, and two of `-2 log p` for each parameter that was fitted to it."""
    least = 2.0 * np.log(CANDIDATES / LEVEL) + 2.0 * added
    known = fitted(1000.0, 5)
    assert not fit_exceeds_evidence_threshold(fitted(1000.01 - least, 5 + added), known, CANDIDATES)
    assert fit_exceeds_evidence_threshold(fitted(999.99 - least, 5 + added), known, CANDIDATES)
