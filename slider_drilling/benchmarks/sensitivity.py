"""What a diagnosis makes of each constant that steers the engine, at two other values of it.

    python -m slider_drilling.benchmarks.sensitivity slide [NAME ...]         # the motor-driven slide of docs/examples
    python -m slider_drilling.benchmarks.sensitivity rig SEALED N [NAME ...]  # N logs that `blind-check` sealed

Every row changes one constant and nothing else, on the same logs: those named, or all of them.
"""

from __future__ import annotations

import importlib
import pkgutil
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import slider_drilling.gap
from slider_drilling.blind.check import LABELS, LOGS
from slider_drilling.blind.label import read_labels
from slider_drilling.blind.reported_diagnosis import diagnosis_from_json
from slider_drilling.blind.score import score
from slider_drilling.diagnosis.diagnose import diagnose
from slider_drilling.diagnosis.to_json import to_json
from slider_drilling.log import read_log


@dataclass(frozen=True)
class Constant:
    """module: within `slider_drilling.gap`; values: the other ones to try; means: what it is."""

    module: str
    name: str
    values: tuple[object, ...]
    means: str


DECIDING = (
    Constant("evidence.compare", "LEVEL", (0.02, 0.1), "level of a test between two explanations"),
    Constant("evidence.adequacy", "LEVEL", (0.003, 0.03), "level of the test whether anything is left"),
    Constant("evidence.adequacy", "NEGLIGIBLE", (0.3, 0.8), "E^2 - 1 that nobody would act upon"),
    Constant("evidence.compare", "LEAST_SHARE", (0.02, 0.1), "share of the gap worth a name, and of a floor"),
    Constant("selection.calibration", "NUISANCE_LIMIT", (1.8, 3.5),
             "spreads that rigs are looked for within, laws beyond"),
    Constant("selection.forward_selection", "OBSERVER_GAIN", (0.15, 0.6), "gain of the weak observer"),
    Constant("problem.problem", "STEP_SIZE", (2.0, 8.0), "noise units from which a missed step is priced as one"),
    Constant("problem.problem", "_SAMPLES", (20.0, 80.0), "samples that a discrepancy remembers"),
    Constant("problem.problem", "_STRETCHES", (10, 40), "stretches of a run, one being the longest memory"),
    Constant("problem.noise", "TRIM_FRACTION", (0.7, 0.9), "share of a record that counts, events being in the rest"),
    Constant("problem.noise", "MAX_NOISE_RATIO", (1.4, 3.0), "times the declared noise that is believed"),
    Constant("evidence.score", "FOLDS", (4, 10), "stretches that are held out in turn"),
    Constant("evidence.free_forms", "_KNOTS", (5, 12), "coefficients of a free form over a reading"),
)
HOW_FINELY = (
    Constant("evidence.replicates", "_NUMBER", (5, 16), "replicates"),
    Constant("search.race", "FINALISTS", (2, 5), "explanations that are judged"),
    Constant("search.screen", "STARTS", (1, 4), "places that fits begin from where the first may mislead"),
    Constant("search.least_squares", "MAX_ITERATIONS", (5, 14), "iterations of a fit at most"),
    Constant("search.least_squares", "DIFFERENCE_STEP", (0.1, 0.4), "step of a derivative, in scales"),
    Constant("search.least_squares", "TRUST_FRACTION", (0.15, 0.5), "how far a linear forecast is trusted"),
    Constant("selection.calibration", "_SCATTERED", (16, 64), "points that re-tuning may begin from"),
)
STEERING = (*DECIDING, *HOW_FINELY)


@dataclass(frozen=True)
class SensitivityCounts:
    """cases; named: with everything in them named or in the group of a name; said: a name without its cause;
    simulations: in all.
    """

    cases: int
    named: int
    false_names: int
    simulations: int


