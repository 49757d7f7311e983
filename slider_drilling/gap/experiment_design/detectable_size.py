"""The smallest size of an effect that a run will show, by the diagnosis's own criteria."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from math import inf, log, sqrt

import numpy as np
from scipy.optimize import brentq
from scipy.stats import ncx2, norm

from slider_drilling.gap.evidence.compare import chi2_critical, evidence_threshold
from slider_drilling.gap.experiment_design.information import Change, Information
from slider_drilling.gap.model import Array, Effect, HasUserParameters, Model, Values
from slider_drilling.gap.selection.evidence_tests import MIN_GAP

POWER = 0.9
"""Probability with which an effect of the detectable size is named."""


@dataclass(frozen=True)
class ProbedShape:
    """One shape of an effect at several amplitudes.

    Attributes:
        effect: The effect.
        points: Scan points of this shape, by growing distance from neutral.
    """

    effect: Effect
    points: tuple[tuple[float, ...], ...]

    def reference(self, material: float) -> float:
        """Amplitude, from neutral, of its smallest scan point that an engineer would act on; else of its largest.

        Args:
            material: Smallest amplitude that an engineer acts on.
        """
        distances = [self.distance(point) for point in self.points]
        return next((distance for distance in distances if distance >= material), distances[-1])

    def distance(self, point: Sequence[float]) -> float:
        """How far an amplitude is from neutral."""
        return abs(point[0] - self.effect.parameters[0].nominal)

    def name(self, point: Sequence[float]) -> str:
        """Name of a point's change."""
        return f"{self.effect.name} {tuple(point)}"

    def changes(self, values: Values) -> list[Change]:
        """The changes to simulate, on top of these values."""
        return [
            Change(self.name(point), {**values, **self.effect.values(point)}, self.effect.fidelity)
            for point in self.points
        ]  # fmt: skip


@dataclass(frozen=True)
class DetectableSize:
    """The smallest size of one shape of an effect that a run shows.

    Attributes:
        amplitude: Distance from neutral that is named with `POWER`.
        limited_by: ``evidence``, ``size of the gap``, or ``material``: the criterion that needs the most.
        reference: A usual amplitude (`ProbedShape.reference`).
        power: Probability that the reference is named.
        noncentrality: Of the reference: expected ``-2 log p`` that it explains and nothing else can.
    """

    amplitude: float
    limited_by: str
    reference: float
    power: float
    noncentrality: float


def probed_shapes(effect: Effect, most_shapes: int | None = None, most_points: int | None = None) -> list[ProbedShape]:
    """The shapes of an effect's scan.

    Args:
        effect: The effect. A sign of its amplitude that the scan has both ways counts once.
        most_shapes: Keep so many shapes, evenly chosen; all by default.
        most_points: Keep the smallest so many amplitudes of each; all by default.
    """
    by_shape: dict[tuple[float, ...], list[tuple[float, ...]]] = {}
    low, high = effect.physical
    for point in effect.scan:
        if low <= point[0] <= high:
            by_shape.setdefault(point[1:], []).append(point)
    neutral = effect.parameters[0].nominal
    shapes = []
    for points in by_shape.values():
        distances: dict[float, tuple[float, ...]] = {}
        for point in points:
            distances.setdefault(round(abs(point[0] - neutral), 12), point)
        ordered = [distances[distance] for distance in sorted(distances)]
        shapes.append(ProbedShape(effect, tuple(ordered[:most_points])))
    if most_shapes is None or len(shapes) <= most_shapes:
        return shapes
    chosen = np.unique(((np.arange(most_shapes) + 0.5) / most_shapes * len(shapes)).astype(int))
    return [shapes[index] for index in chosen]


def evidence_needed(parameters: int, candidates: int) -> float:
    """Gain of ``-2 log p`` that a name needs: Wilks at the shared level, and evidence beyond noise.

    Args:
        parameters: Free parameters of the effect.
        candidates: Number of candidates that share the level.
    """
    return max(chi2_critical(parameters, candidates), evidence_threshold(candidates) + 2.0 * parameters)


@lru_cache(maxsize=256)
def noncentrality_needed(parameters: int, candidates: int, power: float = POWER) -> float:
    """Noncentrality with which the likelihood ratio exceeds what a name needs with a probability."""
    threshold = evidence_needed(parameters, candidates)

    def short(root: float) -> float:
        return float(ncx2.sf(threshold, parameters, max(root * root, 1e-12))) - power

    return float(brentq(short, 0.0, sqrt(threshold) + 10.0)) ** 2


