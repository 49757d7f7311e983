"""How well a fit knows its parameters, by the likelihood's curvature at it."""

from __future__ import annotations

import numpy as np

from slider_drilling.gap.problem.problem import Problem
from slider_drilling.gap.search.least_squares import Fit, prior_weights

_NORMAL_95 = 1.96


def intervals(problem: Problem, found: Fit) -> dict[str, tuple[float, float]]:
    """95 % of each freed parameter, cut at its bounds."""
    if not found.parameters:
        return {}
    _, rows = problem.whitened(found.residual, found.jacobian, found.discrepancy)
    normal = rows @ rows.T + np.diag(prior_weights(found.parameters) ** 2)
    # What the log says nothing of may lie anywhere within its bounds.
    covariance = np.linalg.pinv(normal + 1e-9 * np.eye(len(normal)))
    spans = {}
    for index, parameter in enumerate(found.parameters):
        half = _NORMAL_95 * parameter.scale * float(np.sqrt(max(covariance[index, index], 0.0)))
        value = found.values[parameter.name]
        spans[parameter.name] = max(value - half, parameter.lower), min(value + half, parameter.upper)
    return spans
