"""How the twin's features wander on rigs that do not change: fits the numbers of `slider_drilling.twin.wander`.

    python -m slider_drilling.benchmarks.twin_wander LOG ...

The twin runs over slides in which nothing begins, such as those of `slider-drilling watch --campaign 36 --seed 7003
--begins none --no-diagnose`. Every feature's numbers are those of maximum likelihood, the slides being independent. A
threshold needs slides that the numbers were not fitted to: each half of the slides is tested with the numbers of the
other. The evidence that one feature exceeds once in ten days, all together once a day, is extrapolated from the slides
where it is largest, as an exponential tail.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.linalg import solve_triangular
from scipy.optimize import minimize

from slider_drilling.log import RigLog, read_log
from slider_drilling.twin import Twin, TwinSettings
from slider_drilling.twin.change_statistic import Uncertainty, Wander, covariance, likeliest_change
from slider_drilling.twin.detector import Alarm, ChangeDetector
from slider_drilling.twin.feature_means import FeatureSeries, means_of
from slider_drilling.twin.feed import LogFeed
from slider_drilling.twin.wander import WANDERS, comparisons
from slider_drilling.twin.watch import reports_of

# Number -> lower and upper bound.
_FITTED = {
    "slow": (0.005, 10.0), "memory": (30.0, 3000.0), "drift": (0.005, 5.0),
    "jump": (0.005, 10.0), "fresh": (0.005, 20.0), "weighed": (0.005, 20.0), "steered": (0.002, 5.0),
    "swung": (0.005, 10.0),
}  # fmt: skip
_SPREAD = 2.0  # of the logarithms, about the numbers to begin with: what slides do not show stays near them
_MIN_VALUES = 60
_ALARMS_A_DAY = 0.1  # of one feature
_TAIL = 1.0 / 3.0  # of the slides, whose largest evidence shows its tail
_EVERY = 3  # values after which a slide is tested again

Slide = tuple[FeatureSeries, Uncertainty]


def deviance(slide: Slide, wander: Wander) -> float:
    """``-2 log p`` of a feature of one slide, its size unknown as in the statistic, up to a constant."""
    series, uncertain = slide
    means = means_of(series, wander.values)
    factor = np.linalg.cholesky(covariance(means, uncertain, wander))
    white = solve_triangular(factor, means.value, lower=True)
    freedom = wander.freedom + white.size
    return float(2.0 * np.log(np.diag(factor)).sum() + freedom * np.log1p(white @ white / wander.freedom))


def fit_wander(slides: Sequence[Slide], start: Wander) -> Wander:
    """The likeliest numbers. Threshold, smallest change, what a mean is and has of its own are those of the start."""
    begin = np.log([max(getattr(start, name), low) for name, (low, _) in _FITTED.items()])

    def at(logarithms: np.ndarray) -> Wander:
        return replace(start, **dict(zip(_FITTED, np.exp(logarithms).tolist(), strict=True)))

    def cost(logarithms: np.ndarray) -> float:
        prior = float(np.sum(((logarithms - begin) / _SPREAD) ** 2))
        return prior + sum(deviance(slide, at(logarithms)) for slide in slides)

    bounds = [(np.log(low), np.log(high)) for low, high in _FITTED.values()]
    found = minimize(cost, begin, method="L-BFGS-B", bounds=bounds, options={"maxiter": 20, "eps": 0.02})
    return at(found.x)


class _NeverAlarmed(Twin):
    """A twin that only watches: after an alarm it would forget what was before."""

    def _take_alarms(self, alarms: Iterable[Alarm | None], now: float) -> None:
        pass


def watched(log: RigLog) -> ChangeDetector | None:
    """The twin's detector after a log; None where the twin never learnt its rig."""
    twin = _NeverAlarmed(log.rig(), TwinSettings(forecast=0.0))
    for _ in reports_of(twin, LogFeed(log)):
        pass
    twin.close()
    return twin.detector


def largest_evidence(slide: Slide, wander: Wander) -> float:
    """The largest evidence for a change worth a detection while the values of a slide come in."""
    series, uncertain = slide
    largest = 0.0
    for count in range(_MIN_VALUES, series.time.size + 1, _EVERY):
        change = likeliest_change(series.first(count), uncertain, wander)
        if change is not None and abs(change.size) >= wander.smallest:
            largest = max(largest, change.evidence)
    return largest


def threshold(largest: Sequence[float], hours: float) -> float:
    """Evidence that all slides together exceed so often as `_ALARMS_A_DAY`.

    Args:
        largest: Of each slide.
        hours: Of all slides.
    """
    ordered = np.sort(np.array(largest))[::-1]
    tail = max(round(_TAIL * ordered.size), 2)
    base = float(ordered[tail - 1])
    scale = max(float(np.mean(ordered[: tail - 1] - base)), 1.0)  # of white noise it would be 1
    return base + scale * float(np.log(tail / (_ALARMS_A_DAY * hours / 24.0)))


def main(paths: Sequence[str]) -> None:
    """Print a row of the table for every feature."""
    detectors = [found for path in paths if (found := watched(read_log(Path(path)))) is not None]
    for (channel, kind), wander in WANDERS.items():
        key = (comparisons("rocking", channel, kind)[0], channel, kind)
        slides = [
            (series, each.uncertain) for each in detectors if key in each.watched("rocking")
            and (series := each.series(key)).time.size >= _MIN_VALUES
        ]  # fmt: skip
        fitted = fit_wander(slides, wander)
        hours = sum(float(series.time[-1] - series.time[0]) for series, _ in slides) / 3600.0
        largest: list[float] = []
        for half in range(2):
            others = fit_wander(slides[1 - half :: 2], wander)
            largest += [largest_evidence(slide, others) for slide in slides[half::2]]
        numbers = " ".join(f"{name} {getattr(fitted, name):.2g}" for name in _FITTED)
        highest = " ".join(f"{each:.1f}" for each in sorted(largest)[-4:])
        print(channel, kind, len(slides), "slides", f"{hours:.1f} h", numbers, flush=True)
        print(f"    threshold {threshold(largest, hours):.1f}, largest {highest}", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