def detectable_size(
    shape: ProbedShape, noncentralities: Array, powers: Mapping[str, Array], information: Information,
    candidates: int, material: float,
) -> DetectableSize:  # fmt: skip
    """The smallest amplitude of a shape that passes.

    Args:
        shape: The shape, of p points.
        noncentralities: (p,) of its points.
        powers: By channel, (p,) sum of the squared noise units that its points leave.
        information: Of the runs, for samples and model error of each channel.
        candidates: Number of candidates that share the level.
        material: Smallest amplitude that an engineer acts on; 0 if any.
    """
    count = len(shape.effect.parameters)
    distances = np.array([shape.distance(point) for point in shape.points])
    reference = shape.reference(material)
    evidence = evident_amplitude(shape, noncentralities, candidates)
    gap, gap_power = inf, 0.0
    for name, channel in information.channels.items():
        if channel.samples:
            chance = 3.0 * sqrt(2.0 / channel.samples)
            least = max(MIN_GAP, channel.model_error / channel.samples, chance)
            squares = powers[name] / channel.samples
            gap = min(gap, _amplitude_at(distances, squares, _expected_gap(least, channel.samples)))
            expected = float(np.exp(_log_at(distances, squares, reference)))
            gap_power = max(gap_power, float(norm.sf((least - expected) / _gap_deviation(expected, channel.samples))))
    limits = {"evidence": evidence, "size of the gap": gap, "material": material}
    limit = max(limits, key=lambda name: limits[name])
    noncentrality = float(np.exp(_log_at(distances, noncentralities, reference)))
    power = float(ncx2.sf(evidence_needed(count, candidates), count, noncentrality))
    # Whether evidence suffices and whether the gap is large enough depend on the same noise: the rarer of both counts.
    power = min(power, gap_power) if reference >= material else 0.0
    return DetectableSize(limits[limit], limit, reference, power, noncentrality)


def evident_amplitude(shape: ProbedShape, noncentralities: Array, candidates: int, power: float = POWER) -> float:
    """The smallest amplitude, from neutral, whose evidence suffices with a probability.

    Args:
        shape: The shape, of p points.
        noncentralities: (p,) of its points.
        candidates: Number of candidates that share the level.
        power: The probability.
    """
    distances = np.array([shape.distance(point) for point in shape.points])
    return _amplitude_at(
        distances, noncentralities, noncentrality_needed(len(shape.effect.parameters), candidates, power)
    )


def _expected_gap(least: float, samples: int) -> float:
    """Expected E^2 - 1 of so many samples that exceeds the least one with `POWER`, by the spread of a chi-squared."""
    z, expected = float(norm.ppf(POWER)), least
    for _ in range(20):
        expected = least + z * _gap_deviation(expected, samples)
    return expected


def _gap_deviation(expected: float, samples: int) -> float:
    """Standard deviation of E^2 - 1 of so many samples: of a noncentral chi-squared."""
    return sqrt((2.0 + 4.0 * expected) / samples)


def material_amplitude(model: Model, shape: ProbedShape, neutral: Values) -> float:
    """Smallest distance from neutral at which an engineer would act; 0 if any.

    Args:
        model: The model.
        shape: The shape.
        neutral: The values that the effect is added to.
    """
    effect = shape.effect
    if not effect.material:
        return 0.0
    amplitude, point = effect.parameters[0], shape.points[0]
    sign = 1.0 if point[0] >= amplitude.nominal else -1.0

    def user(values: Values) -> Values:
        return model.to_user(values) if isinstance(model, HasUserParameters) else values

    without = user({**neutral, **effect.values((amplitude.nominal, *point[1:]))})

    def matters(distance: float) -> bool:
        values = {**neutral, **effect.values((amplitude.nominal + sign * distance, *point[1:]))}
        return effect.is_material(without, user(values))

    low, high = 0.0, (amplitude.upper if sign > 0.0 else amplitude.lower) - amplitude.nominal
    high = abs(high)
    if not matters(high):
        return inf
    for _ in range(40):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if matters(middle) else (middle, high)
    return high


def _log_at(distances: Array, squares: Array, amplitude: float) -> float:
    """Logarithm, at an amplitude, of something that grows as its square outside its points."""
    x, y = np.log(distances), np.log(np.maximum(squares, 1e-30))
    at = log(amplitude)
    if at <= x[0]:
        return float(y[0] + 2.0 * (at - x[0]))
    if at >= x[-1]:
        return float(y[-1] + 2.0 * (at - x[-1]))
    return float(np.interp(at, x, y))


def _amplitude_at(distances: Array, squares: Array, needed: float) -> float:
    """The amplitude at which something that grows as its square reaches what is needed.

    Between points the logarithms are joined linearly; outside them it grows as the square.
    """
    x, y = np.log(distances), np.log(np.maximum(squares, 1e-30))
    y = np.maximum.accumulate(y)
    goal = log(needed)
    if goal <= y[0]:
        return float(np.exp(x[0] + 0.5 * (goal - y[0])))
    above = np.flatnonzero(y >= goal)
    if not above.size:
        beyond = float(x[-1] + 0.5 * (goal - y[-1]))
        return float(np.exp(beyond)) if beyond < 300.0 else inf
    after = int(above[0])
    share = (goal - y[after - 1]) / (y[after] - y[after - 1])
    return float(np.exp(x[after - 1] + share * (x[after] - x[after - 1])))