@contextmanager
def changed(constant: Constant, value: object) -> Iterator[object]:
    """The constant has another value wherever it is used; gives the one that it has."""
    for found in pkgutil.walk_packages(slider_drilling.gap.__path__, "slider_drilling.gap."):
        importlib.import_module(found.name)
    home = sys.modules[f"slider_drilling.gap.{constant.module}"]
    was = getattr(home, constant.name)
    users = [
        module for name, module in sys.modules.items()
        if name.startswith("slider_drilling.gap") and getattr(module, constant.name, None) is was
    ]  # fmt: skip
    try:
        for module in users:
            setattr(module, constant.name, value)
        yield was
    finally:
        for module in users:
            setattr(module, constant.name, was)


def slides() -> Callable[[], SensitivityCounts]:
    """The motor-driven slide: five effects, hardly to be seen and plain, and two logs without any."""
    sys.path.insert(0, str(Path(__file__).parents[1] / "docs" / "examples"))
    motor_slide = importlib.import_module("motor_slide")
    tuned = {"stiffness": 21500.0, "friction": 27.0, "damping": 220.0}
    truths: list[tuple[str, dict[str, float]]] = [("", {}), ("", {})]
    for size in (1.0, 4.0):
        truths += [
            ("stribeck", {"stribeck_drop": 0.1 * size, "stribeck_speed": 0.04}),
            ("backlash", {"backlash": 1e-4 * size}),
            ("viscous", {"viscous": 150.0 * size}),
            ("force_bias", {"force_bias": 0.15 * size}),
            ("force_lag", {"force_lag": 0.003 * size}),
        ]
    cases = [(name, motor_slide.record(tuned | truth, number)) for number, (name, truth) in enumerate(truths)]

    def run() -> SensitivityCounts:
        answers = [(name, slider_drilling.gap.explain(motor_slide.MotorSlide((log,)))) for name, log in cases]
        named = [
            name and any(name == e or name in one.indistinguishable[e] for e in one.effects) for name, one in answers
        ]
        said = [any(name != e and name not in one.indistinguishable[e] for e in one.effects) for name, one in answers]
        spent = sum(one.simulation_count for _, one in answers)
        return SensitivityCounts(len(cases), sum(map(bool, named)), sum(said), spent)

    return run


def sealed(folder: Path, most: int) -> Callable[[], SensitivityCounts]:
    """Logs of the drill string that somebody sealed: half with one effect, the others with none, two, or another."""
    labels = read_labels(folder / LABELS)
    single = [stem for stem, label in labels.items() if label.kind == "single" and label.size >= 1.0]
    others = [stem for stem, label in labels.items() if label.kind != "single"]
    chosen = [stem for pair in zip(single, others, strict=False) for stem in pair][:most]

    def run() -> SensitivityCounts:
        named, said, spent = 0, 0, 0
        for stem in chosen:
            log = read_log(folder / LOGS / f"{stem}.mcap")
            tree = to_json(diagnose([log], log.rig()))
            scored = score(labels[stem], diagnosis_from_json(tree, stem))
            named += scored.truth_named
            said += scored.extra_names > 0 or scored.outcome in ("false alarm", "false name")
            spent += tree["counts"]["simulations"]
        return SensitivityCounts(len(chosen), named, said, spent)

    return run


def rows(run: Callable[[], SensitivityCounts], asked: Sequence[Constant]) -> Iterator[str]:
    """Lines of a table: everything as it is, then a line a constant as soon as it is there."""
    yield "| what | as it is | changed to: named, names without their cause, simulations | and to |\n|---|---|---|---|"
    yield f"| nothing changed | | {_told(run())} | |"
    for constant in asked:
        cells = []
        for value in constant.values:
            with changed(constant, value) as was:
                cells.append(f"{value}: {_told(run())}")
        yield f"| {constant.means} | {was} | {' | '.join(cells)} |"


def _told(tally: SensitivityCounts) -> str:
    return f"{tally.named} of {tally.cases}, {tally.false_names}, {tally.simulations:,}"


def main(given: Sequence[str]) -> None:
    """Print a table, a row as soon as it is there."""
    if given[:1] == ["slide"]:
        run, names = slides(), given[1:]
    elif given[:1] == ["rig"] and len(given) > 2:
        run, names = sealed(Path(given[1]), int(given[2])), given[3:]
    else:
        sys.exit(__doc__)
    for line in rows(run, [one for one in STEERING if one.name in names or not names]):
        print(line, flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
