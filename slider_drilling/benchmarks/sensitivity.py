"""Sensitivity of the diagnosis to the engine's constants, each at two other values.

    python -m slider_drilling.benchmarks.sensitivity slide [NAME ...]         # the motor-driven slide of docs/examples
    python -m slider_drilling.benchmarks.sensitivity rig SEALED N [NAME ...]  # N logs that `blind-check` sealed

Each row changes one constant, on the same logs. Without NAME all constants are varied.
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
    """A constant of the engine.

    Attributes:
        module: Module within `slider_drilling.gap`.
        name: Name in that module.
        values: Other values to try.
        meaning: Its row in the table.
    """

    module: str
    name: str
    values: tuple[object, ...]
    meaning: str


DECIDING = (
    Constant("evidence.compare", "NAMING_LEVEL", (0.02, 0.1), "level of a test between two candidates"),
    Constant("evidence.adequacy", "ADEQUACY_LEVEL", (0.003, 0.03), "level of the adequacy test"),
    Constant("evidence.adequacy", "NEGLIGIBLE", (0.3, 0.8), "negligible E^2 - 1"),
    Constant("selection.evidence_tests", "MIN_GAP_CLOSED", (0.02, 0.1), "smallest relevant share of the gap"),
    Constant("selection.candidates", "MIN_FLOOR_CHANGE", (0.02, 0.1), "smallest relevant change of a noise floor"),
    Constant("search.multi_start", "NUISANCE_LIMIT", (1.8, 3.5), "prior spreads within which calibration stays"),
    Constant("selection.calibration", "OBSERVER_GAIN", (0.15, 0.6), "gain of the weak observer"),
    Constant("problem.problem", "STEP_SIZE", (2.0, 8.0), "noise units above which a missed step counts once"),
    Constant("problem.problem", "_SAMPLES", (20.0, 80.0), "memory of the discrepancy, samples"),
    Constant("problem.problem", "_STRETCHES", (10, 40), "stretches of a run; one is the longest memory"),
    Constant("problem.noise", "TRIM_FRACTION", (0.7, 0.9), "share of a record used for the noise floor"),
    Constant("problem.noise", "MAX_NOISE_RATIO", (1.4, 3.0), "accepted multiple of the declared noise"),
    Constant("evidence.score", "FOLDS", (4, 10), "cross-validation folds"),
    Constant("evidence.sensor_forms", "_KNOTS", (5, 12), "coefficients of a free-form curve"),
)
EFFORT = (
    Constant("evidence.replicates", "_NUMBER", (5, 16), "replicates"),
    Constant("search.race", "FINALISTS", (2, 5), "candidates that are refitted"),
    Constant("search.screen", "STARTS", (1, 4), "start points of a fit"),
    Constant("search.least_squares", "MAX_ITERATIONS", (5, 14), "largest number of iterations of a fit"),
    Constant("search.least_squares", "DIFFERENCE_STEP", (0.1, 0.4), "step of a finite difference, in scales"),
    Constant("search.least_squares", "TRUST_FRACTION", (0.15, 0.5), "trust region of a linear prediction"),
    Constant("search.multi_start", "_SCATTERED", (16, 64), "start points of calibration"),
)
CONSTANTS = (*DECIDING, *EFFORT)


@dataclass(frozen=True)
class SensitivityCounts:
    """Counts over a set of logs.

    Attributes:
        cases: Logs.
        named: Logs whose effects are all named or in the group of a name.
        false_names: Logs with a name that has no cause in them.
        simulations: Simulations in total.
    """

    cases: int
    named: int
    false_names: int
    simulations: int


@contextmanager
def constant_set_to(constant: Constant, value: object) -> Iterator[object]:
    """Set the constant in every module that imports it; yields its usual value and restores it."""
    for module_info in pkgutil.walk_packages(slider_drilling.gap.__path__, "slider_drilling.gap."):
        importlib.import_module(module_info.name)
    home = sys.modules[f"slider_drilling.gap.{constant.module}"]
    usual = getattr(home, constant.name)
    users = [
        module for name, module in sys.modules.items()
        if name.startswith("slider_drilling.gap") and getattr(module, constant.name, None) is usual
    ]  # fmt: skip
    try:
        for module in users:
            setattr(module, constant.name, value)
        yield usual
    finally:
        for module in users:
            setattr(module, constant.name, usual)


def motor_slides() -> Callable[[], SensitivityCounts]:
    """A function that diagnoses twelve motor-driven slides: five effects, small and large, and two without any."""
    sys.path.insert(0, str(Path(__file__).parents[2] / "docs" / "examples"))
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
        named, false_names, simulations = 0, 0, 0
        for truth, log in cases:
            answer = slider_drilling.gap.explain(motor_slide.MotorSlide((log,)))
            matches = [truth in (effect, *answer.indistinguishable[effect]) for effect in answer.effects]
            named += any(matches)
            false_names += not all(matches)
            simulations += answer.simulation_count
        return SensitivityCounts(len(cases), named, false_names, simulations)

    return run


def sealed_logs(folder: Path, most: int) -> Callable[[], SensitivityCounts]:
    """A function that diagnoses up to ``most`` sealed logs: half with one effect, half of other kinds."""
    labels = read_labels(folder / LABELS)
    single = [stem for stem, label in labels.items() if label.kind == "single" and label.size >= 1.0]
    others = [stem for stem, label in labels.items() if label.kind != "single"]
    chosen = [stem for pair in zip(single, others, strict=False) for stem in pair][:most]

    def run() -> SensitivityCounts:
        named, false_names, simulations = 0, 0, 0
        for stem in chosen:
            log = read_log(folder / LOGS / f"{stem}.mcap")
            tree = to_json(diagnose([log], log.rig()))
            scored = score(labels[stem], diagnosis_from_json(tree, stem))
            named += scored.truth_named
            false_names += scored.extra_names > 0 or scored.outcome in ("false alarm", "false name")
            simulations += tree["counts"]["simulations"]
        return SensitivityCounts(len(chosen), named, false_names, simulations)

    return run


def table_rows(run: Callable[[], SensitivityCounts], constants: Sequence[Constant]) -> Iterator[str]:
    """Lines of a markdown table: the usual constants, then one line per constant when it is done."""
    yield "| constant | value | lower: named, false names, simulations | higher |\n|---|---|---|---|"
    yield f"| nothing changed | | {_cell(run())} | |"
    for constant in constants:
        cells = []
        for value in constant.values:
            with constant_set_to(constant, value) as usual:
                cells.append(f"{value}: {_cell(run())}")
        yield f"| {constant.meaning} | {usual} | {' | '.join(cells)} |"


def _cell(counts: SensitivityCounts) -> str:
    return f"{counts.named} of {counts.cases}, {counts.false_names}, {counts.simulations:,}"


def main(arguments: Sequence[str]) -> None:
    """Print the table row by row."""
    if arguments[:1] == ["slide"]:
        run, names = motor_slides(), arguments[1:]
    elif arguments[:1] == ["rig"] and len(arguments) > 2:
        run, names = sealed_logs(Path(arguments[1]), int(arguments[2])), arguments[3:]
    else:
        sys.exit(__doc__)
    for line in table_rows(run, [constant for constant in CONSTANTS if constant.name in names or not names]):
        print(line, flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
