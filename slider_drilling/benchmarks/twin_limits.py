"""How soon any detector can see what begins in sealed slides: one that knows what begins, and when.

    python -m slider_drilling.benchmarks.twin_limits FOLDER ...

The folders are outputs of `slider-drilling watch --campaign N`. The twin runs over each slide, so that its features and
what it compares are given. What the change adds to every feature is simulated. A detector that knows it has only one
question: with or without? Its evidence, half the square of what is added in standard deviations of how the features
wander without a change, is added up over all features. It counts as seen from a likelihood ratio of 3,000 on.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from slider_drilling.benchmarks.twin_wander import watched
from slider_drilling.blind.slides.case import SlideCase
from slider_drilling.blind.slides.label import SlideLabel, read_slide_label
from slider_drilling.blind.slides.make import draw_slide
from slider_drilling.blind.slides.size import added_over_time
from slider_drilling.drillstring import Commands
from slider_drilling.files.installed_files import installed_file
from slider_drilling.log import RigLog, read_log
from slider_drilling.log_inputs.commands_from_log import commands_from_log
from slider_drilling.rig import Rig, load_rig
from slider_drilling.twin.activity import OFF_BOTTOM
from slider_drilling.twin.change_statistic import Uncertainty, covariance
from slider_drilling.twin.detector import Key
from slider_drilling.twin.feature_means import FeatureSeries, means_of
from slider_drilling.twin.features import FEATURES, shapes_of
from slider_drilling.twin.samples import Array
from slider_drilling.twin.settings import TwinSettings
from slider_drilling.twin.wander import wander_of

_SEEN = math.log(3000.0)
_EVERY_S = 10.0
_LEAST_SAMPLES, _LEAST_MEANS = 20, 3

Added = tuple[Array, Array]
"""What a change adds to a channel, noise levels, and the channel without it."""


def seen_after(log: RigLog, label: SlideLabel, base: Rig) -> float | None:
    """s after 1.5 noise levels at which a detector that knows the change sees it; None if it does not.

    Args:
        log: Of the slide.
        label: What begins in it.
        base: Rig that the slide was drawn from.
    """
    detector = watched(log)
    if detector is None or label.onset is None:
        return None
    case = SlideCase(label.case, label.onset, label.growth, label.well, label.seed, label.duration)
    drawn = draw_slide(case, base)
    if drawn.beginning is None:
        return None
    commands = commands_from_log(log, drawn.rig).commands
    added = added_over_time(drawn.rig, drawn.perturbation.nuisance, drawn.beginning, case, commands)
    times = np.arange(label.onset, label.duration, _EVERY_S)
    evidence = np.zeros(times.size)
    for key in {key for mode in ("rocking", OFF_BOTTOM) for key in detector.watched(mode)}:
        series = detector.series(key)
        shown = _shown(series, key, commands, added, case)
        evidence += [_evidence(series, shown, key, detector.uncertain, float(now)) for now in times]
    seen = np.flatnonzero(evidence >= _SEEN)
    return float(times[seen[0]] - (label.reached or label.onset)) if seen.size else None


def _shown(
    series: FeatureSeries, key: Key, commands: Commands, added: Mapping[str, Added], case: SlideCase
) -> Array:  # fmt: skip
    """(n,) what the change adds to every value of a feature."""
    full, level = added[key[1]]
    change = full * case.shares_at(commands.time)
    shown = np.zeros(series.time.size)
    for index, (end, window) in enumerate(zip(series.time - TwinSettings().patience, series.window, strict=True)):
        inside = (commands.time > end - window) & (commands.time <= end)
        if inside.sum() < _LEAST_SAMPLES:
            continue
        shapes = shapes_of(level[inside])
        parts = np.linalg.pinv(shapes) @ change[inside]
        if key[2] == "spread":
            rest = float(np.mean((change[inside] - shapes @ parts) ** 2))
            before = max(math.exp(2.0 * series.value[index]) - rest, 0.5)  # noise at least
            shown[index] = 0.5 * math.log1p(rest / before)
        else:
            shown[index] = parts[FEATURES.index(key[2])]
    return shown


def _evidence(series: FeatureSeries, shown: Array, key: Key, uncertain: Uncertainty, now: float) -> float:
    """Evidence of one feature for the change by what has come until now, s."""
    wander, known = wander_of(*key), int(np.searchsorted(series.time, now, side="right"))
    if wander is None or not known:
        return 0.0
    means = means_of(series.first(known), wander.values)
    if means.time.size < _LEAST_MEANS:
        return 0.0
    mean = means.average(shown[:known, None])[:, 0]
    return 0.5 * float(mean @ np.linalg.solve(covariance(means, uncertain, wander), mean))


def main(folders: Sequence[str]) -> None:
    """Print a line for every slide in which something begins, then how many are seen."""
    base, after = load_rig(Path(installed_file("config/rig.example.yaml"))), []
    for path in sorted(each for folder in folders for each in Path(folder, "labels").glob("*.json")):
        label = read_slide_label(path)
        if label.reached is None:
            continue
        seen = seen_after(read_log(path.parent.parent / "logs" / label.log), label, base)
        after.append(seen)
        print(label.log, label.case, "not seen" if seen is None else f"seen after {max(seen, 0.0):.0f} s", flush=True)
    seconds = sorted(max(seen, 0.0) for seen in after if seen is not None)
    if seconds:
        print(f"{len(seconds)} of {len(after)} seen, half of them within {float(np.median(seconds)):.0f} s")


if __name__ == "__main__":
    main(sys.argv[1:])
